"""The command: draws cases, asks both, prints what came of it."""

import argparse
import collections
import json
import random
import secrets
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

from . import selftest, task_compare
from .cases import CLASSES, Case, Source
from .compare import compare, shrink
from .judge import Judge, build

# Seeds that one worker draws at a time, and disagreements that are shrunk in one chunk.
CHUNK, SHRUNK = 12, 3
# Planning tasks of one process.
TASKS = 25


@dataclass
class Tally:
    """Counts for one class, and its disagreements."""

    cases: int = 0
    valid: int = 0
    over: int = 0
    missed: int = 0
    disagreements: list[dict] = field(default_factory=list)


def run_chunk(program: Path, seeds: list[int], kinds: list[str], faults: frozenset, keep: Path | None) -> dict[str, Tally]:
    """Draws the cases of some seeds, judges them, and compares."""
    tallies: dict[str, Tally] = collections.defaultdict(Tally)
    judge = Judge(program)
    with tempfile.TemporaryDirectory() as folder:
        cases = [case for seed in seeds for case in Source(seed, keep or Path(folder), kinds).batch()]
        answers = judge.ask([case.request() for case in cases])
        shrunk = 0
        for case, answer in zip(cases, answers):
            tally = tallies[case.kind]
            comparison = compare(case, answer, faults)
            if faults and comparison.difference and compare(case, answer).difference:
                # Not the fault's doing: they differ without it.
                comparison.difference = None
            tally.cases += 1
            tally.valid += comparison.valid
            tally.over += comparison.over
            tally.missed += comparison.missed
            if comparison.difference is None:
                continue
            difference = comparison.difference
            if shrunk < SHRUNK and not faults:
                shrunk += 1
                case, difference = shrink(case, judge, faults, difference)
            tally.disagreements.append({"difference": difference, **report(case)})
    return dict(tallies)


def report(case: Case) -> dict:
    """A case as it is printed: enough to see it, and the request with which to repeat it."""
    told = {"class": case.kind, "seed": case.seed, "request": case.request()}
    folder = Path(case.domain)
    if folder.is_dir():
        told["files"] = {name: (folder / name).read_text() for name in ("domain.pddl", "domain.toml")}
    return told


def sample(arguments, program: Path, seed: int, faults: frozenset = frozenset(), stop: bool = False) -> dict[str, Tally]:
    """Compares as many cases as are wanted, in several processes."""
    draw = random.Random(seed)
    total: dict[str, Tally] = collections.defaultdict(Tally)
    keep, told = arguments.keep, 0
    with ProcessPoolExecutor(arguments.processes) as pool:
        while sum(tally.cases for tally in total.values()) < arguments.cases:
            chunks = [[draw.randrange(10**9) for _ in range(CHUNK)] for _ in range(arguments.processes * 2)]
            jobs = [pool.submit(run_chunk, program, chunk, arguments.classes, faults, keep) for chunk in chunks]
            for job in jobs:
                for kind, tally in job.result().items():
                    merge(total[kind], tally)
                    for disagreement in tally.disagreements:
                        if not faults:
                            print(f"DISAGREE {json.dumps(disagreement)}", flush=True)
            done = sum(tally.cases for tally in total.values())
            if done // 5000 > told and not faults:
                told = done // 5000
                print(f"{done} cases", file=sys.stderr, flush=True)
            if stop and any(tally.disagreements for tally in total.values()):
                break
    return total


def compare_tasks(arguments, program: Path, seed: int) -> bool:
    """Compares the search with the least costs of random planning tasks; returns true if all agree."""
    draw = random.Random(seed)
    counts: collections.Counter = collections.Counter()
    disagree = 0
    with ProcessPoolExecutor(arguments.processes) as pool:
        sizes = [min(TASKS, arguments.tasks - begin) for begin in range(0, arguments.tasks, TASKS)]
        jobs = [pool.submit(task_compare.run, program, draw.randrange(10**9), size) for size in sizes]
        for job in jobs:
            result = job.result()
            counts.update(result["counts"])
            disagree += len(result["disagreements"])
            for disagreement in result["disagreements"]:
                print(f"DISAGREE {json.dumps(disagreement)}", flush=True)
    print(
        f"{counts['cases']} tasks: {counts['solved']} solved, {counts['unsolvable']} unsolvable, "
        f"{counts['over']} over a bound, {disagree} disagree"
    )
    return disagree == 0


def merge(total: Tally, more: Tally) -> None:
    """Adds counts."""
    total.cases += more.cases
    total.valid += more.valid
    total.over += more.over
    total.missed += more.missed
    total.disagreements += more.disagreements


def print_table(total: dict[str, Tally]) -> None:
    """Prints the counts."""
    print(f"{'class':10}{'cases':>9}{'valid':>9}{'over a bound':>14}{'binding missed':>16}{'disagree':>10}")
    for kind in CLASSES:
        if kind in total:
            tally = total[kind]
            share = f"{100 * tally.valid / max(1, tally.cases):.0f} %"
            print(f"{kind:10}{tally.cases:>9}{share:>9}{tally.over:>14}{tally.missed:>16}{len(tally.disagreements):>10}")


def main() -> None:
    """Runs the command."""
    parser = argparse.ArgumentParser(description="Compares the verifier and the search with an independent simulator.")
    parser.add_argument("--cases", type=int, default=2000, help="how many [default: 2000]")
    parser.add_argument("--seed", type=int, help="what the sample is drawn from [default: a new one, printed]")
    parser.add_argument("--class", dest="classes", action="append", choices=CLASSES, help="only this class; repeatable")
    parser.add_argument("--runner", type=Path, help="the built example `judge` [default: build it]")
    parser.add_argument("--processes", type=int, default=2, help="cases at a time [default: 2]")
    parser.add_argument("--keep", type=Path, help="a folder for the random domains, which are else removed")
    parser.add_argument("--tasks", type=int, help="so many random planning tasks with costs and numbers instead")
    parser.add_argument("--self-test", action="store_true", help="test the simulator itself")
    arguments = parser.parse_args()
    arguments.classes = arguments.classes or CLASSES
    seed = arguments.seed if arguments.seed is not None else secrets.randbelow(10**9)
    program = (arguments.runner or build()).resolve()
    if arguments.self_test:
        print(f"seed {seed}", flush=True)
        failures = selftest.run_by_hand(program)
        failures += selftest.run_faults(arguments, program, seed, sample)
        sys.exit(1 if failures else 0)
    print(f"seed {seed}", flush=True)
    started = time.monotonic()
    if arguments.tasks:
        agree = compare_tasks(arguments, program, seed)
        print(f"{time.monotonic() - started:.0f} s, seed {seed}")
        sys.exit(0 if agree else 1)
    total = sample(arguments, program, seed)
    print_table(total)
    print(f"{sum(tally.cases for tally in total.values())} cases in {time.monotonic() - started:.0f} s, seed {seed}")
    sys.exit(1 if any(tally.disagreements for tally in total.values()) else 0)
