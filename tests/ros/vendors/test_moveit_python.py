"""moveit_python's stand-in, on the twin's move_group."""

import pytest

HEAD = """
import rospy
from geometry_msgs.msg import PoseStamped
from moveit_python import MoveGroupInterface, PickPlaceInterface, PlanningSceneInterface
rospy.init_node('mover')
"""


def test_a_group_moves_to_joints_and_to_a_pose(run_on):
    ran = run_on(
        "panda",
        HEAD
        + """
group = MoveGroupInterface('panda_arm', 'panda_link0')
joints = ['panda_joint%d' % i for i in range(1, 8)]
first = group.moveToJointPosition(joints, [0.3, -0.785, 0, -2.356, 0, 1.571, 0.785],
                                  max_velocity_scaling_factor=0.5)
pose = PoseStamped()
pose.header.frame_id = 'panda_link0'
pose.pose.position.x, pose.pose.position.y, pose.pose.position.z = 0.4, 0.0, 0.5
pose.pose.orientation.x = 1.0
second = group.moveToPose(pose, 'panda_link8')
planned = group.moveToJointPosition(joints, [0.0] * 3 + [-1.5, 0, 1.5, 0], plan_only=True)
pose.pose.position.x = 3.0
far = group.moveToPose(pose, 'panda_link8')
""",
    )
    assert ran["first"].error_code.val == 1
    assert ran["second"].error_code.val == 1
    assert ran["planned"].error_code.val == 1
    assert ran["far"].error_code.val != 1
    assert len(ran.commands) == 2
    assert ran.twin.link_pose("panda_link8").position == pytest.approx((0.4, 0.0, 0.5), abs=0.02)


def test_the_scene_is_changed_by_its_services(run_on):
    ran = run_on(
        "panda",
        HEAD
        + """
scene = PlanningSceneInterface('panda_link0')
scene.addBox('box', 0.1, 0.1, 0.1, 0.6, 0.4, 0.3)
scene.addCube('cube', 0.05, 0.6, -0.4, 0.3, use_service=False)
scene.addSphere('ball', 0.05, 0.6, 0.0, 0.8)
scene.attachBox('tool', 0.02, 0.02, 0.02, 0.0, 0.0, 0.1, 'panda_hand', ['panda_leftfinger'])
scene.setColor('box', 1, 0, 0)
scene.sendColors()
scene.waitForSync()
known, held = sorted(scene.getKnownCollisionObjects()), scene.getKnownAttachedObjects()
scene.removeCollisionObject('ball')
left = sorted(scene.getKnownCollisionObjects())
scene.clear()
""",
    )
    assert ran["known"] == ["ball", "box", "cube"]
    assert ran["held"] == ["tool"]
    assert ran["left"] == ["box", "cube"]


def test_a_pick_of_what_is_not_there_fails_and_is_retried(run_on):
    ran = run_on(
        "panda",
        HEAD
        + """
picker = PickPlaceInterface('panda_arm', 'hand')
done, result = picker.pick_with_retry('nothing', [], retries=2)
try:
    picker.pickup('nothing', [], wait=False)
except NotImplementedError as error:
    told = str(error)
""",
    )
    assert ran["done"] is False
    assert ran["result"].error_code.val != 1
    assert "PickPlaceInterface.pickup with wait=False" in ran["told"]


def test_poses_are_moved_and_turned(run_on):
    ran = run_on(
        "panda",
        """
from math import pi
from geometry_msgs.msg import Point, Pose, Quaternion
from moveit_python.geometry import (
    rotate_pose_msg_about_origin, rotate_pose_msg_by_euler_angles, translate_pose_msg)
pose = Pose(Point(1, 0, 0), Quaternion(0, 0, 0, 1))
turned = rotate_pose_msg_by_euler_angles(pose, 0, 0, pi / 2)
about = rotate_pose_msg_about_origin(pose, 0, 0, pi / 2).position
ahead = translate_pose_msg(turned, 1, 0, 0).position
""",
    )
    assert ran["turned"].orientation.z == pytest.approx(0.7071, abs=1e-4)
    assert (ran["about"].x, ran["about"].y) == pytest.approx((0.0, 1.0))
    assert (ran["ahead"].x, ran["ahead"].y) == pytest.approx((1.0, 1.0))
