"""What the verdict makes of grippers, whichever way their joints turn."""

import pytest

from tests.slow import slow_but

KNUCKLE = "robotiq_85_left_knuckle_joint"
ENDS = {
    "panda": ("panda_arm", "hand", [0.035, 0.035], [0.0, 0.0]),
    "gen3": ("manipulator", "gripper", {KNUCKLE: 0.0}, {KNUCKLE: 0.75}),
    "xarm6": ("xarm6", "xarm_gripper", {"drive_joint": 0.0}, {"drive_joint": 0.8}),
    "j2n6s300": ("arm", "gripper", [0.2] * 3, [1.3] * 3),
}
CLOSES_TWICE = """\
import sys
import moveit_commander
import rospy

def turn(angle):
    goal = arm.get_current_joint_values()
    goal[0] += angle
    arm.go(goal, wait=True)

def close():
    hand.go({closed}, wait=True)

def release():
    hand.go({opened}, wait=True)

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("c")
arm = moveit_commander.MoveGroupCommander("{arm}")
hand = moveit_commander.MoveGroupCommander("{hand}")
release()
for side in (0.3, -0.3):
    turn(side)
    close()
    turn(0.2)
    release()
"""
ASIDE = """\
objects:
  - {name: cube, box: [0.04, 0.04, 0.04], xyz: [0.9, -0.6, 0.02], mass: 0.1}
"""


def verdict(outcome) -> list[dict[str, str]]:
    return outcome.json["trace"]["verdict"]["reasons"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "robot",
    slow_but(["panda", "gen3"], [*ENDS]),
)
def test_a_gripper_that_closes_on_nothing_is_told_at_the_line_that_closes_it(
    tmp_path, example_in, robot
):
    arm, hand, opened, closed = ENDS[robot]
    example = example_in(tmp_path)
    example.write("c.py", CLOSES_TWICE.format(arm=arm, hand=hand, opened=opened, closed=closed))
    example.write("cell.yaml", ASIDE)
    outcome = example.run("run", "c.py", "--json", "--robot", robot, "--scenario", "cell.yaml")
    reasons = [(each["code"], each["function"]) for each in verdict(outcome)]
    assert reasons == [("grasped-nothing", "close")]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("objects", "why"),
    [
        (
            ASIDE,
            "from the origin of cube, the nearest object: no object of the scene is between its "
            "pads there",
        ),
        ("", "m: the scene gives it nothing to grasp, so no load is in the figures"),
    ],
    ids=["aside", "empty scene"],
)
@pytest.mark.parametrize("then", ["release()\n    turn(-0.2)\n    ", ""], ids=["back", "at once"])
def test_a_controller_that_notices_an_empty_grip_learns_where_it_was(
    tmp_path, example_in, then, objects, why
):
    arm, hand, opened, closed = ENDS["panda"]
    source = CLOSES_TWICE.format(arm=arm, hand=hand, opened=opened, closed=closed)
    example = example_in(tmp_path)
    example.write(
        "c.py", source.replace("    turn(0.2)\n    release()", f"    {then}raise SystemExit(1)")
    )
    example.write("cell.yaml", objects)
    scenario = ("--scenario", "cell.yaml") if objects else ()
    outcome = example.run("run", "c.py", "--json", "--robot", "panda", *scenario)
    assert "grasped-nothing" not in [reason["code"] for reason in verdict(outcome)]
    (found,) = [
        finding
        for finding in outcome.json["trace"]["findings"]
        if finding["kind"] == "nothing_to_grasp"
    ]
    assert found["message"].startswith("panda_hand closed on nothing at (")
    assert why in found["message"]
    assert found["function"] == "close"


AT_LAST = """\
import moveit_commander
import rospy

rospy.init_node("c")
arm = moveit_commander.MoveGroupCommander("panda_arm")
hand = moveit_commander.MoveGroupCommander("panda_hand")
hand.go([0.04, 0.04], wait=True)
arm.go([0.0, 0.4, 0.0, -1.8, 0.0, 2.2, 0.78], wait=True)
hand.go([0.0, 0.0], wait=True)
"""


