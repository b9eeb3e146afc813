"""Programs in URScript that come on a topic: what they move, and what is reported of them."""

import ast
import math
from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.ros.vendors.universal_robots.script import (
    PoseNumbers,
    ScriptError,
    evaluate,
    statements,
)

CELL = """\
import rclpy
from rclpy.node import Node
from std_msgs.msg import String

rclpy.init()
node = Node("cell")
publisher = node.create_publisher(String, "/urscript_interface/script_command", 10)


def send(*lines, seconds):
    publisher.publish(String(data="def program():\\n" + "\\n".join(lines) + "\\nend\\n"))
    end = node.get_clock().now().nanoseconds + int(seconds * 1e9)
    while node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.1)


"""

HOME = "movej([0.5, -d2r(90), 1.57, -pi/2, -1.57, 0], a=1.2, v=0.5)"


def test_joints_and_lines_are_moved_in_their_turn(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
send("{HOME}", "start = get_actual_tcp_pose()", "sleep(0.5)",
     "movel(pose_add(start, p[0, 0, -0.1, 0, 0, 0]), a=0.5, v=0.1)  # down", seconds=12.0)
""",
        ros=2,
    )
    assert ran.commands == ["movej", "movel"]
    first, second = ran.recording.commands
    assert second.issue_ns - first.end_ns == pytest.approx(0.5e9, abs=0.05e9)
    # 0.1 m at 0.1 m/s.
    assert 1.0e9 <= second.end_ns - second.issue_ns < 2.5e9
    assert ran.findings == []


def test_older_drivers_say_whether_a_program_runs(run_on):
    ran = run_on(
        "ur5",
        f"""
import rospy
from std_msgs.msg import String
from ur_msgs.msg import RobotModeDataMsg

rospy.init_node("cell")
publisher = rospy.Publisher("/ur_driver/URScript", String, queue_size=1)
rospy.sleep(0.5)


def is_running():
    return rospy.wait_for_message("/ur_driver/robot_mode_state", RobotModeDataMsg).is_program_running


before, waited = is_running(), 0
publisher.publish("{HOME}")
rospy.sleep(0.01)
while is_running():
    waited += 1
""",
    )
    (move,) = ran.recording.commands
    assert move.end == "arrived"
    assert ran["before"] is False
    assert ran["waited"] == pytest.approx((move.end_ns - move.issue_ns) / 1e8, abs=2)


def test_poses_are_those_of_the_controller_box_and_of_its_tcp(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
send("{HOME}", "set_tcp(p[0, 0, 0.1, 0, 0, 0])",
     "movej(p[-0.4, -0.2, 0.3, 0, 3.14159, 0])", seconds=10.0)
""",
        ros=2,
    )
    # The box's frame is turned by half a turn against the robot's base link (REP 103).
    x, y, z = ran.twin.link_pose("tool0").position
    assert (x, y, z) == pytest.approx((0.4, 0.2, 0.4), abs=2e-3)


def test_another_program_takes_the_place_of_the_first(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + """
send("movej([1.5, -1.57, 1.57, -1.57, -1.57, 0], v=0.3)", seconds=1.0)
send("speedj([0.2, 0, 0, 0, 0, 0], 0.5, 1.0)", "stopj(2.0)", seconds=3.0)
""",
        ros=2,
    )
    # What turns at a velocity is stopped by the program.
    assert [command.end for command in ran.recording.commands] == ["replaced", "cancelled"]
    assert abs(ran.position("elbow_joint")) < 1.5


def test_the_tcp_stays_when_its_program_is_over(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
send("{HOME}", "set_tcp(p[0, 0, 0.1, 0, 0, 0])", seconds=8.0)
send("movej(p[-0.4, -0.2, 0.3, 0, 3.14159, 0])", seconds=8.0)
""",
        ros=2,
    )
    assert ran.twin.link_pose("tool0").position == pytest.approx((0.4, 0.2, 0.4), abs=2e-3)


def test_the_tcp_goes_when_the_program_of_the_driver_begins_again(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
from std_srvs.srv import Trigger
send("{HOME}", "set_tcp(p[0, 0, 0.1, 0, 0, 0])", seconds=8.0)
again = node.create_client(Trigger, "/io_and_status_controller/resend_robot_program")
again.wait_for_service()
rclpy.spin_until_future_complete(node, again.call_async(Trigger.Request()))
send("movej(p[-0.4, -0.2, 0.3, 0, 3.14159, 0])", seconds=8.0)
""",
        ros=2,
    )
    assert ran.twin.link_pose("tool0").position == pytest.approx((0.4, 0.2, 0.3), abs=2e-3)


# Streams


def servoj(period, look_ahead):
    """A program that sends points of a cosine for 5 s."""
    steps = round(5.0 / period)
    points = (-1.57 + 0.2 * (1 - math.cos(0.628 * step * period)) for step in range(steps))
    return [
        f"servoj([{pan:.6f}, -1.57, 0, -1.57, 0, 0], t={period}, lookahead_time={look_ahead})"
        for pan in points
    ]


