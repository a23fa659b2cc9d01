#!/usr/bin/env python3
"""Compares the coverage of our search with `lama-first` on random solvable tasks. See docs/internals/peers.md.

    tools/peers/coverage.py --seed 7 --count 300 --limit 10

Exits with 1 if we solve fewer tasks, if our plans are longer in sum by more than 5 %, or if our verifier refuses a plan of
either planner. Times are shown and never decide.
"""

import argparse
import json
import random
import resource
import signal
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import compare
import fast_downward
import wheels
from coverage import tasks, worlds

# Our plans may be this much longer in sum than those of `lama-first`.
LENGTH_LIMIT = 1.05
# Steps of the shorter plan of the two; other tasks are replaced.
SHORTEST, LONGEST = 5, 60
ATTEMPTS = 50


@dataclass
class Pair:
    """A task, and the results of both planners."""

    task: tasks.Task
    ours: dict
    seconds: float
    theirs: fast_downward.Answer
    their_seconds: float

    @property
    def domain(self) -> str:
        """The name of the domain."""
        return self.task.name.split("-", 1)[1]

    @property
    def length(self) -> int | None:
        """The steps of our plan."""
        return self.ours.get("length")

    @property
    def least(self) -> int:
        """The steps of the shorter plan of the two; the least that counts if there is none."""
        lengths = [] if self.length is None else [self.length]
        return min(lengths + [self.theirs.length] * (self.theirs.outcome == "solved"), default=SHORTEST)

    @property
    def is_common(self) -> bool:
        """True if both planners found a plan."""
        return self.length is not None and self.theirs.outcome == "solved"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=random.randrange(10**6), help="seed of the tasks [default: random]")
    parser.add_argument("--count", type=int, default=300, help="number of tasks [default: 300]")
    parser.add_argument("--limit", type=int, default=10, help="processor seconds for a task [default: 10]")
    parser.add_argument("--runner", type=Path, help="the built program `peers` [default: build it]")
    parser.add_argument("--effort", help="effort of our search [default: normal]")
    parser.add_argument("--domains", nargs="*", help="only these domains")
    parser.add_argument("--processes", type=int, default=1, help="tasks at a time; more than 1 blurs the times")
    parser.add_argument("--keep", type=Path, help="folder for the tasks [default: a temporary one]")
    arguments = parser.parse_args()
    wheels.fetch(wheels.FAST_DOWNWARD)
    program = (arguments.runner or compare.build()).resolve()
    print(f"seed {arguments.seed}")
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(arguments.processes) as pool:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)

        def pair(number: int) -> Pair:
            for attempt in range(ATTEMPTS):
                task = tasks.write(folder, arguments.seed, number, attempt)
                ours, seconds = solve(program, task, arguments.limit, arguments.effort)
                started = processor_time()
                theirs = fast_downward.solve(task.domain, task.problem, fast_downward.FIRST, arguments.limit)
                found = Pair(task, ours, seconds, theirs, processor_time() - started)
                if SHORTEST <= found.least <= LONGEST:
                    return found
            sys.exit(f"error: no task of {SHORTEST} to {LONGEST} steps in {ATTEMPTS} attempts")

        wanted = [
            number
            for number in range(arguments.count)
            if not arguments.domains or tasks.domain_of(number) in arguments.domains
        ]
        failures = report(list(pool.map(pair, wanted)))
    for line in failures:
        print(f"FAILED  {line}")
    sys.exit(1 if failures else 0)


def processor_time() -> float:
    """Processor seconds of all processes that ended so far."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


def solve(program: Path, task: tasks.Task, limit: int, effort: str | None) -> tuple[dict, float]:
    """Our answer, and the processor seconds of the process; a process that reaches the limit counts as one without a plan."""
    command = [program, "solve", *(["--effort", effort] if effort else []), task.domain, task.problem]
    started = processor_time()
    limited = ["bash", "-c", 'ulimit -t "$0" && exec "$@"', str(limit), *map(str, command)]
    done = subprocess.run(limited, capture_output=True, text=True, check=False)
    seconds = processor_time() - started
    if done.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        return {"outcome": "limit"}, float(limit)
    if not done.stdout:
        sys.exit(f"error: no answer for {task.problem}\n{done.stderr}")
    return json.loads(done.stdout), seconds


def report(pairs: list[Pair]) -> list[str]:
    """Prints the tables and returns the failures."""
    for pair in pairs:
        if not pair.is_common:
            print(f"{pair.task.name}: {pair.ours['outcome']} here, {pair.theirs.outcome} there")
    print(f"{'':12}{'tasks':>7}{'ours':>7}{'theirs':>8}{'steps':>8}{'theirs':>8}{'ms':>9}{'theirs':>9}{'longest':>9}")
    for make in worlds.DOMAINS:
        line(make.__name__, [pair for pair in pairs if pair.domain == make.__name__])
    line("sum", pairs)
    common = [pair for pair in pairs if pair.is_common]
    own, other = sum(pair.length or 0 for pair in common), sum(pair.theirs.length for pair in common)
    shorter = sum((pair.length or 0) < pair.theirs.length for pair in common)
    longer = sum((pair.length or 0) > pair.theirs.length for pair in common)
    print(f"\nplans: {shorter} shorter and {longer} longer than theirs; {own / max(other, 1):.3f} of their steps")
    lengths = sorted(pair.theirs.length for pair in common)
    print(f"steps of their plans: median {statistics.median(lengths)}, {lengths[0]} to {lengths[-1]}")
    failures = [f"{pair.task.name}: our verifier refuses our plan" for pair in pairs if pair.ours.get("valid") is False]
    failures += [f"{pair.task.name}: unsolvable here" for pair in pairs if pair.ours["outcome"] == "unsolvable"]
    if sum(pair.length is not None for pair in pairs) < sum(pair.theirs.outcome == "solved" for pair in pairs):
        failures.append("fewer tasks solved")
    if own > LENGTH_LIMIT * other:
        failures.append(f"our plans are longer: {own} steps, not {other}")
    return failures


def line(name: str, pairs: list[Pair]) -> None:
    """Prints the figures of a domain."""
    if not pairs:
        return
    common = [pair for pair in pairs if pair.is_common]
    cells = [
        len(pairs),
        sum(pair.length is not None for pair in pairs),
        sum(pair.theirs.outcome == "solved" for pair in pairs),
        sum(pair.length or 0 for pair in common),
        sum(pair.theirs.length for pair in common),
    ]
    times = [statistics.median(pair.seconds for pair in pairs), statistics.median(pair.their_seconds for pair in pairs)]
    numbers = "".join(f"{cell:>{width}}" for cell, width in zip(cells, (7, 7, 8, 8, 8)))
    longest = max(pair.seconds for pair in pairs)
    print(f"{name:12}{numbers}" + "".join(f"{time * 1e3:>9.0f}" for time in [*times, longest]))


if __name__ == "__main__":
    main()
