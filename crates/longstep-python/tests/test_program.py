"""Answers have the bytes of the program's `--json`, and plans those of its exports, on the plans of all shipped suites; LONGSTEP_PROGRAM names the program."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import unittest
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import cast

import longstep
from scenes import ROOT, desk, reply
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


def text_or_message(write: Callable[[], str]) -> str:
    """A text, or the first line of the reason why there is none."""
    try:
        return write()
    except longstep.Unreadable as error:
        return str(error.args[0])


def exported(saved: Path, task: Task, *arguments: str) -> str:
    """The output of `longstep export`, or the first line of its error."""
    assert PROGRAM
    command = [PROGRAM, "export", str(saved), "--domain", task.domain, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout if done.returncode == 0 else done.stderr.splitlines()[0].removeprefix("error: ")


def exported_task(saved: Path, task: Task, folder: Path) -> str:
    """The three files of `longstep export --folder` without the mark of the program, or the first line of its error."""
    printed = exported(saved, task, "--format", "pddl", "--folder", str(folder))
    if not folder.exists():
        return printed
    return task_text({own.name: own.read_text(encoding="utf-8").split("\n", 1)[1] for own in folder.iterdir()})


def task_text(files: dict[str, str]) -> str:
    """The files of a task as one text."""
    return "".join(f"{name}\n{text}" for name, text in sorted(files.items()))


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

    def compare_notations(self, task: Task, folder: Path) -> tuple[int, list[str]]:
        """Compares the plan for a goal in every notation; returns how many were compared, and the differing ones."""
        plan = longstep.solve(longstep.World(task.scene, domain=task.domain), task.goal).plan
        if plan is None:
            return 0, []
        saved = folder / "saved.json"
        saved.write_text(plan.json(), encoding="utf-8")
        forms: dict[tuple[str, ...], Callable[[], str]] = {
            ("pddl",): plan.pddl,
            ("bt",): plan.behavior_tree,
            ("bt", "--guards"): lambda: plan.behavior_tree(guards=True),
            ("mermaid",): plan.mermaid,
            ("dot",): plan.dot,
            ("python",): plan.script,
            ("svg", "--width", "640"): lambda: plan.svg(width=640),
            ("scene", "--width", "640"): lambda: plan.scene(width=640),
        }
        pairs = [(" ".join(form), text_or_message(write), exported(saved, task, "--format", *form)) for form, write in forms.items()]
        pairs.append(("task", text_or_message(lambda: task_text(plan.pddl_task(name="saved"))), exported_task(saved, task, folder / "task")))
        return len(pairs), [f"{what} of `{task.goal}` in {task.scene.name}" for what, mine, its in pairs if mine != its]

    def test_notations_have_the_bytes_of_the_program(self) -> None:
        self.check(self.compare_notations, "notations")

    def test_answers_have_the_bytes_of_the_program(self) -> None:
        self.check(self.compare, "answers")

    def check(self, compare: Callable[[Task, Path], tuple[int, list[str]]], what: str) -> None:
        """Compares the goals of all suites, or every so many of them."""
        every = int(os.environ.get("LONGSTEP_EVERY", "1"))
        chosen = tasks()[::every]
        with tempfile.TemporaryDirectory() as parent, ThreadPoolExecutor(os.cpu_count()) as pool:
            folders = [Path(parent) / str(number) for number in range(len(chosen))]
            for folder in folders:
                folder.mkdir()
            results = list(pool.map(compare, chosen, folders))
        compared, differing = sum(count for count, _ in results), [line for _, lines in results for line in lines]
        self.assertEqual(differing, [])
        self.assertGreater(compared, 3 * len(chosen) // 2)
        print(f"{compared} {what} for {len(chosen)} goals have the bytes of the program", file=sys.stderr)

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

    def test_the_log_of_a_session_is_replayed_without_a_difference(self) -> None:
        replies = iter([reply(question="Which one?"), reply("put(pen, shelf)"), reply("put(pen, desk)")])
        session = longstep.Session(desk(), lambda _: next(replies))
        session.instruct("Put it on the shelf")
        session.answer("the pen")
        session.accept()
        session.instruct("Now the pen back to the desk")
        session.accept()
        session.undo()
        with tempfile.TemporaryDirectory() as folder:
            own = Path(folder) / "errand"
            own.mkdir()
            (own / "session.jsonl").write_text(session.log(), encoding="utf-8")
            command = [cast(str, PROGRAM), "session", "replay", "errand"]
            done = subprocess.run(command, env={**os.environ, "LONGSTEP_SESSIONS": folder}, capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
