"""Stand-in for DR_error2 of Doosan: the error of wrong arguments, which shuts down the node.

Source: doosan-robotics/doosan-robot2 common2/imp/DR_error2.py.
"""

from __future__ import annotations

from std_msgs.msg import Empty as _Empty

from tracerisk.ros.imports.exported import exported as _exported
from tracerisk.ros.messages.dialect import is_ros2 as _is_ros2

if _is_ros2(_Empty):
    import rclpy

    def _shut_down(reason: str) -> None:
        rclpy.shutdown()
else:
    import rospy

    def _shut_down(reason: str) -> None:
        rospy.signal_shutdown(reason)


DR_ERROR_TYPE, DR_ERROR_VALUE, DR_ERROR_RUNTIME, DR_ERROR_STOP = 1000, 1001, 1002, 1003
DR_ERROR_INVALID_MODBUS_NAME = 1010


class DR_Error(Exception):
    """An argument is of the wrong type or value; `type` is the number of the kind."""

    def __init__(self, type: int, msg: str = "", back: bool = False) -> None:
        super().__init__(msg)
        self.type, self.msg = type, msg
        _shut_down(msg)


__all__ = _exported(globals())
