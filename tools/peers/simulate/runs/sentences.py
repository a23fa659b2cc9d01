"""Sentences about facts and numbers, as the log of a run has them, read back: the words are those of domain.toml."""

import re

from ..groups import names_of
from ..pddl import millionths
from .world import NumberWorld

NUMBER = re.compile(r"^(.*) (?:is|=) (-?[0-9.]+)(?: \S+)?$")
UNKNOWN = re.compile(r"^(.*) (?:is not known|is unknown)$")


class Sentences:
    """The sentences of a world."""

    def __init__(self, world: NumberWorld):
        self.world = world
        self.facts: dict[str, tuple[tuple, bool]] = {}
        self.numbers: dict[str, tuple] = {}
        for predicate, (says, denies) in world.words.sentences.items():
            parameters = world.words.pddl.predicates[predicate]
            for binding in world.bindings(parameters):
                names = {name[1:]: self.name(own) for name, own in binding.items()}
                for text, holds in ((says, True), (denies, False)):
                    self.facts[filled(text, names)] = ((predicate, *binding.values()), holds)
        for word in world.words.numbers.values():
            parameters = world.words.pddl.functions[word.name]
            for key in world.keys(word.name):
                names = {name[1:]: self.name(own) for (name, _), own in zip(parameters, key[1:])}
                self.numbers[filled(word.says, names)] = key

    def name(self, entity: str) -> str:
        """The everyday name of an entity, with its article."""
        own = names_of(self.world, entity)[0]
        return own if re.search(r"\d", own) else f"the {own}"

    def read(self, text: str) -> tuple[tuple, object] | None:
        """The fact or number that a sentence is about, and its value; None for a sentence that means nothing here."""
        if text in self.facts:
            return self.facts[text]
        match = UNKNOWN.match(text)
        if match and match[1] in self.numbers:
            return ("#", self.numbers[match[1]]), None
        match = NUMBER.match(text)
        if match and match[1] in self.numbers:
            return ("#", self.numbers[match[1]]), millionths(match[2])
        return None


def filled(text: str, names: dict[str, str]) -> str:
    """A sentence with names in the place of its parameters."""
    for name, own in names.items():
        text = text.replace("{" + name + "}", own)
    return text
