"""Comparison of both verdicts on one case, and the smallest case on which they still differ."""

import copy
from dataclasses import dataclass

from . import groups, hidden, order, plans, search
from .cases import Case
from .claims import kept
from .judge import Judge
from .plan import Bound, Plan, read
from .walk import OverBound, Result, Undecided, simulate
from .world import World

# Where one of these is amiss, the simulated rest is of no interest, and only the verdicts are compared.
SHAPES = {
    "unsensed", "endless_loop", "shared_object", "race", "wrong_actor", "lane_twice", "senses_in_lane", "deadlock",
    "not_sensing", "too_deep", "nothing_fits",
}  # fmt: skip
# The program's own bounds, at which it gives no verdict.
BOUNDS = {"too_many_states", "too_much_work"}


@dataclass
class Comparison:
    """What came of comparing: the same, a difference in words, or a case over the bound of one of the two.

    A binding is missed where a tree has hidden arguments with which it is valid, and the program found others. The page
    on branching says that this can happen, so it is counted and is no difference.
    """

    difference: str | None = None
    over: bool = False
    valid: bool = False
    missed: bool = False


def compare(case: Case, answer: dict, faults: frozenset = frozenset()) -> Comparison:
    """Compares what the program answered with what the simulator says; a crash of either is a difference."""
    try:
        return compared(case, answer, faults)
    except Exception as error:
        return Comparison(f"crash here: {error!r}")


def compared(case: Case, answer: dict, faults: frozenset) -> Comparison:
    """The comparison, unless the simulator stops."""
    if "crash" in answer:
        return Comparison(f"crash: {answer['crash']}")
    if "can hold in no state" in answer.get("error", ""):
        # A constraint that forbids nothing is refused.
        return Comparison(over=True)
    if case.kind == "groups":
        try:
            case = groups.expanded(case.world(faults), case)
        except groups.Refused:
            return Comparison(None if "error" in answer else f"groups: {answer['status']} there, an error here")
    if "error" in answer:
        return Comparison(f"cannot be read: {answer['error']}")
    world = case.world(faults)
    try:
        return compare_search(case, world, answer) if case.goals else Verdict(case, world, answer).compare()
    except OverBound:
        return Comparison(over=True, valid=answer.get("status") == "verified")


def compare_search(case: Case, world: World, answer: dict) -> Comparison:
    """Compares the length of a shortest plan, and simulates the one that was found."""
    status, flags = answer["status"], answer.get("stages", [])
    if (flags or case.stages) and len(flags) != len(case.goals):
        return Comparison(f"goals: {len(flags)} there, {len(case.goals)} here")
    if case.kind in ("order", "groups"):
        own = order.shortest(world, case, flags)
    else:
        own = search.shortest(world, case.goals)
    if own == search.OVER or status == "gave_up":
        return Comparison(over=True)
    theirs = len(answer["steps"]) if status == "verified" else status
    told = answer.get("search") or {}
    if status == "verified" and isinstance(own, int) and told.get("shortest") is False:
        # The search says itself how much shorter a plan may be.
        if not told["at_least"] <= own <= theirs:
            return Comparison(f"search: {told['at_least']} to {theirs} there, {own} here")
    elif own != theirs:
        return Comparison(f"search: {theirs} there, {own} here")
    if status == "verified" and own:
        plan = read({"task_cohesion": flat_of(answer)}, world)
        result = simulate(plan, world, arguments_of(plan, answer))
        if case.kind in ("order", "groups") and not order.fulfilled(world, case, answer):
            return Comparison("search: the plan that was found does not keep the order or a constraint")
        wrong = {violation for violation in result.violations if violation != ("rule", None)}
        if wrong:
            return Comparison(f"search: the plan that was found cannot be done: {sorted(map(str, wrong))}")
    return Comparison(valid=status == "verified")


def flat_of(answer: dict) -> dict:
    """The plan of an answer as a list of calls without what they hide."""
    return {"task_sequence": [f"{step['action']}({', '.join(step['arguments'])})" for step in answer["steps"]]}


def arguments_of(plan: Plan, answer: dict) -> dict[int, tuple[str, ...]]:
    """The arguments that the program found for steps that leave some open."""
    found = {}
    for step, told in zip(plan.steps, answer["steps"]):
        if step is None or not step.open:
            continue
        implicit = dict(told["implicit"])
        if "object" in implicit and step.call.object:
            implicit[step.call.object[1:]] = implicit.pop("object")
        values = []
        for (name, _), choices in zip(step.call.action.parameters, step.choices):
            value = implicit.get(name[1:])
            values.append(value.strip("<>") if value else choices[0] if len(choices) == 1 else None)
        if None not in values:
            found[step.number] = tuple(values)
    return found


