"""Plans carried out on robots that are Python objects."""

from __future__ import annotations

import _thread
import json
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from types import MappingProxyType
from typing import Any, cast

import longstep
from scenes import PANTRY, Recorder, desk, reply

GOAL = "put(pen, shelf)"


class Runs(unittest.TestCase):
    def setUp(self) -> None:
        self.world = desk()
        self.plan = longstep.solve(self.world, GOAL).verified()

    def test_a_plan_is_carried_out_step_by_step(self) -> None:
        robot = Recorder(self.world)
        run = longstep.run(self.plan, robot, approve="never")
        self.assertTrue(run.is_done)
        self.assertIsNone(run.stopped)
        self.assertEqual([call.split()[0] for call in robot.calls], [line[1:].split()[0].rstrip(")") for line in self.plan.pddl().splitlines()])
        self.assertEqual(run.world.environment()["object_states"]["<pen>"], "on_something(<shelf>)")
        self.assertEqual(run.events[0]["event"], "began")

    def test_only_a_verified_plan_moves_a_robot(self) -> None:
        robot = Recorder(self.world)
        for other in (self.plan.json(), self.plan.dict(), longstep.solve(self.world, GOAL), None):
            with self.assertRaisesRegex(TypeError, "verified"):
                longstep.run(cast(Any, other), robot, approve="never")
        self.assertEqual(robot.calls, [])

    def test_a_plan_is_mended_when_the_world_changes(self) -> None:
        robot = longstep.Sim(self.world, faults=1, kinds=["slips"], horizon=4, seed=3)
        run = longstep.run(self.plan, robot, approve="never")
        self.assertTrue(run.is_done, run)
        self.assertGreater(run.changes, 0)

    def test_a_step_that_failed_is_no_exception(self) -> None:
        class Clumsy(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                if len(self.calls) == 1:
                    self.calls.append("failed")
                    raise longstep.StepFailed("it slipped")
                super().perform(action, *arguments)

        run = longstep.run(self.plan, Clumsy(self.world), approve="never")
        self.assertTrue(run.is_done, run)
        self.assertIn("it slipped", json.dumps(run.events))

    def test_a_person_approves_the_plan_or_it_does_not_move(self) -> None:
        for answer, done in ((True, True), (False, False)):
            robot, asked = Recorder(self.world), []

            def ask(question: longstep.RunQuestion, answer: bool = answer) -> bool:
                asked.append(question)
                return answer

            run = longstep.run(self.plan, robot, ask=ask)
            self.assertEqual(run.is_done, done)
            self.assertEqual((asked[0]["kind"], len(asked[0]["steps"])), ("plan", 6))
            self.assertEqual(bool(robot.calls), done)

    def asked(self, plan: longstep.Plan) -> longstep.RunQuestion:
        """Returns the only question of a run to a person who says no."""
        asked: list[longstep.RunQuestion] = []

        def ask(question: longstep.RunQuestion) -> bool:
            asked.append(question)
            return False

        longstep.run(plan, Recorder(self.world), ask=ask)
        self.assertEqual(len(asked), 1)
        return asked[0]

    def test_a_person_reads_the_words_that_the_plan_leaves_out(self) -> None:
        words = "but only if Anna is not there"
        session = longstep.Session(self.world, lambda _: reply(GOAL, left_out=(words,)))
        session.instruct(f"Put the pen on the shelf, {words}")
        accepted = session.accept(consent=True)
        saved = longstep.verify(accepted.json(), self.world).verified()
        for plan in (accepted, saved):
            asked = self.asked(plan)
            self.assertEqual(asked["left_out"], plan.left_out)
            self.assertTrue(any("Anna" in own for own in plan.left_out), plan.left_out)
            for own in plan.left_out:
                self.assertIn(own, asked["text"])
        asked = self.asked(self.plan)
        self.assertEqual((asked["left_out"], asked["text"]), ([], "Go on with this plan?"))

    def test_nothing_moves_without_anybody_to_approve(self) -> None:
        robot = Recorder(self.world)
        run = longstep.run(self.plan, robot)
        self.assertIn("nobody answered", cast(str, run.stopped))
        self.assertEqual((robot.calls, robot.stops), ([], 1))

    def test_an_exception_stops_the_robot_and_comes_out_as_itself(self) -> None:
        error = ConnectionError("the arm is gone")

        class Broken(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                super().perform(action, *arguments)
                raise error

        robot = Broken(self.world)
        with self.assertRaises(ConnectionError) as raised:
            longstep.run(self.plan, robot, approve="never")
        self.assertIs(raised.exception, error)
        self.assertEqual((len(robot.calls), robot.stops), (1, 1))

    def test_an_exception_of_the_person_stops_the_robot(self) -> None:
        def ask(_: longstep.RunQuestion) -> bool:
            raise EOFError

        robot = Recorder(self.world)
        with self.assertRaises(EOFError):
            longstep.run(self.plan, robot, ask=ask)
        self.assertEqual((robot.calls, robot.stops), ([], 1))

    def test_ctrl_c_in_a_step_stops_the_robot(self) -> None:
        # Ctrl-C is ignored by what a shell starts in the background.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)

        class Slow(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                super().perform(action, *arguments)
                _thread.interrupt_main()
                time.sleep(60)

        robot = Slow(self.world)
        with self.assertRaises(KeyboardInterrupt):
            longstep.run(self.plan, robot, approve="never")
        self.assertEqual((len(robot.calls), robot.stops), (1, 1))

    def test_ctrl_c_in_an_observation_stops_the_robot(self) -> None:
        program = """
import signal, longstep, scenes
signal.signal(signal.SIGINT, signal.default_int_handler)
world = scenes.desk()
class Own(scenes.Recorder):
    def observe(self):
        seen = super().observe()
        if self.calls:
            signal.raise_signal(signal.SIGINT)
        return seen
robot = Own(world)
try:
    longstep.run(longstep.solve(world, "put(pen, shelf)").verified(), robot, approve="never")
except KeyboardInterrupt:
    print(len(robot.calls), robot.stops)
"""
        folder = str(Path(__file__).parent)
        done = subprocess.run([sys.executable, "-c", program], cwd=folder, capture_output=True, text=True, timeout=60, check=True)
        self.assertEqual(done.stdout.split(), ["1", "1"])

    def test_a_robot_without_a_method_is_a_type_error(self) -> None:
        class Deaf:
            def perform(self, action: str, /, *arguments: str) -> None:
                raise AssertionError

            def observe(self) -> longstep.Observation:
                raise AssertionError

        with self.assertRaisesRegex(TypeError, "stop"):
            longstep.run(self.plan, cast(Any, Deaf()), approve="never")

    def test_a_step_that_returns_false_is_not_taken_for_done(self) -> None:
        class Wrong(Recorder):
            def perform(self, action: str, /, *arguments: str) -> bool:  # type: ignore[override]
                return False

        robot = Wrong(self.world)
        with self.assertRaisesRegex(TypeError, "StepFailed"):
            longstep.run(self.plan, cast(Any, robot), approve="never")
        self.assertEqual(robot.stops, 1)

    def test_an_observation_in_another_form_stops_the_robot(self) -> None:
        states = {"<pen>": ["on_something(<desk>)"]}
        cases: list[tuple[object, type[Exception], str]] = [
            ({"seen": []}, ValueError, "`observe` must return .*`states` is missing"),
            ({}, ValueError, "`observe` must return .*`states` is missing"),
            ([states], TypeError, "`observe` must return .* not list"),
            ([], TypeError, "`observe` must return .* not list"),
            (None, TypeError, "`observe` must return .* not NoneType"),
            ({"states": [states]}, TypeError, "`states` must be a dict, not list"),
            ({"states": {"<pen>": 3}}, ValueError, "`observe` must return"),
            ({"states": {"<pen>": {1}}}, TypeError, "set is no data"),
            ({"states": {"pen": ["on_something(<desk>)"]}}, ValueError, "`observe` names .*`pen` .did you mean `<pen>`"),
        ]
        for seen, error, message in cases:
            class Blind(Recorder):
                def observe(self, seen: object = seen) -> longstep.Observation:
                    return cast(longstep.Observation, seen)

            robot = Blind(self.world)
            with self.subTest(seen), self.assertRaisesRegex(error, message):
                longstep.run(self.plan, robot, approve="never")
            self.assertEqual((robot.calls, robot.stops), ([], 1))

    def test_a_robot_may_see_more_than_the_world_of_the_plan_has(self) -> None:
        class Wide(Recorder):
            def observe(self) -> longstep.Observation:
                seen = super().observe()
                states = MappingProxyType({**seen["states"], "<cat>": ("on_something(<desk>)",)})
                return {**seen, "states": states}

        self.assertTrue(longstep.run(self.plan, Wide(self.world), approve="never").is_done)

    def test_a_plan_that_senses_needs_a_robot_that_does(self) -> None:
        world = longstep.World(PANTRY, domain="household-checks")
        goal = "if expired(milk) then put(milk, trash bin) else put(milk, fridge)"
        plan = longstep.solve(world, goal).verified()
        self.assertEqual(len(plan.endings), 2)
        robot = Recorder(world)
        with self.assertRaisesRegex(longstep.LongstepError, "sense"):
            longstep.run(plan, robot, approve="never")
        self.assertEqual(robot.calls, [])
        self.assertTrue(longstep.run(plan, longstep.Sim(world, seed=1), approve="never").is_done)

    def test_the_log_is_a_file_that_is_not_overwritten(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            log = Path(folder) / "run.jsonl"
            run = longstep.run(self.plan, longstep.Sim(self.world), approve="never", log=log)
            lines = [json.loads(line) for line in log.read_text(encoding="utf-8").splitlines()]
            self.assertEqual(len(lines), len(run.events) + 1)
            self.assertEqual(lines[0]["domain"], "household")
            with self.assertRaises(longstep.Unreadable):
                longstep.run(self.plan, longstep.Sim(self.world), approve="never", log=log)

    def test_wrong_options_are_value_errors(self) -> None:
        for options in ({"approve": "always"}, {"trust": "blind"}, {"observe": "never"}):
            with self.assertRaises(ValueError):
                longstep.run(self.plan, longstep.Sim(self.world), **cast(Any, options))
        with self.assertRaises(longstep.Unreadable):
            longstep.Sim(self.world, kinds=["explodes"])  # type: ignore[list-item]


if __name__ == "__main__":
    unittest.main()
