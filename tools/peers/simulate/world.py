"""A world: the entities of an environment, what holds at first, and actions and rules made ground for it."""

import itertools
import re
from dataclasses import dataclass

from .numbers import decide, in_range, with_values
from .words import Words, split_call

# A ground condition is True, False, or a tuple: ("is", fact) ("not", fact) ("and", [..]) ("or", [..]).
# A fact is a tuple of the predicate and its arguments; a state is a frozenset of facts.

# Conditions on numbers are ("compares", (sign, expression, expression)), its opposite "fails", and ("range", ..).
# ("misses", condition) is the complement of one on numbers.
OPPOSITES = {"is": "not", "not": "is", "compares": "fails", "fails": "compares"}

# Semantics that are wrong on purpose. The self-test switches each on and expects the comparison to find it.
FAULTS = {
    "add-before-delete": "an effect that adds and deletes one fact leaves it false",
    "sequential-effects": "conditional effects see what the effects before them did",
    "any-for-all": "`forall` in a condition is satisfied by one binding",
    "initially-now": "`(initially ...)` looks at the present state",
    "no-always": "`always` rules are not looked at",
    "no-end": "`end` rules are not looked at",
    "one-outcome": "sensing always comes out as its first outcome",
    "eager-conditions": "`and` and `or` in a plan's conditions evaluate all their parts",
    "claims-by-parts": "each promise may be kept by another ending",
    "unordered-lanes": "lanes run one after the other, in one order only",
    "no-sync": "nobody waits at a `sync`",
    "no-hidden-choice": "of several bindings of hidden arguments only the first that is applicable is tried",
    "equality": "`(= a b)` is always false",
    "forgetful": "`all` leaves out one member of a group",
    "longer": "search costs a step more",
}


@dataclass
class GroundAction:
    """An action with its arguments: when it is applicable, and what it does under which condition."""

    name: str
    arguments: tuple[str, ...]
    condition: object
    effects: list[tuple[object, bool, tuple]]
    senses: list[tuple]


def negate(ground):
    """The negation of a ground condition, in negation normal form."""
    if ground is True or ground is False:
        return not ground
    head, rest = ground
    if head in OPPOSITES:
        return (OPPOSITES[head], rest)
    return ("or" if head == "and" else "and", [negate(part) for part in rest])


def complement(ground):
    """What holds exactly where a ground condition does not: also where a comparison fails for want of a number."""
    if ground is True or ground is False:
        return not ground
    head, rest = ground
    if head in ("and", "or"):
        return join("or" if head == "and" else "and", [complement(part) for part in rest])
    return (OPPOSITES[head], rest) if head in ("is", "not") else ("misses", ground)


def join(head: str, parts: list):
    """`and` or `or` of ground conditions, simplified."""
    deciding = head == "or"
    kept = []
    for part in parts:
        if part is deciding:
            return deciding
        if part is not (not deciding):
            kept.append(part)
    if not kept:
        return not deciding
    return kept[0] if len(kept) == 1 else (head, kept)


def holds(ground, state: frozenset) -> bool:
    """The truth of a ground condition in a state."""
    if ground is True or ground is False:
        return ground
    head, rest = ground
    if head == "is":
        return rest in state
    if head == "not":
        return rest not in state
    if head == "and":
        return all(holds(part, state) for part in rest)
    if head == "or":
        return any(holds(part, state) for part in rest)
    if head == "misses":
        return not holds(rest, state)
    return in_range(rest, state.numbers) if head == "range" else decide(head, rest, state.numbers)


def stem(entity: str) -> str:
    """An identifier without its number."""
    return re.sub(r"_\d+$", "", entity)


def settled(ground, state: frozenset):
    """A ground condition that is looked at in one state, in whatever state it stands; a comparison keeps its numbers for its negation."""
    if ground is True or ground is False:
        return ground
    head, rest = ground
    if head in ("and", "or"):
        return join(head, [settled(part, state) for part in rest])
    return (head, with_values(rest, state.numbers)) if head in ("compares", "fails") else holds(ground, state)


def named(entity: str, names: list[str]) -> bool:
    """True if an identifier is one of the names or ends with one, as a word of its own."""
    base = stem(entity)
    return any(base == name or base.endswith("_" + name) for name in names)


def as_list(value) -> list[str]:
    """The words of an entry, which may be one word or a list."""
    return [value] if isinstance(value, str) else list(value)


