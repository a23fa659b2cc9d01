"""Fast Downward, run as a program."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import wheels

# Shortest plans, whatever the domain uses: blind search knows conditional effects and axioms, and is still right
# with them, which the cleverer heuristics are not.
SHORTEST = ["--search", "astar(blind())"]
# The first plan of its satisficing configuration.
FIRST = ["--alias", "lama-first"]

# Its exit codes, as far as they say something about the task.
OUTCOMES = {0: "solved", 10: "unsolvable", 11: "unsolvable", 12: "gave_up"} | dict.fromkeys(range(20, 25), "gave_up")


@dataclass
class Answer:
    """What Fast Downward said: `solved`, `unsolvable` or `gave_up`, its plan, and its wall time in seconds."""

    outcome: str
    plan: str
    seconds: float

    @property
    def length(self) -> int:
        """How many steps the plan has."""
        return sum(line.startswith("(") for line in self.plan.splitlines())


def solve(
    domain: Path, problem: Path, configuration: list[str], limit: int | None = None, translation: int = 60
) -> Answer:
    """Runs Fast Downward on a task, for at most `limit` seconds of search and, if there is a limit, `translation` before it."""
    driver = wheels.fetch(wheels.FAST_DOWNWARD) / "fast-downward.py"
    with tempfile.TemporaryDirectory() as folder:
        plan = Path(folder) / "plan"
        command = [sys.executable, str(driver), "--plan-file", str(plan)]
        if limit is not None:
            command += ["--search-time-limit", str(limit)]
        options, search = ([], configuration) if configuration[0] == "--search" else (configuration, [])
        command += [*options, str(domain.resolve()), str(problem.resolve()), *search]
        started = time.perf_counter()
        process = subprocess.Popen(
            command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
        )
        try:
            # Its translator has no limit of its own, and may need one.
            out, err = process.communicate(timeout=None if limit is None else limit + translation)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            return Answer("gave_up", "", time.perf_counter() - started)
        seconds = time.perf_counter() - started
        if process.returncode not in OUTCOMES:
            said = (out + err)[-2000:]
            sys.exit(f"error: Fast Downward cannot read {problem}\n{said}")
        outcome = OUTCOMES[process.returncode]
        return Answer(outcome, plan.read_text() if outcome == "solved" else "", seconds)
