"""Parameters of the nodes that a bring-up starts: move_group, the state publisher, controllers.

In ROS 2 the services below each node's name give them, in ROS 1 the parameter server, unless a file
of the workspace has them. The descriptions are those of the twin's robot.
Sources: moveit/moveit and moveit/moveit2, launch files of moveit_setup_assistant and
moveit_ros/planning/rdf_loader; ros2/rclcpp rclcpp/src/rclcpp/parameter_service.cpp: of several
names of which one is not declared, none is answered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.parameter_files import flat
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.ros.robot.bring_up.system import (
    MANAGER,
    MOVE_GROUP,
    PARAMETER_SERVICES,
    STATE_PUBLISHER,
    SystemState,
)
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode
from tracerisk.twin.urdf.semantic_text import srdf_text
from tracerisk.twin.urdf.text import urdf_text

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

DESCRIPTION = "robot_description"
SEMANTIC, _PLANNING, _KINEMATICS = (
    f"{DESCRIPTION}_{part}" for part in ("semantic", "planning", "kinematics")
)
_SOLVER = {
    "kinematics_solver": "kdl_kinematics_plugin/KDLKinematicsPlugin",
    "kinematics_solver_search_resolution": 0.005,
    "kinematics_solver_timeout": 0.005,
}
_MASTERS = {"rosdistro": "noetic\n", "rosversion": "1.16.0\n", "run_id": "twin"}
"""What roscore sets in ROS 1."""
# rcl_interfaces/ParameterType, and the field of ParameterValue of each.
_FIELDS: dict[type, tuple[int, str]] = {
    bool: (1, "bool_value"), int: (2, "integer_value"), float: (3, "double_value"),
    str: (4, "string_value"),
}  # fmt: skip
_OF_LISTS: dict[type, tuple[int, str]] = {
    bool: (6, "bool_array_value"), int: (7, "integer_array_value"),
    float: (8, "double_array_value"), str: (9, "string_array_value"),
}  # fmt: skip


class NodeParameters(TwinNode):
    """Answers what the parameters of the bring-up's nodes are."""

    node = MOVE_GROUP

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._changed: dict[str, dict[str, Any]] = {}
        if messages.is_ros2:
            self._graph.services.offer_found(self._found)
            return
        parameters = self._graph.parameters
        offered: dict[str, Callable[[], Any]] = {
            SEMANTIC: lambda: self._semantic,
            _PLANNING: lambda: self._planning,
            _KINEMATICS: lambda: self._kinematics,
            **{f"/{name}": partial(str, text) for name, text in _MASTERS.items()},
            **{
                f"/{controller.name}": partial(self._of_controller, controller.name)
                for controller in runtime.twin.robot.controllers
            },
        }
        for name, value in offered.items():
            parameters.offer(name, partial(self._unless_in_workspace, name, value))

    def _unless_in_workspace(self, name: str, value: Callable[[], Any]) -> Any:
        """Return a parameter of the bring-up, `None` where the workspace's files give it."""
        full = name if name.startswith("/") else f"/{name}"
        return value() if self._graph.parameters.beyond(full) is None else None

    # Values

    @cached_property
    def _semantic(self) -> str:
        return srdf_text(self._twin.robot)

    @cached_property
    def _planning(self) -> dict[str, Any]:
        return {
            "joint_limits": {
                joint.name: {
                    "has_velocity_limits": True,
                    "max_velocity": joint.planned_velocity,
                    "has_acceleration_limits": True,
                    "max_acceleration": joint.planned_acceleration,
                }
                for joint in self._twin.robot.joints
            }
        }

    @cached_property
    def _kinematics(self) -> dict[str, Any]:
        grips = {gripper.group for gripper in self._twin.robot.grippers}
        return {name: dict(_SOLVER) for name in self._twin.robot.groups if name not in grips}

    def _of_controller(self, name: str) -> dict[str, Any]:
        controller = self._runtime.client(ControllerStates).all[name]
        if controller.settings:
            return dict(controller.settings)
        known: dict[str, Any] = {"joints": list(controller.joints)}
        if self._messages.is_ros2:
            known["command_interfaces"] = ["position"]
            known["state_interfaces"] = ["position", "velocity"]
        else:
            known["type"] = f"position_controllers/{controller.type.rpartition('/')[2]}"
        return known if controller.joints else {}

    def _values(self, node: str) -> Mapping[str, Any]:
        """Return the parameters of a node of ROS 2 by their dotted names."""
        robot = self._twin.robot
        values: dict[str, Any] = {"use_sim_time": False}
        if node in (MOVE_GROUP, STATE_PUBLISHER):
            values[DESCRIPTION] = urdf_text(robot)
        if node == MOVE_GROUP:
            values[SEMANTIC] = self._semantic
            values |= {_PLANNING: self._planning, _KINEMATICS: self._kinematics}
        elif node == STATE_PUBLISHER:
            values |= {"publish_frequency": 20.0, "frame_prefix": "", "ignore_timestamp": False}
        elif node == MANAGER:
            states = self._runtime.client(ControllerStates)
            values["update_rate"] = 100
            values |= {f"{name}.type": controller.type for name, controller in states.all.items()}
        else:
            values |= self._of_controller(node.removeprefix("/"))
        dotted = {
            key.strip("/").replace("/", "."): value
            for name, item in values.items()
            for key, value in flat(name, item)
        }
        return {**dotted, **self._changed.get(node, {})}

    # Services of ROS 2

    def _found(self, name: str) -> tuple[str, Callable[[Any], Any], str] | None:
        """Return type, handler and node of a service of the parameters of a node, if it is one."""
        space, _, leaf = name.rpartition("/")
        if leaf not in PARAMETER_SERVICES:
            return None
        node = f"/{space.rpartition('/')[2]}"
        if node not in self._runtime.client(SystemState).nodes_with_parameters():
            return None
        handle = {
            "get_parameters": self._get,
            "get_parameter_types": self._types,
            "list_parameters": self._list,
            "describe_parameters": self._describe,
            "set_parameters": self._set,
            "set_parameters_atomically": self._set_at_once,
        }[leaf]
        kind = PARAMETER_SERVICES[leaf]
        return kind, partial(self._answer_to, kind, partial(handle, node)), node

    def _asked(self, node: str, names: Any) -> list[tuple[str, Any]]:
        values = self._values(node)
        return [(name, values[name]) for name in names] if {*names} <= values.keys() else []

    def _get(self, node: str, request: Any, answer: Any) -> None:
        answer.values = [self._value(value) for _, value in self._asked(node, request.names)]

    def _types(self, node: str, request: Any, answer: Any) -> None:
        answer.types = [_field(value)[0] for _, value in self._asked(node, request.names)]

    def _describe(self, node: str, request: Any, answer: Any) -> None:
        result = []
        for name, value in self._asked(node, request.names):
            descriptor = self._messages.new("rcl_interfaces/ParameterDescriptor")
            descriptor.name, descriptor.type = name, _field(value)[0]
            result.append(descriptor)
        answer.descriptors = result

    def _list(self, node: str, request: Any, answer: Any) -> None:
        prefixes = tuple(f"{prefix}." for prefix in request.prefixes)
        names = sorted(self._values(node))
        answer.result.names = [
            name
            for name in names
            if not prefixes or name in request.prefixes or name.startswith(prefixes)
        ]

    def _set(self, node: str, request: Any, answer: Any) -> None:
        answer.results = [self._set_all(node, [parameter]) for parameter in request.parameters]

    def _set_at_once(self, node: str, request: Any, answer: Any) -> None:
        answer.result = self._set_all(node, request.parameters)

    def _set_all(self, node: str, parameters: Any) -> Any:
        """Set parameters that are declared, which the twin keeps and does not act on."""
        result = self._messages.new("rcl_interfaces/SetParametersResult")
        declared = self._values(node)
        unknown = [parameter.name for parameter in parameters if parameter.name not in declared]
        if unknown:
            result.reason = f"parameter '{unknown[0]}' cannot be set because it was not declared"
            return result
        for parameter in parameters:
            self._changed.setdefault(node, {})[parameter.name] = _plain(parameter.value)
            self._commands.report(
                "not_simulated",
                f"parameter '{parameter.name}' of {node} is set, and changes nothing in the "
                "simulation",
                object_name=f"{node} {parameter.name}",
            )
        result.successful = True
        return result

    def _value(self, value: Any) -> Any:
        message = self._messages.new("rcl_interfaces/ParameterValue")
        message.type, field = _field(value)
        if field:
            setattr(message, field, list(value) if isinstance(value, list | tuple) else value)
        return message


def _field(value: Any) -> tuple[int, str]:
    """Return the type of a parameter and the field of its value; 0 and none for no value."""
    if isinstance(value, list | tuple):
        return _OF_LISTS.get(type(value[0]), (0, "")) if value else _OF_LISTS[str]
    return _FIELDS.get(type(value), (0, ""))


def _plain(message: Any) -> Any:
    """Return the value that a rcl_interfaces/ParameterValue holds."""
    fields = dict([*_FIELDS.values(), *_OF_LISTS.values()])
    value = getattr(message, fields[message.type]) if message.type in fields else None
    return value if isinstance(value, bool | int | float | str | None) else list(value)
