"""Goals of several constraints: a state is found that meets all of them, or a code says no."""

import math

import pytest

from tests.slow import slow_but

PREAMBLE = """\
import actionlib, rospy
from geometry_msgs.msg import Point, Pose, Quaternion, Vector3
from moveit_msgs.msg import (
    BoundingVolume, Constraints, JointConstraint, MoveGroupAction, MoveGroupGoal,
    OrientationConstraint, PositionConstraint)
from moveit_msgs.srv import GetPositionFK
from shape_msgs.msg import SolidPrimitive

rospy.init_node("controller")
move = actionlib.SimpleActionClient("/move_group", MoveGroupAction)
move.wait_for_server()
SPHERE, BOX = SolidPrimitive.SPHERE, SolidPrimitive.BOX

def at(x, y, z, kind=SPHERE, sizes=(0.01,), offset=(0.0, 0.0, 0.0), link="panda_link8"):
    one = PositionConstraint(link_name=link, weight=1.0, target_point_offset=Vector3(*offset))
    one.header.frame_id = "panda_link0"
    one.constraint_region = BoundingVolume(
        primitives=[SolidPrimitive(type=kind, dimensions=list(sizes))],
        primitive_poses=[Pose(position=Point(x, y, z), orientation=Quaternion(w=1.0))])
    return one

def turned(x, y, z, w, tolerances=(0.01, 0.01, 0.01)):
    one = OrientationConstraint(link_name="panda_link8", orientation=Quaternion(x, y, z, w))
    one.header.frame_id = "panda_link0"
    (one.absolute_x_axis_tolerance, one.absolute_y_axis_tolerance,
     one.absolute_z_axis_tolerance) = tolerances
    return one

def joint(number, position, below=0.01, above=0.01):
    return JointConstraint(joint_name="panda_joint%d" % number, position=position,
                           tolerance_below=below, tolerance_above=above, weight=1.0)

def go(*alternatives, path=None):
    goal = MoveGroupGoal()
    goal.request.group_name = "panda_arm"
    goal.request.goal_constraints = list(alternatives)
    goal.request.max_velocity_scaling_factor = 1.0
    goal.request.max_acceleration_scaling_factor = 1.0
    if path is not None:
        goal.request.path_constraints = path
    state = move.send_goal_and_wait(goal)
    return state, move.get_result().error_code.val

def constraints(*parts):
    return Constraints(
        joint_constraints=[each for each in parts if isinstance(each, JointConstraint)],
        position_constraints=[each for each in parts if isinstance(each, PositionConstraint)],
        orientation_constraints=[
            each for each in parts if isinstance(each, OrientationConstraint)])
"""
DONE, FAILED = (3, 1), 4
PLANNING_FAILED, INVALID = -1, -16
TARGET = (0.4, 0.3, 0.4)


@pytest.fixture
def ran(run_on_twin):
    return lambda program, **options: run_on_twin(PREAMBLE + program, **options)


def at(result, joint: str) -> float:
    return result.twin.joint_state().positions[joint]


def tip(result) -> tuple[float, float, float]:
    return result.twin.link_pose("panda_link8").position


def test_a_position_is_come_to_although_a_joint_is_constrained_as_well(ran):
    result = ran("ended = go(constraints(at(0.4, 0.3, 0.4), joint(1, 0.0, 1.57, 1.57)))")
    assert result["ended"] == DONE
    assert math.dist(tip(result), TARGET) < 0.01
    (command,) = result.recording.commands
    assert (command.end, command.way_done) == ("arrived", pytest.approx(1.0, abs=0.01))


@pytest.mark.parametrize("first", slow_but((0.2,), (0.2, 0.5, 0.9)))
def test_a_narrow_joint_and_a_position_hold_both(ran, first):
    result = ran(f"ended = go(constraints(at(0.4, 0.3, 0.4), joint(1, {first})))")
    assert result["ended"] == DONE
    assert math.dist(tip(result), TARGET) < 0.011
    assert at(result, "panda_joint1") == pytest.approx(first, abs=0.015)


def test_pose_and_some_joints_hold_all(ran):
    result = ran(
        "ended = go(constraints(at(0.45, 0.1, 0.45), turned(1.0, 0.0, 0.0, 0.0), "
        "joint(3, 0.3, 0.05, 0.05)))"
    )
    assert result["ended"] == DONE
    pose = result.twin.link_pose("panda_link8")
    assert math.dist(pose.position, (0.45, 0.1, 0.45)) < 0.011
    assert abs(pose.orientation[0]) > 0.9999
    assert at(result, "panda_joint3") == pytest.approx(0.3, abs=0.06)


