"""The example `demo_server` as a process: a scripted model and simulated robots behind HTTP, for the scripts beside this file."""

import http.client
import json
import os
import re
import subprocess
import time


class Server:
    """A server on a free port of this machine, with its files in a folder."""

    def __init__(self, program, folder, minutes=10, variables=None):
        self.program, self.folder, self.minutes = str(program), str(folder), str(minutes)
        self.environment = {**os.environ, **(variables or {})}
        self.process, self.port, self.token = None, 0, ""
        self.start()

    def start(self):
        """Starts the program, also again after `kill` on the same folder, and waits for its address."""
        command = [self.program, self.minutes, self.folder]
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=self.environment)
        line = self.process.stdout.readline()
        found = re.search(r"127\.0\.0\.1:(\d+)/\?token=(\w+)", line)
        if not found:
            raise RuntimeError(f"{self.program} did not print its address, but {line!r}")
        self.port, self.token = int(found.group(1)), found.group(2)

    def kill(self):
        """Ends the program with SIGKILL, and waits for its end."""
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()

    @property
    def address(self):
        """The address without a path."""
        return f"http://127.0.0.1:{self.port}"

    def headers(self, more=None):
        """The headers of a program that may use the server."""
        return {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json", **(more or {})}

    def request(self, method, path, body=None, headers=None, timeout=60):
        """Returns the status and the data of a request on a connection of its own."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=timeout)
        try:
            data = None if body is None else json.dumps(body)
            connection.request(method, path, data, self.headers(headers))
            answer = connection.getresponse()
            return answer.status, json.loads(answer.read())
        finally:
            connection.close()

    def get(self, path):
        """Returns the data of a path that has to be there."""
        return self.expect(200, "GET", path)

    def post(self, path, body=None, status=200):
        """Returns the data of a change that has to succeed."""
        return self.expect(status, "POST", path, body)

    def expect(self, status, method, path, body=None):
        """Returns the data of a request that has to have a status."""
        found, data = self.request(method, path, body)
        if found != status:
            raise AssertionError(f"{method} {path}: {found} instead of {status}: {data}")
        return data

    def resident_kib(self):
        """The memory of the process in KiB (Linux)."""
        with open(f"/proc/{self.process.pid}/status", encoding="ascii") as file:
            return int(re.search(r"VmRSS:\s+(\d+)", file.read()).group(1))

    def processor_seconds(self):
        """The processor time of the process (Linux)."""
        with open(f"/proc/{self.process.pid}/stat", encoding="ascii") as file:
            user, system = file.read().rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def until(is_so, seconds=60.0, pause=0.01):
    """Waits until a function returns something true, and returns it; raises after the time that no healthy machine needs."""
    end = time.monotonic() + seconds
    while True:
        found = is_so()
        if found:
            return found
        if time.monotonic() > end:
            raise AssertionError(f"not so after {seconds} s: {is_so}")
        time.sleep(pause)