class World:
    """An environment under a domain."""

    def __init__(self, words: Words, environment: dict, faults: frozenset = frozenset()):
        self.words = words
        self.faults = faults
        environment = environment.get("environment", environment)
        self.environment = environment
        self.types: dict[str, str] = dict(words.pddl.constants)
        for key, kind in (("assets", words.asset_type), ("objects", words.object_type)):
            for name in environment.get(key, []):
                self.types[name.strip("<>")] = kind
        self.by_type: dict[str, list[str]] = {}
        self.initial: frozenset = frozenset()
        self.actions: dict[tuple, GroundAction] = {}
        self.initial = self.first_state()
        self.rules = {holds: self.ground_rules(holds) for holds in ("start", "always", "end", "tidy")}

    def of_type(self, kind: str) -> list[str]:
        """The entities and constants of a type or of one below it."""
        if kind not in self.by_type:
            self.by_type[kind] = [name for name, own in self.types.items() if self.words.pddl.is_a(own, kind)]
        return self.by_type[kind]

    def bindings(self, variables: list[tuple[str, str]]) -> list[dict]:
        """Every way to bind variables to entities of their types."""
        names = [name for name, _ in variables]
        return [dict(zip(names, choice)) for choice in itertools.product(*(self.of_type(kind) for _, kind in variables))]

    # --- the first state -----------------------------------------------------------------------------------

    def said(self, environment: dict) -> set[tuple]:
        """The facts that the state words of an environment say."""
        facts = set()
        for key in ("asset_states", "object_states"):
            for entity, entry in environment.get(key, {}).items():
                for text in as_list(entry):
                    facts.add(self.fact_of_word(entity.strip("<>"), text))
        return facts

    def fact_of_word(self, entity: str, text: str) -> tuple:
        """The fact that a state word says in an entity's entry."""
        name, arguments = split_call(text)
        word = self.words.states[name]
        binding = dict(zip(word.parameters, (argument.strip("<>") for argument in arguments)), **{"?self": entity})
        return (word.predicate, *(binding.get(term, term) for term in word.terms))

    def first_state(self) -> frozenset:
        """What holds at first: what is said, what follows, what is usual, and what is assumed."""
        yes, no = set(self.said(self.environment)), set()
        # An environment that gives a property to one entity gives it to all that have it: then nothing is assumed, and
        # nothing is derived of a predicate that the domain calls complete.
        complete = set()
        for key in ("asset_properties", "object_properties"):
            for entity, entry in self.environment.get(key, {}).items():
                for word in as_list(entry):
                    for sign, predicate, terms in self.words.properties[word]:
                        fact = (predicate, *(entity.strip("<>") if term == "?self" else term for term in terms))
                        (yes if sign else no).add(fact)
                        complete |= {predicate} if sign else set()
        self.derive(yes, no, complete & self.words.complete)
        for (_, predicate, terms), when in self.words.defaults:
            for entity in self.types:
                binding = {"?self": entity}
                fact = (predicate, *(binding.get(term, term) for term in terms))
                if fact not in no and self.fits(fact) and self.truth(when, binding, frozenset(yes)):
                    yes.add(fact)
        for predicate in self.words.assumed - complete:
            [(_, kind)] = self.words.pddl.predicates[predicate]
            yes |= {(predicate, entity) for entity in self.of_type(kind) if (predicate, entity) not in no}
        return frozenset(yes)

    def fits(self, fact: tuple) -> bool:
        """True if the arguments of a fact have the types that its predicate declares."""
        declared = self.words.pddl.predicates[fact[0]]
        return all(self.words.pddl.is_a(self.types[name], kind) for name, (_, kind) in zip(fact[1:], declared))

    def derive(self, yes: set, no: set, complete: set) -> None:
        """Adds what follows from names and from other facts, until nothing more does."""
        before = None
        while before != (len(yes), len(no)):
            before = (len(yes), len(no))
            for entry in self.words.derivations:
                for binding in self.matches(entry, frozenset(yes)):
                    for sign, predicate, terms in entry["facts"]:
                        fact = (predicate, *(binding.get(term, term) for term in terms))
                        if predicate in complete or not self.fits(fact):
                            continue
                        if fact not in (no if sign else yes):
                            (yes if sign else no).add(fact)

    def matches(self, entry: dict, state: frozenset) -> list[dict]:
        """The bindings of `?self` and `?other` for which a derivation speaks."""
        entities = [name for name in self.types if (name, self.types[name]) not in self.words.pddl.constants]
        if "pattern" in entry:
            parts = [{"?self": entry["pattern"].replace("{other}", other), "?other": other} for other in entities]
            return [binding for binding in parts if binding["?self"] in entities]
        found = [{"?self": entity} for entity in entities]
        if "names" in entry:
            found = [binding for binding in found if named(binding["?self"], entry["names"])]
        if "other_names" in entry:
            others = [entity for entity in entities if named(entity, entry["other_names"])]
            found = [dict(binding, **{"?other": other}) for binding in found for other in others]
        if "when" in entry:
            found = [binding for binding in found if self.truth(entry["when"], binding, state)]
        return found

    # --- ground conditions ---------------------------------------------------------------------------------

    def truth(self, condition: tuple, binding: dict, state: frozenset) -> bool:
        """The truth of a condition in a state."""
        return holds(self.ground(condition, binding, fixed=False), state)

    def ground(self, condition: tuple, binding: dict, fixed: bool = True):
        """A condition with its variables bound; with `fixed`, what no action changes is decided at once."""
        head = condition[0]
        if head in ("and", "or"):
            return join(head, [self.ground(part, binding, fixed) for part in condition[1]])
        if head == "not":
            return negate(self.ground(condition[1], binding, fixed))
        if head in ("forall", "exists"):
            parts = [self.ground(condition[2], {**binding, **more}, fixed) for more in self.bindings(condition[1])]
            if head == "forall" and "any-for-all" in self.faults and parts:
                return join("or", parts)
            return join("and" if head == "forall" else "or", parts)
        if head == "initially":
            if "initially-now" in self.faults:
                return self.ground(condition[1], binding, fixed)
            return settled(self.ground(condition[1], binding, fixed=False), self.initial)
        if head == "=":
            if "equality" in self.faults:
                return False
            return binding.get(condition[1], condition[1]) == binding.get(condition[2], condition[2])
        fact = (condition[1], *(binding.get(term, term) for term in condition[2]))
        if fixed and condition[1] not in self.words.changing:
            return fact in self.initial
        return ("is", fact)

    def ground_effect(self, effect: tuple, binding: dict, when) -> list[tuple[object, bool, tuple]]:
        """An effect as a list of conditions, signs and facts."""
        head = effect[0]
        if head == "and":
            return [each for part in effect[1] for each in self.ground_effect(part, binding, when)]
        if head == "forall":
            choices = self.bindings(effect[1])
            return [each for more in choices for each in self.ground_effect(effect[2], {**binding, **more}, when)]
        if head == "when":
            inner = join("and", [when, self.ground(effect[1], binding)])
            return [] if inner is False else self.ground_effect(effect[2], binding, inner)
        return [(when, head == "add", (effect[1], *(binding.get(term, term) for term in effect[2])))]

    def action(self, name: str, arguments: tuple[str, ...]) -> GroundAction:
        """An action with its arguments."""
        key = (name, arguments)
        if key not in self.actions:
            action = self.words.pddl.actions[name]
            binding = dict(zip((parameter for parameter, _ in action.parameters), arguments))
            call = self.words.call_of(name)
            self.actions[key] = GroundAction(
                name,
                arguments,
                self.ground(action.condition, binding),
                self.ground_effect(action.effect, binding, True),
                [(predicate, *(binding.get(term, term) for term in terms)) for predicate, terms in call.senses],
            )
        return self.actions[key]

    def all_actions(self) -> list[GroundAction]:
        """Every action with every choice of arguments."""
        return [
            self.action(name, choice)
            for name, action in self.words.pddl.actions.items()
            for choice in itertools.product(*(self.of_type(kind) for _, kind in action.parameters))
        ]

    def apply(self, action: GroundAction, state: frozenset) -> frozenset:
        """The state after an action, as if it were applicable: deleted first, then added, all conditions asked before."""
        if "sequential-effects" in self.faults:
            for when, sign, fact in action.effects:
                if holds(when, state):
                    state = state | {fact} if sign else state - {fact}
            return state
        happens = [(sign, fact) for when, sign, fact in action.effects if holds(when, state)]
        gone = {fact for sign, fact in happens if not sign}
        come = {fact for sign, fact in happens if sign}
        return (state | come) - gone if "add-before-delete" in self.faults else (state - gone) | come

    def sense(self, action: GroundAction, state: frozenset) -> list[tuple[int, frozenset]]:
        """The outcomes that sensing can have, by their numbers, with the state after each."""
        known = [number for number, fact in enumerate(action.senses) if fact in state]
        numbers = known or range(len(action.senses))
        if "one-outcome" in self.faults:
            numbers = [0]
        return [(number, state | {action.senses[number]}) for number in numbers]

    def outcome_groups(self, fact: tuple) -> list[list[tuple]]:
        """For each sensing action that can tell a fact, all facts of which it tells one."""
        groups = []
        for call in self.words.calls.values():
            for predicate, terms in call.senses:
                if predicate == fact[0]:
                    binding = dict(zip(terms, fact[1:]))
                    groups.append([(name, *(binding.get(term, term) for term in more)) for name, more in call.senses])
        return groups

    # --- rules ----------------------------------------------------------------------------------------------

    def ground_rules(self, holds_when: str) -> list[tuple[str, tuple, object]]:
        """The rules of one sort: name, binding of the outermost `forall`, condition."""
        return [
            (rule.name, tuple(binding.values()), self.ground(rule.condition, binding))
            for rule in self.words.rules
            if rule.holds == holds_when
            for binding in self.bindings(rule.variables)
        ]

    def broken(self, sort: str, state: frozenset) -> list[tuple[str, tuple]]:
        """The rules of a sort that a state breaks, with their bindings."""
        return [(name, binding) for name, binding, condition in self.rules[sort] if not holds(condition, state)]

    def newly_broken(self, before: frozenset, after: frozenset) -> list[str]:
        """The `always` rules that were kept before a step and are broken after it."""
        if "no-always" in self.faults or before == after:
            return []
        return [
            name
            for name, _, condition in self.rules["always"]
            if not holds(condition, after) and holds(condition, before)
        ]

    def written(self, state: frozenset) -> frozenset:
        """The facts of a state that an environment can say."""
        predicates = {word.predicate for word in self.words.states.values()} - self.words.events
        return frozenset(fact for fact in state if fact[0] in predicates)
