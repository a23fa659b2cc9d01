"""HTTP connections and streams of events for asyncio, as much as `load.py` needs."""

import asyncio
import json
import socket
import time


class Refused(Exception):
    """A request without an answer of the kind 2xx."""


class Connection:
    """A connection that is kept alive, opened with the first request."""

    def __init__(self, server, measures):
        self.server, self.measures = server, measures
        self.reader = self.writer = None

    async def call(self, kind, method, path, body=None):
        """Returns the data of an answer; its time counts for calls of this kind."""
        began = time.monotonic()
        data = b"" if body is None else json.dumps(body).encode()
        if self.writer is None:
            self.reader, self.writer = await asyncio.open_connection("127.0.0.1", self.server.port)
        self.writer.write(head(self.server, method, path, {"Content-Length": str(len(data))}) + data)
        status, headers = await answer_head(self.reader)
        answer = await self.reader.readexactly(int(headers["content-length"]))
        self.measures.setdefault(kind, []).append(time.monotonic() - began)
        if not 200 <= status < 300:
            raise Refused(f"{method} {path}: {status} {answer[:300]!r}")
        return json.loads(answer)

    def close(self):
        """Ends the connection."""
        if self.writer:
            self.writer.close()
        self.reader = self.writer = None


class Stream:
    """Events with their numbers, from `GET /api/events`."""

    def __init__(self, server, query):
        self.server, self.query = server, query
        self.reader = self.writer = None
        self.rest = b""

    async def open(self, buffer=1 << 16):
        """Opens the stream, with buffers of about this many bytes here; the events that are read follow."""
        own = socket.socket()
        own.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer)
        own.setblocking(False)
        await asyncio.get_running_loop().sock_connect(own, ("127.0.0.1", self.server.port))
        self.reader, self.writer = await asyncio.open_connection(sock=own, limit=buffer)
        self.writer.write(head(self.server, "GET", "/api/events" + self.query, {}))
        status, _ = await answer_head(self.reader)
        if status != 200:
            raise Refused(f"GET /api/events{self.query}: {status}")
        return self

    async def next(self):
        """Returns the id, the kind and the data of the next event."""
        while True:
            block, found, rest = self.rest.partition(b"\n\n")
            if not found:
                size = int(await self.reader.readline(), 16)
                self.rest += (await self.reader.readexactly(size + 2))[:-2]
                continue
            self.rest = rest
            fields = dict(line.split(": ", 1) for line in block.decode().split("\n") if ": " in line and line[0] != ":")
            if "id" in fields:
                return fields["id"], fields["event"], fields["data"]

    def close(self):
        """Goes away."""
        if self.writer:
            self.writer.close()


def head(server, method, path, more):
    """Returns the head of a request with the token."""
    headers = {"Host": f"127.0.0.1:{server.port}", **server.headers(more)}
    lines = [f"{method} {path} HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items())]
    return "\r\n".join(lines).encode() + b"\r\n\r\n"


async def answer_head(reader):
    """Reads the status and the headers of an answer."""
    text = (await reader.readuntil(b"\r\n\r\n")).decode()
    first, *lines = text.strip().split("\r\n")
    return int(first.split(" ")[1]), {name.lower(): value for name, value in (line.split(": ", 1) for line in lines)}
