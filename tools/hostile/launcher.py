"""Starts the program for measure.py, from a process that stays small.

A process passes the most memory that it ever held on to what it starts, also over exec: measured as a child of the
search itself, everything would seem to need what the search needs. Reads one request a line, answers with one line, and
ends with its input.
"""

import json
import os
import signal
import subprocess
import sys
import threading

# The shell sets the limits in the child itself: address space in KiB, processor time in seconds, files in KiB.
LIMITED = 'ulimit -v "$1"; ulimit -t "$2"; ulimit -f 262144; ulimit -c 0; shift 2; exec "$@"'


def run(request):
    """Runs `command` in `folder` and returns [processor time in seconds, peak memory in KiB, exit status as of wait]."""
    limits = [str(request["address_kibibytes"]), str(request["cpu_seconds"])]
    with open(os.path.join(request["folder"], ".stderr"), "wb") as errors:
        child = subprocess.Popen(
            ["/bin/sh", "-c", LIMITED, "sh", *limits, *request["command"]],
            cwd=request["folder"],
            env=request["env"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            start_new_session=True,
        )
        # A child that sleeps spends no processor time.
        timer = threading.Timer(request["wall_seconds"], end_group, [child.pid])
        timer.start()
        _, status, usage = os.wait4(child.pid, 0)
        timer.cancel()
        child.returncode = os.waitstatus_to_exitcode(status)
    return [usage.ru_utime + usage.ru_stime, usage.ru_maxrss, child.returncode]


def end_group(pid):
    """Ends a child and its children."""
    try:
        os.killpg(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass


if __name__ == "__main__":
    # Ctrl-C is for the search, which then closes the input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    for line in sys.stdin:
        print(json.dumps(run(json.loads(line))), flush=True)
