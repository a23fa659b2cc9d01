"""Tests of the simulator itself: cases worked out by hand, and planted faults that the comparison has to find."""

import argparse
import tempfile
from pathlib import Path

from . import search, task_compare, task_machine, words
from .cases import Case
from .compare import compare
from .domains import EXAMPLES, GOAL_PROMPT
from .judge import Judge
from .world import FAULTS

# The classes in which a planted fault shows, and the cases within which it has to be found.
WITHIN = 6_000
# The planning tasks within which a fault in their meaning has to be found.
TASKS = 300
SHOWS_IN = {
    "add-before-delete": ["flat"],
    "sequential-effects": ["domain"],
    "any-for-all": ["flat"],
    "initially-now": ["domain"],
    "no-always": ["domain"],
    "no-end": ["flat"],
    "one-outcome": ["tree"],
    "eager-conditions": ["tree"],
    "claims-by-parts": ["claims"],
    "no-sync": ["lanes"],
    "no-hidden-choice": ["hidden"],
    "equality": ["domain"],
    "forgetful": ["groups"],
    "longer": ["solve"],
}

# Too seldom in random plans to wait for.
BY_HAND = {"unordered-lanes"}

STARTER = """(define (domain guard)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions
                 :quantified-preconditions :conditional-effects :equality)
  (:types spot piece - thing)
  (:predicates (lit ?a - spot) (warm ?a - spot) (held ?b - piece) (count-on ?a - spot ?b - piece))
  (:action toggle :parameters (?p - spot) :precondition (and)
    :effect (and (when (lit ?p) (not (lit ?p))) (when (not (lit ?p)) (lit ?p))))
  (:action swap :parameters (?p - spot) :precondition (and)
    :effect (and (when (lit ?p) (warm ?p)) (when (warm ?p) (lit ?p)) (when (not (lit ?p)) (not (warm ?p)))
                 (when (not (warm ?p)) (not (lit ?p)))))
  (:action take :parameters (?b - piece) :precondition (not (held ?b)) :effect (held ?b))
  (:action leave :parameters (?b - piece) :precondition (held ?b) :effect (not (held ?b)))
  (:action both :parameters (?p - spot) :precondition (forall (?a - spot) (imply (not (= ?a ?p)) (lit ?a)))
    :effect (and (not (warm ?p)) (warm ?p))))
"""
STARTER_WORDS = """name = "guard"
about = "A domain for the simulator's own test."
[environment]
assets = "spot"
objects = "piece"
""" + "".join(
    f'[[predicate]]\nname = "{name}"\nsays = "{{a}} is {name}"\ndenies = "{{a}} is not {name}"\n'
    f'[[state]]\nword = "{name}()"\nfact = "({name} ?self)"\nmeans = "It is {name}."\n'
    for name in ("lit", "warm")
) + """[[predicate]]
name = "held"
says = "{b} is held"
denies = "{b} is not held"
[[state]]
word = "held()"
fact = "(held ?self)"
means = "It is held."
[[predicate]]
name = "count-on"
says = "{b} is on {a}"
denies = "{b} is not on {a}"
[[state]]
word = "count_on(<piece>)"
fact = "(count-on ?self ?piece)"
means = "It carries <piece>."
""" + "".join(
    f'[[action]]\nname = "{name}"\ncall = "{name}(?{letter})"\nsays = "{name} {{{letter}}}"\nmeans = "To {name}."\n'
    for name, letter in (("toggle", "p"), ("swap", "p"), ("take", "b"), ("leave", "b"), ("both", "p"))
) + """[[rule]]
name = "not-held"
holds = "always"
condition = "(forall (?b - piece) (not (held ?b)))"
says = "{b} must not be held"
[[rule]]
name = "as-before"
holds = "end"
condition = "(forall (?a - spot) (imply (initially (lit ?a)) (lit ?a)))"
says = "{a} must be lit again"
[[goal]]
form = "warmness({a})"
parameters = "?a - spot"
condition = "(warm ?a)"
subject = "?a"
says = "{a} is warm"
means = "To have it warm."
[[goal]]
form = "heldness({b})"
parameters = "?b - piece"
condition = "(held ?b)"
subject = "?b"
says = "{b} is held"
means = "To hold it."
"""


