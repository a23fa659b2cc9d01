"""Families of rules files and goals: groups, counts, stages, constraints, comparisons."""

import json

from examples import text
from genes import Family, choice, size
from measure import Case
from worlds import ENVIRONMENT, environment

DOMAINS = ("household", "household-checks", "household-dual", "virtualhome")
PLAN = '{"task_cohesion": {"task_sequence": ["move_hand()", "grasp_object()"]}}'
COMMANDS = (
    ("solve", "--goal", "GOAL"),
    ("verify", "plan.json"),
    ("repair", "plan.json"),
    ("solve", "--goal", "GOAL", "--json"),
    ("solve", "--goal", "GOAL", "--parallel"),
    ("solve", "--goal", "GOAL", "--pddl"),
    ("run", "plan.py", "--robot", "sim", "--approve", "never", "--log", "run.jsonl", "--goal", "GOAL"),
)
TANK = {f"d/{name}": text(f"tools/hostile/tank/{name}") for name in ("domain.pddl", "domain.toml")}
TANK["d/prompt/goal.md"] = "Write goals.\n"
TANK["d/prompt/examples.toml"] = '[[example]]\nobjects = { dock = "" }\nplaces = { well = "" }\ninstruction = "Fly"\nanswer = "question: Where to?"\n'


class Names:
    """Names and groups of the entities of a world, and goals over them."""

    def __init__(self, genes, rng, world, upper=False):
        self.genes, self.rng = genes, rng
        self.objects, self.places = world["objects"], world["assets"]
        self.upper = upper

    def name(self, names):
        names = names[: max(1, self.genes["variety"])]
        return self.rng.choice(names)

    def kind(self):
        return self.rng.choice(("thing", "object", "box", "item") if self.genes["kinds"] else ("thing",))

    def condition(self):
        word = ("ON", "INSIDE") if self.upper else ("on_something", "inside_something")
        # Nothing is there, mostly.
        text = f"{self.rng.choice(word)}({self.name(self.places[::-1])})"
        return text if self.rng.random() < 0.02 else f"not {text}"

    def group(self, names):
        """A name or a group of entities."""
        genes, rng = self.genes, self.rng
        if rng.randrange(100) >= genes["groups"]:
            return self.name(names)
        count = 1 + rng.randrange(max(1, genes["count"]))
        made = f"{('all', 'any', f'{count} of', f'exactly {count} of', 'each')[genes['quantifier'] if genes['quantifier'] < 5 else rng.randrange(5)]} {self.kind()}"
        if genes["conditions"]:
            made += " where " + " & ".join(self.condition() for _ in range(genes["conditions"]))
        if genes["exceptions"]:
            made += f" except ({', '.join(self.name(names) for _ in range(genes['exceptions']))})"
        return made

    def goal(self):
        kind = self.genes["form"] if self.genes["form"] < 6 else self.rng.randrange(6)
        one, other = self.group(self.objects), self.group(self.places)
        word = "ON" if self.upper else "on_something"
        return (f"put({one}, {other})", f"opened({other})", f"closed({one})", f"{word}({one}, {other})", f"put({one}, {self.group(self.objects)})", f"wiped({other}, {one})")[kind]

    def rule(self):
        genes, rng = self.genes, self.rng
        kind = genes["rule"] if genes["rule"] < 6 else rng.randrange(6)
        one, other = self.group(self.objects), self.group(self.places)
        steps = ("never Grab(_)", f"never Grab({one})", f"never Put({one}, {other})") if self.upper else ("never wipe_on_plane()", "never open_by_rotate()")
        return (f"never {self.goal()}", f"never put({one}, {self.group(self.objects)})", f"untouched({one})", rng.choice(steps), f"never opened({other})", f"never put({one}, {other})")[kind]


def rules(genes, rng):
    domain = DOMAINS[genes["domain"]]
    world = environment(genes, rng, domain)
    names = Names(genes, rng, world, domain == "virtualhome")
    lines = [names.rule() for _ in range(genes["distinct"])]
    lines = [lines[index % len(lines)] + (f"  # {index}" if genes["comments"] else "") for index in range(genes["rules"])]
    if genes["joined"]:
        lines = [" & ".join(lines)]
    plain = Names({**genes, "groups": genes["goal_groups"], "form": 0, "variety": 500}, rng, world, domain == "virtualhome")
    goals = [plain.goal() for _ in range(genes["goals"])]
    script = f'# objects: {json.dumps(world["objects"][:3])}\nmove_hand(to="{world["objects"][0]}")\ngrasp_object(item="{world["objects"][0]}")\n'
    files = {"env.json": json.dumps(world), "rules.txt": "\n".join(lines) + "\n", "plan.json": PLAN, "plan.py": script}
    argv = tuple(" & ".join(goals) if word == "GOAL" else word for word in COMMANDS[genes["command"]])
    return Case(files, (*argv, "--env", "env.json", "--domain", domain, "--rules", "rules.txt"))


