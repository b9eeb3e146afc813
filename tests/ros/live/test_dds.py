"""`tracerisk attach --dds`: it hears a robot of ROS 2 by readers alone, on loopback if asked to."""

import json
import os
import subprocess
import sys

import pytest

from tracerisk.common import dependencies, trace_json
from tracerisk.common.dependencies import EXTRAS, is_installed
from tracerisk.errors import DependencyError
from tracerisk.pipeline.recordings.attach import record_robot

pytestmark = pytest.mark.skipif(
    not is_installed("cyclonedds"), reason="cyclonedds of the extra dds is not installed"
)

# A domain of our own: whoever else runs the tests on this machine is not to be heard.
ENVIRONMENT = {"ROS_LOCALHOST_ONLY": "1", "ROS_DOMAIN_ID": str(1 + os.getpid() % 100)}

ROBOT = """
import json, os, sys, time
from dataclasses import dataclass
from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication
from cyclonedds.core import Policy, Qos
from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float64, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.topic import Topic
from tracerisk.ros.live.dds import _LOOPBACK

@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32

@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str

@dataclass
class JointState(IdlStruct, typename="sensor_msgs::msg::dds_::JointState_"):
    header: Header
    name: sequence[str]
    position: sequence[float64]
    velocity: sequence[float64]
    effort: sequence[float64]

@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str

_OURS = int(os.environ["ROS_DOMAIN_ID"])
domain = Domain(_OURS, _LOOPBACK)
robot = DomainParticipant(_OURS)
kept = Qos(Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal, Policy.History.KeepAll)
probe = DataWriter(robot, Topic(robot, "rt/tracerisk/commands", String), kept)
other = DataWriter(robot, Topic(robot, "rt/chatter", String), kept)
sensed = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
states = DataWriter(robot, Topic(robot, "rt/joint_states", JointState), sensed)

def say(kind, number, **fields):
    probe.write(String(json.dumps({"t": time.time(), "kind": kind, "id": number, "pid": 1, **fields})))

probe.write(String(json.dumps({"t": time.time(), "kind": "begin", "format": "tracerisk-probe/1",
                               "controller": "cell.py", "pid": 1})))
deadline = time.time() + 60.0
while not states.get_matched_subscriptions() and time.time() < deadline:
    time.sleep(0.02)
began, sent = time.time(), []
while time.time() < began + 2.4:
    at = time.time() - began
    for number, (name, begins) in enumerate((("reach", 0.5), ("rest", 1.9)), 1):
        if at >= begins and name not in sent:
            sent.append(name)
            say("topic", number, name="/arm/command", type="trajectory_msgs/msg/JointTrajectory",
                stack=["cell.py:" + name], at=[[number, 3 * number, 4, 1]], root="main",
                joints=["panda_joint1"])
    moves = 0.5 <= at < 1.5
    stamp = Time(int(began + at), int((began + at) % 1.0 * 1e9))
    other.write(String("nobody asks for this"))
    states.write(JointState(
        Header(stamp, "base"), ["panda_joint%d" % i for i in range(1, 8)],
        [0.3 * min(max(at - 0.5, 0.0), 1.0)] + [0.0] * 6, [0.3 * moves] + [0.0] * 6, [5.0] * 7))
    time.sleep(0.02)
others = [each.topic_name for each in BuiltinDataReader(robot, BuiltinTopicDcpsPublication).take(100)
          if each.participant_key != robot.guid]
print(json.dumps(others))
"""

