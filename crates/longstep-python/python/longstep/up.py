"""Problems and plans of the package `unified_planning`, through PDDL. The package is imported when a function is called.

    import longstep.up
    task = longstep.up.translate(problem)               # a problem of unified_planning
    answer = longstep.solve(task.problem)
    plan = task.plan(answer.verified())                 # a SequentialPlan of unified_planning
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from longstep._errors import Unreadable
from longstep._longstep import Plan, Problem

if TYPE_CHECKING:
    import unified_planning.model
    import unified_planning.plans

__all__ = ["Translation", "translate"]


class Translation:
    """A problem of unified_planning as one of ours, with the way back for plans."""

    def __init__(self, original: unified_planning.model.Problem, writer: Any, problem: Problem) -> None:
        self._original = original
        self._writer = writer
        self._problem = problem

    @property
    def problem(self) -> Problem:
        """The problem, with its domain and its world."""
        return self._problem

    def plan(self, plan: Plan) -> unified_planning.plans.SequentialPlan:
        """Returns a plan of ours as a plan for the original problem.

        Raises `Unreadable` for a plan that branches, which a sequential plan cannot say.
        """
        from unified_planning.io import PDDLReader

        if len(plan.endings) > 1:
            raise Unreadable("the plan branches on what the robot senses, and a sequential plan does not")
        return PDDLReader().parse_plan_string(self._original, plan.pddl(), self._writer.get_item_named)


def translate(problem: unified_planning.model.Problem) -> Translation:
    """Returns a problem of unified_planning as one of ours.

    Raises `Unreadable` for a problem with parts that PDDL or Longstep does not have.
    """
    from unified_planning.io import PDDLWriter

    writer = PDDLWriter(problem)
    try:
        domain, task = writer.get_domain(), writer.get_problem()
    except Exception as error:
        raise Unreadable(f"the problem cannot be written in PDDL: {error}") from error
    return Translation(problem, writer, Problem(domain, task))
