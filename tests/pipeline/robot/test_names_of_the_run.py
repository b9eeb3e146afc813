"""Joints whose names no source tells, for the controller puts them together as it runs."""

SOURCE = """\
import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint


class Mover(Node):
    def __init__(self):
        super().__init__("mover")
        self.client = ActionClient(self, FollowJointTrajectory, "follow_joint_trajectory")
        self.client.wait_for_server()

    def move(self, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = [f"PREFIX{i + 1}" for i in range(len(positions))]
        point = JointTrajectoryPoint(positions=positions)
        point.time_from_start.sec = 2
        goal.trajectory.points = [point]
        sent = self.client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        rclpy.spin_until_future_complete(self, sent.result().get_result_async())


rclpy.init()
Mover().move([0.3] * 7)
"""


def test_a_stand_in_arm_gets_the_joints_that_the_run_moves(example):
    example.write("c.py", SOURCE.replace("PREFIX", "axis_"))
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    trace = outcome.json["trace"]
    assert trace["robot"] == "generic"
    joints = {each["name"] for each in trace["elements"] if each["kind"] == "joint"}
    moved = {name for name, used in trace["active"].items() if used["active_s"] > 0.5}
    assert moved & joints == {f"axis_{i}" for i in range(1, 8)}


def test_a_shipped_arm_is_reported_by_them(example):
    example.write("c.py", SOURCE.replace("PREFIX", "panda_joint"))
    outcome = example.run("run", "c.py", "--json")
    # Its fourth joint cannot reach 0.3 rad, so the goal is aborted and the run is faulted.
    assert outcome.code == 1, outcome.err
    (reason,) = outcome.json["trace"]["verdict"]["reasons"]
    assert "joint 'panda_joint4' is" in reason["words"]
    assert outcome.json["trace"]["robot"] == "panda"


def test_a_robot_that_is_named_stays(example):
    example.write("c.py", SOURCE.replace("PREFIX", "panda_joint"))
    outcome = example.run("run", "c.py", "--json", "--robot", "ur5e", "--no-draft")
    assert outcome.code == 4
    assert "no joint 'panda_joint1'" in outcome.err
