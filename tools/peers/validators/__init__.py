"""Validators of PDDL plans that others wrote, run as programs with limits of time and memory."""

import json
import os
import resource
import selectors
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import wheels

# For one plan; the largest takes seconds.
SECONDS = 120
BYTES = 4 << 30


@dataclass
class Verdict:
    """A validator's verdict on a plan: `valid`, `invalid`, `unreadable` (the domain or the problem) or `timeout`."""

    verdict: str
    reason: str = ""


def limit_memory() -> None:
    """Runs in the child."""
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))


class UnifiedPlanning:
    """The SequentialPlanValidator of unified-planning (Apache 2.0), which reads PDDL with its own reader."""

    name = "unified-planning"

    def __init__(self) -> None:
        packages = [wheels.UNIFIED_PLANNING, wheels.PYPARSING, wheels.NETWORKX]
        self.path = os.pathsep.join(str(wheels.fetch(wheel)) for wheel in packages)
        self.child: subprocess.Popen[str] | None = None

    def validate(self, domain: Path, problem: Path, plan: Path) -> Verdict:
        """The verdict on a plan; a problem that is the last one's is not read again."""
        if self.child is None:
            self.child = self.start()
        assert self.child.stdin and self.child.stdout
        self.child.stdin.write(f"{domain}\t{problem}\t{plan}\n")
        self.child.stdin.flush()
        with selectors.DefaultSelector() as selector:
            selector.register(self.child.stdout, selectors.EVENT_READ)
            if not selector.select(SECONDS):
                self.close()
                return Verdict("timeout", f"no verdict within {SECONDS} seconds")
        line = self.child.stdout.readline()
        if not line:
            sys.exit(f"error: the validator ended with {self.child.wait()} at {plan}\nhint: its message is above")
        return Verdict(**json.loads(line))

    def start(self) -> "subprocess.Popen[str]":
        """Starts the child."""
        return subprocess.Popen(
            [sys.executable, "-S", str(Path(__file__).parent / "unified_planning_server.py")],
            env={**os.environ, "PYTHONPATH": self.path, "PYTHONHASHSEED": "0", "PYTHONUTF8": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            preexec_fn=limit_memory,
        )

    def close(self) -> None:
        """Ends the child."""
        if self.child is not None:
            self.child.kill()
            self.child.wait()
            self.child = None


class Val:
    """VAL's `Validate` (BSD), a program that is built from its sources and not fetched here."""

    name = "VAL"

    def __init__(self, program: Path) -> None:
        self.program = program.resolve()

    def validate(self, domain: Path, problem: Path, plan: Path) -> Verdict:
        """The verdict on a plan."""
        # With `-v` it says why.
        command = [str(self.program), "-v", str(domain), str(problem), str(plan)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=SECONDS, preexec_fn=limit_memory, check=False
            )
        except subprocess.TimeoutExpired:
            return Verdict("timeout", f"no verdict within {SECONDS} seconds")
        said = done.stdout + done.stderr
        reason = said[-2000:]
        if "Plan valid" in said:
            return Verdict("valid")
        # An unknown name or an argument of the wrong type.
        if any(words in said for words in ("Plan failed", "Goal not satisfied", "Bad operator in plan", "Bad plan description")):
            return Verdict("invalid", reason)
        return Verdict("unreadable", reason)

    def close(self) -> None:
        """Nothing runs between two plans."""
