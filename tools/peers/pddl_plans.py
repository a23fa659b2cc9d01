#!/usr/bin/env python3
"""Lets others judge our PDDL: domains, problems and plans as `longstep export` writes them. See docs/guide/exports.md.

    tools/peers/pddl_plans.py                            # all plans of the shipped suites, 500 changed plans; some ten minutes
    tools/peers/pddl_plans.py --every 20 --mutations 60  # a sample
    tools/peers/pddl_plans.py --val VAL/bin/Validate     # with VAL as a second validator

1. unified-planning (and VAL, if it is there) accepts each plan for its exported domain and problem.
2. Fast Downward solves each exported task, and our verifier accepts its plan.
3. For changed plans (a step dropped, doubled, swapped, with another argument; the end cut off), the verdicts of our verifier and of
   the validators are the same. Our verdict is taken in the world from which the task was written, and in the one read back.

Before that, files that were broken on purpose have to be refused. Exits with 1 where there is a disagreement.
"""

import argparse
import collections
import json
import os
import random
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import fast_downward
import validators
import wheels

ROOT = Path(__file__).resolve().parents[2]
# Seconds of Fast Downward's search for one task, and of its translator before it; the task counts as undecided behind them.
SEARCH_LIMIT, TRANSLATION_LIMIT = 4, 6
CHANGES = ("drop", "swap", "argument", "double", "cut")


@dataclass(frozen=True)
class Task:
    """An exported plan with its domain and problem."""

    number: int
    domain_name: str
    folder: Path

    @property
    def files(self) -> tuple[Path, Path]:
        """The domain and the problem."""
        return self.folder / "domain.pddl", self.folder / "problem.pddl"

    def steps(self) -> list[str]:
        """The lines of the plan."""
        return (self.folder / "plan.pddl").read_text().splitlines()

    def objects(self) -> list[str]:
        """The names of the problem's objects."""
        problem = (self.folder / "problem.pddl").read_text()
        listed = problem.split("(:objects", 1)[1].split("\n  )", 1)[0]
        return re.findall(r"^ +(\S+) - ", listed, flags=re.MULTILINE)


class Ours:
    """Our side: writes the tasks, and judges plans for them."""

    def __init__(self, runner: Path, folder: Path, every: int) -> None:
        command = [str(runner), str(folder), str(every)]
        self.child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.tasks: list[Task] = []
        while "done" not in (line := self.line()):
            self.tasks.append(Task(line["number"], line["domain"], Path(line["folder"])))
        self.counts = line

    def line(self) -> dict:
        """The next line that it writes."""
        assert self.child.stdout
        text = self.child.stdout.readline()
        if not text:
            sys.exit(f"error: our side ended with {self.child.wait()}\nhint: its message is above")
        return json.loads(text)

    def verdict(self, task: Task, plan: Path) -> dict:
        """Our verdict on a plan."""
        assert self.child.stdin
        self.child.stdin.write(f"{task.number}\t{plan}\n")
        self.child.stdin.flush()
        return self.line()

    def close(self) -> None:
        """Lets the child end."""
        assert self.child.stdin
        self.child.stdin.close()
        self.child.wait()


