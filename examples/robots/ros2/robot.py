"""A robot of the domain `household` in ROS 2, whose world is in its memory: robot.py ENVIRONMENT.json (docs/guide/ros2.md)"""
import json, sys, time
import rclpy
from rclpy.action import ActionServer, CancelResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import UInt64
from longstep_msgs.action import ExecuteStep
from longstep_msgs.msg import EntityStates
from longstep_msgs.srv import Observe

class Robot(Node):
    def __init__(self, environment):
        super().__init__("robot")
        self.heard, group = 0.0, ReentrantCallbackGroup()
        written = {**environment.get("asset_states", {}), **environment["object_states"]}
        self.states = {name: [words] if isinstance(words, str) else words for name, words in written.items()}
        self.create_subscription(UInt64, "longstep/heartbeat", self.hear, 1, callback_group=group)
        self.create_service(Observe, "observe", self.observe, callback_group=group)
        self.server = ActionServer(self, ExecuteStep, "execute_step", self.execute, callback_group=group,
                                   cancel_callback=lambda goal: CancelResponse.ACCEPT)

    def hear(self, beat):
        self.heard = time.monotonic()

    def execute(self, handle):
        goal = handle.request
        for tenth in range(1, 11):  # move a little; stand still if told so, and if Longstep is not heard any more
            time.sleep(0.02)
            if handle.is_cancel_requested:
                handle.canceled()
                return ExecuteStep.Result(message="cancelled")
            if time.monotonic() - self.heard > 2:
                handle.abort()
                return ExecuteStep.Result(message="no heartbeat for 2 s")
            handle.publish_feedback(ExecuteStep.Feedback(progress=tenth / 10))
        self.change(goal.action, *goal.arguments)
        handle.succeed()
        return ExecuteStep.Result(success=True)

    def change(self, action, item, place=""):
        inside = f"{place[:-1]}_handle>" in self.states or "bin" in place
        words = {"grasp": [*self.states.get(item, []), "inside_hand()"], "detach": ["inside_hand()"],
                 "attach": [f"{'inside' if inside else 'on'}_something({place})", "inside_hand()"],
                 "release": [word for word in self.states.get(item, []) if word != "inside_hand()"],
                 "open-by-rotate": ["open()", "inside_hand()"], "close-by-rotate": ["closed()", "inside_hand()"]}
        self.states[item] = words.get(action, self.states.get(item, []))

    def observe(self, request, response):
        response.states = [EntityStates(entity=name, statements=words) for name, words in self.states.items()]
        return response

def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        environment = json.load(file)
    rclpy.init()
    executor = MultiThreadedExecutor(4)
    executor.add_node(Robot(environment.get("environment", environment)))
    print("ready", flush=True)
    executor.spin()

if __name__ == "__main__":
    main()
