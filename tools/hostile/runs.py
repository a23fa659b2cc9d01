"""Families of runs: plans that are carried out on a simulated robot, interrupted logs, skills, and configurations of robots."""

import json

from genes import Family, choice, size
from measure import Case
from plans import CALLS, SMALL, TREE, Calls, write_block
from rules import GROUPS, Names
from worlds import environment

KINDS = ("fails", "no-effect", "slips", "moved", "undone")


def world_of(genes, rng):
    """Objects on a few places, in none of which a step is hindered."""
    assets = [f"<{'long_' * genes['long']}place_{index}>" for index in range(max(2, genes["assets"]))]
    objects = [f"<{'long_' * genes['long']}item_{index}>" for index in range(genes["objects"])]
    states = {name: f"on_something({assets[0]})" for name in objects}
    return {"assets": assets, "asset_states": {}, "objects": objects, "object_states": states}


def move(item, start, end, lane=None):
    """A valid move of an object as lines of a script."""
    hand = f'"{lane}", ' if lane else ""
    return [
        f'move_hand({hand}to="{item}")', f'grasp_object({hand}item="{item}")', f'detach_from_plane({hand}item="{item}", from_="{start}")',
        f'move_object({hand}item="{item}", to="{end}")', f'attach_to_plane({hand}item="{item}", to="{end}")', f'release_object({hand}item="{item}")',
    ]


def script_of(genes, rng, world):
    """A script of valid moves, there and back again in loops and branches."""
    where = {name: world["assets"][0] for name in world["objects"]}
    lines = []
    for index in range(genes["moves"]):
        item = world["objects"][index % len(world["objects"])]
        start, end = where[item], world["assets"][(index + 1) % len(world["assets"])]
        if start == end:
            continue
        there, back = move(item, start, end), move(item, end, start)
        if rng.randrange(100) < genes["looped"]:
            lines.append(f"for _ in range({genes['times']}):")
            lines.extend("    " + line for line in there + back)
        elif genes["checks"] and rng.randrange(100) < genes["branched"]:
            lines += [f'move_hand(to="{item}")', f'if check_best_by_date(item="{item}"):']
            lines += ["    " + line for line in there + back] + ["else:"] + ["    " + line for line in there[1:] + back]
        else:
            lines += there
            where[item] = end
    return "\n".join(lines) + "\n"


def lanes_of(genes, world):
    """Two hands that each move objects there and back."""
    lines = ["with parallel():"]
    for lane, item in zip(("left", "right"), (world["objects"] * 2)[:2]):
        lines.append(f'    with lane("{lane}"):')
        for index in range(genes["moves"]):
            if genes["times"] % 3 == 1:
                lines.append(f'        sync("s{index}")')
            places = world["assets"][:2]
            lines += ["        " + line for line in move(item, places[index % 2], places[1 - index % 2], lane)]
    return "\n".join(lines) + "\n"


def sim(genes):
    if genes["plain_sim"]:
        return "sim"
    kinds = "+".join(kind for bit, kind in enumerate(KINDS) if genes["kinds_of_faults"] >> bit & 1)
    options = f"sim:faults={genes['faults']},horizon={genes['horizon']},seed={genes['seed'] % 1000},sees={genes['sees']}"
    return options + (f",kinds={kinds}" if kinds else "")


def goal_of(genes, rng, world):
    names = Names({**genes, "form": 0}, rng, world)
    goal = names.goal()
    for _ in range(genes["goals"] - 1):
        goal += (" then " if rng.randrange(100) < genes["stages"] else " & ") + (names.rule() if rng.randrange(100) < genes["constraints"] else names.goal())
    return goal


def run(genes, rng):
    world = world_of(genes, rng)
    domain = "household-dual" if genes["dual"] else "household-checks" if genes["checks"] else "household"
    plan = lanes_of(genes, world) if genes["dual"] else script_of(genes, rng, world)
    files = {"plan.py": plan, "env.json": json.dumps(world)}
    argv = ["run", "plan.py", "--env", "env.json", "--domain", domain, "--robot", sim(genes), "--approve", "never", "--log", "run.jsonl", "--changes", "1"]
    if genes["goals"]:
        argv += ["--goal", goal_of(genes, rng, world)]
    if genes["rules"]:
        names = Names({**genes, "rule": 3 if genes["steps_only"] else 6}, rng, world)
        files["rules.txt"] = "\n".join(names.rule() for _ in range(genes["rules"])) + "\n"
        argv += ["--rules", "rules.txt"]
    if genes["seldom"]:
        argv += ["--observe", "on-failure"]
    return Case(files, tuple(argv))


