"""The services of a controller manager: its controllers can be listed, loaded and switched.

Whatever is switched, the twin's joints can be commanded: one driver serves all its interfaces.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.declared_controllers import DeclaredController, DeclaredControllers
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "controller_manager_msgs"
BROADCASTER = "joint_state_broadcaster"
_TYPES = {
    "follow_joint_trajectory": "JointTrajectoryController",
    "gripper_command": "GripperActionController",
}
_BROADCASTS = DeclaredController((), "JointStateBroadcaster")
_BEST_EFFORT = 1


def robot_controllers(runtime: Runtime) -> dict[str, DeclaredController]:
    """Return the controllers of the robot, and those that files of the workspace declare."""
    robot = runtime.twin.robot
    known = {
        each.name: DeclaredController(each.joints, _TYPES[each.type]) for each in robot.controllers
    }
    declared = runtime.client(DeclaredControllers)
    return known | dict(declared.of_robot(joint.name for joint in robot.joints))


class ControllerManager(TwinNode):
    """Answers for the controllers of the twin's robot, under any namespace.

    All of the robot's controllers run from the beginning, and those of its joints that files of
    the workspace declare. Starting one that is not known fails
    where the request is strict; others are loaded as they are named.
    """

    node = "/controller_manager"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        for name, kind, handle in (
            ("list_controllers", "ListControllers", self._list),
            ("list_controller_types", "ListControllerTypes", self._list_types),
            ("load_controller", "LoadController", self._load),
            ("configure_controller", "ConfigureController", self._configure),
            ("unload_controller", "UnloadController", self._unload),
            ("switch_controller", "SwitchController", self._switch),
            ("reload_controller_libraries", "ReloadControllerLibraries", lambda *_: True),
        ):
            self._offer(name, f"{PACKAGE}/{kind}", handle)

    def _conclude(self, answer: Any, result: Any) -> None:
        if result is not None:
            answer.ok = result

    @cached_property
    def _controllers(self) -> dict[str, DeclaredController]:
        known = robot_controllers(self._runtime)
        known.setdefault(BROADCASTER, _BROADCASTS)
        return known

    @cached_property
    def _running(self) -> set[str]:
        return {*self._controllers}

    def _list(self, request: Any, answer: Any) -> None:
        answer.controller = [self._state(name) for name in self._controllers]

    def _state(self, name: str) -> Any:
        controller = self._controllers[name]
        joints, kind = controller.joints, controller.type
        is_declared = "/" in kind
        state = self._messages.new(f"{PACKAGE}/ControllerState")
        state.name = name
        is_running = name in self._running
        if hasattr(state, "claimed_interfaces"):
            state.state = "active" if is_running else "inactive"
            state.type = kind if is_declared else f"{_snake(kind)}/{kind}"
            claimed = [f"{joint}/position" for joint in joints]
            state.required_command_interfaces = claimed
            state.claimed_interfaces = claimed if is_running else []
        else:
            state.state = "running" if is_running else "stopped"
            state.type = kind if is_declared else f"position_controllers/{kind}"
            resources = self._messages.new(f"{PACKAGE}/HardwareInterfaceResources")
            resources.hardware_interface = "hardware_interface::PositionJointInterface"
            resources.resources = list(joints)
            state.claimed_resources = [resources]
        return state

    def _list_types(self, request: Any, answer: Any) -> None:
        answer.types = [f"position_controllers/{kind}" for kind in _TYPES.values()]
        answer.base_classes = ["controller_interface::ControllerBase"] * len(_TYPES)

    def _load(self, request: Any, answer: Any) -> bool:
        self._controllers.setdefault(request.name, _BROADCASTS)
        return True

    def _configure(self, request: Any, answer: Any) -> bool:
        return request.name in self._controllers

    def _unload(self, request: Any, answer: Any) -> bool:
        # As the real ones: a controller that runs is not unloaded.
        ok = request.name in self._controllers and request.name not in self._running
        if ok:
            del self._controllers[request.name]
        return ok

    def _switch(self, request: Any, answer: Any) -> bool:
        start = _names(request, "activate_controllers", "start_controllers")
        stop = _names(request, "deactivate_controllers", "stop_controllers")
        unknown = [name for name in (*start, *stop) if name not in self._controllers]
        ok = bool(not unknown or request.strictness <= _BEST_EFFORT)
        if ok:
            self._running -= set(stop)
            self._running |= {name for name in start if name in self._controllers}
        return ok


def _names(request: Any, *fields: str) -> list[str]:
    return next((list(getattr(request, name)) for name in fields if hasattr(request, name)), [])


def _snake(name: str) -> str:
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
