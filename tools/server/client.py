#!/usr/bin/env python3
"""Makes calls to a server with a client that is generated from its OpenAPI description.

    tools/server/client.sh target/debug/examples/demo_server

Starts the server, generates a client from its `/openapi.json` with openapi-python-client, and goes through a scenario with the typed
functions and models of that client. Exits with 1 if the generator warns, if an answer is not of the described type, if a field of an
answer is lost or added by the types, or if a call has another result than expected.
"""

import argparse
import importlib
import json
import pkgutil
import subprocess
import sys
import tempfile
import urllib.request
from pathlib import Path

from served import Server, until

# Times lose their nanoseconds in the types of Python.
TIMES = ("at", "expires")


def generated(server, folder):
    """Generates the client into a folder, and imports it."""
    request = urllib.request.Request(f"{server.address}/openapi.json", headers=server.headers())
    description = Path(folder) / "openapi.json"
    with urllib.request.urlopen(request) as answer:
        description.write_bytes(answer.read())
    command = ["openapi-python-client", "generate", "--path", str(description), "--output-path", str(Path(folder) / "generated")]
    run = subprocess.run([*command, "--meta", "none", "--fail-on-warning"], capture_output=True, text=True, check=False)
    if run.returncode != 0 or "arning" in run.stdout + run.stderr:
        sys.exit(f"error: the generator is not content\n{run.stdout}{run.stderr}")
    sys.path.insert(0, str(folder))
    return importlib.import_module("generated")


def without_times(data):
    """Returns data without its times."""
    if isinstance(data, dict):
        return {key: without_times(value) for key, value in data.items() if key not in TIMES}
    if isinstance(data, list):
        return [without_times(value) for value in data]
    return data


# The bytes at both ends of an MCAP file.
MCAP = b"\x89MCAP0\r\n"


class Caller:
    """The functions of a generated client by name; each answer is compared with its type."""

    def __init__(self, package, server):
        self.models = importlib.import_module("generated.models")
        self.client = package.AuthenticatedClient(base_url=server.address, token=server.token, headers={"Longstep-User": "ada"})
        self.functions, self.calls, self.called = {}, 0, set()
        api = importlib.import_module("generated.api")
        for module in pkgutil.walk_packages(api.__path__, "generated.api."):
            if not module.ispkg:
                self.functions[module.name.rsplit(".", 1)[1]] = importlib.import_module(module.name)

    def file(self, name, *arguments):
        """Calls an operation whose answer is a file; returns its bytes."""
        self.calls += 1
        self.called.add(name)
        answer = self.functions[name].sync_detailed(*arguments, client=self.client)
        if answer.status_code != 200:
            raise AssertionError(f"{name}: {int(answer.status_code)}: {answer.content!r}")
        return answer.parsed.payload.read()

    def __call__(self, name, *arguments, status=200, **named):
        """Calls an operation; returns the typed answer."""
        self.calls += 1
        self.called.add(name)
        answer = self.functions[name].sync_detailed(*arguments, client=self.client, **named)
        if answer.status_code != status:
            raise AssertionError(f"{name}: {int(answer.status_code)} instead of {status}: {answer.content!r}")
        is_error = isinstance(answer.parsed, self.models.Error)
        if is_error != (status >= 400):
            raise AssertionError(f"{name}: an answer of the type {type(answer.parsed).__name__}")
        typed, raw = without_times(answer.parsed.to_dict()), without_times(json.loads(answer.content))
        if typed != raw:
            raise AssertionError(f"{name}: the types make {typed} of {raw}")
        return answer.parsed


def equal(what, found, expected):
    """Raises unless two values are the same."""
    if found != expected:
        raise AssertionError(f"{what}: {found!r} instead of {expected!r}")


def ask_the_model(call):
    """Describes the model, lets it answer a request as it is, and counts tokens."""
    models = call.models
    lent = call("get_model")
    equal("the model", (lent.name, lent.version), ("scripted", 1))
    message = models.ChatMessage(role=models.ChatRole.USER, text="Put the butter on the counter")
    request = models.ChatRequest(messages=[message], answer_so_far="", constraint="free", max_tokens=100)
    reply = call("chat", body=models.ChatCall(request=request))
    equal("the goal of the reply", json.loads(reply.text)["goal"], "put(butter, counter)")
    counted = call("count_tokens", body=models.CountCall(messages=[message, message]))
    equal("the counts", (len(counted.tokens), counted.frame), (2, 0))