def call(text: str, **implicit: str) -> dict:
    """A step."""
    return {"call": text, **({"implicit": {name.rstrip("_"): value for name, value in implicit.items()}} if implicit else {})}


def environment(assets: list[str], objects: list[str], states: dict, properties: dict | None = None) -> dict:
    """An environment."""
    parts: dict = {"assets": assets, "objects": objects}
    for key, of in (("states", states), ("properties", properties or {})):
        parts[f"asset_{key}"] = {name: said for name, said in of.items() if name in assets}
        parts[f"object_{key}"] = {name: said for name, said in of.items() if name in objects}
    return parts


def fetch(to: str) -> list[dict]:
    """The milk from the table to another place, in the household."""
    return [
        call("move_hand()", to="<milk>"),
        call("grasp_object()", item="<milk>"),
        call("detach_from_plane()", item="<milk>", from_="<table>"),
        *put(to),
    ]


def put(to: str) -> list[dict]:
    """The milk, which is in the hand, down at a place."""
    return [
        call("move_object()", item="<milk>", to=to),
        call("attach_to_plane()", item="<milk>", to=to),
        call("release_object()", item="<milk>"),
    ]


KITCHEN = environment(["<table>", "<ledge>"], ["<milk>"], {"<milk>": ["on_something(<table>)"]})
LOOK = call("check_best_by_date()", item="<milk>")
HELD = [*fetch("<table>")[:3]]
AT_LEDGE = {"objects": ["<milk>"], "object_states": {"<milk>": ["on_something(<ledge>)"]}}
OLD_AT_LEDGE = {"objects": ["<milk>"], "object_states": {"<milk>": ["on_something(<ledge>)", "expired()"]}}
TABLE = environment(["<table>"], ["<sponge>"], {"<sponge>": ["on_something(<table>)"]})
WIPE = [call("move_hand()", to="<sponge>"), call("grasp_object()", item="<sponge>"),
        call("wipe_on_plane()", tool="<sponge>", place="<table>"), call("release_object()", item="<sponge>")]
SEE = call("check_cleanness()", thing="<table>")
AT_TABLE = call("move_hand()", to="<table>")
SPOTS = environment(["<gate>", "<kiosk>"], ["<drum>", "<lamp>"], {"<gate>": ["lit()"], "<drum>": ["held()"]})
TRAY = environment(["<table>"], ["<tray>", "<milk>"],
                   {"<tray>": ["on_something(<table>)"], "<milk>": ["on_something(<tray>)"]})
HANDS = environment(["<table>", "<ledge>"], ["<milk>", "<cup>"], {})
LEFT, RIGHT = call("move_hand(left)", to="<milk>"), call("move_hand(right)", to="<milk>")


def lanes(left: list[dict], right: list[dict]) -> list[dict]:
    """Two lanes."""
    return [{"parallel": [{"lane": "left", "do": left}, {"lane": "right", "do": right}]}]