class Verdict:
    """The comparison for a plan."""

    def __init__(self, case: Case, world: World, answer: dict):
        self.case, self.world, self.answer = case, world, answer
        self.after = case.file.get("environment_after")
        self.theirs = answer["status"] == "verified"
        self.plan = read(case.file, world)
        kinds = {violation["kind"] for violation in answer["violations"]}
        self.told = {
            (violation["kind"], None if violation["step"] is None else violation["step"] + 1)
            for violation in answer["violations"]
        }
        self.shapes = bool(kinds & SHAPES)
        self.bounded = bool(kinds & BOUNDS)

    def compare(self) -> Comparison:
        """Compares validity, what is wrong where, and the endings."""
        if self.plan.issues:
            return self.decided(False, f"words: {sorted(set(self.plan.issues))}")
        if self.answer["status"] not in ("verified", "invalid"):
            return Comparison(f"status {self.answer['status']}")
        if self.bounded:
            return Comparison(over=True)
        if not any(step.open for step in self.plan.steps):
            return self.with_arguments({})
        arguments = arguments_of(self.plan, self.answer)
        if not self.theirs:
            found = hidden.find(self.plan, self.world, self.after)
            if found is not None and any(node[0] != "step" for node in self.plan.nodes):
                return Comparison(missed=True)
            if found is not None:
                told = {number: " ".join(values) for number, values in found.items()}
                return Comparison(f"invalid there, and valid here with {told}: {self.messages()}")
            return Comparison()
        comparison = self.with_arguments(arguments)
        if comparison.valid and not self.found_here():
            # Else the search could be blind, and agree on every plan that is called invalid.
            return Comparison("valid there and here, but trying all arguments finds none")
        return comparison

    def found_here(self) -> bool:
        """True if trying all arguments finds some, or gives up."""
        try:
            return hidden.find(self.plan, self.world, self.after) is not None
        except OverBound:
            return True

    def messages(self) -> str:
        """What the program says is wrong."""
        return "; ".join(violation["message"] for violation in self.answer["violations"]) or "nothing is wrong"

    def decided(self, own: bool, why: str) -> Comparison:
        """Compares validity alone."""
        if own != self.theirs:
            said = {True: "valid", False: "invalid"}
            return Comparison(f"{said[self.theirs]} there, {said[own]} here ({why}); there: {self.messages()}")
        return Comparison(valid=own)

    def with_arguments(self, arguments: dict) -> Comparison:
        """Compares everything, with the arguments that the program found."""
        try:
            result = simulate(self.plan, self.world, arguments)
        except Undecided as undecided:
            return Comparison(f"step {undecided.step.number} is reached and has no arguments there")
        told = kept(Bound(self.plan, self.world, arguments), self.after, result.endings)
        own = set(result.violations) | (set() if told else {("claim", None)})
        validity = self.decided(not own, f"here: {sorted(map(str, own))}")
        if validity.difference:
            return validity
        if self.shapes or any(kind in SHAPES for kind, _ in own):
            return validity
        for difference in (self.steps_differ(own), self.endings_differ(result)):
            if difference:
                return Comparison(difference)
        return validity

    def steps_differ(self, own: set) -> str | None:
        """What is wrong where: each kind of violation at each step."""
        mine = {(kind, step) for kind, step in own if kind in ("precondition", "rule", "claim")}
        theirs = {(kind, step) for kind, step in self.told if kind in ("precondition", "rule", "claim")}
        if mine != theirs:
            return f"violations differ: there {sorted(map(str, theirs))}, here {sorted(map(str, mine))}"
        return None

    def endings_differ(self, result: Result) -> str | None:
        """The worlds after the plan, as environments can say them."""
        if "endings" not in self.answer:
            return None if self.shapes else "the answer has no endings"
        theirs = set()
        for ending in self.answer["endings"]:
            after = World(self.world.words, ending["after"], self.world.faults)
            theirs.add(after.written(after.initial))
        mine = {self.world.written(state) for state in result.endings}
        if mine == theirs:
            return None
        return f"endings differ: only there {facts(theirs - mine)}, only here {facts(mine - theirs)}"


def facts(worlds: set) -> list[str]:
    """Worlds in words that can be read."""
    return sorted(", ".join(" ".join(fact) for fact in sorted(world)) for world in worlds)