@dataclass
class Comparison:
    """What was found."""

    failures: list[str] = field(default_factory=list)
    verdicts: collections.Counter = field(default_factory=collections.Counter)
    planner: collections.Counter = field(default_factory=collections.Counter)

    def fail(self, text: str) -> None:
        """Records and prints a failure."""
        self.failures.append(text)
        print(f"DISAGREE  {text}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="take each so many plans only [default: 1]")
    parser.add_argument("--mutations", type=int, default=500, help="number of changed plans [default: 500]")
    parser.add_argument("--planner", type=int, default=1, help="Fast Downward solves each so many tasks only [default: 1]")
    parser.add_argument("--seed", type=int, default=random.randrange(10**6), help="seed of the changes [default: random]")
    parser.add_argument("--runner", type=Path, help="the built program `pddl_plans` [default: build it]")
    parser.add_argument("--val", type=Path, default=os.environ.get("LONGSTEP_VAL"), help="VAL's program `Validate`")
    parser.add_argument("--keep", type=Path, help="folder for the files [default: a temporary one]")
    arguments = parser.parse_args()
    wheels.fetch(wheels.FAST_DOWNWARD)
    runner = (arguments.runner or build()).resolve()
    judges = [validators.UnifiedPlanning(), *([validators.Val(Path(arguments.val))] if arguments.val else [])]
    print(f"seed {arguments.seed}")
    with tempfile.TemporaryDirectory() as temporary:
        folder = (arguments.keep or Path(temporary)).resolve()
        ours = Ours(runner, folder, arguments.every)
        found = Comparison()
        refuse_broken(judges, ours, folder)
        accept_all(judges, ours, found)
        solve_all(ours, ours.tasks[:: arguments.planner], found)
        compare_changed(judges, ours, arguments, folder, found)
        for own in [*judges, ours]:
            own.close()
    report(judges, ours, found)
    sys.exit(1 if found.failures else 0)


def build() -> Path:
    """Builds our side and returns its program."""
    command = ["cargo", "build", "--quiet", "--locked", "-p", "longstep-peers", "--bin", "pddl_plans"]
    subprocess.run(command, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR") or ROOT / "target")
    return ROOT / target / "debug/pddl_plans"


def refuse_broken(judges: list, ours: Ours, folder: Path) -> None:
    """Breaks the files of a task; whoever accepts one cannot find anything, so this ends the comparison."""
    task = max(ours.tasks, key=lambda task: len(task.steps()))
    (domain, problem), steps = task.files, task.steps()
    broken = folder / "broken"
    broken.mkdir()
    cases = {
        "no-first-step": (domain, problem, steps[1:]),
        "no-last-step": (domain, problem, steps[:-1]),
        "no-such-action": (domain, problem, [*steps, "(levitate)"]),
        "no-such-object": (domain, problem, [*steps[:-1], steps[-1].rsplit(" ", 1)[0] + " no-such-object)"]),
        "other-goal": (domain, broken / "other-goal-problem", steps),
        "half-a-domain": (broken / "half-a-domain-domain", problem, steps),
        "half-a-problem": (domain, broken / "half-a-problem-problem", steps),
    }
    text = problem.read_text()
    (broken / "other-goal-problem").write_text(text.replace("(:goal (and", "(:goal (and (or)", 1))
    (broken / "half-a-domain-domain").write_text(domain.read_text()[: domain.stat().st_size // 2])
    (broken / "half-a-problem-problem").write_text(text[: text.index("(:goal")])
    for name, (own_domain, own_problem, lines) in cases.items():
        plan = broken / f"{name}.pddl"
        plan.write_text("\n".join(lines) + "\n")
        for judge in judges:
            if judge.validate(own_domain, own_problem, plan).verdict == "valid":
                sys.exit(f"error: {judge.name} accepts {name} in {task.folder}, so it finds nothing")
        if (own_domain, own_problem) == task.files and ours.verdict(task, plan)["valid"]:
            sys.exit(f"error: our verifier accepts {name} in {task.folder}, so it finds nothing")
    print(f"{len(cases)} broken tasks are refused")


def accept_all(judges: list, ours: Ours, found: Comparison) -> None:
    """Each plan is valid for its domain and problem."""
    for task in ours.tasks:
        plan = task.folder / "plan.pddl"
        own = ours.verdict(task, plan)
        if not (own["valid"] and own["valid_read_back"]):
            found.fail(f"{task.folder}: our verifier refuses our plan: {own}")
        for judge in judges:
            answer = judge.validate(*task.files, plan)
            found.verdicts[judge.name, "plans", answer.verdict] += 1
            if answer.verdict != "valid":
                found.fail(f"{task.folder}: {judge.name} says {answer.verdict}: {answer.reason}")


def solve_all(ours: Ours, tasks: list[Task], found: Comparison) -> None:
    """Fast Downward solves each task, and our verifier accepts its plan."""

    def solve(task: Task) -> fast_downward.Answer:
        if ":fluents" in task.files[0].read_text():
            return fast_downward.Answer("reads no numbers", "", 0.0)
        return fast_downward.solve(*task.files, fast_downward.FIRST, SEARCH_LIMIT, TRANSLATION_LIMIT)

    with ThreadPoolExecutor(2) as pool:
        for task, answer in zip(tasks, pool.map(solve, tasks)):
            found.planner[answer.outcome] += 1
            if answer.outcome == "unsolvable":
                found.fail(f"{task.folder}: Fast Downward proves that there is no plan")
            if answer.outcome != "solved":
                continue
            plan = task.folder / "fast-downward.plan"
            plan.write_text(answer.plan)
            own = ours.verdict(task, plan)
            found.planner["accepted"] += own["valid"] and own["valid_read_back"]
            if not (own["valid"] and own["valid_read_back"]):
                found.fail(f"{task.folder}: our verifier refuses Fast Downward's plan: {own}")


def compare_changed(judges: list, ours: Ours, arguments: argparse.Namespace, folder: Path, found: Comparison) -> None:
    """Both sides have the same verdict on changed plans."""
    chance = random.Random(arguments.seed)
    by_domain: dict[str, list[Task]] = {}
    for task in ours.tasks:
        if task.steps():
            by_domain.setdefault(task.domain_name, []).append(task)
    names = sorted(by_domain)
    drawn = []
    for number in range(arguments.mutations):
        task = chance.choice(by_domain[names[number % len(names)]])
        drawn.append((task.number, number, task, *changed(task, chance)))
    # The tasks in order, because a validator keeps the last one that it read.
    for _, number, task, change, lines in sorted(drawn, key=lambda own: own[:2]):
        plan = folder / f"changed-{number:04}.pddl"
        plan.write_text("".join(f"{line}\n" for line in lines))
        own = ours.verdict(task, plan)
        verdict = "valid" if own["valid"] else "invalid"
        found.verdicts["ours", change, verdict] += 1
        found.verdicts["domains", task.domain_name, verdict] += 1
        if own["valid"] != own["valid_read_back"]:
            found.fail(f"{plan}, {change}, {task.folder}: another verdict on what is read back: {own}")
        for judge in judges:
            answer = judge.validate(*task.files, plan)
            found.verdicts[judge.name, "changed", answer.verdict] += 1
            if answer.verdict != verdict:
                reason = f"{own['reasons']}; {judge.name}: {answer.reason}"
                found.fail(f"{plan}, {change}, {task.folder}: {verdict} here, {answer.verdict} there: {reason}")


def changed(task: Task, chance: random.Random) -> tuple[str, list[str]]:
    """A plan with one change, seldom two, and the name of the first."""
    lines, first = task.steps(), None
    for _ in range(chance.choice((1, 1, 1, 2))):
        # Two changes may have left nothing.
        if not lines:
            break
        fitting = [change for change in CHANGES if len(lines) > 1 or change in ("argument", "double")]
        change = chance.choice(fitting)
        first = first or change
        lines = CHANGE[change](lines, task, chance)
    assert first
    return first, lines


def drop(lines: list[str], _: Task, chance: random.Random) -> list[str]:
    """Without one step."""
    at = chance.randrange(len(lines))
    return lines[:at] + lines[at + 1 :]


def swap(lines: list[str], _: Task, chance: random.Random) -> list[str]:
    """With two steps in each other's place."""
    one, other = chance.sample(range(len(lines)), 2)
    lines = lines.copy()
    lines[one], lines[other] = lines[other], lines[one]
    return lines


def replace_argument(lines: list[str], task: Task, chance: random.Random) -> list[str]:
    """With another object as one argument: one that the plan has, or any."""
    at = chance.randrange(len(lines))
    words = lines[at].strip("()").split()
    if len(words) == 1:
        return drop(lines, task, chance)
    in_plan = sorted({word for line in lines for word in line.strip("()").split()[1:]})
    place = chance.randrange(1, len(words))
    words[place] = chance.choice(in_plan if chance.random() < 0.5 else task.objects() or in_plan)
    return [*lines[:at], f"({' '.join(words)})", *lines[at + 1 :]]


def double(lines: list[str], _: Task, chance: random.Random) -> list[str]:
    """With one step again, at any place behind it."""
    at = chance.randrange(len(lines))
    to = chance.randint(at + 1, len(lines))
    return [*lines[:to], lines[at], *lines[to:]]


def cut(lines: list[str], _: Task, chance: random.Random) -> list[str]:
    """Without its end."""
    return lines[: chance.randrange(len(lines))]


CHANGE = {"drop": drop, "swap": swap, "argument": replace_argument, "double": double, "cut": cut}


def report(judges: list, ours: Ours, found: Comparison) -> None:
    """Prints the figures."""
    counts = ours.counts
    print(f"\n{counts['plans']} plans of the suites: {counts['done']} exported, {counts['branching']} with branches or loops")
    for reason, number in counts["unwritable"].items():
        print(f"  {number} not written: {reason}")
    for judge in judges:
        for what in ("plans", "changed"):
            verdicts = {name: number for (who, of, name), number in found.verdicts.items() if (who, of) == (judge.name, what)}
            print(f"{judge.name}, {what}: {verdicts}")
    print(f"Fast Downward: {dict(found.planner)}")
    for who, heading in (("ours", "changes"), ("domains", "domains")):
        names = sorted({of for (own, of, _) in found.verdicts if own == who})
        cells = [f"{name} {found.verdicts[who, name, 'valid']}/{found.verdicts[who, name, 'invalid']}" for name in names]
        print(f"changed plans, valid/invalid, by {heading}: {', '.join(cells)}")
    print(f"{len(found.failures)} disagreement(s)")


if __name__ == "__main__":
    main()
