"""Scene graphs of VirtualHome, made from the environment files of the `virtualhome` domain."""

import re

ROOMS = {"kitchen", "bathroom", "bedroom", "livingroom", "living_room", "diningroom", "dining_room", "hall", "hallway", "office",
         "home_office", "study", "garage"}
# Assets that stand together although neither is on or in the other.
PARTS = [({"faucet", "tap"}, {"sink", "bathtub", "basin", "washbasin"})]


def from_environment(environment):
    """Returns the graph that an environment file describes: {"nodes": [...], "edges": [...]}."""
    environment = environment.get("environment", environment)
    nodes, edges = {}, []

    def add_edge(origin, relation, target):
        edge = {"from_id": origin, "relation_type": relation, "to_id": target}
        if edge not in edges:
            edges.append(edge)

    for kind in ("asset", "object"):
        for name in environment.get(f"{kind}s", []):
            node = node_of(name, kind == "object", texts(environment.get(f"{kind}_properties", {}).get(name)))
            if nodes.setdefault(node["id"], node) is not node:
                raise ValueError(f"{name}: two entities have the number {node['id']}")
    held = []
    for kind in ("asset", "object"):
        for name, states in environment.get(f"{kind}_states", {}).items():
            node = nodes[number(name)]
            for text in texts(states):
                word, _, argument = text.rstrip(")").partition("(")
                if word in ("ON", "INSIDE"):
                    add_edge(node["id"], word, number(argument))
                elif word == "SWITCHED_ON":
                    node["states"] = [state for state in node["states"] if state != "OFF"] + ["ON"]
                elif word in ("OPEN", "CLOSED"):
                    node["states"] = [state for state in node["states"] if state not in ("OPEN", "CLOSED")] + [word]
                elif word == "HELD":
                    held.append(node["id"])
                else:
                    raise ValueError(f"{name}: no scene has `{text}`")
    for edge in list(edges):
        if nodes[edge["to_id"]]["category"] != "Rooms":
            add_edge(edge["from_id"], "CLOSE", edge["to_id"])
            add_edge(edge["to_id"], "CLOSE", edge["from_id"])
    for node in nodes.values():
        room = room_of(node["id"], nodes, edges)
        if room is not None and room != node["id"]:
            add_edge(node["id"], "INSIDE", room)
    for left, right in PARTS:
        for one in (node for node in nodes.values() if node["class_name"] in left):
            for other in (node for node in nodes.values() if node["class_name"] in right):
                if room_of(one["id"], nodes, edges) == room_of(other["id"], nodes, edges):
                    add_edge(one["id"], "CLOSE", other["id"])
                    add_edge(other["id"], "CLOSE", one["id"])
    return {"nodes": list(nodes.values()), "edges": edges, "held": held}


def texts(value):
    return [value] if isinstance(value, str) else list(value or [])


def number(name):
    """Returns the number of `<fridge_306>`."""
    match = re.fullmatch(r"<?[^<>]*_(\d+)>?", name)
    if match is None:
        raise ValueError(f"{name}: the name of an entity of VirtualHome ends with its number, as <fridge_306>")
    return int(match.group(1))


def node_of(name, grabbable, words):
    class_name = name.strip("<>").rpartition("_")[0]
    properties = ["GRABBABLE"] if grabbable else []
    states = []
    if "IS_OPENABLE" in words:
        properties.append("CAN_OPEN")
        states.append("CLOSED")
    if "HAS_SWITCH" in words:
        properties.append("HAS_SWITCH")
        states.append("OFF")
    properties += ["RECIPIENT"] if "RECIPIENT" in words else []
    properties += ["SURFACES"] if "SURFACE" in words else []
    category = "Rooms" if class_name in ROOMS else ("placable_objects" if grabbable else "Furniture")
    return {"id": number(name), "class_name": class_name, "category": category, "properties": properties, "states": states,
            "prefab_name": None, "bounding_box": None}


def room_of(number, nodes, edges):
    """Returns the room that an entity is in, through whatever it is on or in; None if there is none."""
    seen, todo = set(), [number]
    while todo:
        here = todo.pop(0)
        if nodes[here]["category"] == "Rooms":
            return here
        seen.add(here)
        of = [edge["to_id"] for edge in edges if edge["from_id"] == here and edge["relation_type"] in ("INSIDE", "ON")]
        # What it is in comes first: a drawer may be listed as on something in another room.
        direct = [target for target in of if nodes[target]["category"] == "Rooms"]
        todo += [target for target in direct + of if target not in seen]
    return None
