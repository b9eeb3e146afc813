"""The services of a controller manager: its controllers can be listed, loaded and switched.

Whatever is switched, the twin's joints can be commanded: one driver serves all its interfaces.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

from tracerisk.ros.graph.declared_controllers import DeclaredController, DeclaredControllers
from tracerisk.ros.robot.messages import TwinMessages

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "controller_manager_msgs"
BROADCASTER = "joint_state_broadcaster"
_NODE = "/controller_manager"
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


class ControllerManager:
    """Answers for the controllers of the twin's robot, under any namespace.

    All of the robot's controllers run from the beginning, and those of its joints that files of
    the workspace declare. Starting one that is not known fails
    where the request is strict; others are loaded as they are named.
    """

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        self._messages = messages
        self._runtime = runtime
        for name, kind, handle in (
            ("list_controllers", "ListControllers", self._list),
            ("list_controller_types", "ListControllerTypes", self._list_types),
            ("load_controller", "LoadController", self._load),
            ("configure_controller", "ConfigureController", self._configure),
            ("unload_controller", "UnloadController", self._unload),
            ("switch_controller", "SwitchController", self._switch),
            ("reload_controller_libraries", "ReloadControllerLibraries", self._reload),
        ):
            if messages.has_service(f"{PACKAGE}/{kind}"):
                runtime.graph.offer(name, f"{PACKAGE}/{kind}", handle, node=_NODE)

    @cached_property
    def _controllers(self) -> dict[str, DeclaredController]:
        known = robot_controllers(self._runtime)
        known.setdefault(BROADCASTER, _BROADCASTS)
        return known

    @cached_property
    def _running(self) -> set[str]:
        return {*self._controllers}

    def _response(self, kind: str, *, ok: bool) -> Any:
        response = self._messages.response(f"{PACKAGE}/{kind}")
        response.ok = ok
        return response

    def _list(self, request: Any) -> Any:
        del request
        response = self._messages.response(f"{PACKAGE}/ListControllers")
        response.controller = [self._state(name) for name in self._controllers]
        return response

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

    def _list_types(self, request: Any) -> Any:
        del request
        response = self._messages.response(f"{PACKAGE}/ListControllerTypes")
        response.types = [f"position_controllers/{kind}" for kind in _TYPES.values()]
        response.base_classes = ["controller_interface::ControllerBase"] * len(_TYPES)
        return response

    def _load(self, request: Any) -> Any:
        self._controllers.setdefault(request.name, _BROADCASTS)
        return self._response("LoadController", ok=True)

    def _configure(self, request: Any) -> Any:
        return self._response("ConfigureController", ok=request.name in self._controllers)

    def _unload(self, request: Any) -> Any:
        # As the real ones: a controller that runs is not unloaded.
        ok = request.name in self._controllers and request.name not in self._running
        if ok:
            del self._controllers[request.name]
        return self._response("UnloadController", ok=ok)

    def _switch(self, request: Any) -> Any:
        start = _names(request, "activate_controllers", "start_controllers")
        stop = _names(request, "deactivate_controllers", "stop_controllers")
        unknown = [name for name in (*start, *stop) if name not in self._controllers]
        ok = not unknown or request.strictness <= _BEST_EFFORT
        if ok:
            self._running -= set(stop)
            self._running |= {name for name in start if name in self._controllers}
        return self._response("SwitchController", ok=ok)

    def _reload(self, request: Any) -> Any:
        del request
        return self._response("ReloadControllerLibraries", ok=True)


def _names(request: Any, *fields: str) -> list[str]:
    return next((list(getattr(request, name)) for name in fields if hasattr(request, name)), [])


def _snake(name: str) -> str:
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
