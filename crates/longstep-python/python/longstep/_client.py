"""The client of a server (`longstep serve`), over HTTP, with nothing but the standard library."""

from __future__ import annotations

import json
import os
import time
import urllib.error
import urllib.parse
import urllib.request
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, TypedDict, cast

from longstep._errors import LongstepError
from longstep._types import Environment

__all__ = ["Client", "RunView", "ServerError", "SessionView"]


class ServerError(LongstepError):
    """A request that the server refused. `kind` is its word for the reason, `status` the status of HTTP."""

    def __init__(self, message: str, *, hint: str | None = None, kind: str, status: int) -> None:
        super().__init__(message, hint=hint)
        self.kind = kind
        self.status = status


class ProposalView(TypedDict):
    """A plan that waits for a decision. `plan` is its hash, `answer` what `longstep plan --json` prints."""

    plan: str
    refused: list[str]
    offers_rule: bool
    answer: dict[str, Any]


class AcceptedView(TypedDict):
    """An accepted plan. `plan` is its hash."""

    number: int
    plan: str
    instruction: str
    goal: list[str]
    steps: list[str]
    not_in_plan: list[str]
    pending: bool


class SessionView(TypedDict):
    """A session as the server shows it."""

    id: str
    version: int
    domain: str
    model: str
    state: Literal["ready", "thinking", "question", "plan", "consent", "no_plan", "endings"]
    instruction: str | None
    question: str | None
    proposal: ProposalView | None
    failure: dict[str, Any] | None
    endings: list[dict[str, Any]]
    accepted: list[AcceptedView]
    rules: list[str]
    environment: Environment


class _QuestionView(TypedDict):
    id: str
    kind: Literal["plan", "change", "step", "judge", "confirm"]
    text: str
    steps: list[str]
    edits: list[str]


class EndView(TypedDict):
    """The end of a run."""

    done: bool
    text: str
    resumable: bool


class RunView(TypedDict):
    """A run as the server shows it."""

    id: str
    session: str
    number: int
    plan: str
    approval: str
    robot: str
    by: str
    instruction: str
    urgent: bool
    state: Literal["queued", "opening", "running", "asking", "paused", "done", "stopped", "interrupted"]
    dry_run: bool
    steps: list[dict[str, Any]]
    lines: list[dict[str, Any]]
    feedback: str | None
    question: _QuestionView | None
    notices: list[str]
    events: int
    environment: Environment | None
    end: EndView | None


_ENDED = ("done", "stopped", "interrupted")