def by_hand(folder: str) -> list[tuple[str, str, dict, list[dict], dict | None, bool]]:
    """Cases with the verdict that was worked out by hand: name, domain, world, plan, claim, valid."""
    checks, dual = "household-checks", "household-dual"
    branch = [*HELD, {"if": LOOK, "then": put("<table>"), "else": put("<ledge>")}]
    until_clean = {"while": {"not": SEE}, "do": [*WIPE, AT_TABLE]}
    return [
        ("a plain plan", "household", KITCHEN, fetch("<ledge>"), None, True),
        ("a step is missing", "household", KITCHEN, fetch("<ledge>")[1:], None, False),
        ("the hand is not empty at the end", "household", KITCHEN, HELD, None, False),
        ("a claim that is kept", "household", KITCHEN, fetch("<ledge>"), AT_LEDGE, True),
        ("a claim that is broken", "household", KITCHEN, fetch("<table>"), AT_LEDGE, False),
        ("both ways end well", checks, KITCHEN, branch, None, True),
        ("one ending keeps the claim", checks, KITCHEN, branch, AT_LEDGE, True),
        ("one way forgets to release", checks, KITCHEN, [*branch[:3], {"if": LOOK, "then": put("<table>")}], None, False),
        ("nothing has sensed what is asked", checks, KITCHEN, [{"if": call("fresh(<milk>)"), "then": []}, AT_TABLE], None, False),
        ("what decides comes first", checks, KITCHEN,
         [{"if": {"all": [call("on_something(<milk>, <ledge>)"), LOOK]}, "then": []}, AT_TABLE], None, True),
        ("sensing out of reach", checks, KITCHEN,
         [{"if": {"all": [call("on_something(<milk>, <table>)"), LOOK]}, "then": []}, AT_TABLE], None, False),
        ("a loop that sensing leaves", checks, environment(["<table>"], ["<sponge>"], TABLE["object_states"]),
         [AT_TABLE, until_clean], None, True),
        ("a loop that nothing leaves", checks, KITCHEN,
         [{"while": call("on_something(<milk>, <table>)"), "do": [AT_TABLE]}], None, False),
        ("a loop that is never entered", checks, KITCHEN,
         [{"while": call("on_something(<milk>, <ledge>)"), "do": [call("release_object()", item="<milk>")]}, AT_TABLE], None, True),
        ("an even number of turns", folder, SPOTS, [{"repeat": 1_000_000_000, "do": [call("toggle(<gate>)")]}], None, True),
        ("an odd number of turns", folder, SPOTS, [{"repeat": 999_999_999, "do": [call("toggle(<gate>)")]}], None, False),
        ("effects happen at once", folder, environment(["<gate>"], ["<drum>"], {"<gate>": ["warm()"]}),
         [call("swap(<gate>)"), call("swap(<gate>)")],
         {"assets": ["<gate>"], "asset_states": {"<gate>": ["lit()"]}}, False),
        ("added wins over deleted", folder, SPOTS, [call("both(<kiosk>)")],
         {"assets": ["<kiosk>"], "asset_states": {"<kiosk>": ["warm()"]}}, True),
        ("equality excludes one", folder, SPOTS, [call("both(<gate>)")], None, False),
        ("a rule broken at the start", folder, SPOTS, [call("swap(<kiosk>)"), call("leave(<drum>)")], None, True),
        ("a rule kept, then broken", folder, SPOTS, [call("leave(<drum>)"), call("take(<drum>)")], None, False),
        ("a rule broken for another thing", folder, SPOTS, [call("take(<lamp>)")], None, False),
        ("lanes apart", dual, HANDS, lanes([LEFT], [call("move_hand(right)", to="<cup>")]), None, True),
        ("lanes at one thing", dual, HANDS, lanes([LEFT], [RIGHT]), None, False),
        ("lanes one after the other", dual, HANDS,
         lanes([LEFT, {"sync": "a"}], [{"sync": "a"}, RIGHT]), None, True),
        ("lanes that wait for ever", dual, HANDS,
         lanes([{"sync": "a"}, {"sync": "b"}, LEFT], [{"sync": "b"}, {"sync": "a"}]), None, False),
        ("lanes whose order matters", dual, TRAY, [
            call("move_hand(left)", to="<tray>"), call("grasp_object(left)", item="<tray>"),
            *lanes([call("detach_from_plane(left)", item="<tray>", from_="<table>")],
                   [call("move_hand(right)", to="<milk>")]),
            call("move_object(left)", item="<tray>", to="<table>"),
            call("attach_to_plane(left)", item="<tray>", to="<table>"), call("release_object(left)", item="<tray>")], None, False),
        ("another hand's lane", dual, HANDS, lanes([RIGHT], []), None, False),
        ("hidden and possible", "household", KITCHEN, [call(text["call"]) for text in fetch("<ledge>")], AT_LEDGE, True),
        ("hidden and impossible", "household", KITCHEN, [call("grasp_object()"), call("release_object()")], None, False),
        ("two promises, two endings", checks, KITCHEN,
         [*HELD, {"if": LOOK, "then": put("<ledge>"), "else": put("<table>")}], OLD_AT_LEDGE, True),
    ]  # fmt: skip