def goals(genes, rng):
    """Goals with groups, stages and constraints, without a rules file."""
    domain = DOMAINS[genes["domain"]]
    world = environment(genes, rng, domain)
    names = Names(genes, rng, world, domain == "virtualhome")
    parts = [names.rule() if rng.randrange(100) < genes["constraints"] else names.goal() for _ in range(genes["goals"])]
    text = parts[0]
    for part in parts[1:]:
        text += (" then " if rng.randrange(100) < genes["stages"] else " & ") + part
    argv = tuple(text if word == "GOAL" else word for word in COMMANDS[(0, 3, 4, 5)[genes["command"] % 4]])
    return Case({"env.json": json.dumps(world)}, (*argv, "--env", "env.json", "--domain", domain))


NUMBERS = ("5", "0", "40", "0.000001", "39.999999", "1000000000", "-1", "9" * 30, "1e9", "9223372036854", "9223372036854.775807")


def numbers(genes, rng):
    """Tanks with numbers: goals and rules that compare them."""
    places = ["<dock>", "<well>"] + [f"<tank_{index}>" for index in range(genes["tanks"])]
    states = {"<dock>": ["here()"], "<well>": []}

    def number():
        return NUMBERS[genes["number"]] if genes["number"] < len(NUMBERS) else str(rng.randrange(41))

    for index, place in enumerate(places):
        said = states.setdefault(place, [])
        if index > 1:
            said += [f"level({rng.randrange(5) if genes['plain'] else number()})", f"capacity({40 if genes['plain'] else number()})"]
        said += [f"distance({other}, {1 + (index * 7 + at) % 5})" for at, other in enumerate(places) if other != place and rng.randrange(100) < genes["distances"]]
    world = {"assets": places, "asset_states": states, "objects": [], "facts": ["bucket(0)", f"battery({100 if genes['plain'] else number()})"]}
    tanks = places[2:]

    def side():
        group = f"level({('all', 'any', '2 of', 'exactly 1 of')[rng.randrange(4)]} place)" if genes["grouped"] else "battery"
        return (f"level({rng.choice(tanks)})", "battery", "bucket", group, number())

    def compared():
        return f"{rng.choice(side()[:4])} {rng.choice(('<', '<=', '=', '!=', '>=', '>'))} {rng.choice(side())}"

    def part():
        one = compared() if genes["compare"] else f"level({rng.choice(tanks)}) >= {number()}"
        return (f"never {one}", f"never {one}", f"untouched({rng.choice(tanks)})", "never Draw(_)")[rng.randrange(4)] if rng.randrange(100) < genes["constraints"] else one

    goal = part()
    for _ in range(genes["goals"] - 1):
        goal += (" then " if rng.randrange(100) < genes["stages"] else " & ") + part()
    lines = [f"never {compared()}" for _ in range(genes["rules"])]
    argv = (("solve", "--goal", goal), ("solve", "--goal", goal, "--json"), ("solve", "--goal", goal, "--pddl"), ("domain", "check", "d"))[genes["command"] % 4]
    files = {**TANK, "env.json": json.dumps(world), "rules.txt": "\n".join(lines) + "\n"}
    if argv[0] == "domain":
        return Case(files, (*argv, "--env", "env.json"))
    return Case(files, (*argv, "--env", "env.json", "--domain", "d", "--rules", "rules.txt"))


GROUPS = {
    "variety": size(1, 500), "kinds": choice(2), "groups": size(0, 100), "count": size(1, 300), "quantifier": choice(6),
    "conditions": size(0, 30), "exceptions": size(0, 60), "form": choice(7), "rule": choice(7), "goal_groups": size(0, 100),
}
LITTLE = {**ENVIRONMENT, "assets": size(1, 30), "objects": size(1, 30), "states": size(1, 4)}
RULES = {**GROUPS, "rules": size(1, 1500), "distinct": size(1, 600), "comments": choice(2), "joined": choice(2), "goals": size(1, 12), "command": choice(len(COMMANDS)), "domain": choice(4)}
GOALS = {**GROUPS, "goals": size(1, 300), "constraints": size(0, 100), "stages": size(0, 100), "command": choice(4), "domain": choice(4)}

FAMILIES = [
    Family("rules", {**ENVIRONMENT, **RULES}, rules),
    Family("rules-small-world", {**LITTLE, **RULES}, rules),
    Family("rules-run", {**LITTLE, **RULES}, lambda genes, rng: rules({**genes, "command": 6, "domain": 0}, rng)),
    Family("goal-groups", {**ENVIRONMENT, **GOALS}, goals),
    Family("goal-groups-small-world", {**LITTLE, **GOALS}, goals),
    Family("goal-stages", {**LITTLE, **GOALS, "goals": size(2, 40), "stages": size(30, 100)}, goals),
    Family(
        "numbers",
        {"tanks": size(1, 120), "number": choice(len(NUMBERS) + 3), "plain": choice(3), "distances": size(0, 100), "compare": choice(2), "grouped": choice(2), "constraints": size(0, 60), "stages": size(0, 100), "goals": size(1, 60), "rules": size(0, 600), "command": choice(4)},
        numbers,
    ),
]
