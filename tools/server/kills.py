#!/usr/bin/env python3
"""Kills a server at random moments, starts it again on its files, and checks that it lost nothing that it had answered.

    kills.py --program target/debug/examples/demo_server [--kills 200] [--seed 1]

Three people at once instruct, answer, revise, accept, undo, approve and begin runs on simulated robots until the server gets SIGKILL. It
starts again on the same folder, and then has to hold:

- each session has the accepted plans and the proposal of its last answer; of a request without an answer, all or nothing;
- an approval that was given and not used still begins a run, and none has begun two;
- each run that was begun is there: with the end that its log has, or interrupted, and is then resumed to its end;
- no step is performed again without a reason in the log of its run: a failure, a difference in the world, a change;
- the logs of sessions, runs and the audit can be read line by line.

Exits with 1 if something does not hold.
"""

import argparse
import collections
import http.client
import json
import random
import sys
import tempfile
import threading
import time
from pathlib import Path

from served import Server, until

PEOPLE = 3
INSTRUCTIONS = [
    "Put the juice on top of the shelf", "Put the cereal on the counter", "Put the butter on the counter", "Bring the drink",
]
ENDED = ("done", "stopped", "interrupted")
# Events that are a reason to perform a step again.
REASONS = ("assessed", "changed", "failed")


class Dead(Exception):
    """The server did not answer."""


class Person(threading.Thread):
    """A person with one session: what was asked, and what was answered."""

    def __init__(self, server, seed):
        super().__init__(daemon=True)
        self.server, self.random = server, random.Random(seed)
        self.view, self.in_flight = None, None
        self.approvals, self.runs, self.used = [], {}, set()
        self.wrong, self.requests = [], 0

    def ask(self, method, path, body=None):
        """Returns the data of an answer of the kind 2xx, or none; raises at the end of the server."""
        self.in_flight = (path.rsplit("/", 1)[1], body)
        try:
            status, data = self.server.request(method, path, body)
        except (OSError, http.client.HTTPException, json.JSONDecodeError):
            raise Dead from None
        self.in_flight = None
        self.requests += 1
        if status >= 500:
            self.wrong.append(f"{method} {path}: {status} {data}")
        return data if 200 <= status < 300 else None

    def tell(self, path, body=None):
        """Changes the session, and keeps how it is now."""
        view = self.ask("POST", f"/api/sessions/{self.view['id']}/{path}", body)
        self.view = view or self.view
        return view

    def run(self):
        try:
            self.view = self.ask("POST", "/api/sessions", {"scene": "pantry"})
            while self.view:
                self.act()
        except Dead:
            pass

    def act(self):
        """Does the next that a person would do."""
        state = self.view["state"]
        if state == "question":
            self.tell("answer", {"text": "put the juice on top of the shelf"})
        elif state == "plan" and self.random.random() < 0.2:
            self.tell("feedback", {"text": "the cereal instead"})
        elif state == "plan" and self.random.random() < 0.9:
            if self.tell("accept", {"plan": self.view["proposal"]["plan"]}) and self.random.random() < 0.8:
                self.carry_out()
        elif state in ("plan", "no_plan"):
            self.tell("cancel")
        elif self.view["accepted"] and self.random.random() < 0.25:
            self.tell("undo")
        else:
            self.tell("instruct", {"text": self.random.choice(INSTRUCTIONS)})

    def carry_out(self):
        """Approves the next plan, and begins a run."""
        plan = next((own["plan"] for own in self.view["accepted"] if own["pending"]), None)
        body = {"plan": plan, "robot": self.random.choice(["brisk", "brisk", "quick", "clumsy"])}
        approval = plan and self.ask("POST", f"/api/sessions/{self.view['id']}/approve", body)
        if not approval:
            return
        self.approvals.append(approval)
        self.begin(approval)
        if self.random.random() < 0.1:
            # Twice, by mistake.
            self.begin(approval)

    def begin(self, approval):
        """Begins a run with an approval, and looks at it for a while or to its end."""
        self.used.add(approval["id"])
        run = self.ask("POST", "/api/runs", {"approval": approval["id"]})
        if not run:
            return
        self.runs[run["id"]] = run
        is_patient = self.random.random() < 0.7
        while self.runs[run["id"]]["state"] not in ENDED and is_patient:
            time.sleep(0.01)
            self.look(run["id"])

    def look(self, run):
        """Looks at a run, and answers what it asks."""
        self.runs[run] = self.ask("GET", f"/api/runs/{run}") or self.runs[run]
        question = self.runs[run]["question"]
        if question:
            self.ask("POST", f"/api/runs/{run}/decide", {"question": question["id"], "yes": True})


