"""A path of robot states in time."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from itertools import accumulate
from typing import Any

import numpy as np

from tracerisk.ros.messages.dialect import nanoseconds, set_time
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError
from tracerisk.twin.robots.robot_parts import Scaling

from .._library import library, log_error, new
from .robot_model import RobotModel
from .robot_state import RobotState

__all__ = ["RobotTrajectory"]


class RobotTrajectory:
    """Waypoints, each with the time since the one before [s]."""

    def __init__(self, robot_model: RobotModel) -> None:
        if not isinstance(robot_model, RobotModel):
            raise TypeError(f"RobotTrajectory takes a RobotModel, not {type(robot_model).__name__}")
        self._model = robot_model
        self._group = ""
        self._waypoints: list[RobotState] = []
        self._durations: list[float] = []

    def __getitem__(self, idx: int) -> RobotState:
        if not 0 <= idx < len(self._waypoints):
            raise IndexError(f"waypoint {idx} of a trajectory of {len(self._waypoints)}")
        return copy.copy(self._waypoints[idx])

    def __iter__(self) -> Iterator[tuple[RobotState, float]]:
        return iter(list(zip(self._waypoints, self._durations, strict=True)))

    def __len__(self) -> int:
        return len(self._waypoints)

    def __reverse__(self) -> RobotTrajectory:
        """Turn the path around, and return it."""
        self._waypoints.reverse()
        for waypoint in self._waypoints:
            # Along the same line, the other way.
            waypoint._velocities = {name: -v for name, v in waypoint._velocities.items()}
        if self._durations:
            self._durations = [self._durations[0], *reversed(self._durations[1:])]
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> RobotTrajectory:
        made = RobotTrajectory(self._model)
        made._group = self._group
        made._waypoints = [copy.copy(waypoint) for waypoint in self._waypoints]
        made._durations = list(self._durations)
        return made

    @property
    def joint_model_group_name(self) -> str:
        """The planning group that the trajectory is for; empty for the whole robot."""
        return self._group

    @joint_model_group_name.setter
    def joint_model_group_name(self, joint_model_group_name: str) -> None:
        if not self._model.has_joint_model_group(joint_model_group_name):
            log_error(self._model._no_group(joint_model_group_name))
            joint_model_group_name = ""
        self._group = joint_model_group_name

    @property
    def robot_model(self) -> RobotModel:
        """The model that the trajectory is for."""
        return self._model

    @property
    def duration(self) -> float:
        """The time from the beginning to the end [s]."""
        return sum(self._durations)

    @property
    def average_segment_duration(self) -> float:
        """The mean time between two waypoints [s]."""
        return self.duration / (len(self) - 1) if len(self) > 1 else 0.0

    def get_waypoint_durations(self) -> list[float]:
        """Return the time of each waypoint since the one before [s]."""
        return list(self._durations)

    def unwind(self) -> RobotTrajectory:
        """Unwind joints without limits, which must not jump by a whole turn; return the path."""
        for joint in self._model._joints():
            if joint.type == "continuous" and self._waypoints:
                turned = np.unwrap([one._positions[joint.name] for one in self._waypoints])
                for waypoint, value in zip(self._waypoints, turned, strict=True):
                    waypoint._take({joint.name: float(value)})
        return self

    # Timing

    def apply_totg_time_parameterization(
        self,
        velocity_scaling_factor: float,
        acceleration_scaling_factor: float,
        *,
        path_tolerance: float = 0.1,
        resample_dt: float = 0.1,
        min_angle_change: float = 0.001,
    ) -> bool:
        """Time the path anew for fractions of the rated speeds; return whether it could be done.

        `path_tolerance` is how far a blend may leave a waypoint [rad or m], `resample_dt` the
        longest time between two waypoints of the result [s]; a waypoint of which no joint is
        further than `min_angle_change` [rad or m] from the last one is dropped.
        """
        return self._retime(
            velocity_scaling_factor,
            acceleration_scaling_factor,
            path_tolerance=path_tolerance,
            resample_s=resample_dt,
            min_angle_change=min_angle_change,
        )

    def apply_ruckig_smoothing(
        self,
        velocity_scaling_factor: float,
        acceleration_scaling_factor: float,
        *,
        mitigate_overshoot: bool = False,
        overshoot_threshold: float = 0.01,
    ) -> bool:
        """Keep the timing where it is slow enough, else time the path anew.

        The twin knows no rated jerk; the path itself stays as it is.
        """
        before = copy.deepcopy(self)
        if not self._retime(velocity_scaling_factor, acceleration_scaling_factor):
            return False
        if before.duration >= self.duration:
            self._waypoints, self._durations = before._waypoints, before._durations
        return True

    def _retime(self, velocity: float, acceleration: float, **settings: float) -> bool:
        server = library().server
        try:
            if not self._waypoints:
                raise PlanningError("bad_request", "it has no waypoints")
            timed = server.retime(self._to_twin(), Scaling(velocity, acceleration), **settings)
        except PlanningError as error:
            message = f"a trajectory cannot be timed anew: {error.message}"
            server.execution.report("planning_failure", message)
            return False
        self._fill(timed, self._waypoints[0])
        return True

    # Messages

    def get_robot_trajectory_msg(self, joint_filter: Sequence[str] = ()) -> Any:
        """Return the trajectory as a RobotTrajectory message, of all joints or some."""
        message = new("moveit_msgs/RobotTrajectory")
        if not self._waypoints:
            return message
        names = [name for name in self._joints() if not joint_filter or name in joint_filter]
        out = message.joint_trajectory
        out.header.frame_id = self._model.model_frame
        out.joint_names = names
        points = []
        for waypoint, time in zip(self._waypoints, accumulate(self._durations), strict=True):
            point = new("trajectory_msgs/JointTrajectoryPoint")
            point.positions = [waypoint._positions[name] for name in names]
            if waypoint._has_velocities:
                point.velocities = [waypoint._velocities[name] for name in names]
            if waypoint._has_accelerations:
                point.accelerations = [waypoint._accelerations[name] for name in names]
            set_time(point.time_from_start, round(time * 1e9))
            points.append(point)
        out.points = points
        return message

    def set_robot_trajectory_msg(self, robot_state: RobotState, msg: Any) -> RobotTrajectory:
        """Take the points of a RobotTrajectory message, and return the trajectory.

        Joints that the message leaves out stand as in `robot_state`.

        Raises:
            RuntimeError: the message has a joint that the robot lacks, or an ill-formed point.
        """
        given = msg.joint_trajectory
        names = list(given.joint_names)
        known = robot_state.joint_positions
        for name in names:
            if name not in known:
                raise self._model._no_variable(name, known)
        waypoints, durations, before = [], [], 0
        for number, point in enumerate(given.points):
            if len(point.positions) != len(names):
                raise RuntimeError(
                    f"point {number} of the trajectory has {len(point.positions)} positions for "
                    f"{len(names)} joints"
                )
            waypoint = copy.copy(robot_state)
            waypoint._take(_pairs(names, point.positions))
            if len(point.velocities) == len(names):
                waypoint.joint_velocities = _pairs(names, point.velocities)
            if len(point.accelerations) == len(names):
                waypoint.joint_accelerations = _pairs(names, point.accelerations)
            waypoints.append(waypoint)
            time = nanoseconds(point.time_from_start)
            durations.append((time - before) / 1e9)
            before = time
        self._waypoints, self._durations = waypoints, durations
        if not self._group:
            self._group = self._group_with(names)
        return self

    # What the twin carries out

    def _fill(self, trajectory: JointTrajectory, start: RobotState) -> None:
        """Take the points of a trajectory of the twin, all other joints as in `start`."""
        accelerations = np.zeros_like(trajectory.velocity)
        if len(trajectory.time) > 1:
            accelerations = np.gradient(trajectory.velocity, trajectory.time, axis=0)
        waypoints = []
        for position, velocity, acceleration in zip(
            trajectory.position, trajectory.velocity, accelerations, strict=True
        ):
            waypoint = copy.copy(start)
            waypoint._take(_pairs(trajectory.joints, position))
            waypoint.joint_velocities = _pairs(trajectory.joints, velocity)
            waypoint.joint_accelerations = _pairs(trajectory.joints, acceleration)
            waypoints.append(waypoint)
        self._waypoints = waypoints
        self._durations = np.diff(trajectory.time, prepend=0.0).tolist()

    def _to_twin(self) -> JointTrajectory:
        names = tuple(self._joints())
        shape = (len(self._waypoints), len(names))
        time = np.cumsum(np.array(self._durations, dtype=np.float64))
        position = _rows(names, [one._positions for one in self._waypoints], shape)
        if all(one._has_velocities for one in self._waypoints):
            velocity = _rows(names, [one._velocities for one in self._waypoints], shape)
        elif len(time) > 1 and (np.diff(time) > 0.0).all():
            velocity = np.asarray(np.gradient(position, time, axis=0))
            velocity[[0, -1]] = 0.0
        else:
            velocity = np.zeros(shape)
        return JointTrajectory(names, time, position, velocity)

    def _joints(self) -> list[str]:
        if self._group:
            return self._model._group(self._group).active_joint_model_names
        return [joint.name for joint in self._model._joints()]

    def _group_with(self, names: Sequence[str]) -> str:
        """Return the smallest group that has all the joints, else none: the whole robot."""
        groups = [
            (len(group.active_joint_model_names), group.name)
            for group in self._model.joint_model_groups
            if names and set(names) <= set(group.active_joint_model_names)
        ]
        return min(groups)[1] if groups else ""


def _pairs(names: Sequence[str], values: Any) -> dict[str, float]:
    return {name: float(value) for name, value in zip(names, values, strict=True)}


def _rows(names: Sequence[str], values: Sequence[Any], shape: tuple[int, int]) -> Any:
    rows = [[value[name] for name in names] for value in values]
    return np.array(rows, dtype=np.float64).reshape(shape)
