"""What a run may believe after its events, and why: written from the section "Knowledge" of docs/reference/execution.md."""

from ..numbers import UNSURE, State
from ..world import as_list, holds
from .make import Entries
from .view import keys_of
from .world import NumberAction, NumberWorld

ASSUMED, PROMISED, OBSERVED, SURMISED = "assumed", "promised", "observed", "surmised"


class Belief:
    """A state, and the source of every fact and number of it.

    A source is `assumed`, `promised` by an order or `observed` after one, with the number of the order; `surmised` stands for facts
    that nothing can show, and of which the pages leave open what follows from a surprise.
    """

    def __init__(self, world: NumberWorld, entries: Entries, reports: set[str]):
        self.world, self.entries, self.reports = world, entries, reports
        self.state: State = world.initial
        self.source: dict[tuple, tuple[str, int]] = {}
        self.ended = 0
        # Facts and numbers that looks have shown since the last order ended.
        self.shown: set[tuple] = set()
        self.listed: frozenset = frozenset()
        # By order that promised effects: those that no look has compared yet, and the events of the same step.
        self.fresh: list[tuple[set, set]] = []

    def visible(self, key: tuple) -> bool:
        """True for what an observation can show."""
        return key in self.entries.visible or (key[0] in self.reports)

    def source_of(self, key: tuple) -> tuple[str, int]:
        """The source of a fact or a number."""
        return self.source.get(key, (ASSUMED, 0))

    def value(self, key: tuple):
        """The believed value."""
        return self.state.numbers.get(key[1]) if key[0] == "#" else key in self.state

    # --- events ---------------------------------------------------------------------------------------------

    def touched(self, action: NumberAction, order: int, fired: set = frozenset()) -> None:
        """An order that may have changed all that its effects name; what was open stays open unless an effect fired."""
        for key in action.touches():
            if self.source_of(key)[0] != SURMISED or key in fired:
                self.source[key] = (PROMISED, order)
            self.shown.discard(key)

    def performed(self, action: NumberAction, order: int) -> frozenset:
        """The end of a step that the robot says it did; returns its events."""
        before = self.state
        events = {fact for when, sign, fact in action.effects if sign and holds(when, before) and fact[0] in self.world.words.events}
        doubtful = self.effects_in_doubt(action)
        self.state = self.world.apply(action, before)
        self.touched(action, order, {fact for when, _, fact in action.effects if holds(when, before)})
        for key in doubtful:
            self.source[key] = (SURMISED, order)
        changed = {key for key in action.touches() if self.visible(key) and self.differs(key, before, self.state)}
        self.fresh.append((changed, events))
        self.end_of_order(order)
        return frozenset(events)

    def effects_in_doubt(self, action: NumberAction) -> set[tuple]:
        """What depends on a fact that the pages leave open."""
        effects = [(when, fact) for when, _, fact in action.effects] + [(own[0], ("#", own[2])) for own in action.changes]
        open_keys = {key for key, (source, _) in self.source.items() if source == SURMISED}
        return {key for when, key in effects if open_keys and open_keys & keys_of(when)}

    def failed(self, action: NumberAction, order: int) -> None:
        """The end of a step that the robot says it could not do, or of which nobody knows the end."""
        self.touched(action, order)
        self.end_of_order(order)

    def end_of_order(self, order: int) -> None:
        """Looks before this do not belong to the end."""
        self.ended = max(self.ended, order)
        self.shown = set()
        self.listed = frozenset()

    @staticmethod
    def differs(key: tuple, before: State, after: State) -> bool:
        """True if two states differ in a fact or a number."""
        if key[0] == "#":
            return before.numbers.get(key[1]) != after.numbers.get(key[1])
        return (key in before) != (key in after)

    def put(self, key: tuple, other: State) -> None:
        """Takes one fact or number over from another state."""
        facts, numbers = set(self.state), dict(self.state.numbers)
        if key[0] != "#":
            (facts.add if key in other else facts.discard)(key)
        elif key[1] in other.numbers:
            numbers[key[1]] = other.numbers[key[1]]
        self.state = State.of(facts, numbers)

    def read(self, statements: dict) -> tuple[dict, set]:
        """What an observation decides: the value of each fact and number, and the entities that it lists."""
        told: dict[tuple, object] = {}
        seen: set = set()
        for entity, said in statements.get("states", {}).items():
            name = entity.strip("<>")
            if name not in self.world.types:
                continue
            seen.add(name)
            self.entry(name, as_list(said), told)
        if statements.get("facts") is not None:
            seen.add(None)
            self.entry(None, statements["facts"], told)
            for predicate in self.reports:
                declared = self.world.words.pddl.predicates[predicate]
                for binding in self.world.bindings(declared):
                    key = (predicate, *binding.values())
                    told[key] = key in told and told[key]
        return told, seen

    def entry(self, subject: str | None, texts: list[str], told: dict) -> None:
        """Reads the entry of an entity, which is described fully; a number that it lacks was not measured."""
        told.update({key: False for key in self.entries.keys.get(subject, []) if key[0] != "#"})
        facts, numbers = set(), {}
        self.world.read(subject, texts, facts, numbers)
        told.update({fact: True for fact in facts})
        told.update({("#", key): own for key, own in numbers.items()})

    def observed(self, statements: dict) -> set[tuple]:
        """An observation; returns the facts and numbers that differ from what was believed."""
        told, seen = self.read(statements)
        different = {key for key, own in told.items() if self.value(key) != own}
        facts = set(self.state)
        numbers = dict(self.state.numbers)
        for key, own in told.items():
            self.source[key] = (OBSERVED, self.ended)
            self.shown.add(key)
            if key[0] != "#":
                (facts.add if own else facts.discard)(key)
            else:
                numbers[key[1]] = own
        self.state = State.of(facts, numbers)
        self.surprise(different)
        self.contradicted(different, set(told))
        left = [(changed - set(told), events) for changed, events in self.fresh if not changed & different]
        self.fresh = [own for own in left if own[0]]
        self.listed = frozenset(seen)
        return different

    def surprise(self, different: set[tuple]) -> None:
        """Facts that nothing shows are open after a surprise about their entities, and the events of a refuted step."""
        surprising = {self.world.subjects.get(key) for key in different} | {
            name for key in different for name in (key[1][1:] if key[0] == "#" else key[1:])
        }
        for key in list(self.source):
            if not self.visible(key) and key[0] != "#" and surprising & set(key[1:]):
                self.source[key] = (SURMISED, self.ended)
        for key in self.state:
            if not self.visible(key) and surprising & set(key[1:]) and key[0] in self.world.words.changing:
                self.source[key] = (SURMISED, self.ended)
        for changed, events in self.fresh:
            if changed & different:
                for event in events:
                    self.source[event] = (SURMISED, self.ended)

    def contradicted(self, different: set[tuple], told: set[tuple]) -> None:
        """What no look has shown, and cannot be together with what this one shows, is open: the hand holds one thing."""
        for _, _, condition in self.world.rules["start"] if different else ():
            if not holds(condition, self.state):
                for key in keys_of(condition):
                    if key in self.state and key not in told and key[0] in self.world.words.changing:
                        self.source[key] = (SURMISED, self.ended)

    # --- views ----------------------------------------------------------------------------------------------

    def view(self, accepts) -> "BeliefView":
        """The view of an observer for whom only the sources count that `accepts` takes."""
        return BeliefView(self, accepts)


class BeliefView:
    """Believed facts and numbers, as far as their sources count; anything else is unsure."""

    def __init__(self, belief: Belief, accepts, events: frozenset | None = None, happening: frozenset = frozenset()):
        self.belief, self.accepts = belief, accepts
        self.events, self.happening = events, happening
        self.numbers = self

    def fact(self, fact: tuple) -> bool | None:
        """The truth of a fact."""
        if fact[0] in self.happening and fact not in self.events:
            return False
        if not self.accepts(fact):
            return None
        return fact in self.belief.state

    def get(self, key: tuple):
        """The value of a number."""
        if not self.accepts(("#", key)):
            return UNSURE
        return self.belief.state.numbers.get(key)

    def with_events(self, events: frozenset, happening) -> "BeliefView":
        """The same with no events but these."""
        return BeliefView(self.belief, self.accepts, events, frozenset(happening))

