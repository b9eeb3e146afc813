"""What a client of a planning group can set, and ask back, without moving anything."""

from collections.abc import Sequence
from typing import Any

from moveit_msgs.msg import (
    Constraints,
    PlannerInterfaceDescription,
    TrajectoryConstraints,
    WorkspaceParameters,
)

from tracerisk.errors import one_of
from tracerisk.ros.moveit.move_group import MoveGroupServer
from tracerisk.twin.robots.robot_parts import Scaling

from ._binding import check_arguments
from ._server import server
from .exception import MoveItCommanderException


class GroupSettings:
    """The settings of one client, with MoveIt's defaults."""

    def __init__(self, name: str, robot_description: str = "robot_description") -> None:
        self._server: MoveGroupServer = server()
        robot = self._server.robot
        if name not in robot.groups:
            raise RuntimeError(
                f"Group '{name}' was not found. Groups of robot '{robot.name}': "
                f"{one_of(robot.groups, name)}"
            )
        self._name = name
        self._end_effector_link = self._server.end_effector_link(name)
        self._reference_frame = self._server.planning_frame
        self._joint_tolerance = 1e-4
        self._position_tolerance = 1e-4
        self._orientation_tolerance = 1e-3
        self._scaling = self._server.default_scaling(robot_description)
        self._planning_time = 5.0
        self._planning_attempts = 1
        self._planner_id = ""
        self._pipeline_id = ""
        self._workspace = WorkspaceParameters()
        self._path_constraints = Constraints()
        self._trajectory_constraints = TrajectoryConstraints()
        self._speed_limit: tuple[float, str] | None = None

    def get_name(self) -> str:
        """Return the group's name."""
        return self._name

    # Frames

    def get_planning_frame(self) -> str:
        """Return the frame in which plans are made."""
        return self._server.planning_frame

    def get_pose_reference_frame(self) -> str:
        """Return the frame that poses without one are given in."""
        return self._reference_frame

    def set_pose_reference_frame(self, reference_frame: str) -> None:
        """Set the frame that poses without one are given in."""
        check_arguments("set_pose_reference_frame", (reference_frame, "std::string"))
        self._reference_frame = reference_frame

    # Tolerances

    def get_goal_tolerance(self) -> tuple[float, float, float]:
        """Return the tolerances of joints [rad or m], position [m] and orientation [rad]."""
        return (self._joint_tolerance, self._position_tolerance, self._orientation_tolerance)

    def get_goal_joint_tolerance(self) -> float:
        """Return the tolerance of joint goals [rad or m]."""
        return self._joint_tolerance

    def get_goal_position_tolerance(self) -> float:
        """Return the tolerance of a pose goal's position [m]."""
        return self._position_tolerance

    def get_goal_orientation_tolerance(self) -> float:
        """Return the tolerance of a pose goal's orientation [rad]."""
        return self._orientation_tolerance

    def set_goal_tolerance(self, value: float) -> None:
        """Set all three tolerances."""
        check_arguments("set_goal_tolerance", (value, "double"))
        self.set_goal_joint_tolerance(value)
        self.set_goal_position_tolerance(value)
        self.set_goal_orientation_tolerance(value)

    def set_goal_joint_tolerance(self, value: float) -> None:
        """Set the tolerance of joint goals [rad or m]."""
        check_arguments("set_goal_joint_tolerance", (value, "double"))
        self._joint_tolerance = float(value)

    def set_goal_position_tolerance(self, value: float) -> None:
        """Set the tolerance of a pose goal's position [m]."""
        check_arguments("set_goal_position_tolerance", (value, "double"))
        self._position_tolerance = float(value)

    def set_goal_orientation_tolerance(self, value: float) -> None:
        """Set the tolerance of a pose goal's orientation [rad]."""
        check_arguments("set_goal_orientation_tolerance", (value, "double"))
        self._orientation_tolerance = float(value)

    # The planner

    def set_planning_time(self, seconds: float) -> None:
        """Set the time that planning may take [s]; the twin's planner needs none of it."""
        check_arguments("set_planning_time", (seconds, "double"))
        if seconds > 0.0:
            self._planning_time = float(seconds)

    def get_planning_time(self) -> float:
        """Return the time that planning may take [s]."""
        return self._planning_time

    def set_planning_pipeline_id(self, planning_pipeline: str) -> None:
        """Name the planning pipeline; there is one, whatever its name."""
        check_arguments("set_planning_pipeline_id", (planning_pipeline, "std::string"))
        self._pipeline_id = planning_pipeline

    def get_planning_pipeline_id(self) -> str:
        """Return the name of the planning pipeline."""
        return self._pipeline_id

    def set_planner_id(self, planner_id: str) -> None:
        """Name the planner; there is one, whatever its name."""
        check_arguments("set_planner_id", (planner_id, "std::string"))
        self._planner_id = planner_id

    def get_planner_id(self) -> str:
        """Return the name of the planner."""
        return self._planner_id

    def set_num_planning_attempts(self, num_planning_attempts: int) -> None:
        """Set how often planning is tried; the twin's planner gives the same plan each time."""
        check_arguments("set_num_planning_attempts", (num_planning_attempts, "unsigned int"))
        self._planning_attempts = int(num_planning_attempts)

    def get_interface_description(self) -> Any:
        """Return a description of the planner."""
        return PlannerInterfaceDescription(name="tracerisk twin", planner_ids=[self._planner_id])

    def allow_looking(self, value: bool) -> None:
        """Allow sensors to look around first; there are none."""
        check_arguments("allow_looking", (value, "bool"))

    def allow_replanning(self, value: bool) -> None:
        """Allow planning anew when the scene changes; it changes under no plan of the twin."""
        check_arguments("allow_replanning", (value, "bool"))

    def set_workspace(self, ws: Sequence[float]) -> None:
        """Set the workspace as [], [minX, minY, maxX, maxY] or with Z; it binds mobile bases.

        Raises:
            ArgumentError: a value is no number.
            MoveItCommanderException: there are neither 0, 4 nor 6 values.
        """
        if len(ws) not in (0, 4, 6):
            raise MoveItCommanderException("Expected 0, 4 or 6 values in list specifying workspace")
        check_arguments("set_workspace", *((value, "double") for value in ws))
        low, high = list(ws[: len(ws) // 2]), list(ws[len(ws) // 2 :])
        for corner, values in (
            (self._workspace.min_corner, low),
            (self._workspace.max_corner, high),
        ):
            corner.x, corner.y, corner.z = (values + [0.0] * 3)[:3]
        self._workspace.header.frame_id = self.get_planning_frame()

    # Speeds

    def set_max_velocity_scaling_factor(self, value: float) -> None:
        """Set the fraction of the rated velocities that plans use, in (0, 1]."""
        self._scaling = Scaling(_fraction(value), self._scaling.acceleration)

    def set_max_acceleration_scaling_factor(self, value: float) -> None:
        """Set the fraction of the rated accelerations that plans use, in (0, 1]."""
        self._scaling = Scaling(self._scaling.velocity, _fraction(value))

    def limit_max_cartesian_link_speed(self, speed: float, link_name: str = "") -> None:
        """Limit the speed of a link (the end effector) in plans [m/s]."""
        if not speed > 0.0:
            raise MoveItCommanderException("Expected speed value to be greater than 0")
        self._speed_limit = (float(speed), link_name)

    def clear_max_cartesian_link_speed(self) -> None:
        """Limit no link's speed."""
        self._speed_limit = None

    # Constraints

    def get_known_constraints(self) -> list[str]:
        """Return the constraints of the warehouse; none is connected."""
        return []

    def set_constraints_database(self, host: str, port: int) -> None:
        """Name the warehouse.

        Raises:
            MoveItCommanderException: always; no warehouse can be connected.
        """
        raise MoveItCommanderException(
            f"the constraints database at {host}:{port} cannot be reached: a run on the twin has "
            "no network; give constraints by set_path_constraints"
        )

    def get_path_constraints(self) -> Any:
        """Return what plans must keep to on the way."""
        return self._path_constraints

    def set_path_constraints(self, value: Any) -> None:
        """Set what plans must keep to on the way; a plan that does not is a failure.

        Raises:
            ArgumentError: it is neither a Constraints nor the name of some.
            MoveItCommanderException: it is a name, of which the warehouse has none.
        """
        if value is None:
            self.clear_path_constraints()
        elif isinstance(value, Constraints):
            self._path_constraints = value
        else:
            check_arguments("set_path_constraints", (value, "std::string"))
            raise MoveItCommanderException(
                f"Unable to set path constraints {value}: no warehouse is connected that has them"
            )

    def clear_path_constraints(self) -> None:
        """Keep to nothing on the way."""
        self._path_constraints = Constraints()

    def get_trajectory_constraints(self) -> Any:
        """Return the trajectory constraints, which the planner does not use."""
        return self._trajectory_constraints

    def set_trajectory_constraints(self, value: Any) -> None:
        """Set trajectory constraints; MoveIt's usual planners do not use them, nor does this."""
        if value is None:
            self.clear_trajectory_constraints()
        elif isinstance(value, TrajectoryConstraints):
            self._trajectory_constraints = value
        elif isinstance(value, str):
            raise MoveItCommanderException(f"Unable to set trajectory constraints {value}")
        else:
            # The library joins its words and the value.
            raise TypeError(
                f'can only concatenate str (not "{type(value).__name__}") to str: trajectory '
                "constraints are a TrajectoryConstraints"
            )

    def clear_trajectory_constraints(self) -> None:
        """Forget the trajectory constraints."""
        self._trajectory_constraints = TrajectoryConstraints()

    def set_support_surface_name(self, value: str) -> None:
        """Name the object that a placed object stands on."""
        check_arguments("set_support_surface_name", (value, "std::string"))


def _fraction(value: float) -> float:
    if not (value > 0 and value <= 1):
        raise MoveItCommanderException("Expected value in the range from 0 to 1 for scaling factor")
    return float(value)
