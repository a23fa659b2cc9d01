from __future__ import annotations

import abc
import enum
import importlib
import re
import threading
import time
import xml.etree.ElementTree as ElementTree
from typing import Any, Callable, Generic, NamedTuple, Optional, TypeVar, Union


class Status(enum.Enum):
    """The status of an action without a result."""

    RUNNING = "running"
    FAILED = "failed"


class Done(enum.Enum):
    """The result of a physical action that has succeeded."""

    DONE = "done"


Result = TypeVar("Result")


class Task(abc.ABC, Generic[Result]):
    """An action that the robot has begun. Its result is `Done.DONE`, or the outcome of a sensing action."""

    @abc.abstractmethod
    def poll(self) -> Union[Result, Status]:
        """Returns at once. It is called with every tick until it returns something else than `Status.RUNNING`."""

    @abc.abstractmethod
    def halt(self) -> None:
        """Stops the robot. It is called once if the action must end before its result; nothing moves when it returns."""


class _ThreadTask(Task[Result]):
    def __init__(self, work: Callable[[threading.Event], Optional[Result]]) -> None:
        self._stop = threading.Event()
        self._result: Optional[Result] = None
        self._error: Optional[BaseException] = None
        self._thread = threading.Thread(target=self._run, args=(work,), daemon=True)
        self._thread.start()

    def _run(self, work: Callable[[threading.Event], Optional[Result]]) -> None:
        try:
            self._result = work(self._stop)
        except BaseException as error:
            self._error = error

    def poll(self) -> Union[Result, Status]:
        if self._thread.is_alive():
            return Status.RUNNING
        if self._error is not None:
            raise self._error
        return Status.FAILED if self._result is None else self._result

    def halt(self) -> None:
        self._stop.set()
        self._thread.join()


def in_thread(work: Callable[[threading.Event], Optional[Result]]) -> Task[Result]:
    """Does an action in a thread of its own. The work returns the result, or None if it fails, and has to look at its
    argument often, for example with `stop.wait(0.01)`: a halted tree waits until the work returns."""
    return _ThreadTask(work)