def tree(genes, rng):
    """A plan of any shape, most of them not valid, with a goal."""
    world = environment(genes, rng, "household-checks")
    calls = Calls({**genes, "domain": 1}, rng, world)
    lines = [f'# objects: {json.dumps(world["objects"][: genes["things"]])}']
    write_block(genes, rng, calls, lines, genes["nodes"], 0)
    argv = ("run", "plan.py", "--env", "env.json", "--domain", "household-checks", "--robot", sim(genes), "--approve", "never", "--log", "run.jsonl", "--goal", goal_of(genes, rng, world))
    return Case({"plan.py": "\n".join(lines) + "\n", "env.json": json.dumps(world)}, argv)


def skills(genes, rng):
    """A plan of a domain with skill parameters, and a file with values for them."""
    world = world_of(genes, rng)
    names = world["objects"] + world["assets"] + ["_"]
    arm = {f"{part}_arm_{end}": "x" * min(genes["points"], 900) for part in ("upper", "lower") for end in ("first", "last")}
    every = {"first_position": [0, 0, 1], "last_position": [0, 1, 0], "object_position": [0, 0, 0], "approach": [0, 0, 1], "retreat": [0, 0, 1], "displacement": [0, 10.0 ** (genes["points"] % 9), 0], "grasp_type": "power", "hand": "right", **arm}
    own = {"move-hand": ("first_position", "last_position"), "grasp": ("object_position", "approach", "grasp_type"), "release": ("retreat",), "move-object": ("first_position", "last_position"), "detach": ("displacement", "last_position"), "attach": ("displacement", "first_position")}
    entries = {}
    for action, parameters in own.items():
        arity = 1 if action in ("move-hand", "grasp", "release") else 2
        full = {"arguments": ["_"] * arity, "values": {name: every[name] for name in (*parameters, "hand", *arm)}}
        entries[action] = [full]
    for index in range(genes["entries"]):
        action = list(own)[index % (1 + genes["actions"])]
        arity = len(entries[action][0]["arguments"])
        entry = {"arguments": [rng.choice(names) for _ in range(arity)], "values": {} if genes["value"] else {"hand": "left"}}
        if genes["stepped"]:
            entry["step"] = 1 + index
        entries[action].append(entry)
    files = {"plan.py": script_of({**genes, "checks": 0}, rng, world), "env.json": json.dumps(world), "skills.json": json.dumps(entries)}
    argv = ("run", "plan.py", "--env", "env.json", "--domain", "household-taught", "--robot", "sim", "--approve", "never", "--log", "run.jsonl", "--skills", "skills.json")
    return Case(files, argv)


def log(genes, rng):
    """The log of an interrupted run of a plan in loops; the robot saw nothing, or all of it."""
    world = world_of(genes, rng)
    places, plan, steps = world["assets"], [], []
    shown = lambda name: "the " + name.strip("<>").replace("_", " ")
    for index in range(genes["moves"]):
        item = world["objects"][index % len(world["objects"])]
        for start, end in (places[:2], places[1::-1]):
            for call, action, given, says in (
                ("move_hand()", "move-hand", {"to": item}, "move the hand to {}"), ("grasp_object()", "grasp", {"item": item}, "grasp {}"), ("detach_from_plane()", "detach", {"item": item, "from": start}, "pick up {} from {}"),
                ("move_object()", "move-object", {"item": item, "to": end}, "move {} to {}"), ("attach_to_plane()", "attach", {"item": item, "to": end}, "put down {} at {}"), ("release_object()", "release", {"item": item}, "release {}"),
            ):
                explanation = says.format(*map(shown, given.values()))
                plan.append({"call": call, "implicit": given, "explanation": explanation})
                steps.append((f"{action}({', '.join(given.values())})", explanation))
    for _ in range(genes["nested"]):
        plan = [{"repeat": 1 + genes["times"] % 2, "do": plan}]
    goal = {"goal": goal_of(genes, rng, world)} if genes["goals"] else {}
    names = Names({**genes, "rule": 3 if genes["odd"] else 6}, rng, world)
    constraints = {"constraints": [[names.rule(), True] for _ in range(genes["rules"])]} if genes["rules"] else {}
    began = {"event": "began", "format": 3, "domain": "household", "environment": world, "plan": plan, **goal, **constraints, "approval": "never", "trust": "observed", "watch": "each-step", "changes": 8, "reports": ["hand-at", "lifted", "wiped", "adjusted"]}
    seen = {"event": "observed", "statements": {"states": {}}}
    events = [began, seen]
    for number in range(genes["done"]):
        step = number % len(steps)
        events += [{"event": "ordered", "order": number + 1, "step": step + 1, "call": steps[step][0], "explanation": steps[step][1]}, {"event": "performed", "order": number + 1}]
        events += [seen] * (1 + (genes["more"] if number == 0 else 0))
    lines = [json.dumps({"longstep_run": 1, "robot": "sim", "domain": "household"})] + [json.dumps(event) for event in events]
    return Case({"run.jsonl": "\n".join(lines) + "\n"}, ("run", "--resume", "run.jsonl"))


