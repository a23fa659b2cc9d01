"""Families of plans: lists of steps, scripts with branches, loops, lanes and large conditions, claims, sentences."""

import json

from genes import Family, choice, size
from measure import Case
from worlds import ENVIRONMENT, OUTCOMES, environment

DOMAINS = ("household", "household-checks", "household-dual", "virtualhome")
COMMANDS = (
    ("verify",),
    ("repair",),
    ("verify", "--feedback"),
    ("export", "--format", "python"),
    ("export", "--format", "json"),
    ("verify", "--json"),
    ("repair", "--json"),
)
COMMAND = {"command": choice(len(COMMANDS)), "domain": choice(len(DOMAINS))}
SENSING = ("check_best_by_date", "check_fullness", "check_damage", "check_cleanness")
MOVING = ("move_object", "move_hand", "grasp_object", "release_object", "detach_from_plane", "attach_to_plane", "wipe_on_plane")
HANDLES = ("open_by_rotate", "close_by_rotate", "adjust_by_rotate", "open_by_slide", "close_by_slide", "adjust_by_slide")
VIRTUAL = ("Walktowards", "Grab", "Open", "Close", "Put", "PutIn", "SwitchOn", "Drink")
# One object from its place to another one, as a valid plan does it.
MOVE = ("move_hand", "grasp_object", "detach_from_plane", "move_object", "attach_to_plane", "release_object")


def command(genes, plan, env):
    words = COMMANDS[genes["command"]]
    return (words[0], plan, *words[1:], "--env", env, "--domain", DOMAINS[genes["domain"]])


