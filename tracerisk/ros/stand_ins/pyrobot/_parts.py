"""The parts beside the arm: grippers, a LoCoBot's camera and its base."""

from __future__ import annotations

import math
from typing import Any

import moveit_commander
import rospy
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from std_msgs.msg import Empty, Float64
from tf.transformations import euler_from_quaternion

from tracerisk.ros.controller.needs import asking_place
from tracerisk.ros.graph.runtime import current
from tracerisk.twin.robots.gripper_ends import gripper_ends

from ._configs import Config

_NEARLY = 0.02  # of a camera's joint [rad]


class Gripper:
    """Opens and closes the twin's gripper."""

    def __init__(self, configs: Config, **_: Any) -> None:
        self.configs = configs
        robot = current().twin.robot
        if not robot.grippers:
            raise RuntimeError(f"robot '{robot.name}' has no gripper; name another with --robot")
        self._gripper = robot.grippers[0]
        self._ends = gripper_ends(robot, self._gripper)
        self._group = moveit_commander.MoveGroupCommander(self._gripper.group)

    def _go(self, opening: float, wait: bool) -> None:
        signs = zip(self._gripper.joints, self._gripper.signs, strict=True)
        asked = {name: sign * opening for name, sign in signs}
        self._group.go(
            [asked.get(active_joint, 0.0) for active_joint in self._group.get_active_joints()], wait
        )

    def open(self, wait: bool = True, **_: Any) -> None:
        """Open it fully."""
        self._go(self._ends.opened, wait)

    def close(self, wait: bool = True, **_: Any) -> None:
        """Close it."""
        self._go(self._ends.closed, wait)

    def reset(self, wait: bool = True) -> None:
        """Open, close and open it."""
        self.open(wait)
        self.close(wait)
        self.open(wait)


class TopicGripper(Gripper):
    """A LoCoBot's gripper, which its driver moves for a message."""

    def __init__(self, configs: Config, wait_time: float = 3, **_: Any) -> None:
        super().__init__(configs)
        self.wait_time = wait_time
        self._is_closed = False
        self.pub_gripper_open = rospy.Publisher("/gripper/open", Empty, queue_size=1)
        self.pub_gripper_close = rospy.Publisher("/gripper/close", Empty, queue_size=1)

    def open(self, wait: bool = True, **_: Any) -> None:
        """Open it fully."""
        self._send(self.pub_gripper_open, False, wait)

    def close(self, wait: bool = True, **_: Any) -> None:
        """Close it."""
        self._send(self.pub_gripper_close, True, wait)

    def _send(self, topic: Any, closes: bool, wait: bool) -> None:
        topic.publish(Empty())
        self._is_closed = closes
        if wait:
            rospy.sleep(self.wait_time)

    def get_gripper_state(self) -> int:
        """Return 0 for an open gripper, 2 for one that holds something and 3 for a closed one."""
        if not self._is_closed:
            return 0
        twin = current().twin
        gripper = twin.robot.grippers[0]
        place = abs(twin.joint_state().positions[gripper.joints[0]])
        closed = abs(gripper_ends(twin.robot, gripper).closed)
        return 3 if math.isclose(place, closed, abs_tol=0.002) else 2


