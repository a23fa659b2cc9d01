#!/usr/bin/env python3
"""Tests of the synthetic robots: inflection, the lexicon, and the cases. They need nothing but Python: lab/adapter/test_synthetic.py"""

import contextlib
import io
import json
import random
import re
import tempfile
import unittest
from pathlib import Path
from typing import Any

import synthetic
from inflection import ADJECTIVES, french, german, spanish
from lexicon import LANGUAGES, Noun, read_goal_words, read_nouns
from phrases import PARAMETER_NAMES
from phrasing import Phrasing
from synthetic_robot import DrawnGoal, NounEntity, Robot, goal_text

# The ending of the system prompt, which all robots share.
ENDING = "\n\nBeyond plain goals:\n- behind never and always also: at(PLACE)\n- never GOAL until GOAL\n"


def write_cases(folder: Path, seed: int, robots: int = 40) -> bytes:
    """Returns the output of the program."""
    data, out = folder / "data.jsonl", folder / "out.jsonl"
    data.write_text(json.dumps({"fixed": [["system", f"You read.{ENDING}"]]}) + "\n")
    with contextlib.redirect_stdout(io.StringIO()):
        synthetic.main([str(data), str(out), "--robots", str(robots), "--cases", "40", "--seed", str(seed)])
    return out.read_bytes()


def read_cases(written: bytes) -> list[dict[str, Any]]:
    return [json.loads(line) for line in written.decode().splitlines()]


def goals(answer: str) -> list[tuple[str, list[str]]]:
    """Returns the words and arguments of a goal."""
    return [(word, arguments.split(", ")) for word, arguments in re.findall(r"(\w+)\(([^()]*)\)", answer)]


class Inflection(unittest.TestCase):
    def test_german(self) -> None:
        for synonym, case, adjective, expected in [
            ("der Tisch", "nom", None, "der Tisch"),
            ("der Tisch", "acc", "red", "den roten Tisch"),
            ("der Tisch", "gen", None, "des Tischs"),
            ("die Tasse", "dat", "old", "der alten Tasse"),
            ("die Tasse", "acc", "old", "die alte Tasse"),
            ("das Fass", "gen", None, "des Fasses"),
            ("das Hemd", "nom", "blue", "das blaue Hemd"),
            ("das Hemd", "acc", "blue", "das blaue Hemd"),
            ("pl:die Teller", "dat", None, "den Tellern"),
            ("pl:die Möhren", "dat", "big", "den großen Möhren"),
            ("pl:die Autos", "nom", "new", "die neuen Autos"),
        ]:
            self.assertEqual(german(synonym, case, adjective), expected)

    def test_french(self) -> None:
        for synonym, preposition, adjective, expected in [
            ("le salon", "", None, "le salon"),
            ("le salon", "à", None, "au salon"),
            ("la cuisine", "de", "white", "de la cuisine blanche"),
            ("les carottes", "de", None, "des carottes"),
            ("l'assiette", "à", None, "à l'assiette"),
            ("le panier", "", "old", "le vieux panier"),
            ("l'évier", "à", "small", "au petit évier"),
            ("la porte", "de", "left", "de la porte de gauche"),
        ]:
            self.assertEqual(french(synonym, preposition, adjective), expected)

    def test_spanish(self) -> None:
        for synonym, preposition, adjective, expected in [
            ("el salón", "a", None, "al salón"),
            ("el salón", "de", "new", "del salón nuevo"),
            ("la cocina", "a", None, "a la cocina"),
            ("las zanahorias", "", "yellow", "las zanahorias amarillas"),
            ("los platos", "de", "back", "de los platos de atrás"),
        ]:
            self.assertEqual(spanish(synonym, preposition, adjective), expected)

    def test_every_noun_can_be_inflected(self) -> None:
        for nouns in read_nouns().values():
            for noun in nouns:
                for adjective in [None, *ADJECTIVES]:
                    for synonym in noun.synonyms["de"]:
                        self.assertNotIn("  ", german(synonym, "dat", adjective), noun)
                    for synonym in noun.synonyms["fr"]:
                        self.assertNotIn("_", french(synonym, "de", adjective), noun)
                    for synonym in noun.synonyms["es"]:
                        self.assertNotIn("_", spanish(synonym, "de", adjective), noun)


class Lexicon(unittest.TestCase):
    def test_templates_have_a_place_for_each_argument(self) -> None:
        for word in read_goal_words():
            expected = {"X", "Y"} if len(word.takes) == 2 else {"X"}
            for language in LANGUAGES:
                for template in word.requests[language] + word.prohibitions[language]:
                    self.assertEqual(set(re.findall(r"\{([A-Z])", template)), expected, f"{word.name}: {template}")

    def test_kinds_and_opposites_exist(self) -> None:
        nouns, words = read_nouns(), read_goal_words()
        names = {word.name for word in words}
        self.assertEqual(len(names), len(words))
        self.assertEqual(len({noun.name for own in nouns.values() for noun in own}), sum(map(len, nouns.values())))
        self.assertEqual(set(nouns), set(PARAMETER_NAMES))
        for word in words:
            self.assertIn(word.opposite or word.name, names)
            for kind in word.takes:
                self.assertTrue(kind in nouns or kind.startswith("value"), f"{word.name}: {kind}")