def plans(view):
    """Returns the hashes of the accepted plans."""
    return [own["plan"] for own in view["accepted"]]


def expected_plans(person):
    """Returns the lists of accepted plans that a session may have: with and without the request that was not answered."""
    known = plans(person.view)
    kind, body = person.in_flight or (None, None)
    lists = [known]
    if kind == "accept":
        lists.append([*known, body["plan"]])
    if kind == "undo":
        lists.append(known[:-1])
    return lists


def check_session(server, person):
    """Compares the session with the last answer about it. Returns what is wrong."""
    path = f"/api/sessions/{person.view['id']}"
    view = until(lambda: (own := server.get(path))["state"] != "thinking" and own)
    wrong = []
    if plans(view) not in expected_plans(person):
        wrong.append(f"{path}: the plans {plans(view)} instead of {expected_plans(person)}")
    shown = [(own["state"], own["question"], own["proposal"] and own["proposal"]["plan"]) for own in (view, person.view)]
    is_talking = person.in_flight and person.in_flight[0] not in ("approve", "runs", "decide", *person.runs)
    if not is_talking and shown[0] != shown[1]:
        wrong.append(f"{path}: {shown[0]} instead of {shown[1]}")
    person.view = view
    return wrong


def check_approvals(server, person):
    """Uses the approval that was not used. Returns what is wrong."""
    fresh = [own for own in person.approvals if own["id"] not in person.used]
    next_plan = next((own["plan"] for own in person.view["accepted"] if own["pending"]), None)
    if not fresh or fresh[-1]["plan"] != next_plan or any(run["state"] not in ENDED for run in person.runs.values()):
        return []
    status, run = server.request("POST", "/api/runs", {"approval": fresh[-1]["id"]})
    if status == 201:
        person.runs[run["id"]] = run
        return []
    return [f"the approval {fresh[-1]['id']} begins no run: {status} {run}"]


def events_of(folder, run):
    """Returns the events of the log of a run; every line but a last one that was cut off is JSON."""
    path = folder / "runs" / f"{run}.jsonl"
    lines = path.read_text(encoding="utf-8").split("\n")[:-1] if path.exists() else []
    return [json.loads(line) for line in lines][1:]


def check_run(server, folder, run):
    """Compares the state of a run with its log, and takes it up if it was interrupted. Returns what is wrong, and a word."""
    status, view = server.request("GET", f"/api/runs/{run}")
    if status != 200:
        return [f"run {run}: {status} {view}"], "lost"
    events = events_of(folder, run)
    last = events[-1]["event"] if events else "none"
    state = {"done": "done", "stopped": "stopped", "none": "stopped"}.get(last, "interrupted")
    if view["state"] != state:
        return [f"run {run}: {view['state']} ({view['end']}), and its log ends with {last}"], "wrong"
    if state != "interrupted":
        return [], state
    status, resumed = server.request("POST", f"/api/runs/{run}/resume")
    if status != 200:
        return [f"run {run} is not resumed: {status} {resumed}"], "wrong"
    end = until(lambda: end_of(server, run))
    if end["state"] == "done" or end["end"]["text"]:
        return [], f"resumed, then {end['state']}"
    return [f"run {run}: resumed to {end['state']} without a reason"], "wrong"


def end_of(server, run):
    """Answers the question of a run; returns it if it has ended."""
    view = server.get(f"/api/runs/{run}")
    if view["question"]:
        server.request("POST", f"/api/runs/{run}/decide", {"question": view["question"]["id"], "yes": True})
    return view if view["state"] in ENDED else None


def check_steps(folder, run):
    """Returns the steps that were ordered again without a reason, or during a pause."""
    wrong, done, calls, is_paused = [], set(), {}, False
    for event in events_of(folder, run):
        kind = event["event"]
        if kind in REASONS:
            done.clear()
        is_paused = kind == "paused" or (is_paused and kind != "continued")
        if kind == "ordered":
            # A plan may have the same call at two of its steps.
            step = calls[event["order"]] = (event["step"], event["call"])
            if is_paused or step in done:
                wrong.append(f"run {run}: step {step} again, or during a pause")
        if kind == "performed":
            done.add(calls[event["order"]])
    return wrong


