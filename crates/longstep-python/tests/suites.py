"""The goals of the shipped suites, and plans for them with a step missing. `scripts/release/same_bytes.py` uses them too."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

if sys.version_info >= (3, 11):
    import tomllib

SUITES = Path(__file__).resolve().parents[2] / "longstep-eval" / "suites"

# Durations are the only part that differs from run to run.
TIMES = re.compile(r'"timings_ms": \{[^}]*\}')


class Task(NamedTuple):
    """A goal in a scene of a domain."""

    domain: str
    scene: Path
    goal: str


def goals_of(case: dict[str, Any]) -> Iterator[str]:
    """The goals of a case, and of its steps."""
    for own in (case, *case.get("steps", [])):
        goal = own.get("goal")
        if isinstance(goal, str):
            yield goal


def tasks() -> list[Task]:
    """Every goal of the suites once, with its domain and its scene."""
    found: dict[Task, None] = {}
    for suite in sorted(SUITES.iterdir()):
        domain = tomllib.loads((suite / "suite.toml").read_text(encoding="utf-8"))["domain"]
        for file in sorted(suite.glob("*.toml")):
            for case in tomllib.loads(file.read_text(encoding="utf-8")).get("case", []):
                for goal in goals_of(case):
                    found[Task(domain, suite / "scenes" / f"{case['scene']}.json", goal)] = None
    return list(found)


def damaged(plan: dict[str, Any]) -> dict[str, Any]:
    """The plan without the call in the middle; a plan that is a tree stays as it is."""
    cohesion = plan["task_cohesion"]
    calls = cohesion.get("task_sequence")
    if not calls:
        return plan
    kept = [call for place, call in enumerate(calls) if place != len(calls) // 2]
    return {**plan, "task_cohesion": {**cohesion, "task_sequence": kept}}


def without_times(output: str) -> str:
    """The output of the program without its durations."""
    return TIMES.sub("", output)
