"""Answers have the bytes of the program's `--json`, on the plans of all shipped suites; LONGSTEP_PROGRAM names the program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import longstep
from scenes import ROOT
from suites import Task, damaged, tasks, without_times

PROGRAM = os.environ.get("LONGSTEP_PROGRAM")


def printed(*arguments: str | Path) -> str:
    """The output of the program, without its durations."""
    assert PROGRAM
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json"], capture_output=True, text=True, check=False)
    return without_times(done.stdout)


def own(answer: longstep.Answer) -> str:
    """The JSON of an answer, without its durations, as it is printed."""
    return without_times(answer.json() + "\n")


@unittest.skipUnless(PROGRAM, "LONGSTEP_PROGRAM names no program")
@unittest.skipUnless(sys.version_info >= (3, 11), "suites are TOML files, which Python reads from 3.11 on")
class Bytes(unittest.TestCase):
    def compare(self, task: Task, folder: Path) -> tuple[int, list[str]]:
        """Compares the answers for a goal; returns how many were compared, and the differing ones."""
        world = longstep.World(task.scene, domain=task.domain)
        place = ("--env", task.scene, "--domain", task.domain)
        answer = longstep.solve(world, task.goal)
        saved, whole, broken = (folder / f"{name}.json" for name in ("saved", "whole", "broken"))
        pairs = [("solve", own(answer), printed("solve", "--goal", task.goal, *place, "--save", saved))]
        if answer.plan is not None:
            pairs.append(("the file of the plan", answer.plan.json() + "\n", saved.read_text(encoding="utf-8")))
            whole.write_text(answer.plan.json(), encoding="utf-8")
            broken.write_text(json.dumps(damaged(answer.plan.dict())), encoding="utf-8")
            pairs.append(("verify", own(longstep.verify(whole, world)), printed("verify", whole, *place)))
            pairs.append(("verify broken", own(longstep.verify(broken, world)), printed("verify", broken, *place)))
            pairs.append(("repair", own(longstep.repair(broken, world)), printed("repair", broken, *place)))
        return len(pairs), [f"{what} of `{task.goal}` in {task.scene.name}" for what, mine, its in pairs if mine != its]

    def test_answers_have_the_bytes_of_the_program(self) -> None:
        every = int(os.environ.get("LONGSTEP_EVERY", "1"))
        chosen = tasks()[::every]
        with tempfile.TemporaryDirectory() as parent, ThreadPoolExecutor(os.cpu_count()) as pool:
            folders = [Path(parent) / str(number) for number in range(len(chosen))]
            for folder in folders:
                folder.mkdir()
            results = list(pool.map(self.compare, chosen, folders))
        compared, differing = sum(count for count, _ in results), [line for _, lines in results for line in lines]
        self.assertEqual(differing, [])
        self.assertGreater(compared, 3 * len(chosen) // 2)
        print(f"{compared} answers for {len(chosen)} goals have the bytes of the program", file=sys.stderr)

    def test_foreign_plans_and_problems_have_the_bytes_of_the_program(self) -> None:
        environments, plans = ROOT / "examples" / "environments", ROOT / "examples" / "plans"
        cases = [(plans / "warm_cupcake.json", environments / "flat.json"), (plans / "tidy_magazine.txt", environments / "flat.json")]
        for plan, scene in cases:
            world = longstep.World(scene, domain="virtualhome")
            for name, function in (("verify", longstep.verify), ("repair", longstep.repair)):
                self.assertEqual(own(function(plan, world)), printed(name, plan, "--env", scene, "--domain", "virtualhome"))
        with tempfile.TemporaryDirectory() as folder:
            domain, problem, plan = (Path(folder) / name for name in ("domain.pddl", "problem.pddl", "plan.txt"))
            domain.write_text("(define (domain lamps) (:predicates (lit ?lamp)) (:action light :parameters (?lamp) "
                              ":precondition (not (lit ?lamp)) :effect (lit ?lamp)))", encoding="utf-8")
            problem.write_text("(define (problem evening) (:domain lamps) (:objects hall porch) (:init (lit hall)) "
                               "(:goal (forall (?lamp) (lit ?lamp))))", encoding="utf-8")
            plan.write_text("(light hall)\n", encoding="utf-8")
            task = longstep.Problem(domain, problem)
            place = ("--domain", domain, "--problem", problem)
            self.assertEqual(own(longstep.solve(task)), printed("solve", *place))
            self.assertEqual(own(longstep.verify(plan, task)), printed("verify", plan, *place))
            self.assertEqual(own(longstep.repair(plan, task)), printed("repair", plan, *place))


if __name__ == "__main__":
    unittest.main()