class Client:
    """A client of a server. It keeps no connection and no state, so threads may share one.

    `token` is the server's; without one it is read from `LONGSTEP_TOKEN`, or from the file of this user's server, which is
    sent to this machine alone. `user` is the name of the person in the server's audit log.
    """

    def __init__(
        self,
        address: str = "http://127.0.0.1:8765",
        *,
        token: str | None = None,
        user: str | None = None,
        timeout: float = 600.0,
    ) -> None:
        parts = urllib.parse.urlsplit(address)
        if parts.scheme not in ("http", "https") or not parts.hostname:
            raise ValueError(f"the address of a server is http://HOST:PORT, not {address!r}")
        self._address = address.rstrip("/")
        self._timeout = timeout
        is_here = parts.hostname in ("127.0.0.1", "::1", "localhost")
        self._headers = {"Content-Type": "application/json", "Authorization": f"Bearer {token or _found_token(is_here)}"}
        if user is not None:
            if not (user.isascii() and user.isprintable() and user.strip()):
                raise ValueError(f"the name of a person goes into a header of HTTP: printable ASCII characters, not {user!r}")
            self._headers["Longstep-User"] = user
        # A redirection would carry the token elsewhere, and a proxy would see it on its way to this machine.
        handlers: list[urllib.request.BaseHandler] = [_NoRedirect()]
        if is_here:
            handlers.append(urllib.request.ProxyHandler({}))
        self._opener = urllib.request.build_opener(*handlers)

    def server(self) -> dict[str, Any]:
        """Returns the model, the domains, the scenes and the robots of the server."""
        return cast("dict[str, Any]", self._get("/api/server"))

    def create_session(
        self,
        *,
        environment: Environment | None = None,
        domain: str | None = None,
        scene: str | None = None,
        rules: Sequence[str] = (),
    ) -> SessionView:
        """Begins a session in a scene of the server, or in an environment with its domain."""
        return cast(SessionView, self._post("/api/sessions", _place(environment, domain, scene, rules)))

    def session(self, session: str) -> SessionView:
        """Returns a session as it is now."""
        return cast(SessionView, self._get(f"/api/sessions/{_segment(session)}"))

    def instruct(self, session: str, text: str) -> SessionView:
        """Gives an instruction, and waits until it is the person's turn."""
        return self._say(session, "instruct", text)

    def answer(self, session: str, text: str) -> SessionView:
        """Answers the question of a session."""
        return self._say(session, "answer", text)

    def feedback(self, session: str, text: str) -> SessionView:
        """Asks for a change of the plan that waits for a decision."""
        return self._say(session, "feedback", text)

    def accept(self, session: str, plan: str) -> SessionView:
        """Accepts the plan with this hash. Nothing moves for that."""
        return cast(SessionView, self._post(f"/api/sessions/{_segment(session)}/accept", {"plan": plan}))

    def undo(self, session: str) -> SessionView:
        """Takes the last accepted plan back."""
        return cast(SessionView, self._post(f"/api/sessions/{_segment(session)}/undo"))

    def approve(self, session: str, plan: str, robot: str, *, expires_s: int | None = None) -> str:
        """Approves the accepted plan with this hash for one run on one robot; returns the approval. Call this only for a
        person who has read the plan."""
        body: dict[str, Any] = {"plan": plan, "robot": robot}
        if expires_s is not None:
            body["expires_s"] = expires_s
        view = cast("dict[str, Any]", self._post(f"/api/sessions/{_segment(session)}/approve", body))
        return str(view["id"])

    def start(self, approval: str, *, urgent: bool = False) -> RunView:
        """Begins the run of an approval, which is used up by that."""
        return cast(RunView, self._post("/api/runs", {"approval": approval, "urgent": urgent}))

    def run(self, run: str) -> RunView:
        """Returns a run as it is now."""
        return cast(RunView, self._get(f"/api/runs/{_segment(run)}"))

    def follow(self, run: str, *, every: float = 0.2) -> Iterator[RunView]:
        """Yields a run whenever it has changed, until its end; `every` is the time between two looks in seconds.

        A run with the state `asking` waits for `decide`.
        """
        last: RunView | None = None
        while True:
            view = self.run(run)
            if view != last:
                last = view
                yield view
            if view["state"] in _ENDED:
                return
            time.sleep(every)

    def decide(self, run: str, question: str, yes: bool) -> RunView:
        """Answers the question of a run, by its id."""
        return cast(RunView, self._post(f"/api/runs/{_segment(run)}/decide", {"question": question, "yes": yes}))

    def pause(self, run: str) -> RunView:
        """Pauses a run after the steps that are under way."""
        return cast(RunView, self._post(f"/api/runs/{_segment(run)}/pause"))

    def go_on(self, run: str) -> RunView:
        """Continues a paused run from the world that is observed then."""
        return cast(RunView, self._post(f"/api/runs/{_segment(run)}/continue"))

    def resume(self, run: str) -> RunView:
        """Takes up a run that was interrupted."""
        return cast(RunView, self._post(f"/api/runs/{_segment(run)}/resume"))

    def stop(self, run: str | None = None) -> None:
        """Stops a run, or all robots."""
        self._post("/api/stop" if run is None else f"/api/runs/{_segment(run)}/stop")

    def verify(self, plan: str | Mapping[str, Any], *, goal: str | None = None, **place: Any) -> dict[str, Any]:
        """Verifies a plan; `place` is that of `create_session`."""
        return self._assess("verify", plan, goal, place)

    def repair(self, plan: str | Mapping[str, Any], *, goal: str | None = None, **place: Any) -> dict[str, Any]:
        """Repairs a plan; `place` is that of `create_session`."""
        return self._assess("repair", plan, goal, place)

    def solve(self, goal: str, **place: Any) -> dict[str, Any]:
        """Finds a plan for a goal; `place` is that of `create_session`."""
        return cast("dict[str, Any]", self._post("/api/solve", {"goal": goal, "place": place}))

    def _assess(self, what: str, plan: str | Mapping[str, Any], goal: str | None, place: Mapping[str, Any]) -> dict[str, Any]:
        body = {"plan": plan if isinstance(plan, str) else dict(plan), "goal": goal, "place": dict(place)}
        return cast("dict[str, Any]", self._post(f"/api/{what}", body))

    def _say(self, session: str, what: str, text: str) -> SessionView:
        return cast(SessionView, self._post(f"/api/sessions/{_segment(session)}/{what}", {"text": text}))

    def _get(self, path: str) -> object:
        return self._request("GET", path, None)

    def _post(self, path: str, body: Mapping[str, Any] | None = None) -> object:
        return self._request("POST", path, json.dumps(body if body is not None else {}).encode())

    def _request(self, method: str, path: str, body: bytes | None) -> object:
        request = urllib.request.Request(f"{self._address}{path}", data=body, headers=self._headers, method=method)
        try:
            with self._opener.open(request, timeout=self._timeout) as reply:
                return _decoded(reply.read(), reply.status)
        except urllib.error.HTTPError as error:
            with error:
                raise _refusal(error.read(), error.code) from None
        except (urllib.error.URLError, TimeoutError, ConnectionError) as error:
            reason = getattr(error, "reason", error)
            hint = "start it with `longstep serve`, or check the address"
            raise LongstepError(f"the server at {self._address} does not answer: {reason}", hint=hint) from error

    def __repr__(self) -> str:
        return f"<longstep.Client {self._address}>"


class _NoRedirect(urllib.request.HTTPRedirectHandler):
    def redirect_request(self, *_: Any) -> None:
        return None


def _place(
    environment: Environment | None, domain: str | None, scene: str | None, rules: Sequence[str]
) -> dict[str, Any]:
    given = {"environment": environment, "domain": domain, "scene": scene}
    return {**{key: value for key, value in given.items() if value is not None}, "rules": list(rules)}


def _segment(name: str) -> str:
    return urllib.parse.quote(name, safe="")


def _found_token(is_here: bool) -> str:
    token = os.environ.get("LONGSTEP_TOKEN")
    if token:
        return token.strip()
    state = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    file = state / "longstep" / "server" / "token"
    try:
        if is_here:
            return file.read_text(encoding="ascii").strip()
    except OSError:
        pass
    raise LongstepError("the token of the server is not known", hint="pass `token`, or set LONGSTEP_TOKEN")


def _decoded(data: bytes, status: int) -> object:
    if not data:
        return None
    try:
        return json.loads(data)
    except ValueError:
        raise ServerError("the answer is no JSON; is this a Longstep server?", kind="protocol", status=status) from None


def _refusal(data: bytes, status: int) -> ServerError:
    try:
        error = json.loads(data)["error"]
        return ServerError(str(error["message"]), hint=error.get("hint"), kind=str(error["kind"]), status=status)
    except (ValueError, KeyError, TypeError):
        return ServerError(f"the server answers with status {status}", kind="protocol", status=status)
