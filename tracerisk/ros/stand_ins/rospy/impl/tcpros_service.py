# ruff: noqa: F401 - what is imported here is what the module gives
"""Where programs find the classes of services that are public as `rospy.Service`."""

from tracerisk.ros.imports.exported import exported as _exported

from ..service import (
    Service,
    ServiceImpl,
    ServiceProxy,
    convert_return_to_response,
    wait_for_service,
)

__all__ = _exported(globals())
