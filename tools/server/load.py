#!/usr/bin/env python3
"""Measures a server under load, with clients that it has to bear beside it.

    load.py --program target/debug/examples/demo_server [--seconds 60] [--sessions 1000] [--clients 64] [--idle 10000] [--target-ms 50]

Clients visit their sessions in turn: they instruct, look at the session, its plan and its world, accept, approve and run on a simulated
robot, with pauses, and follow the live stream of the session. Beside them are a reader of one byte a second, readers that go away,
bodies of 100 MB, and thousands of idle connections. Exits with 1 if

- a request has another answer than 2xx;
- the stream of a session lacks an event of the stream of everything, whose numbers have no gap, or of the log of a run;
- the idle connections are not bounded, or one is refused without a message; a large body is not refused;
- the memory grows by more than the bound after the warm-up.

Times are printed, and compared with the target; they decide nothing, because other programs share the machine.
"""

import argparse
import asyncio
import json
import os
import random
import resource
import statistics
import sys
import tempfile
import time
from pathlib import Path

from connection import Connection, Refused, Stream
from guests import idle_connections, large_body, leaving_readers, slow_reader
from served import Server

INSTRUCTIONS = ["Put the juice on top of the shelf", "Put the cereal on the counter", "Put the butter on the counter"]
MODEL_CALLS = ("instruct", "feedback")
# The pause of a client between two calls, in seconds: 64 clients make some hundred calls a second.
PAUSE = (0.05, 0.25)
# The bound on connections in src/http/serve.rs.
CONNECTIONS = 1024
# The seconds in which sessions, events and runs reach their bounds in memory, twice.
WARM_UP = 60
# Growth of the memory after the warm-up, in KiB for each run: its record, and the accepted plan in its session.
GROWTH = 16
# The allocator of glibc has an arena for each of many threads otherwise, whose free parts look like growth for minutes.
VARIABLES = {"MALLOC_ARENA_MAX": "2"}


class Load:
    """The state that all clients share."""

    def __init__(self, server, until):
        self.server, self.until = server, until
        self.measures, self.errors, self.wrong = {}, [], []
        self.recorded, self.newest, self.boot = {}, 0, ""
        self.visits, self.runs, self.memory = [], {}, []

    async def record(self):
        """Reads the stream of everything: the numbers have no gap."""
        stream = await Stream(self.server, "").open()
        while True:
            name, kind, data = await stream.next()
            self.boot, number = name.rsplit("-", 1)[0], int(name.rsplit("-", 1)[1])
            if kind != "happened" or (self.newest and number != self.newest + 1):
                self.wrong.append(f"the stream of everything: {kind} {number} after {self.newest}")
            self.newest = number
            self.recorded[number] = json.loads(data)

    async def sample(self):
        """Samples the memory of the server every second."""
        while True:
            self.memory.append((time.monotonic(), self.server.resident_kib()))
            await asyncio.sleep(1)


class Visit:
    """The events of a session while a client visits it."""

    def __init__(self, load, session):
        self.load, self.session, self.began = load, session, load.newest
        self.events, self.stream, self.task = [], None, None

    async def follow(self):
        """Opens the stream, or opens it again after the last event."""
        last = self.events[-1][0] if self.events else self.began
        self.stream = await Stream(self.load.server, f"?session={self.session}&after={self.load.boot}-{last}").open()
        self.task = asyncio.create_task(self.read())

    async def read(self):
        while True:
            name, kind, data = await self.stream.next()
            if kind != "happened":
                self.load.wrong.append(f"session {self.session}: {kind}")
            self.events.append((int(name.rsplit("-", 1)[1]), json.loads(data)))

    def leave(self):
        """Closes the stream."""
        self.task.cancel()
        self.stream.close()

    async def seen(self, run):
        """Waits for the event that a run has ended."""
        for _ in range(3000):
            if any(data.get("run") == run and data["state"] in ("done", "stopped") for _, data in self.events):
                return
            await asyncio.sleep(0.01)
        self.load.wrong.append(f"run {run}: its end is not on the stream of its session")


