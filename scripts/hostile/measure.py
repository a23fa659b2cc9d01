"""Runs the program on a case in a child process with limits, and measures processor time and peak memory."""

import os
import shutil
import signal
import subprocess
import tempfile
import threading
from dataclasses import dataclass, field

# The shell sets the limits in the child itself: address space in KiB, processor time in seconds, files in KiB.
LIMITED = 'ulimit -v "$1"; ulimit -t "$2"; ulimit -f 262144; ulimit -c 0; shift 2; exec "$@"'


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
        limits = [str(self.address_kibibytes), str(cpu_seconds)]
        command = ["/bin/sh", "-c", LIMITED, "sh", *limits, self.program, *argv]
        with open(os.path.join(folder, ".stderr"), "w+b") as errors:
            child = subprocess.Popen(
                command,
                cwd=folder,
                env=env,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=errors,
                start_new_session=True,
            )
            # A child that sleeps spends no processor time.
            timer = threading.Timer(self.wall_seconds, end_group, [child.pid])
            timer.start()
            _, status, usage = os.wait4(child.pid, 0)
            timer.cancel()
            child.returncode = os.waitstatus_to_exitcode(status)
            errors.seek(0)
            text = errors.read(4000).decode("utf-8", "replace")
        code = child.returncode
        end = str(code) if code >= 0 else signal.Signals(-code).name
        return Cost(usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, end, text)


def end_group(pid):
    """Ends a child and its children."""
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


def write_files(files, folder):
    for name, text in files.items():
        path = os.path.join(folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="utf-8", errors="surrogateescape", newline="") as file:
            file.write(text)


def folder_in_memory():
    """A folder that needs no disk, where the system has one."""
    return "/dev/shm" if os.path.isdir("/dev/shm") and os.access("/dev/shm", os.W_OK) else None
