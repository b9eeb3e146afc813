"""An arm of a Baxter."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import baxter_dataflow
import rospy
from baxter_core_msgs.msg import EndpointState, JointCommand
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from tracerisk.ros.graph.runtime import current
from tracerisk.ros.readings.limb_readings import LimbReadings

from . import settings

__all__ = ["Limb"]

_JOINTS = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")
_NEUTRAL = (0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0)
_KEPT = 0.98751  # of the position before, in each step of the filter; the rest is the goal's
_ADDED = 0.012488


class Limb(LimbReadings):
    """Commands the joints of an arm, `left` or `right`, and reports where they are."""

    def __init__(self, limb: str) -> None:
        super().__init__(limb)
        self._joint_names = {
            side: [f"{side}_{joint}" for joint in _JOINTS] for side in ("left", "right")
        }
        space = f"/robot/limb/{limb}/"
        self._command_msg = JointCommand()
        self._pub_speed_ratio = rospy.Publisher(
            space + "set_speed_ratio", Float64, latch=True, queue_size=10
        )
        self._pub_joint_cmd = rospy.Publisher(
            space + "joint_command", JointCommand, tcp_nodelay=True, queue_size=1
        )
        self._pub_joint_cmd_timeout = rospy.Publisher(
            space + "joint_command_timeout", Float64, latch=True, queue_size=10
        )
        rospy.Subscriber(space + "endpoint_state", EndpointState, self._on_endpoint_states)
        rospy.Subscriber("robot/joint_states", JointState, self._on_joint_states)
        text = f"{limb.capitalize()} limb init failed to get current"
        baxter_dataflow.wait_for(
            lambda: self._joint_angle, timeout_msg=f"{text} joint_states from robot/joint_states"
        )
        baxter_dataflow.wait_for(
            lambda: self._cartesian_pose,
            timeout_msg=f"{text} endpoint_state from {space}endpoint_state",
        )

    def joint_names(self) -> list[str]:
        """Return the joints, from the shoulder to the wrist."""
        return self._joint_names[self.name]

    def set_command_timeout(self, timeout: float) -> None:
        """Set how long a velocity lasts without another [s]."""
        self._pub_joint_cmd_timeout.publish(Float64(timeout))

    def exit_control_mode(self, timeout: float = 0.2) -> None:
        """Go back to positions, and stay at the present ones."""
        self.set_command_timeout(timeout)
        self.set_joint_positions(self.joint_angles())

    def set_joint_position_speed(self, speed: float) -> None:
        """Set the fraction of the rated speed that moves to positions use, 0.3 by default."""
        self._pub_speed_ratio.publish(Float64(speed))

    def set_joint_positions(self, positions: Mapping[str, float], raw: bool = False) -> None:
        """Command positions [rad]; returns at once."""
        mode = JointCommand.RAW_POSITION_MODE if raw else JointCommand.POSITION_MODE
        self._command(positions, mode)

    def set_joint_velocities(self, velocities: Mapping[str, float]) -> None:
        """Command velocities [rad/s], which last for the timeout."""
        self._command(velocities, JointCommand.VELOCITY_MODE)

    def set_joint_torques(self, torques: Mapping[str, float]) -> None:
        """Command torques [N m], which the twin refuses."""
        self._command(torques, JointCommand.TORQUE_MODE)

    def _command(self, asked: Mapping[str, float], mode: int) -> None:
        self._command_msg.names = list(asked)
        self._command_msg.command = [float(value) for value in asked.values()]
        self._command_msg.mode = mode
        self._pub_joint_cmd.publish(self._command_msg)

    def move_to_neutral(self, timeout: float = 15.0) -> None:
        """Move to the middle of the joints' ranges and wait."""
        angles = dict(zip(self.joint_names(), _NEUTRAL, strict=True))
        return self.move_to_joint_positions(angles, timeout)

    def move_to_joint_positions(
        self,
        positions: Mapping[str, float],
        timeout: float = 15.0,
        threshold: float = settings.JOINT_ANGLE_TOLERANCE,
        test: Callable[[], bool] | None = None,
    ) -> None:
        """Move to positions through a low-pass filter, and wait until all are within `threshold`.

        Gives up after the timeout, or when `test` says so.
        """
        command = self.joint_angles()

        def step() -> None:
            for joint, goal in positions.items():
                command[joint] = _ADDED * goal + _KEPT * command[joint]
            self.set_joint_positions(command)

        def is_there() -> bool:
            return (callable(test) and bool(test())) or self._is_at(positions, threshold)

        if is_there():
            # Where the arm begins is assumed. A real one has to go there, which takes longer than
            # to connect what the limb has made.
            current().graph.carrier.pass_connections()
        step()
        baxter_dataflow.wait_for(
            is_there,
            timeout=timeout,
            timeout_msg=f"{self.name.capitalize()} limb failed to reach commanded joint positions",
            rate=100,
            raise_on_error=False,
            body=step,
        )
