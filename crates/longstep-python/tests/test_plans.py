"""Worlds, and plans that are verified, repaired and found."""

from __future__ import annotations

import json
import tempfile
import unittest
import xml.etree.ElementTree
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import longstep
from scenes import DESK, PANTRY, ROOT, desk


def call(*steps: str) -> dict[str, Any]:
    """A plan for the pen, as a dict."""
    return {"task_cohesion": {"task_sequence": list(steps), "object_name": "<pen>"}}


class Worlds(unittest.TestCase):
    def test_environments_are_texts_dicts_and_paths(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "desk.json"
            file.write_text(json.dumps(DESK), encoding="utf-8")
            worlds = [longstep.World(json.dumps(DESK)), longstep.World(DESK), longstep.World(file)]
            with self.assertRaises(longstep.Unreadable) as raised:
                longstep.World(str(file))
        self.assertIn("pathlib.Path", cast(str, raised.exception.hint))
        self.assertEqual(len(set(worlds)), 1)
        self.assertEqual(worlds[0].environment()["object_states"], DESK["object_states"])
        self.assertEqual(json.loads(worlds[0].json()), worlds[0].environment())
        self.assertIn("(on <pen> <desk>)", worlds[0].facts)
        self.assertEqual(worlds[0].entities[:3], ["<desk>", "<shelf>", "<pen>"])

    def test_other_types_are_refused(self) -> None:
        for wrong in (3, None, ["<desk>"], b"{}"):
            with self.assertRaises(TypeError):
                longstep.World(cast(Any, wrong))

    def test_an_environment_of_another_domain_is_named_in_the_hint(self) -> None:
        with self.assertRaises(longstep.Unreadable) as raised:
            longstep.World(ROOT / "examples" / "environments" / "flat.json")
        self.assertIn('domain="virtualhome"', cast(str, raised.exception.hint))

    def test_rules_are_in_force(self) -> None:
        world = desk().with_rules(["untouched(pen)"])
        self.assertEqual(world.rules, ["untouched(<pen>)"])
        self.assertNotEqual(world, desk())
        self.assertEqual(longstep.World(DESK, rules=["untouched(pen)"]), world)
        self.assertEqual(longstep.solve(world, "put(pen, shelf)").status, "unsolvable")
        with self.assertRaises(longstep.Unreadable):
            desk().with_rules(["put(pen, shelf)"])

    def test_domains_are_shipped_or_folders(self) -> None:
        self.assertIn("household", longstep.Domain.shipped())
        self.assertIn("put(ITEM, PLACE)", longstep.Domain().goals)
        folder = ROOT / "examples" / "home"
        self.assertEqual(longstep.Domain(folder).name, longstep.Domain(str(folder)).name)
        self.assertNotEqual(longstep.Domain("virtualhome").hash, longstep.Domain().hash)
        with self.assertRaises(longstep.Unreadable) as raised:
            longstep.Domain("houshold")
        self.assertEqual(raised.exception.hint, "did you mean `household`?")
        lamp = longstep.Domain.from_pddl("(define (domain lamp) (:predicates (lit)) (:action press :effect (lit)))")
        self.assertEqual((lamp.name, lamp.actions), ("lamp", ["press"]))

    def test_classes_are_frozen(self) -> None:
        for own in (desk(), longstep.Domain(), longstep.solve(desk(), "put(pen, shelf)")):
            with self.assertRaises(AttributeError):
                own.rules = []  # type: ignore[union-attr,misc]
        with self.assertRaises(TypeError):
            cast(Any, longstep.Plan)()


class Answers(unittest.TestCase):
    def test_a_goal_is_solved(self) -> None:
        answer = longstep.solve(desk(), "put(pen, shelf)")
        plan = answer.verified()
        self.assertTrue(answer.is_verified)
        self.assertEqual(len(plan), 6)
        self.assertEqual(plan.goal, ["put(<pen>, <shelf>)"])
        self.assertEqual(plan.endings[0].environment()["object_states"]["<pen>"], "on_something(<shelf>)")
        self.assertEqual([step.index for step in plan.steps], list(range(6)))
        self.assertEqual(plan.steps[0].implicit, {"to": "<pen>"})
        self.assertEqual(plan.pddl().splitlines()[1], "(grasp pen)")
        self.assertEqual(len(plan.hash), 32)
        self.assertEqual(json.loads(answer.json()), answer.dict())
        self.assertEqual(json.loads(plan.json()), plan.dict())
        self.assertEqual(plan.dict()["domain"]["hash"], plan.world.domain.hash)
        self.assertIn("grasp the pen", str(plan))

    def test_the_hash_depends_on_the_steps_the_world_and_the_goal(self) -> None:
        here = longstep.World({**DESK, "objects": ["<pen>", "<cup>"]})
        one = longstep.solve(here, "put(pen, shelf)").verified()
        again = longstep.solve(here, "put(pen, shelf)").verified()
        other_goal = longstep.verify(one, here, goal="put(pen, shelf) & untouched(cup)")
        there = longstep.World({**DESK, "assets": ["<desk>", "<shelf>", "<bench>"]})
        elsewhere = longstep.solve(there, "put(pen, shelf)").verified()
        self.assertEqual(one.hash, again.hash)
        self.assertEqual(len({one.hash, other_goal.verified().hash, elsewhere.hash}), 3)

    def test_violations_are_data_until_a_plan_is_needed(self) -> None:
        answer = longstep.verify(call("grasp_object()"), desk())
        self.assertEqual((answer.status, answer.plan), ("invalid", None))
        self.assertEqual(answer.violations[0].message, "step 1: grasp_object() needs that the hand is at the pen")
        with self.assertRaises(longstep.NotValid) as raised:
            answer.verified()
        self.assertIs(raised.exception.answer, answer)
        self.assertIn("repair", cast(str, raised.exception.hint))

    def test_a_plan_is_repaired(self) -> None:
        answer = longstep.repair(call("grasp_object()"), desk())
        self.assertEqual([edit.kind for edit in answer.edits], ["insert", "insert"])
        self.assertEqual(len(answer.verified()), 3)
        valid = answer.verified()
        again = longstep.repair(valid, desk())
        self.assertEqual((again.edits, again.verified().json()), ([], valid.json()))

    def test_every_status_has_its_exception(self) -> None:
        question = {"task_cohesion": {"task_sequence": []}, "question": "Which pen?"}
        cases: list[tuple[longstep.Answer, type[longstep.LongstepError]]] = [
            (longstep.verify(call("grasp_object()"), desk()), longstep.NotValid),
            (longstep.solve(desk(), "put(pen, shelf) & untouched(pen)"), longstep.Unsolvable),
            (longstep.verify(question, desk()), longstep.Question),
            (longstep.repair(question, desk()), longstep.Question),
        ]
        for answer, expected in cases:
            with self.assertRaises(expected) as raised:
                answer.verified()
            self.assertIs(raised.exception.answer, answer)
            self.assertIsInstance(raised.exception, longstep.LongstepError)

    def test_unreadable_inputs_have_hints(self) -> None:
        cases: list[Callable[[], object]] = [
            lambda: longstep.verify("no plan at all", desk()),
            lambda: longstep.solve(desk(), "put(pencil, shelf)"),
            lambda: longstep.solve(desk(), "put(pen, shelf)", effort=cast(Any, "huge")),
            lambda: longstep.verify(ROOT / "no such file.json", desk()),
            lambda: longstep.World("{"),
        ]
        for case in cases:
            with self.assertRaises(longstep.Unreadable) as raised:
                case()
            self.assertTrue(str(raised.exception))

    def test_a_saved_plan_for_another_domain_is_unreadable(self) -> None:
        world = longstep.World(ROOT / "examples" / "environments" / "flat.json", domain="virtualhome")
        plan = longstep.repair(ROOT / "examples" / "plans" / "warm_cupcake.json", world).verified()
        with self.assertRaises(longstep.Unreadable) as raised:
            longstep.verify(plan, desk())
        self.assertIn("virtualhome", str(raised.exception))

    def test_a_plan_that_branches_has_no_form_in_pddl(self) -> None:
        world = longstep.World(PANTRY, domain="household-checks")
        plan = longstep.solve(world, "if expired(milk) then put(milk, trash bin) else put(milk, fridge)").verified()
        for write in (plan.pddl, plan.pddl_task):
            with self.assertRaisesRegex(longstep.Unreadable, "branches, loops or lanes") as raised:
                cast(Any, write)()
            self.assertIn("behavior_tree()", cast(str, raised.exception.hint))
        self.assertIn("if ", plan.script())
        for text in (plan.behavior_tree(guards=True), plan.scene()):
            xml.etree.ElementTree.fromstring(text)
        self.assertNotEqual(plan.behavior_tree(guards=True), plan.behavior_tree())

    def test_the_other_notations_of_a_plan(self) -> None:
        plan = longstep.solve(desk(), "put(pen, shelf)").verified()
        files = plan.pddl_task(name="errand")
        self.assertEqual(set(files), {"domain.pddl", "problem.pddl", "plan.pddl"})
        self.assertEqual(files["plan.pddl"], plan.pddl())
        self.assertIn("(problem errand)", files["problem.pddl"])
        problem = longstep.Problem(files["domain.pddl"], files["problem.pddl"])
        self.assertTrue(longstep.verify(files["plan.pddl"], problem).is_verified)
        self.assertTrue(longstep.verify(plan.script(), desk()).is_verified)
        self.assertTrue(plan.mermaid().startswith("flowchart"))
        self.assertTrue(plan.dot().startswith("digraph"))
        xml.etree.ElementTree.fromstring(plan.behavior_tree())
        self.assertNotEqual(plan.scene(width=400), plan.scene(width=900))

    def test_a_task_of_a_problem_has_its_goal(self) -> None:
        problem = longstep.Problem(Problems.DOMAIN, Problems.PROBLEM)
        files = longstep.solve(problem).verified().pddl_task()
        again = longstep.Problem(files["domain.pddl"], files["problem.pddl"])
        self.assertEqual(longstep.solve(again).verified().pddl(), "(light porch)\n")

    def test_pictures_are_well_formed_and_escaped(self) -> None:
        world = desk()
        answer = longstep.solve(world, "put(<pen>, <shelf>)")
        for picture in (world._repr_svg_(), answer.verified()._repr_svg_(), answer._repr_svg_(), world.svg(width=300)):
            assert picture is not None
            root = xml.etree.ElementTree.fromstring(picture)
            self.assertTrue(root.tag.endswith("svg"))
            self.assertNotIn("<pen>", picture)
        self.assertIn("&lt;pen&gt;", world.svg())
        self.assertIsNone(longstep.verify(call("grasp_object()"), desk())._repr_svg_())

    def test_effort_bounds_the_search(self) -> None:
        scenes = ROOT / "crates" / "longstep-eval" / "suites" / "long" / "scenes"
        world = longstep.World(scenes / "cafe.json")
        goal = "put(syrup, window table) & put(lemon, corner table) & put(napkins, counter) & put(vase, wall shelf)"
        self.assertTrue(longstep.solve(world, goal, effort=1).status in ("verified", "gave_up"))
        self.assertEqual(longstep.solve(world, goal, effort="small").status, "verified")


class Problems(unittest.TestCase):
    DOMAIN = """(define (domain lamps) (:predicates (lit ?lamp))
        (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) :effect (lit ?lamp)))"""
    PROBLEM = """(define (problem evening) (:domain lamps) (:objects hall porch)
        (:init (lit hall)) (:goal (forall (?lamp) (lit ?lamp))))"""

    def test_a_pddl_problem_is_solved_and_its_plan_verified(self) -> None:
        problem = longstep.Problem(self.DOMAIN, self.PROBLEM)
        self.assertEqual((problem.name, problem.goal, problem.world.facts), ("evening", ["(lit hall)", "(lit porch)"], ["(lit hall)"]))
        plan = longstep.solve(problem).verified()
        self.assertEqual(plan.pddl(), "(light porch)\n")
        self.assertTrue(longstep.verify("(light porch)", problem).is_verified)
        self.assertEqual(longstep.verify("(light hall)", problem).status, "invalid")
        self.assertEqual(longstep.repair("(light hall)\n(light porch)", problem).verified().pddl(), "(light porch)\n")

    def test_goals_beside_a_problem_are_refused(self) -> None:
        problem = longstep.Problem(self.DOMAIN, self.PROBLEM)
        with self.assertRaises(TypeError):
            longstep.solve(problem, cast(Any, "lit(hall)"))
        with self.assertRaises(TypeError):
            cast(Any, longstep.solve)(desk())
        with self.assertRaises(longstep.Unreadable):
            longstep.verify("(light porch)", problem, goal="lit(hall)")


if __name__ == "__main__":
    unittest.main()
