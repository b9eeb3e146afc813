"""A run that shows no risk for want of input goes on with drafted values, and says so."""

from __future__ import annotations

import pytest

HEAD = """\
import sys
import moveit_commander, rospy
from geometry_msgs.msg import PoseStamped
from std_srvs.srv import SetBool, SetBoolResponse

rospy.init_node("picker")


def arm_of():
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(1.0)
    arm.set_max_acceleration_scaling_factor(1.0)
    return arm


def turn(angle):
    arm = arm_of()
    joints = arm.get_current_joint_values()
    joints[0] += angle
    arm.go(joints, wait=True)


"""
MESSAGE = HEAD + "rospy.wait_for_message('/object', PoseStamped)\nturn(0.2)\n"
CALL = (
    HEAD
    + "def serve(request):\n    turn(0.2)\n    return SetBoolResponse(True, '')\n\n"
    + "rospy.Service('swing', SetBool, serve)\nrospy.spin()\n"
)
ARGUMENT = (
    HEAD
    + "import argparse\nparser = argparse.ArgumentParser()\n"
    + "parser.add_argument('side', choices=['left', 'right'])\n"
    + "turn({'left': 0.2, 'right': -0.2}[parser.parse_args().side])\n"
)
ANSWER = HEAD + "if input('Side? ') == 'left':\n    turn(0.2)\n"
ROBOT = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

NAMES = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
         "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]


def swing():
    out = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=1)
    rospy.sleep(0.5)
    point = JointTrajectoryPoint([0.2, -1.5, 1.5, -1.5, -1.5, 0.0], [], [], [], rospy.Duration(1))
    out.publish(JointTrajectory(joint_names=NAMES, points=[point]))
    rospy.sleep(2.0)


rospy.init_node("swinger")
swing()
"""


def drafted(outcome) -> list[str]:
    reasons = outcome.json["verdict"]["reasons"]
    return [each["object"] for each in reasons if each["code"] == "input-assumed"]


@pytest.mark.parametrize(
    ("source", "objects"),
    [
        pytest.param(MESSAGE, ["/object"], id="message"),
        pytest.param(CALL, ["/swing"], id="call", marks=pytest.mark.slow),
        pytest.param(ARGUMENT, ["arguments[1]"], id="argument", marks=pytest.mark.slow),
        pytest.param(ANSWER, ["answers[1]"], id="answer", marks=pytest.mark.slow),
        pytest.param(ROBOT, ["robot"], id="one of several robots"),
    ],
)
def test_what_it_lacks_is_drafted_and_is_a_reason_of_its_verdict(example, source, objects):
    example.write("c.py", source)
    ran = example.run("run", "c.py", "--json", "--check")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    assert drafted(ran) == objects
    places = {each["location"] is None for each in ran.json["verdict"]["reasons"]}
    assert places == {True}, "no file holds them"
    assert "scenario.yaml" not in ran.out


def test_blocks_and_lock_are_the_same_after_every_run_and_are_fresh(example):
    example.write("c.py", MESSAGE)
    ran = example.run("run", "c.py")
    assert ran.code == 0, ran.err
    told = " ".join(ran.err.split())
    assert "1 value is drafted, for it showed no risk without, and nobody has confirmed" in told
    assert "`tracerisk scenario c.py --write` writes them down" in told
    before = example.files()
    assert b"RiskAnnotation" in before["c.py"]
    assert example.run("run", "c.py").code == 0
    assert example.files() == before
    assert example.run("refresh", "c.py").code in (0, 1)
    assert example.files() == before
    checked = example.run("check", "c.py", "--json")
    assert [each["kind"] for each in checked.json["findings"]] == ["partial"]


def test_the_recording_that_is_kept_is_that_of_the_drafted_run(example):
    example.write("c.py", MESSAGE)
    ran = example.run("trace", "c.py", "--keep", "kept", "-o", "trace.json")
    assert ran.code == 0, ran.err
    assert b'"/object"' in example.read("trace.json")
    assert b"command_ended" in example.read("kept/events.jsonl")


@pytest.mark.parametrize("how", ["option", "setting"])
def test_without_drafts_it_ends_as_it_is(example, how):
    example.write("c.py", MESSAGE)
    if how == "setting":
        example.write("pyproject.toml", "[tool.tracerisk]\ndraft = false\n")
    options = ("--no-draft",) if how == "option" else ()
    ran = example.run("run", "c.py", *options)
    assert ran.code == 4
    assert "/object" in ran.err
    assert b"RiskAnnotation" not in example.read("c.py")


def test_what_no_draft_mends_ends_as_without(example):
    example.write("c.py", HEAD + "rospy.get_param('~speed')\nraise RuntimeError('no cell')\n")
    ran, plain = (example.run("run", "c.py", *more) for more in ((), ("--no-draft",)))
    assert (ran.code, ran.err) == (plain.code, plain.err)
