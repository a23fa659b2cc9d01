"""Goals and constraints with groups: `put(all cup where dirty except mug, sink)`, written from docs/reference/goals.md.

A group stands for entities of the environment. `all` is one goal for each of them; the other quantifiers are one condition
over all combinations, so that a breadth-first search needs to know nothing of groups.
"""

import itertools
from dataclasses import dataclass, field, replace
from random import Random

from .render import written
from .world import World, complement, join, stem

ANYTHING = ("thing", "object")


class Refused(Exception):
    """A goal that makes no sense and is an error."""


@dataclass(frozen=True)
class Group:
    """A quantifier, a kind, conditions as (sign, word, arguments), and exceptions."""

    quantifier: str
    kind: str
    number: int = 0
    where: tuple = ()
    exceptions: tuple = ()
    parentheses: bool = True

    def text(self, world: World, ambiguous: bool = False) -> str:
        """The group as `longstep solve --goal` reads it; exceptions are in parentheses where their end is `ambiguous`."""
        word = {"some": f"{self.number} of", "exactly": f"exactly {self.number} of"}.get(self.quantifier, self.quantifier)
        text = f"{word} {self.kind}"
        if self.where:
            text += " where " + " & ".join(condition_text(world, *condition) for condition in self.where)
        names = ", ".join(written(world, name) for name in self.exceptions)
        if ambiguous or (len(self.exceptions) > 1 and self.parentheses):
            names = f"({names})"
        return f"{text} except {names}" if self.exceptions else text

    def is_type(self, world: World) -> bool:
        """True if the kind is a type, whether or not entities are called so."""
        return singular(self.kind) in ANYTHING or kind_type(world, self.kind) is not None

    def members(self, world: World) -> list[str]:
        """The entities that the group stands for, in the order of the environment."""
        kind = kind_type(world, self.kind)
        if kind is not None and kind != "object":
            found = world.of_type(kind)
        elif singular(self.kind) in ANYTHING:
            constants = dict(world.words.pddl.constants)
            found = [name for name in world.types if name not in constants]
        else:
            kind = singular(self.kind)
            found = [name for name in world.types if kind in map(singular, kinds_by_name(world, name))]
        found = [name for name in found if name not in self.exceptions]
        found = [name for name in found if all(meets(world, name, condition) for condition in self.where)]
        if not found:
            raise Refused
        if "forgetful" in world.faults and self.quantifier == "all" and len(found) > 1:
            return found[:-1]
        return found


@dataclass(frozen=True)
class Choice:
    """A goal over groups without `all`: the groups with their members, and a goal for each combination that makes sense."""

    groups: tuple
    members: tuple
    goals: tuple

    def condition(self, world: World, bound):
        """The ground condition."""
        goals = dict(self.goals)

        def nested(level: int, chosen: tuple):
            if level == len(self.groups):
                return bound(world, *goals[chosen]) if chosen in goals else False
            parts = [nested(level + 1, (*chosen, member)) for member in self.members[level]]
            return counted(self.groups[level], parts)

        return nested(0, ())


def counted(group: Group, parts: list):
    """The condition that as many parts hold as a group requires."""
    if group.quantifier == "any":
        return join("or", parts)
    ways = []
    for chosen in itertools.combinations(range(len(parts)), group.number):
        way = [parts[number] for number in chosen]
        if group.quantifier == "exactly":
            way += [complement(parts[number]) for number in range(len(parts)) if number not in chosen]
        ways.append(join("and", way))
    return join("or", ways)


def is_overloaded(world: World, form: str) -> bool:
    """True if the name of a goal takes different numbers of arguments, so that a comma may end a group or continue it."""
    words, name = world.words, form.split("(")[0]
    counts = {len(goal.parameters) for other, goal in words.goals.items() if other.split("(")[0] == name}
    counts |= {len(state.parameters) + 1 for state in words.states.values() if state.name == name}
    counts |= {len(parameters) for predicate, parameters in words.pddl.predicates.items() if predicate == name}
    return len(counts) > 1