# --- the smallest case ------------------------------------------------------------------------------------------


def smaller(case: Case) -> list[Case]:
    """Cases with one thing less."""
    found = []
    cohesion = case.file.get("task_cohesion", {})
    if "task_sequence" in cohesion:
        for place in range(len(cohesion["task_sequence"])):
            made = case.changed()
            del made.file["task_cohesion"]["task_sequence"][place]
            found.append(made)
    if "task_tree" in cohesion:
        found += smaller_trees(case)
    if case.script:
        found.append(case.changed(script=False))
    if len(case.goals) > 1:
        found += [case.changed(goals=[goal], stages=[]) for goal in case.goals]
    after = case.file.get("environment_after")
    if after is not None:
        made = case.changed()
        del made.file["environment_after"]
        found.append(made)
    for of in (case.environment, after):
        if of is not None:
            found += smaller_environments(case, of is after)
    return found


def smaller_trees(case: Case) -> list[Case]:
    """Cases in whose tree one node is gone, or its inside stands in its place."""
    found = []
    for number, part in enumerate(plans.blocks(case.file["task_cohesion"]["task_tree"])):
        for place in range(len(part)):
            made = case.changed()
            mine = plans.blocks(made.file["task_cohesion"]["task_tree"])[number]
            inner = [mine[place][key] for key in ("then", "else", "do") if key in mine[place]]
            del mine[place]
            found.append(made)
            for body in inner:
                made = case.changed()
                mine = plans.blocks(made.file["task_cohesion"]["task_tree"])[number]
                mine[place : place + 1] = copy.deepcopy(body)
                found.append(made)
            for condition in conditions_below(part[place]):
                made = case.changed()
                mine = plans.blocks(made.file["task_cohesion"]["task_tree"])[number][place]
                mine["if" if "if" in mine else "while"] = copy.deepcopy(condition)
                found.append(made)
    return found


def conditions_below(node: dict) -> list[dict]:
    """The conditions that are parts of a node's condition."""
    condition = node.get("if", node.get("while"))
    if condition is None or "call" in condition:
        return []
    return [condition["not"]] if "not" in condition else condition.get("all", condition.get("any", []))


def smaller_environments(case: Case, of_claim: bool) -> list[Case]:
    """Cases in whose environment, or claim, one word or one entity is gone."""
    found = []

    def environment(made: Case) -> dict:
        return made.file["environment_after"] if of_claim else made.environment

    source = environment(case)
    for key in ("asset_states", "object_states", "asset_properties", "object_properties"):
        for name, entry in source.get(key, {}).items():
            for place in range(len(entry)):
                made = case.changed()
                del environment(made)[key][name][place]
                if not environment(made)[key][name]:
                    del environment(made)[key][name]
                found.append(made)
    if not of_claim:
        text = str(case.file) + str(case.goals) + str(case.constraints) + str(source)
        for key in ("assets", "objects"):
            for name in source[key]:
                if text.count(name.strip("<>")) == 1:
                    made = case.changed()
                    made.environment[key].remove(name)
                    found.append(made)
    return found


def shrink(case: Case, judge: Judge, faults: frozenset, sort: str, rounds: int = 60) -> tuple[Case, str]:
    """The smallest case found that still differs in the same way, and how."""
    difference = sort
    for _ in range(rounds):
        candidates = [made for made in smaller(case) if is_usable(made)]
        if not candidates:
            break
        for made, answer in zip(candidates, judge.ask([candidate.request() for candidate in candidates])):
            again = compare(made, answer, faults).difference
            if again is not None and kind_of(again) == kind_of(sort):
                case, difference = made, again
                break
        else:
            break
    return case, difference


def is_usable(case: Case) -> bool:
    """False for a case that cannot be written, that starts in a broken state, or in which nothing is left."""
    try:
        case.request()
        return not starts_broken(case) and bool(case.goals or has_steps(case))
    except (LookupError, ValueError):
        return False


def has_steps(case: Case) -> bool:
    """False for a plan in which nothing is left."""
    return any(case.file["task_cohesion"].get(key) for key in ("task_sequence", "task_tree"))


def starts_broken(case: Case) -> bool:
    """True if the environment contradicts itself."""
    world = case.world()
    return bool(world.broken("start", world.initial))


def kind_of(difference: str) -> str:
    """The sort of a difference: its words without particulars."""
    return difference.split("(")[0].split(":")[0].split("with")[0]
