"""Stand-in for dynamic_reconfigure: parameters that are changed while a node runs (ROS 1)."""

from __future__ import annotations

__all__ = [
    "DynamicReconfigureCallbackException",
    "DynamicReconfigureParameterException",
    "find_reconfigure_services",
]


class DynamicReconfigureParameterException(Exception):
    """A parameter is not known, or cannot have the value."""


class DynamicReconfigureCallbackException(Exception):
    """The server's callback failed."""


def find_reconfigure_services() -> list[str]:
    """Return the names of the servers, sorted."""
    import rosservice

    result = rosservice.rosservice_find("dynamic_reconfigure/Reconfigure")
    return sorted(name.removesuffix("/set_parameters") for name in result)
