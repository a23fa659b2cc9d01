"""Robot plans that are verified, step by step, against a model of the world.

>>> import longstep
>>> world = longstep.World({
...     "assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
...     "object_states": {"<pen>": "on_something(<desk>)"}})
>>> plan = longstep.solve(world, "put(pen, shelf)").verified()
>>> len(plan), plan.steps[0].explanation
(6, 'move the hand to the pen')
>>> longstep.run(plan, longstep.Sim(world), approve="never").is_done
True
"""

from longstep._client import Client, RunView, ServerError, SessionView
from longstep._errors import GaveUp, LongstepError, NotValid, Question, StepFailed, Unreadable, Unsolvable
from longstep._longstep import (
    Answer,
    Control,
    Domain,
    Edit,
    Plan,
    Problem,
    Run,
    Session,
    Sim,
    Step,
    Violation,
    World,
    __version__,
    repair,
    run,
    solve,
    verify,
)
from longstep._types import (
    Environment,
    Message,
    Model,
    Observation,
    Request,
    Robot,
    RunQuestion,
    SensingRobot,
)

__all__ = [
    "Answer",
    "Client",
    "Control",
    "Domain",
    "Edit",
    "Environment",
    "GaveUp",
    "LongstepError",
    "Message",
    "Model",
    "NotValid",
    "Observation",
    "Plan",
    "Problem",
    "Question",
    "Request",
    "Robot",
    "Run",
    "RunQuestion",
    "RunView",
    "SensingRobot",
    "ServerError",
    "Session",
    "SessionView",
    "Sim",
    "Step",
    "StepFailed",
    "Unreadable",
    "Unsolvable",
    "Violation",
    "World",
    "__version__",
    "repair",
    "run",
    "solve",
    "verify",
]
