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

    def has(self, kind: str, name: str) -> bool:
        """Return whether the controller's ROS has a service, action or message `package/Name`."""
        # By the names alone: a class is made when it is first needed.
        package, _, short = name.partition("/")
        if kind == "action" and not self.is_ros2:
            kind, short = "message", f"{short}Goal"
        return short in self._names(kind, package)

    def has_package(self, package: str) -> bool:
        """Return whether the controller's ROS has a package of messages."""
        return package in self._interfaces.packages

    def names(self, package: str, kind: str) -> tuple[str, ...]:
        """Return the names of a package's services, actions or messages, as `kind` says."""
        if kind != "action" or self.is_ros2:
            return self._names(kind, package)
        goals = (name for name in self._names("message", package) if name.endswith("ActionGoal"))
        return tuple(name.removesuffix("ActionGoal") for name in goals)

    @cache  # noqa: B019 - it lives as long as the run
    def _names(self, kind: str, package: str) -> tuple[str, ...]:
        return tuple(getattr(self._interfaces, f"{kind}_names")(package))

    def request(self, service: str) -> Any:
        """Return an empty request of the service `package/Name`."""
        return service_parts(self._interfaces, service)[0]()

    def is_used(self, package: str) -> bool:
        """Return whether the controller has a package, or has used a message or a service of it."""
        return bool(self._interfaces.is_used(package))

    def stamp(self, header: Any, now_ns: int) -> None:
        """Set a header's time to the present."""
        set_time(header.stamp, EPOCH_NS + now_ns)
