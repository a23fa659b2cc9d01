"""A synthetic robot: goal words, entities, the system prompt and one scene, all drawn from the lexicon."""

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from inflection import ADJECTIVES
from lexicon import LANGUAGES, GoalWord, Noun
from phrases import ADVICE, AMOUNTS, EXTRA_FACTS, EXTRA_FACTS_ANCHOR, PARAMETER_NAMES, PEOPLE, TASKS


@dataclass(frozen=True)
class NamedPerson:
    """A person with a proper name."""

    name: str
    kind: str = "person"


@dataclass(frozen=True)
class NounEntity:
    """An entity that is called by a noun, with an adjective or none. A namesake is another entity with the same noun."""

    noun: Noun
    adjective: str | None
    name: str
    kind: str
    has_namesake: bool = False


@dataclass(frozen=True)
class Amount:
    """A number with a unit, or with none ("")."""

    number: int
    unit: str


Entity = NamedPerson | NounEntity
Argument = Entity | Amount


class DrawnGoal(NamedTuple):
    """A goal word with its arguments, and the goal in the goal language."""

    word: GoalWord
    arguments: list[Argument]
    text: str


def goal_text(word: GoalWord, arguments: Sequence[Argument]) -> str:
    """Returns a goal in the goal language, such as `brought(red cup, shelf)`."""
    names = [
        f"{argument.number} {argument.unit}".strip() if isinstance(argument, Amount) else argument.name
        for argument in arguments
    ]
    return f"{word.name}({', '.join(names)})"


