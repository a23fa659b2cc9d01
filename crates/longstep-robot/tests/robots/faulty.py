"""A robot with one fault, which the first argument names. Writes what it receives to the file in the second."""

import json
import os
import subprocess
import sys
import time

fault, log = sys.argv[1], open(sys.argv[2], "a", buffering=1)


# The orders that fail when the robot is next asked what it observes: until then they are being carried out.
slipping = []


def write(text):
    sys.stdout.write(text)
    sys.stdout.flush()


def send(**message):
    write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")


def hang():
    while True:
        time.sleep(1)


def perform(id):
    """Answers the first order with the fault."""
    if fault == "dies":
        print("the gripper is on fire", file=sys.stderr)
        os._exit(3)
    elif fault == "is killed":
        os.kill(os.getpid(), 9)
    elif fault == "hangs":
        hang()
    elif fault == "hangs with children":
        child = subprocess.Popen(["sleep", "1000"])
        print(child.pid, file=log)
        hang()
    elif fault == "leaves a child":
        child = subprocess.Popen(["sleep", "1000"])
        print(child.pid, file=log)
        os._exit(0)
    elif fault == "closes its output":
        os.close(1)
        hang()
    elif fault == "ignores stop":
        pass
    elif fault == "writes text":
        write("moving...\n")
    elif fault == "answers twice":
        send(id=id, result={})
        send(id=id, result={})
    elif fault == "answers another request":
        send(id=id + 7, result={})
    elif fault == "reports after the end":
        send(id=id, result={})
        send(method="feedback", params={"id": id})
    elif fault == "does not understand":
        send(id=id, error={"code": -32601, "message": "no such method"})
    elif fault == "senses without order":
        send(id=id, result={"outcome": "(expired <milk>)"})
    elif fault == "sends a request":
        send(id=1, method="perform", params={})
    elif fault == "writes a line without end":
        while True:
            write("x" * 65536)
    elif fault == "writes lines without end":
        while True:
            send(method="feedback", params={"id": id, "text": "x" * 1000})
    elif fault == "floods standard error":
        for _ in range(2000):
            sys.stderr.write("y" * 1000 + "\n")
        sys.stderr.write("the last line\n")
        os._exit(4)
    elif fault == "reports much":
        for count in range(100):
            send(method="feedback", params={"id": id, "fraction": count / 100, "text": str(count)})
        send(id=id, result={})
    elif fault == "slips":
        slipping.append(id)
    else:
        send(id=id, result={})


for line in sys.stdin:
    message = json.loads(line)
    print(message["method"], file=log)
    id, method = message["id"], message["method"]
    if method == "initialize":
        if fault == "never initializes":
            hang()
        elif fault == "speaks version 2":
            send(id=id, result={"protocol": 2, "name": "faulty"})
        else:
            timeouts = {"perform": 60 if "stop" in fault or fault == "none" else 2, "stop": 1, "observe": 1}
            send(id=id, result={"protocol": 1, "name": "faulty", "timeouts": timeouts, "capabilities": {"observe": True}})
    elif method == "perform":
        perform(id)
    elif method == "observe":
        if fault == "does not observe":
            hang()
        elif fault == "observes nonsense":
            send(id=id, result={"states": {"<cup>": 3}})
        elif fault == "cannot see":
            send(id=id, error={"code": 2, "message": "the camera is covered"})
        else:
            for order in slipping:
                send(id=order, error={"code": 1, "message": "the can slipped"})
            slipping.clear()
            send(id=id, result={"states": {"<cup>": "on_something(<table>)"}})
    elif method == "stop" and fault == "ignores stop":
        pass
    else:
        send(id=id, result={})
