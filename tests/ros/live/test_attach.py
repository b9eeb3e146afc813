"""`tracerisk attach`: it hears a robot, and neither publishes nor serves anything."""

import json
import os
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tracerisk.common import trace_json
from tracerisk.ros.live.messages.modules import make_missing_modules
from tracerisk.ros.messages.ros1 import Interfaces

PROBE = Path(__file__).parents[3] / "probe"
ROBOT = """
import time
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import String

rospy.init_node("robot")
states = rospy.Publisher("/joint_states", JointState, queue_size=10)
steps = rospy.Publisher("/steps", String, queue_size=10)
while states.get_num_connections() == 0 or steps.get_num_connections() == 0:
    time.sleep(0.02)
master = rospy.client.get_master()
began, told = time.time(), []
while time.time() < began + 3.0:
    at = time.time() - began
    for name, begins in (("reach", 1.0), ("rest", 2.0)):
        if at >= begins and name not in told:
            told.append(name)
            steps.publish(name)
    message = JointState()
    message.header.stamp = rospy.Time.from_sec(began + at)
    message.name = ["panda_joint%d" % i for i in range(1, 8)]
    message.position = [0.3 * min(max(at - 1.0, 0.0), 1.0)] + [0.0] * 6
    message.velocity = [0.3 if 1.0 <= at < 2.0 else 0.0] + [0.0] * 6
    message.effort = [5.0] * 7
    states.publish(message)
    time.sleep(0.02)
print([[sorted({node for _, nodes in kind for node in nodes}) for kind in master.getSystemState()[2]]])
time.sleep(0.5)
"""


ARM = """
import threading
import time
import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory

at, target, ends = 0.0, 0.0, 0.0

def heard(message):
    global target
    target = message.points[-1].positions[0]

rospy.init_node("arm")
states = rospy.Publisher("/joint_states", JointState, queue_size=10)
rospy.Subscriber("/arm/command", JointTrajectory, heard)
step = 0.005
while not rospy.is_shutdown():
    left = min(max(target - at, -step), step)
    at += left
    message = JointState()
    message.header.stamp = rospy.Time.now()
    message.name = ["panda_joint%d" % i for i in range(1, 8)]
    message.position = [at] + [0.0] * 6
    message.velocity = [left / 0.02] + [0.0] * 6
    states.publish(message)
    time.sleep(0.02)
"""
CONTROLLER = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint


class Arm:
    def __init__(self):
        self.commands = rospy.Publisher("/arm/command", JointTrajectory, queue_size=1)
        while self.commands.get_num_connections() < 2:  # the arm, and who listens
            rospy.sleep(0.05)

    def move(self, position):
        point = JointTrajectoryPoint(positions=[position])
        self.commands.publish(JointTrajectory(joint_names=["panda_joint1"], points=[point]))
        rospy.sleep(2.0)


def reach(arm):
    arm.move(0.25)


def rest(arm):
    arm.move(0.0)


def main():
    rospy.init_node("cell")
    arm = Arm()
    reach(arm)
    rest(arm)


main()
"""


@contextmanager
def on_rospy(python: str, folder: Path, *words: str) -> Iterator[subprocess.Popen[str]]:
    """A program on real rospy, with messages that the installed ROS may lack."""
    sources = [each.encode() for each in (ROBOT, ARM, CONTROLLER)]
    make_missing_modules(Interfaces(), sources, folder / "modules")
    path = os.pathsep.join(map(str, (PROBE, folder / "modules")))
    process = subprocess.Popen(
        [python, "-s", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
    finally:
        process.terminate()
        process.communicate(timeout=30)


@pytest.mark.slow
@pytest.mark.usefixtures("master")
def test_a_robot_is_heard_by_a_node_that_only_subscribes(real_ros, tmp_path, example_in):
    example = example_in(tmp_path)
    with on_rospy(real_ros, tmp_path, "-c", ROBOT) as robot:
        done = example.run(
            *("attach", "--robot", "panda", "--names", "/steps", "--effort-unit", "Nm"),
            *("--duration", "15", "--keep", "robot.mcap", "-o", "robot.json"),
        )
        reported = robot.communicate(timeout=30)[0]
    assert done.code == 0, done.err
    (publishers, subscribers, services) = json.loads(reported.replace("'", '"'))[0]
    assert [n for n in subscribers if n.startswith("/tracerisk_attach")], subscribers
    assert not [n for n in [*publishers, *services] if n.startswith("/tracerisk_attach")]
    trace = json.loads(example.read("robot.json"))
    names = [each["ref"]["name"] for each in trace["functions"]]
    assert names == ["reach", "rest"]
    assert trace["active"]["panda_joint1"]["moving_s"] == pytest.approx(1.0, abs=0.15)
    assert any(each.startswith("lost: contacts") for each in trace["assumptions"])


@pytest.mark.slow
@pytest.mark.usefixtures("master")
def test_the_functions_of_a_controller_with_the_probe_are_heard(real_ros, tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("cell.py", CONTROLLER)
    probe = ("-m", "tracerisk_probe", "cell.py")
    with on_rospy(real_ros, tmp_path, "-c", ARM), on_rospy(real_ros, tmp_path, *probe):
        done = example.run(
            *("attach", "cell.py", "--robot", "panda", "--duration", "12", "-o", "robot.json"),
        )
    assert done.code == 0, done.err
    trace = trace_json.loads(example.read("robot.json").decode(), "robot.json")
    assert trace.controller == "cell.py"
    assert trace.assumptions[0] == (
        "measured: by robot.mcap; functions by the probe's topic /tracerisk/commands"
    )
    assert [str(each.function.name) for each in trace.visits] == ["reach", "rest"]
    for visit in trace.visits:
        moved = visit.exposures["panda_joint1"]
        assert moved is not None
        assert moved.moving_s == pytest.approx(1.0, abs=0.4)  # 50 steps of 20 ms and more


def test_a_master_that_is_not_there_is_said(real_ros, tmp_path, example_in, monkeypatch):
    del real_ros
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9/")
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    began = time.monotonic()
    done = example_in(tmp_path).run("attach", "--robot", "panda", "--duration", "2")
    assert done.code == 2
    assert "no master answers at http://127.0.0.1:9/" in " ".join(done.err.split())
    assert time.monotonic() - began < 60.0
