"""Hidden arguments: is there a choice of them under which a plan can be carried out and ends as it claims?"""

from .claims import hides_place, kept
from .plan import Bound, Plan, Step
from .walk import OverBound, Undecided, simulate
from .world import World, holds

# Attempts at one case.
ATTEMPTS = 4_000
FLAT_STATES = 40_000


def find(plan: Plan, world: World, after: dict | None) -> dict[int, tuple[str, ...]] | None:
    """Arguments with which the plan is valid and as claimed, by trying all; None if there are none."""
    if all(node[0] == "step" for node in plan.nodes):
        return Flat(plan, world, after).find()
    return Tree(plan, world, after).find({})


class Flat:
    """The search for a list of steps: what comes after a step depends only on the states and on what was put down."""

    def __init__(self, plan: Plan, world: World, after: dict | None):
        self.plan, self.world, self.after = plan, world, after
        self.failed: set = set()

    def find(self) -> dict[int, tuple[str, ...]] | None:
        """Arguments for all steps."""
        return self.extend(0, frozenset([self.world.initial]), {}, frozenset())

    def extend(self, index: int, states: frozenset, arguments: dict, objects: frozenset) -> dict | None:
        """Arguments for the steps from `index` on; `objects` are those that the claim may speak of."""
        key = (index, states, objects)
        if key in self.failed:
            return None
        if len(self.failed) > FLAT_STATES:
            raise OverBound
        if index == len(self.plan.steps):
            found = self.ends_well(states, arguments)
        else:
            found = self.step(index, states, arguments, objects)
        if found is None:
            self.failed.add(key)
        return found

    def step(self, index: int, states: frozenset, arguments: dict, objects: frozenset) -> dict | None:
        """Tries every binding of a step."""
        step = self.plan.steps[index]
        choices = step.bindings()
        for choice in choices:
            action = self.world.action(step.call.action.name, choice)
            if not all(holds(action.condition, state) for state in states):
                continue
            after = set()
            for state in states:
                if action.senses:
                    nexts = [made for _, made in self.world.sense(action, state)]
                else:
                    nexts = [self.world.apply(action, state)]
                if not action.senses and any(self.world.newly_broken(state, made) for made in nexts):
                    break
                after.update(nexts)
            else:
                put = objects | self.put_down(step, choice)
                found = self.extend(index + 1, frozenset(after), {**arguments, step.number: choice}, put)
                if found is not None:
                    return found
                if "no-hidden-choice" in self.world.faults:
                    return None
        return None

    def put_down(self, step: Step, choice: tuple[str, ...]) -> set[str]:
        """The object of a call that hides where it goes, if there is a claim that may speak of it."""
        if self.after is None or not hides_place(self.world, step.call):
            return set()
        parameters = [name for name, _ in step.call.action.parameters]
        return {choice[parameters.index(step.call.object)]}

    def ends_well(self, states: frozenset, arguments: dict) -> dict | None:
        """The arguments if the end is as it should be."""
        if "no-end" not in self.world.faults and any(self.world.broken("end", state) for state in states):
            return None
        return arguments if kept(Bound(self.plan, self.world, arguments), self.after, states) else None


class Tree:
    """The search for a tree: simulated from the start each time, and decided where a step is open."""

    def __init__(self, plan: Plan, world: World, after: dict | None):
        self.plan, self.world, self.after = plan, world, after
        self.attempts = 0

    def find(self, arguments: dict) -> dict[int, tuple[str, ...]] | None:
        """Arguments that complete those that are given."""
        self.attempts += 1
        if self.attempts > ATTEMPTS:
            raise OverBound
        try:
            result = simulate(self.plan, self.world, arguments, stop_at_first=True)
        except Undecided as undecided:
            step = undecided.step
            for choice in step.bindings():
                action = self.world.action(step.call.action.name, choice)
                if all(holds(action.condition, state) for state in undecided.states):
                    found = self.find({**arguments, step.number: choice})
                    if found is not None or "no-hidden-choice" in self.world.faults:
                        return found
            return None
        if not result.valid:
            return None
        return arguments if kept(Bound(self.plan, self.world, arguments), self.after, result.endings) else None
