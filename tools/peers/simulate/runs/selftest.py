"""Tests of the judge itself: runs written by hand, one that it has to accept and one for each verdict that it has to give."""

import copy
import json
import tempfile
from pathlib import Path

from .. import words
from ..domains import EXAMPLES, GOAL_PROMPT
from . import ending
from .judge import Judge, Settings
from .make import Entries
from .purpose import Constraint, Purpose, Wanted
from .world import NumberWorld

DOMAIN = """(define (domain made)
  (:requirements :strips :typing :negative-preconditions :conditional-effects :numeric-fluents)
  (:types spot piece - thing)
  (:predicates (lit ?a - spot) (held ?b - piece) (rung ?a - spot) (poised ?a - spot))
  (:functions (level ?a - spot))
  (:action light :parameters (?p - spot) :precondition (not (lit ?p)) :effect (and (lit ?p) (poised ?p)))
  (:action dim :parameters (?p - spot) :precondition (lit ?p) :effect (not (lit ?p)))
  (:action fill :parameters (?p - spot) :precondition (lit ?p) :effect (increase (level ?p) 1))
  (:action ring :parameters (?p - spot) :precondition (and) :effect (rung ?p))
  (:action take :parameters (?b - piece) :precondition (not (held ?b)) :effect (held ?b)))
"""
WORDS = """name = "made"
about = "A domain for the judge's own test."
[environment]
assets = "spot"
objects = "piece"
""" + "".join(
    f'[[predicate]]\nname = "{name}"\nsays = "{{{letter}}} is {name}"\ndenies = "{{{letter}}} is not {name}"\n{more}'
    for name, letter, more in (("lit", "a", ""), ("held", "b", ""), ("rung", "a", "event = true\n"), ("poised", "a", ""))
) + "".join(
    f'[[state]]\nword = "{name}()"\nfact = "({name} ?self)"\nmeans = "It is {name}."\n' for name in ("lit", "held")
) + """[[number]]
name = "level"
says = "the level of {a}"
min = 0
max = 3
""" + "".join(
    f'[[action]]\nname = "{name}"\ncall = "{name}(?{letter})"\nsays = "{name} {{{letter}}}"\nmeans = "To {name}."\n{more}'
    for name, letter, more in (("light", "p", ""), ("dim", "p", ""), ("fill", "p", "retries = 1\n"), ("ring", "p", ""), ("take", "b", ""))
) + """[[goal]]
form = "litness({a})"
parameters = "?a - spot"
condition = "(lit ?a)"
subject = "?a"
says = "{a} is lit"
means = "To have it lit."
"""
ENVIRONMENT = {
    "assets": ["<gate>", "<kiosk>"],
    "asset_states": {"<gate>": ["level(0)"], "<kiosk>": ["level(2)"]},
    "objects": ["<drum>"],
    "object_states": {},
}
HASH = "0123456789abcdef0123456789abcdef"


def world() -> tuple[NumberWorld, Entries]:
    """The world of the test."""
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "prompt").mkdir()
        for name, text in (("domain.pddl", DOMAIN), ("domain.toml", WORDS), ("prompt/goal.md", GOAL_PROMPT), ("prompt/examples.toml", EXAMPLES)):
            (Path(folder) / name).write_text(text)
        own = NumberWorld(words.read(DOMAIN, WORDS), ENVIRONMENT)
        return own, Entries(own)


def seen(gate: list[str], kiosk: list[str] = ("level(2)",), drum: list[str] = ()) -> dict:
    """An observation of all entities."""
    states = {"<gate>": list(gate), "<kiosk>": list(kiosk), "<drum>": list(drum)}
    return {"event": "observed", "statements": {"states": states}}


def ordered(order: int, step: int, call: str) -> dict:
    """An order."""
    return {"event": "ordered", "order": order, "step": step, "call": call, "explanation": ""}


def performed(order: int) -> dict:
    """The end of an order."""
    return {"event": "performed", "order": order}


def failed(order: int) -> dict:
    """An order that failed."""
    return {"event": "failed", "order": order, "why": ""}


def stopped(why: str, proven: bool = False) -> dict:
    """A stop."""
    return {"event": "stopped", "why": why, "proven": proven, "under_way": [], "environment": {}}


BEGAN = {"event": "began", "format": 3, "approval": "never", "watch": "each-step", "trust": "observed", "changes": 8}
DONE = {"event": "done", "environment": {}, "unseen": []}
LIT, FULL = ["lit()", "level(0)"], ["lit()", "level(1)"]
GOOD = [
    BEGAN,
    seen(["level(0)"]),
    ordered(1, 1, "light(<gate>)"),
    performed(1),
    seen(LIT),
    ordered(2, 2, "fill(<gate>)"),
    performed(2),
    seen(FULL),
    DONE,
]


