"""Only a person who approves moves the robot: the example `mcp_scripted` against the client of PyPI `mcp` 2.x.

    cargo build -p longstep-server --example mcp_scripted
    python3 -m venv venv && venv/bin/pip install 'mcp>=2.3'
    venv/bin/python crates/longstep-server/tests/mcp_matrix.py target/debug/examples/mcp_scripted

Both transports (stdio, streamable HTTP) and both protocols (2025-11-25, 2026-07-28), each with every kind of answer. After
each case the audit log and the logs of runs on disk are compared with what a person approved. The exit code is 1 if a
case fails.
"""

import asyncio
import contextlib
import json
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from mcp import Client, StdioServerParameters, types
from mcp.client.stdio import stdio_client

SERVER = str(Path(sys.argv[1]).resolve())
ERAS = {"2025-11-25": "legacy", "2026-07-28": "2026-07-28"}
TRANSPORTS = ("stdio", "http")
PAGE = "http://127.0.0.1:8734/sessions/{session}"
INSTRUCTION = "Put the pen on the shelf"
MOVED = {"states": {"<pen>": "on_something(<table>)"}}


class Place:
    """A server with a folder and a pipe that changes its world."""

    def __init__(self, folder, transport, era, arguments=()):
        self.folder = Path(folder)
        self.control = self.folder / "control"
        os.mkfifo(self.control)
        self.transport, self.era = transport, era
        self.arguments = [str(self.folder), "--control", str(self.control), "--page", PAGE, *arguments]
        self.forms = []
        self.process = None

    @contextlib.asynccontextmanager
    async def client(self, answer):
        """Connects a client; `answer` maps a form to a result, and is none for a client without forms."""

        async def elicit(_, form):
            self.forms.append(form)
            result = answer(form)
            return await result if asyncio.iscoroutine(result) else result

        with open(self.folder / "errors", "a+") as errors:
            if self.transport == "http":
                target = await self.http(errors)
            else:
                parameters = StdioServerParameters(command=SERVER, args=self.arguments)
                target = stdio_client(parameters, errlog=errors)
            callback = elicit if answer else None
            information = types.Implementation(name="matrix", version="1")
            try:
                async with Client(
                    target, mode=ERAS[self.era], elicitation_callback=callback, client_info=information
                ) as client:
                    assert client.protocol_version == self.era, client.protocol_version
                    # Clients check results against the schemas that they have listed.
                    assert len((await client.list_tools()).tools) == 14
                    yield client
            finally:
                if self.process:
                    self.process.kill()
                    self.process.wait()

    async def http(self, errors):
        self.process = subprocess.Popen([SERVER, *self.arguments, "--http"], stderr=errors)
        for _ in range(500):
            found = re.search(r"http://\S+", (self.folder / "errors").read_text())
            if found:
                return found.group(0)
            await asyncio.sleep(0.02)
        raise AssertionError("the server does not begin")

    async def observe(self, session):
        """Changes the world behind the client's back."""
        before = (self.folder / "errors").read_text().count("observed")
        with open(self.control, "w") as pipe:
            pipe.write(f"observe {session} {json.dumps(MOVED)}\n")
        while (self.folder / "errors").read_text().count("observed") == before:
            await asyncio.sleep(0.02)
        assert "not observed" not in (self.folder / "errors").read_text()

    def audit(self):
        path = self.folder / "server" / "audit.jsonl"
        return [json.loads(line) for line in path.read_text().splitlines()]

    def runs(self):
        """Returns the events of each run that reached the robot."""
        logs = (self.folder / "runs").glob("*.jsonl")
        return {log.stem: [json.loads(line) for line in log.read_text().splitlines()] for log in logs}

    def check(self, moved):
        """Compares the audit log with the logs of runs: each run has an approval of its plan before it."""
        deeds = self.audit()
        approved = {deed["approval"]: deed for deed in deeds if deed["deed"] == "approved"}
        started = [deed for deed in deeds if deed["deed"] == "started"]
        assert len(started) == len(self.runs()) == moved, (started, list(self.runs()))
        assert len(approved) == moved, approved
        for start in started:
            approval = approved[start["approval"]]
            assert (approval["plan"], approval["robot"]) == (start["plan"], start["robot"])
            assert deeds.index(approval) < deeds.index(start)
            assert approval["by"] == start["by"] == "mcp:matrix", approval
            assert self.runs()[start["run"]], "the log of a run is empty"


def text(result):
    return "".join(block.text for block in result.content if block.type == "text")


def form_hash(form):
    return form.requested_schema["properties"]["plan"]["default"]


def accept(**content):
    return types.ElicitResult(action="accept", content=content)


def approve(form):
    """Answers as a person who reads the form and approves."""
    assert "1. " in form.message and "sim" in form.message and form_hash(form) in form.message, form.message
    assert form.requested_schema["properties"]["approve"]["default"] is False
    return accept(approve=True, plan=form_hash(form))


