#!/usr/bin/env python3
"""Random PDDL tasks with numbers and costs: our search and verifier against three others.

The first is in this file: a simulator and a search with costs, in plain Python, written from the pages on domains. The
second is ENHSP, a planner for numbers (a wheel of the Python package index and a Java runtime). The third is Fast Downward,
for costs without numbers.

    tools/peers/numeric_tasks.py --cases 2000            # a fresh sample against the simulator; its seed is printed
    tools/peers/numeric_tasks.py --enhsp --cases 100     # tasks that a planner with binary fractions reads exactly
    tools/peers/numeric_tasks.py --fast-downward --cases 100
"""

import argparse
import heapq
import itertools
import json
import random
import re
import secrets
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

import fast_downward
import wheels

ROOT = Path(__file__).resolve().parents[2]
ENHSP = wheels.Wheel(
    "up-enhsp",
    "0.1.1",
    "fecbacf8743f6851108aeb7d828cf202d8ef5e10d88a4bcafff3c12e59c1494c",
    "up_enhsp/ENHSP/",
)
OBJECTS = ("a", "b", "c")
MILLION = 10**6
# Millionths that a number holds at most.
MOST = 2**63 - 1
# States of one search of the simulator.
LIMIT = 3_000
# Seconds for a task of ENHSP, which does not stop where a number grows without bound.
ENHSP_SECONDS = 10
COMPARISONS = {
    "<": lambda left, right: left < right,
    "<=": lambda left, right: left <= right,
    "=": lambda left, right: left == right,
    ">=": lambda left, right: left >= right,
    ">": lambda left, right: left > right,
}


def nearest(value: Fraction) -> int:
    """The nearest whole number; halves go away from zero."""
    size = (2 * abs(value.numerator) + value.denominator) // (2 * value.denominator)
    return size if value >= 0 else -size


def decimal(millionths: int) -> str:
    """A number as PDDL writes it."""
    sign, size = ("-" if millionths < 0 else ""), abs(millionths)
    return f"{sign}{size // MILLION}.{size % MILLION:06}".rstrip("0").rstrip(".")