class Bench:
    """The judge of one run of the test."""

    def __init__(self, **settings):
        self.world, entries = world()
        lit = Wanted("litness(gate)", ("is", ("lit", "gate")))
        full = Wanted("level(gate) = 1", ("compares", ("=", ("fluent", ("level", "gate")), ("number", 1_000_000))))
        self.purpose = Purpose(self.world, [[lit], [full]], [])
        plan = [self.world.action("light", ("gate",)), self.world.action("fill", ("gate",))]
        self.judge = Judge(self.world, entries, self.purpose, plan, Settings(**{"approval": "never", **settings}), set())

    def run(self, events: list) -> list[str]:
        """The verdicts after events; a function among them is called with the judge."""
        for event in events:
            if callable(event):
                event(self.judge)
            else:
                self.judge.event(copy.deepcopy(event))
        return self.judge.verdicts


def constrained(*constraints: Constraint):
    """Adds constraints to the purpose."""

    def add(judge: Judge) -> None:
        judge.purpose.constraints = list(constraints)
        judge.purpose.__dict__.pop("kept", None)

    return add


def without(*places: int) -> list:
    """The good run without some events."""
    return [event for place, event in enumerate(GOOD) if place not in places]


def with_event(place: int, event) -> list:
    """The good run with another event at a place."""
    return [*GOOD[:place], event, *GOOD[place + 1 :]]


def proposing(subject: str, answer, call: str | None = None):
    """A person decides."""
    return lambda judge: judge.propose({"id": HASH, "subject": subject, "call": call}, answer)


APPROVED = {"event": "approved", "proposal": HASH}
CHANGED = {"event": "changed", "kind": "repaired", "steps": [], "plan": [{"call": "take(<drum>)"}]}
NEVER_LIT = Constraint("never", "never litness(gate)", condition=("is", ("lit", "gate")))


