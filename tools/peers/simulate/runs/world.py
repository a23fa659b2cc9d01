"""Worlds with numbers: environments, actions and rules as in `simulate.world`, and the numeric functions beside them."""

from dataclasses import dataclass, field

from ..numbers import MOST, State, value
from ..pddl import CHANGES, millionths
from ..words import split_call
from ..world import GroundAction, World, as_list, holds, join


@dataclass
class NumberAction(GroundAction):
    """A ground action with its changes of numbers: condition, kind, number, expression."""

    changes: list[tuple] = field(default_factory=list)
    named: frozenset = frozenset()

    def touches(self) -> frozenset:
        """The facts and numbers that its effects name, whatever their conditions. A number is ("#", key)."""
        return self.named


class NumberWorld(World):
    """An environment under a domain with numbers. States are `State`s."""

    def __init__(self, words, environment: dict):
        self.given: dict = {}
        super().__init__(words, environment)
        self.rules["always"] += [("range", key, ("range", limits)) for key, limits in self.ranges()]
        self.subjects = self.find_subjects()
        self.reached: list[State] | None = None

    # --- the first state -----------------------------------------------------------------------------------

    def first_state(self) -> State:
        """What holds at first."""
        return State.of(super().first_state(), self.given)

    def said(self, environment: dict) -> set[tuple]:
        """The facts that an environment says; its numbers are kept in `given`."""
        facts, numbers = set(), {}
        for key in ("asset_states", "object_states"):
            for entity, entry in environment.get(key, {}).items():
                self.read(entity.strip("<>"), as_list(entry), facts, numbers)
        self.read(None, environment.get("facts", []), facts, numbers)
        self.given = numbers
        return facts

    def read(self, entity: str | None, texts: list[str], facts: set, numbers: dict) -> None:
        """Reads the statements about an entity, or those without a subject."""
        for text in texts:
            name, arguments = split_call(text if "(" in text else text + "()")
            names = [argument.strip("<>") for argument in arguments]
            if name in self.words.numbers:
                subject = [] if entity is None else [entity]
                key = (self.words.numbers[name].name, *subject, *names[:-1])
                numbers[key] = millionths(names[-1].split()[0])
            elif entity is None:
                facts.add((name, *names))
            else:
                facts.add(self.fact_of_word(entity, text))

    def ranges(self) -> list[tuple]:
        """The numbers with a range: key, and the limits."""
        found = []
        for word in self.words.numbers.values():
            if word.least is not None or word.most is not None:
                found += [(key, (key, word.least, word.most)) for key in self.keys(word.name)]
        return found

    def keys(self, function: str) -> list[tuple]:
        """The numbers of a function."""
        choices = self.bindings(self.words.pddl.functions[function])
        return [(function, *binding.values()) for binding in choices]

    # --- ground conditions and actions ----------------------------------------------------------------------

    def ground(self, condition: tuple, binding: dict, fixed: bool = True):
        """A condition with its variables bound."""
        if condition[0] == "compare":
            left, right = (self.expression(part, binding) for part in condition[2:])
            return ("compares", (condition[1], left, right))
        return super().ground(condition, binding, fixed)

    def expression(self, expression: tuple, binding: dict) -> tuple:
        """An expression with its variables bound."""
        head = expression[0]
        if head == "number":
            return expression
        if head == "fluent":
            return ("fluent", (expression[1], *(binding.get(term, term) for term in expression[2])))
        return (head, self.expression(expression[1], binding), self.expression(expression[2], binding))

    def ground_effect(self, effect: tuple, binding: dict, when) -> list[tuple]:
        """The effects on facts."""
        return [] if effect[0] in CHANGES else super().ground_effect(effect, binding, when)

    def ground_changes(self, effect: tuple, binding: dict, when) -> list[tuple]:
        """The effects on numbers."""
        head = effect[0]
        if head == "and":
            return [each for part in effect[1] for each in self.ground_changes(part, binding, when)]
        if head == "forall":
            choices = self.bindings(effect[1])
            return [each for more in choices for each in self.ground_changes(effect[2], {**binding, **more}, when)]
        if head == "when":
            inner = join("and", [when, self.ground(effect[1], binding)])
            return [] if inner is False else self.ground_changes(effect[2], binding, inner)
        if head in CHANGES:
            key = (effect[1], *(binding.get(term, term) for term in effect[2]))
            return [(when, head, key, self.expression(effect[3], binding))]
        return []

    def named(self, effect: tuple, binding: dict) -> set[tuple]:
        """The facts and numbers that an effect names."""
        head = effect[0]
        if head == "and":
            return {key for part in effect[1] for key in self.named(part, binding)}
        if head == "forall":
            choices = self.bindings(effect[1])
            return {key for more in choices for key in self.named(effect[2], {**binding, **more})}
        if head == "when":
            return self.named(effect[2], binding)
        key = (effect[1], *(binding.get(term, term) for term in effect[2]))
        return {("#", key) if head in CHANGES else key}

    def action(self, name: str, arguments: tuple[str, ...]) -> NumberAction:
        """An action with its arguments."""
        key = (name, arguments)
        if key not in self.actions:
            plain = super().action(name, arguments)
            own = self.words.pddl.actions[name]
            binding = dict(zip((parameter for parameter, _ in own.parameters), arguments))
            changes = self.ground_changes(own.effect, binding, True)
            named = frozenset(self.named(own.effect, binding))
            self.actions[key] = NumberAction(name, arguments, plain.condition, plain.effects, plain.senses, changes, named)
        return self.actions[key]

    def applicable(self, action: NumberAction, state: State) -> bool:
        """True if a step can be done in a state."""
        return holds(action.condition, state) and self.new_numbers(action, state) is not None

    def successor(self, action: NumberAction, state: State) -> State | None:
        """The state after a step; None if it is not applicable."""
        if not holds(action.condition, state):
            return None
        changed = self.new_numbers(action, state)
        if changed is None:
            return None
        facts = super().apply(action, state)
        return State.of(facts, {**state.numbers, **changed} if changed else state.numbers)

    def new_numbers(self, action: NumberAction, state: State) -> dict | None:
        """The numbers that change; None if the step is not applicable for their sake."""
        if not action.changes:
            return {}
        fired: dict[tuple, list] = {}
        for when, kind, key, expression in action.changes:
            if holds(when, state):
                fired.setdefault(key, []).append((kind, value(expression, state.numbers)))
        found = {}
        for key, changes in fired.items():
            assigned = {amount for kind, amount in changes if kind == "assign"}
            moves = [amount if kind == "increase" else amount and -amount for kind, amount in changes if kind != "assign"]
            if any(amount is None for _, amount in changes) or len(assigned) > 1 or (assigned and moves):
                return None
            total = assigned.pop() if assigned else state.numbers.get(key)
            if total is None or abs(total + sum(moves)) > MOST:
                return None
            found[key] = total + sum(moves)
        return found

    def apply(self, action: NumberAction, state: State) -> State:
        """The state after a step; one whose numbers cannot change leaves them."""
        facts = super().apply(action, state)
        changed = self.new_numbers(action, state)
        return State.of(facts, {**state.numbers, **changed} if changed else state.numbers)

    def newly_broken(self, before: State, after: State) -> list[str]:
        """The `always` rules and ranges that were kept before a step and are broken after it."""
        rules = self.rules["always"]
        return [name for name, _, own in rules if not holds(own, after) and holds(own, before)]

    # --- what observations show -----------------------------------------------------------------------------

    def find_subjects(self) -> dict[tuple, str | None]:
        """The entity in whose entry each fact and number stands; None for those without a subject."""
        subjects: dict[tuple, str | None] = {}
        told = {predicate for call in self.words.calls.values() for predicate, _ in call.senses}
        for word in self.words.states.values():
            if word.predicate in told or word.predicate in self.words.events or "?self" not in word.terms:
                continue
            place = word.terms.index("?self")
            declared = self.words.pddl.predicates[word.predicate]
            for binding in self.bindings(declared):
                values = tuple(binding.values())
                if all(term.startswith("?") or term == own for term, own in zip(word.terms, values)):
                    subjects[(word.predicate, *values)] = values[place]
        for predicate, declared in self.words.pddl.predicates.items():
            if not declared and predicate not in self.words.events and predicate not in told:
                subjects[(predicate,)] = None
        for name, declared in self.words.pddl.functions.items():
            for key in self.keys(name):
                subjects[("#", key)] = key[1] if declared else None
        return subjects
