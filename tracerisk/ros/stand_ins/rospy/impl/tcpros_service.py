"""Where programs find the classes of services that are public as `rospy.Service`."""

from ..service import (
    Service,
    ServiceImpl,
    ServiceProxy,
    convert_return_to_response,
    wait_for_service,
)

__all__ = [
    "Service",
    "ServiceImpl",
    "ServiceProxy",
    "convert_return_to_response",
    "wait_for_service",
]
