"""Wrong arguments, errors that leave their process, and values that are equal."""

from __future__ import annotations

import copy
import math
import pickle
import unittest
from collections.abc import Callable
from typing import Any, cast

import longstep
from scenes import DESK, PANTRY, Recorder, desk, reply

GOAL = "put(pen, shelf)"


class Messages(unittest.TestCase):
    def test_types_that_do_not_fit_name_the_argument(self) -> None:
        plan = longstep.solve(desk(), GOAL).verified()
        wrong = cast(Any, longstep)
        cases: list[tuple[Callable[[], object], str]] = [
            (lambda: wrong.World(DESK, domain=3), "domain must be a longstep.Domain, a str or an os.PathLike, not int"),
            (lambda: wrong.World(DESK, rules="untouched(pen)"), "rules must be a list of str, not str"),
            (lambda: cast(Any, desk()).with_rules([3]), "rules must be a list of str, not one with int"),
            (lambda: wrong.solve(desk(), GOAL, rules="untouched(pen)"), "rules must be a list of str, not str"),
            (lambda: wrong.verify(plan, desk(), rules={"untouched(pen)": 1}), "rules must be a list of str, not dict"),
            (lambda: wrong.solve(3, GOAL), "world must be a longstep.World or a longstep.Problem, not int"),
            (lambda: wrong.solve(desk(), GOAL, effort=1.5), 'effort must be "small", "normal", "large" or an int, not float'),
            (lambda: wrong.solve(desk(), GOAL, effort=True), "not bool"),
            (lambda: wrong.Sim(desk(), kinds="slips"), "kinds must be a list of str, not str"),
            (lambda: wrong.Sim(desk()).sense("open", "look"), "outcomes must be a list of str, not str"),
            (lambda: wrong.Sim(desk()).perform("grasp", 3), "the arguments of a step must be a list of str"),
            (lambda: wrong.Session(desk(), "gpt-4.1"), "the model must be callable, not str"),
            (lambda: wrong.run(plan, Recorder(desk()), ask=lambda _: None), "`ask` must return True or False, not NoneType"),
        ]
        for call, message in cases:
            with self.subTest(message), self.assertRaises(TypeError) as raised:
                call()
            self.assertIn(message, str(raised.exception))
        for effort in (0, -1, 10_001, 10**30):
            with self.subTest(effort), self.assertRaises(longstep.Unreadable):
                longstep.solve(desk(), GOAL, effort=effort)

    def test_a_robot_s_reports_are_a_list(self) -> None:
        class Wrong(Recorder):
            def __init__(self) -> None:
                super().__init__(desk())
                self.reports = cast(Any, "hand-at")

        with self.assertRaisesRegex(TypeError, "the attribute `reports` of a robot must be a list of str, not str"):
            longstep.run(longstep.solve(desk(), GOAL).verified(), Wrong(), approve="never")

    def test_a_robot_that_reports_events_needs_begin_plan(self) -> None:
        sim = longstep.Sim(desk())

        class Arm:
            reports = sim.reports

            def perform(self, action: str, /, *arguments: str) -> None:
                raise AssertionError

            def observe(self) -> longstep.Observation:
                raise AssertionError

            def stop(self) -> None:
                raise AssertionError

        with self.assertRaisesRegex(longstep.LongstepError, "it reports `wiped`") as raised:
            longstep.run(longstep.solve(desk(), GOAL).verified(), Arm(), approve="never")
        self.assertIn("begin_plan(world)", cast(str, raised.exception.hint))

    def test_temperatures_are_numbers(self) -> None:
        for temperature in (math.nan, math.inf, -1.0):
            with self.assertRaisesRegex(ValueError, "temperature"):
                longstep.Session(desk(), lambda _: reply(GOAL), temperature=temperature)

    def test_a_simulated_robot_refuses_what_no_plan_can_have(self) -> None:
        for words, message in (
            (("grasp", "<desk>"), "`<desk>` is no `item`"),
            (("grasp", "<cup>"), "no entity `<cup>`"),
            (("grasp",), "0 arguments where `grasp` takes 1"),
            (("fly",), "cannot perform `fly`"),
        ):
            robot = longstep.Sim(desk())
            before = robot.observe()
            with self.assertRaisesRegex(ValueError, message):
                robot.perform(*words)
            self.assertEqual(robot.observe(), before)

    def test_a_step_fails_without_a_reason(self) -> None:
        class Clumsy(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                self.calls.append(action)
                if len(self.calls) == 1:
                    raise longstep.StepFailed
                super().perform(action, *arguments)

        run = longstep.run(longstep.solve(desk(), GOAL).verified(), Clumsy(desk()), approve="never")
        self.assertTrue(run.is_done)
        self.assertIn("the robot did not say why", str(run.events))

    def test_sense_returns_a_text(self) -> None:
        world = longstep.World(PANTRY, domain="household-checks")

        class Mute(Recorder):
            def sense(self, outcomes: list[str], action: str, /, *arguments: str) -> None:
                return None

        plan = longstep.solve(world, "if expired(milk) then put(milk, trash bin) else put(milk, fridge)").verified()
        with self.assertRaisesRegex(TypeError, "`sense` must return one of .* as a str, not NoneType"):
            longstep.run(plan, Mute(world), approve="never")

    def test_a_run_without_a_log_is_not_resumed(self) -> None:
        run = longstep.run(longstep.solve(desk(), GOAL).verified(), Recorder(desk()))
        self.assertEqual((run.is_done, run.is_resumable), (False, False))

    def test_an_answer_without_a_plan_says_why(self) -> None:
        answer = longstep.verify({"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}, desk())
        self.assertEqual(repr(answer), "<longstep.Answer invalid: step 1: grasp_object() needs that the hand is at the pen; at the end: the pen must be released>")
        self.assertEqual(repr(longstep.solve(desk(), GOAL)), "<longstep.Answer verified: 6 steps>")


class Errors(unittest.TestCase):
    def test_errors_leave_their_process(self) -> None:
        with self.assertRaises(longstep.NotValid) as raised:
            longstep.verify({"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}, desk()).verified()
        errors: list[longstep.LongstepError] = [
            raised.exception,
            longstep.LongstepError("no", hint="yes"),
            longstep.StepFailed(),
            longstep.ServerError("busy", hint="later", kind="busy", status=503),
        ]
        for error in errors:
            for other in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
                self.assertIs(type(other), type(error))
                self.assertEqual(str(other), str(error))
                self.assertEqual({**vars(other), "answer": None}, {**vars(error), "answer": None})


class Equality(unittest.TestCase):
    def test_equal_data_is_equal(self) -> None:
        broken = {"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}
        makers: list[Callable[[], Any]] = [
            lambda: longstep.solve(desk(), GOAL).verified(),
            lambda: longstep.solve(desk(), GOAL).steps[1],
            lambda: longstep.verify(broken, desk()).violations[0],
            lambda: longstep.repair(broken, desk()).edits[0],
            longstep.Domain,
            desk,
        ]
        for make in makers:
            one, other = make(), make()
            with self.subTest(type(one)):
                self.assertIsNot(one, other)
                self.assertEqual(one, other)
                self.assertEqual(hash(one), hash(other))
                self.assertEqual(len({one, other}), 1)
                self.assertNotEqual(one, "other")
        self.assertNotEqual(longstep.Domain(), longstep.Domain("virtualhome"))
        self.assertNotEqual(longstep.solve(desk(), GOAL).steps[0], longstep.solve(desk(), GOAL).steps[1])
        self.assertNotEqual(longstep.solve(desk(), GOAL).verified(), longstep.solve(desk(), "put(pen, desk) then put(pen, shelf) then put(pen, desk)").verified())


if __name__ == "__main__":
    unittest.main()