def kind_type(world: World, kind: str) -> str | None:
    """The type that a kind names, in the singular or the plural."""
    return next((own for own in (kind, singular(kind)) if own in types(world)), None)


def types(world: World) -> set[str]:
    """The names of the domain's types."""
    return world.words.pddl.type_names()


def names_of(world: World, name: str) -> list[str]:
    """The everyday names of an entity, without its number."""
    bare = stem(name).lower()
    return [*world.words.lexicon.get(bare, []), bare.replace("_", " ")]


def kinds_by_name(world: World, name: str) -> list[str]:
    """The kinds to which the names of an entity belong: each name, and its last words."""
    kinds = []
    for words in (own.split() for own in names_of(world, name)):
        kinds += [" ".join(words[start:]) for start in range(len(words))]
    return kinds


def singular(kind: str) -> str:
    """A kind without the plural ending of its last word; enough for the names in the scenes."""
    return kind[:-1] if kind.endswith("s") and not kind.endswith(("ss", "us")) else kind


def condition_text(world: World, sign: bool, word: str, arguments: tuple) -> str:
    """A condition of a group."""
    inner = ", ".join(written(world, name) for name in arguments)
    return ("" if sign else "not ") + (f"{word}({inner})" if inner else word)


def meets(world: World, name: str, condition: tuple) -> bool:
    """True if an entity meets a condition at the beginning."""
    sign, word, arguments = condition
    if word in world.words.states:
        fact = world.fact_of_word(name, f"{word}({', '.join(arguments)})")
        return (fact in world.initial) == sign
    literals = world.words.properties[word]
    facts = [(holds, (predicate, *(name if term == "?self" else term for term in terms))) for holds, predicate, terms in literals]
    return all((fact in world.initial) == holds for holds, fact in facts) == sign


def combinations(world: World, form: str, arguments: tuple, offered: bool) -> list[tuple[tuple, tuple]]:
    """The members of the groups and the arguments, for each combination that makes sense."""
    goal = world.words.goals[form]
    places = [place for place, argument in enumerate(arguments) if isinstance(argument, Group)]
    typed = any(arguments[place].is_type(world) for place in places)
    found = []
    for members in itertools.product(*(arguments[place].members(world) for place in places)):
        own = list(arguments)
        for place, member in zip(places, members):
            own[place] = member
        if any(not world.words.pddl.is_a(world.types[own[place]], goal.parameters[place][1]) for place in places):
            continue
        if any(own.count(member) > 1 for member in members):
            continue
        binding = dict(zip((name for name, _ in goal.parameters), own))
        if offered and typed and goal.offered is not None and world.ground(goal.offered, binding) is False:
            continue
        found.append((members, tuple(own)))
    if not found:
        raise Refused
    return found


def goals_of(world: World, form: str, arguments: tuple, offered: bool = True, complete: bool = True) -> list[tuple]:
    """The goals that a goal with groups stands for."""
    groups = [argument for argument in arguments if isinstance(argument, Group)]
    if not groups:
        return [(form, arguments)]
    found = combinations(world, form, arguments, offered)
    plain = [argument for argument in arguments if not isinstance(argument, Group)]
    for place, group in enumerate(groups):
        if complete and group.quantifier == "all" and not group.is_type(world):
            fitting = {members[place] for members, _ in found} | set(plain)
            if not set(group.members(world)) <= fitting:
                raise Refused
    outer = [place for place, group in enumerate(groups) if group.quantifier == "all"]
    inner = [place for place, group in enumerate(groups) if group.quantifier != "all"]
    cases: dict[tuple, list] = {}
    for members, own in found:
        key = tuple(members[place] for place in outer)
        cases.setdefault(key, []).append((tuple(members[place] for place in inner), (form, own)))
    goals: list[tuple] = []
    for own in cases.values():
        if not inner:
            goals += [goal for _, goal in own]
            continue
        chosen = tuple(groups[place] for place in inner)
        members = []
        for place, group in enumerate(chosen):
            taking = list(dict.fromkeys(taken[place] for taken, _ in own))
            if group.quantifier != "any" and not 0 < group.number <= len(taking):
                raise Refused
            members.append(tuple(taking))
        goals.append((Choice(chosen, tuple(members), tuple(own)), ()))
    return goals


