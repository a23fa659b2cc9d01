"""A node of ROS 2 that talks to a Longstep server: commands on stdin, one JSON object a line, and results on stdout.

    {"do": "ask", "kind": "say", "request": {...}}      publishes a request, waits for its response
    {"do": "call", "kind": "say", "request": {...}}     the same through a service
    {"do": "see", "topic": "plan", "with": {...}}       waits for a message with these fields
    {"do": "late", "topic": "plan", "with": {...}}      a subscriber that comes late waits for a message with these fields
    {"do": "count", "topic": "progress"}                the number of messages until now
"""

import json
import sys
import threading
import time

import rclpy
from longstep_msgs.srv import Ask
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from std_msgs.msg import String

LONGEST = 40.0
LATCHED = QoSProfile(depth=50, durability=DurabilityPolicy.TRANSIENT_LOCAL, reliability=ReliabilityPolicy.RELIABLE)
PLAIN = QoSProfile(depth=50)


def fits(message, fields):
    """True if a message has these fields; those of an object inside may be some of its fields too."""
    if not isinstance(fields, dict):
        return message == fields
    return isinstance(message, dict) and all(key in message and fits(message[key], value) for key, value in fields.items())


class Caller:
    def __init__(self, namespace):
        self.node = rclpy.create_node("caller")
        self.namespace = namespace
        self.news = threading.Condition()
        self.seen = {name: [] for name in ("plan", "progress", "world", "say/response", "execute/response")}
        for name in self.seen:
            self.node.create_subscription(String, f"{namespace}/{name}", self.keeper(self.seen[name]), LATCHED)
        self.requests = {kind: self.node.create_publisher(String, f"{namespace}/{kind}/request", PLAIN)
                         for kind in ("say", "execute")}
        self.number = 0

    def keeper(self, messages):
        def keep(message):
            with self.news:
                messages.append(json.loads(message.data))
                self.news.notify_all()
        return keep

    def wait(self, found):
        """Waits until `found` returns something."""
        deadline = time.monotonic() + LONGEST
        with self.news:
            while (result := found()) is None:
                if not self.news.wait(timeout=max(0.0, deadline - time.monotonic())):
                    return {"timeout": True}
            return result

    def see(self, topic, fields):
        def found():
            return next((own for own in reversed(self.seen[topic]) if fits(own, fields)), None)
        return self.wait(found)

    def ask(self, kind, request):
        # Without a subscriber on the other side a request would be lost. It may know of this publisher a moment later.
        deadline = time.monotonic() + LONGEST
        while self.requests[kind].get_subscription_count() == 0:
            if time.monotonic() > deadline:
                return {"timeout": True}
            time.sleep(0.02)
        time.sleep(0.5)
        self.number += 1
        own = {"id": self.number, **request}
        self.requests[kind].publish(String(data=json.dumps(own)))
        return self.see(f"{kind}/response", {"id": self.number})

    def call(self, kind, request):
        client = self.node.create_client(Ask, f"{self.namespace}/{kind}")
        if not client.wait_for_service(timeout_sec=LONGEST):
            return {"timeout": True}
        ended = threading.Event()
        future = client.call_async(Ask.Request(request=json.dumps(request)))
        future.add_done_callback(lambda _: ended.set())
        if not ended.wait(LONGEST):
            return {"timeout": True}
        return json.loads(future.result().response)

    def late(self, topic, fields):
        # A bridge may keep more than the last message; then the earlier ones come first.
        messages = []
        subscription = self.node.create_subscription(String, f"{self.namespace}/{topic}", self.keeper(messages), LATCHED)
        found = self.wait(lambda: next((own for own in messages if fits(own, fields)), None))
        self.node.destroy_subscription(subscription)
        return found

    def do(self, command):
        match command["do"]:
            case "ask":
                return self.ask(command["kind"], command["request"])
            case "call":
                return self.call(command["kind"], command["request"])
            case "see":
                return self.see(command["topic"], command["with"])
            case "late":
                return self.late(command["topic"], command["with"])
            case "count":
                return {"count": len(self.seen[command["topic"]])}


def main():
    rclpy.init()
    caller = Caller(sys.argv[1])
    executor = SingleThreadedExecutor()
    executor.add_node(caller.node)
    threading.Thread(target=executor.spin, daemon=True).start()
    print("ready", flush=True)
    for line in sys.stdin:
        print(json.dumps(caller.do(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
