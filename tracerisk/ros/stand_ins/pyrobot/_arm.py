"""An arm by joint positions, poses and straight ways of its end effector."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from typing import Any

import moveit_commander
import numpy as np
import rospy
import tf
from geometry_msgs.msg import Pose
from moveit_msgs.srv import GetPositionFK, GetPositionFKRequest, GetPositionIK, GetPositionIKRequest

from tracerisk.ros.graph.runtime import current

from ._configs import Config
from .utils.util import quat_to_rot_mat, quaternion_of

_TOLERANCE = 0.01, 0.1  # IK_POSITION_TOLERANCE [m], IK_ORIENTATION_TOLERANCE [rad]
_MOST_ERROR = 0.03  # MAX_EE_ERROR [m]
_NUMBERED = "joint_"
_CAMERA = ("pan", "tilt")
_NEUTRAL = {
    "sawyer": [0.0, -1.18, 0.0, 2.18, 0.0, 0.57, 3.3161],
    "ur5": [0.0, -np.pi / 2.0, np.pi / 2.0, -np.pi / 2.0, -np.pi / 2.0, 0.0],
}


class Arm:
    """Moves the twin's arm; positions of joints are in the order of its group."""

    def __init__(self, configs: Config, **config: Any) -> None:
        self.configs = configs
        robot = current().twin.robot
        held = {joint for gripper in robot.grippers for joint in gripper.joints}
        kept = {joint.name for joint in robot.arm_joints} - {*held, *_CAMERA}
        name = max(robot.groups, key=lambda group: len(kept & {*robot.groups[group].joints}))
        self.use_moveit = config.get("use_moveit", True)
        self.moveit_group = moveit_commander.MoveGroupCommander(name)
        self.moveit_group.set_goal_position_tolerance(_TOLERANCE[0])
        self.moveit_group.set_goal_orientation_tolerance(_TOLERANCE[1])
        self.arm_joint_names = list(self.moveit_group.get_active_joints())
        self.arm_dof = len(self.arm_joint_names)
        links = {link.name for link in robot.links}
        self.base_frame = _first(("locobot/base_link", "base_link"), links, robot.base_link)
        self.ee_frame = self.moveit_group.get_end_effector_link()
        mounts = ("locobot/arm_base_link", "arm_base_link")
        self._mount = _first(mounts, links, self.base_frame)
        self._home = np.zeros(self.arm_dof)
        if not configs.HAS_BASE:
            self._home = np.array(_NEUTRAL["ur5" if robot.name.startswith("ur") else "sawyer"])
        configs.ARM.update(
            MOVEGROUP_NAME=name,
            ARM_BASE_FRAME=self.base_frame,
            EE_FRAME=self.ee_frame,
            JOINT_NAMES=self.arm_joint_names,
        )
        self.moveit_group.set_pose_reference_frame(self.base_frame)
        self.tf_listener = tf.TransformListener()
        self._ik_service = rospy.ServiceProxy("/compute_ik", GetPositionIK)
        self._fk_service = rospy.ServiceProxy("/compute_fk", GetPositionFK)

    # Where it is

    @property
    def pose_ee(self) -> tuple[Any, Any, Any]:
        """Return place (3, 1), rotation (3, 3) and quaternion of the end effector."""
        return self.get_ee_pose(self.base_frame)

    def get_ee_pose(self, base_frame: str) -> tuple[Any, Any, Any]:
        """Return place, rotation and quaternion of the end effector, seen from a frame."""
        return self.get_transform(base_frame, self.ee_frame)

    def get_transform(self, src_frame: str, dest_frame: str) -> tuple[Any, Any, Any]:
        """Return place (3, 1), rotation (3, 3) and quaternion of a frame, seen from another."""
        now = rospy.Time(0)
        self.tf_listener.waitForTransform(src_frame, dest_frame, now, rospy.Duration(3))
        place, quaternion = self.tf_listener.lookupTransform(src_frame, dest_frame, now)
        quaternion = np.array(quaternion)
        return np.array(place).reshape(-1, 1), quat_to_rot_mat(quaternion), quaternion

    def get_joint_angles(self) -> Any:
        """Return the positions of the joints [rad]."""
        return np.array(self.moveit_group.get_current_joint_values())

    def get_joint_angle(self, joint: str) -> float:
        """Return the position of a joint [rad]; `joint_1` is the first one.

        Raises:
            ValueError: there is no such joint.
        """
        return float(self.get_joint_angles()[self._index(joint)])

    def get_joint_velocities(self) -> Any:
        """Return the speeds of the joints [rad/s]."""
        return self._state("velocity")

    def get_joint_velocity(self, joint: str) -> float:
        """Return the speed of a joint [rad/s]."""
        return float(self.get_joint_velocities()[self._index(joint)])

    def get_joint_torques(self) -> Any:
        """Return the efforts of the joints [Nm]."""
        return self._state("effort")

    def get_joint_torque(self, joint: str) -> float:
        """Return the effort of a joint [Nm]."""
        return float(self.get_joint_torques()[self._index(joint)])

    def _state(self, field: str) -> Any:
        state = current().twin.joint_state()
        values = getattr(state, field)
        return np.array([values[state.names.index(name)] for name in self.arm_joint_names])

    def _index(self, joint: str) -> int:
        number = joint.removeprefix(_NUMBERED)
        if joint.startswith(_NUMBERED) and number.isdigit() and 0 < int(number) <= self.arm_dof:
            return int(number) - 1
        if joint not in self.arm_joint_names:
            raise ValueError(f"{joint} not in arm joint list!")
        return self.arm_joint_names.index(joint)

    # Motions

    def go_home(self, plan: bool = False) -> Any:
        """Move to the library's home."""
        return self.set_joint_positions(self._home, plan=plan)

    def move_to_neutral(self) -> Any:
        """Move to where the library says that the arm is neutral."""
        return self.go_home()

    def set_joint_positions(
        self, positions: Any, plan: bool = True, wait: bool = True, **_: Any
    ) -> Any:
        """Move to joint positions [rad]; return whether they were reached, if it waits.

        Raises:
            ValueError: a plan is wanted, and the arm was made without MoveIt.
        """
        if plan:
            self._need_moveit()
        goal = [float(item) for item in np.asarray(positions).flatten()]
        done = self.moveit_group.go(goal, wait=wait)
        return bool(done) if wait else None

    def _need_moveit(self) -> None:
        if not self.use_moveit:
            raise ValueError("Moveit is not initialized, did you pass in use_moveit=True?")

    def set_ee_pose(
        self,
        position: Any,
        orientation: Any,
        plan: bool = True,
        wait: bool = True,
        numerical: bool = True,
        **_: Any,
    ) -> bool:
        """Bring the end effector to a pose in the base's frame; False where it cannot be."""
        del numerical
        if plan:
            self._need_moveit()
        pose = _pose(position, quaternion_of(orientation))
        self.moveit_group.set_pose_target(pose)
        done = bool(self.moveit_group.go(wait=wait))
        self.moveit_group.clear_pose_targets()
        if not done:
            rospy.logerr("No IK solution found; check if target_pose is valid")
        return done

    def set_ee_pose_pitch_roll(
        self,
        position: Any,
        pitch: float,
        roll: float | None = None,
        plan: bool = True,
        wait: bool = True,
        numerical: bool = True,
        **_: Any,
    ) -> bool:
        """Bring the end effector to a place, facing away from the arm's mount."""
        position = np.asarray(position, dtype=float).flatten()
        mount = self.get_transform(self.base_frame, self._mount)[0].flatten()
        yaw = np.arctan2(position[1] - mount[1], position[0] - mount[0])
        if roll is None:
            roll = self.get_joint_angle(self.arm_joint_names[-1])
        euler = np.array([yaw, pitch, roll])
        return self.set_ee_pose(position, euler, plan=plan, wait=wait, numerical=numerical)

    def move_ee_xyz(
        self,
        displacement: Any,
        eef_step: float = 0.005,
        numerical: bool = True,
        plan: bool = True,
        wait: bool = True,
        **_: Any,
    ) -> bool:
        """Move the end effector along a line [m]; return whether it is there."""
        del numerical
        if plan:
            self._need_moveit()
        place, _rotation, quaternion = self.pose_ee
        goal = place.flatten() + np.asarray(displacement, dtype=float).flatten()
        path, _share = self.moveit_group.compute_cartesian_path(
            [_pose(goal, quaternion)], eef_step, avoid_collisions=True
        )
        if not path.joint_trajectory.points:
            return False
        self.moveit_group.execute(path, wait=wait)
        if not wait:
            return True
        error = float(np.linalg.norm(self.pose_ee[0].flatten() - goal))
        if error > _MOST_ERROR:
            rospy.logerr("Move end effector along xyz failed!")
        return error <= _MOST_ERROR

    # Kinematics

    def compute_ik(
        self, position: Any, orientation: Any, qinit: Any = None, numerical: bool = True
    ) -> Any:
        """Return joint positions for a pose in the base's frame, None where there are none."""
        del numerical
        request = GetPositionIKRequest()
        asked = request.ik_request
        asked.group_name = self.moveit_group.get_name()
        asked.pose_stamped.header.frame_id = self.base_frame
        asked.pose_stamped.pose = _pose(position, quaternion_of(orientation))
        if qinit is not None:
            asked.robot_state.joint_state.name = list(self.arm_joint_names)
            asked.robot_state.joint_state.position = [float(q) for q in np.asarray(qinit).flat]
        answer = self._ik_service(request)
        if answer.error_code.val != 1:
            return None
        state = answer.solution.joint_state
        table = dict(zip(state.name, state.position, strict=True))
        return np.array([table[name] for name in self.arm_joint_names])

    def compute_fk_position(self, joint_positions: Any, des_frame: str) -> Any:
        """Return place (3, 1) and rotation (3, 3) of a frame at joint positions; None for none."""
        request = GetPositionFKRequest()
        request.header.frame_id = self.base_frame
        request.fk_link_names = [des_frame]
        state = request.robot_state.joint_state
        state.name = list(self.arm_joint_names)
        state.position = [float(item) for item in np.asarray(joint_positions).flat]
        answer = self._fk_service(request)
        if answer.error_code.val != 1 or not answer.pose_stamped:
            return None
        pose = answer.pose_stamped[0].pose
        turned = pose.orientation
        place = np.array([pose.position.x, pose.position.y, pose.position.z]).reshape(3, 1)
        return place, quat_to_rot_mat([turned.x, turned.y, turned.z, turned.w])

    def set_joint_velocities(self, velocities: Any, **_: Any) -> None:
        """Refuse: the stand-in moves arms by positions.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("tracerisk's stand-in for pyrobot has no control of velocities")

    def set_joint_torques(self, torques: Any, **_: Any) -> None:
        """Refuse: the stand-in moves arms by positions.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("tracerisk's stand-in for pyrobot has no control of torques")


def _first(names: Iterable[str], known: Collection[str], otherwise: str) -> str:
    return next((name for name in names if name in known), otherwise)


def _pose(position: Any, quaternion: Any) -> Any:
    pose = Pose()
    pose.position.x, pose.position.y, pose.position.z = map(float, np.asarray(position).flat)
    turned = pose.orientation
    turned.x, turned.y, turned.z, turned.w = map(float, quaternion)
    return pose
