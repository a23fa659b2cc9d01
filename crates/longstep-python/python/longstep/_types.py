"""Types of the data that callers give and get. They have no code at run time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Protocol, TypedDict

__all__ = [
    "Environment",
    "Message",
    "Model",
    "Observation",
    "Request",
    "ResponseFormat",
    "Robot",
    "RunQuestion",
    "SensingRobot",
]


class Environment(TypedDict, total=False):
    """An environment: entities by identifier (`"<cup>"`), and their states (`"on_something(<desk>)"`)."""

    assets: Sequence[str]
    asset_states: Mapping[str, str | Sequence[str]]
    objects: Sequence[str]
    object_states: Mapping[str, str | Sequence[str]]
    asset_properties: Mapping[str, str | Sequence[str]]
    object_properties: Mapping[str, str | Sequence[str]]
    facts: Sequence[str]
    names: Mapping[str, str]
    types: Mapping[str, str]
    speaker: str
    robot: str


class Message(TypedDict):
    """A message of a conversation."""

    role: Literal["system", "user", "assistant"]
    content: str


class ResponseFormat(TypedDict):
    """The JSON schema of a reply, as OpenAI's chat completions take it."""

    type: Literal["json_schema"]
    json_schema: dict[str, Any]


class _RequestBase(TypedDict):
    messages: list[Message]
    temperature: float
    max_tokens: int


class Request(_RequestBase, total=False):
    """A request to a model, with the names of OpenAI's chat completions: `create(model=..., **request)`."""

    response_format: ResponseFormat


class Model(Protocol):
    """A language model: any callable that returns the text of its reply."""

    def __call__(self, request: Request, /) -> str:
        """Answers a request. An exception ends the instruction and comes out of the session."""
        ...


class _ObservationBase(TypedDict):
    states: Mapping[str, str | Sequence[str]]


class Observation(_ObservationBase, total=False):
    """What a robot sees.

    `states` has all states of each entity that was seen, in the words of an environment; an entity that is left out was not
    seen. `facts` has the statements without a subject, and all facts of the predicates in the robot's `reports`. A robot may
    see entities that the world of the plan does not have: they are ignored. A name without its brackets (`"juice"` for
    `"<juice>"`) is an error.
    """

    facts: Sequence[str] | None


class Robot(Protocol):
    """A robot: any object with these three methods.

    Its attribute `reports`, if it has one, lists the predicates of which `observe` reports all facts. Its method `begin_plan`,
    if it has one, is called with the world before each plan: then it may report events too, such as a wiped table, and counts
    them anew.
    """

    def perform(self, action: str, /, *arguments: str) -> None:
        """Performs a step, and returns when it is done.

        `action` is the name in `domain.pddl`, `arguments` are identifiers. Raise `StepFailed` for a step that failed.
        """
        ...

    def observe(self) -> Observation:
        """Returns what the robot sees."""
        ...

    def stop(self) -> None:
        """Stops the robot at once.

        A run calls it at most once: in its own thread, or in the thread that calls `Control.stop`, also while `perform` is at work.
        """
        ...


class SensingRobot(Robot, Protocol):
    """A robot for plans that branch on what it senses."""

    def sense(self, outcomes: list[str], action: str, /, *arguments: str) -> str:
        """Performs a sensing step, and returns the one of the outcomes that holds."""
        ...


class RunQuestion(TypedDict):
    """A question of a run to a person.

    `steps` are those of the plan or of its changed rest, `edits` the changes. `left_out` has the words of the instruction that
    the plan ignores, in a question about the plan.
    """

    kind: Literal["plan", "change", "step", "judge", "confirm"]
    text: str
    steps: list[str]
    edits: list[str]
    left_out: list[str]