# With `expired()` said, which only the ending with the milk on the table has: sensing brings nothing about, so it is no
# promise, and the place alone decides.


def searches(folder: str) -> list[tuple[str, str, dict, list, int | str]]:
    """Goals with the length of a shortest plan, worked out by hand."""
    both = [("warmness({a})", ("kiosk",))]
    return [
        ("one action makes it warm", folder, SPOTS, both, 1),
        ("held already, and the rule binds later", folder, SPOTS, [("heldness({b})", ("drum",)), *both], 1),
        ("the rule forbids it", folder, SPOTS, [("heldness({b})", ("lamp",))], search.UNSOLVABLE),
        ("put away", "household", KITCHEN, [("put({item}, {place})", ("milk", "ledge"))], 6),
    ]


def run_by_hand(program: Path, faults: frozenset = frozenset()) -> int:
    """Both against the verdicts that were worked out by hand; the number of failures, which a fault is to cause."""
    failures = 0
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "prompt").mkdir()
        for name, text in (("domain.pddl", STARTER), ("domain.toml", STARTER_WORDS),
                           ("prompt/goal.md", GOAL_PROMPT), ("prompt/examples.toml", EXAMPLES)):
            (Path(folder) / name).write_text(text)
        words.load.cache_clear()
        cases = []
        for name, domain, world, plan, claim, valid in by_hand(folder):
            file = {"task_cohesion": {"task_tree": plan}, **({"environment_after": claim} if claim else {})}
            cases.append((name, Case("tree", 0, domain, world, file), valid))
        for name, domain, world, goals, length in searches(folder):
            cases.append((name, Case("solve", 0, domain, world, goals=goals), isinstance(length, int)))
            own = search.shortest(cases[-1][1].world(faults), goals)
            if own != length:
                failures += 1
                faults or print(f"FAIL  {name}: {own} here, {length} by hand")
        answers = Judge(program).ask([case.request() for _, case, _ in cases])
        for (name, case, valid), answer in zip(cases, answers):
            comparison = compare(case, answer, faults)
            if comparison.difference is not None or comparison.valid != valid:
                failures += 1
                faults or print(f"FAIL  {name}: {comparison.difference or comparison}, by hand {'valid' if valid else 'invalid'}")
        faults or print(f"{len(cases)} cases worked out by hand, {failures} failures")
    return failures


def run_faults(arguments: argparse.Namespace, program: Path, seed: int, sample) -> int:
    """Each planted fault has to be found; the number of those that were not."""
    missed = 0
    for fault, means in FAULTS.items():
        if fault in BY_HAND:
            found = run_by_hand(program, frozenset([fault])) > 0
            missed += not found
            print(f"{'found ' if found else 'MISSED'}  {fault}: {means} (cases worked out by hand)", flush=True)
            continue
        chosen = argparse.Namespace(**{**vars(arguments), "classes": SHOWS_IN[fault], "cases": WITHIN})
        total = sample(chosen, program, seed, frozenset([fault]), stop=True)
        cases = sum(tally.cases for tally in total.values())
        found = any(tally.disagreements for tally in total.values())
        missed += not found
        print(f"{'found ' if found else 'MISSED'}  {fault}: {means} (within {cases} cases)", flush=True)
    for fault, means in task_machine.FAULTS.items():
        found = bool(task_compare.run(program, seed, TASKS, frozenset([fault]))["disagreements"])
        missed += not found
        print(f"{'found ' if found else 'MISSED'}  {fault}: {means} (within {TASKS} tasks)", flush=True)
    return missed
