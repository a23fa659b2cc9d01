"""The robot of examples/robots/ros2 with faults, a journal, a world that outlives it, and a second arm.

ros2_robot.py ENVIRONMENT.json FOLDER [STEP=FAULT ...] [arms]

FOLDER/journal gets a line for each event. FOLDER/world.json has the states and the steps that were done, which change together.
Faults: `abort` (the thing falls to the floor),
`reject`, `hang` (until cancelled), `slow` (half a second), `cancel` (somebody at the robot stops it), `outlive` (until cancelled,
half a second after that, whether Longstep is heard or not), `stubborn` (three seconds, whatever is cancelled).
"""
import json, os, sys, threading, time

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../../../examples/robots/ros2"))
import rclpy
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from longstep_msgs.action import ExecuteStep
from robot import Robot

class FaultyRobot(Robot):
    def __init__(self, environment, folder, faults, arms):
        super().__init__(environment)
        self.faults, self.arms, self.journal_lock, self.performed = faults, arms, threading.Lock(), []
        self.journal_file = open(os.path.join(folder, "journal"), "a", buffering=1, encoding="utf-8")
        self.world_file = os.path.join(folder, "world.json")
        if os.path.exists(self.world_file):
            with open(self.world_file, encoding="utf-8") as file:
                world = json.load(file)
                self.states, self.performed = world["states"], world["performed"]
        self.server.destroy()
        self.stubborn = set()
        names = ["left/execute_step", "right/execute_step"] if arms else ["execute_step"]
        self.servers = [ActionServer(self, ExecuteStep, name, self.execute, callback_group=ReentrantCallbackGroup(),
                                     goal_callback=self.judge, cancel_callback=self.judge_cancellation)
                        for name in names]

    def journal(self, event, goal):
        with self.journal_lock:
            self.journal_file.write(f"{event} {goal.step} {goal.action}({', '.join(goal.arguments)})\n")

    def judge(self, goal):
        if self.faults.get(goal.step) == "reject":
            self.journal("rejected", goal)
            return GoalResponse.REJECT
        return GoalResponse.ACCEPT

    def judge_cancellation(self, handle):
        return CancelResponse.REJECT if handle.request.step in self.stubborn else CancelResponse.ACCEPT

    def end(self, handle, how, message):
        getattr(handle, {"aborted": "abort", "cancelled": "canceled"}[how])()
        self.journal(how, handle.request)
        return ExecuteStep.Result(message=message)

    def execute(self, handle):
        goal = handle.request
        self.journal("begun", goal)
        fault = self.faults.pop(goal.step, None)
        ticks = {"hang": 10_000, "outlive": 10_000, "stubborn": 300, "slow": 50}.get(fault, 3)
        if fault == "stubborn":
            self.stubborn.add(goal.step)
        for tick in range(ticks):
            time.sleep(0.01)
            if handle.is_cancel_requested:
                time.sleep(0.5 if fault == "outlive" else 0)
                return self.end(handle, "cancelled", "cancelled")
            if fault not in ("outlive", "stubborn") and time.monotonic() - self.heard > 2:
                return self.end(handle, "aborted", "no heartbeat for 2 s")
            if fault == "abort":
                self.states[goal.arguments[-1]] = ["on_something(<floor>)"]
                self.keep()
                return self.end(handle, "aborted", "it slipped")
            handle.publish_feedback(ExecuteStep.Feedback(progress=(tick + 1) / ticks, text="moving"))
        self.change(goal.action, *goal.arguments)
        self.keep(f"{goal.step} {goal.action}({', '.join(goal.arguments)})")
        self.journal("done", goal)
        handle.succeed()
        return ExecuteStep.Result(success=True)

    def keep(self, *performed):
        with self.journal_lock:
            self.performed += performed
            with open(self.world_file + ".new", "w", encoding="utf-8") as file:
                json.dump({"states": self.states, "performed": self.performed}, file)
            os.replace(self.world_file + ".new", self.world_file)

    def change(self, action, *arguments):
        if not self.arms:
            return super().change(action, *arguments)
        hand, item, *place = arguments
        held = f"inside_hand({hand})"
        words = self.states.get(item, [])
        if action == "attach":
            self.states[item] = [f"on_something({place[0]})", held]
        elif action == "detach":
            self.states[item] = [held]
        elif action in ("grasp", "release"):
            self.states[item] = [word for word in words if word != held] + [held] * (action == "grasp")

def main():
    environment_file, folder, *options = sys.argv[1:]
    with open(environment_file, encoding="utf-8") as file:
        environment = json.load(file)
    pairs = [option.split("=") for option in options if "=" in option]
    rclpy.init()
    executor = MultiThreadedExecutor(6)
    executor.add_node(FaultyRobot(environment.get("environment", environment), folder,
                                  {int(step): fault for step, fault in pairs}, "arms" in options))
    print("ready", flush=True)
    executor.spin()

main()
