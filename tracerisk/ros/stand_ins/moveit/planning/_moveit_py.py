"""MoveItPy: the entry to planning and execution."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter

from tracerisk.ros.graph.runtime import current

from ..core.controller_manager import ExecutionStatus
from ..core.robot_model import RobotModel
from ..core.robot_trajectory import RobotTrajectory
from ..utils import get_launch_params_filepaths
from ._planning_component import PlanningComponent
from ._scene_monitor import PlanningSceneMonitor
from ._trajectory_execution_manager import TrajectoryExecutionManager

_FORM = (
    "execute(): incompatible function arguments. The following argument types are supported:\n"
    "    1. (self: moveit.planning.MoveItPy, robot_trajectory: "
    "moveit.core.robot_trajectory.RobotTrajectory, controllers: list[str])"
)
_FORMS = f"{_FORM}, or in Humble (group_name, robot_trajectory, blocking=True)"


class MoveItPy:
    """A node of its own, with what plans and executes.

    The robot is that of the run, whatever `config_dict` or the files of parameters describe;
    their other parameters are the node's. The scene's service is there in any case.
    """

    def __init__(
        self,
        node_name: str = "moveit_py",
        name_space: str = "",
        launch_params_filepaths: Sequence[str] | None = None,
        config_dict: Mapping[str, Any] | None = None,
        provide_planning_service: bool = True,
        remappings: Mapping[str, str] | None = None,
    ) -> None:
        files = get_launch_params_filepaths() if launch_params_filepaths is None else ()
        files = list(launch_params_filepaths or files)
        arguments = [] if config_dict is not None else _flagged("--params-file", files)
        arguments += _flagged("--remap", [f"{a}:={b}" for a, b in (remappings or {}).items()])
        # A node of C++ has a context of its own: rclpy need not have begun.
        self._context = Context()
        self._context.init([])
        self._node = Node(
            node_name,
            context=self._context,
            namespace=name_space,
            cli_args=arguments,
            parameter_overrides=_parameters(config_dict or {}),
            allow_undeclared_parameters=True,
            automatically_declare_parameters_from_overrides=True,
        )
        self._model = RobotModel._of_run()
        self._monitor = PlanningSceneMonitor._of_run()
        self._execution_manager = TrajectoryExecutionManager._of_run()
        self._execution_manager._read(self._parameter)
        # It loads the robot and its planners, which takes longer than any connection.
        current().graph.carrier.pass_connections()

    def execute(self, *args: Any, **kwargs: Any) -> ExecutionStatus:
        """Execute a trajectory: (robot_trajectory, controllers); return the status at the end.

        In Humble it takes (group_name, robot_trajectory, blocking=True): without blocking the
        status is RUNNING, and the motion goes on. There, the forms of later builds from source
        are taken too; where the distribution is assumed, every form is.

        Raises:
            TypeError: the arguments are of no version of the library that may be meant.
        """
        names = ["robot_trajectory", "controllers"]
        if args and isinstance(args[0], str):
            names = ["group_name", "robot_trajectory", "blocking"]
        elif len(args) > 1 and isinstance(args[1], bool):
            names = ["robot_trajectory", "blocking", "controllers"]
        given = {**dict(zip(names, args, strict=False)), **kwargs}
        known = {"robot_trajectory", "controllers", "blocking", "group_name"}
        if len(args) > len(names) or "robot_trajectory" not in given or set(given) - known:
            raise TypeError(_FORMS)
        if set(given) != {"robot_trajectory", "controllers"}:
            distro = current().distro
            if not distro.is_assumed and not distro.value("moveit-py-older-execute"):
                raise TypeError(f"{_FORM}\n\nInvoked with: {_invoked_with(self, args, kwargs)}")
            distro.decided("moveit-py-older-execute")
        trajectory = given["robot_trajectory"]
        if trajectory is not None and not isinstance(trajectory, RobotTrajectory):
            raise TypeError(f"{_FORMS}; the trajectory is of type {type(trajectory).__name__}")
        if not isinstance(given.get("controllers", []), (list, tuple)):
            raise TypeError(f"{_FORMS}; controllers is a list of names")
        blocking = bool(given.get("blocking", True))
        return self._execution_manager._execute(trajectory, blocking=blocking)

    def get_planning_component(self, planning_component_name: str) -> PlanningComponent:
        """Return a new component that plans for a planning group.

        Raises:
            RuntimeError: the robot has no such group; lists those it has.
        """
        return PlanningComponent(planning_component_name, self)

    def get_planning_scene_monitor(self) -> PlanningSceneMonitor:
        """Return the monitor of the planning scene."""
        return self._monitor

    def get_trajectory_execution_manager(self) -> TrajectoryExecutionManager:
        """Return the manager of executions."""
        return self._execution_manager

    def get_trajactory_execution_manager(self) -> TrajectoryExecutionManager:
        """Return the manager of executions; so it is spelt in the first versions."""
        return self._execution_manager

    def get_robot_model(self) -> RobotModel:
        """Return the model of the robot."""
        return self._model

    def shutdown(self) -> None:
        """End the node."""
        if self._context.is_valid:
            self._node.destroy_node()
            self._context.shutdown()

    def _parameter(self, name: str, default: Any) -> Any:
        parameter = self._node.get_parameter_or(name, None)
        return default if parameter.value is None else parameter.value


def _invoked_with(self: Any, args: Sequence[Any], kwargs: Mapping[str, Any]) -> str:
    text = ", ".join(repr(value) for value in (self, *args))
    named = ", ".join(f"{key}={value!r}" for key, value in kwargs.items())
    return f"{text}; kwargs: {named}" if named else text


def _flagged(flag: str, values: Sequence[str]) -> list[str]:
    return [word for value in values for word in (flag, value)]


def _parameters(tree: Mapping[str, Any], prefix: str = "") -> list[Parameter]:
    """Return nested values as parameters with dots; what can be none is left out."""
    parameters: list[Parameter] = []
    for key, value in tree.items():
        if isinstance(value, Mapping):
            parameters += _parameters(value, f"{prefix}{key}.")
            continue
        try:
            parameters.append(Parameter(f"{prefix}{key}", value=_plain(value)))
        except (TypeError, ValueError):
            continue
    return parameters


def _plain(value: Any) -> Any:
    if isinstance(value, (list, tuple)):
        # A parameter's array has one type; numbers become those with a fraction.
        mixed = {type(one) for one in value} == {int, float}
        return [float(one) for one in value] if mixed else list(value)
    return value
