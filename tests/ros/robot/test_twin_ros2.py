"""The twin's interfaces with message classes of ROS 2, whatever client library sends them."""

import pytest

from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.graph import Graph
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.messages.ros2 import Interfaces2, copy_message
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.twin_interfaces import TwinInterfaces
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.simulation.twin import Twin

SECOND = 1_000_000_000
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


@pytest.fixture
def robot():
    """A run on the Panda with ROS 2 messages: runtime, interfaces, and how to run a function."""
    panda = load_robot("panda")
    twin = Twin.build(panda, load_scene("tube_racks"))
    scheduler = Scheduler(twin, duration_ns=60 * SECOND)
    interfaces = Interfaces2()
    runtime = Runtime(scheduler, Graph(scheduler), twin)
    TwinInterfaces(runtime, interfaces)
    return runtime, interfaces, scheduler


def trajectory(interfaces, seconds=1):
    message = interfaces.message("trajectory_msgs/JointTrajectory")(joint_names=JOINTS)
    point = interfaces.message("trajectory_msgs/JointTrajectoryPoint")(positions=READY)
    point.time_from_start.sec = seconds
    message.points = [point]
    return message


def pursue(robot, name, type_name, goal):
    runtime, _, scheduler = robot
    client = runtime.client(Actions).client(name, type_name, node="/n", copy=copy_message)
    feedback = []

    def main():
        sent = client.send(goal, on_feedback=lambda _, each: feedback.append(copy_message(each)))
        scheduler.wait_until(lambda: sent.state.is_terminal, reason="the result")
        return sent

    return scheduler.run_main(main), feedback


def test_a_trajectory_is_followed(robot):
    interfaces = robot[1]
    kind = interfaces.action("control_msgs/FollowJointTrajectory")
    goal = kind.Goal(trajectory=trajectory(interfaces))
    sent, feedback = pursue(robot, "/arm/fjt", "control_msgs/FollowJointTrajectory", goal)
    assert sent.state.ros2_status == 4
    assert sent.result.error_code == kind.Result.SUCCESSFUL
    assert list(feedback[5].joint_names) == JOINTS
    assert feedback[5].header.stamp.sec > 0


def test_a_new_goal_aborts_the_one_before(robot):
    """ros2_controllers, joint_trajectory_controller.cpp of Jazzy, `preempt_active_goal`."""
    runtime, interfaces, scheduler = robot
    name, kind = "/arm/fjt", "control_msgs/FollowJointTrajectory"
    goal = interfaces.action(kind).Goal(trajectory=trajectory(interfaces, seconds=3))
    client = runtime.client(Actions).client(name, kind, node="/n", copy=copy_message)

    def main():
        first = client.send(goal)
        scheduler.sleep(SECOND)
        second = client.send(goal)
        scheduler.wait_until(lambda: second.state.is_terminal, reason="the result")
        return first.state.ros2_status, second.state.ros2_status

    assert scheduler.run_main(main) == (6, 4)


def test_a_gripper_is_driven(robot):
    kind = robot[1].action("control_msgs/GripperCommand")
    goal = kind.Goal()
    goal.command.position = 0.02
    sent, _ = pursue(robot, "/hand/gripper_cmd", "control_msgs/GripperCommand", goal)
    assert sent.result.reached_goal
    assert sent.result.position == pytest.approx(0.02, abs=0.001)


def test_a_parallel_gripper_is_driven_by_one_position(robot):
    name = "control_msgs/ParallelGripperCommand"
    goal = robot[1].action(name).Goal()
    goal.command.name, goal.command.position = ["panda_finger_joint1"], [0.02]
    sent, _ = pursue(robot, "/hand/gripper_cmd", name, goal)
    assert sent.result.reached_goal
    assert list(sent.result.state.position) == pytest.approx([0.02], abs=0.001)


def test_a_parallel_gripper_takes_no_goal_of_several_positions(robot):
    name = "control_msgs/ParallelGripperCommand"
    goal = robot[1].action(name).Goal()
    goal.command.position = [0.02, 0.02]
    sent, _ = pursue(robot, "/hand/gripper_cmd", name, goal)
    assert sent.state.name == "REJECTED"


GRIPPERS = """\
controller_manager:
  ros__parameters:
    hand: {type: TYPE}
hand:
  ros__parameters: {joint: panda_finger_joint1SETTINGS}
"""