@dataclass
class Task:
    """A task as nested tuples. A number is in millionths; `level` and `charge` change, `rate` does not."""

    actions: list
    facts: frozenset
    numbers: dict
    goal: tuple
    costs: bool
    numeric: bool = True
    calls: list = field(default_factory=list)

    def __post_init__(self):
        self.calls = [(action, x) for action in self.actions for x in OBJECTS]

    def state(self):
        """The initial state: the facts, and the numbers that change."""
        return self.facts, frozenset((key, value) for key, value in self.numbers.items() if key[0] != "rate")

    def value(self, expression, numbers, bound):
        """The value of an expression in millionths; none if it is unknown."""
        match expression:
            case ("number", value):
                return value
            case ("fluent", name, *arguments):
                key = (name, *(bound.get(own, own) for own in arguments))
                return self.numbers.get(key) if name == "rate" else numbers.get(key)
            case (sign, left, right):
                left, right = self.value(left, numbers, bound), self.value(right, numbers, bound)
                if left is None or right is None or (sign == "/" and right == 0):
                    return None
                result = {
                    "+": lambda: left + right,
                    "-": lambda: left - right,
                    "*": lambda: nearest(Fraction(left * right, MILLION)),
                    "/": lambda: nearest(Fraction(left * MILLION, right)),
                }[sign]()
                return result if abs(result) <= MOST else None

    def holds(self, condition, facts, numbers, bound, positive=True):
        """The value of a condition, or of its negation: a comparison of unknown numbers is false either way."""
        again = lambda part, more=None: self.holds(part, facts, numbers, {**bound, **(more or {})}, positive)
        match condition:
            case ("and", *parts):
                return (all if positive else any)(again(part) for part in parts)
            case ("or", *parts):
                return (any if positive else all)(again(part) for part in parts)
            case ("not", inner):
                return self.holds(inner, facts, numbers, bound, not positive)
            case ("fact", name, argument):
                return ((name, bound.get(argument, argument)) in facts) == positive
            case ("each", inner):
                return (all if positive else any)(again(inner, {"?y": other}) for other in OBJECTS)
            case ("some", inner):
                return (any if positive else all)(again(inner, {"?y": other}) for other in OBJECTS)
            case ("compare", sign, left, right):
                left, right = self.value(left, numbers, bound), self.value(right, numbers, bound)
                return left is not None and right is not None and COMPARISONS[sign](left, right) == positive

    def cost(self, action, x):
        """The cost of a step in millionths; none if it is unknown."""
        if not self.costs:
            return MILLION
        return 0 if action["cost"] is None else self.value(action["cost"], {}, {"?x": x})

    def fire(self, effect, facts, numbers, bound, fired):
        """Collects the changes of an effect."""
        match effect:
            case ("when", condition, inner):
                if self.holds(condition, facts, numbers, bound):
                    self.fire(inner, facts, numbers, bound, fired)
            case ("each", inner):
                for other in OBJECTS:
                    self.fire(inner, facts, numbers, {**bound, "?y": other}, fired)
            case ("set", name, argument, holds):
                fired.append(("set", (name, bound.get(argument, argument)), holds))
            case (kind, ("fluent", name, *arguments), value):
                key = (name, *(bound.get(own, own) for own in arguments))
                fired.append((kind, key, self.value(value, numbers, bound)))

    def after(self, state, action, x):
        """The state after a step; none if it is not applicable."""
        facts, numbers = state[0], dict(state[1])
        bound = {"?x": x}
        if not self.holds(action["requires"], facts, numbers, bound) or self.cost(action, x) is None:
            return None
        fired = []
        for effect in action["effects"]:
            self.fire(effect, facts, numbers, bound, fired)
        changed = {key: [] for _, key, _ in fired}
        for kind, key, value in fired:
            changed[key].append((kind, value))
        facts, after = set(facts), dict(numbers)
        for key, all_changes in changed.items():
            if all_changes[0][0] == "set":
                (facts.add if any(holds for _, holds in all_changes) else facts.discard)(key)
                continue
            assigned = {value for kind, value in all_changes if kind == "assign"}
            moves = [(kind, value) for kind, value in all_changes if kind != "assign"]
            if any(value is None for _, value in all_changes) or len(assigned) > 1 or (assigned and moves):
                return None
            total = assigned.pop() if assigned else numbers.get(key)
            if total is None:
                return None
            total += sum(value if kind == "increase" else -value for kind, value in moves)
            if abs(total) > MOST:
                return None
            after[key] = total
        return frozenset(facts), frozenset(after.items())

    def best(self):
        """The least cost of a plan; none if there is no plan, `over` if the limit is reached."""
        start = self.state()
        order = itertools.count()
        queue, closed = [(0, next(order), start)], set()
        while queue:
            cost, _, state = heapq.heappop(queue)
            if self.holds(self.goal, state[0], dict(state[1]), {}):
                return cost
            if state in closed:
                continue
            closed.add(state)
            if len(closed) > LIMIT:
                return "over"
            for action, x in self.calls:
                following = self.after(state, action, x)
                if following is not None and following not in closed:
                    heapq.heappush(queue, (cost + self.cost(action, x), next(order), following))
        return None

    def replay(self, plan):
        """The number of the first step that is not applicable; none and the cost if the plan reaches the goal."""
        state, cost = self.state(), 0
        named = {action["name"]: action for action in self.actions}
        for number, (name, x) in enumerate(plan):
            state = self.after(state, named[name], x)
            if state is None:
                return number, None
            cost += self.cost(named[name], x)
        reached = self.holds(self.goal, state[0], dict(state[1]), {})
        return (None, cost) if reached else (len(plan), None)

    def domain(self):
        """The domain as PDDL."""
        # Fast Downward refuses the requirement of numbers.
        requirements = ":adl :numeric-fluents :action-costs" if self.numeric else ":adl :action-costs"
        functions = ["(level ?o) (rate ?o) (charge)"] * self.numeric + ["(total-cost)"] * self.costs
        lines = [
            f"(define (domain numbers) (:requirements {requirements})",
            f"(:constants {' '.join(OBJECTS)})",
            "(:predicates (p ?o) (q ?o))",
            *([f"(:functions {' '.join(functions)})"] if functions else []),
        ]
        for action in self.actions:
            effects = [text(effect) for effect in action["effects"]]
            if self.costs and action["cost"] is not None:
                effects.append(f"(increase (total-cost) {text(action['cost'])})")
            lines.append(f"(:action {action['name']} :parameters (?x)")
            lines.append(f" :precondition {text(action['requires'])}\n :effect (and {' '.join(effects)}))")
        return "\n".join(lines) + ")\n"

    def problem(self):
        """The problem as PDDL."""
        init = [f"({name} {argument})" for name, argument in sorted(self.facts)]
        init += [f"(= ({' '.join(key)}) {decimal(value)})" for key, value in sorted(self.numbers.items())]
        metric = "\n(:metric minimize (total-cost))" if self.costs else ""
        init += ["(= (total-cost) 0)"] if self.costs else []
        return f"(define (problem p) (:domain numbers)\n(:init {' '.join(init)})\n(:goal {text(self.goal)}){metric})\n"


