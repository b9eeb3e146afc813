"""`tracerisk attach`: it hears a robot, and neither publishes nor serves anything."""

from __future__ import annotations

import json
import os
import subprocess
import threading
import time

import pytest

from tracerisk.ros.live.loopback import loopback_environment
from tracerisk.ros.live.session import Session

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


@pytest.mark.slow
def test_a_robot_is_heard_by_a_node_that_only_subscribes(real_ros, tmp_path, example_in):
    example = example_in(tmp_path)
    session = Session(os.environ)
    is_over = threading.Event()

    def serve() -> None:
        while not is_over.wait(0.01):
            session.settle()

    serving = threading.Thread(target=serve)
    serving.start()
    robot = subprocess.Popen(
        [real_ros, "-s", "-c", ROBOT],
        env=loopback_environment(os.environ, session.master),
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        with pytest.MonkeyPatch.context() as patch:
            for name, value in loopback_environment({}, session.master).items():
                patch.setenv(name, value)
            done = example.run(
                *("attach", "--robot", "panda", "--names", "/steps", "--effort-unit", "Nm"),
                *("--duration", "15", "--keep", "robot.mcap", "-o", "robot.json"),
            )
        reported = robot.communicate(timeout=30)[0]
    finally:
        robot.kill()
        is_over.set()
        serving.join()
        session.close()
    assert done.code == 0, done.err
    (publishers, subscribers, services) = json.loads(reported.replace("'", '"'))[0]
    assert [n for n in subscribers if n.startswith("/tracerisk_attach")], subscribers
    assert not [n for n in [*publishers, *services] if n.startswith("/tracerisk_attach")]
    trace = json.loads(example.read("robot.json"))
    names = [each["ref"]["name"] for each in trace["functions"]]
    assert names == ["reach", "rest"]
    assert trace["active"]["panda_joint1"]["moving_s"] == pytest.approx(1.0, abs=0.15)
    assert any(each.startswith("lost: contacts") for each in trace["assumptions"])


def test_a_master_that_is_not_there_is_said(real_ros, tmp_path, example_in, monkeypatch):
    del real_ros
    monkeypatch.setenv("ROS_MASTER_URI", "http://127.0.0.1:9/")
    monkeypatch.setenv("ROS_IP", "127.0.0.1")
    began = time.monotonic()
    done = example_in(tmp_path).run("attach", "--robot", "panda", "--duration", "2")
    assert done.code == 2
    assert "no master answers at http://127.0.0.1:9/" in " ".join(done.err.split())
    assert time.monotonic() - began < 60.0