class Calls:
    """Writes calls of a domain, with hidden or given arguments."""

    def __init__(self, genes, rng, world):
        self.genes, self.rng = genes, rng
        self.domain = DOMAINS[genes["domain"]]
        self.things = world["objects"] or ["<cup>"]
        self.places = world["assets"] or self.things
        self.count = 0

    def thing(self):
        return self.rng.choice(self.things[: max(1, self.genes["things"])])

    def place(self):
        return self.rng.choice(self.places[: max(1, self.genes["things"])])

    def words(self):
        if self.domain == "virtualhome":
            return VIRTUAL
        sensing = SENSING if self.domain == "household-checks" else ()
        return (MOVE, MOVING, MOVING + HANDLES, sensing or MOVING)[self.genes["verbs"]]

    def name(self):
        words = self.words()
        self.count += 1
        # In the order of a valid plan, or any.
        return words[(self.count - 1) % len(words)] if self.genes["verbs"] == 0 else self.rng.choice(words)

    def call(self, python=True, name=None, lane=None):
        name = name or self.name()
        quoted = (lambda text: f'"{text}"') if python else (lambda text: text)
        if self.domain == "virtualhome":
            given = [quoted(self.thing())] + ([quoted(self.place())] if name in ("Put", "PutIn") else [])
            return f"{name}({', '.join(given)})"
        given = []
        if python and self.rng.randrange(100) < self.genes["given"]:
            thing = {"move_hand": None, "check_cleanness": "thing", "wipe_on_plane": "tool"}.get(name, "item")
            if name in HANDLES:
                thing = "handle"
            if thing:
                given.append(f'{thing}="{self.thing()}"')
            if name in ("move_hand", "move_object", "attach_to_plane"):
                given.append(f'to="{self.place()}"')
        if self.domain == "household-dual" and lane is None:
            given.insert(0, quoted("left" if self.rng.random() < 0.5 else "right"))
        elif lane:
            given.insert(0, quoted(lane))
        return f"{name}({', '.join(given)})"

    def fact(self):
        if self.domain == "virtualhome":
            return f'OPEN("{self.thing()}")'
        if self.domain == "household-checks" and self.rng.random() < 0.7:
            return f'{self.rng.choice(OUTCOMES)}("{self.thing()}")'
        return self.rng.choice((f'on_something("{self.thing()}", "{self.place()}")', f'closed("{self.thing()}")', f'inside_hand("{self.thing()}")'))

    def condition(self, parts, depth):
        """A condition of so many parts; sensing calls, facts, `not`, `and`, `or` in each other."""
        if parts <= 1 or depth <= 0:
            senses = self.domain == "household-checks" and self.rng.randrange(100) < self.genes["sensing"]
            text = self.call(name=self.rng.choice(SENSING)) if senses else self.fact()
            return f"not {text}" if self.rng.random() < 0.2 else text
        word = (" and ", " or ")[self.rng.randrange(2) if self.genes["shape"] == 0 else depth % 2]
        if self.genes["shape"] == 1:
            # The same few facts again and again.
            few = min(parts - 1, self.genes["repeated"])
            pieces = [self.condition(few, depth - 1)] * (parts // few)
        else:
            cut = 2 if self.genes["shape"] == 0 else parts // 2 + 1
            pieces = [self.condition(parts // cut, depth - 1) for _ in range(cut)]
        return f"({word.join(pieces)})"


CALLS = {"things": size(1, 60), "verbs": choice(4), "given": size(0, 100), "sensing": size(0, 100), "shape": choice(3), "repeated": size(1, 8)}


def flat(genes, rng):
    world = environment(genes, rng, DOMAINS[genes["domain"]])
    calls = Calls(genes, rng, world)
    steps = [calls.call(python=False) for _ in range(genes["steps"])]
    said = {}
    if genes["sentences"]:
        said["step_instructions"] = [sentence(genes, rng, world) for _ in steps]
    if genes["sentences"] != 2:
        said["object_names"] = world["objects"][: genes["things"]]
    plan = {"task_cohesion": {"task_sequence": steps, **said}, "instruction_summary": sentence(genes, rng, world)}
    if genes["claims"]:
        plan["environment_after"] = claimed(genes, rng, world)
    return Case({"plan.json": json.dumps(plan), "env.json": json.dumps(world)}, command(genes, "plan.json", "env.json"))


def sentence(genes, rng, world):
    names = [name.strip("<>").replace("_", " ") for name in world["assets"] + world["objects"]]
    words = (names, ["put", "the", "box", "into", "it"], names[:1], [name.split()[-1] for name in names])
    return " ".join(rng.choice(words[genes["wording"]]) for _ in range(genes["words"]))


def claimed(genes, rng, world):
    """An environment afterwards in which so many objects are elsewhere."""
    after = {**world, "object_states": dict(world["object_states"])}
    word = "ON" if DOMAINS[genes["domain"]] == "virtualhome" else rng.choice(("on_something", "inside_something"))
    for name in world["objects"][: genes["claims"]]:
        after["object_states"][name] = f"{word}({rng.choice(world['assets'])})"
    return after


SENTENCES = {"sentences": choice(3), "words": size(0, 6000), "wording": choice(4), "claims": size(0, 300)}


def script(genes, rng):
    world = environment(genes, rng, DOMAINS[genes["domain"]])
    calls = Calls(genes, rng, world)
    lines = [f'# objects: {json.dumps(world["objects"][: genes["things"]])}']
    write_block(genes, rng, calls, lines, genes["nodes"], 0)
    files = {"plan.py": "\n".join(lines) + "\n", "env.json": json.dumps(world)}
    return Case(files, command(genes, "plan.py", "env.json"))


def write_block(genes, rng, calls, lines, nodes, depth):
    """Writes so many nodes, branches and loops among them as often as their genes say."""
    indent = "    " * depth
    weights = (genes["plain"], genes["branches"], genes["whiles"], genes["counts"], genes["lanes"] * (depth == 0))
    begun = len(lines)
    while nodes > 0:
        kind = rng.choices(range(5), weights)[0] if depth < genes["depth"] and sum(weights) else 0
        inner = max(1, nodes * genes["share"] // 100)
        nodes -= 1 if kind == 0 else inner
        if kind == 0:
            lines.append(indent + calls.call() + claim(genes, rng, calls))
        elif kind == 1:
            lines.append(f"{indent}if {calls.condition(genes['parts'], 12)}:")
            write_block(genes, rng, calls, lines, inner // 2, depth + 1)
            if rng.random() < 0.7:
                lines.append(f"{indent}else:")
                write_block(genes, rng, calls, lines, inner // 2, depth + 1)
        elif kind == 2:
            lines.append(f"{indent}while {calls.condition(genes['parts'], 12)}:")
            write_block(genes, rng, calls, lines, inner, depth + 1)
        elif kind == 3:
            lines.append(f"{indent}for _ in range({10 ** genes['times'] - 1}):")
            write_block(genes, rng, calls, lines, inner, depth + 1)
        else:
            write_lanes(genes, rng, calls, lines, inner)
    if len(lines) == begun:
        lines.append(indent + "pass")


def write_lanes(genes, rng, calls, lines, nodes):
    lines.append("with parallel():")
    for lane in ("left", "right"):
        lines.append(f'    with lane("{lane}"):')
        for index in range(max(1, nodes // 2)):
            if genes["syncs"] and index % genes["syncs"] == genes["syncs"] - 1:
                lines.append(f'        sync("s{index}")')
            lines.append("        " + calls.call(lane=lane if genes["given"] else ""))


def claim(genes, rng, calls):
    if rng.randrange(100) >= genes["step_claims"]:
        return ""
    return f"  # so; {calls.thing()}: {rng.choice(('inside_hand()', f'on_something({calls.place()})'))}"


TREE = {
    "nodes": size(1, 600),
    "depth": size(0, 47),
    "share": size(1, 100),
    "plain": size(0, 20),
    "branches": size(0, 20),
    "whiles": size(0, 20),
    "counts": size(0, 20),
    "lanes": size(0, 20),
    "times": size(0, 9),
    "parts": size(1, 400),
    "syncs": size(0, 12),
    "step_claims": size(0, 100),
}

# A world of a few objects, in which plans can get somewhere.
SMALL = {**ENVIRONMENT, "assets": size(1, 12), "objects": size(1, 12), "states": size(1, 4)}


FAMILIES = [
    Family("plan-list", {**COMMAND, **ENVIRONMENT, **CALLS, **SENTENCES, "steps": size(0, 900)}, flat),
    Family("plan-list-small-world", {**COMMAND, **SMALL, **CALLS, **SENTENCES, "steps": size(0, 900)}, flat),
    Family("script", {**COMMAND, **SMALL, **CALLS, **TREE}, script),
    Family("script-large-world", {**COMMAND, **ENVIRONMENT, **CALLS, **TREE, "nodes": size(1, 60)}, script),
    Family(
        "script-sensing",
        {**COMMAND, **SMALL, **CALLS, **TREE, "domain": choice(2), "branches": size(5, 20), "things": size(1, 12)},
        lambda genes, rng: script({**genes, "domain": 1}, rng),
    ),
    Family(
        "script-condition",
        {**COMMAND, **SMALL, **CALLS, **TREE, "nodes": size(1, 8), "branches": size(5, 20), "parts": size(1, 900)},
        lambda genes, rng: script({**genes, "domain": 1}, rng),
    ),
    Family(
        "script-lanes",
        {**COMMAND, **SMALL, **CALLS, **TREE, "lanes": size(5, 20), "nodes": size(1, 600)},
        lambda genes, rng: script({**genes, "domain": 2}, rng),
    ),
]
