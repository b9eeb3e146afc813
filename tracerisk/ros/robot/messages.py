"""Message classes of either ROS, for what the twin sends."""

from __future__ import annotations

from functools import cache
from typing import Any

from tracerisk.ros.messages.dialect import set_time
from tracerisk.ros.messages.fields import service_parts
from tracerisk.ros.time.clock import EPOCH_NS


class TwinMessages:
    """Makes messages of the ROS that the controller speaks; `interfaces` knows their classes."""

    def __init__(self, interfaces: Any) -> None:
        self._interfaces = interfaces

    @property
    def is_ros2(self) -> bool:
        """Whether the controller speaks ROS 2."""
        return hasattr(self._interfaces, "action")

    def new(self, name: str) -> Any:
        """Return an empty message `package/Name`."""
        return self._interfaces.message(name)()

    def part(self, action: str, part: str) -> Any:
        """Return an empty `Goal`, `Result` or `Feedback` of the action `package/Name`."""
        if self.is_ros2:
            return getattr(self._interfaces.action(action), part)()
        return self.new(action + part)

    def response(self, service: str) -> Any:
        """Return an empty response of the service `package/Name`."""
        return service_parts(self._interfaces, service)[1]()

    def has_service(self, service: str) -> bool:
        """Return whether the controller's ROS has the service `package/Name`."""
        # By the names alone: a class is made when it is first needed.
        package, _, name = service.partition("/")
        return name in self._service_names(package)

    def has_action(self, action: str) -> bool:
        """Return whether the controller's ROS has the action `package/Name`."""
        package, _, name = action.partition("/")
        if self.is_ros2:
            return name in self._action_names(package)
        return f"{name}Goal" in self._message_names(package)

    def has_message(self, message: str) -> bool:
        """Return whether the controller's ROS has the message `package/Name`."""
        package, _, name = message.partition("/")
        return name in self._message_names(package)

    def has_package(self, package: str) -> bool:
        """Return whether the controller's ROS has a package of messages."""
        return package in self._interfaces.packages

    def names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the names of a package's services, actions or messages, as `kind` says."""
        if kind == "service":
            return self._service_names(package)
        if kind == "message":
            return self._message_names(package)
        if self.is_ros2:
            return self._action_names(package)
        goals = (name for name in self._message_names(package) if name.endswith("ActionGoal"))
        return tuple(name.removesuffix("ActionGoal") for name in goals)

    def request(self, service: str) -> Any:
        """Return an empty request of the service `package/Name`."""
        return service_parts(self._interfaces, service)[0]()

    def is_used(self, package: str) -> bool:
        """Return whether the controller has a package, or has used a message or a service of it."""
        return bool(self._interfaces.is_used(package))

    @cache  # noqa: B019 - it lives as long as the run
    def _service_names(self, package: str) -> tuple[str, ...]:
        return tuple(self._interfaces.service_names(package))

    @cache  # noqa: B019 - it lives as long as the run
    def _message_names(self, package: str) -> tuple[str, ...]:
        return tuple(self._interfaces.message_names(package))

    @cache  # noqa: B019 - it lives as long as the run
    def _action_names(self, package: str) -> tuple[str, ...]:
        return tuple(self._interfaces.action_names(package))

    def stamp(self, header: Any, now_ns: int) -> None:
        """Set a header's time to the present."""
        set_time(header.stamp, EPOCH_NS + now_ns)
