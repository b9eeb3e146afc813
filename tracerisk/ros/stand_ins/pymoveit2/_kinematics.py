"""Forward and inverse kinematics by the services of move_group."""

from __future__ import annotations

from typing import Any

from moveit_msgs.msg import MoveItErrorCodes
from moveit_msgs.srv import GetPositionFK, GetPositionIK
from sensor_msgs.msg import JointState

from ._goals import Goals
from ._messages import init_joint_state, point, quaternion
from .utils import enum_to_str


class KinematicsServices(Goals):
    """Asks where links are, and for the joint state that leads to a pose."""

    joint_state: Any

    def _begin_kinematics(self) -> None:
        self._fk_client = self._client(GetPositionFK, "compute_fk")
        self._ik_client = self._client(GetPositionIK, "compute_ik")

    def _as_state(self, given: Any) -> Any:
        if isinstance(given, JointState):
            return given
        return init_joint_state(self._joint_names, given)

    def compute_fk(self, joint_state: Any = None, fk_link_names: Any = None) -> Any:
        """Return the pose of the end effector, or those of links; None where it failed."""
        future = self.compute_fk_async(joint_state, fk_link_names)
        if future is None:
            return None
        self._wait(future)
        return self.get_compute_fk_result(future, fk_link_names)

    def get_compute_fk_result(self, future: Any, fk_link_names: Any = None) -> Any:
        """Return the poses of a future."""
        if not future.done():
            self._warn("Cannot get FK result because future is not done.")
            return None
        answer = future.result()
        if answer.error_code.val != MoveItErrorCodes.SUCCESS:
            self._warn(f"FK computation failed! Error code: {answer.error_code.val}.")
            return None
        return answer.pose_stamped[0] if fk_link_names is None else answer.pose_stamped

    def compute_fk_async(self, joint_state: Any = None, fk_link_names: Any = None) -> Any:
        """Return the future of the poses of links."""
        request = GetPositionFK.Request()
        request.header.frame_id = self._base_link
        request.header.stamp = self._node.get_clock().now().to_msg()
        request.fk_link_names = [self._end_effector] if fk_link_names is None else fk_link_names
        given = self.joint_state if joint_state is None else joint_state
        if given is not None:
            request.robot_state.joint_state = self._as_state(given)
        if not self._is_ready(self._fk_client):
            return None
        return self._fk_client.call_async(request)

    def compute_ik(
        self,
        position: Any,
        quat_xyzw: Any,
        ik_link_name: str | None = None,
        start_joint_state: Any = None,
        constraints: Any = None,
        wait_for_server_timeout_sec: float | None = 1.0,
    ) -> Any:
        """Return the joint state that leads to a pose, None where there is none."""
        future = self.compute_ik_async(
            position,
            quat_xyzw,
            ik_link_name,
            start_joint_state,
            constraints,
            wait_for_server_timeout_sec,
        )
        if future is None:
            return None
        self._wait(future)
        return self.get_compute_ik_result(future)

    def get_compute_ik_result(self, future: Any) -> Any:
        """Return the joint state of a future."""
        if not future.done():
            self._warn("Cannot get IK result because future is not done.")
            return None
        answer = future.result()
        if answer.error_code.val != MoveItErrorCodes.SUCCESS:
            code = enum_to_str(MoveItErrorCodes, answer.error_code.val)
            self._warn(f"IK computation failed! Error code: {code}")
            return None
        return answer.solution.joint_state

    def compute_ik_async(
        self,
        position: Any,
        quat_xyzw: Any,
        ik_link_name: str | None = None,
        start_joint_state: Any = None,
        constraints: Any = None,
        wait_for_server_timeout_sec: float | None = 1.0,
    ) -> Any:
        """Return the future of the joint state that leads to a pose."""
        request = GetPositionIK.Request()
        asked = request.ik_request
        asked.group_name = self._group
        asked.avoid_collisions = True
        asked.ik_link_name = ik_link_name or ""
        asked.pose_stamped.header.frame_id = self._base_link
        asked.pose_stamped.header.stamp = self._node.get_clock().now().to_msg()
        asked.pose_stamped.pose.position = point(position)
        asked.pose_stamped.pose.orientation = quaternion(quat_xyzw)
        given = self.joint_state if start_joint_state is None else start_joint_state
        if given is not None:
            asked.robot_state.joint_state = self._as_state(given)
        if constraints is not None:
            asked.constraints = constraints
        if not self._is_ready(self._ik_client, wait_for_server_timeout_sec):
            return None
        return self._ik_client.call_async(request)