def wrong_runs() -> list[tuple[str, dict, list]]:
    """Verdict, settings and events of each run that the judge has to reject."""
    interrupted = {"event": "interrupted", "under_way": [2]}
    return [
        ("false done", {}, [*GOOD[:7], seen(["lit()", "level(0)"]), DONE]),
        ("false done", {}, [*GOOD[:7], {"event": "observed", "statements": {"states": {}}}, DONE]),
        ("done without a look", {}, [*GOOD[:7], DONE]),
        ("done with an order under way", {}, [*GOOD[:6], DONE]),
        ("precondition", {}, [*GOOD[:4], seen(["level(0)"]), *GOOD[5:]]),
        ("a step is left out", {}, [*GOOD[:2], ordered(1, 2, "fill(<gate>)")]),
        ("a step is repeated", {}, [*GOOD[:5], ordered(2, 1, "light(<gate>)")]),
        ("a step is repeated more often than its retries", {}, repeated()),
        ("a step that failed more often than its retries", {}, failing()),
        ("a step that is not in the plan in force", {}, with_event(5, ordered(2, 2, "ring(<gate>)"))),
        ("an order without a look", {}, without(4)),
        ("an order without a look", {"watch": "on-failure"}, [*GOOD[:3], failed(1), ordered(2, 1, "light(<gate>)")]),
        ("an order while another is under way", {}, [*GOOD[:3], seen(LIT), ordered(2, 2, "fill(<gate>)")]),
        ("order number", {}, with_event(2, ordered(7, 1, "light(<gate>)"))),
        ("unapproved", {"approval": "changes"}, GOOD),
        ("unapproved", {}, [*GOOD[:5], settled("changes"), {**interrupted, "under_way": [], "approval": "changes"}, *GOOD[4:6]]),
        ("unapproved", {"approval": "changes"}, [proposing("plan", True), APPROVED, *GOOD[:5], CHANGED, ordered(2, 1, "take(<drum>)")]),
        ("unapproved step", {"approval": "each-step"}, [proposing("plan", True), APPROVED, *GOOD]),
        ("approval that no person gave", {"approval": "changes"}, [proposing("plan", None), APPROVED]),
        ("approval that no person gave", {"approval": "changes"}, [proposing("plan", True), {**APPROVED, "proposal": "f" * 32}]),
        ("refusal that no person gave", {"approval": "changes"}, [proposing("plan", True), {"event": "refused"}]),
        ("asked although nobody decides", {}, [proposing("plan", True)]),
        ("asked about a step", {"approval": "changes"}, [proposing("step", True, "light(<gate>)")]),
        ("forbidden", {}, [constrained(NEVER_LIT), *GOOD]),
        ("forbidden", {}, [constrained(Constraint("untouched", "untouched(gate)", entity="gate")), *GOOD]),
        ("forbidden", {}, [constrained(Constraint("never", "never fill(_)", call=("fill", ("_",)))), *GOOD]),
        ("event after the end", {}, [*GOOD, seen(FULL)]),
        ("another environment at the end", {}, [*GOOD[:8], {**DONE, "environment": {**ENVIRONMENT, "asset_states": {"<gate>": ["level(1)"]}}}]),
        ("unknown event", {}, [BEGAN, {"event": "hoped"}]),
        ("another setting in the log", {}, with_event(0, {**BEGAN, "approval": "each-step"})),
        ("another observation in the log", {}, [looked(seen(LIT)), *GOOD]),
        ("the end of an order that is not under way", {}, [*GOOD[:4], performed(1)]),
        ("harmless, but the rest is not valid", {}, [*GOOD[:5], {"event": "assessed", "effect": "harmless", "because": []}][:4] + [seen(["level(0)"]), {"event": "assessed", "effect": "harmless", "because": []}]),
        ("helpful, but the rest is not valid", {}, [*GOOD[:2], {"event": "assessed", "effect": "helpful", "because": [], "steps": ["light"]}]),
        ("changed, but the rest is not valid", {}, [*GOOD[:5], CHANGED]),
        ("too many changes", {"changes": 0}, [*GOOD[:5], CHANGED]),
        ("other orders under way", {}, [*GOOD[:6], {**interrupted, "under_way": []}]),
        ("found an order that is not unknown", {}, [*GOOD[:8], {"event": "found", "order": 2}]),
        ("found, but not all effects are seen", {}, [*GOOD[:6], interrupted, seen(LIT), {"event": "found", "order": 2}]),
        ("a word about an order that is not unknown", {}, [*GOOD[:8], {"event": "judged", "order": 2, "done": True}]),
        ("another word than the person's", {}, [*GOOD[:6], interrupted, seen(LIT), {"event": "judged", "order": 2, "done": True}]),
        ("a plan exists", {}, [*GOOD[:2], stopped(ending.NO_PLAN, True)]),
        ("no constraint is broken", {}, [*GOOD[:2], stopped("a constraint no longer holds (x): ", True)]),
        ("the log ends otherwise", {}, [*GOOD, ends("requested", "signal")]),
        ("a stop without a cause", {}, [*GOOD[:2], stopped("stopped at a request"), ends("requested")]),
        ("a stop without a cause", {}, [*GOOD[:2], stopped("too many"), ends("too-many-changes")]),
        ("an order that the log does not have", {}, [*GOOD[:2], lambda judge: judge.started(judge.plan[0], False)]),
        ("an order after a stop", {}, [*GOOD[:3], lambda judge: judge.started(judge.plan[0], True)]),
    ]  # fmt: skip


BLIND = {"event": "observed", "statements": {"states": {}}}
SEEN_LIT = {"what": "the gate is lit", "basis": "seen", "order": 1}
PROMISED_FULL = {"what": "the level of the gate is 1", "basis": "promised", "order": 2}
TRUSTING = {"trust": "promised"}
CONFIRMED = {"event": "confirmed", "what": "the level of the gate is 1", "holds": True}


def blind(*unseen: dict) -> list:
    """The good run with a last look that shows nothing, and what `done` lists."""
    return [{**BEGAN, "trust": "promised"}, *GOOD[1:7], BLIND, {**DONE, "unseen": list(unseen)}]


def confirming(what: str, holds: bool):
    """A person says whether something is so."""

    def tell(judge: Judge) -> None:
        judge.confirming = (what, holds)

    return tell


def asked(holds: bool, *more: dict) -> list:
    """A run in which a person is asked about what nobody has seen."""
    what = CONFIRMED["what"]
    began = {**BEGAN, "approval": "changes"}
    approved = [began, GOOD[1], proposing("plan", True), APPROVED]
    return [*approved, *GOOD[2:7], BLIND, confirming(what, holds), {**CONFIRMED, "holds": holds}, *more]


def right_runs() -> list[tuple[dict, list]]:
    """Settings and events of runs that the judge has to accept."""
    changes = {"approval": "changes"}
    return [
        ({}, [*GOOD, ends(None)]),
        (TRUSTING, blind(SEEN_LIT, PROMISED_FULL)),
        (changes, asked(True, {**DONE, "unseen": [SEEN_LIT]})),
        (changes, asked(False, stopped("a person says that this is not so: the level of the gate is 1"), ends("unseen", "denies"))),
        ({}, [*GOOD[:7], BLIND, stopped("not observed: promised by step 2, not seen since: the level of the gate is 1")]),
    ]  # fmt: skip


