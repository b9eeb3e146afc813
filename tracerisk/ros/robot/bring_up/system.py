"""What lists of a running system show: the controller's ends, and those of all that runs beside.

A bring-up starts nodes that publish, subscribe and serve before anybody asks for them. The twin
begins with most of that when somebody uses it; whoever lists or counts sees it from the beginning.
Names of MoveIt's topics: moveit/moveit moveit_ros/move_group and planning_scene_monitor.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from tracerisk.common.text.near_names import is_respelt
from tracerisk.ros.graph.actions import Actions, topics_of_action
from tracerisk.ros.robot.bring_up.states import ControllerStates
from tracerisk.twin.robots.robot_parts import OFFERED

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

MOVE_GROUP = "/move_group"
STATE_PUBLISHER = "/robot_state_publisher"
MANAGER = "/controller_manager"
DISPLAY = {False: "/rviz", True: "/rviz2"}
"""The node of the display, by whether it is of ROS 2."""
_DRIVER = "/robot_driver"
_SCENE = {
    "planning_scene": "moveit_msgs/PlanningScene",
    "collision_object": "moveit_msgs/CollisionObject",
    "attached_collision_object": "moveit_msgs/AttachedCollisionObject",
    "trajectory_execution_event": "std_msgs/String",
}
_OF_MOVE_GROUP = (
    "compute_ik GetPositionIK", "compute_fk GetPositionFK", "get_planning_scene GetPlanningScene",
    "compute_cartesian_path GetCartesianPath", "plan_kinematic_path GetMotionPlan",
    "apply_planning_scene ApplyPlanningScene", "check_state_validity GetStateValidity",
)  # fmt: skip
_OF_MANAGER = (
    "list_controllers ListControllers", "list_controller_types ListControllerTypes",
    "load_controller LoadController", "unload_controller UnloadController",
    "switch_controller SwitchController",
)  # fmt: skip
_OF_MANAGER_2 = (
    "configure_controller ConfigureController", "list_hardware_components ListHardwareComponents",
    "list_hardware_interfaces ListHardwareInterfaces",
)  # fmt: skip
PARAMETER_SERVICES = {
    "describe_parameters": "rcl_interfaces/DescribeParameters",
    "get_parameter_types": "rcl_interfaces/GetParameterTypes",
    "get_parameters": "rcl_interfaces/GetParameters",
    "list_parameters": "rcl_interfaces/ListParameters",
    "set_parameters": "rcl_interfaces/SetParameters",
    "set_parameters_atomically": "rcl_interfaces/SetParametersAtomically",
}
"""The services of each node of ROS 2, below its name."""

_ALSO_OFFERED: Mapping[str, tuple[str, ...]] = {
    "control_msgs/GripperCommand": ("/gripper_action",),
    "std_msgs/Float64MultiArray": ("/command", "/commands"),
}
"""What else follows the names of controllers, by type: in drivers of makers, and of numbers."""


@dataclass(frozen=True, slots=True)
class SystemEnd:
    """An end of a topic of the running system, or a service, whoever has it."""

    topic: str
    """Its name."""
    type_name: str
    """Its type, `package/Name`."""
    node: str
    """The node that has it."""
    is_sender: bool = False
    """Whether it publishes."""


class SystemState:
    """The running system as lists show it: `runtime.client(SystemState)`; the cell's part in it.

    Without a twin it has the ends on the graph alone.
    """

    is_of_world = True

    def __init__(self, runtime: Runtime) -> None:
        self._runtime = runtime
        self._graph = runtime.graph
        self._is_ros2 = runtime.distro.is_ros2

    # Topics

    def publications(self, topic: str) -> tuple[Any, ...]:
        """Return who publishes on a topic: ends on the graph, else what the bring-up has there."""
        result = self._graph.publications(topic)
        has_cells = any(not publication.by_controller for publication in result)
        return result if has_cells else (*result, *self._beside(topic, is_sender=True))

    def subscriptions(self, topic: str) -> tuple[Any, ...]:
        """Return who subscribes to a topic; see the last."""
        result = self._graph.subscriptions(topic)
        has_cells = any(not subscription.by_controller for subscription in result)
        return result if has_cells else (*result, *self._beside(topic, is_sender=False))

    def topic_names(self) -> tuple[str, ...]:
        """Return the names of all topics that have an end, sorted."""
        used = (
            name
            for name in self._graph.topic_names()
            if self._graph.publications(name) or self._graph.subscriptions(name)
        )
        return tuple(sorted({*used, *self._topics}))

    def published_topics(self) -> tuple[tuple[str, str], ...]:
        """Return name and type of each topic that somebody publishes, sorted."""
        senders = {name: self.publications(name) for name in self.topic_names()}
        return tuple((name, ends[0].type_name) for name, ends in senders.items() if ends)

    def _beside(self, topic: str, *, is_sender: bool) -> tuple[SystemEnd, ...]:
        return tuple(
            system_end
            for system_end in self._topics.get(topic, ())
            if system_end.is_sender is is_sender
        )

    @cached_property
    def _topics(self) -> dict[str, list[SystemEnd]]:
        topics: dict[str, list[SystemEnd]] = {}
        if self._runtime.twin is not None:
            for end in self._ends():
                topics.setdefault(end.topic, []).append(end)
        return topics

    def _ends(self) -> Iterator[SystemEnd]:
        space = "" if self._is_ros2 else MOVE_GROUP
        shown = "moveit_msgs/DisplayTrajectory"
        yield SystemEnd(f"{space}/display_planned_path", shown, MOVE_GROUP, is_sender=True)
        yield SystemEnd(f"{space}/display_planned_path", shown, DISPLAY[self._is_ros2])
        for name, kind in _SCENE.items():
            yield SystemEnd(f"/{name}", kind, MOVE_GROUP)
        if not self._is_ros2:
            yield SystemEnd("/rosout", "rosgraph_msgs/Log", "/rosout")
            yield SystemEnd("/rosout_agg", "rosgraph_msgs/Log", "/rosout", is_sender=True)
            for name, kind, node in self.actions():
                for topic, type_name, is_servers in topics_of_action(name, kind):
                    yield SystemEnd(topic, type_name, node, is_sender=is_servers)
        for name in self._running_trajectory_controllers():
            node = f"/{name}" if self._is_ros2 else _DRIVER
            command = "joint_trajectory" if self._is_ros2 else "command"
            state = "controller_state" if self._is_ros2 else "state"
            yield SystemEnd(f"/{name}/{command}", "trajectory_msgs/JointTrajectory", node)
            kind = "control_msgs/JointTrajectoryControllerState"
            yield SystemEnd(f"/{name}/{state}", kind, node, is_sender=True)

    def _running_trajectory_controllers(self) -> list[str]:
        states = self._runtime.client(ControllerStates)
        return sorted(name for name in states.running if "Trajectory" in states.all[name].type)

    # Actions, services and nodes

    def actions(self) -> tuple[tuple[str, str, str], ...]:
        """Return name, type and node of each action that the bring-up serves."""
        if self._runtime.twin is None:
            return ()
        name = "/move_action" if self._is_ros2 else MOVE_GROUP
        rows = [
            (name, "moveit_msgs/MoveGroup", MOVE_GROUP),
            ("/execute_trajectory", "moveit_msgs/ExecuteTrajectory", MOVE_GROUP),
        ]
        for controller in self._running_trajectory_controllers():
            node = f"/{controller}" if self._is_ros2 else _DRIVER
            action = f"/{controller}/follow_joint_trajectory"
            rows.append((action, "control_msgs/FollowJointTrajectory", node))
        return tuple(rows)

    def words_of_slip(self, name: str, type_name: str) -> str:
        """Return what to say of an action or a command topic whose name is likely misspelt, or "".

        Each is served under any name, for nobody knows those of a robot that no file describes.
        """
        controllers = self._runtime.client(ControllerStates).all
        offered = [leaf for rows in OFFERED.values() for _, leaf, kind in rows if kind == type_name]
        offered += _ALSO_OFFERED.get(type_name, ())
        known = [f"{controller}{leaf}" for controller in controllers for leaf in offered]
        known += [action.strip("/") for action, kind, _ in self.actions() if kind == type_name]
        parts = name.strip("/").split("/")
        ends = {other: "/".join(parts[-len(other.split("/")) :]) for other in known}
        if any(end == other for other, end in ends.items()):
            return ""
        meant = next((other for other, end in ends.items() if is_respelt(end, other)), None)
        if meant is None:
            return ""
        return (
            f"{name} is likely a mistake for {name.removesuffix(ends[meant])}{meant}: the twin "
            "serves it all the same, the robot may not"
        )

    def action_names_and_types(self) -> tuple[tuple[str, str], ...]:
        """Return name and type of every action that has a client or a server, sorted."""
        known = self._runtime.client(Actions).names_and_types()
        return tuple(sorted({*known, *((name, kind) for name, kind, _ in self.actions())}))

    def services(self) -> tuple[SystemEnd, ...]:
        """Return all services, sorted by name."""
        system_ends = {
            service_server.name: SystemEnd(
                service_server.name, service_server.type_name, service_server.node
            )
            for service_server in self._graph.services.served()
        }
        for end in self._services():
            system_ends.setdefault(end.topic, end)
        return tuple(end for _, end in sorted(system_ends.items()))

    def _services(self) -> Iterator[SystemEnd]:
        if self._runtime.twin is None:
            return
        for text in _OF_MOVE_GROUP:
            name, kind = text.split()
            yield SystemEnd(f"/{name}", f"moveit_msgs/{kind}", MOVE_GROUP)
        for text in (*_OF_MANAGER, *(_OF_MANAGER_2 if self._is_ros2 else ())):
            name, kind = text.split()
            yield SystemEnd(f"{MANAGER}/{name}", f"controller_manager_msgs/{kind}", MANAGER)
        if self._is_ros2:
            for node in self.nodes_with_parameters():
                for name, kind in PARAMETER_SERVICES.items():
                    yield SystemEnd(f"{node}/{name}", kind, node)

    def nodes_with_parameters(self) -> tuple[str, ...]:
        """Return the nodes of the bring-up whose parameters the twin knows, in ROS 2."""
        controllers = self._runtime.client(ControllerStates).all
        return (MOVE_GROUP, STATE_PUBLISHER, MANAGER, *(f"/{name}" for name in controllers))

    def nodes(self) -> tuple[str, ...]:
        """Return all nodes but those of the controller that have no end on the graph, sorted."""
        names = {end.node for end in self.services()}
        for topic in self.topic_names():
            ends = (*self.publications(topic), *self.subscriptions(topic))
            names.update(end.node for end in ends)
        if self._runtime.twin is not None:
            names |= {STATE_PUBLISHER, DISPLAY[self._is_ros2]}
        return tuple(sorted(names))