@pytest.mark.slow(but=12)
@pytest.mark.parametrize("distro", ["noetic", "humble", "jazzy"])
@pytest.mark.parametrize("kind", ["GripperCommand", "ParallelGripperCommand"])
@pytest.mark.parametrize(
    ("settings", "position", "expected"),
    [
        # position, then status, reached_goal and stalled
        ("", 0.02, (4, True, False)),
        ("", 0.06, (6, False, True)),
        (", allow_stalling: true", 0.06, (4, False, True)),
        (", goal_tolerance: 0.03", 0.06, (4, True, False)),
        (None, 0.06, (4, True, False)),
    ],
)
def test_gripper(kind, distro, settings, position, expected, tmp_path):
    """Fingers that stop short of their goal, here at their end, fail a gripper controller."""
    if settings is not None:
        name = "parallel_gripper_action_controller" if "Par" in kind else "position_controllers"
        text = GRIPPERS.replace("TYPE", f"{name}/GripperActionController")
        (tmp_path / "controllers.yaml").write_text(text.replace("SETTINGS", settings))
    cell = _cell(tmp_path, distro)
    goal = cell[1].action(f"control_msgs/{kind}").Goal()
    goal.command.position = position if kind == "GripperCommand" else [position]
    sent, _ = pursue(cell, "/hand/gripper_cmd", f"control_msgs/{kind}", goal)
    result = sent.result
    assert (sent.state.ros2_status, result.reached_goal, result.stalled) == expected


def _cell(folder, distro):
    twin = Twin.build(load_robot("panda"), load_scene("empty"))
    scheduler = Scheduler(twin, duration_ns=60 * SECOND)
    runtime = Runtime(
        scheduler, Graph(scheduler), twin, packages={"cell": folder}, distro=DistroRules(distro)
    )
    interfaces = Interfaces2()
    TwinInterfaces(runtime, interfaces)
    return runtime, interfaces, scheduler


@pytest.mark.parametrize("controllers", ["position_controllers", "effort_controllers"])
def test_a_gripper_of_positions_heeds_no_effort(controllers, tmp_path):
    text = GRIPPERS.replace("TYPE", f"{controllers}/GripperActionController")
    (tmp_path / "controllers.yaml").write_text(text.replace("SETTINGS", ""))
    cell = _cell(tmp_path, "humble")
    goal = cell[1].action("control_msgs/GripperCommand").Goal()
    goal.command.position, goal.command.max_effort = 0.03, 0.002
    sent, _ = pursue(cell, "/hand/gripper_cmd", "control_msgs/GripperCommand", goal)
    is_moved = sent.result.position == pytest.approx(0.03, abs=0.001)
    assert is_moved is (controllers == "position_controllers")


@pytest.mark.parametrize("position", [float("nan"), float("inf")])
def test_a_gripper_goes_nowhere_that_is_not_finite(robot, position):
    goal = robot[1].action("control_msgs/GripperCommand").Goal()
    goal.command.position = position
    sent, _ = pursue(robot, "/hand/gripper_cmd", "control_msgs/GripperCommand", goal)
    assert sent.state.name == "REJECTED"


def test_a_goal_with_unknown_joints_is_rejected(robot):
    interfaces = robot[1]
    goal = interfaces.action("control_msgs/FollowJointTrajectory").Goal()
    goal.trajectory.joint_names = ["elbow"]
    sent, _ = pursue(robot, "/arm/fjt", "control_msgs/FollowJointTrajectory", goal)
    assert (sent.state.name, sent.result.error_code) == ("REJECTED", -2)


def test_command_topics_move_the_joints(robot):
    runtime, interfaces, scheduler = robot
    many = interfaces.message("std_msgs/Float64MultiArray")

    def main():
        group = runtime.graph.advertise("/x/commands", "std_msgs/Float64MultiArray", node="/n")
        group.publish(many(data=[0.1, *READY[1:]]))
        scheduler.sleep(2 * SECOND)
        first = runtime.twin.joint_state().position[0]
        topic = "/arm_controller/joint_trajectory"
        arm = runtime.graph.advertise(topic, "trajectory_msgs/JointTrajectory", node="/n")
        arm.publish(trajectory(interfaces))
        scheduler.sleep(2 * SECOND)
        return first, runtime.twin.joint_state().position[0]

    first, second = scheduler.run_main(main)
    assert first == pytest.approx(0.1, abs=0.005)
    assert second == pytest.approx(0.0, abs=0.005)