class Robot:
    """A robot with goal words, entities, a system prompt and one scene. All of it is drawn when it is constructed."""

    def __init__(
        self,
        name: str,
        nouns: Mapping[str, Sequence[Noun]],
        all_goal_words: Sequence[GoalWord],
        prompt_ending: str,
        rng: random.Random,
    ) -> None:
        """`prompt_ending` is the part of the system prompt that all robots share."""
        self.name = name
        self.nouns = nouns
        self.all_goal_words = all_goal_words
        self.rng = rng
        self.goal_words = self.draw_goal_words()
        self.entities: list[Entity] = []
        self.entities_by_kind: dict[str, list[Entity]] = {kind: [] for kind in nouns}
        self.used_names: set[str] = set()
        self.draw_entities()
        self.system_prompt = self.draw_system_prompt(prompt_ending)
        self.scene = self.draw_scene()

    def draw_goal_words(self) -> list[GoalWord]:
        """Draws 6 to 12 goal words, mostly with their opposites: what can be opened can be closed."""
        rng = self.rng
        count = rng.randint(6, 12)
        drawn: list[GoalWord] = []
        for word in rng.sample(self.all_goal_words, len(self.all_goal_words)):
            if len(drawn) >= count:
                break
            if word in drawn:
                continue
            drawn.append(word)
            opposite = next((other for other in self.all_goal_words if other.name == word.opposite), None)
            if opposite and opposite not in drawn and rng.random() < 0.8:
                drawn.append(opposite)
        rng.shuffle(drawn)
        return drawn

    def draw_unused_noun(self, kind: str) -> tuple[Noun, set[str]] | None:
        """Draws a noun none of whose synonyms is in use, and returns it with all its names; None after 30 vain draws."""
        for _ in range(30):
            noun = self.rng.choice(self.nouns[kind])
            names = {synonym.lower() for language in LANGUAGES for synonym in noun.synonyms[language]} | {noun.name}
            if not names & self.used_names:
                return noun, names
        return None

    def add_entity(self, kind: str) -> None:
        """Adds an entity of a kind, or two namesakes with different adjectives; none if the drawn name is in use."""
        rng = self.rng
        added: list[Entity]
        if kind == "person" and rng.random() < 0.5:
            person = rng.choice(PEOPLE).replace("_", " ")
            if person.lower() in self.used_names:
                return
            self.used_names.add(person.lower())
            added = [NamedPerson(person)]
        else:
            drawn = self.draw_unused_noun(kind)
            if drawn is None:
                return
            noun, names = drawn
            self.used_names |= names
            added = [NounEntity(noun, None, noun.name, kind)]
            if kind != "person" and rng.random() < 0.16:
                count = rng.choice([1, 2])
                added = [
                    NounEntity(noun, adjective, f"{adjective} {noun.name}", kind, has_namesake=count == 2)
                    for adjective in rng.sample(list(ADJECTIVES), count)
                ]
        self.entities += added
        self.entities_by_kind[kind] += added

    def draw_entities(self) -> None:
        """Adds two to five entities of each kind that a goal word takes, and some that no goal word takes."""
        needed = {kind for word in self.goal_words for kind in word.takes if not kind.startswith("value")}
        for kind in sorted(needed):
            for _ in range(self.rng.randint(2, 5)):
                self.add_entity(kind)
        for kind in self.rng.sample(sorted(self.nouns), 3):
            if kind not in needed:
                self.add_entity(kind)
        self.rng.shuffle(self.entities)

    def goal_word_line(self, word: GoalWord) -> str:
        """Returns the line of a goal word in the system prompt."""
        names: list[str] = []
        for kind in word.takes:
            name = "AMOUNT" if kind.startswith("value") else self.rng.choice(PARAMETER_NAMES[kind])
            names.append(name if name not in names else name + "2")
        return f"- {word.name}({', '.join(names)}): {word.means}"

    def draw_system_prompt(self, ending: str) -> str:
        """Returns a system prompt with the goal words of the robot."""
        rng = self.rng
        place = rng.choice(self.nouns["place"]).name
        robot = rng.choice([f"robot in the {place}", "household robot", "robot", f"robot that works at the {place}"])
        task = rng.choice(TASKS).format(robot=robot, place=f"the {place}")
        goal_words = "\n".join(self.goal_word_line(word) for word in self.goal_words)
        if rng.random() < 0.5:
            facts = rng.choice(EXTRA_FACTS)
            ending = ending.replace(EXTRA_FACTS_ANCHOR, f"- behind never and always also: {facts}\n{EXTRA_FACTS_ANCHOR}")
        return f"{task}\n\nA goal is one of these:\n{goal_words}\n\n{ADVICE}{ending}"

    def draw_scene(self) -> str:
        """Returns the lines of the objects and the places with drawn states, up to the instruction."""
        rng = self.rng
        place_kinds = {"place", "furniture", "container", "door", "device"} | ({"person"} if rng.random() < 0.5 else set())
        supports = [entity for entity in self.entities if entity.kind in ("place", "furniture", "container")]
        usual = {"door": "opens", "container": "opens", "device": "switch", "furniture": "has a top"}
        properties = {kind: rng.choice([kind, None, usual.get(kind, kind)]) for kind in self.nouns}
        objects: list[str] = []
        places: list[str] = []
        for entity in self.entities:
            kind, kind_property = entity.kind, properties[entity.kind]
            states: list[str] = []
            if kind in place_kinds:
                states += [kind_property] if kind_property else []
                if kind in ("door", "container", "device") and rng.random() < 0.4:
                    states.append("on" if kind == "device" else "open")
                if kind == "place" and rng.random() < 0.1:
                    states.append("robot here")
            else:
                if supports and rng.random() < 0.85:
                    states.append(rng.choice(["at ", "on ", "in "]) + rng.choice(supports).name)
                if kind_property and kind != "thing":
                    states.insert(rng.randint(0, len(states)), kind_property)
            line = f"- {entity.name}: {', '.join(states)}\n" if states else f"- {entity.name}\n"
            (places if kind in place_kinds else objects).append(line)
        return "Objects:\n" + "".join(objects) + "Places:\n" + "".join(places) + "\nInstruction:"

    def draw_arguments(self, word: GoalWord) -> list[Argument] | None:
        """Draws different entities, or amounts, for the arguments of a goal word; None if there are too few entities."""
        arguments: list[Argument] = []
        for kind in word.takes:
            if kind.startswith("value"):
                unit = kind.partition(":")[2]
                least, greatest, _ = AMOUNTS.get(unit, AMOUNTS[""])
                arguments.append(Amount(self.rng.randint(least, greatest), unit))
                continue
            others = [entity for entity in self.entities_by_kind[kind] if entity not in arguments]
            if not others:
                return None
            arguments.append(self.rng.choice(others))
        return arguments

    def draw_goal(self) -> DrawnGoal | None:
        """Draws a goal; None if there are too few entities for the drawn goal word."""
        word = self.rng.choice(self.goal_words)
        arguments = self.draw_arguments(word)
        return DrawnGoal(word, arguments, goal_text(word, arguments)) if arguments else None
