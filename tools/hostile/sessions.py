"""Families of goals, compositions, suites with recorded replies, session logs and recordings."""

import json

from domains import HEAD
from genes import Family, choice, size
from measure import Case
from plans import CALLS, DOMAINS, SMALL, TREE, Calls, write_block
from worlds import ENVIRONMENT, GOAL, environment, goal_text

SOLVE = ((), ("--parallel",), ("--pddl",), ("--json",))


def solve(genes, rng):
    world = environment(genes, rng, DOMAINS[genes["domain"]])
    argv = ("solve", "--goal", goal_text(genes, rng, world, DOMAINS[genes["domain"]]), "--env", "env.json", "--domain", DOMAINS[genes["domain"]])
    return Case({"env.json": json.dumps(world)}, argv + SOLVE[genes["way"]])


WORLD_COMMANDS = (
    ("solve", "--goal", "GOAL", "--env", "env.json"),
    ("verify", "plan.json", "--env", "env.json"),
    ("plan", "Put the box on the table", "--env", "env.json", "--model", "replay:r.jsonl", "--explain-prompt"),
    ("plan", "Put the box on the table", "--env", "env.json", "--model", "replay:r.jsonl", "--strategy", "direct", "--explain-prompt"),
    ("plan", "INSTRUCTION", "--env", "env.json", "--model", "replay:r.jsonl"),
    ("chat", "--env", "env.json", "--model", "replay:r.jsonl", "--session", "kept"),
)


def world_only(genes, rng):
    """An environment, and an instruction of so many words."""
    world = environment(genes, rng, DOMAINS[genes["domain"]])
    instruction = words(genes, rng, world)
    goal = f"put({world['objects'][0]}, {world['assets'][0]})"
    given = {"INSTRUCTION": instruction, "GOAL": goal}
    argv = tuple(given.get(word, word) for word in WORLD_COMMANDS[genes["command"]])
    head = HEAD.replace('"grammar"', '"json_schema"') if genes["schema"] else HEAD
    if genes["context"]:
        head = head.replace("null", str(genes["context"]))
    files = {"env.json": json.dumps(world), "plan.json": '{"task_cohesion": {"task_sequence": []}}', "r.jsonl": head + "\n"}
    return Case(files, (*argv, "--domain", DOMAINS[genes["domain"]]))


def words(genes, rng, world):
    names = [name.strip("<>").replace("_", " ") for name in world["assets"] + world["objects"]]
    kinds = (names, ["if", "it", "is", "empty", "put", "the", "otherwise", "throw", "away", *names[:3]], names[:1], ["and", "or", *names])
    return " ".join(rng.choice(kinds[genes["wording"]]) for _ in range(genes["words"] + 1))


def compose(genes, rng):
    """Stored plans, and a script that calls them."""
    world = environment(genes, rng, "household-checks")
    calls = Calls({**genes, "domain": 1}, rng, world)
    files = {"env.json": json.dumps(world)}
    for index in range(genes["stored"]):
        steps = [calls.call(python=False) for _ in range(genes["steps"])]
        plan = {"task_cohesion": {"task_sequence": steps, "object_name": rng.choice(world["objects"])}, "environment_before": world}
        files[f"plans/p{index}.json"] = json.dumps(plan)
    lines = []
    calls.name = lambda: f"p{rng.randrange(genes['stored'])}"
    calls.call = lambda name=None, lane=None: f"{name or calls.name()}()"
    write_block(genes, rng, calls, lines, genes["nodes"], 0)
    files["c.py"] = "\n".join(lines) + "\n"
    return Case(files, ("compose", "--script", "c.py", "--plans", "plans", "--env", "env.json", "--domain", "household-checks"))


def reply_of(genes, rng, world, calls):
    """What a model could have answered: goals, a plan as a tree or a list, or text around one."""
    kind = genes["reply"]
    if kind == 0:
        goals = goal_text(genes, rng, world, "household-checks").split(" & ")
        return {"question": "", "goals": goals}
    if kind == 1:
        steps = [calls.call(python=False) for _ in range(genes["steps"])]
        return {"task_cohesion": {"task_sequence": steps, "object_name": rng.choice(world["objects"])}, "environment_after": world}
    if kind == 2:
        lines = []
        write_block(genes, rng, calls, lines, genes["nodes"], 0)
        return {"python_script": "\n".join(lines), "environment_after": world}
    if kind == 3:
        return {"question": words(genes, rng, world)}
    return ("{[" * genes["steps"], "```\n" * genes["steps"], "{'a': [" * genes["steps"] + "//")[kind - 4] + words(genes, rng, world)


