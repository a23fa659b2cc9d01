#!/usr/bin/env python3
"""Compares the answers of two builds of the program, byte by byte, on the goals of all shipped suites and the shipped plans.

    scripts/release/same_bytes.py PROGRAM OTHER                a command with arguments is one word:
    scripts/release/same_bytes.py longstep "qemu-aarch64-static -L ROOT longstep-aarch64"
    scripts/release/same_bytes.py PROGRAM OTHER --every 20     a sample: every twentieth goal
    scripts/release/same_bytes.py --self-test PROGRAM          programs that differ in one byte, or crash, are found

For each goal: `solve` and the file of the plan; then `verify` of the plan, `verify` and `repair` of the plan without the call
in its middle. An answer is the exit status, the standard output and the standard error. Durations are left out. Exits with 1
where an answer differs.
"""

from __future__ import annotations

import argparse
import json
import shlex
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "crates" / "longstep-python" / "tests"))

from suites import Task, damaged, tasks, without_times  # noqa: E402

# Emulation is about fifteen times slower; the slowest goal takes seconds.
LIMIT_SECONDS = 900

# Exit statuses with an answer: verified, not valid, unsolvable, given up, a question. Others are errors and crashes.
ANSWERED = (0, 10, 11, 12, 13)


@dataclass
class Comparison:
    """The answers that were compared, by command, the differing ones, and the seconds of both programs."""

    compared: Counter[str] = field(default_factory=Counter)
    statuses: Counter[int] = field(default_factory=Counter)
    differing: list[str] = field(default_factory=list)
    seconds: list[float] = field(default_factory=lambda: [0.0, 0.0])

    def add(self, other: Comparison) -> None:
        """Adds the figures of another comparison."""
        self.compared += other.compared
        self.statuses += other.statuses
        self.differing += other.differing
        self.seconds = [mine + its for mine, its in zip(self.seconds, other.seconds, strict=True)]


class Pair:
    """Two programs that get the same arguments, each with a folder for the files that it writes."""

    def __init__(self, programs: Sequence[Sequence[str]], folder: Path) -> None:
        self.programs = programs
        self.folder = folder
        self.result = Comparison()

    def run(self, name: str, subject: str, *arguments: str | Path) -> None:
        """Runs both programs, and compares their answers and the files that they save."""
        saved = self.folder / "saved.json"
        answers = []
        for place, program in enumerate(self.programs):
            saved.unlink(missing_ok=True)
            began = time.monotonic()
            done = subprocess.run([*program, name, *map(str, arguments), "--json"], capture_output=True, timeout=LIMIT_SECONDS,
                                  check=False)
            self.result.seconds[place] += time.monotonic() - began
            file = saved.read_bytes() if saved.exists() else b""
            answers.append((done.returncode, without_times(done.stdout.decode()), done.stderr, file))
        self.result.compared[name] += 1
        self.result.statuses[answers[0][0]] += 1
        if answers[0] != answers[1]:
            self.result.differing.append(f"{name} of {subject}")


def compare_goal(programs: Sequence[Sequence[str]], task: Task, folder: Path) -> Comparison:
    """Compares the answers for a goal and for the plan that is found for it."""
    pair = Pair(programs, folder)
    place = ("--env", task.scene, "--domain", task.domain)
    subject = f"`{task.goal}` in {task.scene.name}"
    saved, whole, broken = (folder / f"{name}.json" for name in ("saved", "whole", "broken"))
    pair.run("solve", subject, "--goal", task.goal, *place, "--save", saved)
    if saved.exists():
        saved.rename(whole)
        broken.write_text(json.dumps(damaged(json.loads(whole.read_text(encoding="utf-8")))), encoding="utf-8")
        pair.run("verify", f"the plan for {subject}", whole, *place)
        pair.run("verify", f"the damaged plan for {subject}", broken, *place)
        pair.run("repair", f"the damaged plan for {subject}", broken, *place)
    return pair.result


