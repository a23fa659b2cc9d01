#!/usr/bin/env python3
"""Makes synthetic robots from a lexicon, and requests to them in five languages: training data for vocabulary.

    synthetic.py DATA.jsonl OUT.jsonl [--robots N] [--cases N] [--seed S]

The entities of a robot are drawn from `synthetic/nouns-*.tsv` (a name, a class, and synonyms in each language), its goal words from
`synthetic/words-*.toml` (the meaning, the classes of the arguments, and in each language templates of requests and prohibitions).
DATA.jsonl is the output of `training_data` (lab/programs): the end of its system prompt, which all robots share, is taken from there.
OUT.jsonl has the same form. The same arguments give the same bytes.

Most requests make no sense ("vacuum the wardrobe"): they teach words, cases and articles. The kinds of cases are one request, two, a
request with a prohibition, a prohibition alone, an order, a question (namesakes, an entity that is absent, a request that is no goal),
and conversations (an answer to a question, a correction, a further request, a prohibition, one request less).
"""

import argparse
import json
import random
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from lexicon import LANGUAGES, read_goal_words, read_nouns
from phrases import AFTER, ALSO, BEFORE, BUT, CORRECTION, DROP, FURTHER, LANGUAGE_WEIGHTS, ORDERED, WITHOUT
from phrasing import Phrasing, in_sentence, without_full_stop
from synthetic_robot import Amount, DrawnGoal, NounEntity, Robot, goal_text

# A second request that follows one of these is a part of the same sentence.
CONJUNCTIONS = ("and ", "und ", "et ", "y ")


class Case(NamedTuple):
    """An instruction with its answer, the goal or None for a question, after rounds of an earlier answer and the next message."""

    instruction: str
    answer: str | None
    rounds: Sequence[tuple[str, str]] = ()


def contradicts(goal: DrawnGoal, other: DrawnGoal) -> bool:
    """Returns true if two goals have the same or opposite words and the same first argument."""
    return other.word.name in (goal.word.name, goal.word.opposite) and other.arguments[0] == goal.arguments[0]


