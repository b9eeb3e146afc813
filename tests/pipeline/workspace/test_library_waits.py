"""Controllers on a Python wrapper of MoveIt 2: how it waits decides whether a mission ends.

Three ways to wait beside an executor that a thread spins, as releases of AndrejOrsula/pymoveit2
have them: by a rate (up to 4.0), by `rclpy.spin_once` (from 4.1 on, which takes the node from its
executor), and beside it (5.0, which runs where the workspace has no other). The wrapper of these
tests is one of their own.
"""

import re

import pytest

JOINTS = (("pan", "0 0 1"), ("lift", "0 1 0"), ("elbow", "0 1 0"), ("flex", "0 1 0"))
LINK = """  <link name="{name}"><inertial><origin xyz="0 0 0.05"/><mass value="0.1"/>
    <inertia ixx="1e-4" ixy="0" ixz="0" iyy="1e-4" iyz="0" izz="1e-4"/></inertial>
    <visual><origin xyz="0 0 0.05"/><geometry><box size="0.02 0.02 0.1"/></geometry></visual></link>
"""
JOINT = """  <joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{at}"/><axis xyz="{axis}"/>
    <limit lower="{lower}" upper="1.75" effort="10" velocity="5"/></joint>
"""


def small_arm() -> str:
    """A URDF of four joints and a gripper with one moving jaw."""
    parts, parent = [LINK.format(name="base_link")], "base_link"
    for name, axis in JOINTS:
        parts.append(LINK.format(name=f"{name}_link"))
        parts.append(
            JOINT.format(
                name=name,
                parent=parent,
                child=f"{name}_link",
                at="0 0 0.1",
                axis=axis,
                lower=-1.75,
            )
        )
        parent = f"{name}_link"
    parts.append(LINK.format(name="moving_jaw_link"))
    jaw = {"name": "gripper", "child": "moving_jaw_link", "at": "0.02 0 0.1", "axis": "0 1 0"}
    parts.append(JOINT.format(parent=parent, lower=-0.17, **jaw))
    return '<robot name="small_arm">\n' + "".join(parts) + "</robot>\n"


SORTER = """\
import sys
import time
from threading import Thread

import rclpy
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.node import Node
from pymoveit2 import GripperInterface, MoveIt2

BINS = {"left": [-0.8, 0.2, 0.1, 0.8]}


class Sorter(Node):
    def __init__(self):
        super().__init__("sorter")
        group = ReentrantCallbackGroup()
        self.arm = MoveIt2(node=self, joint_names=["pan", "lift", "elbow", "flex"],
                           base_link_name="base_link", end_effector_name="flex_link",
                           group_name="arm", callback_group=group)
        self.arm.max_velocity = 0.5
        self.arm.max_acceleration = 0.5
        self.gripper = GripperInterface(
            node=self, gripper_joint_names=["gripper"], open_gripper_joint_positions=[1.2],
            closed_gripper_joint_positions=[0.1], gripper_group_name="gripper",
            callback_group=group)

    def go(self, joints):
        self.arm.move_to_configuration(joints)
        if not self.arm.wait_until_executed():
            sys.exit("the arm did not arrive")

    def settle(self):
        began = self.get_clock().now().nanoseconds
        self.gripper.wait_until_executed()
        ended = self.get_clock().now().nanoseconds
        self.get_logger().info(f"waited {(ended - began) / 1e9}")

    def pick(self):
        self.gripper.open()
        self.settle()
        self.go([0.3, 0.4, 0.2, 0.9])
        self.gripper.close()
        self.settle()

    def drop(self, side):
        self.go(BINS[side])
        self.gripper.open()
        self.settle()

    def home(self):
        self.go([0.0, -0.6, 0.6, 0.6])


def main():
    rclpy.init()
    node = Sorter()
    executor = rclpy.executors.MultiThreadedExecutor(2)
    executor.add_node(node)
    thread = Thread(target=executor.spin, daemon=True)
    thread.start()
    node.create_rate(1.0).sleep()
    node.home()
    node.pick()
    node.drop("left")
    rclpy.shutdown()
    thread.join()


main()
"""