class Client:
    """A client with sessions of its own."""

    def __init__(self, load, number, sessions):
        self.load, self.random, self.count = load, random.Random(number), sessions
        self.connection = Connection(load.server, load.measures)
        self.sessions = []

    async def call(self, kind, method, path, body=None):
        """Makes a call, after a pause."""
        await asyncio.sleep(self.random.uniform(*PAUSE))
        return await self.connection.call(kind, method, path, body)

    async def begin(self):
        """Begins the sessions."""
        for _ in range(self.count):
            session = await self.call("create", "POST", "/api/sessions", {"scene": "pantry"})
            self.sessions.append(session["id"])

    async def work(self):
        """Visits the sessions until the time is over."""
        number = 0
        while time.monotonic() < self.load.until:
            try:
                await self.visit(self.sessions[number % len(self.sessions)])
            except (Refused, OSError, asyncio.IncompleteReadError) as error:
                self.load.errors.append(f"{type(error).__name__} {error}")
                self.connection.close()
            number += 1

    async def visit(self, session):
        """Follows a session, and has a plan carried out in it."""
        visit, path = Visit(self.load, session), f"/api/sessions/{session}"
        await visit.follow()
        try:
            await self.call("look", "GET", path)
            view = await self.call("instruct", "POST", f"{path}/instruct", {"text": self.random.choice(INSTRUCTIONS)})
            if self.random.random() < 0.2:
                view = await self.call("feedback", "POST", f"{path}/feedback", {"text": "the cereal instead"})
            await self.call("look", "GET", path)
            await self.call("world", "GET", f"{path}/world")
            if self.random.random() < 0.2:
                visit.leave()
                await visit.follow()
            plan = view["proposal"]["plan"]
            await self.call("accept", "POST", f"{path}/accept", {"plan": plan})
            approval = await self.call("approve", "POST", f"{path}/approve", {"plan": plan, "robot": "quick"})
            run = await self.call("run", "POST", "/api/runs", {"approval": approval["id"]})
            while run["state"] not in ("done", "stopped"):
                run = await self.call("look at the run", "GET", f"/api/runs/{run['id']}")
            await visit.seen(run["id"])
            self.load.runs[run["id"]] = run["events"]
            self.load.visits.append(visit)
            if self.random.random() < 0.1:
                await self.call("list", "GET", self.random.choice(["/api/runs", "/api/sessions", "/api/audit", "/api/server"]))
        finally:
            visit.leave()


async def guests(load, until, idle):
    """Brings the clients that are hard to bear, so many idle connections among them, and checks how they are served."""
    server = load.server
    readers = [asyncio.create_task(slow_reader(server, until)), asyncio.create_task(leaving_readers(server, until))]
    bodies = [await large_body(server) for _ in range(3)]
    # Less than the 15 s after which the server ends a connection without a request.
    found = await idle_connections(server, idle, 3)
    slow, left = await asyncio.gather(*readers)
    print(f"a slow reader got {slow} bytes, {left} readers went away")
    for status, sent, seconds in bodies:
        print(f"a body of 100 MB: {status} after {sent >> 10} KiB and {seconds * 1000:.0f} ms")
        if status != 413:
            load.wrong.append(f"a body of 100 MB: {status}")
    print(f"{idle} idle connections: {found}")
    if found["held"] > CONNECTIONS or found["closed"] or found["held"] + found["refused"] != idle:
        load.wrong.append(f"idle connections: {found}")


def check_events(load, folder):
    """Compares the streams of the visits with the stream of everything, and with the logs of the runs."""
    of_session = {}
    for number, data in sorted(load.recorded.items()):
        of_session.setdefault(data["session"], []).append((number, data))
    count = 0
    for visit in load.visits:
        last = visit.events[-1][0]
        expected = [event for event in of_session[visit.session] if visit.began < event[0] <= last]
        count += len(expected)
        if visit.events != expected:
            load.wrong.append(f"session {visit.session}: {len(visit.events)} events instead of {len(expected)}")
    in_stream = {}
    for data in load.recorded.values():
        if "run" in data:
            in_stream[data["run"]] = max(in_stream.get(data["run"], 0), data["event"])
    for run, events in load.runs.items():
        lines = (folder / "runs" / f"{run}.jsonl").read_bytes().count(b"\n") - 1
        if not lines == events == in_stream.get(run):
            load.wrong.append(f"run {run}: {lines} events in the log, {events} shown, {in_stream.get(run)} on the stream")
    print(f"{count} events of {len(load.visits)} visits and {len(load.runs)} runs compared, {load.newest} events in all")