def suite(genes, rng):
    """A suite with a reply for each case: what a session does with hostile replies, without a model."""
    world = environment(genes, rng, "household-checks")
    calls = Calls({**genes, "domain": 1}, rng, world)
    cases, replies = [], []
    for index in range(genes["cases"]):
        goal = goal_text({**genes, "goals": min(genes["goals"], 8)}, rng, world, "household-checks")
        cases.append(f'[[case]]\nid = "c{index}"\nscene = "s"\nsays = {json.dumps(words(genes, rng, world))}\ngoal = {json.dumps(goal)}\n')
        for turn in range(genes["rounds"]):
            replies.append({"case": f"c{index}", "round": turn, "reply": reply_of(genes, rng, world, calls)})
    files = {
        "s/suite.toml": 'name = "s"\nabout = "A test."\ndomain = "household-checks"\n',
        "s/cases.toml": "\n".join(cases),
        "s/scenes/s.json": json.dumps(world),
        "r.json": json.dumps(replies),
    }
    strategy = ("goal", "direct")[genes["reply"] in (1, 2) or genes["direct"]]
    return Case(files, ("eval", "s", "--replies", "r.json", "--out", "run", "--strategy", strategy))


SESSION_COMMANDS = (
    ("session", "replay", "kept"),
    ("session", "show", "kept"),
    ("session", "show", "kept", "--json"),
    ("chat", "--resume", "kept", "--model", "replay:r.jsonl"),
)


def log(genes, rng):
    """A session log in which instructions were given and replies came."""
    world = environment(genes, rng, "household-checks")
    calls = Calls({**genes, "domain": 1}, rng, world)
    usage = {"prompt_tokens": 1, "cached_tokens": 0, "completion_tokens": 1}
    settings = {"strategy": "direct" if genes["direct"] else "goal", "repair": "first", "rounds": genes["rounds"], "accept": bool(genes["accepts"])}
    events = [
        {"event": "begin", "version": 1, "domain": "household-checks", "environment": world, "settings": settings},
        {"event": "model", "name": "m", "schema": bool(genes["schema"]), "context": genes["context"] or None},
    ]
    for _ in range(genes["cases"]):
        events.append({"event": "instruction", "text": words(genes, rng, world)})
        for _ in range(max(1, genes["rounds"])):
            reply = reply_of(genes, rng, world, calls)
            text = reply if isinstance(reply, str) else json.dumps(reply)
            events.append({"event": "reply", "text": text, "finish": "stop", "usage": usage, "milliseconds": 1.0})
        events.append(rng.choice(({"event": "cancel"}, {"event": "feedback", "text": words(genes, rng, world)}, {"event": "undo", "number": 0})))
    lines = [json.dumps({"at": "2026-01-01T00:00:00Z", **event}) for event in events]
    files = {"kept/session.jsonl": "\n".join(lines) + "\n", "r.jsonl": HEAD + "\n"}
    return Case(files, SESSION_COMMANDS[genes["command"]])


def recording(genes, rng):
    """A recording with many requests, none of which is the one that is asked."""
    world = environment(genes, rng, "household")
    lines = [HEAD]
    for index in range(genes["cases"]):
        messages = [{"role": "user", "text": words(genes, rng, world)} for _ in range(genes["rounds"] + 1)]
        constraint = ({"json_schema": {"a": index}}, "free", {"lark": words(genes, rng, world)})[index % 3]
        request = {"messages": messages, "answer_so_far": "", "constraint": constraint, "max_tokens": 9}
        reply = {"text": "x", "finish": "stop", "prompt_tokens": 1, "cached_tokens": 0, "completion_tokens": 1}
        lines.append(json.dumps({"turn": {"request": request, "reply": reply}}))
    files = {"env.json": json.dumps(world), "r.jsonl": "\n".join(lines) + "\n"}
    return Case(files, ("plan", words(genes, rng, world), "--env", "env.json", "--model", "replay:r.jsonl"))


# Longer instructions than 2,000 characters are refused.
WORDS = {"words": size(0, 900), "wording": choice(4)}
TALK = {
    **SMALL, **CALLS, **TREE, **GOAL, **WORDS,
    "cases": size(1, 60), "rounds": size(1, 6), "reply": choice(7), "steps": size(1, 400), "direct": choice(2),
    "accepts": choice(2), "schema": choice(2), "context": size(0, 20000),
}

FAMILIES = [
    Family("solve", {**ENVIRONMENT, **GOAL, "domain": choice(4), "way": choice(4)}, solve),
    Family("solve-small-world", {**SMALL, **GOAL, "goals": size(1, 60), "domain": choice(4), "way": choice(4)}, solve),
    Family("solve-conditional", {**ENVIRONMENT, **GOAL, "goals": size(1, 30), "conditional": choice(4), "domain": choice(1), "way": choice(4)}, lambda genes, rng: solve({**genes, "domain": 1, "conditional": max(1, genes["conditional"])}, rng)),
    Family("environment", {**ENVIRONMENT, **WORDS, "domain": choice(4), "command": choice(len(WORLD_COMMANDS)), "schema": choice(2), "context": size(0, 20000)}, world_only),
    Family("compose", {**SMALL, **CALLS, **TREE, "stored": size(1, 30), "steps": size(0, 200)}, compose),
    # An evaluation is a batch, and so is a log: each reply of a model has budgets of its own, so one is what is measured.
    Family("suite", {**TALK, "cases": size(1, 1), "rounds": size(1, 1)}, suite),
    Family("session-log", {**TALK, "cases": size(1, 1), "rounds": size(1, 1), "command": choice(len(SESSION_COMMANDS))}, log),
    Family("recording", {**SMALL, **WORDS, "cases": size(1, 200), "rounds": size(0, 30)}, recording),
]