WRAPPER = '''\
"""A small wrapper of MoveIt 2 for one arm and its gripper."""
import rclpy
from control_msgs.action import GripperCommand
from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.msg import Constraints, JointConstraint
from moveit_msgs.srv import GetMotionPlan
from rclpy.action import ActionClient
from sensor_msgs.msg import JointState


class _Motion:
    def __init__(self, node, action_type, action_name, callback_group):
        self.node = node
        self.is_requested = self.is_executing = self.succeeded = False
        self.client = ActionClient(node, action_type, action_name, callback_group=callback_group)
        self.rate = node.create_rate({frequency})

    def send(self, goal):
        self.is_requested = True
        self.client.wait_for_server(timeout_sec=1.0)
        self.client.send_goal_async(goal=goal).add_done_callback(self.answered)

    def answered(self, response):
        self.is_executing = response.result().accepted
        self.is_requested = False
        if self.is_executing:
            response.result().get_result_async().add_done_callback(self.ended)

    def ended(self, response):
        self.succeeded = response.result().status == 4
        self.is_executing = False

    def wait(self):
        {wait}

    def wait_until_executed(self):
        if not self.is_requested and not self.is_executing:
            return False
        while self.is_requested or self.is_executing:
            self.wait()
        return self.succeeded


class MoveIt2(_Motion):
    def __init__(self, node, joint_names, base_link_name, end_effector_name, group_name,
                 callback_group):
        super().__init__(node, ExecuteTrajectory, "execute_trajectory", callback_group)
        self.joint_names, self.group = joint_names, group_name
        self.state = None
        self.planner = node.create_client(
            GetMotionPlan, "plan_kinematic_path", callback_group=callback_group)
        node.create_subscription(
            JointState, "joint_states", self.take_state, 1, callback_group=callback_group)

    def take_state(self, message):
        self.state = message

    def move_to_configuration(self, positions):
        while self.state is None:
            self.wait()
        asked = GetMotionPlan.Request().motion_plan_request
        asked.group_name = self.group
        asked.start_state.joint_state = self.state
        asked.max_velocity_scaling_factor = self.max_velocity
        asked.max_acceleration_scaling_factor = self.max_acceleration
        asked.goal_constraints = [Constraints(joint_constraints=[
            JointConstraint(joint_name=name, position=position, tolerance_above=0.001,
                            tolerance_below=0.001, weight=1.0)
            for name, position in zip(self.joint_names, positions)])]
        future = self.planner.call_async(GetMotionPlan.Request(motion_plan_request=asked))
        while not future.done():
            self.wait()
        self.send(ExecuteTrajectory.Goal(trajectory=future.result().motion_plan_response.trajectory))


class GripperInterface(_Motion):
    def __init__(self, node, gripper_joint_names, open_gripper_joint_positions,
                 closed_gripper_joint_positions, gripper_group_name, callback_group):
        super().__init__(
            node, GripperCommand, "gripper_action_controller/gripper_cmd", callback_group)
        self.opened, self.closed = open_gripper_joint_positions, closed_gripper_joint_positions

    def open(self):
        self.move_to(self.opened[0])

    def close(self):
        self.move_to(self.closed[0])

    def move_to(self, position):
        goal = GripperCommand.Goal()
        goal.command.position = position
        self.send(goal)

    def wait(self):
        self.rate.sleep()
'''
WAYS = {
    "rate": "self.rate.sleep()",
    "spin_once": "rclpy.spin_once(self.node, timeout_sec=1.0)",
}
PACKAGE = "<package format='3'><name>{}</name>{}</package>\n"


def sort_with(example, way: str | None = None, sorter: str = SORTER):
    """Run the sorter on a wrapper of its workspace that waits in one way, or on the release 5.0."""
    depends = "" if way is None else "<exec_depend>pymoveit2</exec_depend>"
    example.write("src/sorter/package.xml", PACKAGE.format("sorter", depends))
    example.write("src/sorter/sorter/sorter.py", sorter)
    example.write("src/sorter/urdf/small_arm.urdf", small_arm())
    if way is not None:
        wrapper = WRAPPER.replace("{wait}", WAYS[way]).replace("{frequency}", "20.0")
        example.write("src/pymoveit2/package.xml", PACKAGE.format("pymoveit2", ""))
        example.write("src/pymoveit2/pymoveit2/__init__.py", wrapper)
    files = ("src/sorter/sorter/sorter.py", "--robot", "src/sorter/urdf/small_arm.urdf")
    return example.run("run", *files, "--json")


@pytest.fixture(scope="module")
def sorted_by(tmp_path_factory, example_in):
    """The sorter's run on the release 5.0 of the package index."""
    outcome = sort_with(example_in(tmp_path_factory.mktemp("from_index")))
    assert outcome.code == 0, outcome.err
    return outcome


def risk(outcome) -> float:
    return outcome.json["assessment"]["mission"]["failure_probability"]


def visits(outcome) -> list[tuple[str, str]]:
    return [
        (visit["function"]["name"], visit["outcome"]) for visit in outcome.json["trace"]["visits"]
    ]


def test_gripper_and_arm_in_turn_run_to_the_end_of_the_program(sorted_by):
    names = ["Sorter.home", "Sorter.pick", "Sorter.drop"]
    assert visits(sorted_by) == [(name, "succeeded") for name in names]
    assert sorted_by.json["trace"]["end"]["cause"] == "ended"


def test_a_sleep_as_long_as_each_wait_for_the_gripper_has_the_same_risk(sorted_by, example):
    waits = [float(each) for each in re.findall(r"waited ([\d.]+)", sorted_by.err)]
    assert len(waits) == 3
    assert sum(waits) > 5.0
    sleeping = SORTER.replace(
        "self.gripper.wait_until_executed()", "time.sleep(WAITS.pop(0))"
    ).replace("BINS =", f"WAITS = {waits}\nBINS =")
    assert sleeping != SORTER
    outcome = sort_with(example, sorter=sleeping)
    assert outcome.code == 0, outcome.err
    assert visits(outcome) == visits(sorted_by)
    assert risk(outcome) == pytest.approx(risk(sorted_by), rel=0.01)


# `tests/ros/stand_ins/rclpy/test_rclpy_background.py` waits by a rate; that a wait costs what it lasts is above.
@pytest.mark.slow
def test_a_wrapper_of_the_workspace_that_waits_by_a_rate_has_the_same_risk(sorted_by, example):
    outcome = sort_with(example, "rate")
    assert outcome.code == 0, outcome.err
    assert visits(outcome) == visits(sorted_by)
    assert risk(outcome) == pytest.approx(risk(sorted_by), rel=0.01)


def test_a_wrapper_that_takes_the_node_from_its_executor_gets_no_figure(example):
    """The gripper's rate never beats again, as with the real rclpy."""
    before = SORTER.encode()
    outcome = sort_with(example, "spin_once")
    assert outcome.code == 4, outcome.out
    assert re.search(
        r"nothing spins node /sorter since the call at __init__\.py:\d+ took it from the "
        r"MultiThreadedExecutor that a thread spins",
        outcome.err,
    )
    assert example.read("src/sorter/sorter/sorter.py") == before