class CaseWriter:
    """Draws cases for a robot. A method returns None if its draw makes no case."""

    def __init__(self, robot: Robot, rng: random.Random) -> None:
        self.robot = robot
        self.rng = rng
        self.phrasing = Phrasing(rng)

    def draw_case(self) -> Case | None:
        """Draws a case in one of the languages."""
        language = self.rng.choices(LANGUAGES, LANGUAGE_WEIGHTS)[0]
        goal = self.robot.draw_goal()
        if goal is None:
            return None
        if self.rng.random() < 0.09:
            return self.conversation(language, goal)
        weights: dict[Callable[[str, DrawnGoal], Case | None], int] = {
            self.one_request: 60, self.two_requests: 8, self.request_and_prohibition: 13, self.prohibition: 5, self.ordered_requests: 6,
            self.ambiguous_request: 3, self.absent_entity: 3, self.foreign_request: 2,
        }
        draw = self.rng.choices(list(weights), list(weights.values()))[0]
        return draw(language, goal)

    def request(self, goal: DrawnGoal, language: str) -> str:
        return self.phrasing.request(goal.word, goal.arguments, language)

    def draw_other_goal(self, goal: DrawnGoal) -> DrawnGoal | None:
        """Draws a goal; None if it is the same goal."""
        other = self.robot.draw_goal()
        return None if other is None or other.text == goal.text else other

    def one_request(self, language: str, goal: DrawnGoal) -> Case:
        return Case(self.phrasing.ended(self.request(goal, language)), goal.text)

    def two_requests(self, language: str, goal: DrawnGoal) -> Case | None:
        other = self.draw_other_goal(goal)
        if other is None or other.word.name == goal.word.opposite:
            return None
        conjunction = self.rng.choice(ALSO[language])
        second = self.request(other, language)
        if conjunction.endswith(CONJUNCTIONS):
            second = in_sentence(second, language)
        first = without_full_stop(self.request(goal, language))
        return Case(self.phrasing.ended(first + conjunction + second), f"{goal.text} & {other.text}")

    def request_and_prohibition(self, language: str, goal: DrawnGoal) -> Case | None:
        other = self.draw_other_goal(goal)
        if other is None or contradicts(goal, other):
            return None
        if self.rng.random() < 0.25:
            untouched = other.arguments[0]
            if isinstance(untouched, Amount) or untouched in goal.arguments:
                return None
            prohibition = self.phrasing.untouched(untouched, language)
            constraint = f"untouched({untouched.name})"
        else:
            prohibition = self.phrasing.prohibition(other.word, other.arguments, language)
            constraint = f"never {other.text}"
        text = self.joined_prohibition(self.request(goal, language), prohibition, language)
        return Case(self.phrasing.ended(text), f"{goal.text} & {constraint}")

    def joined_prohibition(self, request: str, prohibition: str, language: str) -> str:
        """Returns a request with a prohibition, as one sentence or two."""
        clause = prohibition[:1].lower() + prohibition[1:]
        if clause.startswith(WITHOUT[language]):
            return without_full_stop(request) + self.rng.choice([", ", " ", ", "]) + clause
        if language == "ja" and prohibition.endswith(("に", "ないで")) and self.rng.random() < 0.5:
            return prohibition + ("、" if self.rng.random() < 0.7 else "") + request
        conjunction = self.rng.choice(BUT[language])
        return without_full_stop(request) + conjunction + (clause if conjunction.startswith((",", ";", " ;")) else prohibition)

    def prohibition(self, language: str, goal: DrawnGoal) -> Case | None:
        if self.rng.random() < 0.3:
            entity = goal.arguments[0]
            if isinstance(entity, Amount):
                return None
            return Case(self.phrasing.ended(self.phrasing.untouched(entity, language)), f"untouched({entity.name})")
        text = self.phrasing.whole_prohibition(goal.word, goal.arguments, language)
        return Case(self.phrasing.ended(text), f"never {goal.text}") if text else None

    def ordered_requests(self, language: str, goal: DrawnGoal) -> Case | None:
        other = self.draw_other_goal(goal)
        if other is None:
            return None
        before, between = self.rng.choice(ORDERED[language])
        first = without_full_stop(self.request(goal, language))
        second = in_sentence(self.request(other, language), language)
        if before:
            first = before + in_sentence(first, language)
        full_stop = "。" if language == "ja" else "."
        return Case(self.phrasing.ended(first + full_stop + between + second), f"{goal.text} then {other.text}")

    def ambiguous_request(self, language: str, goal: DrawnGoal) -> Case | None:
        """An entity with a namesake, without its adjective: a question."""
        ambiguous = self.first_with_namesake(goal)
        if ambiguous is None:
            return None
        return Case(self.phrasing.ended(self.request_without_adjective(goal, ambiguous, language)), None)

    def first_with_namesake(self, goal: DrawnGoal) -> NounEntity | None:
        """Returns the first argument of a goal that has a namesake."""
        return next((own for own in goal.arguments if isinstance(own, NounEntity) and own.has_namesake), None)

    def request_without_adjective(self, goal: DrawnGoal, ambiguous: NounEntity, language: str) -> str:
        template = self.rng.choice(goal.word.requests[language])
        return self.phrasing.fill(template, language, goal.arguments, [argument is ambiguous for argument in goal.arguments])

    def absent_entity(self, language: str, goal: DrawnGoal) -> Case | None:
        """An entity that the scene does not have: a question."""
        index = self.rng.randrange(len(goal.arguments))
        replaced = goal.arguments[index]
        if not isinstance(replaced, NounEntity):
            return None
        drawn = self.robot.draw_unused_noun(replaced.kind)
        if drawn is None:
            return None
        noun, _ = drawn
        arguments = list(goal.arguments)
        arguments[index] = NounEntity(noun, None, noun.name, noun.kind)
        return Case(self.phrasing.ended(self.phrasing.request(goal.word, arguments, language)), None)

    def foreign_request(self, language: str, goal: DrawnGoal) -> Case | None:
        """A goal word that the robot does not have: a question."""
        word = self.rng.choice([own for own in self.robot.all_goal_words if own not in self.robot.goal_words])
        arguments = self.robot.draw_arguments(word)
        if not arguments:
            return None
        return Case(self.phrasing.ended(self.phrasing.request(word, arguments, language)), None)

    def conversation(self, language: str, goal: DrawnGoal) -> Case | None:
        """An instruction, its answer, the next message, and the goal that is asked for then."""
        other = self.draw_other_goal(goal)
        if other is None:
            return None
        first = self.phrasing.ended(self.request(goal, language))
        second = in_sentence(without_full_stop(self.request(other, language)), language)
        kinds = ["answer", "correction", "further", "after", "before", "prohibition", "less"]
        kind = self.rng.choices(kinds, [22, 16, 12, 12, 8, 14, 16])[0]
        if kind == "answer":
            return self.answered_question(language, goal)
        if kind == "correction":
            return self.correction(language, goal, first)
        if kind == "prohibition":
            if contradicts(goal, other):
                return None
            prohibition = self.phrasing.ended(self.phrasing.prohibition(other.word, other.arguments, language))
            return Case(first, f"{goal.text} & never {other.text}", [(goal.text, prohibition)])
        if kind == "less":
            return self.dropped_request(language, goal, other, first, second)
        templates, answer = {
            "further": (FURTHER, f"{goal.text} & {other.text}"),
            "after": (AFTER, f"{goal.text} then {other.text}"),
            "before": (BEFORE, f"{other.text} then {goal.text}"),
        }[kind]
        message = self.phrasing.ended(self.rng.choice(templates[language]).format(second))
        return Case(first, answer, [(goal.text, message)])

    def answered_question(self, language: str, goal: DrawnGoal) -> Case | None:
        """An ambiguous request, the question, and the name of the entity that is meant."""
        meant = self.first_with_namesake(goal)
        if meant is None:
            return None
        names = [own.name for own in self.robot.entities if isinstance(own, NounEntity) and own.has_namesake and own.noun is meant.noun]
        self.rng.shuffle(names)
        instruction = self.phrasing.ended(self.request_without_adjective(goal, meant, language))
        noun = meant.noun.name.split()[-1]
        question = f"question: Which {noun} do you mean: {self.rng.choice([', or ', ' or ']).join(names)}?"
        reply = self.phrasing.fill("{X:acc}" if language == "de" else "{X}", language, [meant], [False])
        return Case(instruction, goal.text, [(question, self.phrasing.ended(reply))])

    def correction(self, language: str, goal: DrawnGoal, first: str) -> Case | None:
        """A request whose answer has a wrong argument, and the request once more."""
        index = self.rng.randrange(len(goal.arguments))
        replaced = goal.arguments[index]
        if isinstance(replaced, Amount):
            return None
        others = [entity for entity in self.robot.entities_by_kind[replaced.kind] if entity not in goal.arguments]
        if not others:
            return None
        wrong = list(goal.arguments)
        wrong[index] = self.rng.choice(others)
        again = in_sentence(without_full_stop(self.request(goal, language)), language)
        message = self.phrasing.ended(self.rng.choice(CORRECTION[language]).format(again))
        return Case(first, goal.text, [(goal_text(goal.word, wrong), message)])

    def dropped_request(self, language: str, goal: DrawnGoal, other: DrawnGoal, first: str, second: str) -> Case | None:
        """Two requests, and a message that drops the second."""
        dropped = other.arguments[0]
        if isinstance(dropped, Amount) or dropped in goal.arguments:
            return None
        goals = [goal.text, other.text] if self.rng.random() < 0.5 else [other.text, goal.text]
        conjunction = self.rng.choice([own for own in ALSO[language] if not own.endswith(CONJUNCTIONS)])
        template = self.rng.choice(DROP[language])
        drop = self.phrasing.fill(template, language, [dropped], self.phrasing.omitted_adjectives([dropped]))
        instruction = self.phrasing.ended(without_full_stop(first) + conjunction + second)
        return Case(instruction, goal.text, [(" & ".join(goals), self.phrasing.ended(drop))])