def constraint_of(world: World, word: str, subject) -> list[tuple]:
    """The constraints that one with groups stands for."""
    if word == "untouched":
        if isinstance(subject, Group) and subject.quantifier in ("some", "exactly"):
            raise Refused
        return [(word, name) for name in (subject.members(world) if isinstance(subject, Group) else [subject])]
    form, arguments = subject
    groups = [argument for argument in arguments if isinstance(argument, Group)]
    each = ("all", "any") if word == "never" else ("all",)
    if all(group.quantifier in each for group in groups):
        own = tuple(replace(argument, quantifier="all") if isinstance(argument, Group) else argument for argument in arguments)
    else:
        own = arguments
    return [(word, goal) for goal in goals_of(world, form, own, offered=word == "always", complete=False)]


def expanded(world: World, case):
    """The case without groups; raises `Refused` where it is an error."""
    goals: list[tuple] = []
    stages: list[int] = []
    start = 0
    for number, goal in enumerate(case.goals):
        if number in case.stages and start < len(goals):
            start = len(goals)
            stages.append(start)
        for own in goals_of(world, *goal):
            if own not in goals[start:]:
                goals.append(own)
    constraints = [own for constraint in case.constraints for own in constraint_of(world, *constraint)]
    return case.changed(goals=goals, stages=stages, constraints=constraints)


# --- random groups ------------------------------------------------------------------------------------------------


@dataclass
class Grouper:
    """Puts groups into goals."""

    world: World
    random: Random
    names: list[str] = field(default_factory=list)

    def __post_init__(self):
        constants = dict(self.world.words.pddl.constants)
        self.names = [name for name in self.world.types if name not in constants]

    def goal(self, goal: tuple, chance: float = 0.6) -> tuple:
        """A goal with groups in some of its places."""
        form, arguments = goal
        return form, tuple(self.group(name) if self.random.random() < chance else name for name in arguments)

    def group(self, name: str) -> Group:
        """A group to which an entity belongs, unless a condition or an exception is unlucky."""
        random, world = self.random, self.world
        named = kinds_by_name(world, name)
        above = [kind for kind in types(world) if world.words.pddl.is_a(world.types[name], kind)]
        kind = random.choice([random.choice(named), random.choice(named), random.choice(sorted(above)), *ANYTHING[:1]])
        quantifier = random.choice(["all", "all", "any", "any", "some", "exactly"])
        where = []
        while random.random() < 0.35 and len(where) < 2:
            condition = self.condition(name)
            if condition is not None:
                where.append(condition)
        exceptions = [other for other in self.names if other != name and random.random() < 0.15]
        return Group(
            quantifier,
            kind,
            random.choice([1, 2, 2, 3]) if quantifier in ("some", "exactly") else 0,
            tuple(where),
            tuple(exceptions[:3]),
            random.random() < 0.6,
        )

    def condition(self, name: str) -> tuple | None:
        """A condition on the beginning that an entity meets."""
        random, world = self.random, self.world
        told = {predicate for call in world.words.calls.values() for predicate, _ in call.senses}
        words = [word.name for word in world.words.states.values() if word.predicate not in told]
        words += list(world.words.properties)
        if not words:
            return None
        word = random.choice(words)
        state = world.words.states.get(word)
        arguments = tuple(random.choice(self.names) for _ in state.parameters) if state else ()
        if any(argument == name for argument in arguments):
            return None
        return (meets(world, name, (True, word, arguments)), word, arguments)


def several(environment_text: str, objects: list[str], random: Random) -> str:
    """An environment in which some entities share their name."""
    chosen = [name for name in objects if random.random() < 0.6 and not name.strip("<>").endswith("handle")]
    for number, name in enumerate(chosen):
        environment_text = environment_text.replace(name, f"<beaker_{number + 71}>")
    return environment_text
