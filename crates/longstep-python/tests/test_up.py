"""Problems of unified_planning; skipped where the package is not installed."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
import unittest

import longstep
import longstep.up

INSTALLED = importlib.util.find_spec("unified_planning") is not None


class UnifiedPlanning(unittest.TestCase):
    def test_the_package_is_not_imported_with_the_module(self) -> None:
        program = "import sys, longstep.up; print('unified_planning' in sys.modules)"
        done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
        self.assertEqual(done.stdout.strip(), "False")

    @unittest.skipUnless(INSTALLED, "unified_planning is not installed")
    def test_a_problem_is_solved_and_its_plan_comes_back(self) -> None:
        from unified_planning.engines import SequentialPlanValidator
        from unified_planning.shortcuts import BoolType, Fluent, InstantaneousAction, Not, Object, Problem, UserType

        place = UserType("Place")
        # Names that PDDL does not have are renamed on the way there, and come back as they were.
        robot_at = Fluent("robot at", BoolType(), place=place)
        move = InstantaneousAction("move", origin=place, target=place)
        origin, target = move.parameter("origin"), move.parameter("target")
        move.add_precondition(robot_at(origin))
        move.add_precondition(Not(robot_at(target)))
        move.add_effect(robot_at(origin), False)
        move.add_effect(robot_at(target), True)
        here, there = Object("Here", place), Object("over there", place)
        problem = Problem("errand")
        problem.add_fluent(robot_at, default_initial_value=False)
        problem.add_action(move)
        problem.add_objects([here, there])
        problem.set_initial_value(robot_at(here), True)
        problem.add_goal(robot_at(there))

        task = longstep.up.translate(problem)
        plan = task.plan(longstep.solve(task.problem).verified())
        self.assertEqual(str(plan.actions[0]), "move(Here, over there)")
        with SequentialPlanValidator() as validator:
            self.assertTrue(validator.validate(problem, plan))
        self.assertTrue(longstep.verify(longstep.solve(task.problem).verified().pddl(), task.problem).is_verified)

    @unittest.skipUnless(INSTALLED, "unified_planning is not installed")
    def test_bounds_are_refused_or_ignored_at_the_caller_s_word(self) -> None:
        from unified_planning.shortcuts import GE, Fluent, InstantaneousAction, IntType, Problem, RealType

        for bounds, is_refused in ((IntType(0, 10), True), (IntType(lower_bound=0), True), (RealType(upper_bound=9), True), (IntType(), False)):
            level = Fluent("level", bounds)
            pour = InstantaneousAction("pour")
            pour.add_increase_effect(level, 6)
            problem = Problem("jug")
            problem.add_fluent(level, default_initial_value=0)
            problem.add_action(pour)
            problem.add_goal(GE(level, 12))
            with self.subTest(bounds):
                if is_refused:
                    with self.assertRaisesRegex(longstep.Unreadable, "`level` .* bounds") as raised:
                        longstep.up.translate(problem)
                    self.assertIn("ignore_bounds=True", str(raised.exception.hint))
                task = longstep.up.translate(problem, ignore_bounds=is_refused)
                self.assertEqual(len(task.plan(longstep.solve(task.problem).verified()).actions), 2)

    @unittest.skipUnless(INSTALLED, "unified_planning is not installed")
    def test_a_problem_with_time_is_refused(self) -> None:
        from unified_planning.shortcuts import DurativeAction, EndTiming, Fluent, Problem, StartTiming

        lit = Fluent("lit")
        light = DurativeAction("light")
        light.set_fixed_duration(3)
        light.add_effect(EndTiming(), lit, True)
        problem = Problem("evening")
        problem.add_fluent(lit, default_initial_value=False)
        problem.add_action(light)
        problem.add_goal(lit)
        with self.assertRaisesRegex(longstep.Unreadable, "`light` take time") as raised:
            longstep.up.translate(problem)
        self.assertIn("instantaneous", str(raised.exception.hint))
        timed = Problem("clock")
        timed.add_fluent(lit, default_initial_value=False)
        timed.add_timed_effect(StartTiming(5), lit, True)
        timed.add_goal(lit)
        with self.assertRaisesRegex(longstep.Unreadable, "TIMED_EFFECTS"):
            longstep.up.translate(timed)

    @unittest.skipUnless(INSTALLED, "unified_planning is not installed")
    def test_a_constraint_on_the_way_is_refused(self) -> None:
        from unified_planning.shortcuts import Always, Fluent, InstantaneousAction, Not, Problem

        lit, warm = Fluent("lit"), Fluent("warm")
        light = InstantaneousAction("light")
        light.add_effect(lit, True)
        light.add_effect(warm, True)
        problem = Problem("evening")
        problem.add_fluent(lit, default_initial_value=False)
        problem.add_fluent(warm, default_initial_value=False)
        problem.add_action(light)
        problem.add_goal(lit)
        problem.add_trajectory_constraint(Always(Not(warm)))
        with self.assertRaisesRegex(longstep.Unreadable, "STATE_INVARIANTS"):
            longstep.up.translate(problem)


if __name__ == "__main__":
    unittest.main()
