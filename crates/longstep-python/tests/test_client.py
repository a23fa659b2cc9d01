"""The client of a server: against a server of this test, and against a real one if LONGSTEP_DEMO_SERVER names its program."""

from __future__ import annotations

import http.server
import json
import os
import re
import subprocess
import tempfile
import threading
import unittest
from typing import Any

import longstep

DEMO_SERVER = os.environ.get("LONGSTEP_DEMO_SERVER")


class Handler(http.server.BaseHTTPRequestHandler):
    """Answers every request with what it got, and some paths with errors."""

    def do_GET(self) -> None:
        self.do_POST()

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers.get("Content-Length") or 0))
        if self.path.endswith("/busy/accept"):
            return self._send(503, {"error": {"kind": "busy", "message": "wait", "hint": "again later"}})
        if self.path == "/api/runs/elsewhere":
            self.send_response(302)
            self.send_header("Location", "/api/runs/x")
            self.end_headers()
            return None
        if self.path == "/api/runs/text":
            return self._send(200, "no json", raw=True)
        headers = {name: self.headers.get(name) for name in ("Authorization", "Longstep-User")}
        self._send(200, {"path": self.path, "body": json.loads(body or b"null"), "headers": headers})

    def _send(self, status: int, data: object, raw: bool = False) -> None:
        text = str(data).encode() if raw else json.dumps(data).encode()
        self.send_response(status)
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text)

    def log_message(self, *_: object) -> None:
        pass


class Clients(unittest.TestCase):
    def setUp(self) -> None:
        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()
        self.addCleanup(self.server.server_close)
        self.addCleanup(self.server.shutdown)
        self.client = longstep.Client(f"http://127.0.0.1:{self.server.server_address[1]}", token="secret", user="ada")

    def test_a_name_that_no_header_can_have_is_refused(self) -> None:
        for user in ("Jürgen", "梅子", "ada\nx", "", "  "):
            with self.assertRaisesRegex(ValueError, "printable ASCII"):
                longstep.Client("http://127.0.0.1:1", token="secret", user=user)

    def test_requests_name_the_token_the_person_and_the_body(self) -> None:
        got: Any = self.client.instruct("a/b", "Put the pen away")
        self.assertEqual(got["path"], "/api/sessions/a%2Fb/instruct")
        self.assertEqual(got["body"], {"text": "Put the pen away"})
        self.assertEqual(got["headers"], {"Authorization": "Bearer secret", "Longstep-User": "ada"})

    def test_refusals_are_exceptions_with_their_kind_and_hint(self) -> None:
        with self.assertRaises(longstep.ServerError) as raised:
            self.client.accept("busy", "hash")
        error = raised.exception
        self.assertEqual((error.kind, error.status, error.hint), ("busy", 503, "again later"))

    def test_the_token_follows_no_redirection(self) -> None:
        with self.assertRaises(longstep.ServerError) as raised:
            self.client.run("elsewhere")
        self.assertEqual(raised.exception.status, 302)

    def test_an_answer_that_is_no_json_is_an_error(self) -> None:
        with self.assertRaises(longstep.ServerError):
            self.client.run("text")

    def test_a_server_that_is_not_there_is_an_error_with_a_hint(self) -> None:
        with self.assertRaisesRegex(longstep.LongstepError, "longstep serve"):
            longstep.Client("http://127.0.0.1:9", token="secret").server()
        for wrong in ("localhost:8765", "ftp://host"):
            with self.assertRaises(ValueError):
                longstep.Client(wrong, token="secret")

    def test_the_token_of_the_file_is_for_this_machine_alone(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "longstep", "server", "token")
            os.makedirs(os.path.dirname(file))
            with open(file, "w", encoding="ascii") as out:
                out.write("of-the-file\n")
            before = {name: os.environ.pop(name, None) for name in ("XDG_STATE_HOME", "LONGSTEP_TOKEN")}
            os.environ["XDG_STATE_HOME"] = folder
            try:
                address = f"http://127.0.0.1:{self.server.server_address[1]}"
                got: Any = longstep.Client(address).server()
                self.assertEqual(got["headers"]["Authorization"], "Bearer of-the-file")
                with self.assertRaises(longstep.LongstepError):
                    longstep.Client("https://robot.example:443")
            finally:
                del os.environ["XDG_STATE_HOME"]
                os.environ.update({name: value for name, value in before.items() if value is not None})


@unittest.skipUnless(DEMO_SERVER, "LONGSTEP_DEMO_SERVER names no program")
class RealServer(unittest.TestCase):
    def setUp(self) -> None:
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        assert DEMO_SERVER
        self.process = subprocess.Popen([DEMO_SERVER, "5", folder.name], stdout=subprocess.PIPE, text=True)
        self.addCleanup(self.end)
        assert self.process.stdout
        found = re.search(r"(http://127\.0\.0\.1:\d+)/\?token=(\w+)", self.process.stdout.readline())
        assert found
        self.client = longstep.Client(found.group(1), token=found.group(2), user="ada")

    def end(self) -> None:
        self.process.kill()
        self.process.wait()
        assert self.process.stdout
        self.process.stdout.close()

    def accepted(self) -> longstep.SessionView:
        session = self.client.create_session(scene="pantry")
        asked = self.client.instruct(session["id"], "Bring the drink")
        self.assertEqual((asked["state"], asked["question"]), ("question", "Which drink?"))
        told = self.client.answer(session["id"], "put the juice on top of the shelf")
        proposal = told["proposal"]
        assert proposal
        # The hash that a person approves is the one that the package computes.
        world = longstep.World(session["environment"])
        own = longstep.verify({**proposal["answer"]["plan"]}, world).verified()
        self.assertEqual(own.hash, proposal["plan"])
        return self.client.accept(session["id"], proposal["plan"])

    def test_from_an_instruction_to_the_end_of_a_run(self) -> None:
        session = self.accepted()
        approval = self.client.approve(session["id"], session["accepted"][0]["plan"], "brisk")
        run = self.client.start(approval)
        views = list(self.client.follow(run["id"], every=0.01))
        self.assertEqual(views[-1]["state"], "done")
        end = views[-1]["end"]
        assert end
        self.assertTrue(end["done"])
        with self.assertRaises(longstep.ServerError) as raised:
            self.client.start(approval)
        self.assertEqual(raised.exception.kind, "conflict")

    def test_a_run_is_stopped(self) -> None:
        session = self.accepted()
        approval = self.client.approve(session["id"], session["accepted"][0]["plan"], "slow")
        run = self.client.start(approval)
        self.client.stop(run["id"])
        last = list(self.client.follow(run["id"], every=0.01))[-1]
        self.assertEqual(last["state"], "stopped")
        self.client.stop()

    def test_plans_without_a_session_are_those_of_the_package(self) -> None:
        answer = self.client.solve("put(butter, counter)", scene="pantry")
        self.assertEqual(answer["status"], "verified")
        verified = self.client.verify(answer["plan"], scene="pantry")
        repaired = self.client.repair(answer["plan"], scene="pantry")
        self.assertEqual((verified["status"], repaired["edits"]), ("verified", []))
        session = self.client.create_session(scene="pantry")
        own = longstep.solve(longstep.World(session["environment"]), "put(butter, counter)")
        self.assertEqual(own.dict()["steps"], answer["steps"])


if __name__ == "__main__":
    unittest.main()
