"""Random domains with numbers, their environments, and walks through them."""

from pathlib import Path
from random import Random

from .. import scenes
from ..domains import EXAMPLES, GOAL_PROMPT, Maker
from ..numbers import MILLION, State, decimal
from ..render import written
from ..world import GroundAction
from .sentences import Sentences
from .world import NumberWorld

NUMBERS_ONE, NUMBERS_NONE = ["level", "weight"], ["charge", "spares"]
SIGNS = ["<", "<=", "=", ">=", ">"]


class NumberMaker(Maker):
    """Makes one random domain whose actions read and change numbers."""

    def __init__(self, random: Random):
        super().__init__(random, sensing=False)
        # Environments have no entries for constants, so that nothing could show their states.
        self.constant = False
        self.functions: dict[str, list[str]] = {}
        for name in random.sample(NUMBERS_ONE, random.choice([0, 1, 1, 2])):
            self.functions[name] = [self.kind()]
        for name in random.sample(NUMBERS_NONE, random.choice([0, 0, 1])):
            self.functions[name] = []

    def fluent_of(self, scope: dict[str, str]) -> str | None:
        """A number over the scope."""
        options = []
        for name, kinds in self.functions.items():
            terms = self.terms(kinds, scope)
            if terms is not None:
                options.append(f"({name} {terms})" if terms else f"({name})")
        return self.random.choice(options) if options else None

    def atom(self, scope: dict[str, str], positive: bool, changing: bool = False) -> str | None:
        """An atom over the scope, or a comparison."""
        number = self.fluent_of(scope)
        if changing or number is None or self.random.random() > 0.25:
            return super().atom(scope, positive, changing)
        return f"({self.random.choice(SIGNS)} {number} {self.amount(scope)})"

    def amount(self, scope: dict[str, str]) -> str:
        """A number, or a small expression."""
        own = self.fluent_of(scope)
        plain = self.random.choice(["0", "1", "1", "2", "2", "3", "0.5"])
        if own is None or self.random.random() < 0.8:
            return plain
        return own if self.random.random() < 0.6 else f"({self.random.choice('+-*/')} {own} {plain})"

    def effect(self, scope: dict[str, str], depth: int = 2) -> str | None:
        """One effect, on a fact or on a number."""
        number = self.fluent_of(scope)
        if number is None or self.random.random() > 0.3:
            return super().effect(scope, depth)
        change = self.random.choice(["increase", "increase", "decrease", "decrease", "assign"])
        return f"({change} {number} {self.amount(scope)})"

    def header(self) -> str:
        """The beginning of domain.pddl, with the functions."""
        text = super().header().replace(":equality)", ":equality :numeric-fluents)")
        declared = [f"({name}" + "".join(f" ?a - {kind}" for kind in kinds) + ")" for name, kinds in self.functions.items()]
        return text + (f"\n  (:functions {' '.join(declared)})" if declared else "")

    def words_of_predicates(self, toml: list[str]) -> None:
        """The words for predicates and numbers."""
        super().words_of_predicates(toml)
        for name, kinds in self.functions.items():
            toml.append(f'[[number]]\nname = "{name}"\nsays = "the {name}{" of {a}" if kinds else ""}"')
            if self.random.random() < 0.75:
                toml.append(f"min = {self.random.choice([0, 0, -1])}\nmax = {self.random.choice([3, 4, 6])}")

    def action(self, name: str, pddl: list[str], toml: list[str]) -> None:
        """An action; some declare how often they are tried again."""
        super().action(name, pddl, toml)
        if self.random.random() < 0.4:
            toml[-1] += f"\nretries = {self.random.choice([0, 1, 3])}"


def write(folder: Path, random: Random) -> Path:
    """Writes a random domain into a folder."""
    domain, words = NumberMaker(random).make()
    (folder / "prompt").mkdir(parents=True, exist_ok=True)
    for name, text in (("domain.pddl", domain), ("domain.toml", words)):
        (folder / name).write_text(text)
    for name, text in (("goal.md", GOAL_PROMPT), ("examples.toml", EXAMPLES)):
        (folder / "prompt" / name).write_text(text)
    return folder


def environment(random: Random, words) -> dict:
    """An environment for a random domain, with numbers."""
    made = scenes.any_domain(random, words)
    facts: list[str] = []
    for word, number in words.numbers.items():
        declared = words.pddl.functions[number.name]
        low = 0 if number.least is None else number.least // MILLION
        high = 4 if number.most is None else number.most // MILLION
        if not declared:
            facts.append(f"{word}({random.randint(low, high)})")
            continue
        for key, entry, kind in (
            ("assets", "asset_states", words.asset_type),
            ("objects", "object_states", words.object_type),
        ):
            for name in made[key]:
                if words.pddl.is_a(kind, declared[0][1]) and random.random() < 0.93:
                    made[entry].setdefault(name, []).append(f"{word}({random.randint(low, high)})")
    plain = [name for name, declared in words.pddl.predicates.items() if not declared and name not in words.events]
    facts += [name for name in plain if random.random() < 0.5]
    if facts or plain:
        made["facts"] = facts
    return made


class Entries:
    """What an environment and an observation can say of each entity of a world."""

    def __init__(self, world: NumberWorld):
        self.world = world
        self.keys: dict[str | None, list[tuple]] = {}
        constants = dict(world.words.pddl.constants)
        for key, subject in world.subjects.items():
            if subject not in constants:
                self.keys.setdefault(subject, []).append(key)
        self.texts = {key: self.template(key) for keys in self.keys.values() for key in keys}
        self.entities = [name for name in world.types if name not in constants]
        self.visible = set(self.texts)
        self.sentences = Sentences(world)

    def template(self, key: tuple) -> str:
        """The statement for a fact; that for a number lacks its value."""
        if key[0] == "#":
            name = key[1][0]
            word = next(own for own, number in self.world.words.numbers.items() if number.name == name)
            more = "".join(f"{written(self.world, other)}, " for other in key[1][2:])
            return f"{word}({more}%s)"
        for word in self.world.words.states.values():
            if word.predicate == key[0]:
                binding = dict(zip(word.terms, key[1:]))
                return f"{word.name}({', '.join(written(self.world, binding[name]) for name in word.parameters)})"
        return key[0]

    def statements(self, subject: str | None, state: State) -> list[str]:
        """The statements about an entity, or those without a subject, in a state."""
        said = []
        for key in self.keys.get(subject, []):
            if key[0] != "#":
                if key in state:
                    said.append(self.texts[key])
            elif key[1] in state.numbers:
                said.append(self.texts[key] % decimal(state.numbers[key[1]]))
        return said

    def calls(self) -> list[GroundAction]:
        """The actions that a plan can have: their conditions are not false for good."""
        return [action for action in self.world.all_actions() if action.condition is not False]
