"""Reads the lexicon of synthetic robots: nouns and goal words in five languages."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

FOLDER = Path(__file__).parent / "synthetic"
LANGUAGES = ("en", "de", "fr", "es", "ja")


@dataclass(frozen=True)
class Noun:
    """A noun of the lexicon with its class, such as `furniture`, and its synonyms in each language, the usual one first.

    German, French and Spanish synonyms begin with their article; a German plural begins with `pl:`.
    """

    name: str
    kind: str
    synonyms: Mapping[str, list[str]]


@dataclass(frozen=True)
class GoalWord:
    """A goal word with the classes of its arguments and, in each language, templates that request it or prohibit it.

    A template has `{X}` and `{Y}` for the arguments, with a German case or a preposition if it governs one: `{X:dat}`, `{Y:de}`.
    """

    name: str
    takes: list[str]
    means: str
    opposite: str | None
    requests: Mapping[str, list[str]]
    prohibitions: Mapping[str, list[str]]


def read_nouns(folder: Path = FOLDER) -> dict[str, list[Noun]]:
    """Returns the nouns by class. The first noun of a name counts; an entry without synonyms in all languages is left out."""
    nouns: dict[str, list[Noun]] = {}
    known: set[str] = set()
    for path in sorted(folder.glob("nouns-*.tsv")):
        with open(path, encoding="utf-8") as lines:
            for line in lines:
                name, kind, *columns = line.rstrip("\n").split("\t")
                synonyms = {
                    language: [synonym.strip().replace("’", "'") for synonym in column.split("/") if synonym.strip()]
                    for language, column in zip(LANGUAGES, columns)
                }
                if name not in known and len(synonyms) == len(LANGUAGES) and all(synonyms.values()):
                    known.add(name)
                    nouns.setdefault(kind, []).append(Noun(name, kind, synonyms))
    return nouns


def read_goal_words(folder: Path = FOLDER) -> list[GoalWord]:
    """Returns the goal words. The first one of a name counts."""
    words: dict[str, GoalWord] = {}
    for path in sorted(folder.glob("words-*.toml")):
        with open(path, "rb") as file:
            for entry in tomllib.load(file)["word"]:
                words.setdefault(entry["name"], GoalWord(
                    name=entry["name"],
                    takes=entry["takes"],
                    means=entry["means"],
                    opposite=entry.get("opposite"),
                    requests={language: entry[language] for language in LANGUAGES},
                    prohibitions={language: entry[f"not_{language}"] for language in LANGUAGES},
                ))
    return list(words.values())