def test_a_grip_as_the_last_command_of_a_run_holds(tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("c.py", AT_LAST)
    part = "{name: part, cylinder: {radius: 0.02, height: 0.25}, xyz: [0.646, 0, 0.125], mass: 0.3}"
    example.write("cell.yaml", f"objects:\n  - {part}\n")
    outcome = example.run("run", "c.py", "--json", "--robot", "panda", "--scenario", "cell.yaml")
    assert outcome.json["trace"]["active"]["panda_hand"]["grasps"] == 1
    assert outcome.json["trace"]["findings"] == []


GRASP = """\
import actionlib
import rospy
from franka_gripper.msg import GraspAction, GraspGoal, MoveAction, MoveGoal

rospy.init_node("c")
move = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
grasp = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
move.wait_for_server()
grasp.wait_for_server()

def wide(width=0.08):
    move.send_goal_and_wait(MoveGoal(width=width, speed=0.1))

def take(width, epsilon=0.0):
    goal = GraspGoal(width=width, speed=0.1, force=10.0)
    goal.epsilon.inner = goal.epsilon.outer = epsilon
    grasp.send_goal_and_wait(goal)
    return grasp.get_result().success

"""


@pytest.mark.parametrize(
    ("calls", "missed"),
    [
        (
            "assert take(0.0, 0.005)\nwide()\nassert take(0.03, 0.03)\nwide()\n"
            "take(0.02) or take(0.02, 0.04)",
            [],
        ),
        ("take(0.03)", ["0.0300 to 0.0300 m"]),
        pytest.param("take(0.03, 0.01)", ["0.0200 to 0.0400 m"], marks=pytest.mark.slow),
        ("take(0.03) or wide() or take(0.02)", ["0.0300 to 0.0300 m"]),
    ],
)
def test_a_grasp_that_ends_at_another_width_aborts_its_command(tmp_path, example_in, calls, missed):
    example = example_in(tmp_path)
    example.write("c.py", f"{GRASP}wide()\n{calls}\nwide()\n")
    outcome = example.run("run", "c.py", "--json", "--robot", "panda")
    aborted = [each for each in verdict(outcome) if each["code"] == "command-aborted"]
    begin = "a goal of action /franka_gripper/grasp was aborted: the fingers stopped at a width of "
    assert all(each["words"].startswith(f"{begin}0.000") for each in aborted)
    assert [each["words"].partition("epsilon allow ")[2] for each in aborted] == missed
    assert outcome.code == bool(missed)


def test_a_grasp_that_was_aborted_for_want_of_things_is_said_to_be_no_fault(tmp_path, example_in):
    """The controller tries again, and what it tries then cannot hold anything either."""
    arm = (
        "import moveit_commander\narm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "def turn(angle):\n    joints = arm.get_current_joint_values()\n"
        "    joints[0] += angle\n    arm.go(joints, wait=True)\n"
    )
    calls = "wide()\nturn(0.2)\ntake(0.02) or take(0.02, 0.04)\nturn(-0.2)\nwide()\n"
    example = example_in(tmp_path)
    example.write("c.py", f"{GRASP}{arm}{calls}")
    outcome = example.run("run", "c.py", "--json", "--robot", "panda")
    assert [reason["code"] for reason in verdict(outcome)] == []
    (found,) = [
        finding
        for finding in outcome.json["trace"]["findings"]
        if finding["kind"] == "nothing_to_grasp"
    ]
    assert found["message"].endswith("; that its goal was aborted is no fault therefore")


GRIPPER_COMMAND = """\
import actionlib
import rospy
from control_msgs.msg import GripperCommandAction, GripperCommandGoal

rospy.init_node("c")
hand = actionlib.SimpleActionClient("/franka_gripper/gripper_action", GripperCommandAction)
hand.wait_for_server()

def take(position, effort=20.0):
    goal = GripperCommandGoal()
    goal.command.position, goal.command.max_effort = position, effort
    print("state", hand.send_goal_and_wait(goal))

"""


# Each from the fingers at 0.04 m, and all in one run, for a run takes longer than what it shows.
GRIPPED = (
    ("take(0.0)", 3, ()),
    ("take(0.002)", 3, ()),
    ("take(0.01)", 4, ("0.0150 to 0.0250 m",)),
    ("take(0.01, 0.0)", 3, ()),
    ("take(0.08)", 4, ("position 0.08 is out of range",)),
    (
        "rospy.set_param('/franka_gripper/default_grasp_epsilon/inner', 0.03); take(0.01)",
        3,
        (),
    ),
)


def test_gripper_action_of_franka_grasps_with_the_epsilon_of_its_node(tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("README.md", "# ROS Noetic\n")
    calls = "".join(f"take(0.04)\n{call}\n" for call, _, _ in GRIPPED)
    example.write("c.py", f"{GRIPPER_COMMAND}{calls}take(0.04)\n")
    outcome = example.run("run", "c.py", "--json", "--robot", "panda")
    said = outcome.out + outcome.err
    expected = [state for _, ended, _ in GRIPPED for state in (3, ended)]
    assert [int(each[:1]) for each in said.split("state ")[1:]] == [*expected, 3]
    assert [word for _, _, words in GRIPPED for word in words if word not in said] == []
