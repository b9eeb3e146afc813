"""Calls that a stand-in refuses: reported although the controller catches the exception."""

import pytest

from tests.slow import slow_but

BEGIN = """\
import contextlib
import moveit_commander, rospy
from std_msgs.msg import Float64

rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")

"""
END = """
arm.set_named_target("ready")
arm.go()
"""
REFUSED = {
    "group": (
        "try:\n    moveit_commander.MoveGroupCommander('left_arm')\nexcept RuntimeError:\n    pass\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        9,
    ),
    "group in a function that handles": (
        "def group(name):\n    return moveit_commander.MoveGroupCommander(name)\n"
        "try:\n    group('left_arm')\nexcept Exception as error:\n    print(error)\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        9,
    ),
    "named target": (
        "with contextlib.suppress(Exception):\n    arm.set_named_target('nowhere')\n",
        "set_named_target raised MoveItCommanderException: Unable to set target nowhere",
        9,
    ),
    "joint": (
        "try:\n    arm.set_joint_value_target({'panda_jiont1': 0.3})\nexcept:\n    pass\n",
        "set_joint_value_target raised MoveItCommanderException: Error setting joint target",
        9,
    ),
    "link": (
        "try:\n    arm.get_current_pose('no_link')\nexcept Exception:\n    pass\n",
        "get_current_pose raised MoveItCommanderException: There is no link 'no_link'",
        9,
    ),
    "another name after one that is known": (
        "try:\n    moveit_commander.MoveGroupCommander('panda_hand')\n"
        "    moveit_commander.MoveGroupCommander('left_arm')\nexcept RuntimeError:\n    pass\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        10,
    ),
    "one of two in a function for both": (
        "def group(name):\n    try:\n        return moveit_commander.MoveGroupCommander(name)\n"
        "    except RuntimeError:\n        return None\n"
        "group('left_arm')\ngroup('panda_hand')\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        10,
    ),
    "one of two in a loop over both": (
        "for name in ('left_arm', 'panda_hand'):\n    try:\n"
        "        moveit_commander.MoveGroupCommander(name)\n    except RuntimeError:\n        pass\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        10,
    ),
    "one of two that a condition leaves after": (
        "def arms():\n    found = []\n    for name in ('left_arm', 'panda_arm'):\n        try:\n"
        "            found.append(moveit_commander.MoveGroupCommander(name))\n"
        "        except RuntimeError:\n            continue\n"
        "        if rospy.is_shutdown():\n            return found\n    return found\narms()\n",
        "MoveGroupCommander raised RuntimeError: Group 'left_arm' was not found",
        12,
    ),
    "type of a message": (
        "publisher = rospy.Publisher('/x', Float64, queue_size=1)\n"
        "rospy.Subscriber('/x', Float64, print)\nrospy.sleep(0.5)\n"
        "try:\n    publisher.publish('far')\nexcept Exception:\n    pass\n",
        "publish raised ROSSerializationException: ",
        12,
    ),
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "way",
    slow_but(("joint", "another name after one that is known", "type of a message"), [*REFUSED]),
)
def test_a_refused_call_is_reported_with_its_line_although_it_was_caught(example, way):
    source, words, line = REFUSED[way]
    example.write("cell.py", BEGIN + source + END)
    outcome = example.run("run", "cell.py", "--robot", "panda", "--check", "--json")
    (reason,) = [
        reason for reason in outcome.json["verdict"]["reasons"] if reason["code"] == "call-raised"
    ]
    assert reason["words"].startswith(f"the controller went on although {words}")
    assert reason["location"]["line"] == line
    assert outcome.json["verdict"]["kind"] == "faulted"


SETTLED = {
    "another name in the except clause": (
        "try:\n    hand = moveit_commander.MoveGroupCommander('gripper')\n"
        "except RuntimeError:\n    hand = moveit_commander.MoveGroupCommander('panda_hand')\n"
    ),
    "another name in the next pass": (
        "for name in ('manipulator', 'panda_arm'):\n    try:\n"
        "        moveit_commander.MoveGroupCommander(name)\n        break\n"
        "    except RuntimeError:\n        continue\n"
    ),
    "the controller's own exception": (
        "try:\n    raise RuntimeError('not ready')\nexcept RuntimeError:\n    pass\n"
    ),
    "a timeout": (
        "try:\n    rospy.wait_for_message('/x', Float64, timeout=0.5)\n"
        "except rospy.ROSException:\n    pass\n"
    ),
    "a parameter that has a default": (
        "try:\n    rospy.get_param('~speed')\nexcept KeyError:\n    speed = 1.0\n"
    ),
}


@pytest.mark.parametrize(
    "way", slow_but(("another name in the except clause", "a timeout"), [*SETTLED])
)
def test_what_has_another_way_or_may_be_tried_again_is_not_reported(example, way):
    example.write("cell.py", BEGIN + SETTLED[way] + END)
    outcome = example.run("run", "cell.py", "--robot", "panda", "--check", "--json")
    codes = {reason["code"] for reason in outcome.json["verdict"]["reasons"]}
    assert "call-raised" not in codes


def test_a_refused_call_that_ends_the_run_is_its_end_alone(example):
    source = "try:\n    moveit_commander.MoveGroupCommander('left_arm')\nexcept RuntimeError:\n    raise\n"
    example.write("cell.py", BEGIN + END + source)
    outcome = example.run("run", "cell.py", "--robot", "panda", "--check", "--json")
    codes = [reason["code"] for reason in outcome.json["verdict"]["reasons"]]
    assert codes == ["run-raised"]


def test_a_run_that_commands_nothing_names_what_was_refused(example):
    source = "try:\n    arm = moveit_commander.MoveGroupCommander('left')\nexcept RuntimeError:\n    exit()\n"
    example.write(
        "cell.py", "import moveit_commander, rospy\nrospy.init_node('cell')\n" + source + END
    )
    outcome = example.run("run", "cell.py", "--robot", "panda")
    assert outcome.code == 4
    assert "cell.py:4:11: the controller ended, and it commanded no hardware" in outcome.err
    assert "although MoveGroupCommander raised RuntimeError: Group 'left'" in outcome.err


UNUSED = """\
import rospy
from trajectory_msgs.msg import JointTrajectory

rospy.init_node("cell")

class Cell:
    def __init__(self):
        self.publisher = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=1)

    def pick(self):
        CALL
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "call",
    slow_but(
        ("self.publisher.publish(JointTrajectory())", "self.client.send_goal(1)"),
        (
            "self.publisher.publish(JointTrajectory())",
            "self.arm.go(wait=True)",
            "self.client.send_goal(1)",
            "self.bot.arm.set_joint_positions([0.0])",
            "self.robot.movej([0.0])",
        ),
    ),
)
def test_a_run_that_commands_nothing_names_what_could_and_never_ran(example, call):
    example.write("cell.py", UNUSED.replace("CALL", call))
    outcome = example.run("run", "cell.py", "--robot", "panda")
    assert outcome.code == 4
    words = "Cell.pick (cell.py:10) can command hardware and never ran"
    assert words in " ".join(outcome.err.split())


def test_a_run_that_commands_nothing_names_nothing_where_nothing_could(example):
    example.write("cell.py", UNUSED.replace("CALL", "return self.publisher.name"))
    outcome = example.run("run", "cell.py", "--robot", "panda")
    assert "never ran" not in outcome.err