def percentile(values, share):
    """Returns the value below which a share of sorted values is."""
    return values[min(len(values) - 1, int(len(values) * share))]


def report_times(load, seconds, target):
    """Prints the times of calls by kind, and of all that wait for no model."""
    rows = dict(sorted(load.measures.items()))
    rows["all without a model"] = [time for kind, times in load.measures.items() if kind not in MODEL_CALLS for time in times]
    print(f"{'ms':22} {'calls':>7} {'p50':>7} {'p90':>7} {'p99':>7} {'max':>7}")
    for kind, times in rows.items():
        times.sort()
        shares = [percentile(times, share) * 1000 for share in (0.5, 0.9, 0.99)]
        print(f"{kind:22} {len(times):7}" + "".join(f" {value:7.1f}" for value in [*shares, times[-1] * 1000]))
    print(f"{load.server.processor_seconds():.0f} s of processor time in the server, {time.process_time():.0f} s in the clients")
    total = sum(len(times) for kind, times in load.measures.items())
    p99 = percentile(rows["all without a model"], 0.99) * 1000
    print(f"{total / seconds:.0f} calls a second; p99 is {'below' if p99 < target else 'above'} the target of {target} ms")
    print("load average of the machine:", " ".join(f"{value:.1f}" for value in os.getloadavg()))


def report_memory(load, seconds):
    """Prints the memory over time, and compares its growth after the warm-up with the bound."""
    begin = load.memory[0][0]
    late = [(at - begin, kib) for at, kib in load.memory if at - begin >= seconds / 2]
    tenth = max(1, len(load.memory) // 10)
    print("memory in MiB:", " ".join(f"{kib / 1024:.0f}" for _, kib in load.memory[::tenth]))
    if seconds < WARM_UP:
        print(f"the growth of the memory is measured in {WARM_UP} s or more")
        return
    slope = statistics.linear_regression(*zip(*late, strict=True)).slope
    of_run = slope * seconds / len(load.runs)
    print(f"growth after {seconds / 2:.0f} s: {slope:.0f} KiB a second, {of_run:.1f} KiB a run")
    if of_run > GROWTH:
        load.wrong.append(f"the memory grows by {of_run:.1f} KiB a run")


async def run_load(server, own):
    """Runs the clients and the guests. Returns what was measured."""
    load = Load(server, time.monotonic() + own.seconds)
    background = [asyncio.create_task(load.record()), asyncio.create_task(load.sample())]
    # The first event tells the name of the stream.
    await Connection(server, {}).call("create", "POST", "/api/sessions", {"scene": "pantry"})
    while not load.boot:
        await asyncio.sleep(0.01)
    share = [own.sessions // own.clients + (number < own.sessions % own.clients) for number in range(own.clients)]
    clients = [Client(load, number, sessions) for number, sessions in enumerate(share)]
    # The connections of the clients are there, with requests on them, before others flood the server.
    await asyncio.gather(*(client.begin() for client in clients))
    load.until = time.monotonic() + own.seconds
    await asyncio.gather(guests(load, load.until - own.seconds / 3, own.idle), *(client.work() for client in clients))
    await asyncio.sleep(0.5)
    for task in background:
        task.cancel()
        if task.done() and not task.cancelled() and task.exception():
            load.wrong.append(f"a reader failed: {task.exception()!r}")
    return load


def main():
    """Runs the load, and reports."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--sessions", type=int, default=1000)
    parser.add_argument("--clients", type=int, default=64)
    parser.add_argument("--idle", type=int, default=10_000)
    parser.add_argument("--target-ms", type=float, default=50)
    own = parser.parse_args()
    # The server gets the usual soft limit of open files.
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (1024, hard))
    with tempfile.TemporaryDirectory() as name, Server(own.program, name, 60, VARIABLES) as server:
        load = asyncio.run(run_load(server, own))
        report_times(load, own.seconds, own.target_ms)
        report_memory(load, own.seconds)
        check_events(load, Path(name))
    for line in load.errors[:5] + load.wrong[:15]:
        print("WRONG", line[:400])
    print(f"{len(load.errors)} errors, {len(load.wrong)} wrong")
    sys.exit(1 if load.errors or load.wrong else 0)


if __name__ == "__main__":
    main()
