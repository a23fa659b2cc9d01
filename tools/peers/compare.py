#!/usr/bin/env python3
"""Compares our search with Fast Downward's. See docs/internals/peers.md.

    tools/peers/compare.py shipped        our own domains, written as PDDL: shortest plans of the same length
    tools/peers/compare.py order          goals with an order and prohibitions, written as ground PDDL tasks
    tools/peers/compare.py virtualhome    338 problems of somebody else's: as many solved, plans as short, faster

Exits with 1 where the planners disagree. Times are told and never decide.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import fast_downward
import wheels

ROOT = Path(__file__).resolve().parents[2]
# Seconds of blind search for one task; without the limit, a few tasks that have no plan take minutes.
SEARCH_LIMIT = 5
# What is known of the 338 problems.
SOLVABLE, UNSOLVABLE = 330, 8
# Plans may be this much longer in sum than those of Fast Downward.
LENGTH_LIMIT = 1.10


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["shipped", "order", "virtualhome"])
    parser.add_argument("--runner", type=Path, help="the built program `peers` [default: build it]")
    parser.add_argument("--processes", type=int, default=1, help="tasks at a time; more than 1 blurs the times")
    arguments = parser.parse_args()
    # Before there are several of us to fetch them.
    wheels.fetch(wheels.FAST_DOWNWARD)
    runner = (arguments.runner or build()).resolve()
    with tempfile.TemporaryDirectory() as folder, ThreadPoolExecutor(arguments.processes) as pool:
        compare = {"shipped": compare_shipped, "order": compare_order, "virtualhome": compare_virtualhome}[arguments.what]
        disagreements = compare(runner, Path(folder), pool)
    for line in disagreements:
        print(f"DISAGREE  {line}")
    if disagreements:
        sys.exit(1)


def build() -> Path:
    """Builds our side and returns its program."""
    command = ["cargo", "build", "--quiet", "--locked", "--release", "-p", "longstep-peers", "--bin", "peers"]
    subprocess.run(command, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
    return ROOT / target / "release/peers"


def ours(runner: Path, *arguments: str, lines: str = "") -> list[dict]:
    """What our side writes, one object to a line."""
    done = subprocess.run([runner, *arguments], input=lines, stdout=subprocess.PIPE, text=True, check=True)
    return [json.loads(line) for line in done.stdout.splitlines()]


def bad_plans(runner: Path, folder: Path, plans: list[tuple[Path, Path, fast_downward.Answer]]) -> list[str]:
    """The problems for which Fast Downward's plan is not good to our verifier."""
    lines = []
    for number, (domain, problem, answer) in enumerate(plans):
        file = folder / f"{number}.plan"
        file.write_text(answer.plan)
        lines.append(f"{domain}\t{problem}\t{file}\n")
    checked = ours(runner, "check", lines="".join(lines))
    return [f"{line['problem']}: our verifier refuses Fast Downward's plan" for line in checked if not line["valid"]]


def compare_shipped(runner: Path, folder: Path, pool: ThreadPoolExecutor) -> list[str]:
    """Goals of our own domains: both find shortest plans, so they must be equally long."""
    tasks = ours(runner, "export", str(folder))

    def ask(task: dict) -> fast_downward.Answer:
        domain, problem = Path(task["domain"]), Path(task["problem"])
        return fast_downward.solve(domain, problem, fast_downward.SHORTEST, SEARCH_LIMIT)

    disagreements, plans, undecided = [], [], 0
    for task, theirs in zip(tasks, pool.map(ask, tasks)):
        own = task.get("length", task["outcome"])
        other = theirs.length if theirs.outcome == "solved" else theirs.outcome
        told = f"{task['scene']}: {task['goal']}"
        if task["again"] != own:
            disagreements.append(f"{told}: {own}, but {task['again']} when what was written is read back")
        if "gave_up" in (own, other):
            undecided += 1
        elif own == other:
            pass
        elif isinstance(own, int) and isinstance(other, int) and not task["shortest"] and own > other:
            undecided += 1
        else:
            disagreements.append(f"{told}: {own} here, {other} there")
        if theirs.outcome == "solved":
            plans.append((Path(task["domain"]), Path(task["problem"]), theirs))
        print(f"{own!s:>10}  {other!s:>10}  {told}")
    disagreements += bad_plans(runner, folder, plans)
    print(f"\n{len(tasks)} tasks: {len(tasks) - undecided} compared, {undecided} given up by one of the two")
    return disagreements


def compare_order(runner: Path, folder: Path, pool: ThreadPoolExecutor) -> list[str]:
    """Goals with an order or a prohibition: cheapest plans of both are equally long, and theirs are good to us."""
    tasks = ours(runner, "order", str(folder))

    def ask(task: dict) -> fast_downward.Answer:
        domain, problem = Path(task["domain"]), Path(task["problem"])
        return fast_downward.solve(domain, problem, fast_downward.SHORTEST, SEARCH_LIMIT)

    disagreements, lines, undecided, lengths = [], [], 0, {}
    for number, (task, theirs) in enumerate(zip(tasks, pool.map(ask, tasks))):
        name = f"{task['scene']}: {task['goal']}"
        lengths[name] = task
        if "gave_up" in (task["outcome"], theirs.outcome):
            undecided += 1
        elif task["outcome"] != theirs.outcome:
            disagreements.append(f"{name}: {task['outcome']} here, {theirs.outcome} there")
        elif theirs.outcome == "solved":
            file = folder / f"{number}.plan"
            file.write_text(theirs.plan)
            lines.append(f"{task['scene']}\t{task['goal']}\t{file}\n")
    for line in ours(runner, "check-order", lines="".join(lines)):
        own = lengths[line["problem"]]
        if not line["valid"]:
            disagreements.append(f"{line['problem']}: our verifier refuses Fast Downward's plan")
        elif own["length"] < line["length"] or (own["shortest"] and own["length"] > line["length"]):
            disagreements.append(f"{line['problem']}: {own['length']} steps here, {line['length']} there")
    print(f"{len(tasks)} ordered tasks: {len(tasks) - undecided} compared, {undecided} given up by one of the two")
    return disagreements