def text(part) -> str:
    """A part of a task as PDDL."""
    match part:
        case ("number", value):
            return decimal(value)
        case ("fluent", *words):
            return f"({' '.join(words)})"
        case ("fact", name, argument):
            return f"({name} {argument})"
        # ENHSP reads no variable without a type in an effect.
        case ("each", inner):
            return f"(forall (?y - object) {text(inner)})"
        case ("some", inner):
            return f"(exists (?y - object) {text(inner)})"
        case ("compare", sign, left, right):
            return f"({sign} {text(left)} {text(right)})"
        case ("set", name, argument, holds):
            return f"({name} {argument})" if holds else f"(not ({name} {argument}))"
        case (head, *parts):
            return f"({head} {' '.join(text(part) for part in parts)})"


class Drawer:
    """Draws tasks. A plain task has no division, no unknown number and only quarters, which binary fractions hold."""

    def __init__(self, seed, plain=False, numeric=True):
        self.random = random.Random(seed)
        self.plain, self.numeric = plain, numeric

    def chance(self, count):
        """True once in `count` times."""
        return self.random.randrange(count) == 0

    def number(self):
        """A small number."""
        if self.chance(4):
            return self.random.randrange(-8, 13) * (MILLION // 4 if self.plain else MILLION // 10)
        return self.random.randrange(-3, 7) * MILLION

    def value(self, depth, scope):
        """An expression."""
        kind = self.random.randrange(5 if depth == 0 else 7)
        if kind >= 5:
            sign = self.random.choice("+-" if self.plain else "+-*/")
            return sign, self.value(depth - 1, scope), self.value(depth - 1, scope)
        if kind <= 1:
            return "fluent", "level", self.random.choice(scope)
        if kind == 2:
            return ("fluent", "charge")
        return ("fluent", "rate", self.random.choice(scope)) if kind == 3 else ("number", self.number())

    def condition(self, depth, scope):
        """A condition."""
        kind = self.random.randrange(4 if depth == 0 else 8)
        if kind == 0 or not self.numeric and kind < 4:
            return "fact", self.random.choice("pq"), self.random.choice(scope)
        if kind < 4:
            right = self.value(1, scope) if self.chance(3) else ("number", self.number())
            return "compare", self.random.choice(sorted(COMPARISONS)), self.value(0, scope), right
        parts = [self.condition(depth - 1, scope) for _ in range(self.random.randrange(1, 4))]
        if kind <= 5:
            return "and", *parts
        if kind == 6 or "?y" in scope:
            return ("not", parts[0]) if self.chance(2) else ("or", *parts)
        return self.random.choice(["each", "some"]), self.condition(depth - 1, [*scope, "?y", "?y"])

    def effect(self, depth, scope):
        """An effect."""
        kind = self.random.randrange(5 if depth == 0 else 7)
        if kind <= 1 or not self.numeric and kind < 5:
            return "set", self.random.choice("pq"), self.random.choice(scope), self.chance(2)
        if kind < 5:
            change = self.random.choice(["assign", "increase", "increase", "decrease", "decrease"])
            fluent = ("fluent", "charge") if self.chance(3) else ("fluent", "level", self.random.choice(scope))
            return change, fluent, self.value(1, scope) if self.chance(3) else ("number", self.number())
        if kind == 5:
            return "when", self.condition(1, scope), self.effect(0 if self.plain else depth - 1, scope)
        if "?y" in scope:
            return self.effect(depth - 1, scope)
        if self.plain:
            # ENHSP reads no change of a number under a quantifier.
            return "each", ("set", self.random.choice("pq"), "?y", self.chance(2))
        return "each", self.effect(depth - 1, [*scope, "?y", "?y"])

    def effects(self, scope):
        """The effects of an action."""
        effects = [self.effect(2, scope) for _ in range(self.random.randrange(1, 4))]
        kinds = [effect[-1][0] if effect[0] == "when" else effect[0] for effect in effects]
        changes = [kind for kind in kinds if kind in ("assign", "increase", "decrease")]
        if self.plain and len(changes) > 1:
            # Planners differ in what two assignments of one number mean.
            effects = [effect for effect, kind in zip(effects, kinds) if kind != "assign"]
        return effects or [("set", "p", "?x", True)]

    def task(self):
        """A task."""
        scope = ["?x", "?x", "a", "b"]
        costs = not self.numeric or self.chance(2)

        def cost():
            if self.chance(5):
                return None
            if self.numeric and self.chance(2):
                return "fluent", "rate", "?x"
            return "number", self.random.randrange(5) * (MILLION // 2 if self.numeric else MILLION)

        actions = [
            {
                "name": f"do{index}",
                "requires": self.condition(2, scope),
                "effects": self.effects(scope),
                "cost": cost(),
            }
            for index in range(self.random.randrange(1, 4))
        ]
        # A domain in which no action has a cost has none.
        costs = costs and any(action["cost"] is not None for action in actions)
        numbers = {}
        if self.numeric:
            for key in [("charge",), *(("level", own) for own in OBJECTS), *(("rate", own) for own in OBJECTS)]:
                if self.plain or not self.chance(10):
                    numbers[key] = abs(self.number()) if key[0] == "rate" else self.number()
        facts = frozenset((name, own) for name in "pq" for own in OBJECTS if self.chance(2))
        return Task(actions, facts, numbers, self.condition(2, ["a", "b", "c"]), costs, self.numeric)


def build() -> Path:
    """Builds the program that solves tasks."""
    command = ["cargo", "build", "--release", "--quiet", "-p", "longstep-peers", "--bin", "number_tasks"]
    subprocess.run(command, cwd=ROOT, check=True)
    target = json.loads(subprocess.check_output(["cargo", "metadata", "--format-version", "1", "--no-deps"], cwd=ROOT))
    return Path(target["target_directory"]) / "release" / "number_tasks"


def ask(program: Path, lines: list[str]) -> list[dict]:
    """Our answers to tasks."""
    done = subprocess.run([str(program)], input="\n".join(lines) + "\n", capture_output=True, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def steps_of(plan: str) -> list[tuple[str, str]]:
    """The steps of a plan, from lines such as `(do1 a)` with anything around them."""
    return [tuple(words.lower().split()) for words in re.findall(r"\(\s*(do\d+ +[abc])\s*\)", plan, re.IGNORECASE)]


def is_cost(found, expected) -> bool:
    """True if our cost, a decimal, is the number of millionths."""
    return found is not None and Fraction(found) * MILLION == expected


def against_simulator(task: Task, answer: dict, verdicts: list) -> str | None:
    """The difference between our answers and the simulator's; none if they agree."""
    for plan, verdict in verdicts:
        wrong, cost = task.replay(plan)
        inapplicable = wrong if wrong is not None and wrong < len(plan) else None
        if verdict.get("inapplicable") != inapplicable or verdict.get("valid") != (wrong is None):
            return f"verdict {verdict} on {plan}, and the simulator says {wrong}"
        if wrong is None and task.costs and not is_cost(verdict["cost"], cost):
            return f"verdict {verdict} on {plan}, which costs {cost}"
    if answer["outcome"] == "error":
        return answer["why"]
    best = task.best()
    if answer["outcome"] == "unsolvable" and best not in (None, "over"):
        return f"unsolvable, and there is a plan that costs {best}"
    if answer["outcome"] != "solved":
        return None
    plan = steps_of(answer["plan"])
    wrong, cost = task.replay(plan)
    if wrong is not None or not answer["valid"]:
        return f"the plan fails at step {wrong}: {plan}"
    if task.costs and not is_cost(answer["cost"], cost):
        return f"the plan costs {cost}, not {answer['cost']}"
    if best is None:
        return "solved, and there is no plan"
    if best != "over" and (cost < best or answer["best"] and cost != best):
        return f"the plan costs {cost}, and the best one {best}"
    return None


def enhsp(domain: Path, problem: Path) -> tuple[str, list]:
    """ENHSP's outcome and plan."""
    jar = wheels.fetch(ENHSP) / "enhsp.jar"
    command = ["java", "-jar", str(jar), "-o", str(domain), "-f", str(problem), "-planner", "sat-hadd"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=ENHSP_SECONDS)
    except subprocess.TimeoutExpired:
        return "gave_up", []
    shown = done.stdout + done.stderr
    if "Exception" in shown or "SEVERE" in shown:
        return "error", []
    if "Problem Solved" in shown:
        return "solved", steps_of(shown)
    if "unsolvable" in shown.lower():
        return "unsolvable", []
    return "gave_up", []


def against_planner(task: Task, answer: dict, outcome: str, plan: list, best_cost: bool) -> str | None:
    """The difference between our answer and another planner's; none if they agree."""
    ours = answer["outcome"]
    if {ours, outcome} == {"solved", "unsolvable"}:
        return f"ours: {ours}, the other: {outcome} {plan}"
    if outcome == "solved":
        wrong, cost = task.replay(plan)
        if wrong is not None:
            return f"the other's plan fails at step {wrong}: {plan}"
        # Without costs, both planners count steps.
        own = answer.get("cost") if task.costs else len(steps_of(answer.get("plan", "")))
        if ours == "solved" and best_cost and answer["best"] and not is_cost(own, cost):
            return f"ours costs {own}, the other {cost}"
    return None


def main() -> None:
    """Runs the command."""
    parser = argparse.ArgumentParser(description="Compares numbers and costs with others.")
    parser.add_argument("--cases", type=int, default=2000, help="how many [default: 2000]")
    parser.add_argument("--seed", type=int, help="what the sample is drawn from [default: a new one, printed]")
    parser.add_argument("--runner", type=Path, help="the built program `number_tasks` [default: build it]")
    parser.add_argument("--enhsp", action="store_true", help="compare with ENHSP instead of the simulator")
    parser.add_argument("--fast-downward", action="store_true", help="compare costs with Fast Downward instead")
    arguments = parser.parse_args()
    program = (arguments.runner or build()).resolve()
    seed = arguments.seed if arguments.seed is not None else secrets.randbelow(10**9)
    print(f"seed {seed}", flush=True)
    other = arguments.enhsp or arguments.fast_downward
    drawer = Drawer(seed, plain=arguments.enhsp, numeric=not arguments.fast_downward)
    counts: dict[str, int] = {}
    wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        for begin in range(0, arguments.cases, 100):
            tasks = [drawer.task() for _ in range(min(100, arguments.cases - begin))]
            lines, plans = [], []
            for number, task in enumerate(tasks):
                domain, problem = Path(folder) / f"d{number}.pddl", Path(folder) / f"p{number}.pddl"
                domain.write_text(task.domain())
                problem.write_text(task.problem())
                lines.append(f"{domain}\t{problem}")
                for trial in range(0 if other else 2):
                    plan = [(call["name"], x) for call, x in drawer.random.choices(task.calls, k=drawer.random.randrange(1, 6))]
                    path = Path(folder) / f"s{number}_{trial}"
                    path.write_text("".join(f"({name} {x})\n" for name, x in plan))
                    plans.append((number, plan, f"{domain}\t{problem}\t{path}"))
            answers = ask(program, lines)
            verdicts = ask(program, [line for *_, line in plans]) if plans else []
            for number, (task, answer) in enumerate(zip(tasks, answers)):
                domain, problem = lines[number].split("\t")
                counts[answer["outcome"]] = counts.get(answer["outcome"], 0) + 1
                if arguments.enhsp:
                    outcome, plan = enhsp(Path(domain), Path(problem))
                    counts[f"other {outcome}"] = counts.get(f"other {outcome}", 0) + 1
                    difference = against_planner(task, answer, outcome, plan, False)
                elif arguments.fast_downward:
                    found = fast_downward.solve(Path(domain), Path(problem), fast_downward.SHORTEST, 5)
                    counts[f"other {found.outcome}"] = counts.get(f"other {found.outcome}", 0) + 1
                    difference = against_planner(task, answer, found.outcome, steps_of(found.plan), True)
                else:
                    own = [(plan, verdict) for (of, plan, _), verdict in zip(plans, verdicts) if of == number]
                    difference = against_simulator(task, answer, own)
                if difference is not None:
                    wrong += 1
                    print(f"DISAGREE {difference}\n{task.domain()}{task.problem()}", flush=True)
    shown = ", ".join(f"{counts[key]} {key}" for key in sorted(counts))
    print(f"{arguments.cases} cases, {wrong} disagreements; {shown}; seed {seed}")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
