"""Scenes and robots that several tests use."""

from __future__ import annotations

import json
from pathlib import Path

import longstep

ROOT = Path(__file__).resolve().parents[3]

DESK: longstep.Environment = {
    "assets": ["<desk>", "<shelf>"],
    "objects": ["<pen>"],
    "object_states": {"<pen>": "on_something(<desk>)"},
}

PANTRY: longstep.Environment = {
    "assets": ["<shelf>", "<trash_bin>", "<fridge>"],
    "objects": ["<milk>", "<fridge_handle>"],
    "object_states": {"<milk>": "on_something(<shelf>)", "<fridge_handle>": "closed()"},
}


def desk() -> longstep.World:
    """A pen on a desk, and a shelf."""
    return longstep.World(DESK)


def reply(goal: str = "", question: str = "", left_out: tuple[str, ...] = ()) -> str:
    """The reply of a model that names a goal, or asks; with the words that its goal does not say."""
    return json.dumps({"goal": goal, "left_out": list(left_out), "question": question})


class Recorder:
    """A robot that passes everything on to a simulated one, and keeps the calls."""

    def __init__(self, world: longstep.World) -> None:
        self._sim = longstep.Sim(world)
        self.reports = self._sim.reports
        self.calls: list[str] = []
        self.stops = 0

    def begin_plan(self, world: longstep.World) -> None:
        self._sim.begin_plan(world)

    def perform(self, action: str, /, *arguments: str) -> None:
        self.calls.append(" ".join((action, *arguments)))
        self._sim.perform(action, *arguments)

    def observe(self) -> longstep.Observation:
        return self._sim.observe()

    def stop(self) -> None:
        self.stops += 1
        self._sim.stop()