def test_some_joints_alone_leave_the_others_where_they_are(ran):
    result = ran("ended = go(constraints(joint(1, 0.4), joint(7, 0.1)))")
    assert result["ended"] == DONE
    assert at(result, "panda_joint1") == pytest.approx(0.4, abs=0.01)
    assert at(result, "panda_joint4") == pytest.approx(-2.6, abs=0.01)


@pytest.mark.parametrize(
    ("asked", "reached"), [("joint(4, 0.0)", -0.0698), ("joint(4, -4.0)", -3.0718)]
)
def test_a_joint_constraint_past_a_limit_is_taken_to_the_limit_and_said(ran, asked, reached):
    result = ran(f"ended = go(constraints({asked}))")
    assert result["ended"] == DONE
    assert at(result, "panda_joint4") == pytest.approx(reached, abs=0.01)
    (finding,) = result.recording.findings
    assert (finding.kind, finding.object) == ("stopped_at_limit", "panda_joint4")


def test_a_joint_constraint_that_a_limit_cuts_is_met_within_it_without_a_word(ran):
    result = ran("ended = go(constraints(joint(4, 0.0, 0.2, 0.2)))")
    assert result["ended"] == DONE
    assert -0.2 < at(result, "panda_joint4") < -0.06
    assert result.recording.findings == ()


def test_two_regions_of_one_link_hold_both(ran):
    result = ran(
        "ended = go(constraints(at(0.4, 0.3, 0.4, SPHERE, [0.1]), "
        "at(0.4, 0.3, 0.6, BOX, [0.4, 0.4, 0.28])))"
    )
    assert result["ended"] == DONE
    x, y, z = tip(result)
    assert math.dist((x, y, z), TARGET) < 0.101
    assert z > 0.459


def test_a_turn_that_is_free_about_one_axis_leaves_the_joints_room(ran):
    result = ran(
        "ended = go(constraints(at(0.45, 0.0, 0.45), "
        "turned(1.0, 0.0, 0.0, 0.0, (0.05, 0.05, 3.15)), joint(7, 2.6, 0.1, 0.1)))"
    )
    assert result["ended"] == DONE
    assert math.dist(tip(result), (0.45, 0.0, 0.45)) < 0.011
    assert at(result, "panda_joint7") == pytest.approx(2.6, abs=0.11)


def test_a_point_beside_the_link_is_what_comes_to_the_place(ran):
    result = ran(
        "ended = go(constraints(at(0.45, 0.0, 0.4, offset=(0.0, 0.0, 0.1)), "
        "turned(1.0, 0.0, 0.0, 0.0)))"
    )
    assert result["ended"] == DONE
    # The hand points down: its link is above the point.
    assert tip(result) == pytest.approx((0.45, 0.0, 0.5), abs=0.011)


def test_the_first_alternative_that_can_be_met_is_taken(ran):
    result = ran("ended = go(constraints(at(3.0, 0.0, 0.4)), constraints(joint(1, 0.4)))")
    assert result["ended"] == DONE
    assert at(result, "panda_joint1") == pytest.approx(0.4, abs=0.01)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("goal", "code"),
    [
        # It is near, and joint 4 is to stretch the arm.
        ("constraints(at(0.3, 0.0, 0.3), joint(4, -0.15))", PLANNING_FAILED),
        ("constraints()", INVALID),
        ("constraints(joint(1, 0.5), joint(1, 0.9))", INVALID),
        ("constraints(joint(1, 0.5, -0.1, 0.1))", INVALID),
        ("constraints(joint(4, 0.0, -0.1, 0.1))", INVALID),
        ("constraints(at(0.4, 0.3, 0.4), joint(9, 0.5))", INVALID),
        ("constraints(at(0.4, 0.3, 0.4), at(0.4, -0.3, 0.4))", PLANNING_FAILED),
        # What the joints lead to is not where the link is to be.
        ("constraints(at(0.4, 0.3, 0.4), *(joint(i, 0.0) for i in (1, 2, 3, 5)))", PLANNING_FAILED),
    ],
)
def test_what_cannot_be_met_as_a_whole_moves_nothing_and_is_refused(ran, goal, code):
    result = ran(f"ended = go({goal})")
    assert result["ended"] == (FAILED, code)
    assert result.recording.commands == ()
    assert any("planning" in message for message in result.findings)


def test_what_the_way_must_keep_to_holds_beside_a_mixed_goal(ran):
    result = ran(
        "level = Constraints(joint_constraints=[joint(4, -2.2, 0.6, 0.6)])\n"
        "ended = go(constraints(at(0.4, 0.3, 0.4), joint(1, 0.5)), path=level)\n"
    )
    assert result["ended"] == DONE
    assert -2.81 < at(result, "panda_joint4") < -1.59