class Camera:
    """Pans and tilts a camera, which sees nothing on the twin."""

    def __init__(self, configs: Config) -> None:
        self.configs = configs
        self.set_pan_pub = rospy.Publisher("/pan/command", Float64, queue_size=1)
        self.set_tilt_pub = rospy.Publisher("/tilt/command", Float64, queue_size=1)

    @property
    def state(self) -> list[float]:
        """Return pan and tilt [rad]."""
        return [self.get_pan(), self.get_tilt()]

    def get_state(self) -> list[float]:
        """Return pan and tilt [rad]."""
        return self.state

    def get_pan(self) -> float:
        """Return how far it is turned [rad]."""
        return self._place("pan")

    def get_tilt(self) -> float:
        """Return how far it is tilted [rad]."""
        return self._place("tilt")

    def _joint(self, kind: str) -> Any:
        robot = current().twin.robot
        result = next((joint for joint in robot.joints if kind in joint.name), None)
        if result is None:
            raise RuntimeError(f"robot '{robot.name}' has no joint '{kind}'; see --robot")
        return result

    def _place(self, kind: str) -> float:
        return float(current().twin.joint_state().positions[self._joint(kind).name])

    def set_pan(self, pan: float, wait: bool = True) -> None:
        """Turn it [rad]."""
        self._command({"pan": pan}, wait)

    def set_tilt(self, tilt: float, wait: bool = True) -> None:
        """Tilt it [rad]."""
        self._command({"tilt": tilt}, wait)

    def set_pan_tilt(self, pan: float, tilt: float, wait: bool = True) -> None:
        """Turn and tilt it [rad]."""
        self._command({"pan": pan, "tilt": tilt}, wait)

    def reset(self) -> None:
        """Bring both joints to 0."""
        self.set_pan_tilt(0.0, 0.0)

    def _command(self, asked: dict[str, float], wait: bool) -> None:
        topics = {"pan": self.set_pan_pub, "tilt": self.set_tilt_pub}
        for kind, value in asked.items():
            joint = self._joint(kind)
            asked[kind] = min(max(float(value), joint.lower), joint.upper)
            topics[kind].publish(asked[kind])
        end = rospy.get_time() + (5.0 if wait else 0.0)
        while rospy.get_time() < end:
            if all(abs(self._place(kind) - value) < _NEARLY for kind, value in asked.items()):
                return
            rospy.sleep(0.1)

    def get_rgb(self) -> None:
        """Return no image; the run says so."""
        self._unseen("get_rgb")

    def get_depth(self) -> None:
        """Return no image; the run says so."""
        self._unseen("get_depth")

    def get_rgb_depth(self) -> tuple[None, None]:
        """Return no images; the run says so."""
        self._unseen("get_rgb_depth")
        return None, None

    def get_intrinsics(self) -> None:
        """Return nothing, as before a camera has published."""
        self._unseen("get_intrinsics")

    def get_current_pcd(self, in_cam: bool = True) -> None:
        """Return no points; the run says so."""
        del in_cam
        self._unseen("get_current_pcd")

    def _unseen(self, name: str) -> None:
        current().recorder.finding(
            "unprovided",
            f"pyrobot's camera.{name} needs a camera, and tracerisk simulates none",
            asking_place(),
        )


class Base:
    """Commands a base, which stands still on the twin."""

    def __init__(self, configs: Config) -> None:
        self.configs = configs
        topic = "/navigation_velocity_smoother/raw_cmd_vel"
        self.ctrl_pub = rospy.Publisher(topic, Twist, queue_size=1)
        self._odometry: Any = None
        self._hears = False

    def _keep(self, message: Any) -> None:
        self._odometry = message.pose.pose

    def stop(self) -> None:
        """Command a stop."""
        self.ctrl_pub.publish(Twist())

    def set_vel(self, fwd_speed: float, turn_speed: float, exe_time: float = 1) -> None:
        """Command speeds [m/s, rad/s] for a time [s]."""
        limits = self.configs.BASE
        ahead, around = limits.MAX_ABS_FWD_SPEED, limits.MAX_ABS_TURN_SPEED
        twist = Twist()
        twist.linear.x = min(max(fwd_speed, -ahead), ahead)
        twist.angular.z = min(max(turn_speed, -around), around)
        end = rospy.get_time() + exe_time
        self.ctrl_pub.publish(twist)
        while rospy.get_time() < end:
            self.ctrl_pub.publish(twist)
            rospy.sleep(1.0 / limits.BASE_CONTROL_RATE)

    def go_to_relative(self, xyt_position: Any, *_: Any, **__: Any) -> bool:
        """Leave the base where it is; the run says so."""
        return self._still("go_to_relative")

    def go_to_absolute(self, xyt_position: Any, *_: Any, **__: Any) -> bool:
        """Leave the base where it is; the run says so."""
        return self._still("go_to_absolute")

    def track_trajectory(self, states: Any, *_: Any, **__: Any) -> bool:
        """Leave the base where it is; the run says so."""
        return self._still("track_trajectory")

    def _still(self, name: str) -> bool:
        current().recorder.finding(
            "unprovided",
            f"pyrobot's base.{name} moves nothing: a base stands still on the twin",
            asking_place(),
        )
        return True

    def get_state(self, state_type: str = "odom") -> list[float]:
        """Return x, y [m] and yaw [rad] of the odometry, zeros without one."""
        del state_type
        if not self._hears:
            self._hears = True
            rospy.Subscriber("/odom", Odometry, self._keep)
        if self._odometry is None:
            return [0.0, 0.0, 0.0]
        place, turned = self._odometry.position, self._odometry.orientation
        yaw = euler_from_quaternion((turned.x, turned.y, turned.z, turned.w))[2]
        return [place.x, place.y, float(yaw)]
