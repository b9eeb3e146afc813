"""What a gripper's interface does in either ROS."""

from __future__ import annotations

from typing import Any

from interbotix_xs_msgs.msg import JointSingleCommand


class GripperInterface:
    """Drives the servo of the fingers with an effort, until they are at their limits."""

    core: Any

    def _begin(self, name: str, pressure: float, lower_limit: float, upper_limit: float) -> None:
        self.gripper_moving = False
        self.gripper_command = JointSingleCommand(name=name)
        self.gripper_pressure_lower_limit = lower_limit
        self.gripper_pressure_upper_limit = upper_limit
        self.set_pressure(pressure)

    def _take_info(self, info: Any) -> None:
        self.left_finger_index = self.core.js_index_map[info.joint_names[0]]
        self.left_finger_lower_limit = info.joint_lower_limits[0]
        self.left_finger_upper_limit = info.joint_upper_limits[0]

    def _finger(self) -> float:
        with self.core.js_mutex:
            return float(self.core.joint_states.position[self.left_finger_index])

    def _is_at_limit(self) -> bool:
        effort, finger = self.gripper_command.cmd, self._finger()
        return bool(
            (effort > 0 and finger >= self.left_finger_upper_limit)
            or (effort < 0 and finger <= self.left_finger_lower_limit)
        )

    def _look(self) -> None:
        if self.gripper_moving and self._is_at_limit():
            self.gripper_command.cmd = 0.0
            self.core.pub_single.publish(self.gripper_command)
            self.gripper_moving = False

    def gripper_controller(self, effort: float, delay: float) -> None:
        """Drive the fingers with an effort (PWM or current) and wait; not beyond their limits."""
        self.gripper_command.cmd = float(effort)
        if effort != 0 and not self._is_at_limit():
            self.core.pub_single.publish(self.gripper_command)
            self.gripper_moving = True
            self.core._sleep(delay)

    def set_pressure(self, pressure: float) -> None:
        """Set the effort: a fraction of the way from the lower to the upper limit."""
        lower, upper = self.gripper_pressure_lower_limit, self.gripper_pressure_upper_limit
        self.gripper_value = lower + pressure * (upper - lower)
