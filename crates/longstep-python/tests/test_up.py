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


if __name__ == "__main__":
    unittest.main()
