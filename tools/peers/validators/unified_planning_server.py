"""Validates plans with unified-planning; `tools/peers/validators` runs it as a child, with the packages in PYTHONPATH.

Each line of the input is `DOMAIN.pddl PROBLEM.pddl PLAN`, with tabs between; each line of the output is a JSON object with the
`verdict`, `valid`, `invalid` or `unreadable`, and the `reason`.
"""

import json
import sys
import types
import warnings

# The package is for tuning parameters of engines, which no validator has; it needs SciPy.
sys.modules["ConfigSpace"] = types.ModuleType("ConfigSpace")
sys.modules["ConfigSpace"].ConfigurationSpace = object

from unified_planning.engines import SequentialPlanValidator  # noqa: E402
from unified_planning.engines.results import ValidationResultStatus  # noqa: E402
from unified_planning.exceptions import UPException  # noqa: E402
from unified_planning.io import PDDLReader  # noqa: E402
from unified_planning.shortcuts import get_environment  # noqa: E402


def validate(problem, plan: str) -> tuple[str, str]:
    """The verdict on a plan, and the reason."""
    try:
        steps = PDDLReader().parse_plan(problem, plan)
    # Its reader asserts that arguments fit, and raises its own errors for unknown names.
    except (UPException, AssertionError) as error:
        return "invalid", f"the plan cannot be read: {error}"
    result = SequentialPlanValidator().validate(problem, steps)
    reasons = "; ".join(message.message for message in result.log_messages or [])
    return ("valid" if result.status == ValidationResultStatus.VALID else "invalid"), reasons


def main() -> None:
    warnings.simplefilter("ignore")
    environment = get_environment()
    environment.credits_stream = None
    # PDDL lets an action have the name of a predicate.
    environment.error_used_name = False
    last, problem = None, None
    for line in sys.stdin:
        domain_file, problem_file, plan_file = line.rstrip("\n").split("\t")
        try:
            if last != (domain_file, problem_file):
                problem = PDDLReader().parse_problem(domain_file, problem_file)
                last = (domain_file, problem_file)
        # Syntax errors of the parser below it included: whatever stops it, the task cannot be read.
        except Exception as error:  # noqa: BLE001
            last, answer = None, ("unreadable", f"{type(error).__name__}: {error}")
        else:
            answer = validate(problem, plan_file)
        print(json.dumps({"verdict": answer[0], "reason": answer[1][:2000]}), flush=True)


if __name__ == "__main__":
    main()