ACTIONS = ("move-hand", "grasp", "release", "move-object", "detach", "attach", "open-by-rotate", "close-by-rotate", "*")


def robot(genes, rng):
    """A configuration of a robot behind ROS 2 that is checked without a connection."""
    world = world_of(genes, rng)
    names = world["objects"] + world["assets"]
    lines = ['name = "r"', 'url = "ws://127.0.0.1:9"', f"allow = {json.dumps([ACTIONS[index % 8] for index in range(genes['allowed'] if genes['entries'] > 8 else min(genes['allowed'], genes['entries']))])}"]
    template = ("{step}", "{item|bare}" * genes["holes"], "{{" * genes["holes"], "{to|pose0}", "{item}" * genes["holes"], "{arguments}{skills|json}" * genes["holes"])[genes["template"]]
    nested = template
    for _ in range(genes["deep"]):
        nested = {"a": nested} if genes["lists"] else [nested]
    for index in range(genes["tables"]):
        lines.append(f"[table.pose{index}]")
        lines += [f"{json.dumps(name)} = {{ x = {at} }}" for at, name in enumerate(names[: genes["rows"]])]
    for index in range(genes["entries"] if genes["lists"] else min(9, genes["entries"])):
        lines += ["[[action]]", f'name = "{ACTIONS[index % 9]}"', 'server = "/s"', 'type = "a/action/B"', f"goal = {{ x = {inline(nested)} }}"]
        if genes["outcomes"]:
            lines.append("outcomes = [" + ", ".join(f'{{ is = "(fresh {{item}})", when = {{ a{at} = {{ below = {at} }} }} }}' for at in range(genes["outcomes"])) + "]")
    for index in range(genes["observations"]):
        said = ", ".join(f'{{ state = "on_something({{place}})", when = {{ "{".".join("abc"[at % 3] for at in range(genes["deep"] + 1))}" = {at} }} }}' for at in range(genes["said"]))
        lines += ["[[observation]]", f'topic = "/t{index}"', 'type = "a/msg/B"', 'each = ["a", "b"]', 'entity = "{name|entity}"', f"say = [{said}]"]
    return Case({"robot.toml": "\n".join(lines) + "\n", "env.json": json.dumps(world)}, ("robot", "check", "robot.toml", "--offline", "--env", "env.json"))


def inline(value):
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {inline(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(inline(inner) for inner in value) + "]"
    return json.dumps(value)


WORLD = {"assets": size(2, 60), "objects": size(1, 60), "long": size(0, 20)}
MOVES = {"moves": size(1, 70), "looped": size(0, 100), "times": size(0, 10), "branched": size(0, 100), "checks": choice(2)}
AIM = {**GROUPS, "goals": size(0, 30), "stages": size(0, 100), "constraints": size(0, 60)}
SIM = {"plain_sim": choice(2), "kinds_of_faults": size(0, 31), "faults": size(0, 100), "horizon": size(1, 10000), "sees": size(0, 100)}

FAMILIES = [
    Family("run", {**WORLD, **MOVES, **AIM, **SIM, "rules": size(0, 400), "steps_only": choice(2), "seldom": choice(2), "dual": choice(1)}, run),
    Family("run-small-world", {**WORLD, "assets": size(2, 6), "objects": size(1, 6), **MOVES, **AIM, **SIM, "rules": size(0, 0), "steps_only": choice(1), "seldom": choice(2), "dual": choice(1)}, run),
    Family("run-lanes", {**WORLD, "assets": size(2, 6), "objects": size(1, 6), **MOVES, **AIM, **SIM, "goals": size(0, 4), "rules": size(0, 0), "steps_only": choice(1), "seldom": choice(2), "dual": choice(2)}, lambda genes, rng: run({**genes, "dual": 1}, rng)),
    Family("run-tree", {**SMALL, **CALLS, **TREE, **AIM, **SIM, "goals": size(1, 8)}, tree),
    Family("run-skills", {**WORLD, **MOVES, "points": size(0, 400), "entries": size(0, 400), "actions": size(0, 5), "value": choice(2), "stepped": choice(2)}, skills),
    Family("run-log", {**WORLD, **MOVES, **AIM, "goals": size(0, 4), "rules": size(0, 60), "nested": size(0, 4), "done": size(0, 60), "more": size(0, 0), "odd": choice(2)}, log),
    Family("robot-check", {**WORLD, "allowed": size(0, 500), "holes": size(1, 1000), "template": choice(6), "deep": size(0, 40), "lists": choice(2), "tables": size(0, 60), "rows": size(0, 120), "entries": size(0, 120), "outcomes": size(0, 200), "observations": size(0, 80), "said": size(0, 200)}, robot),
]
