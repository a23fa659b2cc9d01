"""Environments of the shipped domains, and goals over them."""

from genes import choice, size

# Genes of an environment.
ENVIRONMENT = {
    "assets": size(1, 500),
    "objects": size(1, 500),
    "names": choice(8),
    "placing": choice(8),
    "states": size(1, 300),
    "properties": choice(4),
    "said": choice(3),
}

HELD = {"household": "inside_hand()", "household-checks": "inside_hand()", "household-dual": "inside_hand(left)", "virtualhome": "HELD()"}
# Sets that do not contradict themselves.
PROPERTIES = (("ROTATES", "CONTAINER"), ("SLIDES", "BASE"), ("CONTAINER", "BIN"))
VIRTUAL_PROPERTIES = (("IS_OPENABLE",), ("IS_OPENABLE", "HAS_SWITCH"), ("HAS_SWITCH",))
HEADS = ("fridge", "drawer", "window", "box", "plate", "bin", "table", "shelf")
OUTCOMES = ("fresh", "expired", "empty", "half_full", "full", "intact", "broken", "clean", "dirty")


def names_of(style, count, rng):
    """Identifiers: short ones, ones that share words, ones that continue each other, long ones."""
    made = []
    for index in range(count):
        head = HEADS[index % len(HEADS)]
        made.append(
            (
                f"p{index}",
                f"box_{index}",
                f"{head}_{index}" if index % 2 else f"{head}_{index - 1}_handle" if index else head,
                f"{'very_' * (index % 40)}old_box",
                f"{'red_' * (index % 5)}{'big_' * (index // 5 % 5)}box_{index}",
                f"{head}_{'x' * 40}{index}",
                f"box_{index}_door",
                f"{'_'.join(HEADS[(index >> bit) & 7] for bit in range(0, 9, 3))}_{index}",
            )[style]
        )
    return [f"<{name}>" for name in dict.fromkeys(made)]


def environment(genes, rng, domain):
    """An environment of a shipped domain."""
    upper = domain == "virtualhome"
    names = names_of(genes["names"], genes["assets"] + genes["objects"], rng)
    assets = names[: max(1, genes["assets"])]
    objects = names[len(assets) :] or ["<cup>"]
    on, inside = ("ON", "INSIDE") if upper else ("on_something", "inside_something")
    states, everything = {}, assets + objects
    for index, name in enumerate(objects):
        kind, said = genes["placing"], []
        if kind == 0:
            said = [f"{on}({assets[0]})"]
        elif kind == 1:
            said = [f"{on}({rng.choice(assets)})"]
        elif kind == 2:
            # A tower: each object on the one before.
            said = [f"{on}({objects[index - 1] if index else assets[0]})"]
        elif kind == 3:
            said = [f"{inside}({rng.choice(assets)})"]
        elif kind == 4:
            said = [f"{inside}({objects[index - 1] if index else assets[0]})"]
        elif kind == 5:
            said = [] if upper else [f"next_to({other})" for other in rng.sample(everything, min(genes["states"], len(everything)))]
        elif kind == 6 and index == 0:
            said = [f"{on}({place})" for place in assets[: genes["states"] * 2]]
        elif kind == 7:
            said = [f"{on}({rng.choice(assets)})"] if index else [HELD[domain]]
        if "_handle" in name or "_door" in name:
            said = ["CLOSED()" if upper else "closed()"]
        elif genes["said"] == 1 and domain == "household-checks":
            said.append(f"{OUTCOMES[index % len(OUTCOMES)]}()")
        if said:
            states[name] = said[0] if len(said) == 1 else said
    made = {"assets": assets, "asset_states": {}, "objects": objects, "object_states": states}
    if genes["properties"]:
        words = (VIRTUAL_PROPERTIES if upper else PROPERTIES)[genes["properties"] - 1]
        made["object_properties"] = {name: list(words) for name in objects[::2]}
    if genes["said"] == 2:
        made["names"] = {name: f"the {'very ' * (index % 9)}old box {index}" for index, name in enumerate(objects)}
    return made


TWO_HANDS = {"household-dual": ", two hands"}

# Genes of a goal.
GOAL = {"goals": size(1, 400), "goal_kind": choice(9), "same": choice(3), "conditional": choice(4)}


def goal_text(genes, rng, world, domain):
    """A conjunction of goals, conditional ones among them."""
    assets, objects = world["assets"], world["objects"]
    plain, places = objects, assets
    conditional = genes["conditional"] if domain == "household-checks" else 0

    def one(index):
        thing = plain[0] if genes["same"] == 0 else plain[index % len(plain)] if genes["same"] == 1 else rng.choice(plain)
        place = rng.choice(places) if genes["same"] else places[index % len(places)]
        return (
            f"put({thing}, {place})",
            f"opened({place})",
            f"closed({thing})",
            f"wiped({place}, {thing})",
            f"adjusted({thing})",
            f"put({thing}, {plain[(index * 7 + 1) % len(plain)]})",
            f"put({thing.strip('<>').replace('_', ' ')}, {place.strip('<>').replace('_', ' ')})",
            f"put({'box ' * (index % 9 + 1)}, {place})",
            f"put({thing}, {place}{TWO_HANDS.get(domain, str())})",
        )[genes["goal_kind"]]

    parts = []
    for index in range(genes["goals"]):
        part = one(index)
        if conditional and (conditional < 3 or index % 2):
            outcome = rng.choice(OUTCOMES)
            about = plain[index % len(plain)]
            no = "not " if rng.random() < 0.3 else ""
            part = f"if {no}{outcome}({about}) then {part}"
            if conditional != 2:
                part += f" and {one(index + 1)}" * (index % 3) + f" else {one(index + 2)}"
        parts.append(part)
    return " & ".join(parts)