START = "movej([-1.57, -1.57, 0, -1.57, 0, 0], a=1.2, v=0.8)"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("period", [0.1, 0.02, 0.008])
def test_set_points_of_a_program_are_one_smooth_stream_at_any_rate(run_on, period):
    lines = [START, *servoj(period, 0.1)]
    ran = run_on("ur5e", CELL + f"send(*{lines!r}, seconds=12.0)\n", ros=2)
    assert ran.commands == ["movej", "servoj"]
    assert ran.findings == []
    _, stream = ran.recording.commands
    assert stream.end == "arrived"
    assert stream.end_ns - stream.issue_ns == pytest.approx(5.2e9, abs=0.5e9)
    assert ran.position("shoulder_pan_joint") == pytest.approx(-1.17, abs=0.01)


def test_programs_of_one_set_point_are_one_stream(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
send("{START}", seconds=6.0)
for step in range(50):
    send(f"servoj([{{-1.57 + 0.01 * step}}, -1.57, 0, -1.57, 0, 0], t=0.05)", seconds=0.05)
send("sleep(0.1)", seconds=1.0)
""",
        ros=2,
    )
    assert ran.commands == ["movej", "servoj"]
    assert ran.position("shoulder_pan_joint") == pytest.approx(-1.08, abs=0.01)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("lines", "turned"),
    [
        (["speedj([0.2, 0, 0, 0, 0, 0], 1.0, 2.0)"], 0.4),
        (["speedj([0.2, 0, 0, 0, 0, 0], 1.0)", "sleep(2.0)"], 0.42),
        (["speedj([0.2, 0, 0, 0, 0, 0], 1.0)"], 0.03),
        (
            ["speedj([0.2, 0, 0, 0, 0, 0], 1.0, 1.0)", "speedj([-0.2, 0, 0, 0, 0, 0], 1.0, 1.0)"],
            0.0,
        ),
    ],
)
def test_a_velocity_lasts_until_its_program_is_over(run_on, lines, turned):
    ran = run_on(
        "ur5e", CELL + f'send("{START}", seconds=6.0)\nsend(*{lines!r}, seconds=4.0)\n', ros=2
    )
    assert ran.position("shoulder_pan_joint") + 1.57 == pytest.approx(turned, abs=0.04)
    assert ran.findings == []


@pytest.mark.slow
def test_programs_of_one_velocity_are_one_stream(run_on):
    ran = run_on(
        "ur5e",
        CELL
        + f"""
send("{START}", seconds=6.0)
for step in range(20):
    send("speedj([0.2, 0, 0, 0, 0, 0], 1.0, 0.5)", seconds=0.1)
send("stopj(1.0)", seconds=1.0)
""",
        ros=2,
    )
    assert ran.commands == ["movej", "speedj"]
    first, last = ran.recording.commands[-1].issue_ns, ran.recording.commands[-1].end_ns
    turned = ran.position("shoulder_pan_joint") + 1.57
    assert turned == pytest.approx(0.2e-9 * (last - first), abs=0.04)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("while True:", "line 2 of the program: 'while' is not simulated"),
        ("force_mode(p[0,0,0,0,0,0])", "line 2 of the program: 'force_mode' is not simulated"),
        ("movej([1, 2)", "line 2 of the program is malformed"),
        ("movej([9, 0, 0, 0, 0, 0])", "9.000 for 'shoulder_pan_joint' is outside"),
        ("movel(p[5, 0, 0, 0, 0, 0])", "of the line to"),
        ("x = missing", "line 2 of the program: 'missing' is not simulated"),
    ],
)
def test_what_is_not_carried_out_is_reported_with_its_line(run_on, line, words):
    ran = run_on("ur5e", CELL + f"send({line!r}, seconds=1.0)\n", ros=2)
    (finding,) = ran.findings
    assert words in finding
    assert ran.commands == []


def test_other_robots_take_no_such_program(run_on):
    ran = run_on("panda", CELL + f"send({HOME!r}, seconds=1.0)\n", ros=2)
    assert ran.commands == []


def value(text, **names):
    (statement,) = statements(text)
    return evaluate(statement, names, {"d2r": math.radians})


def test_values_are_those_that_are_written():
    assert value("p[0.1, -2, 3, 0, 0, d2r(180)]") == [0.1, -2.0, 3.0, 0.0, 0.0, math.pi]
    assert isinstance(value("p[0, 0, 0, 0, 0, 0]"), PoseNumbers)
    assert value("global way = [1 + 2, 4 / 2, a[1]];", a=[5, 6]) == [3, 2.0, 6]
    assert value("True") is True


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    with suppress(ScriptError):
        for each in statements(text):
            assert isinstance(each.expression, ast.expr)
            evaluate(each, {}, {})
