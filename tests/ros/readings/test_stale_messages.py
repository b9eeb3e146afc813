"""Commands that come of old messages while newer ones wait: which are told of, and which not."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.common.traced.findings import NOTES
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

ROS_1 = """\
import moveit_commander, message_filters, rospy
from std_msgs.msg import Float64
from geometry_msgs.msg import PointStamped
rospy.init_node("follow")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
done = []
def turn_to(angle):
    arm.go([angle, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=True)
def follow(msg):
    turn_to(getattr(msg, "data", None) or msg.point.x)
    rospy.sleep(0.5)
    done.append(msg)
SUBSCRIBE
out = rospy.Publisher("/seen", type_of, queue_size=10)
while out.get_num_connections() == 0:
    rospy.sleep(0.1)
for number in range(COUNT):
    msg = type_of()
    if hasattr(msg, "data"):
        msg.data = VALUE
    else:
        msg.point.x = VALUE
    out.publish(msg)
    rospy.sleep(STEP)
rospy.sleep(20.0)
"""
ROS_2 = """\
import time
import rclpy
from rclpy.node import Node
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
from builtin_interfaces.msg import Duration
rclpy.init()
done = []
class Follow(Node):
    def __init__(self):
        super().__init__("follow")
        self.out = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 10)
        self.create_subscription(Float64, "/seen", self.follow, DEPTH)
        self.seen = self.create_publisher(Float64, "/seen", 10)
        self.count = 0
        time.sleep(2.0)
    def follow(self, msg):
        point = JointTrajectoryPoint(
            positions=[msg.data, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785],
            time_from_start=Duration(sec=1))
        self.out.publish(JointTrajectory(
            joint_names=[f"panda_joint{n}" for n in range(1, 8)], points=[point]))
        time.sleep(1.0)
        done.append(msg)
node = Follow()
other = rclpy.create_node("seer")
seen = other.create_publisher(Float64, "/seen", 10)
import threading
def see():
    for number in range(30):
        seen.publish(Float64(data=0.02 * (number + 1)))
        time.sleep(0.25)
threading.Thread(target=see).start()
end = time.time() + 15.0
while time.time() < end:
    rclpy.spin_once(node, timeout_sec=0.1)
"""
PLAIN = 'type_of = Float64\nrospy.Subscriber("/seen", Float64, follow{})'
FILTERED = (
    'type_of = PointStamped\nmessage_filters.Subscriber("/seen", PointStamped{})'
    ".registerCallback(follow)"
)
RISING = "0.02 * (number + 1)"


@pytest.fixture
def late(tmp_path: Path):
    def late(program: str):
        script = tmp_path / "follow.py"
        script.write_text(program, encoding="utf-8")
        interfaces = Interfaces2() if "rclpy" in program else Interfaces()
        ran = quiet_end(*run_traced(script, interfaces, scene="empty", duration_s=60.0))
        assert len(ran["done"]) >= 2
        return [each for each in ran.recording.findings if each.kind == "handled_late"]

    return late


def ros_1(subscribe, *, value=RISING, count=20, step=0.1):
    steps = {"SUBSCRIBE": subscribe, "COUNT": count, "VALUE": value, "STEP": step}
    program = ROS_1
    for name, text in steps.items():
        program = program.replace(name, str(text))
    return program


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("subscribe", "line"),
    [
        (PLAIN.format(""), 16),
        (PLAIN.format(", queue_size=100"), 16),
        (FILTERED.format(""), 16),
    ],
)
def test_a_callback_that_falls_behind_a_stream_is_told_of(late, subscribe, line):
    (finding,) = late(ros_1(subscribe))
    assert finding.object == "/seen"
    assert "newer ones waited; queue_size=1 keeps the newest alone" in finding.message
    assert finding.location.line == line
    assert finding.kind in NOTES


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "program",
    [
        ros_1(PLAIN.format(", queue_size=1")),
        # Orders that come at one time, and such as a person gives.
        ros_1(PLAIN.format(""), step=0.0, count=6),
        ros_1(PLAIN.format(""), step=1.0, count=6),
        # What says the same is as good as the newest.
        ros_1(PLAIN.format(""), value="0.3"),
        # Nothing is commanded.
        ros_1(PLAIN.format("")).replace("    turn_to(", "    print("),
    ],
)
def test_who_keeps_up_or_has_orders_to_carry_out_is_not(late, program):
    assert not late(program)


def test_a_deep_queue_of_rclpy_is_told_of(late):
    (finding,) = late(ROS_2.replace("DEPTH", "10"))
    # The last ten of the stream wait when it ends, and each takes a second.
    assert "up to 7.5 s old, while up to 9 newer ones waited" in finding.message
    assert "a depth of 1 keeps the newest alone" in finding.message
    assert finding.location.line == 14


def test_a_queue_of_one_message_is_not(late):
    assert not late(ROS_2.replace("DEPTH", "1"))
