#!/usr/bin/env python3
"""Kits three articles out of the feeder into the tray, books each with the store (Panda, ROS 1)."""
import contextlib
import sys

import actionlib
import moveit_commander
import rospy
from franka_gripper.msg import GraspAction, GraspGoal, MoveAction, MoveGoal
from geometry_msgs.msg import Pose, Quaternion
from kit_msgs.msg import KitDone
from kit_msgs.srv import BookPart
from std_srvs.srv import SetBool

import layout

DOWN = Quaternion(x=1.0, y=0.0, z=0.0, w=0.0)  # of panda_hand_tcp


class Hand(object):
    def __init__(self):
        self._move = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self._grasp = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        self._move.wait_for_server()
        self._grasp.wait_for_server()

    def open(self, width=0.07):
        self._move.send_goal_and_wait(MoveGoal(width=width, speed=0.1), rospy.Duration(4.0))

    def grip(self, width):
        goal = GraspGoal(width=width, speed=0.05, force=12.0)
        goal.epsilon.inner = goal.epsilon.outer = 0.006
        self._grasp.send_goal_and_wait(goal, rospy.Duration(4.0))
        outcome = self._grasp.get_result()
        return outcome is not None and outcome.success


class Arm(object):
    def __init__(self):
        self._group = moveit_commander.MoveGroupCommander("panda_manipulator")
        self._group.set_max_velocity_scaling_factor(0.6)
        self._group.set_max_acceleration_scaling_factor(0.5)

    def hover(self, place):
        self._go(place, layout.CLEARANCE)

    def straight(self, place, lift=0.0):
        pose = self._pose(place, lift)
        path, share = self._group.compute_cartesian_path([pose], 0.01)
        if share < 0.99:
            raise RuntimeError("no straight way to %s" % (place,))
        slow = self._group.retime_trajectory(self._group.get_current_state(), path, 0.3, 0.3)
        self._group.execute(slow, wait=True)

    def park(self):
        self._group.set_named_target("ready")
        self._group.go(wait=True)

    def _go(self, place, lift):
        self._group.set_pose_target(self._pose(place, lift))
        if not self._group.go(wait=True):
            raise RuntimeError("cannot reach %s" % (place,))
        self._group.clear_pose_targets()

    @staticmethod
    def _pose(place, lift):
        pose = Pose(orientation=DOWN)
        pose.position.x, pose.position.y = place.x, place.y
        pose.position.z = place.z + lift
        return pose


@contextlib.contextmanager
def lane_locked(lock):
    """The feeder must not index while the hand is in the lane."""
    lock(True)
    try:
        yield
    finally:
        lock(False)


def jobs(order):
    for entry in order:
        article = layout.CATALOGUE[entry["article"]]
        yield article, layout.LANES[article.lane], entry["nest"]


def fetch(arm, hand, place, width):
    hand.open()
    arm.hover(place)
    arm.straight(place)
    held = hand.grip(width)
    arm.straight(place, layout.CLEARANCE)
    return held


def deposit(arm, hand, place):
    arm.hover(place)
    arm.straight(place, 0.002)
    hand.open()
    arm.straight(place, layout.CLEARANCE)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("kit_node")
    order = rospy.get_param("~order")
    kit_id = rospy.get_param("~kit_id")
    done_pub = rospy.Publisher("/kit/done", KitDone, queue_size=1, latch=True)
    rospy.wait_for_service("/store/book")
    book = rospy.ServiceProxy("/store/book", BookPart)
    lock = rospy.ServiceProxy("/feeder/lock", SetBool)
    arm, hand = Arm(), Hand()

    arm.park()
    kitted = 0
    for article, pick_at, label in jobs(order):
        with lane_locked(lock):
            held = fetch(arm, hand, pick_at, article.width)
        if not held:
            rospy.logerr("no part in lane %s", article.lane)
            continue
        deposit(arm, hand, layout.nest(label))
        receipt = book(part_number=article.number, nest=label, weight_g=article.weight_g)
        if receipt.booked:
            kitted += 1
    arm.park()
    done_pub.publish(KitDone(kit_id=kit_id, parts=kitted, complete=kitted == len(order)))
    rospy.sleep(0.2)


if __name__ == "__main__":
    main()