def is_a(value, kind):
    """Raises unless a value has a type of the client, and returns it."""
    if not isinstance(value, kind):
        raise AssertionError(f"a value of the type {type(value).__name__} instead of {kind.__name__}: {value!r}")
    return value


def plan_and_talk(call):
    """Begins a session, talks about plans, and accepts one. Returns the session."""
    models = call.models
    server = call("server")
    equal("the scenes", [scene.name for scene in server.scenes], ["pantry", "kitchen"])
    is_a(server.model, models.Model)
    session = call("create_session", body=models.Place(scene="pantry"), status=201)
    equal("the state", session.state, models.SessionState.READY)
    asked = call("instruct", session.id, body=models.Words(text="Bring the drink"))
    equal("the question", (asked.state, asked.question), (models.SessionState.QUESTION, "Which drink?"))
    told = call("answer", session.id, body=models.Words(text="put the juice on top of the shelf"))
    first = is_a(told.proposal, models.Proposal)
    equal("the goal", first.answer.goal, ["put(<juice>, <shelf_top>)"])
    is_a(first.answer.steps[0], models.Step)
    is_a(first.answer.search, models.Search)
    revised = call("feedback", session.id, body=models.Words(text="the cereal instead"))
    second = is_a(revised.proposal, models.Proposal)
    equal("another plan", second.plan != first.plan, True)
    stale = call("accept", session.id, body=models.PlanHash(plan=first.plan), status=409)
    equal("the kind of the problem", stale.error.kind, models.ProblemKind.CONFLICT)
    accepted = call("accept", session.id, body=models.PlanHash(plan=second.plan))
    equal("the accepted plan", [(own.plan, own.pending) for own in accepted.accepted], [(second.plan, True)])
    world = call("get_world", session.id)
    equal("the world", world.object_states["<cereal>"], "on_something(<counter>)")
    undone = call("undo", session.id)
    equal("no plan after the undo", undone.accepted, [])
    return session.id


def plan_without_a_session(call):
    """Solves, verifies and repairs plans, and plans for one instruction."""
    models = call.models
    place = models.Place(scene="pantry")
    solved = call("solve", body=models.GoalRequest(place=place, goal="put(butter, counter)"))
    equal("the status", solved.status, models.AnswerStatus.VERIFIED)
    plan = is_a(solved.plan, models.PlanFile)
    verified = call("verify", body=models.WrittenPlan(place=place, plan=plan, goal="put(butter, counter)"))
    equal("the status", verified.status, models.AnswerStatus.VERIFIED)
    broken = models.PlanFile.from_dict(plan.to_dict())
    dropped = broken["task_cohesion"]["task_sequence"].pop(0)
    invalid = call("verify", body=models.WrittenPlan(place=place, plan=broken))
    equal("the status", invalid.status, models.AnswerStatus.INVALID)
    is_a(invalid.violations[0], models.Violation)
    repaired = call("repair", body=models.WrittenPlan(place=place, plan=broken))
    equal("the status", repaired.status, models.AnswerStatus.VERIFIED)
    equal("the edit", (repaired.edits[0].kind, repaired.edits[0].after.split("(")[0]), (models.EditKind.INSERT, dropped.split("(")[0]))
    planned = call("plan", body=models.Instruction(place=place, instruction="Put the butter on the counter"))
    equal("the goal", planned.goal, solved.goal)
    unknown = call("solve", body=models.GoalRequest(place=models.Place(scene="moon"), goal="x"), status=404)
    equal("the kind of the problem", unknown.error.kind, models.ProblemKind.MISSING)


