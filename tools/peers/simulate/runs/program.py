"""Runs through the program itself: `longstep run` with a robot behind another process, killed and resumed."""

import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from .judge import Judge, Settings
from .purpose import plan_faults
from .scenario import Scenario, Source

PEERS = Path(__file__).resolve().parents[2]
# Seconds after which a run counts as hanging.
PATIENCE = 30
# Exit codes of `run` after which a log can be resumed.
RESUMABLE = {50, 51, 52, 53, 54}


class ProgramRun:
    """One scenario through the program."""

    def __init__(self, program: Path, scenario: Scenario, seed: int, number: int, folder: Path):
        self.program, self.scenario, self.seed, self.number, self.folder = program, scenario, seed, number, folder
        self.random = random.Random(seed * 7 + number)
        self.judge = Judge(
            scenario.world, scenario.entries, scenario.purpose, scenario.steps, scenario.settings, set(scenario.reports)
        )
        self.judge.hears = True
        self.read = 0
        self.killed = 0
        self.answers: list[bool] = []
        self.log = folder / "run.jsonl"

    def command(self) -> list[str]:
        """The first command."""
        scenario = self.scenario
        (self.folder / "plan.json").write_text(json.dumps(scenario.plan))
        (self.folder / "env.json").write_text(json.dumps(scenario.environment))
        (self.folder / "rules.txt").write_text("".join(rule + "\n" for rule in scenario.rules))
        goal = ["--goal", scenario.goal] if scenario.goal is not None else []
        return [
            "run", str(self.folder / "plan.json"), "--env", str(self.folder / "env.json"), "--domain", scenario.domain,
            *goal, "--rules", str(self.folder / "rules.txt"), "--changes", str(scenario.settings.changes),
            "--observe", scenario.settings.watch, "--log", str(self.log), *self.policies(scenario.settings),
        ]  # fmt: skip

    def policies(self, settings: Settings) -> list[str]:
        """The robot and what a resumed run may change."""
        robot = f"process:{sys.executable} -m simulate.runs.robot_program {self.folder} {self.seed} {self.number}"
        return ["--robot", robot, "--approve", settings.approval, "--trust", settings.trust]

    def run(self) -> Judge:
        """Runs to the end, through kills."""
        code = self.start(self.command())
        if not self.log.exists():
            strict = plan_faults(self.scenario.purpose, self.scenario.steps, self.scenario.world.initial, strict=True)
            self.judge.counts["refused"] += 1
            if code == 10 and not strict:
                self.judge.blame("a valid plan is refused", self.words[-300:])
            return self.judge
        for _ in range(6):
            self.take_up()
            if code is not None and code not in RESUMABLE:
                break
            if self.judge.counts["began"] == 0 or self.judge.ended == "done":
                break
            settings = self.scenario.settings
            approval = self.random.choice([settings.approval, settings.approval, "never", "each-step"])
            self.judge.resumes(Settings(approval, settings.watch, settings.trust, settings.changes))
            code = self.start(["run", "--resume", str(self.log), *self.policies(Settings(approval, trust=settings.trust))])
        self.take_up()
        self.check_code(code)
        self.check_trace()
        return self.judge

    def check_code(self, code: int | None) -> None:
        """The exit code fits the end of the log."""
        self.judge.counts[f"exit code {code}"] += 1
        if code == 0 and self.judge.ended != "done":
            self.judge.blame("exit code 0 without `done`", self.words[-300:])
        if self.judge.ended == "done" and code not in (0, None):
            self.judge.blame("another exit code after `done`", str(code))

    def check_trace(self) -> None:
        """The robot got only what was in the log, and as often."""
        path = self.folder / "trace.jsonl"
        entries = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
        for entry in entries:
            if "wrong" in entry:
                self.judge.blame("an order that the log does not have", entry["wrong"])
        done = sum("did" in entry for entry in entries)
        if done > len(self.judge.orders):
            self.judge.blame("more orders than in the log", f"{done} of {len(self.judge.orders)}")

    def take_up(self) -> None:
        """Judges the new whole lines of the log."""
        text = self.log.read_text()
        lines = text[: text.rfind("\n") + 1].splitlines()[1:]
        for line in lines[self.read :]:
            self.judge.event(json.loads(line))
        self.read = len(lines)

    def start(self, command: list[str]) -> int | None:
        """Starts the program and perhaps kills it; returns its exit code, none if it was killed."""
        environment = {**os.environ, "PYTHONPATH": str(PEERS), "PYTHONDONTWRITEBYTECODE": "1"}
        process = subprocess.Popen(
            [self.program, *command], stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
            text=True, env=environment, cwd=self.folder,
        )  # fmt: skip
        self.words = ""
        reader = threading.Thread(target=self.listen, args=(process,), daemon=True)
        reader.start()
        kill = self.random.random() < 0.6
        limit = self.random.uniform(0.15, 1.0) if kill else PATIENCE
        try:
            code = process.wait(timeout=limit)
        except subprocess.TimeoutExpired:
            process.send_signal(signal.SIGKILL)
            process.wait()
            code = None
            if kill:
                self.killed += 1
            else:
                self.judge.blame("no end in time", self.words[-300:])
        reader.join(timeout=2)
        # The robot's program ends with its input; its next one must not begin while it still moves.
        time.sleep(0.05)
        return code

    def listen(self, process: subprocess.Popen) -> None:
        """Answers the questions of the program."""
        for line in process.stderr:
            self.words += line
            if line.rstrip().endswith(("[y/n]", "[Enter, or `no`]")):
                answer = self.decide(line)
                try:
                    process.stdin.write("y\n" if answer else "n\n")
                    process.stdin.flush()
                except BrokenPipeError:
                    return

    def decide(self, question: str) -> bool:
        """A person's answer: yes, and the truth about what was done."""
        if "Was it done" not in question:
            return True
        path = self.folder / "trace.jsonl"
        entries = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
        done = [entry for entry in entries if "did" in entry]
        self.judge.answer = len(done) >= len(self.judge.orders) > 0 and done[-1]["done"]
        return self.judge.answer


def campaign(program: Path, seed: int, count: int) -> tuple[dict, list[dict]]:
    """Runs some scenarios; returns counts and what the judge blames."""
    draw = random.Random(seed)
    counts: dict = {"runs": 0, "killed": 0}
    blamed = []
    while counts["runs"] < count:
        own = draw.randrange(10**9)
        with tempfile.TemporaryDirectory() as drawn:
            scenarios = list(Source(own, Path(drawn)).runs())
            if not scenarios:
                continue
            number = draw.randrange(len(scenarios))
            scenario = scenarios[number]
            if draw.random() < 0.9 and plan_faults(scenario.purpose, scenario.steps, scenario.world.initial, strict=False):
                continue
            scenario.person.refuses = scenario.person.leaves = 0
            folder = Path(drawn) / "run"
            folder.mkdir()
            # The robot's program draws the same scenario again, with its domain beside its world.
            run = ProgramRun(program, scenario, own, number, folder)
            judge = run.run()
            counts["runs"] += 1
            counts["killed"] += run.killed
            for name, value in judge.counts.items():
                counts[name] = counts.get(name, 0) + value
            if judge.verdicts:
                log = run.log.read_text().splitlines() if run.log.exists() else []
                blamed.append({"seed": own, "run": number, "verdicts": judge.verdicts, "goal": scenario.goal, "log": log, "words": run.words})
    return counts, blamed
