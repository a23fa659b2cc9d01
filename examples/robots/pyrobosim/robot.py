"""A robot of pyrobosim for Longstep: `longstep run ... --robot "process:examples/robots/pyrobosim/run"`.

The world is pyrobosim's own. With `--environment` the program prints it as an environment file of the domain beside it.
See docs/guide/robots.md.
"""

import argparse
import json
import logging
import os
import queue
import sys
import threading

# What it says about each action is in the results too.
logging.disable(logging.WARNING)

from world import REFUSALS, World  # noqa: E402

# A request that is not understood.
INVALID = -32602


def send(**message):
    sys.stdout.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
    sys.stdout.flush()


class Robot:
    """Answers requests, one after the other; a stop is answered while the robot moves."""

    def __init__(self, world):
        self.world, self.stopped, self.requests = world, threading.Event(), queue.Queue()

    def read(self):
        """Reads requests. A stop, and the end of the connection, cancel the movement at once."""
        for line in sys.stdin:
            try:
                message = json.loads(line)
                request = message["id"], message["method"], message.get("params", {})
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
                # A line that was cut is followed by a stop.
                self.halt()
                continue
            if request[1] == "stop":
                self.halt()
            self.requests.put(request)
        self.halt()
        self.requests.put(None)

    def halt(self):
        self.stopped.set()
        self.world.cancel()

    def serve(self):
        threading.Thread(target=self.read, daemon=True).start()
        while (request := self.requests.get()) is not None:
            id, method, params = request
            if method in ("stop", "shutdown"):
                send(id=id, result={})
                if method == "shutdown":
                    return
            elif not self.stopped.is_set():
                try:
                    getattr(self, f"do_{method}")(id, params)
                except (AttributeError, KeyError, TypeError, ValueError) as error:
                    print(f"{method}: {error}", file=sys.stderr)
                    send(id=id, error={"code": INVALID, "message": str(error)})

    def do_initialize(self, id, params):
        environment = params.get("environment") or {}
        missing = [name for name in environment.get("assets", []) + environment.get("objects", []) if name not in self.world.names]
        if missing:
            raise ValueError(f"the world {self.world.name} has no {', '.join(missing[:5])}; make the environment with --environment")
        send(id=id, result={"protocol": 1, "name": "pyrobosim", "simulated": True, "timeouts": {"perform": 120, "observe": 10, "stop": 5},
                            "capabilities": {"actions": list(self.world.actions), "observe": True}})

    def do_perform(self, id, order):
        send(method="feedback", params={"id": id, "fraction": 0})
        result = self.world.perform(order["action"], order["arguments"])
        if self.stopped.is_set():
            return
        if result.is_success():
            send(id=id, result={})
        else:
            send(id=id, error={"code": REFUSALS[result.status], "message": f"{result.status.name}: {result.message}"})

    def do_observe(self, id, params):
        names = params.get("entities") or list(self.world.names)
        send(id=id, result={"states": {name: self.world.statements(name) for name in names if name in self.world.names}})


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--world", default="test_world.yaml", help="a world file, or the name of one of pyrobosim's own")
    parser.add_argument("--speed", type=float, default=-1, help="seconds of the simulation a second; -1 for as fast as it can")
    parser.add_argument("--seed", type=int, default=0, help="of its random paths, grasps and places; also of where some objects are at first")
    parser.add_argument("--state", metavar="FILE", help="keep the world and the steps performed in this file, and continue in it")
    parser.add_argument("--environment", action="store_true", help="print the world as an environment file, and end")
    options = parser.parse_args()
    try:
        world = World(options)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"error: the world {options.world} cannot be read: {error}")
    if options.environment:
        json.dump(world.environment(), sys.stdout, indent=2)
        print()
        return
    Robot(world).serve()


if __name__ == "__main__":
    main()
    # Threads of the simulator may still run.
    sys.stdout.flush()
    os._exit(0)
