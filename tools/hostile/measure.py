"""Runs the program on a case in a child process with limits, and measures processor time and peak memory."""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
from dataclasses import dataclass, field

LAUNCHER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "launcher.py")


@dataclass(frozen=True)
class Case:
    """Files of a small folder, and the arguments of the command that reads them there."""

    files: dict = field(default_factory=dict)
    argv: tuple = ()

    def largest(self):
        """Size in bytes of the largest file or argument."""
        texts = list(self.files.values()) + list(self.argv)
        return max((len(text.encode("utf-8", "surrogateescape")) for text in texts), default=0)


@dataclass(frozen=True)
class Cost:
    """What a run took. `end` says how it ended: an exit code, or the name of a signal."""

    seconds: float
    mebibytes: float
    end: str
    stderr: str = ""


class Runner:
    """Runs cases one by one, each in a folder of its own."""

    def __init__(self, program, cpu_seconds, address_mebibytes, wall_seconds):
        self.program = os.path.abspath(program)
        self.cpu_seconds = cpu_seconds
        self.address_kibibytes = address_mebibytes * 1024
        self.wall_seconds = wall_seconds
        self.base = tempfile.mkdtemp(prefix="longstep-hostile-", dir=folder_in_memory())
        self.own = threading.local()

    def close(self):
        shutil.rmtree(self.base, ignore_errors=True)

    def run(self, case, cpu_seconds=None):
        """Runs a case, for so much processor time at most."""
        folder = tempfile.mkdtemp(dir=self.base)
        try:
            write_files(case.files, folder)
            return self.run_in(folder, case.argv, cpu_seconds or self.cpu_seconds)
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def run_in(self, folder, argv, cpu_seconds):
        # Sessions and caches of the person who runs the search stay out of it.
        env = {
            "PATH": os.environ.get("PATH", ""),
            "HOME": folder,
            "LONGSTEP_CACHE": os.path.join(folder, ".cache"),
            "LONGSTEP_SESSIONS": os.path.join(folder, ".sessions"),
        }
        seconds, kibibytes, code = self.launcher().ask(
            {
                "command": [self.program, *argv],
                "folder": folder,
                "env": env,
                "address_kibibytes": self.address_kibibytes,
                "cpu_seconds": cpu_seconds,
                "wall_seconds": self.wall_seconds,
            }
        )
        with open(os.path.join(folder, ".stderr"), "rb") as errors:
            text = errors.read(4000).decode("utf-8", "replace")
        end = str(code) if code >= 0 else signal.Signals(-code).name
        return Cost(seconds, kibibytes / 1024, end, text)

    def launcher(self):
        """The launcher of this thread."""
        if not hasattr(self.own, "launcher"):
            self.own.launcher = Launcher()
        return self.own.launcher


class Launcher:
    """A small process that starts the program, since what starts it counts into its peak memory."""

    def __init__(self):
        self.process = subprocess.Popen([sys.executable, "-S", "-E", LAUNCHER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8")

    def ask(self, request):
        self.process.stdin.write(json.dumps(request) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise RuntimeError("the launcher has ended")
        return json.loads(answer)


def write_files(files, folder):
    for name, text in files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
            file.write(text)


def folder_in_memory():
    """A folder that needs no disk, where the system has one."""
    return "/dev/shm" if os.path.isdir("/dev/shm") and os.access("/dev/shm", os.W_OK) else None