def shared_prompt_ending(data_path: str) -> str:
    """Returns the end of the system prompt that all robots share, without the facts of the one robot."""
    with open(data_path, encoding="utf-8") as lines:
        system_prompt: str = json.loads(next(lines))["fixed"][0][1]
    ending = system_prompt[system_prompt.index("\n\nBeyond plain goals:"):]
    return re.sub(r"- behind never and always also: .*\n", "", ending)


def one_line(text: str) -> str:
    return " ".join(text.split())


def case_json(robot: Robot, number: int, case: Case) -> str:
    """Returns a case as a line of training data (the keys are those of `training_data`)."""
    return json.dumps({
        "suite": robot.name,
        "id": f"{robot.name}-{number}",
        "fixed": [["system", robot.system_prompt]],
        "lead": robot.scene,
        "instruction": f" {one_line(case.instruction)}",
        "rounds": [[reply, one_line(message)] for reply, message in case.rounds],
        "answer": case.answer,
    }, ensure_ascii=False)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("data", help="training data whose system prompt is used")
    parser.add_argument("out", help="the file to write")
    parser.add_argument("--robots", type=int, default=660)
    parser.add_argument("--cases", type=int, default=40, help="of each robot")
    parser.add_argument("--seed", type=int, default=100)
    options = parser.parse_args(arguments)
    rng = random.Random(options.seed)
    ending = shared_prompt_ending(options.data)
    nouns, goal_words = read_nouns(), read_goal_words()
    written = 0
    with open(options.out, "w", encoding="utf-8") as out:
        for number in range(options.robots):
            robot = Robot(f"synthetic-{options.seed}-{number}", nouns, goal_words, ending, rng)
            writer = CaseWriter(robot, rng)
            count = attempts = 0
            while count < options.cases and attempts < 5 * options.cases:
                attempts += 1
                case = writer.draw_case()
                if case is not None:
                    out.write(case_json(robot, count, case) + "\n")
                    count += 1
            written += count
    print(f"{sum(map(len, nouns.values()))} nouns, {len(goal_words)} goal words, {written} cases of {options.robots} robots")


if __name__ == "__main__":
    main()
