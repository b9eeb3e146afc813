"""Stand-in for DR_error2 of Doosan: the error of wrong arguments, which shuts down rclpy.

Source: doosan-robotics/doosan-robot2 common2/imp/DR_error2.py.
"""

from __future__ import annotations

import rclpy

from tracerisk.ros.imports.exported import exported as _exported

DR_ERROR_TYPE, DR_ERROR_VALUE, DR_ERROR_RUNTIME, DR_ERROR_STOP = 1000, 1001, 1002, 1003
DR_ERROR_INVALID_MODBUS_NAME = 1010


class DR_Error(Exception):
    """An argument is of the wrong type or value; `type` is the number of the kind."""

    def __init__(self, type: int, msg: str = "", back: bool = False) -> None:
        super().__init__(msg)
        self.type, self.msg = type, msg
        rclpy.shutdown()


__all__ = _exported(globals())