def check_audit(folder):
    """Reads the audit log. Returns what is wrong, and the number of runs that were begun."""
    lines = (folder / "server" / "audit.jsonl").read_text(encoding="utf-8").split("\n")
    started = [entry for entry in map(json.loads, lines[:-1]) if entry["deed"] == "started"]
    wrong = ["the audit log ends within a line"] if lines[-1] else []
    for what in ("approval", "run"):
        for name, count in collections.Counter(entry[what] for entry in started).items():
            if count > 1:
                wrong.append(f"the {what} {name} began {count} runs")
    begun = {entry["run"] for entry in started}
    for path in (folder / "runs").glob("*.jsonl"):
        # An empty one is that of a run for which no approval was used before the end of the server.
        if path.stat().st_size and path.stem not in begun:
            wrong.append(f"the run {path.stem} has a log and no approval")
    return wrong, len(started)


def check_logs(folder):
    """Reads the logs of all sessions, line by line. Returns what is wrong."""
    wrong = []
    for path in (folder / "sessions").glob("*/session.jsonl"):
        for number, line in enumerate(path.read_text(encoding="utf-8").split("\n")[:-1]):
            try:
                json.loads(line)
            except json.JSONDecodeError as error:
                wrong.append(f"{path}:{number + 1}: {error}")
    return wrong


def kill_while_used(server, people, rng):
    """Lets people use the server, and kills it: after a random time, or a moment after a random request."""
    for person in people:
        person.start()
    if rng.random() < 0.4:
        time.sleep(rng.uniform(0.0, 1.2))
    else:
        count = rng.randrange(1, 60)
        end = time.monotonic() + 3
        while sum(person.requests for person in people) < count and time.monotonic() < end:
            time.sleep(0.0005)
        time.sleep(rng.expovariate(500))
    server.kill()
    for person in people:
        person.join()


def one_round(server, folder, seed, counts):
    """Kills the server once, starts it again, and checks everything. Returns what is wrong, and the people."""
    rng = random.Random(seed)
    people = [Person(server, f"{seed} {number}") for number in range(PEOPLE)]
    kill_while_used(server, people, rng)
    wrong = [line for person in people for line in person.wrong]
    for person in people:
        counts[f"in flight: {person.in_flight[0] if person.in_flight and len(person.in_flight[0]) < 32 else 'look'}"] += 1
    server.start()
    for person in (own for own in people if own.view):
        wrong += check_session(server, person)
        for run in list(person.runs):
            found, word = check_run(server, folder, run)
            wrong += found
            counts[f"run: {word}"] += 1
            person.runs[run] = server.get(f"/api/runs/{run}") if word != "lost" else person.runs[run]
        person.view = server.get(f"/api/sessions/{person.view['id']}")
        wrong += check_approvals(server, person)
        for run in person.runs:
            until(lambda own=run: end_of(server, own))
            wrong += check_steps(folder, run)
    return wrong, people


def main():
    """Runs the rounds, and reads everything again at the end."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    own = parser.parse_args()
    counts, wrong, everyone = collections.Counter(), [], []
    with tempfile.TemporaryDirectory() as name, Server(own.program, name, minutes=60) as server:
        folder = Path(name)
        for number in range(own.kills):
            found, people = one_round(server, folder, f"{own.seed} {number}", counts)
            wrong += [f"kill {number}: {line}" for line in found]
            everyone += [person for person in people if person.view]
        for person in everyone:
            path = f"/api/sessions/{person.view['id']}"
            if plans(server.get(path)) != plans(person.view):
                wrong.append(f"{path}: other plans at the end")
        server.kill()
        found, started = check_audit(folder)
        wrong += found + check_logs(folder)
        server.start()
    for what, count in sorted(counts.items()):
        print(f"{count:6} {what}")
    for line in wrong[:20]:
        print("WRONG", line[:600])
    requests = sum(person.requests for person in everyone)
    print(f"{own.kills} kills, {len(everyone)} sessions, {requests} requests, {started} runs, {len(wrong)} wrong")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
