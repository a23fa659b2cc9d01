"""Renders goals of a synthetic robot as sentences in five languages."""

import random
import re
from collections.abc import Sequence

from inflection import ADJECTIVES, GERMAN_CONTRACTIONS, french, german, spanish
from lexicon import LANGUAGES, GoalWord
from phrases import AMOUNTS, UNTOUCHED, WITHOUT
from synthetic_robot import Amount, Argument, Entity, NamedPerson, NounEntity

PLACEHOLDER = re.compile(r"\{([XY])(?::(\w+))?\}")


def without_full_stop(text: str) -> str:
    """Returns a sentence without its final full stop, exclamation mark or question mark."""
    return text.rstrip(" .!。！?？")


def in_sentence(text: str, language: str) -> str:
    """Returns a text as it is written within a sentence. German keeps its capital: the first word may be a noun."""
    return text if language == "de" else text[:1].lower() + text[1:]


def render_person(person: NamedPerson, language: str, form: str, rng: random.Random) -> str:
    """Returns the name of a person with its German case, its preposition, or a Japanese honorific."""
    name = person.name
    if language == "fr":
        return {"à": f"à {name}", "de": ("d'" if name[0] in "AEIOUÉ" else "de ") + name}.get(form, name)
    if language == "es":
        return {"a": f"a {name}", "de": f"de {name}"}.get(form, name)
    if language == "ja":
        return name + rng.choice(["さん", "さん", ""])
    if language == "de":
        mister = "Herrn " if form in ("acc", "dat") else "Herr "
        return name.replace("Mr ", mister).replace("Mrs ", "Frau ").replace("Ms ", "Frau ")
    return name


def render_noun(entity: NounEntity, language: str, form: str, omits_adjective: bool, rng: random.Random) -> str:
    """Returns a noun phrase for an entity, with one of its synonyms."""
    adjective = None if omits_adjective else entity.adjective
    synonyms = entity.noun.synonyms[language]
    synonym = rng.choice(synonyms) if rng.random() < 0.55 else synonyms[0]
    if language == "en":
        return f"the {adjective} {synonym}" if adjective else f"the {synonym}"
    if language == "de":
        return german(synonym, form or "nom", adjective)
    if language == "fr":
        return french(synonym, form, adjective)
    if language == "es":
        return spanish(synonym, form, adjective)
    return (ADJECTIVES[adjective].japanese if adjective else "") + synonym


class Phrasing:
    """Draws sentences. All draws come from one generator."""

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng

    def render(self, argument: Argument, language: str, form: str, omits_adjective: bool) -> str:
        """Returns an argument as a phrase; `form` is a German case or a preposition, or empty."""
        if isinstance(argument, Amount):
            phrases = AMOUNTS.get(argument.unit, AMOUNTS[""])[2]
            return phrases[LANGUAGES.index(language)].format(argument.number)
        if isinstance(argument, NamedPerson):
            return render_person(argument, language, form, self.rng)
        return render_noun(argument, language, form, omits_adjective, self.rng)

    def fill(self, template: str, language: str, arguments: Sequence[Argument], omits_adjective: Sequence[bool]) -> str:
        """Returns a template with its arguments; it mostly begins with a capital letter."""
        def replacement(match: re.Match[str]) -> str:
            index = 0 if match[1] == "X" else 1
            return self.render(arguments[index], language, match[2] or "", omits_adjective[index])

        text = PLACEHOLDER.sub(replacement, template)
        if language == "de":
            text = self.contracted(text)
        return text[:1].upper() + text[1:] if self.rng.random() < 0.85 else text[:1].lower() + text[1:]

    def contracted(self, text: str) -> str:
        """Returns a German text in which a preposition mostly contracts with its article."""
        for separate, contraction in GERMAN_CONTRACTIONS:
            if self.rng.random() < 0.9:
                text = text.replace(f" {separate}", f" {contraction}")
            if text.lower().startswith(separate):
                text = contraction.capitalize() + text[len(separate):]
        return text

    def omitted_adjectives(self, arguments: Sequence[Argument]) -> list[bool]:
        """Draws for each argument whether its adjective is omitted: half of the time, where no namesake needs it."""
        return [
            isinstance(argument, NounEntity) and bool(argument.adjective) and not argument.has_namesake and self.rng.random() < 0.5
            for argument in arguments
        ]

    def request(self, word: GoalWord, arguments: Sequence[Argument], language: str) -> str:
        """Returns a sentence that asks for a goal."""
        template = self.rng.choice(word.requests[language])
        return self.fill(template, language, arguments, self.omitted_adjectives(arguments))

    def prohibition(self, word: GoalWord, arguments: Sequence[Argument], language: str) -> str:
        """Returns a sentence or a clause that prohibits a goal."""
        template = self.rng.choice(word.prohibitions[language])
        return self.fill(template, language, arguments, self.omitted_adjectives(arguments))

    def whole_prohibition(self, word: GoalWord, arguments: Sequence[Argument], language: str) -> str | None:
        """Returns a sentence that prohibits a goal and can stand alone; None if the goal word has no such template."""
        templates = [
            template for template in word.prohibitions[language]
            if not template.lower().startswith(WITHOUT[language]) and not template.endswith(("ずに", "に"))
        ]
        if not templates:
            return None
        template = self.rng.choice(templates)
        return self.fill(template, language, arguments, self.omitted_adjectives(arguments))

    def untouched(self, entity: Entity, language: str) -> str:
        """Returns a sentence that forbids touching an entity."""
        template = self.rng.choice(UNTOUCHED[language])
        return self.fill(template, language, [entity], self.omitted_adjectives([entity]))

    def ended(self, text: str) -> str:
        """Returns a text that mostly ends with a full stop."""
        return text if text.rstrip()[-1:] in ".!?。！？…" else text + self.rng.choice([".", "", "."])
