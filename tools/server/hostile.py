#!/usr/bin/env python3
"""Sends hostile requests to a server, and checks that it stays what it was.

    hostile.py --program target/debug/longstep [--requests 50000] [--seed 1]

Starts `longstep serve --no-model` on a free port with a folder of its own, sends requests with random methods, paths, ids, headers and
bodies, with and without the token, and checks: no answer has a status of 500, nobody without the token gets anything but 4xx, the
server still answers at the end, and no run was started. Exits with 1 otherwise.
"""

import argparse
import collections
import json
import os
import random
import re
import socket
import subprocess
import sys
import tempfile

METHODS = ["GET", "POST", "PUT", "DELETE", "PATCH", "HEAD", "OPTIONS", "TRACE", "BREW", "get", ""]
PATHS = [
    "/", "/api/server", "/api/sessions", "/api/sessions/{}", "/api/sessions/{}/world", "/api/sessions/{}/instruct", "/api/sessions/{}/answer",
    "/api/sessions/{}/feedback", "/api/sessions/{}/cancel", "/api/sessions/{}/accept", "/api/sessions/{}/undo", "/api/sessions/{}/ended",
    "/api/sessions/{}/observed", "/api/sessions/{}/approve", "/api/plan", "/api/verify", "/api/repair", "/api/solve", "/api/runs",
    "/api/runs/{}", "/api/runs/{}/decide", "/api/runs/{}/pause", "/api/runs/{}/continue", "/api/runs/{}/resume", "/api/runs/{}/stop",
    "/api/stop", "/api/audit", "/openapi.json", "/api/runs/{}/mcap", "/sessions/{}", "/runs/{}", "/audit", "/sessions/{}/fragment", "/nothing", "//", "/%00", "/api",
]
IDS = ["x", "..", "../../../etc/passwd", "%2e%2e%2f", "a" * 5000, "\u0000", "ключ", "-1", "{id}", "' OR 1=1 --", "<script>", "%ff%fe"]
TEXTS = ["", "a" * 5000, "\u202e", "null", "<b>", "\ud83d\ude00", "-" * 100, "put(", "never " * 50, "put(pen, shelf)" * 100, "(" * 3000, "[" * 3000]


def bodies(rng, session):
    """Returns a body of some kind: broken JSON, right JSON of the wrong shape, right shapes with hostile values."""
    text = rng.choice(TEXTS)
    deep = "[" * rng.randrange(1, 4000)
    environment = {"assets": ["<desk>", text], "objects": [text] * rng.randrange(4), "object_states": {text: text}}
    shapes = [
        {}, [], None, 7, text, {"text": text}, {"plan": text}, {"plan": text, "robot": text}, {"approval": text}, {"question": text, "yes": True},
        {"scene": text}, {"scene": "pantry", "rules": [text] * 5}, {"domain": text, "environment": environment},
        {"place": {"scene": "pantry"}, "plan": text}, {"place": {"scene": "pantry"}, "goal": text}, {"ending": rng.choice([-1, 0, 10**30])},
        {"states": {text: text}}, {"plan": session, "robot": "sim", "expires_s": rng.choice([0, -1, 10**30])}, {"text": text, "more": text},
    ]
    kind = rng.randrange(10)
    if kind == 0:
        return deep.encode()
    if kind == 1:
        return bytes(rng.randrange(256) for _ in range(rng.randrange(200)))
    if kind == 2:
        return json.dumps(rng.choice(shapes)).encode()[: rng.randrange(60)]
    return json.dumps(rng.choice(shapes)).encode("utf-8", "surrogatepass")


