"""The hand in MuJoCo as a hand tracker: a recorder for `longstep teach`, which shows each step of a plan live.

    longstep run plan.json --robot sim --approve never --log run.jsonl
    longstep teach plan.json --recorder "python3 tracker.py run.jsonl"

The log of the simulated run has the environment and the steps with all their arguments. The tracker performs the steps before the one that is to be shown (LONGSTEP_STEP) unseen, then that step at the speed of a person, and
writes the path of the hand as it moves, until Ctrl-C. See docs/guide/robots.md.
"""

import argparse
import json
import os
import sys
import threading
import time

os.environ.setdefault("MUJOCO_GL", "disable")

from hand import Failure, Hand
from record import Recorder
from scene import Scene
from world import World

# The rest before and after a movement, in steps of the simulation.
REST = 100


class Tracker(Recorder):
    """Writes each frame at the time at which it happens."""

    def __init__(self, noise, seed, speed):
        super().__init__("/dev/stdout", noise, seed)
        self.speed, self.begun = speed, None

    def sample(self, world):
        frames = self.frames
        if self.step is not None and self.begun is None:
            self.begun = time.monotonic() - world.data.time / self.speed
            # The frames before the step are not shown.
            self.frames = frames = int(world.data.time * 30) + 1
        super().sample(world)
        if self.frames > frames:
            self.end()
            time.sleep(max(0, self.begun + world.data.time / self.speed - time.monotonic()))


def read(log):
    """The environment of a run, and its orders by the numbers of the steps."""
    environment, orders = None, {}
    with open(log, encoding="utf-8") as file:
        for line in file:
            event = json.loads(line)
            if event.get("event") == "began":
                environment = event["environment"]
            elif event.get("event") == "ordered":
                action, _, arguments = event["call"].rstrip(")").partition("(")
                names = [name.strip() for name in arguments.split(",")]
                orders[event["step"]] = {"action": action, "arguments": names}
    return environment, orders


def show(options):
    environment, orders = read(options.log)
    if environment is None or options.step not in orders:
        sys.exit(f"{options.log} has no step {options.step}; give the log of a run of the plan")
    world = World(Scene(environment))
    hand = Hand(world, threading.Event())
    for step in sorted(orders):
        if step < options.step:
            hand.perform(orders[step])
    world.recorder = Tracker(options.noise, options.seed + options.step, options.speed)
    world.recorder.begin(options.step)
    world.step(REST)
    hand.perform(orders[options.step])
    world.step(REST)
    if options.shown:
        open(options.shown, "w", encoding="utf-8").close()
    while True:
        world.step(REST)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("log", help="the log of a run of the plan")
    parser.add_argument("--step", type=int, default=int(os.environ.get("LONGSTEP_STEP", 1)), help="the step to show")
    parser.add_argument("--noise", type=float, default=0.0, metavar="METRES", help="add noise to the positions")
    parser.add_argument("--seed", type=int, default=1, help="the seed of the noise")
    parser.add_argument("--speed", type=float, default=1.0, metavar="FACTOR", help="faster or slower than a person")
    parser.add_argument("--shown", metavar="FILE", help="write this file when the step is shown")
    try:
        show(parser.parse_args())
    except Failure as error:
        sys.exit(f"the hand cannot do it: {error}")
    except KeyboardInterrupt:
        pass


if __name__ == "__main__":
    main()
