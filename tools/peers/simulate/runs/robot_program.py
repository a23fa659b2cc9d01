"""The robot of a scenario as a program of its own, for runs through `longstep run --robot process:...`.

    python3 -m simulate.runs.robot_program FOLDER SEED NUMBER

FOLDER has the real world (`world.json`), which outlives the program, the log of the run (`run.jsonl`), and `trace.jsonl`, to which the
program appends what it did and what it found wrong: an order that is not the last line of the log.
"""

import json
import os
import random
import sys
import time
from pathlib import Path

from ..numbers import State
from .robot import Died, Robot, action_of
from .scenario import Source


class Program:
    """The robot's program."""

    def __init__(self, folder: Path, seed: int, number: int):
        self.folder = folder
        self.scenario = [own for place, own in enumerate(Source(seed, folder).runs()) if place == number][0]
        scenario = self.scenario
        scenario.faults.steps = {place: kind for place, kind in scenario.faults.steps.items() if kind not in ("times-out", "refuses-step")}
        self.robot = Robot(scenario.world, scenario.entries, scenario.faults, random.Random(seed), set(scenario.reports))
        self.path = folder / "world.json"
        if self.path.exists():
            self.load()

    def load(self) -> None:
        """Takes the world over from the program before."""
        kept = json.loads(self.path.read_text())
        facts = [tuple(fact) for fact in kept["facts"]]
        self.robot.state = State.of(facts, {tuple(key): own for key, own in kept["numbers"]})
        self.robot.orders, self.robot.looks = kept["orders"], kept["looks"]

    def save(self) -> None:
        """Keeps the world."""
        state = self.robot.state
        kept = {
            "facts": sorted(state),
            "numbers": list(state.numbers.items()),
            "orders": self.robot.orders,
            "looks": self.robot.looks,
        }
        temporary = self.path.with_suffix(".new")
        temporary.write_text(json.dumps(kept))
        temporary.rename(self.path)

    def trace(self, **entry) -> None:
        """Notes what happened."""
        with (self.folder / "trace.jsonl").open("a") as file:
            file.write(json.dumps(entry) + "\n")

    def send(self, **message) -> None:
        """Writes a message."""
        sys.stdout.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
        sys.stdout.flush()

    def main(self) -> None:
        """Answers messages until the input ends."""
        for line in sys.stdin:
            message = json.loads(line)
            number, method = message["id"], message["method"]
            if method == "initialize":
                capabilities = {"observe": True, "reports": self.scenario.reports}
                name = f"judged-{os.path.basename(self.folder)}"
                self.send(id=number, result={"protocol": 1, "name": name, "simulated": True, "capabilities": capabilities})
            elif method == "perform":
                self.perform(number, message["params"])
            elif method == "observe":
                self.observe(number)
            else:
                self.send(id=number, result={})

    def perform(self, number: int, order: dict) -> None:
        """Does a step, as far as the faults allow."""
        self.check_log(order)
        action = action_of(self.scenario.world, order)
        before = self.robot.state
        try:
            result, why = self.robot.perform(action)
        except Died:
            self.save()
            self.trace(did=order["action"], arguments=order["arguments"], done=before.key() != self.robot.state.key())
            os._exit(9)
        self.save()
        self.trace(did=order["action"], arguments=order["arguments"], done=result == "done")
        time.sleep(0.03)
        if result == "done":
            self.send(id=number, result={})
        else:
            self.send(id=number, error={"code": 1, "message": why})

    def check_log(self, order: dict) -> None:
        """An order is in the log before the robot gets it."""
        lines = (self.folder / "run.jsonl").read_text().splitlines()
        last = json.loads(lines[-1]) if lines else {}
        call = f"{order['action']}({', '.join(order['arguments'])})"
        if last.get("event") != "ordered" or last.get("call") != call:
            self.trace(wrong=f"{call} is not the last line of the log: {lines[-1:]}")

    def observe(self, number: int) -> None:
        """Looks."""
        try:
            seen = self.robot.look()
        except Died:
            self.save()
            os._exit(9)
        self.save()
        self.send(id=number, result=seen)


if __name__ == "__main__":
    Program(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])).main()
