"""The services of a controller manager: its controllers can be listed, loaded and switched.

What is known to be inactive takes no commands: `ControllerStates`.
"""

# ruff: noqa: ARG002 - every handler takes a request and an answer
from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from tracerisk.ros.robot.bring_up.states import TYPES, ControllerStates
from tracerisk.ros.robot.messages import TwinMessages
from tracerisk.ros.robot.twin_node import TwinNode

if TYPE_CHECKING:
    from tracerisk.ros.graph.runtime import Runtime

PACKAGE = "controller_manager_msgs"
_STRICT = 2
_ACTIVE = 3, "active"
"""The state of hardware that runs, as lifecycle_msgs/State."""
_COMMANDED = ("position",)
_MEASURED = ("position", "velocity", "effort")
UNKNOWN_ALONE = "switch-of-unknown-alone"
CONFLICT = "switch-resource-conflict"


class ControllerManager(TwinNode):
    """Answers for the controllers of the twin's robot, under any namespace.

    Those of `ControllerStates` are loaded from the beginning, others as they are named.
    """

    node = "/controller_manager"

    def __init__(self, runtime: Runtime, messages: TwinMessages) -> None:
        super().__init__(runtime, messages)
        self._states = runtime.client(ControllerStates)
        for name, kind, handle in (
            ("list_controllers", "ListControllers", self._list),
            ("list_controller_types", "ListControllerTypes", self._list_types),
            ("load_controller", "LoadController", self._load),
            ("configure_controller", "ConfigureController", self._configure),
            ("unload_controller", "UnloadController", self._unload),
            ("switch_controller", "SwitchController", self._switch),
            ("list_hardware_components", "ListHardwareComponents", self._list_components),
            ("list_hardware_interfaces", "ListHardwareInterfaces", self._list_interfaces),
            ("set_hardware_component_state", "SetHardwareComponentState", self._set_component),
            ("reload_controller_libraries", "ReloadControllerLibraries", lambda *_: True),
        ):
            self._offer(name, f"{PACKAGE}/{kind}", handle)

    def _conclude(self, answer: Any, result: Any) -> None:
        if result is not None:
            answer.ok = result

    def _list(self, request: Any, answer: Any) -> None:
        answer.controller = [self._state(name) for name in self._states.all]

    def _state(self, name: str) -> Any:
        controller = self._states.all[name]
        joints, kind = controller.joints, controller.type
        is_declared = "/" in kind
        state = self._messages.new(f"{PACKAGE}/ControllerState")
        state.name = name
        is_running = name in self._states.running
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
            read = "PositionJoint" if joints else "JointState"
            resources.hardware_interface = f"hardware_interface::{read}Interface"
            resources.resources = list(joints)
            state.claimed_resources = [resources]
        return state

    def _list_types(self, request: Any, answer: Any) -> None:
        answer.types = [f"position_controllers/{kind}" for kind in TYPES.values()]
        answer.base_classes = ["controller_interface::ControllerBase"] * len(TYPES)

    def _list_components(self, request: Any, answer: Any) -> None:
        component = self._messages.new(f"{PACKAGE}/HardwareComponentState")
        component.name, component.type = self._twin.robot.name, "system"
        component.state.id, component.state.label = _ACTIVE
        component.command_interfaces = self._interfaces(_COMMANDED)
        component.state_interfaces = self._interfaces(_MEASURED)
        answer.component = [component]

    def _list_interfaces(self, request: Any, answer: Any) -> None:
        answer.command_interfaces = self._interfaces(_COMMANDED)
        answer.state_interfaces = self._interfaces(_MEASURED)

    def _interfaces(self, kinds: Sequence[str]) -> list[Any]:
        """Return the interfaces of the joints; a controller that runs claims what it commands."""
        running = (self._states.all[name] for name in self._states.running)
        claimed = {joint for controller in running for joint in controller.joints}
        interfaces = []
        for joint in self._twin.robot.joints:
            for kind in kinds:
                interface = self._messages.new(f"{PACKAGE}/HardwareInterface")
                interface.name, interface.is_available = f"{joint.name}/{kind}", True
                interface.is_claimed = kinds is _COMMANDED and joint.name in claimed
                interfaces.append(interface)
        return interfaces

    def _set_component(self, request: Any, answer: Any) -> bool:
        # The robot is active; any other state would let go of it.
        answer.state.id, answer.state.label = _ACTIVE
        is_kept = request.target_state.label in ("", _ACTIVE[1])
        return request.name == self._twin.robot.name and is_kept

    def _load(self, request: Any, answer: Any) -> bool:
        self._states.load(request.name)
        return True

    def _configure(self, request: Any, answer: Any) -> bool:
        return request.name in self._states.all

    def _unload(self, request: Any, answer: Any) -> bool:
        # As the real ones: a controller that runs is not unloaded.
        ok = request.name in self._states.all and request.name not in self._states.running
        if ok:
            del self._states.all[request.name]
        return ok

    def _switch(self, request: Any, answer: Any) -> bool:
        """Stop and start controllers: all of the request where it is strict, else what can be."""
        start = _names(request, "activate_controllers", "start_controllers")
        stop = _names(request, "deactivate_controllers", "stop_controllers")
        ok = self._switched(start, stop, is_strict=request.strictness == _STRICT)
        if not ok:
            self._commands.report(
                "service_refused",
                f"switch_controller switched nothing: start {', '.join(start) or 'none'}, stop "
                f"{', '.join(stop) or 'none'}; running: {', '.join(sorted(self._states.running))}",
                object_name="switch_controller",
            )
        return ok

    def _switched(self, start: list[str], stop: list[str], *, is_strict: bool) -> bool:
        rules, known = self._runtime.distro, self._states.all
        if rules.value(UNKNOWN_ALONE) == "fails" and any(
            names and not any(name in known for name in names) for names in (stop, start)
        ):
            return False
        stopped = [name for name in stop if name in self._states.running]
        running = self._states.running.difference(stopped)
        idle = [name for name in dict.fromkeys(start) if name in known and name not in running]
        started: list[str] = []
        for name in idle:
            if not self._states.conflicts(name, (*running, *started)):
                started.append(name)
        if len(started) < len(idle) and rules.value(CONFLICT) == "nothing is switched":
            return False
        if is_strict and (len(stopped) < len(stop) or len(started) < len(start)):
            return False
        self._states.switch(stopped, started)
        return True


def _names(request: Any, *fields: str) -> list[str]:
    # A request of Humble has the newer and the older fields, and both count.
    return [name for field in fields for name in getattr(request, field, ())]


def _snake(name: str) -> str:
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).lstrip("_")