def unseen_runs() -> list[tuple[str, dict, list]]:
    """Wrong runs about what no look has shown."""
    changes, observed = {"approval": "changes"}, lambda events: [BEGAN, *events[1:]]
    trusting = {**BEGAN, "trust": "promised"}
    return [
        ("false done", TRUSTING, blind(SEEN_LIT)),
        ("false done", changes, asked(True, DONE)),
        ("another basis", TRUSTING, blind(SEEN_LIT, {**PROMISED_FULL, "basis": "seen"})),
        ("another basis", TRUSTING, blind({**SEEN_LIT, "order": 2}, PROMISED_FULL)),
        ("another basis", TRUSTING, blind({**SEEN_LIT, "basis": "word"}, PROMISED_FULL)),
        ("listed as unseen and not believed", TRUSTING, blind({**SEEN_LIT, "what": "the gate is not lit"}, PROMISED_FULL)),
        ("listed as unseen although the last looks show it", TRUSTING, [trusting, *GOOD[1:8], {**DONE, "unseen": [SEEN_LIT]}]),
        ("a sentence without a meaning", TRUSTING, blind({**SEEN_LIT, "what": "the gate sings"})),
        ("a promise is trusted", {}, observed(blind(SEEN_LIT, PROMISED_FULL))),
        ("a promise is trusted", {}, [*GOOD[:7], {"event": "trusted", "unseen": [PROMISED_FULL]}]),
        ("asked about a promise", {}, [*GOOD[:7], BLIND, confirming(CONFIRMED["what"], True), CONFIRMED]),
        ("asked about a promise", {**changes, **TRUSTING}, asked(True)),
        ("asked about something else than an open promise", changes, [*asked(True)[:-4], GOOD[7], *asked(True)[-2:]]),
        ("another word than the person's", changes, [*asked(True)[:-2], CONFIRMED]),
        ("done although a person says that it is not so", changes, asked(False, DONE)),
        ("a stop for a promise that is trusted", TRUSTING, [trusting, *GOOD[1:7], BLIND, stopped(ending.NOT_SEEN + "x")]),
        ("stopped for a fact that was not seen, and all are seen", {}, [*GOOD[:8], stopped(ending.NOT_SEEN + "x")]),
        ("another setting in the log", {}, [*GOOD[:5], settled("each-step"), {"event": "interrupted", "under_way": []}]),
    ]  # fmt: skip


def repeated() -> list:
    """A step with one retry whose effect is undone twice."""
    undone = {"event": "assessed", "effect": "undone", "because": [], "steps": ["fill"]}
    turn = [seen(LIT), undone]
    return [
        *GOOD[:7], *turn, ordered(3, 1, "fill(<gate>)"), performed(3), *turn, ordered(4, 1, "fill(<gate>)"),
    ]  # fmt: skip


def failing() -> list:
    """A step with one retry that fails twice."""
    return [*GOOD[:6], failed(2), seen(LIT), ordered(3, 2, "fill(<gate>)"), failed(3), seen(LIT), ordered(4, 2, "fill(<gate>)")]


def settled(approval: str):
    """The run is taken up with another approval."""
    return lambda judge: judge.resumes(Settings(approval=approval))


def looked(event: dict):
    """The robot's last look."""

    def tell(judge: Judge) -> None:
        judge.last_look = event["statements"]

    return tell


def ends(stop: str | None, *given: str):
    """The end that the interface returns."""
    return lambda judge: ending.check_end(judge, {"stop": stop, "why": ""}, set(given))


def run() -> int:
    """The number of failures."""
    failures = 0
    right = right_runs()
    for settings, events in right:
        verdicts = Bench(**settings).run(events)
        if verdicts:
            failures += 1
            print(f"FAIL  a right run is blamed: {verdicts}")
    cases = wrong_runs() + unseen_runs()
    for number, (verdict, settings, events) in enumerate(cases, 1):
        found = Bench(**settings).run(events)
        if not any(own.split(":")[0] == verdict for own in found):
            failures += 1
            print(f"FAIL  {number} has to be blamed for `{verdict}`, and is blamed for {json.dumps(found)}")
    kinds = len({verdict for verdict, _, _ in cases})
    print(f"{len(cases)} wrong runs of {kinds} kinds and {len(right)} right ones, {failures} failures")
    return failures
