"""The base of a LoCoBot (ROS 2): the base itself stands still on the twin."""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion, Twist, Vector3
from nav2_msgs.action import NavigateToPose
from nav_msgs.msg import Odometry
from rclpy.action import ActionClient
from rclpy.callback_groups import ReentrantCallbackGroup
from sensor_msgs.msg import JointState
from tf_transformations import euler_from_quaternion, quaternion_from_euler

__all__ = ["InterbotixMobileBaseInterface"]

_HZ = 10.0


class InterbotixMobileBaseInterface:
    """Publishes twists, sends goals to Nav2, and keeps the odometry."""

    def __init__(
        self,
        core: Any,
        robot_name: str,
        topic_base_joint_states: str,
        topic_cmd_vel: str = "cmd_vel",
        nav_timeout_sec: float = 300.0,
        use_nav: bool = False,
    ) -> None:
        self.core, self.robot_name = core, robot_name
        self.nav_timeout_sec, self.use_nav = nav_timeout_sec, use_nav
        self.odom, self.base_states = Odometry(), JointState()
        self.future_nav: Any = None
        self.nav_to_pose_feedback: Any = None
        self._node = core.get_node()
        group = ReentrantCallbackGroup()
        self.pub_base_twist = self._node.create_publisher(Twist, topic_cmd_vel, 1)
        self.sub_base_states = self._node.create_subscription(
            JointState, topic_base_joint_states, self._base_states_cb, 1, callback_group=group
        )
        self.sub_base_odom = self._node.create_subscription(
            Odometry, "/mobile_base/odom", self._base_odom_cb, 1, callback_group=group
        )
        self.client_base_nav_to_pose = ActionClient(
            self._node, NavigateToPose, "navigate_to_pose", callback_group=group
        )
        core._sleep(0.5)

    def command_velocity_xyaw(self, x: float = 0.0, yaw: float = 0.0) -> None:
        """Command speeds once [m/s, rad/s]."""
        self.command_velocity(_twist(x, yaw))

    def command_velocity_xyaw_for_duration(
        self, x: float = 0.0, yaw: float = 0.0, duration: float = 1.0
    ) -> None:
        """Command speeds [m/s, rad/s] for a time [s], and then a stop."""
        self.command_velocity_for_duration(_twist(x, yaw), duration)

    def command_velocity_for_duration(
        self, twist: Any | None = None, duration: float = 1.0
    ) -> None:
        """Command a twist for a time [s], and then a stop."""
        for _ in range(max(round(duration * _HZ), 1)):
            self.command_velocity(twist)
            self.core._sleep(1.0 / _HZ)
        self.stop()

    def command_velocity(self, twist: Any | None = None) -> None:
        """Command a twist once."""
        self.pub_base_twist.publish(Twist() if twist is None else twist)

    def stop(self) -> None:
        """Command a stop."""
        self.pub_base_twist.publish(Twist())

    def command_pose(
        self,
        goal_pose: Any,
        behavior_tree: str = "",
        blocking: bool = False,
        frame_id: str = "map",
    ) -> bool:
        """Send the base to a pose; with `blocking` until it is there."""
        if not self.use_nav:
            self._node.logerror("`use_nav` set to `False`. Will not execute navigation.")
            return False
        pose = PoseStamped(pose=goal_pose)
        pose.header.frame_id, pose.header.stamp = frame_id, self.core._now()
        goal = NavigateToPose.Goal(pose=pose, behavior_tree=behavior_tree)
        sent = self.client_base_nav_to_pose.send_goal_async(
            goal, feedback_callback=self._nav_to_pose_feedback_cb
        )
        self._node.wait_until_future_complete(sent)
        self.goal_handle = sent.result()
        if not self.goal_handle.accepted:
            self._node.logerror("The navigation goal was rejected.")
            return False
        self.future_nav = self.goal_handle.get_result_async()
        if blocking:
            self._node.wait_until_future_complete(self.future_nav, self.nav_timeout_sec)
            return self.is_nav_complete()
        return True

    def command_pose_xyyaw(
        self,
        x: float,
        y: float,
        yaw: float = 0.0,
        behavior_tree: str = "",
        blocking: bool = False,
        frame_id: str = "map",
    ) -> bool:
        """Send the base to a place [m, rad]; see `command_pose`."""
        turned = dict(zip("xyzw", map(float, quaternion_from_euler(0, 0, yaw)), strict=True))
        pose = Pose(position=Point(x=float(x), y=float(y)), orientation=Quaternion(**turned))
        return self.command_pose(pose, behavior_tree, blocking, frame_id)

    def is_nav_complete(self) -> bool:
        """Return whether the base has arrived, or there was no goal."""
        if self.future_nav is None:
            return True
        if not self.future_nav.done():
            return False
        self.nav_status = self.future_nav.result().status
        if self.nav_status != GoalStatus.STATUS_SUCCEEDED:
            self._node.logerror(f"Navigation failed with status '{self.nav_status}'.")
        return True

    def get_nav_to_pose_feedback(self) -> Any:
        """Return the last feedback of a goal."""
        return self.nav_to_pose_feedback

    def get_base_states(self) -> Any:
        """Return the last states of the wheels."""
        return self.base_states

    def get_odom_xytheta(self) -> list[float]:
        """Return x, y [m] and yaw [rad] in the frame of the odometry."""
        pose = self.odom.pose.pose
        turned = pose.orientation
        yaw = euler_from_quaternion((turned.x, turned.y, turned.z, turned.w))[2]
        return [pose.position.x, pose.position.y, float(yaw)]

    def get_linear_velocity(self) -> Any:
        """Return the linear speed of the odometry."""
        return self.odom.twist.twist.linear

    def get_angular_velocity(self) -> Any:
        """Return the angular speed of the odometry."""
        return self.odom.twist.twist.angular

    def _base_states_cb(self, msg: Any) -> None:
        self.base_states = msg

    def _base_odom_cb(self, msg: Any) -> None:
        self.odom = msg

    def _nav_to_pose_feedback_cb(self, msg: Any) -> None:
        self.nav_to_pose_feedback = msg


def _twist(x: float, yaw: float) -> Any:
    return Twist(linear=Vector3(x=float(x)), angular=Vector3(z=float(yaw)))
