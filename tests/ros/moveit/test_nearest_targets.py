"""Programs of moveit_commander on an arm whose joints turn further than once."""

import numpy as np
import pytest

from tracerisk.twin.robots.robot import load_robot

BEGIN = """\
arm = MoveGroupCommander("manipulator")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
def down(x, y, z):
    pose = geometry_msgs.msg.Pose()
    pose.position.x, pose.position.y, pose.position.z = x, y, z
    pose.orientation.x = 1.0
    return pose
arm.go([0.0, -1.57, 1.57, -1.57, -1.57, 0.0], wait=True)
"""


@pytest.fixture
def cell():
    return load_robot("ur10e"), "empty"


def test_pose_targets_in_turn_take_no_needless_turn(run):
    ran = run(
        BEGIN
        + """
done, values = [], [arm.get_current_joint_values()]
for place in ((0.45, -0.3, 0.2), (0.35, 0.3, 0.3), (0.5, 0.1, 0.15), (0.4, -0.2, 0.35)):
    arm.set_pose_target(down(*place))
    done.append(arm.go(wait=True))
    values.append(arm.get_current_joint_values())
"""
    )
    assert ran["done"] == [True] * 4
    assert ran["values"][1][0] == pytest.approx(-0.916, abs=0.01)
    assert np.abs(np.diff(ran["values"], axis=0)).max() < 2.6


def test_a_pose_as_joint_value_target_takes_the_nearest_solution(run):
    ran = run(
        BEGIN
        + """
arm.set_joint_value_target(down(0.45, -0.3, 0.2))
values = arm.get_joint_value_target()
"""
    )
    assert ran["values"][0] == pytest.approx(-0.916, abs=0.01)


def test_a_straight_path_after_a_goal_makes_no_turn(run):
    ran = run(
        BEGIN
        + """
arm.set_pose_target(down(0.45, -0.3, 0.3))
arm.go(wait=True)
plan, fraction = arm.compute_cartesian_path([down(0.45, 0.3, 0.3), down(0.45, 0.3, 0.2)], 0.02)
points = [point.positions for point in plan.joint_trajectory.points]
"""
    )
    assert ran["fraction"] == 1.0
    assert np.abs(np.array(ran["points"])[-1] - ran["points"][0]).max() < 1.7


def test_a_pose_whose_nearest_solution_is_blocked_is_reached_in_another(run):
    ran = run(
        BEGIN
        + """
scene = moveit_commander.PlanningSceneInterface(synchronous=True)
arm.set_pose_target(down(0.45, -0.3, 0.2))
free = list(arm.plan()[1].joint_trajectory.points[-1].positions)
box = geometry_msgs.msg.PoseStamped()
box.header.frame_id = "base_link"
arm.set_pose_target(down(0.45, -0.3, 0.2))
elbow = [0.25, -0.15, 0.52]
box.pose.position.x, box.pose.position.y, box.pose.position.z = elbow
box.pose.orientation.w = 1.0
scene.add_box("lamp", box, (0.1, 0.1, 0.1))
found = arm.plan()
reached = list(found[1].joint_trajectory.points[-1].positions)
done = arm.execute(found[1], wait=True)
place = arm.get_current_pose().pose.position
"""
    )
    assert np.abs(np.subtract(ran["free"], ran["reached"])).max() > 0.5
    assert ran["done"] is True
    place = ran["place"]
    assert (place.x, place.y, place.z) == pytest.approx((0.45, -0.3, 0.2), abs=5e-3)