def begin_run(call, session, text, robot):
    """Makes a plan, accepts and approves it, and begins a run. Returns the approval and the run."""
    models = call.models
    told = call("instruct", session, body=models.Words(text=text))
    plan = is_a(told.proposal, models.Proposal).plan
    call("accept", session, body=models.PlanHash(plan=plan))
    approval = call("approve", session, body=models.Approve(plan=plan, robot=robot, expires_s=60), status=201)
    equal("the approval", (approval.plan, approval.robot, approval.by), (plan, robot, "ada"))
    run = call("start_run", body=models.Start(approval=approval.id), status=201)
    equal("the run", (run.session, run.plan, run.approval), (session, plan, approval.id))
    return approval.id, run.id


def run_on_robots(call, session):
    """Begins runs, looks at them, pauses, continues and stops them."""
    models = call.models
    state = models.RunState
    approval, run = begin_run(call, session, "Put the butter on the counter", "sim")
    again = call("start_run", body=models.Start(approval=approval), status=409)
    equal("the kind of the problem", again.error.kind, models.ProblemKind.CONFLICT)
    call("pause_run", run)
    paused = until(lambda: (view := call("get_run", run)).state == state.PAUSED and view)
    is_a(paused.lines[0], (models.StepLine, models.TextLine))
    is_a(paused.steps[0].mark, (models.PlainMark, models.UnderWay))
    call("continue_run", run)
    until(lambda: any(isinstance(step.mark, models.UnderWay) for step in call("get_run", run).steps))
    call("stop_run", run)
    stopped = until(lambda: (view := call("get_run", run)).state == state.STOPPED and view)
    equal("the end", (is_a(stopped.end, models.RunEnd).done, stopped.end.resumable), (False, True))
    call("resume_run", run)
    until(lambda: is_decided(call, run))
    nothing_asked = call("decide", run, body=models.Decision(question="another", yes=True), status=409)
    equal("the kind of the problem", nothing_asked.error.kind, models.ProblemKind.CONFLICT)
    recording = call.file("get_recording", run)
    equal("the recording", (recording[:8], recording[-8:]), (MCAP, MCAP))
    listed = call("list_runs")
    equal("the runs", [(own.id, own.session) for own in listed.runs], [(run, session)])
    equal("the runs that were stopped", call("stop_all").stopped, 0)


def is_decided(call, run):
    """Answers the question of a run; returns true at its end in the goal."""
    models = call.models
    view = call("get_run", run)
    if isinstance(view.question, models.RunQuestion):
        call("decide", run, body=models.Decision(question=view.question.id, yes=True))
    if view.state in (models.RunState.STOPPED, models.RunState.INTERRUPTED):
        raise AssertionError(f"the run ended with {view.end}")
    return view.state == models.RunState.DONE


def observe_and_look(call, session):
    """Reports the world, cancels an instruction, and reads lists and the audit log."""
    models = call.models
    seen = models.Observation(states=models.StateWords.from_dict({"<cloth>": "on_something(<floor>)"}))
    observed = call("observed", session, body=seen)
    equal("the world", observed.environment.object_states["<cloth>"], "on_something(<floor>)")
    call("instruct", session, body=models.Words(text="Bring the drink"))
    equal("the state", call("cancel", session).state, models.SessionState.READY)
    call("ended", session, body=models.Ending(ending=0), status=409)
    equal("the session", call("get_session", session).id, session)
    equal("the sessions", call("list_sessions").sessions, [session])
    deeds = [entry.deed.value for entry in reversed(call("get_audit").entries)]
    expected = ["refused", "accepted", "accepted", "approved", "started", "paused", "continued", "stopped", "ended", "continued", "ended"]
    # The run asks about the step that was under way at the stop, if there was one.
    equal("the deeds", [deed for deed in deeds if deed != "decided"], [*expected, "stopped"])


def main():
    """Generates the client and goes through the scenario."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    own = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, Server(own.program, Path(folder) / "state") as server:
        call = Caller(generated(server, folder), server)
        ask_the_model(call)
        session = plan_and_talk(call)
        plan_without_a_session(call)
        run_on_robots(call, session)
        observe_and_look(call, session)
        # The live stream has no end: a client reads it as server-sent events.
        left_out = set(call.functions) - call.called - {"events"}
        equal("the operations that were not called", left_out, set())
        print(f"{call.calls} calls of {len(call.called)} operations with a generated client")


if __name__ == "__main__":
    main()
