"""Interbotix's driver of the years before `xs_sdk`, whose messages are those of the workspace."""

import json

import pytest

MESSAGES = {
    "msg/JointCommands.msg": "float64[] cmd\n",
    "msg/SingleCommand.msg": "string joint_name\nfloat64 cmd\n",
    "srv/RobotInfo.srv": """\
---
string[] joint_names
int16[] joint_ids
float64[] lower_joint_limits
float64[] upper_joint_limits
float64[] velocity_limits
float64 lower_gripper_limit
float64 upper_gripper_limit
bool use_gripper
float64[] home_pos
float64[] sleep_pos
int8 num_joints
int8 num_single_joints
""",
    "srv/OperatingModes.srv": """\
int8 cmd
string mode
string joint_name
bool use_custom_profiles
int32 profile_velocity
int32 profile_acceleration
---
""",
    "srv/RegisterValues.srv": """\
int8 cmd
string motor_name
string addr_name
int32 value
---
int32[] values
""",
    "package.xml": "<package><name>interbotix_sdk</name></package>\n",
}
HEAD = """\
import rospy
from interbotix_sdk.msg import JointCommands, SingleCommand
from interbotix_sdk.srv import OperatingModes, RegisterValues, RobotInfo
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64
from std_srvs.srv import Empty

rospy.init_node("arm_task")
rospy.wait_for_service("/SPACE/get_robot_info")
info = rospy.ServiceProxy("/SPACE/get_robot_info", RobotInfo)()
registers = rospy.ServiceProxy("/SPACE/set_motor_register_values", RegisterValues)
modes = rospy.ServiceProxy("/SPACE/set_operating_modes", OperatingModes)
arm = rospy.Publisher("/SPACE/joint/commands", JointCommands, queue_size=1)
one = rospy.Publisher("/SPACE/single_joint/command", SingleCommand, queue_size=1)
gripper = rospy.Publisher("/SPACE/gripper/command", Float64, queue_size=1)
rospy.sleep(0.5)


def state():
    return rospy.wait_for_message("/SPACE/joint_states", JointState)


def at(name):
    found = state()
    return found.position[found.name.index(name)]
"""


@pytest.fixture
def run_sdk(example):
    """Run statements of a function `act` against the old driver; return the trace's JSON."""
    for file, text in MESSAGES.items():
        example.write(f"src/interbotix_sdk/{file}", text)
    example.write("src/task/package.xml", "<package><name>task</name></package>\n")

    def run(*statements: str, robot: str = "wx250s") -> dict:
        body = "\n    ".join(statements)
        source = f"{HEAD.replace('SPACE', robot)}\n\ndef act():\n    {body}\n\n\nact()\n"
        example.write("src/task/task.py", source)
        outcome = example.run("trace", "src/task/task.py", "--robot", robot, "--json")
        assert outcome.out, outcome.err
        return json.loads(outcome.out)

    return run


def ends(found: dict) -> list[tuple[str, str]]:
    return [(each["kind"], each["end"]) for each in found["trace"]["commands"]]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("robot", "count"), [("wx250s", 6), ("rx150", 5), ("px100", 4)])
def test_the_arm_goes_where_it_is_sent_in_the_time_of_its_profile(run_sdk, robot, count):
    found = run_sdk(
        f"assert info.num_joints == len(info.home_pos) == {count}, info",
        f"assert info.num_single_joints == len(info.upper_joint_limits) == {count + 1}",
        "assert info.joint_names[-1] == 'gripper'",
        "assert state().name[-3:] == ['gripper', 'left_finger', 'right_finger']",
        "registers(cmd=2, addr_name='Profile_Velocity', value=1500)",
        "registers(cmd=2, addr_name='Profile_Acceleration', value=300)",
        "arm.publish(JointCommands(info.home_pos))",
        "rospy.sleep(0.7)",
        "assert abs(at('elbow')) > 0.3, at('elbow')",
        "rospy.sleep(1.0)",
        "assert abs(at('elbow')) < 0.03, at('elbow')",
        "one.publish(SingleCommand('waist', 0.4))",
        "rospy.sleep(2.0)",
        "assert abs(at('waist') - 0.4) < 0.02, at('waist')",
        robot=robot,
    )
    assert found["verdict"]["kind"] == "complete", found["verdict_line"]
    assert ends(found) == [("joint_group_command", "arrived"), ("joint_command", "arrived")]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("opening", "closing"),
    [
        ("gripper.publish(350)", "gripper.publish(-350)"),
        ("gripper.publish(0.07)", "gripper.publish(0.032)"),
        (
            "one.publish(SingleCommand('gripper', 350))",
            "one.publish(SingleCommand('gripper', -350))",
        ),
        (
            "modes(cmd=3, mode='pwm'); gripper.publish(300)",
            "modes(4, 'position', 'gripper', False, 0, 0); gripper.publish(0.032)",
        ),
    ],
)
def test_the_gripper_takes_a_pwm_or_the_distance_of_its_fingers(run_sdk, opening, closing):
    found = run_sdk(
        opening,
        "rospy.sleep(1.5)",
        "assert at('left_finger') > 0.034, at('left_finger')",
        closing,
        "rospy.sleep(1.5)",
        "assert at('left_finger') < 0.0165, at('left_finger')",
    )
    assert "raised" not in found["verdict_line"], found["verdict_line"]
    assert ends(found) == [("gripper_command", "arrived")] * 2


@pytest.mark.slow
def test_joints_in_a_mode_of_velocity_turn_until_they_are_stopped(run_sdk):
    found = run_sdk(
        "modes(cmd=4, mode='velocity', joint_name='waist')",
        "one.publish(SingleCommand('waist', 0.5))",
        "rospy.sleep(1.0)",
        "one.publish(SingleCommand('waist', 0.0))",
        "rospy.sleep(0.5)",
        "assert 0.3 < at('waist') < 0.7, at('waist')",
    )
    assert "raised" not in found["verdict_line"], found["verdict_line"]
    assert len(ends(found)) >= 1


def test_what_means_no_servo_moves_nothing_and_is_reported(run_sdk):
    found = run_sdk(
        "one.publish(SingleCommand('wrist', 0.5))",
        "arm.publish(JointCommands([0.0, 0.0]))",
        "rospy.ServiceProxy('/wx250s/torque_joints_off', Empty)()",
        "arm.publish(JointCommands(info.home_pos))",
        "rospy.sleep(1.0)",
    )
    words = " ".join(each["words"] for each in found["verdict"]["reasons"])
    assert "no servo 'wrist'" in words
    assert "2 commands for 6 joints" in words
    assert "torqued off" in words
    assert set(ends(found)) == {("message", "ignored")}
