"""Subscriptions that their own program's publisher never reaches, for their QoS does not fit."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.common.traced.findings import NOTES
from tracerisk.ros.messages.ros2 import Interfaces2

PROGRAM = """\
import rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data
from std_msgs.msg import Bool
rclpy.init()
cell, sensor = rclpy.create_node("cell"), rclpy.create_node("sensor")
got = []
cell.create_subscription(Bool, "/part", lambda msg: got.append(msg), ASKED)
out = sensor.create_publisher(Bool, "/part", OFFERED)
for number in range(5):
    out.publish(Bool(data=True))
    rclpy.spin_once(cell, timeout_sec=0.1)
"""
KEPT = "QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)"


@pytest.fixture
def told(tmp_path: Path):
    def told(asked, offered):
        script = tmp_path / "cell.py"
        text = PROGRAM.replace("ASKED", asked).replace("OFFERED", offered)
        script.write_text(text, encoding="utf-8")
        ran = quiet_end(*run_traced(script, Interfaces2(), scene="empty", duration_s=10.0))
        findings = [each for each in ran.recording.findings if each.kind == "qos_misfit"]
        assert bool(ran["got"]) == (not findings)
        return findings

    return told


@pytest.mark.parametrize(
    ("asked", "offered", "policy"),
    [
        ("10", "qos_profile_sensor_data", "RELIABILITY"),
        (KEPT, "10", "DURABILITY"),
        (KEPT, "QoSProfile(depth=5)", "DURABILITY"),
        (
            "10",
            "QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)",
            "RELIABILITY",
        ),
    ],
)
def test_a_subscription_that_does_not_fit_is_told_of(told, asked, offered, policy):
    (finding,) = told(asked, offered)
    assert f"their {policy} does not fit" in finding.message
    assert (finding.object, finding.location.line) == ("/part", 7)
    assert finding.kind in NOTES


@pytest.mark.parametrize(
    ("asked", "offered"), [("10", "10"), ("qos_profile_sensor_data", "10"), ("10", KEPT)]
)
def test_one_that_fits_is_not(told, asked, offered):
    assert not told(asked, offered)
