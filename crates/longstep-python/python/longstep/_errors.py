"""Exceptions, with the next step for the user and the answer if there is one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from longstep._longstep import Answer


class LongstepError(Exception):
    """A request that failed.

    `hint` is the next step for the user, `answer` the whole answer; both are None if there is none. An error that comes from
    another process has no answer.
    """

    def __init__(self, message: str, *, hint: str | None = None, answer: Answer | None = None) -> None:
        super().__init__(message)
        self.hint = hint
        self.answer = answer

    def __str__(self) -> str:
        message = str(self.args[0]) if self.args else ""
        return f"{message}\nhint: {self.hint}" if self.hint else message

    def __reduce__(self) -> tuple[Any, ...]:
        # An answer stays in its process.
        return _restored, (type(self), self.args, {**self.__dict__, "answer": None})


def _restored(cls: type[LongstepError], args: tuple[object, ...], state: dict[str, Any]) -> LongstepError:
    """Returns an error from another process."""
    error = cls.__new__(cls, *args)
    error.__dict__.update(state)
    return error


class Unreadable(LongstepError):
    """An input that cannot be read: an environment, a domain, a plan, a goal or a rule."""


class NotValid(LongstepError):
    """A plan with violations; `answer.violations` lists them."""


class Unsolvable(LongstepError):
    """A goal that no plan reaches. This is proven."""


class GaveUp(LongstepError):
    """A goal for which no plan was found within the limits."""


class Question(LongstepError):
    """An instruction that is not clear; `answer.question` is the question."""


class StepFailed(LongstepError):
    """A step that a robot could not do. A robot raises it in `perform`, and stays usable: the world is observed then."""

    def __init__(self, message: str = "the robot did not say why", *, hint: str | None = None, answer: Answer | None = None) -> None:
        super().__init__(message, hint=hint, answer=answer)