async def slowly(result):
    await asyncio.sleep(1.2)
    return result


async def plan(client, instruction=INSTRUCTION):
    result = await client.call_tool("plan", {"instruction": instruction})
    assert not result.is_error, text(result)
    return result.structured_content


def executing(planned):
    return {"plan_id": planned["plan_id"], "hash": planned["hash"]}


async def execute(client, planned, **more):
    return await client.call_tool("execute_plan", {**executing(planned), **more})


async def done(client, run):
    for _ in range(20):
        status = await client.call_tool("run_status", {"run": run["id"], "wait_seconds": 5})
        if status.structured_content["end"]:
            return status.structured_content
    raise AssertionError("the run does not end")


def refused(result, *expected):
    assert result.is_error, text(result)
    for part in expected:
        assert part in text(result), (part, text(result))
    assert "Next step: " in text(result), text(result)


def simple(name, answer, expected, forms=1):
    """A case in which the answer to one form decides that nothing moves."""

    async def case(place):
        async with place.client(answer) as client:
            planned = await plan(client)
            refused(await execute(client, planned), *expected)
        assert len(place.forms) == forms, place.forms
        place.check(moved=0)
        assert any(deed["deed"] == "refused" for deed in place.audit())

    return name, ERAS, case


async def accepts(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        result = await execute(client, planned)
        assert not result.is_error, text(result)
        assert (await done(client, result.structured_content))["state"] == "done"
        session = {"session": planned["id"]}
        world = (await client.call_tool("describe_world", session)).structured_content
        assert world["environment"]["object_states"]["<pen>"] == "on_something(<shelf>)"
    assert len(place.forms) == 1
    place.check(moved=1)


async def replays_an_id(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        first, second = await asyncio.gather(execute(client, planned), execute(client, planned))
        assert sorted([first.is_error, second.is_error]) == [False, True], (text(first), text(second))
        run = (second if first.is_error else first).structured_content
        await done(client, run)
        refused(await execute(client, planned), "was used already")
        refused(await client.call_tool("explain", {"session": planned["id"]}), "no plan")
    place.check(moved=1)


async def expires(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        await asyncio.sleep(0.3)
        refused(await execute(client, planned), "has expired")
    assert not place.forms
    place.check(moved=0)


async def world_changes(place):
    answers = [types.ElicitResult(action="decline")]

    async def answer(form):
        if answers:
            return answers.pop()
        await place.observe(session)
        return approve(form)

    async with place.client(answer) as client:
        planned = await plan(client)
        session = planned["id"]
        # Declined at once: the plan is accepted and waits. Only then can the world of the session change.
        refused(await execute(client, planned), "Nobody was asked", PAGE.replace("{session}", session))
        # Changed while the person reads the form.
        refused(await execute(client, planned), "world has changed")
        # Changed since the plan was shown.
        refused(await execute(client, planned), "world has changed")
    assert len(place.forms) == 2
    place.check(moved=0)


async def wrong_words(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        refused(await client.call_tool("execute_plan", {**executing(planned), "hash": "0" * 32}), "hash")
        refused(await client.call_tool("execute_plan", {**executing(planned), "plan_id": "plan-0"}), "no plan_id")
        refused(await execute(client, planned, robot="arm"), "no robot")
        refused(await client.call_tool("execute_plan", {}), "arguments")
        refused(await client.call_tool("execute_plan", {**executing(planned), "approve": True}), "arguments")
    assert not place.forms
    place.check(moved=0)


async def round_by_hand(client, planned, state=None, responses=None):
    return await client.session.call_tool(
        "execute_plan",
        executing(planned),
        input_responses=responses,
        request_state=state,
        allow_input_required=True,
    )


async def tampers(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        asked = await round_by_hand(client, planned)
        state = asked.request_state
        yes = {"approval": accept(approve=True, plan=planned["hash"])}
        middle = len(state) // 2
        changed = state[:middle] + ("A" if state[middle] != "A" else "B") + state[middle + 1 :]
        for wrong in (changed, state[:-2], "", "rs2.AAAA.AAAA.AAAA"):
            refused(await round_by_hand(client, planned, wrong, yes), "not one of this server")
        refused(await round_by_hand(client, planned, None, yes), "no requestState")
        refused(await round_by_hand(client, planned, state, {}), "no answer")
        refused(await round_by_hand(client, planned, state, yes), "answered already")
    place.check(moved=0)


async def replays_a_state(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        yes = {"approval": accept(approve=True, plan=planned["hash"])}
        asked = await round_by_hand(client, planned)
        result = await round_by_hand(client, planned, asked.request_state, yes)
        assert not result.is_error, text(result)
        await done(client, result.structured_content)
        refused(await round_by_hand(client, planned, asked.request_state, yes), "used already")
        # The state of one plan does not approve another.
        cup = await client.call_tool("plan", {"instruction": "Put the cup on the shelf", "session": planned["id"]})
        cup = cup.structured_content
        yes = {"approval": accept(approve=True, plan=cup["hash"])}
        refused(await round_by_hand(client, cup, asked.request_state, yes), "answered already")
    place.check(moved=1)


async def state_expires(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        asked = await round_by_hand(client, planned)
        await asyncio.sleep(0.4)
        yes = {"approval": accept(approve=True, plan=planned["hash"])}
        refused(await round_by_hand(client, planned, asked.request_state, yes), "time to answer")
    place.check(moved=0)


async def stops(place):
    async with place.client(approve) as client:
        planned = await plan(client)
        run = (await execute(client, planned)).structured_content
        began = time.monotonic()
        stopped = await client.call_tool("stop", {"run": run["id"]})
        assert not stopped.is_error and time.monotonic() - began < 1, text(stopped)
        assert (await done(client, run))["state"] in ("stopped", "done")
    place.check(moved=1)


async def reads(place):
    """Everything that changes nothing, with the schemas that the client checks."""
    async with place.client(None) as client:
        assert [str(own.uri) for own in (await client.list_resources()).resources] == [
            "longstep://world",
            "longstep://plan",
        ]
        world = await client.read_resource("longstep://world")
        assert "<pen>" in world.contents[0].text
        planned = await plan(client)
        session = {"session": planned["id"]}
        file = await client.read_resource(f"longstep://sessions/{planned['id']}/plan")
        for tool in ("verify", "repair"):
            result = await client.call_tool(tool, {"plan": file.contents[0].text, **session})
            assert result.structured_content["status"] == "verified", text(result)
        explained = (await client.call_tool("explain", session)).structured_content
        assert explained["hash"] == planned["hash"] and len(explained["steps"]) == 6
        question = await client.call_tool("plan", {"instruction": "Put it somewhere", **session})
        assert question.structured_content["state"] == "question"
        answer = await client.call_tool("answer", {"answer": "the pen on the shelf", **session})
        assert answer.structured_content["state"] == "plan", text(answer)
        assert (await client.call_tool("discard", session)).structured_content["state"] == "ready"
        refused(await client.call_tool("revise", {"feedback": "slower", **session}), "")
    place.check(moved=0)


DECLINE = types.ElicitResult(action="decline")
CANCEL = types.ElicitResult(action="cancel")
PAGE_NAMED = ("Nobody was asked", PAGE.split("{")[0])

CASES = [
    ("reads", ERAS, reads),
    ("accept", ERAS, accepts),
    simple("decline", lambda form: slowly(DECLINE), ["the person declined"]),
    simple("cancel", lambda form: slowly(CANCEL), ["without a decision"]),
    simple("decline at once", lambda form: DECLINE, PAGE_NAMED),
    simple("cancel at once", lambda form: CANCEL, PAGE_NAMED),
    simple("empty accept", lambda form: accept(), ["came back empty"]),
    simple("empty accept, slowly", lambda form: slowly(accept()), ["came back empty"]),
    simple("approve unset", lambda form: accept(approve=False, plan=form_hash(form)), ["did not approve"]),
    simple("wrong hash in the form", lambda form: accept(approve=True, plan="0" * 32), ["another hash"]),
    simple("no hash in the form", lambda form: accept(approve=True), ["another hash"]),
    simple("no elicitation", None, PAGE_NAMED, forms=0),
    ("wrong arguments", ERAS, wrong_words),
    ("replayed id", ERAS, replays_an_id),
    ("expired id", ERAS, expires),
    ("changed world", ERAS, world_changes),
    ("stop", ERAS, stops),
    ("tampered state", ["2026-07-28"], tampers),
    ("replayed state", ["2026-07-28"], replays_a_state),
    ("expired state", ["2026-07-28"], state_expires),
]

ARGUMENTS = {"expired id": ["--plan-lifetime", "0.1"], "expired state": ["--form-lifetime", "0.2"]}


async def attempt(transport, era, name, case):
    with tempfile.TemporaryDirectory() as folder:
        place = Place(folder, transport, era, ARGUMENTS.get(name, ()))
        try:
            await asyncio.wait_for(case(place), timeout=60)
        except BaseException as error:  # noqa: BLE001: a case that fails in any way has failed
            errors = Path(folder, "errors")
            print(f"FAILED  {transport:5} {era} {name}: {error!r}")
            for part in getattr(error, "exceptions", []):
                print("        ", repr(part))
            print("        ", errors.read_text()[-600:] if errors.exists() else "")
            return False
        print(f"ok      {transport:5} {era} {name}")
        return True


async def main():
    results = []
    for transport in TRANSPORTS:
        for era in ERAS:
            for name, eras, case in CASES:
                if era in eras:
                    results.append(await attempt(transport, era, name, case))
    print(f"{sum(results)} of {len(results)} cases")
    return 0 if all(results) else 1


sys.exit(asyncio.run(main()))
