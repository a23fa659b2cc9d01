"""Runs that other threads stop, let wait and watch; and one run at a time for one robot."""

from __future__ import annotations

import asyncio
import subprocess
import sys
import threading
import time
import unittest
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import longstep
from scenes import ROOT, Recorder, desk

GOAL = "put(pen, shelf)"
# Longer than any wait of these tests, and the limit of each of them.
LIMIT = 60.0


class Slow(Recorder):
    """A robot that is at work in its second step until somebody stops it, or lets it go on."""

    def __init__(self, world: longstep.World) -> None:
        super().__init__(world)
        self.is_working, self.may_return = threading.Event(), threading.Event()
        self.stopped_by: list[int] = []

    def perform(self, action: str, /, *arguments: str) -> None:
        if len(self.calls) == 1:
            self.is_working.set()
            assert self.may_return.wait(LIMIT)
        super().perform(action, *arguments)

    def stop(self) -> None:
        self.stopped_by.append(threading.get_ident())
        self.stops += 1


def at_pause(paused: threading.Event) -> Callable[[dict[str, Any]], None]:
    """Returns a watch that says when a run begins to wait."""

    def watch(event: dict[str, Any]) -> None:
        if event["event"] == "paused":
            paused.set()

    return watch


class Controls(unittest.TestCase):
    def setUp(self) -> None:
        self.world = desk()
        self.plan = longstep.solve(self.world, GOAL).verified()

    def begin(self, robot: longstep.Robot, control: longstep.Control, **options: Any) -> tuple[threading.Thread, list[longstep.Run]]:
        """Carries the plan out in another thread."""
        runs: list[longstep.Run] = []
        run = lambda: runs.append(longstep.run(self.plan, robot, approve="never", control=control, **options))  # noqa: E731
        thread = threading.Thread(target=run)
        thread.start()
        return thread, runs

    def test_stop_calls_the_robot_at_once_and_in_its_own_thread(self) -> None:
        robot, control = Slow(self.world), longstep.Control()
        thread, runs = self.begin(robot, control)
        self.assertTrue(robot.is_working.wait(LIMIT))
        control.stop()
        self.assertEqual((robot.stopped_by, runs), ([threading.get_ident()], []))
        control.stop()
        robot.may_return.set()
        thread.join(LIMIT)
        self.assertEqual((runs[0].is_done, runs[0].stopped), (False, "stopped at a request"))
        self.assertEqual((len(robot.calls), robot.stops), (2, 1))

    def test_stop_before_a_run_lets_nothing_move_and_after_it_does_nothing(self) -> None:
        for early in (True, False):
            robot, control = Recorder(self.world), longstep.Control()
            if early:
                control.stop()
            run = longstep.run(self.plan, robot, approve="never", control=control)
            control.stop()
            self.assertEqual((run.is_done, bool(robot.calls), robot.stops), (not early, not early, int(early)))

    def test_the_robot_may_stop_its_own_run(self) -> None:
        control = longstep.Control()

        class Careful(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                super().perform(action, *arguments)
                control.stop()

            def stop(self) -> None:
                super().stop()
                control.stop()

        robot = Careful(self.world)
        run = longstep.run(self.plan, robot, approve="never", control=control)
        self.assertEqual((run.stopped, len(robot.calls), robot.stops), ("stopped at a request", 1, 1))

    def test_an_exception_after_the_stop_ends_the_step_alone(self) -> None:
        control = longstep.Control()

        class Cut(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                self.calls.append(action)
                control.stop()
                raise ConnectionAbortedError("the connection was cut")

        robot = Cut(self.world)
        run = longstep.run(self.plan, robot, approve="never", control=control)
        self.assertEqual((run.stopped, robot.stops), ("stopped at a request", 1))
        self.assertIn("the connection was cut", str(run.events))

    def test_a_run_waits_between_steps_and_goes_on(self) -> None:
        robot, control = Slow(self.world), longstep.Control()
        paused = threading.Event()
        thread, runs = self.begin(robot, control, watch=at_pause(paused))
        self.assertTrue(robot.is_working.wait(LIMIT))
        control.pause()
        robot.may_return.set()
        self.assertTrue(paused.wait(LIMIT))
        time.sleep(0.1)
        self.assertEqual((len(robot.calls), runs, robot.stops), (2, [], 0))
        control.resume()
        thread.join(LIMIT)
        self.assertTrue(runs[0].is_done)

    def test_a_run_that_waits_is_stopped(self) -> None:
        robot, control = Recorder(self.world), longstep.Control()
        control.pause()
        paused = threading.Event()
        thread, runs = self.begin(robot, control, watch=at_pause(paused))
        self.assertTrue(paused.wait(LIMIT))
        control.stop()
        thread.join(LIMIT)
        self.assertEqual((runs[0].stopped, robot.calls, robot.stops), ("stopped at a request", [], 1))

    def test_ctrl_c_ends_a_run_that_waits(self) -> None:
        program = """
import signal, threading, longstep, scenes
signal.signal(signal.SIGINT, signal.default_int_handler)
world, control = scenes.desk(), longstep.Control()
robot = scenes.Recorder(world)
control.pause()
main = threading.main_thread().ident
watch = lambda event: event["event"] == "paused" and threading.Timer(0.2, signal.pthread_kill, (main, signal.SIGINT)).start()
try:
    longstep.run(longstep.solve(world, "put(pen, shelf)").verified(), robot, approve="never", control=control, watch=watch)
except KeyboardInterrupt:
    print(len(robot.calls), robot.stops)
"""
        done = subprocess.run([sys.executable, "-c", program], cwd=Path(__file__).parent, capture_output=True, text=True, timeout=LIMIT, check=True)
        self.assertEqual(done.stdout.split(), ["0", "1"])

    def test_a_control_is_for_one_run(self) -> None:
        control = longstep.Control()
        self.assertTrue(longstep.run(self.plan, longstep.Sim(self.world), approve="never", control=control).is_done)
        robot = Recorder(self.world)
        with self.assertRaisesRegex(longstep.LongstepError, "another run"):
            longstep.run(self.plan, robot, approve="never", control=control)
        self.assertEqual((robot.calls, robot.stops), ([], 0))

    def test_every_event_is_seen_as_it_happens(self) -> None:
        events: list[dict[str, Any]] = []

        class Broken(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                super().perform(action, *arguments)
                assert events[-1]["event"] == "ordered"
                if len(self.calls) == 2:
                    raise RuntimeError("the gripper jammed")

        with self.assertRaises(RuntimeError):
            longstep.run(self.plan, Broken(self.world), approve="never", watch=events.append)
        self.assertEqual([event["event"] for event in events].count("ordered"), 2)
        self.assertIn("the gripper jammed", str(events[-1]))
        events.clear()
        run = longstep.run(self.plan, longstep.Sim(self.world), approve="never", watch=events.append)
        self.assertEqual(run.events, events)

    def test_an_exception_of_the_watch_stops_the_run(self) -> None:
        calls: list[str] = []

        def watch(event: dict[str, Any]) -> None:
            calls.append(event["event"])
            if event["event"] == "ordered":
                raise BrokenPipeError("nobody listens")

        robot = Recorder(self.world)
        with self.assertRaises(BrokenPipeError):
            longstep.run(self.plan, robot, approve="never", watch=watch)
        self.assertEqual((robot.calls, robot.stops, calls.count("ordered")), ([], 1, 1))

    def test_callables_are_checked_before_anything_moves(self) -> None:
        robot = Recorder(self.world)
        for option in ("ask", "watch"):
            with self.assertRaisesRegex(TypeError, f"{option} must be callable, not str"):
                longstep.run(self.plan, robot, **cast(Any, {option: "yes"}))
        with self.assertRaises(TypeError):
            longstep.run(self.plan, robot, control=cast(Any, "stop"))
        self.assertEqual((robot.calls, robot.stops), ([], 0))

    def test_the_example_of_the_guide_stops_the_robot_after_a_cancellation(self) -> None:
        guide = (ROOT / "docs" / "guide" / "python.md").read_text(encoding="utf-8")
        begin = guide.index("async def carry_out")
        names: dict[str, Any] = {"asyncio": asyncio, "longstep": longstep}
        exec(guide[begin : guide.index("run = ", begin)], names)
        robot = Slow(self.world)

        async def cancelled() -> None:
            task = asyncio.create_task(names["carry_out"](self.plan, robot))
            await asyncio.to_thread(robot.is_working.wait, LIMIT)
            task.cancel()
            try:
                await task
            finally:
                self.assertEqual(robot.stops, 1)
                robot.may_return.set()

        with self.assertRaises(asyncio.CancelledError):
            asyncio.run(cancelled())
        self.assertEqual((len(robot.calls), robot.stops), (2, 1))
        robot = Slow(self.world)
        robot.may_return.set()
        self.assertTrue(asyncio.run(names["carry_out"](self.plan, robot)).is_done)
        self.assertEqual(robot.stops, 0)


class Unstoppable(Recorder):
    """A robot whose `stop` fails."""

    error = OSError("no connection: the robot still moves")

    def stop(self) -> None:
        self.stops += 1
        raise self.error


class FailedStops(unittest.TestCase):
    def setUp(self) -> None:
        self.world = desk()
        self.plan = longstep.solve(self.world, GOAL).verified()

    def raised(self, robot: Unstoppable, **options: Any) -> BaseException | None:
        """Returns the context of the exception of `stop`, which comes out of the run."""
        robot.error = OSError("no connection: the robot still moves")
        with self.assertRaises(OSError) as raised:
            longstep.run(self.plan, robot, **options)
        self.assertIs(raised.exception, robot.error)
        self.assertEqual(robot.stops, 1)
        return raised.exception.__context__

    def test_an_earlier_exception_is_the_context(self) -> None:
        jammed = RuntimeError("the gripper jammed")

        class Broken(Unstoppable):
            def perform(self, action: str, /, *arguments: str) -> None:
                raise jammed

        events: list[dict[str, Any]] = []
        self.assertIs(self.raised(Broken(self.world), approve="never", watch=events.append), jammed)
        self.assertIn("the robot still moves", str(events[-1]))

    def test_the_reason_of_a_stop_is_the_context(self) -> None:
        context = self.raised(Unstoppable(self.world), ask=lambda _: False)
        self.assertIsInstance(context, longstep.LongstepError)
        self.assertIn("a person did not approve it", str(context))
        control = longstep.Control()
        control.stop()
        context = self.raised(Unstoppable(self.world), approve="never", control=control)
        self.assertIn("the robot did not confirm it", str(context))

    def test_an_exception_in_another_thread_comes_out_of_the_run(self) -> None:
        control = longstep.Control()

        class Own(Unstoppable):
            def perform(self, action: str, /, *arguments: str) -> None:
                thread = threading.Thread(target=control.stop)
                thread.start()
                thread.join(LIMIT)
                super().perform(action, *arguments)

        self.assertIn("stopped at a request", str(self.raised(Own(self.world), approve="never", control=control)))

    def test_contexts_of_the_exception_stay(self) -> None:
        class Own(Unstoppable):
            def stop(self) -> None:
                try:
                    raise TimeoutError
                except TimeoutError:
                    super().stop()

        context = self.raised(Own(self.world), ask=lambda _: False)
        self.assertIsInstance(context, TimeoutError)
        assert context is not None
        self.assertIsInstance(context.__context__, longstep.LongstepError)


class OneRobot(unittest.TestCase):
    def setUp(self) -> None:
        self.world = desk()
        self.plan = longstep.solve(self.world, GOAL).verified()

    def test_a_second_run_on_a_robot_is_refused(self) -> None:
        robot, control = Slow(self.world), longstep.Control()
        thread = threading.Thread(target=lambda: longstep.run(self.plan, robot, approve="never", control=control))
        thread.start()
        self.assertTrue(robot.is_working.wait(LIMIT))
        with self.assertRaisesRegex(longstep.LongstepError, "another run uses this robot"):
            longstep.run(self.plan, robot, approve="never")
        self.assertEqual((len(robot.calls), robot.stops), (1, 0))
        self.assertTrue(longstep.run(self.plan, Recorder(self.world), approve="never").is_done)
        robot.may_return.set()
        thread.join(LIMIT)
        # The robot is free after the run.
        self.assertTrue(longstep.run(self.plan, robot, approve="never").is_done)

    def test_a_nested_run_is_refused_and_a_failed_one_leaves_the_robot_free(self) -> None:
        plan = self.plan

        class Nested(Recorder):
            def perform(self, action: str, /, *arguments: str) -> None:
                super().perform(action, *arguments)
                longstep.run(plan, self, approve="never")

        robot = Nested(self.world)
        with self.assertRaisesRegex(longstep.LongstepError, "another run uses this robot"):
            longstep.run(self.plan, robot, approve="never")
        self.assertEqual((len(robot.calls), robot.stops), (1, 1))
        with self.assertRaises(longstep.Unreadable):
            longstep.run(self.plan, robot, approve="never", log=ROOT / "README.md")
        with self.assertRaisesRegex(RuntimeError, "stopped"):
            longstep.run(self.plan, robot, approve="never")


# The methods are those of threads that are not joined at the end of a program.
ENDINGS = """
import sys, threading, time, longstep, scenes
world = scenes.desk()
plan = longstep.solve(world, "put(pen, shelf)").verified()
stops = []
class Arm(scenes.Recorder):
    def perform(self, action, *arguments):
        time.sleep(0.01)
        super().perform(action, *arguments)
    def stop(self):
        stops.append(1)
        super().stop()
def model(request):
    time.sleep(0.01)
    return scenes.reply("put(pen, shelf)")
work = {
    "run": lambda: longstep.run(plan, Arm(world), approve="never"),
    "instruct": lambda: longstep.Session(world, model).instruct("Put the pen on the shelf"),
    "solve": lambda: longstep.solve(world, "put(pen, shelf)"),
}[sys.argv[1]]
def forever():
    while True:
        work()
import atexit
atexit.register(lambda: print("ends", len(stops), longstep.solve(world, "put(pen, shelf)").status, flush=True))
for _ in range(3):
    threading.Thread(target=forever, daemon=True).start()
time.sleep(0.2)
"""


class Ends(unittest.TestCase):
    def test_a_program_ends_while_daemon_threads_work(self) -> None:
        for work in ("run", "instruct", "solve"):
            for _ in range(5):
                with self.subTest(work):
                    done = subprocess.run(
                        [sys.executable, "-c", ENDINGS, work], cwd=Path(__file__).parent, capture_output=True, text=True, timeout=LIMIT
                    )
                    self.assertEqual((done.returncode, done.stderr), (0, ""))
                    self.assertEqual(done.stdout, "ends 0 verified\n")

    def test_a_robot_is_stopped_at_the_end_of_the_program(self) -> None:
        program = ENDINGS.replace("stops.append(1)", "stops.append(1); print('stopped', flush=True)")
        done = subprocess.run([sys.executable, "-c", program, "run"], cwd=Path(__file__).parent, capture_output=True, text=True, timeout=LIMIT)
        self.assertEqual((done.returncode, done.stdout.count("stopped\n")), (0, 3))

    def test_a_program_does_not_wait_for_a_model_that_never_answers(self) -> None:
        program = ENDINGS.replace("time.sleep(0.01)\n    return", "time.sleep(600)\n    return")
        self.assertNotEqual(program, ENDINGS)
        begun = time.monotonic()
        done = subprocess.run(
            [sys.executable, "-c", program, "instruct"], cwd=Path(__file__).parent, capture_output=True, text=True, timeout=LIMIT
        )
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        # The limit is five seconds; the rest is the beginning of the program.
        self.assertLess(time.monotonic() - begun, 30)

    def test_a_forked_child_stops_no_run_of_its_parent(self) -> None:
        program = ENDINGS[: ENDINGS.index("import atexit")] + """
import os
class Own(Arm):
    def stop(self):
        super().stop()
        print("stopped", os.getpid() == parent, flush=True)
parent = os.getpid()
control = longstep.Control()
run = threading.Thread(target=lambda: [longstep.run(plan, Own(world), approve="never") for _ in range(20)])
run.start()
time.sleep(0.1)
child = os.fork()
if child == 0:
    sys.exit()
os.waitpid(child, 0)
run.join()
print("done", flush=True)
"""
        done = subprocess.run([sys.executable, "-c", program, "run"], cwd=Path(__file__).parent, capture_output=True, text=True, timeout=LIMIT)
        self.assertEqual((done.returncode, done.stdout), (0, "done\n"), done.stderr)


if __name__ == "__main__":
    unittest.main()
