"""The arm of a Sawyer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from typing import Any

import intera_dataflow
import rospy
from geometry_msgs.msg import Pose, PoseStamped
from intera_core_msgs.msg import (
    CollisionDetectionState,
    EndpointState,
    EndpointStates,
    JointCommand,
)
from intera_core_msgs.srv import (
    SolvePositionFK,
    SolvePositionFKRequest,
    SolvePositionIK,
    SolvePositionIKRequest,
)
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Header

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.readings.limb_readings import LimbReadings

from . import settings
from .robot_params import RobotParams

__all__ = ["Limb"]


class Limb(LimbReadings):
    """Commands the joints of the arm, and reports where they are."""

    def __init__(self, limb: str = "right", synchronous_pub: bool = False) -> None:
        super().__init__(limb)
        self._tip_states: Any = None
        self._collision_state = False
        limbs = RobotParams().get_limb_names()
        if limb not in limbs:
            rospy.logerr(f"Cannot detect limb {limb} on this robot. Valid limbs are {limbs}.")
            return
        self._joint_names = RobotParams().get_joint_names(limb)
        self._command_msg = JointCommand()
        space = f"/robot/limb/{limb}/"
        self._pub_speed_ratio = rospy.Publisher(
            f"{space}set_speed_ratio", Float64, latch=True, queue_size=10
        )
        self._pub_joint_cmd = rospy.Publisher(
            f"{space}joint_command",
            JointCommand,
            tcp_nodelay=True,
            queue_size=None if synchronous_pub else 1,
        )
        self._pub_joint_cmd_timeout = rospy.Publisher(
            f"{space}joint_command_timeout", Float64, latch=True, queue_size=10
        )
        rospy.Subscriber(f"{space}endpoint_state", EndpointState, self._on_endpoint_states)
        rospy.Subscriber(f"{space}tip_states", EndpointStates, self._on_tip_states)
        rospy.Subscriber(
            f"{space}collision_detection_state", CollisionDetectionState, self._on_collision_state
        )
        rospy.Subscriber("robot/joint_states", JointState, self._on_joint_states)
        tools = f"ExternalTools/{limb}/PositionKinematicsNode/"
        self._iksvc = rospy.ServiceProxy(f"{tools}IKService", SolvePositionIK)
        self._fksvc = rospy.ServiceProxy(f"{tools}FKService", SolvePositionFK)
        text = f"{limb.capitalize()} limb init failed to get current"
        for known, topic in (
            (lambda: self._joint_angle, "robot/joint_states"),
            (lambda: self._cartesian_pose, f"{space}endpoint_state"),
            (lambda: self._tip_states, f"{space}tip_states"),
        ):
            name = topic.rsplit("/", 1)[-1]
            intera_dataflow.wait_for(known, timeout=5.0, timeout_msg=f"{text} {name} from {topic}")

    def _on_tip_states(self, msg: Any) -> None:
        self._tip_states = msg

    def _on_collision_state(self, msg: Any) -> None:
        self._collision_state = msg.collision_state

    # Where it is

    def joint_names(self) -> list[str]:
        """Return the joints, from the base to the wrist."""
        return self._joint_names

    def joint_ordered_angles(self) -> list[float]:
        """Return the angles of all joints, in their order [rad]."""
        return [self._joint_angle[name] for name in self._joint_names]

    def tip_states(self) -> Any:
        """Return the last EndpointStates."""
        return self._tip_states

    def tip_state(self, tip_name: str) -> Any:
        """Return the EndpointState of a tip, `None` for one that is not there."""
        names = list(self._tip_states.names)
        return (
            deepcopy(self._tip_states.states[names.index(tip_name)]) if tip_name in names else None
        )

    def has_collided(self) -> bool:
        """Return whether the arm struck something."""
        return self._collision_state

    # Commands

    def set_command_timeout(self, timeout: float) -> None:
        """Set how long a velocity lasts without another [s]."""
        self._pub_joint_cmd_timeout.publish(Float64(timeout))

    def exit_control_mode(self, timeout: float = 0.2) -> None:
        """Go back to positions, and stay at the present ones."""
        self.set_command_timeout(timeout)
        self.set_joint_positions(self.joint_angles())

    def set_joint_position_speed(self, speed: float = 0.3) -> None:
        """Set the fraction of the rated speed that moves to positions use."""
        self._pub_speed_ratio.publish(Float64(speed))

    def set_joint_positions(self, positions: Mapping[str, float]) -> None:
        """Command positions [rad]; returns at once."""
        self._command(JointCommand.POSITION_MODE, list(positions), position=positions.values())

    def set_joint_velocities(self, velocities: Mapping[str, float]) -> None:
        """Command velocities [rad/s], which last for the timeout."""
        self._command(JointCommand.VELOCITY_MODE, list(velocities), velocity=velocities.values())

    def set_joint_torques(self, torques: Mapping[str, float]) -> None:
        """Command torques [N m], which the twin refuses."""
        self._command(JointCommand.TORQUE_MODE, list(torques), effort=torques.values())

    def set_joint_trajectory(
        self,
        names: Sequence[str],
        positions: Sequence[float],
        velocities: Sequence[float],
        accelerations: Sequence[float],
    ) -> None:
        """Command the next point of a way: positions [rad], with velocities and accelerations."""
        self._command(
            JointCommand.TRAJECTORY_MODE,
            names,
            position=positions,
            velocity=velocities,
            acceleration=accelerations,
        )

    def _command(self, mode: int, names: Sequence[str], **values: Any) -> None:
        message = self._command_msg
        message.mode, message.names = mode, list(names)
        for field in ("position", "velocity", "acceleration", "effort"):
            setattr(message, field, [float(value) for value in values.get(field, ())])
        message.header.stamp = rospy.Time.now()
        self._pub_joint_cmd.publish(message)

    def move_to_neutral(self, timeout: float = 15.0, speed: float = 0.3) -> None:
        """Move to the neutral posture at a fraction of the rated speed, and wait."""
        neutral = rospy.get_param(f"/named_poses/{self.name}/poses/neutral")
        self.set_joint_position_speed(speed)
        angles = dict(zip(self.joint_names(), neutral, strict=True))
        return self.move_to_joint_positions(angles, timeout)

    def move_to_joint_positions(
        self,
        positions: Mapping[str, float],
        timeout: float = 15.0,
        threshold: float = settings.JOINT_ANGLE_TOLERANCE,
        test: Callable[[], bool] | None = None,
    ) -> None:
        """Move to positions, and wait until all are within `threshold`.

        Gives up after the timeout, at a collision, or when `test` says so.
        """

        def is_over() -> bool:
            if self._collision_state:
                rospy.logerr(f"{self.name.capitalize()} limb: collision detected")
                return True
            return (callable(test) and bool(test())) or self._is_at(positions, threshold)

        if self._is_at(positions, threshold):
            # Where the arm begins is assumed. A real one has to go there, which takes longer than
            # to connect what the limb has made.
            current().graph.carrier.pass_connections()
        self.set_joint_positions(positions)
        intera_dataflow.wait_for(
            is_over,
            timeout=timeout,
            timeout_msg=f"{self.name.capitalize()} limb failed to reach commanded joint positions",
            rate=100,
            raise_on_error=False,
            body=lambda: self.set_joint_positions(positions),
        )

    # Kinematics

    def fk_request(self, joint_angles: Mapping[str, float], end_point: str = "right_hand") -> Any:
        """Return the answer to where an end point is at some joint angles [rad]."""
        asked = SolvePositionFKRequest()
        state = JointState(name=list(joint_angles), position=list(joint_angles.values()))
        asked.configuration.append(state)
        asked.tip_names.append(end_point)
        return self._fksvc(asked)

    def joint_angles_to_cartesian_pose(
        self, joint_angles: Mapping[str, float], end_point: str = "right_hand"
    ) -> Any:
        """Return the pose of an end point at some joint angles [rad]."""
        return self.fk_request(joint_angles, end_point).pose_stamp[0].pose

    def ik_request(
        self,
        pose: Any,
        end_point: str = "right_hand",
        joint_seed: Mapping[str, float] | None = None,
        nullspace_goal: Mapping[str, float] | None = None,
        nullspace_gain: float = 0.4,
        allow_collision: bool = False,
    ) -> Any:
        """Return joint angles that bring an end point to a Pose or PoseStamped, False for none."""
        del allow_collision
        if isinstance(pose, Pose):
            pose = PoseStamped(header=Header(frame_id="base"), pose=pose)
        asked = SolvePositionIKRequest()
        asked.pose_stamp.append(pose)
        asked.tip_names.append(end_point)
        if joint_seed is not None:
            asked.seed_mode = SolvePositionIKRequest.SEED_USER
            asked.seed_angles.append(
                JointState(name=list(joint_seed), position=list(joint_seed.values()))
            )
        if nullspace_goal is not None:
            asked.use_nullspace_goal.append(True)
            asked.nullspace_gain.append(nullspace_gain)
            asked.nullspace_goal.append(
                JointState(name=list(nullspace_goal), position=list(nullspace_goal.values()))
            )
        found = self._iksvc(asked)
        if not found.result_type or found.result_type[0] <= 0:
            return False
        return dict(zip(found.joints[0].name, found.joints[0].position, strict=True))