HEARD = """
import fcntl, json, os, socket, struct, sys, threading
from pathlib import Path
from tracerisk.common.sandbox.kernel.features import leave_network
if not leave_network():
    print("not allowed"); sys.exit()
try:
    tap = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(tap, 0x400454CA, struct.pack("16sH22x", b"robot0", 0x1002))
except OSError:
    print("not allowed"); sys.exit()
with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
    for what, text in ((0x8916, "10.9.9.1"), (0x891C, "255.255.255.0")):
        address = struct.pack("16sHH4s8x", b"robot0", socket.AF_INET, 0, socket.inet_aton(text))
        fcntl.ioctl(sock, what, address)
    fcntl.ioctl(sock, 0x8914, struct.pack("16sH14x", b"robot0", 0x1 | 0x1000))
packets = []
def watch():
    while True:
        frame = os.read(tap, 65536)
        if frame[12:14] == b"\\x08\\x00" and frame[23] == socket.IPPROTO_UDP:
            packets.append(len(frame))
threading.Thread(target=watch, daemon=True).start()
from tracerisk.pipeline.recordings.attach import record_robot
heard = record_robot(Path(sys.argv[1]), seconds=1.0, by_dds=True, environment=json.loads(sys.argv[2]))
print(len(packets))
"""


@pytest.fixture
def robot():
    process = subprocess.Popen(
        [sys.executable, "-c", ROBOT],
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, **ENVIRONMENT},
    )
    yield process
    process.kill()
    process.communicate()


def test_a_robot_of_ros_2_is_heard_by_readers_alone(robot, tmp_path, example_in):
    example = example_in(tmp_path)
    done = example.run(
        *("attach", "--dds", "--robot", "panda", "--effort-unit", "Nm", "--duration", "6"),
        *("--keep", "robot.mcap", "-o", "robot.json"),
        environment=ENVIRONMENT,
    )
    assert done.code == 0, done.err
    assert json.loads(robot.communicate(timeout=30)[0]) == []
    assert " on 2 topics; the time is over" in done.err
    trace = trace_json.loads(example.read("robot.json").decode(), "robot.json")
    assert trace.controller == "cell.py"
    assert trace.assumptions[0] == (
        "measured: by robot.mcap; functions by the probe's topic /tracerisk/commands"
    )
    assert [str(each.function.name) for each in trace.visits] == ["reach", "rest"]
    moved = trace.visits[0].exposures["panda_joint1"]
    assert moved is not None
    assert moved.moving_s == pytest.approx(1.0, abs=0.3)
    again = example.run(
        *("trace", "--from", "robot.mcap", "--robot", "panda", "--effort-unit", "Nm"),
        *("-o", "again.json"),
    )
    assert again.code == 0, again.err
    assert example.read("again.json") == example.read("robot.json")


@pytest.mark.parametrize(
    ("said", "leaves"),
    [
        ({"ROS_LOCALHOST_ONLY": "1"}, False),
        pytest.param({"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}, False, marks=pytest.mark.slow),
        ({}, True),  # else this test could not see what leaves
    ],
)
def test_no_packet_leaves_loopback_where_that_is_asked_for(tmp_path, said, leaves):
    done = subprocess.run(
        [sys.executable, "-c", HEARD, str(tmp_path / "robot.mcap"), json.dumps(said)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    if "not allowed" in done.stdout:
        pytest.skip("the kernel allows no network of its own here")
    assert (int(done.stdout) > 0) == leaves


@pytest.mark.parametrize(
    "domain",
    ["233", "cell", *(pytest.param(each, marks=pytest.mark.slow) for each in ("-1", "1.5"))],
)
def test_a_domain_that_is_none_is_refused(domain, tmp_path, example_in):
    done = example_in(tmp_path).run(
        *("attach", "--dds", "--robot", "panda", "--duration", "1"),
        environment={**ENVIRONMENT, "ROS_DOMAIN_ID": domain},
    )
    assert done.code == 2
    said = f"ROS_DOMAIN_ID is '{domain}'; give a number from 0 to 232"
    assert said in " ".join(done.err.split())


def test_without_cyclonedds_the_extra_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(dependencies, "is_installed", lambda name: name not in EXTRAS["dds"])
    with pytest.raises(DependencyError, match=r"pip install 'tracerisk\[dds\]'"):
        record_robot(tmp_path / "robot.mcap", by_dds=True)
