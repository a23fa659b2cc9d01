"""Clients that a server has to bear: a slow reader, readers that go away, a large body, and thousands of idle connections.

Run as a program, it opens idle connections and prints the number of those that were held, refused with a message, and closed without
one:

    guests.py PORT COUNT SECONDS
"""

import asyncio
import json
import resource
import selectors
import socket
import sys
import time

from connection import Stream, head

LARGE = 100 << 20


async def slow_reader(server, until):
    """Reads one byte of the events a second. Returns the number of bytes."""
    stream = await Stream(server, "").open(buffer=4096)
    count = 0
    while time.monotonic() < until:
        if await stream.reader.read(1) == b"":
            raise AssertionError("the stream of a slow reader ended")
        count += 1
        await asyncio.sleep(1)
    stream.close()
    return count


async def leaving_readers(server, until):
    """Opens streams and goes away in the middle. Returns their number."""
    count = 0
    while time.monotonic() < until:
        stream = await Stream(server, "").open()
        try:
            await asyncio.wait_for(stream.next(), 0.3)
        except TimeoutError:
            pass
        stream.writer.transport.abort()
        count += 1
    return count


async def large_body(server):
    """Sends 100 MB. Returns the status of the answer, the bytes that were sent until then, and the seconds."""
    began = time.monotonic()
    reader, writer = await asyncio.open_connection("127.0.0.1", server.port)
    writer.write(head(server, "POST", "/api/verify", {"Content-Length": str(LARGE)}))
    sent = 0
    answer = asyncio.create_task(reader.readline())
    try:
        while sent < LARGE and not answer.done():
            writer.write(b" " * (1 << 16))
            sent += 1 << 16
            await writer.drain()
            await asyncio.sleep(0)
    except ConnectionError:
        pass
    try:
        line = await asyncio.wait_for(answer, 60)
    except ConnectionError:
        line = b""
    writer.close()
    return (int(line.split(b" ")[1]) if line else None), sent, time.monotonic() - began


async def idle_connections(server, count, seconds):
    """Lets another process open idle connections. Returns what it found."""
    program = [sys.executable, __file__, str(server.port), str(count), str(seconds)]
    process = await asyncio.create_subprocess_exec(*program, stdout=asyncio.subprocess.PIPE)
    text, _ = await process.communicate()
    return json.loads(text)


def raise_limit(count):
    """Raises the limit of open files of this process."""
    _, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = count + 1000
    if hard != resource.RLIM_INFINITY and hard < wanted:
        sys.exit(f"error: {wanted} open files are needed, and the hard limit is {hard}\nhint: raise it with `ulimit -Hn {wanted}`")
    resource.setrlimit(resource.RLIMIT_NOFILE, (wanted, hard))


def hold(port, count, seconds):
    """Opens connections that send nothing, and looks at them for some seconds."""
    selector = selectors.DefaultSelector()
    found = {"held": 0, "refused": 0, "closed": 0}
    connections = set()
    for _ in range(count):
        connection = socket.create_connection(("127.0.0.1", port))
        connection.setblocking(False)
        connections.add(connection)
        selector.register(connection, selectors.EVENT_READ)
    end = time.monotonic() + seconds
    while time.monotonic() < end and connections:
        for key, _ in selector.select(0.1):
            try:
                text = key.fileobj.recv(1 << 12)
            except ConnectionError:
                text = b""
            found["refused" if b"too many connections" in text else "closed"] += 1
            selector.unregister(key.fileobj)
            connections.discard(key.fileobj)
            key.fileobj.close()
    found["held"] = len(connections)
    return found


if __name__ == "__main__":
    raise_limit(int(sys.argv[2]))
    print(json.dumps(hold(int(sys.argv[1]), int(sys.argv[2]), float(sys.argv[3]))))
