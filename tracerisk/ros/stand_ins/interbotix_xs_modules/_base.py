"""What the interfaces of a LoCoBot's base do in ROS 1: the base itself stands still on the twin."""

from __future__ import annotations

import math
from typing import Any

import actionlib
import rospy
from geometry_msgs.msg import Pose, PoseStamped, Twist, Vector3
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from nav_msgs.msg import Odometry
from tf.transformations import euler_from_quaternion, quaternion_from_euler

_HZ = 10.0


class BaseInterface:
    """Publishes twists and goals, and keeps the odometry."""

    def __init__(
        self, robot_name: str, command_topic: str, odometry: str, use_move_base_action: bool
    ) -> None:
        self.robot_name = robot_name
        self.use_move_base_action = use_move_base_action
        self.odom = Pose()
        if use_move_base_action:
            self.mb_client = actionlib.SimpleActionClient(
                f"/{robot_name}/move_base", MoveBaseAction
            )
            self.mb_client.wait_for_server()
        self.pub_base_command = rospy.Publisher(command_topic, Twist, queue_size=1)
        goals = f"/{robot_name}/move_base_simple/goal"
        self.pub_base_pose = rospy.Publisher(goals, PoseStamped, queue_size=1)
        self.sub_base_odom = rospy.Subscriber(odometry, Odometry, self.base_odom_cb)

    def move(self, x: float = 0, yaw: float = 0, duration: float = 1.0) -> None:
        """Command speeds [m/s, rad/s] for a time [s], and then a stop."""
        end = rospy.get_time() + duration
        rate = rospy.Rate(_HZ)
        while rospy.get_time() < end:
            self.command_velocity(x, yaw)
            rate.sleep()
        self.pub_base_command.publish(Twist())

    def command_velocity(self, x: float = 0, yaw: float = 0) -> None:
        """Command speeds once [m/s, rad/s]."""
        self.pub_base_command.publish(Twist(linear=Vector3(x=x), angular=Vector3(z=yaw)))

    def move_to_pose(self, x: float, y: float, yaw: float, wait: bool = False) -> bool:
        """Send the base to a place of the map [m, rad]; with `wait` until it is there."""
        goal = PoseStamped()
        goal.header.frame_id, goal.header.stamp = "map", rospy.Time.now()
        goal.pose.position.x, goal.pose.position.y = x, y
        turned = goal.pose.orientation
        turned.x, turned.y, turned.z, turned.w = quaternion_from_euler(0, 0, yaw)
        if not (wait and self.use_move_base_action):
            self.pub_base_pose.publish(goal)
            return True
        self.mb_client.send_goal(MoveBaseGoal(goal))
        self.mb_client.wait_for_result()
        if self.mb_client.get_state() != actionlib.GoalStatus.SUCCEEDED:
            rospy.logerr("Did not successfully reach goal...")
            return False
        return True

    def base_odom_cb(self, msg: Any) -> None:
        """Keep the last odometry."""
        self.odom = msg.pose.pose

    def get_odom(self) -> list[float]:
        """Return x, y [m] and yaw [rad] in the frame of the odometry."""
        turned = self.odom.orientation
        quaternion = (turned.x, turned.y, turned.z, turned.w)
        yaw = euler_from_quaternion(quaternion)[2] if any(quaternion) else 0.0
        place = self.odom.position
        return [place.x, place.y, 0.0 if math.isnan(yaw) else yaw]
