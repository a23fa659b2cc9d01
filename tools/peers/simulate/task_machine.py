"""The meaning of a planning task, and the least cost of a plan by Dijkstra's algorithm, written from PDDL's semantics,
docs/reference/domains.md and docs/reference/goals.md."""

import heapq
import itertools
from functools import cached_property

from .order import Progress
from .tasks import Action, Task

# States of one search.
LIMIT = 6_000
UNSOLVABLE, OVER = "unsolvable", "over"
# Semantics that are wrong on purpose, for the self-test.
FAULTS = {
    "delete-wins": "an effect that adds and deletes one fact leaves it false",
    "no-free-step": "a step without a cost costs 1",
    "one-change": "of several changes of one number only the last one counts",
}
OPERATORS = {"<": "<", "<=": "<=", "=": "==", "!=": "!=", ">=": ">=", ">": ">"}


class Machine:
    """A task as Python functions over states: a number with a bit for each fact, and a tuple of numbers."""

    def __init__(self, task: Task, faults: frozenset = frozenset()):
        self.task = task
        self.faults = faults
        self.bits: dict[tuple, int] = {}
        self.places = {fluent: place for place, (fluent, _) in enumerate(task.numbers)}
        self.start = (sum(self.bit(fact) for fact in task.facts), tuple(number for _, number in task.numbers))
        self.steps = [self.step(action, binding) for action in task.actions for binding in task.bindings(action.parameters)]

    def bit(self, fact: tuple) -> int:
        """The bit of a fact."""
        return 1 << self.bits.setdefault(fact, len(self.bits))

    def source(self, part: tuple, binding: dict) -> str:
        """A condition or an expression over `s` and `n`."""
        head, *rest = part
        own = lambda term: binding.get(term, term)
        if head == "fact":
            return f"(s & {self.bit((rest[0], *map(own, rest[1:])))} != 0)"
        if head == "number":
            return f"({rest[0]})"
        if head == "fluent":
            return f"n[{self.places[(rest[0], *map(own, rest[1:]))]}]"
        if head == "not":
            return f"(not {self.source(rest[0], binding)})"
        if head == "=":
            return str(own(rest[0]) == own(rest[1]))
        if head == "compare":
            return f"({self.source(rest[1], binding)} {OPERATORS[rest[0]]} {self.source(rest[2], binding)})"
        if head in ("forall", "exists"):
            parts = [self.source(rest[1], {**binding, **more}) for more in self.task.bindings(rest[0])]
            return f"{'all' if head == 'forall' else 'any'}(({' '.join(part + ',' for part in parts)}))"
        parts = [self.source(own, binding) for own in rest]
        if head in ("+", "-"):
            return f"({parts[0]} {head} {parts[1]})"
        return f"({f' {head} '.join(parts)})" if parts else str(head == "and")

    def condition(self, condition: tuple):
        """A condition as a function."""
        return eval(f"lambda s, n: {self.source(condition, {})}")  # made of numbers and operators alone

    def fire(self, effect: tuple, binding: dict, indent: str, lines: list[str]) -> None:
        """Lines that collect what an effect does."""
        head, *rest = effect
        own = lambda term: binding.get(term, term)
        if head == "and":
            for part in rest:
                self.fire(part, binding, indent, lines)
        elif head == "when":
            lines.append(f"{indent}if {self.source(rest[0], binding)}:")
            lines.append(f"{indent}    pass")
            self.fire(rest[1], binding, indent + "    ", lines)
        elif head == "forall":
            for more in self.task.bindings(rest[0]):
                self.fire(rest[1], {**binding, **more}, indent, lines)
        elif head == "set":
            lines.append(f"{indent}{'a' if rest[0] else 'd'} |= {self.bit((rest[1], *map(own, rest[2:])))}")
        else:
            place = self.places[(rest[0], *map(own, rest[1]))]
            value = self.source(rest[2], binding)
            if head == "assign":
                lines.append(f"{indent}to.setdefault({place}, set()).add({value})")
            else:
                sign = "" if head == "increase" else "-"
                before = "0" if "one-change" in self.faults else f"by.get({place}, 0)"
                lines.append(f"{indent}by[{place}] = {before} + {sign}{value}")

    def step(self, action: Action, binding: dict):
        """A step: its words, its cost, and the state after it as a function that gives None where it is impossible."""
        lines = ["def after(s, n):", f"    if not {self.source(action.condition, binding)}:", "        return None"]
        lines.append("    a, d, to, by = 0, 0, {}, {}")
        for effect in action.effects:
            self.fire(effect, binding, "    ", lines)
        # What is deleted and added holds; a number that changes in two ways at once makes the step impossible.
        lines += [
            "    s = (s | a) & ~d" if "delete-wins" in self.faults else "    s = s & ~d | a",
            "    if to or by:",
            "        n = list(n)",
            "        for place, values in to.items():",
            "            if len(values) > 1 or place in by:",
            "                return None",
            "            n[place] = values.pop()",
            "        for place, value in by.items():",
            "            n[place] += value",
            "        n = tuple(n)",
            "    return s, n",
        ]
        scope: dict = {}
        exec("\n".join(lines), scope)
        free = 1 if "no-free-step" in self.faults else 0
        cost = free if action.cost is None else eval(f"lambda n: {self.source(action.cost, binding)}")(self.start[1])
        words = (action.name, *(binding[name] for name, _ in action.parameters))
        return words, cost if self.task.has_costs() else 1, scope["after"]

    @cached_property
    def named(self) -> dict:
        """The steps by their words."""
        return {words: (cost, after) for words, cost, after in self.steps}

    def unchanged(self, entity: str):
        """The condition that what has the entity as first argument is as at first."""
        mask = sum(bit for fact, bit in ((fact, 1 << place) for fact, place in self.bits.items()) if entity in fact[1:2])
        places = [place for fluent, place in self.places.items() if entity in fluent[1:2]]
        facts, numbers = self.start
        return lambda s, n: (s ^ facts) & mask == 0 and all(n[place] == numbers[place] for place in places)

    @cached_property
    def rules(self) -> list:
        """The conditions of the constraints. One that is broken binds from the first state that keeps it."""
        rules = []
        for word, written, conditions in self.task.constraints:
            if word == "untouched":
                rules.append(self.unchanged(conditions))
            else:
                rules += [self.condition(own if word == "always " else ("not", own)) for own in conditions]
        return rules

    @cached_property
    def allowed(self) -> list:
        """The steps that no constraint forbids."""
        untouched = {entity for word, _, entity in self.task.constraints if word == "untouched"}
        return [step for step in self.steps if not untouched & set(step[0][1:])]

    @cached_property
    def conditions(self) -> list:
        """The conditions of the goals of all stages."""
        return [self.condition(own) for stage in self.task.stages for goal in stage for own in goal.conditions]

    def progress(self, flags: list[dict]) -> Progress:
        """The progress through the stages."""
        sizes = [sum(len(goal.conditions) for goal in stage) for stage in self.task.stages]
        ends = list(itertools.accumulate(sizes))
        ranges = [range(end - size, end) for end, size in zip(ends, sizes)] if len(sizes) > 1 else []
        return Progress(self.conditions, ranges, flags, lambda condition, state, events: condition(*state))

    def is_goal(self, flags: list[dict]):
        """The condition on the last state, as a function."""
        if not self.task.stages:
            return self.condition(self.task.goal)
        kept = [own for number, own in enumerate(self.conditions) if not flags or flags[number]["kept"]]
        return lambda s, n: all(own(s, n) for own in kept)

    def next(self, state: tuple, after) -> tuple | None:
        """The state after a step; None if it is impossible or breaks a constraint."""
        following = after(*state)
        if following is None or any(rule(*state) and not rule(*following) for rule in self.rules):
            return None
        return following

    def best(self, flags: list[dict]) -> tuple[int, int] | str:
        """The least cost of a plan, and the fewest steps at that cost; or that there is none, or over the limit."""
        progress, is_goal = self.progress(flags), self.is_goal(flags)
        order = itertools.count()
        first = (self.start, progress.start(self.start))
        queue, closed = [((0, 0), next(order), first)], set()
        while queue:
            cost, _, node = heapq.heappop(queue)
            if node in closed:
                continue
            state, at = node
            if progress.is_complete(at) and is_goal(*state):
                return cost
            closed.add(node)
            if len(closed) > LIMIT:
                return OVER
            for _, price, after in self.allowed:
                following = self.next(state, after)
                if following is not None:
                    node = (following, progress.on(at, following))
                    if node not in closed:
                        heapq.heappush(queue, ((cost[0] + price, cost[1] + 1), next(order), node))
        return UNSOLVABLE

    def replay(self, plan: list, flags: list[dict]) -> tuple[int | None, bool, int]:
        """The number of the first step whose condition fails, true if the plan is valid, and its cost."""
        progress, is_goal = self.progress(flags), self.is_goal(flags)
        state, cost, allowed = self.start, 0, True
        at = progress.start(state)
        words = {step[0] for step in self.allowed}
        for number, step in enumerate(plan):
            price, after = self.named[tuple(step)]
            following = after(*state)
            if following is None:
                return number, False, cost
            allowed &= tuple(step) in words
            allowed &= not any(rule(*state) and not rule(*following) for rule in self.rules)
            state, cost = following, cost + price
            at = progress.on(at, state)
        return None, allowed and progress.is_complete(at) and is_goal(*state), cost

    def distances(self, limit: int = LIMIT) -> dict:
        """The fewest steps to each state, up to a limit of states."""
        steps, layer = {self.start: 0}, [self.start]
        while layer and len(steps) < limit:
            following = []
            for state in layer:
                for _, _, after in self.steps:
                    found = after(*state)
                    if found is not None and found not in steps:
                        steps[found] = steps[state] + 1
                        following.append(found)
            layer = following
        return steps

    def reachable(self) -> set | None:
        """All states that steps lead to; None over the limit."""
        states = self.distances()
        return None if len(states) >= LIMIT else set(states)