def request(rng, token, session):
    """Returns a request as bytes, and whether it has the token."""
    path = rng.choice(PATHS).replace("{}", rng.choice([*IDS, session, session, session]))
    if rng.random() < 0.1:
        path += "?" + rng.choice(["token=x", "after=" + "9" * 50, "session=" + "a" * 3000, "&&&=", "%"])
    method = rng.choice(METHODS) if rng.random() < 0.3 else rng.choice(["GET", "POST"])
    body = bodies(rng, session) if method == "POST" or rng.random() < 0.1 else b""
    is_known = rng.random() < 0.6
    headers = {"Host": rng.choice(["127.0.0.1:{port}"] * 8 + ["evil.example", ""]), "Connection": "close"}
    if is_known:
        headers["Authorization"] = f"Bearer {token}"
    elif rng.random() < 0.5:
        headers["Authorization"] = rng.choice(["Bearer ", "Basic x", "Bearer " + "0" * 64, "Bearer " + token[:-1]])
    if rng.random() < 0.8:
        headers["Content-Type"] = "application/json"
    if rng.random() < 0.1:
        headers[rng.choice(["Origin", "Cookie", "Longstep-User", "Last-Event-ID", "Prefer", "X-" + "a" * 200])] = rng.choice(
            ["http://evil.example", "longstep=" + "0" * 64, "null", "respond-async", "a" * 2000])
    if rng.random() < 0.9:
        headers["Content-Length"] = str(len(body))
    elif rng.random() < 0.5:
        headers["Content-Length"] = rng.choice(["-1", "99999999999", "abc", "1"])
    lines = [f"{method} {path} HTTP/1.1"] + [f"{name}: {value}" for name, value in headers.items()]
    return "\r\n".join(lines).encode("utf-8", "surrogatepass") + b"\r\n\r\n" + body, is_known


def exchange(port, data):
    """Sends bytes; returns the status of the answer, or none if the connection ended without one.

    A request that does not have the length that it says would be waited for, so its connection ends.
    """
    head, _, body = data.partition(b"\r\n\r\n")
    said = re.findall(rb"Content-Length: (\S+)", head)
    is_whole = said == [str(len(body)).encode()] or (not said and not body)
    with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
        try:
            connection.sendall(data)
            if not is_whole:
                connection.shutdown(socket.SHUT_WR)
        except OSError:
            pass
        answer = b""
        try:
            while len(answer) < 1 << 16:
                part = connection.recv(1 << 14)
                if not part:
                    break
                answer += part
        except OSError:
            pass
    found = re.match(rb"HTTP/1.1 (\d+)", answer)
    return int(found.group(1)) if found else None


def main():
    """Runs the requests."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--program", required=True)
    parser.add_argument("--requests", type=int, default=50_000)
    parser.add_argument("--seed", type=int, default=1)
    own = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, LONGSTEP_SESSIONS=os.path.join(folder, "sessions"))
        command = [own.program, "serve", "--no-model", "--listen", "127.0.0.1:0"]
        server = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, cwd=folder)
        try:
            sys.exit(attack(server, own))
        finally:
            server.kill()


def attack(server, own):
    """Sends the requests to a server that has just started; returns the exit code."""
    found = re.search(r"127\.0\.0\.1:(\d+)/\?token=(\w+)", server.stdout.readline())
    port, token = int(found.group(1)), found.group(2)
    good = f"Host: 127.0.0.1:{port}\r\nConnection: close\r\nAuthorization: Bearer {token}\r\n"
    create = b'{"scene": "pantry"}'
    head = f"POST /api/sessions HTTP/1.1\r\n{good}Content-Type: application/json\r\nContent-Length: {len(create)}\r\n\r\n"
    with socket.create_connection(("127.0.0.1", port)) as connection:
        connection.sendall(head.encode() + create)
        answer = b"".join(iter(lambda: connection.recv(1 << 14), b""))
    session = json.loads(answer.split(b"\r\n\r\n", 1)[1])["id"]
    rng = random.Random(own.seed)
    statuses = collections.Counter()
    wrong = []
    for number in range(own.requests):
        data, is_known = request(rng, token, session)
        data = data.replace(b"{port}", str(port).encode())
        status = exchange(port, data)
        statuses[status] += 1
        if status == 500 or (not is_known and status is not None and not 400 <= status < 500 and status != 303):
            wrong.append((number, status, data[:300]))
        if server.poll() is not None:
            wrong.append((number, "the server ended", data[:300]))
            break
    runs = exchange(port, f"GET /api/runs HTTP/1.1\r\n{good}\r\n".encode()) if server.poll() is None else None
    print(dict(sorted(statuses.items(), key=str)))
    for own_wrong in wrong[:10]:
        print("WRONG", *own_wrong)
    print(f"{sum(statuses.values())} requests, {len(wrong)} wrong, the server answers {runs}")
    return 1 if wrong or runs != 200 else 0


if __name__ == "__main__":
    main()
