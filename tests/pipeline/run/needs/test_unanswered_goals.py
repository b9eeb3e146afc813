"""Goals that a scenario sends to the controller's own server and that come to no end."""

import pytest

SERVER = """
import time
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node


class Gate(Node):
    def __init__(self):
        super().__init__("gate")
        self.goals = 0
        group = ReentrantCallbackGroup()
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/fr3_arm_controller/follow_joint_trajectory",
            callback_group=group)
        self.server = ActionServer(
            self, FollowJointTrajectory, "/cell/move", self.execute, callback_group=group)

    def execute(self, handle):
        self.goals += 1
        goal = FollowJointTrajectory.Goal(trajectory=handle.request.trajectory)
        sent = self.arm.send_goal_async(goal)
        self.wait(sent)
        result = sent.result().get_result_async()
        self.wait(result)
        handle.succeed()
        return FollowJointTrajectory.Result()

    def wait(self, future):
        while not future.done():
            time.sleep(0.05)


rclpy.init()
gate = Gate()
executor = MultiThreadedExecutor()
executor.add_node(gate)
executor.spin()
"""
GOAL = """  - action: /cell/move
    type: control_msgs/FollowJointTrajectory
    at: {at}
    goal:
      trajectory:
        joint_names: [fr3_joint1, fr3_joint2, fr3_joint3, fr3_joint4, fr3_joint5, fr3_joint6, fr3_joint7]
        points:
          - positions: [{turn}, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
            time_from_start: {{sec: 2}}
"""
CALLS = "calls:\n" + GOAL.format(at=1, turn=0.3) + GOAL.format(at=8, turn=-0.3)


@pytest.fixture
def run(example):
    def run_program(source):
        example.write("gate.py", source)
        example.write("cell.yaml", CALLS)
        arguments = ("gate.py", "--robot", "fr3", "--scenario", "cell.yaml", "--json")
        return example.run("run", *arguments).json

    return run_program


def test_goals_that_are_answered_are_no_reason(run):
    assert run(SERVER)["verdict"]["kind"] == "complete"


@pytest.mark.slow
def test_a_node_that_left_its_executor_takes_no_further_goal(run):
    body = "        rclpy.spin_until_future_complete(self, future)\n"
    start = SERVER.index("        while not future")
    source = SERVER[:start] + body + SERVER[SERVER.index("\n\nrclpy.init()") :]
    error = run(source)["error"]
    assert "goal of action /cell/move sent at 8 s was never taken by its server" in error["message"]


def test_a_server_that_nothing_spins_again_takes_none(run):
    ending = "while gate.goals < 1:\n    executor.spin_once()\ntime.sleep(6.0)\n"
    reasons = run(SERVER.replace("executor.spin()\n", ending + "time.sleep(6.0)\n"))
    found = [each["words"] for each in reasons["verdict"]["reasons"]]
    assert any("sent at 8 s was never taken by its server" in each for each in found)


def test_a_goal_whose_work_does_not_end_is_a_reason(run):
    endless = "        if self.goals == 2:\n            import threading\n            threading.Event().wait()\n"
    source = SERVER.replace("        goal = Follow", endless + "        goal = Follow")
    found = run(source)
    assert "sent at 8 s was accepted and never ended" in str(found)


def test_a_deferred_goal_that_is_never_executed_is_a_reason(run):
    source = SERVER.replace(
        "self.execute, callback_group=group)",
        "self.execute, callback_group=group,\n"
        "            handle_accepted_callback=lambda h: h.execute() if not self.goals else None)",
    )
    assert "sent at 8 s was accepted and never ended" in str(run(source))