def compare_example(programs: Sequence[Sequence[str]], plan: Path, folder: Path) -> Comparison:
    """Compares the answers for a shipped plan."""
    pair = Pair(programs, folder)
    place = ("--env", ROOT / "examples" / "environments" / "flat.json", "--domain", "virtualhome")
    for name in ("verify", "repair"):
        pair.run(name, plan.name, plan, *place)
    return pair.result


def compare(programs: Sequence[Sequence[str]], every: int, processes: int) -> Comparison:
    """Compares the answers for every n-th goal, and for the shipped plans."""
    total = Comparison()
    with tempfile.TemporaryDirectory() as parent, ThreadPoolExecutor(processes) as pool:
        def folder(number: int) -> Path:
            made = Path(parent) / str(number)
            made.mkdir()
            return made

        goals = tasks()[::every]
        waiting = [pool.submit(compare_goal, programs, task, folder(number)) for number, task in enumerate(goals)]
        examples = sorted((ROOT / "examples" / "plans").iterdir())
        waiting += [pool.submit(compare_example, programs, plan, folder(len(goals) + number))
                    for number, plan in enumerate(examples)]
        for number, future in enumerate(waiting, 1):
            total.add(future.result())
            if number % 20 == 0:
                print(f"{number} of {len(waiting)}, {len(total.differing)} answers differ", file=sys.stderr, flush=True)
    return total


def is_sound(total: Comparison) -> bool:
    """Checks that the answers agree, and that they are answers: plans, violations and refusals, no crashes."""
    for line in total.differing:
        print(f"differs: {line}")
    unanswered = sum(count for status, count in total.statuses.items() if status not in ANSWERED)
    if unanswered:
        print(f"error: {unanswered} calls ended with an error: exit statuses {dict(total.statuses)}")
    planned = total.compared["verify"] > total.compared["solve"]
    if not planned:
        print("error: most goals have no plan")
    return not total.differing and not unanswered and planned


def self_test(program: Sequence[str]) -> bool:
    """Compares the program with itself, and with wrong ones that have to be found."""
    every = 60
    with tempfile.TemporaryDirectory() as folder:
        wrong = {}
        for name, end in (("one byte more", 'printf " "'), ("another exit status", "exit 7"), ("a line of errors", "echo >&2")):
            script = Path(folder) / name.replace(" ", "-")
            script.write_text(f'#!/bin/sh\n{shlex.join(program)} "$@"\nstatus=$?\n{end}\nexit $status\n', encoding="utf-8")
            script.chmod(0o755)
            wrong[name] = [str(script)]
        found = {name: compare((program, other), every, 2) for name, other in wrong.items()}
    for name, total in found.items():
        if len(total.differing) != total.compared.total():
            print(f"error: {name}: only {len(total.differing)} of {total.compared.total()} differing answers were found")
            return False
    return is_sound(compare((program, program), every, 2))


def main() -> int:
    """Reads the arguments, compares, and prints the figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+", metavar="PROGRAM", type=shlex.split, help="a program, or a command in quotes")
    parser.add_argument("--every", type=int, default=1, metavar="N", help="compare every n-th goal")
    parser.add_argument("--processes", type=int, default=2, metavar="N", help="goals at a time")
    parser.add_argument("--self-test", action="store_true", help="check the comparison, with one program")
    arguments = parser.parse_args()
    if len(arguments.programs) != (1 if arguments.self_test else 2):
        parser.error("name one program for --self-test, and two to compare")
    if arguments.self_test:
        sound = self_test(arguments.programs[0])
        print("the comparison finds wrong programs" if sound else "error: the self-test failed")
        return 0 if sound else 1
    total = compare(arguments.programs, arguments.every, arguments.processes)
    counts = ", ".join(f"{count} {name}" for name, count in sorted(total.compared.items()))
    same = total.compared.total() - len(total.differing)
    print(f"{same} of {total.compared.total()} answers have the same bytes ({counts}; exit statuses {dict(total.statuses)}); "
          f"{total.seconds[0]:.0f} s and {total.seconds[1]:.0f} s")
    return 0 if is_sound(total) else 1


if __name__ == "__main__":
    sys.exit(main())
