"""What a robot state holds of each joint: position, velocity, acceleration and effort."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from .._library import library
from .robot_model import RobotModel

Array = NDArray[np.float64]


class JointValues:
    """Values of every joint of a model, by name and by group."""

    def __init__(self, robot_model: RobotModel) -> None:
        self._model = robot_model
        names = [joint.name for joint in robot_model._joints()]
        self._positions = dict.fromkeys(names, 0.0)
        self._velocities = dict.fromkeys(names, 0.0)
        self._accelerations = dict.fromkeys(names, 0.0)
        self._efforts = dict.fromkeys(names, 0.0)
        self._has_velocities = self._has_accelerations = False
        self._refresh: Callable[[], None] = _nothing

    # Values of joints by name

    @property
    def joint_positions(self) -> dict[str, float]:
        """The positions by joint [rad or m]; joints left out when it is set stay as they are."""
        self._refresh()
        return dict(self._positions)

    @joint_positions.setter
    def joint_positions(self, joint_positions: Mapping[str, float]) -> None:
        self._set_positions(joint_positions)

    @property
    def joint_velocities(self) -> dict[str, float]:
        """The velocities by joint [rad/s or m/s]."""
        return dict(self._velocities)

    @joint_velocities.setter
    def joint_velocities(self, joint_velocities: Mapping[str, float]) -> None:
        self._set(self._velocities, joint_velocities)
        self._has_velocities = True

    @property
    def joint_accelerations(self) -> dict[str, float]:
        """The accelerations by joint [rad/s^2 or m/s^2]."""
        return dict(self._accelerations)

    @joint_accelerations.setter
    def joint_accelerations(self, joint_accelerations: Mapping[str, float]) -> None:
        self._set(self._accelerations, joint_accelerations)
        self._has_accelerations = True

    @property
    def joint_efforts(self) -> dict[str, float]:
        """The efforts by joint [N m or N]."""
        return dict(self._efforts)

    @joint_efforts.setter
    def joint_efforts(self, joint_efforts: Mapping[str, float]) -> None:
        self._set(self._efforts, joint_efforts)

    # Values of a group, in its order

    def set_joint_group_positions(
        self, joint_model_group_name: str, position_values: Sequence[float]
    ) -> None:
        """Set the positions of a group's joints.

        Raises:
            RuntimeError: there is no such group; lists those there are.
            ValueError: there are more or fewer values than joints.
        """
        self._set_positions(self._named(joint_model_group_name, position_values))

    def set_joint_group_active_positions(
        self, joint_model_group_name: str, position_values: Sequence[float]
    ) -> None:
        """Set the positions of a group's joints that can be commanded; raise as the former."""
        self._set_positions(self._named(joint_model_group_name, position_values))

    def get_joint_group_positions(self, joint_model_group_name: str) -> Array:
        """Return the positions of a group's joints, (n_joints,) [rad or m]."""
        self._refresh()
        return self._listed(joint_model_group_name, self._positions)

    def set_joint_group_velocities(
        self, joint_model_group_name: str, velocity_values: Sequence[float]
    ) -> None:
        """Set the velocities of a group's joints; raise as for positions."""
        self.joint_velocities = self._named(joint_model_group_name, velocity_values)

    def get_joint_group_velocities(self, joint_model_group_name: str) -> Array:
        """Return the velocities of a group's joints, (n_joints,) [rad/s or m/s]."""
        return self._listed(joint_model_group_name, self._velocities)

    def set_joint_group_accelerations(
        self, joint_model_group_name: str, acceleration_values: Sequence[float]
    ) -> None:
        """Set the accelerations of a group's joints; raise as for positions."""
        self.joint_accelerations = self._named(joint_model_group_name, acceleration_values)

    def get_joint_group_accelerations(self, joint_model_group_name: str) -> Array:
        """Return the accelerations of a group's joints, (n_joints,) [rad/s^2 or m/s^2]."""
        return self._listed(joint_model_group_name, self._accelerations)

    # How

    def _named(self, group: str, values: Sequence[float]) -> dict[str, float]:
        joint_model_group = self._model._group(group)
        return dict(
            zip(
                joint_model_group.active_joint_model_names,
                joint_model_group._checked(values),
                strict=True,
            )
        )

    def _listed(self, group: str, values: Mapping[str, float]) -> Array:
        names = self._model._group(group).active_joint_model_names
        return np.array([values[name] for name in names], dtype=np.float64)

    def _set_positions(self, given: Mapping[str, float]) -> None:
        """Set positions; the fingers of a gripper follow those that are given."""
        self._set(self._positions, given)
        self._set(self._positions, library().server.robot.with_followers(given))

    def _set(self, values: dict[str, float], given: Mapping[str, float]) -> None:
        for name, value in given.items():
            if name not in values:
                raise self._model._no_variable(name, values)
            values[name] = float(value)


def _nothing() -> None:
    """Leave the state as it is: it is nobody's current one."""
