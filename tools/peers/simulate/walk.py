"""Simulation of plans: every way through a tree, with states that meet taken together."""

from dataclasses import dataclass, field

from . import lanes
from .plan import Bound, Plan, Step
from .world import GroundAction, World, holds

# States that one case may be in, over all its steps; a case that needs more is counted as over the bound.
STATES = 50_000


class OverBound(Exception):
    """A case that needs more than the simulator's bound."""


class Undecided(Exception):
    """A step whose hidden arguments are not decided yet, with the states in which it stands."""

    def __init__(self, step: Step, states: frozenset):
        super().__init__(step.number)
        self.step = step
        self.states = states


class Broken(Exception):
    """The first violation, where nobody wants to know the others."""


@dataclass
class Result:
    """Violations as pairs of kind and step (None at the end), and the last states of all ways."""

    violations: set[tuple[str, int | None]] = field(default_factory=set)
    endings: frozenset = frozenset()

    @property
    def valid(self) -> bool:
        """True if nothing is wrong."""
        return not self.violations


class Walk:
    """One simulation of a plan with arguments for its steps."""

    def __init__(self, bound: Bound, stop_at_first: bool = False):
        self.bound = bound
        self.world: World = bound.world
        self.result = Result()
        self.stop = stop_at_first
        self.count = 0

    def blame(self, kind: str, step: int | None) -> None:
        """Notes a violation."""
        self.result.violations.add((kind, step))
        if self.stop:
            raise Broken

    def spend(self, states: int) -> None:
        """Counts states against the bound."""
        self.count += states
        if self.count > STATES:
            raise OverBound

    def run(self) -> Result:
        """The result of the whole plan."""
        states = self.nodes(self.bound.plan.nodes, frozenset([self.world.initial]))
        if "no-end" not in self.world.faults:
            for state in states:
                for _ in self.world.broken("end", state):
                    self.blame("rule", None)
        self.result.endings = states
        return self.result

    def nodes(self, nodes: list, states: frozenset) -> frozenset:
        """The states after a list of nodes."""
        for node in nodes:
            self.spend(len(states))
            states = self.node(node, states)
        return states

    def node(self, node: tuple, states: frozenset) -> frozenset:
        """The states after a node."""
        head = node[0]
        if head == "step":
            return frozenset(after for state, _, after in self.step(node[1], states))
        if head == "if":
            truths = self.condition(node[1], states)
            return self.nodes(node[2], truths[True]) | self.nodes(node[3], truths[False])
        if head == "while":
            return self.loop(node[1], node[2], states)
        if head == "repeat":
            return self.repeat(node[1], node[2], states)
        return lanes.run(self, node[1], states)

    def action(self, step: Step, states: frozenset) -> GroundAction:
        """The ground action of a step."""
        action = self.bound.action(step)
        if action is None:
            raise Undecided(step, states)
        return action

    def step(self, step: Step, states: frozenset) -> list[tuple[frozenset, int, frozenset]]:
        """For each state, the outcomes of a step (0 for one that does not sense) and the states after it."""
        if not states:
            return []
        action = self.action(step, states)
        made = []
        for state in states:
            if not holds(action.condition, state):
                self.blame("precondition", step.number)
            if action.senses:
                outcomes = self.world.sense(action, state)
            else:
                outcomes = [(0, self.world.apply(action, state))]
            for number, after in outcomes:
                # A rule that sensing reveals to be broken is no fault of the plan.
                if not action.senses and self.world.newly_broken(state, after):
                    self.blame("rule", step.number)
                made.append((state, number, after))
        return made

    def condition(self, condition: tuple, states: frozenset) -> dict[bool, frozenset]:
        """The states in which a condition comes out true, and those in which it comes out false."""
        if not states:
            return {True: states, False: states}
        head = condition[0]
        if head == "not":
            truths = self.condition(condition[1], states)
            return {True: truths[False], False: truths[True]}
        if head in ("all", "any"):
            return self.joined(head, condition[1], states)
        truths = {True: set(), False: set()}
        if head == "sense":
            for _, number, after in self.step(condition[1], states):
                truths[number == 0].add(after)
        else:
            for state in states:
                if not self.known(condition[2], state):
                    self.blame("unsensed", condition[1])
                truths[condition[2] in state].add(state)
        return {truth: frozenset(found) for truth, found in truths.items()}

    def joined(self, head: str, parts: list, states: frozenset) -> dict[bool, frozenset]:
        """`and` and `or` as Python has them: what comes after the part that decides is not evaluated."""
        deciding = head == "any"
        decided: frozenset = frozenset()
        for part in parts:
            truths = self.condition(part, states)
            if "eager-conditions" in self.world.faults:
                rest = states if part is parts[0] else frozenset()
                for later in parts[1:]:
                    rest = frozenset().union(*self.condition(later, rest).values())
            decided |= truths[deciding]
            states = truths[not deciding]
        return {deciding: decided, not deciding: states}

    def known(self, fact: tuple, state: frozenset) -> bool:
        """False for an outcome of sensing of which nobody knows whether it holds."""
        groups = self.world.outcome_groups(fact)
        return not groups or any(other in state for group in groups for other in group)

    def loop(self, condition: tuple, body: list, states: frozenset) -> frozenset:
        """The states after `while`; a state at its head from which no way leaves is a violation."""
        heads: dict[frozenset, tuple[set, bool]] = {}
        exits: set = set()
        waiting = list(states)
        while waiting:
            head = waiting.pop()
            if head in heads:
                continue
            self.spend(1)
            truths = self.condition(condition, frozenset([head]))
            after = self.nodes(body, truths[True]) if truths[True] else frozenset()
            heads[head] = (set(after), bool(truths[False]))
            exits |= truths[False]
            waiting += after
        leaving = {head for head, (_, leaves) in heads.items() if leaves}
        grown = True
        while grown:
            grown = False
            for head, (after, _) in heads.items():
                if head not in leaving and after & leaving:
                    leaving.add(head)
                    grown = True
        if len(leaving) < len(heads):
            self.blame("endless_loop", None)
        return frozenset(exits)

    def repeat(self, count: int, body: list, states: frozenset) -> frozenset:
        """The states after a counted loop; turns that lead back to states that were there before are not gone again."""
        seen = {states: 0}
        turns = [states]
        for turn in range(1, count + 1):
            states = self.nodes(body, states)
            if states in seen:
                start, length = seen[states], turn - seen[states]
                return turns[start + (count - start) % length]
            seen[states] = turn
            turns.append(states)
        return states


def simulate(plan: Plan, world: World, arguments: dict[int, tuple[str, ...]], stop_at_first: bool = False) -> Result:
    """The result of a plan whose hidden arguments are given."""
    walk = Walk(Bound(plan, world, arguments), stop_at_first)
    try:
        return walk.run()
    except Broken:
        return walk.result
