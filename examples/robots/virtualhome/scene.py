"""A scene of VirtualHome with one character, simulated by the evolving graph of the `virtualhome` wheel."""

import copy
import re

from simulator import (Action, EnvironmentGraph, EnvironmentState, Property, Relation, Script, ScriptExecutor, ScriptParseException,
                       parse_script_line)

# The verbs of the Unity simulator that have another name in the evolving graph.
VERBS = {"walktowards": "walk", "put": "putback"}
LINE = re.compile(r"<char(\d+)>\s*\[(\w+)\](.*)")


class Refused(Exception):
    """A request or a line that the simulator does not carry out; the text is its reason."""


class Scene:
    def __init__(self, graph):
        self.first = {"nodes": graph["nodes"], "edges": graph["edges"]}
        self.held = graph.get("held", [])
        self.reset()

    def reset(self):
        """Puts everything back, without a character."""
        self.use(copy.deepcopy(self.first))
        self.performed = []
        self.character = next((node["id"] for node in self.first["nodes"] if node["class_name"] == "character"), None)

    def use(self, graph, grabbed=None):
        self.state = EnvironmentState(EnvironmentGraph(graph), {}, instance_selection=True)
        # What was grabbed remembers where it stood: the simulator refuses to grab it again before it is put down.
        for item, place, relation in grabbed or []:
            place = None if place is None else self.state.get_node(place)
            self.state.executor_data[(Action.GRAB, item)] = (place, relation)

    def graph(self):
        graph = self.state.to_dict()
        graph["nodes"].sort(key=lambda node: node["id"])
        for node in graph["nodes"]:
            # They come out of sets.
            node["properties"].sort()
            node["states"].sort()
        graph["edges"].sort(key=lambda edge: (edge["from_id"], edge["relation_type"], edge["to_id"]))
        return graph

    def saved(self):
        """Returns everything that a later process needs to continue in this scene."""
        grabbed = [(item, place and place.id, relation and relation.name)
                   for (_, item), (place, relation) in self.state.executor_data.items()]
        return {"graph": self.graph(), "character": self.character, "grabbed": grabbed, "performed": self.performed}

    def restore(self, saved):
        grabbed = [(item, place, relation and Relation[relation]) for item, place, relation in saved["grabbed"]]
        self.use(saved["graph"], grabbed)
        self.character, self.performed = saved["character"], saved["performed"]

    def add_character(self, room):
        """Adds the character in a room, or in the first one."""
        if self.character is not None:
            raise Refused("this scene has a character already")
        graph = self.graph()
        rooms = [node for node in graph["nodes"] if node["category"] == "Rooms"]
        found = [node for node in rooms if not room or node["class_name"] == room]
        if not found:
            raise Refused(f"there is no room `{room}`; there are {', '.join(node['class_name'] for node in rooms)}")
        taken = {node["id"] for node in graph["nodes"]}
        self.character = next(number for number in range(1, len(taken) + 2) if number not in taken)
        graph["nodes"].append({"id": self.character, "class_name": "character", "category": "Characters", "properties": [],
                               "states": [], "prefab_name": None, "bounding_box": None})
        graph["edges"].append({"from_id": self.character, "relation_type": "INSIDE", "to_id": found[0]["id"]})
        graph["edges"] += [{"from_id": self.character, "relation_type": relation, "to_id": item}
                           for item, relation in zip(self.held, ("HOLDS_RH", "HOLDS_LH"))]
        self.use(graph)

    def perform(self, line, check_only=False):
        """Performs one line: `<char0> [grab] <pie> (320)`."""
        if self.character is None:
            raise Refused("there is no character; add one")
        match = LINE.fullmatch(line.strip())
        if match is None:
            raise Refused(f"this is no line of a script: {line[:200]}")
        if match.group(1) != "0":
            raise Refused(f"there is no character {match.group(1)}")
        verb = match.group(2).lower()
        try:
            step = parse_script_line(f"[{VERBS.get(verb, verb)}]{match.group(3)}", 0)
        except (ScriptParseException, ValueError) as error:
            raise Refused(str(error)) from error
        self.check_properties(step)
        executor = ScriptExecutor(self.state._graph, {}, 0)
        if check_only:
            done = executor.check_one_step(Script([step]), self.state)
        else:
            done, self.state = executor.execute_one_step(Script([step]), self.state)
        if not done:
            raise Refused(executor.info.get_error_string() or f"{line} cannot be done here")
        if not check_only:
            self.performed.append(line)

    def check_properties(self, step):
        """Refuses objects without the property that the wheel's table of actions requires. The Unity simulator does that;
        the evolving graph forgets it for `putin`."""
        for parameter, alternatives in zip(step.parameters, step.action.value[2:][0] if len(step.action.value) > 2 else []):
            node = self.state.get_node(parameter.instance)
            if node is None:
                raise Refused(f"there is no {parameter.name} ({parameter.instance})")
            if node.class_name != parameter.name:
                raise Refused(f"number {parameter.instance} is a {node.class_name}, not a {parameter.name}")
            known = [Property[name] for name in alternatives if name in Property.__members__]
            if known and not any(one in node.properties for one in known):
                names = " or ".join(one.name for one in known)
                raise Refused(f"{step.action.value[0]} is not possible with {node}: it is not {names}")