@dataclass
class Pair:
    """A problem, and what both made of it."""

    problem: Path
    ours: dict
    our_process: float
    theirs: fast_downward.Answer

    @property
    def ratio(self) -> float:
        """How many times longer Fast Downward took than our library."""
        return self.theirs.seconds / (self.ours["microseconds"] / 1e6)

    @property
    def name(self) -> str:
        return f"{self.problem.parent.name}/{self.problem.stem}"


def compare_virtualhome(runner: Path, folder: Path, pool: ThreadPoolExecutor) -> list[str]:
    """Problems of somebody else's: as many solved and unsolvable, and plans about as short."""
    resources = wheels.fetch(wheels.VIRTUALHOME)
    domain = resources / "virtualhome.pddl"
    problems = sorted(resources.glob("problem_pddl/*/*.pddl"))

    def ask(problem: Path) -> Pair:
        # One after the other, so that both meet the same machine.
        started = time.perf_counter()
        [own] = ours(runner, "solve", str(domain), str(problem))
        own_process = time.perf_counter() - started
        return Pair(problem, own, own_process, fast_downward.solve(domain, problem, fast_downward.FIRST))

    pairs = list(pool.map(ask, problems))
    disagreements = []
    for pair in pairs:
        if pair.ours["outcome"] != pair.theirs.outcome:
            disagreements.append(f"{pair.name}: {pair.ours['outcome']} here, {pair.theirs.outcome} there")
        if pair.ours.get("valid") is False:
            disagreements.append(f"{pair.name}: our verifier refuses our plan")
        compared = pair.ours["outcome"] == pair.theirs.outcome == "solved"
        if compared and pair.ours["shortest"] and pair.ours["length"] > pair.theirs.length:
            disagreements.append(f"{pair.name}: our shortest plan is longer than theirs")
    counts = {what: sum(pair.ours["outcome"] == what for pair in pairs) for what in ("solved", "unsolvable")}
    if (counts["solved"], counts["unsolvable"]) != (SOLVABLE, UNSOLVABLE):
        disagreements.append(f"expected {SOLVABLE} solved and {UNSOLVABLE} unsolvable problems")
    solved = [pair for pair in pairs if pair.ours["outcome"] == pair.theirs.outcome == "solved"]
    own_steps = sum(pair.ours["length"] for pair in solved)
    their_steps = sum(pair.theirs.length for pair in solved)
    if own_steps > LENGTH_LIMIT * their_steps:
        disagreements.append(f"our plans are much longer: {own_steps} steps, not {their_steps}")
    disagreements += bad_plans(runner, folder, [(domain, pair.problem, pair.theirs) for pair in solved])
    tell_virtualhome(pairs, solved, own_steps, their_steps)
    return disagreements


def tell_virtualhome(pairs: list[Pair], solved: list[Pair], own_steps: int, their_steps: int) -> None:
    """Prints the table."""

    def count(what: str) -> tuple[int, int]:
        return (
            sum(pair.ours["outcome"] == what for pair in pairs),
            sum(pair.theirs.outcome == what for pair in pairs),
        )

    library = [pair.ours["microseconds"] / 1e3 for pair in pairs]
    process = [pair.our_process * 1e3 for pair in pairs]
    theirs = [pair.theirs.seconds * 1e3 for pair in pairs]
    shorter = sum(pair.ours["length"] < pair.theirs.length for pair in solved)
    longer = sum(pair.ours["length"] > pair.theirs.length for pair in solved)
    proven = sum(bool(pair.ours["shortest"]) for pair in solved)
    worst = min(pairs, key=lambda pair: pair.ratio)
    slowest = max(pairs, key=lambda pair: pair.ours["microseconds"])
    rows = [("", "longstep", "as a process", "lama-first")]
    for what in ("solved", "unsolvable"):
        own, other = count(what)
        rows.append((what, f"{own}", f"{own}", f"{other}"))
    rows.append(("steps in sum", f"{own_steps}", f"{own_steps}", f"{their_steps}"))
    for name, of in (("median, ms", statistics.median), ("largest, ms", max), ("sum, ms", sum)):
        rows.append((name, *(f"{of(times):.2f}" for times in (library, process, theirs))))
    for row in rows:
        print(f"{row[0]:14}" + "".join(f"{cell:>14}" for cell in row[1:]))
    print(f"\nplans proven shortest: {proven} of {len(solved)}; shorter than theirs: {shorter}; longer: {longer}")
    print(f"Fast Downward takes {statistics.median(theirs) / statistics.median(library):.0f} times as long")
    print(f"  (medians; as a process {statistics.median(theirs) / statistics.median(process):.0f} times;")
    print(f"  sums {sum(theirs) / sum(library):.0f} times;")
    print(f"  nearest: {worst.name}, {worst.ratio:.1f} times; our slowest: {slowest.name},")
    print(f"  {slowest.ours['microseconds'] / 1e3:.1f} ms)")


if __name__ == "__main__":
    main()
