"""Which controller managers of ROS 1 there are, and which of their controllers."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import rospy
import rosservice
from controller_manager_msgs.srv import ListControllers

from tracerisk.ros.imports.exported import defined as _defined

_LIST = "list_controllers"
_SERVICES = {
    _LIST: "ListControllers",
    "list_controller_types": "ListControllerTypes",
    "load_controller": "LoadController",
    "unload_controller": "UnloadController",
    "switch_controller": "SwitchController",
    "reload_controller_libraries": "ReloadControllerLibraries",
}


def get_controller_managers(
    namespace: str = "/", initial_guess: Sequence[str] | None = None
) -> list[str]:
    """Return the namespaces of the controller managers in a namespace, sorted.

    `initial_guess` changes nothing: those of it that are there are found again.
    """
    space = namespace.rstrip("/")
    listed = rosservice.get_service_list(namespace=namespace)
    names = {name.removesuffix(f"/{_LIST}") for name in listed if name.endswith(f"/{_LIST}")}
    # That of the twin is there when it is asked for.
    return sorted(filter(is_controller_manager, {*names, f"{space}/controller_manager"}))


def is_controller_manager(namespace: str) -> bool:
    """Return whether a namespace has the services of a controller manager."""
    space = namespace.rstrip("/")
    return all(
        rosservice.get_service_type(f"{space}/{name}") == f"controller_manager_msgs/{kind}"
        for name, kind in _SERVICES.items()
    )


def get_rosparam_controller_names(namespace: str = "/") -> list[str]:
    """Return the names of the controllers that parameters below a namespace set the type of."""
    space = rospy.resolve_name(namespace).rstrip("/") + "/"
    removesuffixes = (
        name.removeprefix(space).removesuffix("/type")
        for name in rospy.get_param_names()
        if name.startswith(space) and name.endswith("/type")
    )
    return [name for name in removesuffixes if name and "/" not in name]


class ControllerManagerLister:
    """Lists the controller managers of a namespace when it is called."""

    def __init__(self, namespace: str = "/") -> None:
        self._namespace = namespace

    def __call__(self) -> list[str]:
        """Return the namespaces of the managers."""
        return get_controller_managers(self._namespace)


class ControllerLister:
    """Lists the states of a manager's controllers when it is called; none where it is not there."""

    def __init__(self, namespace: str = "/controller_manager") -> None:
        self._service = rospy.ServiceProxy(f"{namespace}/{_LIST}", ListControllers)

    def __call__(self) -> list[Any]:
        """Return the states of the controllers."""
        try:
            return list(self._service().controller)
        except rospy.ServiceException:
            return []


def filter_by_name(
    ctrl_list: Iterable[Any], ctrl_name: str, match_substring: bool = False
) -> list[Any]:
    """Return the controllers of a name, or with a name that has it in it."""
    return [item for item in ctrl_list if _fits(item.name, ctrl_name, match_substring)]


def filter_by_type(
    ctrl_list: Iterable[Any], ctrl_type: str, match_substring: bool = False
) -> list[Any]:
    """Return the controllers of a type, or with a type that has it in it."""
    return [item for item in ctrl_list if _fits(item.type, ctrl_type, match_substring)]


def filter_by_state(
    ctrl_list: Iterable[Any], ctrl_state: str, match_substring: bool = False
) -> list[Any]:
    """Return the controllers in a state, or in one that has it in its name."""
    return [item for item in ctrl_list if _fits(item.state, ctrl_state, match_substring)]


def filter_by_hardware_interface(
    ctrl_list: Iterable[Any], hardware_interface: str, match_substring: bool = False
) -> list[Any]:
    """Return the controllers that claim something of an interface of the hardware."""
    return [
        item
        for item in ctrl_list
        if any(
            _fits(claimed.hardware_interface, hardware_interface, match_substring)
            for claimed in item.claimed_resources
        )
    ]


def filter_by_resources(
    ctrl_list: Iterable[Any],
    resources: Iterable[str],
    hardware_interface: str | None = None,
    match_any: bool = False,
) -> list[Any]:
    """Return the controllers that claim all of some resources, or any of them."""
    asked = set(resources)
    result = []
    for item in ctrl_list:
        claimed = {
            name
            for part in item.claimed_resources
            if hardware_interface in (None, part.hardware_interface)
            for name in part.resources
        }
        if (match_any and asked & claimed) or (not match_any and asked <= claimed):
            result.append(item)
    return result


def _fits(value: str, asked: str, is_part: bool) -> bool:
    return asked in value if is_part else asked == value


__all__ = _defined(globals())
