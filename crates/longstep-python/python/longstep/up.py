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


# Features of a problem whose plans need times, or more than the state before a step.
_TIMED = (
    "CONTINUOUS_TIME", "DISCRETE_TIME", "INTERMEDIATE_CONDITIONS_AND_EFFECTS", "EXTERNAL_CONDITIONS_AND_EFFECTS", "TIMED_EFFECTS",
    "TIMED_GOALS", "DURATION_INEQUALITIES", "SELF_OVERLAPPING", "PROCESSES", "EVENTS", "INCREASE_CONTINUOUS_EFFECTS",
    "DECREASE_CONTINUOUS_EFFECTS", "NON_LINEAR_CONTINUOUS_EFFECTS",
)  # fmt: skip
_LEFT_OUT = ("SIMULATED_EFFECTS", "TRAJECTORY_CONSTRAINTS", "STATE_INVARIANTS", "HIERARCHICAL", "SCHEDULING", "CONTINGENT")


def _check_time(problem: unified_planning.model.Problem) -> None:
    """Refuses a problem whose plans would not be those of its translation."""
    features = problem.kind.features
    timed = sorted(features.intersection(_TIMED))
    if timed:
        actions = [action.name for action in getattr(problem, "actions", []) if hasattr(action, "duration")]
        named = f": the actions {', '.join(f'`{name}`' for name in actions)} take time" if actions else f" ({', '.join(timed)})"
        raise Unreadable(
            f"the problem has time{named}, and a plan of Longstep is a sequence of steps without times",
            hint="write the actions as instantaneous ones, or use a temporal planner of unified_planning",
        )
    left_out = sorted(features.intersection(_LEFT_OUT))
    if left_out:
        raise Unreadable(
            f"the problem has parts that a plan of Longstep would ignore ({', '.join(left_out)})",
            hint="compile them away where unified_planning can, for example with `CompilationKind.TRAJECTORY_CONSTRAINTS_REMOVING`",
        )


def _check_bounds(problem: unified_planning.model.Problem) -> None:
    """Refuses bounds of numbers, which PDDL does not have."""
    bounded = [
        f"`{fluent.name}` ({fluent.type.lower_bound} to {fluent.type.upper_bound})"
        for fluent in problem.fluents
        if (fluent.type.is_int_type() or fluent.type.is_real_type())
        and (fluent.type.lower_bound is not None or fluent.type.upper_bound is not None)
    ]
    if bounded:
        raise Unreadable(
            f"the values of {', '.join(bounded)} have bounds, which PDDL cannot say",
            hint="write the bounds as preconditions, or pass `ignore_bounds=True` and validate the plan with unified_planning",
        )


def translate(problem: unified_planning.model.Problem, *, ignore_bounds: bool = False) -> Translation:
    """Returns a problem of unified_planning as one of ours.

    PDDL has no bounds of numbers. With `ignore_bounds` they are left out, and a plan may leave them: validate it with a validator
    of unified_planning. Raises `Unreadable` for bounds otherwise, for a problem with time, and for one with other parts that PDDL
    or Longstep does not have.
    """
    from unified_planning.io import PDDLWriter

    _check_time(problem)
    if not ignore_bounds:
        _check_bounds(problem)
    writer = PDDLWriter(problem)
    try:
        domain, task = writer.get_domain(), writer.get_problem()
    except Exception as error:
        raise Unreadable(f"the problem cannot be written in PDDL: {error}") from error
    return Translation(problem, writer, Problem(domain, task))
