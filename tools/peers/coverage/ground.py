"""Ground actions of a task, and random walks through its states."""

import itertools
from dataclasses import dataclass
from functools import cached_property
from random import Random

from simulate import pddl

# A fact is a tuple: the predicate and its arguments.
Fact = tuple[str, ...]
State = frozenset


@dataclass
class World:
    """A domain with objects by type, and the facts of the first state."""

    domain: pddl.Pddl
    objects: dict[str, list[str]]
    facts: set[Fact]

    @cached_property
    def changing(self) -> set[str]:
        """The predicates that some action changes."""
        return {name for action in self.domain.actions.values() for name in pddl.changed_predicates(action.effect)}

    def of_type(self, kind: str) -> list[str]:
        """The objects of a type and its subtypes, in the order of the task."""
        return [name for own, names in self.objects.items() if self.domain.is_a(own, kind) for name in names]

    def static(self, condition: tuple, binding: dict[str, str]) -> bool:
        """False if the condition is false in every state, judged by its conjuncts without changing facts."""
        head = condition[0]
        if head == "and":
            return all(self.static(part, binding) for part in condition[1])
        if head == "atom" and condition[1] not in self.changing:
            terms = [binding.get(term, term) for term in condition[2]]
            return any(term.startswith("?") for term in terms) or (condition[1], *terms) in self.facts
        if head == "=":
            left, right = (binding.get(term, term) for term in condition[1:])
            return left.startswith("?") or right.startswith("?") or left == right
        return True

    def steps(self) -> list["Step"]:
        """All ground actions that static facts allow."""
        found: list[Step] = []
        for action in self.domain.actions.values():
            found += [Step(self, action, binding) for binding in self.bindings(action)]
        return found

    def bindings(self, action: pddl.Action) -> list[dict[str, str]]:
        """The arguments of an action that static facts allow."""
        partial: list[dict[str, str]] = [{}]
        for name, kind in action.parameters:
            longer = ({**binding, name: thing} for binding in partial for thing in self.of_type(kind))
            partial = [binding for binding in longer if self.static(action.condition, binding)]
        return partial

    def holds(self, condition: tuple, state: State, binding: dict[str, str]) -> bool:
        """The value of a condition in a state."""
        head = condition[0]
        if head == "and":
            return all(self.holds(part, state, binding) for part in condition[1])
        if head == "or":
            return any(self.holds(part, state, binding) for part in condition[1])
        if head == "not":
            return not self.holds(condition[1], state, binding)
        if head in ("forall", "exists"):
            names, kinds = zip(*condition[1])
            choices = itertools.product(*(self.of_type(kind) for kind in kinds))
            values = (self.holds(condition[2], state, {**binding, **dict(zip(names, choice))}) for choice in choices)
            return all(values) if head == "forall" else any(values)
        if head == "=":
            left, right = (binding.get(term, term) for term in condition[1:])
            return left == right
        _, predicate, terms = condition
        return (predicate, *(binding.get(term, term) for term in terms)) in state

    def change(self, effect: tuple, state: State, binding: dict[str, str], added: set[Fact], deleted: set[Fact]) -> None:
        """Collects the facts that an effect adds and deletes."""
        head = effect[0]
        if head == "and":
            for part in effect[1]:
                self.change(part, state, binding, added, deleted)
        elif head == "forall":
            names, kinds = zip(*effect[1])
            for choice in itertools.product(*(self.of_type(kind) for kind in kinds)):
                self.change(effect[2], state, {**binding, **dict(zip(names, choice))}, added, deleted)
        elif head == "when":
            if self.holds(effect[1], state, binding):
                self.change(effect[2], state, binding, added, deleted)
        else:
            fact = (effect[1], *(binding.get(term, term) for term in effect[2]))
            (added if head == "add" else deleted).add(fact)


@dataclass
class Step:
    """A ground action."""

    world: World
    action: pddl.Action
    binding: dict[str, str]

    def after(self, state: State) -> State | None:
        """The next state; none where the step is not applicable."""
        if not self.world.holds(self.action.condition, state, self.binding):
            return None
        added: set[Fact] = set()
        deleted: set[Fact] = set()
        self.world.change(self.action.effect, state, self.binding, added, deleted)
        return frozenset((state - deleted) | added)


def walk(world: World, length: int, random: Random) -> State:
    """The state after a random walk, which prefers facts that it has not seen and never returns to a state."""
    steps = world.steps()
    state = frozenset(world.facts)
    seen, facts = {state}, set(state)
    for _ in range(length):
        following = None
        novel = random.random() < 0.7
        for step in random.sample(steps, len(steps)):
            after = step.after(state)
            if after is None or after in seen:
                continue
            following = following or after
            if not novel or not after <= facts:
                following = after
                break
        if following is None:
            break
        state = following
        seen.add(state)
        facts |= state
    return state
