"""The lines that read joint states, which a world names that lists the joints otherwise."""

from pathlib import Path

import pytest

from tracerisk.common.worlds.world import world_named
from tracerisk.pipeline.evidence.cell_runs import nominal_of
from tracerisk.pipeline.worlds.world_runs import in_world
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.world.state_reads import StateReads

BY_PLACE = "without the names of its joints"
READERS = {
    "by_index": ("def read(msg):\n    return msg.position[2]\n", 2, True),
    "by_slice": ("def read(msg):\n    pan, lift = msg.position[:2]\n    return pan\n", 2, True),
    "as_a_whole": ("def read(msg):\n    kept = msg\n    return sum(kept.position)\n", 3, True),
    "by_name": (
        "def read(msg):\n    names = list(msg.name)\n    return msg.position[names.index('b')]\n",
        3,
        False,
    ),
}


def message(interfaces):
    """The class of joint states, made anew, with a message of three joints."""
    kind = interfaces.message("sensor_msgs/JointState")
    made = kind()
    made.name, made.position = ["a", "b", "c"], [0.1, 0.2, 0.3]
    return kind, made


@pytest.mark.parametrize("interfaces", [Interfaces, Interfaces2])
@pytest.mark.parametrize("reader", READERS)
def test_a_line_that_reads_values_is_noted(tmp_path, interfaces, reader):
    text, line, is_by_place = READERS[reader]
    kind, made = message(interfaces())
    reads = StateReads(kind)
    names = {}
    exec(compile(text, str(tmp_path / "cell" / "reach.py"), "exec"), names)
    names["read"](made)
    ((words, file, found),) = reads.places_in(tmp_path)
    assert (file, found) == ("cell/reach.py", line)
    assert ("position" in words, BY_PLACE in words) == (True, is_by_place)


@pytest.mark.parametrize("interfaces", [Interfaces, Interfaces2])
def test_the_message_is_the_same_while_it_is_watched(interfaces):
    kind, made = message(interfaces())
    StateReads(kind)
    assert (list(made.name), list(made.position)) == (["a", "b", "c"], [0.1, 0.2, 0.3])
    made.velocity = [1.0]
    assert list(made.velocity) == [1.0]
    assert made == made
    assert "0.2" in repr(made)


def test_a_function_without_names_comes_first(tmp_path):
    kind, made = message(Interfaces())
    reads = StateReads(kind)
    for number, reader in enumerate(("by_name", "by_index")):
        names = {}
        exec(compile(READERS[reader][0], str(tmp_path / f"{number}.py"), "exec"), names)
        names["read"](made)
    assert [file for _, file, _ in reads.places_in(tmp_path)] == ["1.py", "0.py"]


def test_what_a_library_reads_is_not_the_controllers(tmp_path):
    kind, made = message(Interfaces())
    reads = StateReads(kind)
    assert list(made.position)
    assert reads.places_in(tmp_path) == []


TURNED = """\
import rclpy
from control_msgs.action import FollowJointTrajectory
from builtin_interfaces.msg import Duration
from rclpy.action import ActionClient
from rclpy.wait_for_message import wait_for_message
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["elbow_joint", "shoulder_lift_joint", "shoulder_pan_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]

rclpy.init()
node = rclpy.create_node("turn")
client = ActionClient(
    node, FollowJointTrajectory, "/scaled_joint_trajectory_controller/follow_joint_trajectory")
client.wait_for_server()
_, state = wait_for_message(JointState, node, "/joint_states", time_to_wait=5.0)
now = READ
goal = FollowJointTrajectory.Goal()
goal.trajectory.joint_names = JOINTS
goal.trajectory.points = [
    JointTrajectoryPoint(positions=[*now[:2], now[2] + 0.4, *now[3:]], time_from_start=Duration(sec=3))]
sent = client.send_goal_async(goal)
rclpy.spin_until_future_complete(node, sent)
rclpy.spin_until_future_complete(node, sent.result().get_result_async())
"""
SETTINGS = '[tool.tracerisk]\nrobot = "ur5e"\nros_distro = "jazzy"\n'


@pytest.mark.parametrize(
    ("read", "line"),
    [
        ("list(state.position)", 18),
        ("[dict(zip(state.name, state.position))[name] for name in JOINTS]", None),
    ],
)
def test_a_world_names_the_line_that_reads_by_place(tmp_path, read, line):
    path = tmp_path / "turn.py"
    path.write_text(TURNED.replace("READ", read), encoding="utf-8")
    Path(tmp_path, "pyproject.toml").write_text(SETTINGS, encoding="utf-8")
    run = in_world(nominal_of(str(path), ()), world_named("joints-rotated"))
    assert run.depends == (line is not None)
    assert (run.location and run.location.line) == line
    assert (BY_PLACE in run.cause) == run.depends
    assert run.changed == "joint states list the last joint first"
