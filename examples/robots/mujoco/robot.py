"""A floating hand in MuJoCo, as a robot for Longstep: `longstep run ... --robot "process:python3 robot.py"`.

Builds its scene from the environment that Longstep sends (or from --env), performs the actions of the household domain, and
reports what it measures. See docs/guide/robots.md.
"""

import argparse
import json
import os
import queue
import sys
import threading

# MuJoCo opens its GL when it is imported. Without pictures it needs none.
os.environ.setdefault("MUJOCO_GL", "egl" if "--pictures" in sys.argv else "disable")

from hand import ACTIONS, Failure, Hand, Stopped
from record import Recorder
from scene import Scene
from world import World

# The code of a step that could not be done, and of a request that is not understood.
FAILED, INVALID = 1, -32602


def send(**message):
    sys.stdout.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
    sys.stdout.flush()


def read(messages, stopped):
    """Reads requests while the hand moves. A stop, and the end of the connection, end the movement at once."""
    for line in sys.stdin:
        try:
            message = json.loads(line)
            request = message["id"], message["method"], message.get("params", {})
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
            # A line that was cut is followed by a stop.
            stopped.set()
            continue
        if request[1] == "stop":
            stopped.set()
        messages.put(request)
    stopped.set()
    messages.put(None)


class Robot:
    """Answers requests, one after the other."""

    def __init__(self, options):
        self.options, self.stopped = options, threading.Event()
        self.world = self.hand = self.strip = None

    def initialize(self, id, params):
        environment = params.get("environment")
        if self.options.env:
            with open(self.options.env, encoding="utf-8") as file:
                environment = json.load(file)
                environment = environment.get("environment", environment)
        if environment is None:
            raise ValueError("there is no environment: give one with --env")
        self.world = World(Scene(environment))
        self.hand = Hand(self.world, self.stopped)
        if self.options.record:
            self.world.recorder = Recorder(self.options.record, self.options.noise, self.options.seed)
        if self.options.pictures:
            from pictures import Strip
            self.strip = Strip(self.world, self.options.pictures)
            self.strip.add("the beginning")
        send(id=id, result={"protocol": 1, "name": "mujoco hand", "simulated": True, "timeouts": {"perform": 60, "observe": 10, "stop": 5},
                            "capabilities": {"actions": list(ACTIONS), "observe": True, "reports": ["hand-at", "lifted"]}})

    def perform(self, id, order):
        failure, recorder = None, self.world.recorder
        if recorder:
            recorder.begin(order["step"])
        slips = self.options.slip == order["step"]
        if slips:
            self.options.slip = None
            self.hand.slip_from = self.world.hand()
        try:
            self.hand.perform(order)
        except Failure as error:
            failure = str(error)
        if slips:
            # A step that was too short for it slips at its end. What fell comes to rest before it is measured.
            if self.hand.slip_from is not None:
                self.hand.slip()
            self.hand.settle()
        if recorder:
            recorder.end()
        if self.strip:
            self.strip.add(f"{order['step']} {order['action']} {' '.join(order['arguments'])}")
        send(method="feedback", params={"id": id, "fraction": 1, "data": {"facts": self.facts(), "time": self.world.data.time}})
        if failure is None:
            send(id=id, result={})
        else:
            send(id=id, error={"code": FAILED, "message": failure})

    def observe(self, id, params):
        scene = self.world.scene
        names = params.get("entities") or scene.objects
        send(id=id, result={"states": {name: self.world.statements(name) for name in names if name in scene.objects},
                            "facts": [f"hand-at({name})" for name in self.hand.is_at()]
                            + [f"lifted({name})" for name in self.hand.has_lifted()]})

    def facts(self):
        """Measured facts that environments have no words for, events included."""
        facts = [f"(hand-at {name})" for name in self.world.hand_is_at()]
        facts += [f"(lifted {name})" for name in self.hand.has_lifted()]
        facts += [f"(wiped {place} {tool})" for place, tool in sorted(self.hand.wiped)]
        return facts + [f"(adjusted {name})" for name in sorted(self.hand.adjusted)]

    def serve(self):
        messages = queue.Queue()
        threading.Thread(target=read, args=(messages, self.stopped), daemon=True).start()
        while (request := messages.get()) is not None:
            id, method, params = request
            if method == "stop":
                send(id=id, result={})
            elif method == "shutdown":
                if self.strip:
                    self.strip.save()
                send(id=id, result={})
                return
            elif not self.stopped.is_set():
                self.answer(id, method, params)

    def answer(self, id, method, params):
        try:
            {"initialize": self.initialize, "perform": self.perform, "observe": self.observe}[method](id, params)
        except Stopped:
            return
        except (ValueError, KeyError, OSError) as error:
            print(f"{method}: {error}", file=sys.stderr)
            send(id=id, error={"code": INVALID, "message": str(error)})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--env", help="environment file, in place of the one that Longstep sends")
    parser.add_argument("--slip", type=int, metavar="STEP", help="let go of what is held during this step, once")
    parser.add_argument("--pictures", metavar="FILE.png", help="write a strip with a picture after each step")
    parser.add_argument("--record", metavar="FILE.csv", help="record the path of the hand, for `longstep teach`")
    parser.add_argument("--noise", type=float, default=0.0, metavar="METRES", help="add noise to the recorded positions")
    parser.add_argument("--seed", type=int, default=1, help="the seed of the noise")
    Robot(parser.parse_args()).serve()


if __name__ == "__main__":
    main()