class Adjectives(unittest.TestCase):
    rng = random.Random(1)

    def entity(self, has_namesake: bool) -> NounEntity:
        cup = Noun("cup", "thing", {language: ["die Tasse"] for language in LANGUAGES} | {"en": ["cup"]})
        return NounEntity(cup, "red", "red cup", "thing", has_namesake)

    def test_an_adjective_is_rendered_unless_it_is_omitted(self) -> None:
        phrasing = Phrasing(self.rng)
        self.assertEqual(phrasing.render(self.entity(False), "en", "", omits_adjective=False), "the red cup")
        self.assertEqual(phrasing.render(self.entity(False), "en", "", omits_adjective=True), "the cup")

    def test_an_adjective_is_omitted_only_where_no_namesake_needs_it(self) -> None:
        phrasing = Phrasing(self.rng)
        drawn = [phrasing.omitted_adjectives([self.entity(False), self.entity(True)]) for _ in range(100)]
        self.assertEqual({first for first, _ in drawn}, {False, True})
        self.assertEqual({second for _, second in drawn}, {False})

    def test_an_ambiguous_request_is_a_question_without_the_adjective(self) -> None:
        cup = self.entity(True)
        word = next(word for word in read_goal_words() if word.takes == ["thing"])
        robot = Robot("robot", read_nouns(), read_goal_words(), ENDING, self.rng)
        writer = synthetic.CaseWriter(robot, self.rng)
        case = writer.ambiguous_request("en", DrawnGoal(word, [cup], goal_text(word, [cup])))
        self.assertIsNotNone(case)
        self.assertIsNone(case and case.answer)
        self.assertIn("the cup", case.instruction.lower() if case else "")


class Cases(unittest.TestCase):
    folder: tempfile.TemporaryDirectory[str]
    written: bytes

    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.written = write_cases(Path(cls.folder.name), seed=1)

    def test_a_seed_decides_every_byte(self) -> None:
        folder = Path(self.folder.name)
        self.assertEqual(write_cases(folder, seed=1), self.written)
        self.assertNotEqual(write_cases(folder, seed=2), self.written)

    def test_a_goal_names_words_and_entities_of_its_robot(self) -> None:
        for case in read_cases(self.written):
            entities = set(re.findall(r"^- ([^:\n]+)", case["lead"], re.M))
            words = set(re.findall(r"^- (\w+)\(", case["fixed"][0][1], re.M)) | {"untouched"}
            answers = [case["answer"], *(reply for reply, _ in case["rounds"])]
            for answer in answers:
                if answer is None or answer.startswith("question:"):
                    continue
                self.assertTrue(goals(answer), answer)
                for word, arguments in goals(answer):
                    self.assertIn(word, words)
                    self.assertEqual(len(set(arguments)), len(arguments), answer)
                    for argument in arguments:
                        self.assertTrue(argument in entities or argument[0].isdigit(), f"{argument} in {case['id']}")

    def test_every_kind_of_case_occurs(self) -> None:
        cases = read_cases(self.written)
        single = [case for case in cases if not case["rounds"]]
        counts = {
            "question": sum(case["answer"] is None for case in single),
            "one goal": sum(len(goals(case["answer"] or "")) == 1 for case in single),
            "conjunction": sum(" & " in (case["answer"] or "") and "never" not in case["answer"] for case in single),
            "prohibition alone": sum((case["answer"] or "").startswith(("never ", "untouched")) for case in single),
            "order": sum(" then " in (case["answer"] or "") for case in single),
            "conversation": len(cases) - len(single),
            "answered question": sum(reply.startswith("question:") for case in cases for reply, _ in case["rounds"]),
        }
        for kind, count in counts.items():
            self.assertGreater(count, len(cases) / 1000, kind)
        self.assertGreater(counts["one goal"], len(cases) / 2)

    def test_a_prohibition_does_not_contradict_its_request(self) -> None:
        opposites = {word.name: word.opposite for word in read_goal_words()}
        for case in read_cases(self.written):
            if " & never " in (case["answer"] or ""):
                (wanted, [wanted_first, *_]), (never, [never_first, *_]) = goals(case["answer"])
                if wanted_first == never_first:
                    self.assertNotIn(never, (wanted, opposites[wanted]), case["answer"])

    def test_a_question_offers_namesakes_and_the_answer_is_one_of_them(self) -> None:
        for case in read_cases(self.written):
            for reply, _ in case["rounds"]:
                if reply.startswith("question:"):
                    offered = reply.removesuffix("?").split(": ")[2].replace(", or ", " or ").split(" or ")
                    self.assertEqual(len(set(offered)), 2, reply)
                    [(_, arguments)] = goals(case["answer"])
                    self.assertTrue(set(offered) & set(arguments), reply)

    def test_texts_are_whole(self) -> None:
        for case in read_cases(self.written):
            texts = [case["instruction"].removeprefix(" "), *(message for _, message in case["rounds"])]
            for text in texts:
                self.assertTrue(text)
                self.assertEqual(text, " ".join(text.split()))
                self.assertIsNone(re.search(r"[{}_]", text), text)

    def test_the_prompt_ends_as_the_data_do(self) -> None:
        prompts = {case["fixed"][0][1] for case in read_cases(self.written)}
        facts = [prompt for prompt in prompts if "- behind never and always also:" in prompt]
        self.assertTrue(facts and len(facts) < len(prompts))
        for prompt in prompts:
            self.assertTrue(prompt.endswith("- never GOAL until GOAL\n"))
            self.assertNotIn("at(PLACE)\n- never", prompt.replace("robot_at(PLACE)", ""))


if __name__ == "__main__":
    unittest.main()
