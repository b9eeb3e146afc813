"""Stand-in for DR_common2 of Doosan: positions of joints and of the tool, segments of a path.

Source: doosan-robotics/doosan-robot2 common2/imp/DR_common2.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from DR_error2 import *  # noqa: F403 - as the library does
from DR_error2 import DR_ERROR_TYPE, DR_ERROR_VALUE, DR_Error

from tracerisk.ros.imports.exported import exported as _exported

POINT_COUNT = 6
DR_LINE, DR_CIRCLE = 0, 1


class _Position(list[Any]):
    """Six numbers, given one by one, or as a list or a position of the same kind."""

    def __init__(self, *values: Any) -> None:
        first = values[0] if values else 0
        if isinstance(first, list) and len(first) == POINT_COUNT:
            values = tuple(first)
        if len(values) > POINT_COUNT:
            raise TypeError(f"{type(self).__name__} takes {POINT_COUNT} numbers")
        numbers = [*values, *[0] * (POINT_COUNT - len(values))]
        if not is_number(numbers):
            raise DR_Error(DR_ERROR_TYPE, f"Invalid type : {self._names}.")
        super().__init__(numbers)

    _names = ""

    def __str__(self) -> str:
        return "[" + ", ".join(f"{value:0.3f}" for value in self) + "]"


class posj(_Position):
    """Positions of the joints [deg]."""

    _names = "q1, q2, q3, q4, q5, q6"

    def __init__(
        self, q1: Any = 0, q2: Any = 0, q3: Any = 0, q4: Any = 0, q5: Any = 0, q6: Any = 0
    ) -> None:
        super().__init__(q1, q2, q3, q4, q5, q6)


class posx(_Position):
    """A place [mm] and turns about z, y', z'' [deg]."""

    _names = "x, y, z, w, p, r"

    def __init__(
        self, x: Any = 0, y: Any = 0, z: Any = 0, w: Any = 0, p: Any = 0, r: Any = 0
    ) -> None:
        super().__init__(x, y, z, w, p, r)


class posb:
    """A segment of a path: a line to `posx1`, or a circle over it to `posx2`; `radius` [mm]."""

    def __init__(self, seg_type: int, posx1: Any, posx2: Any = None, radius: float = 0) -> None:
        if type(seg_type) is not int:
            raise DR_Error(DR_ERROR_TYPE, "Invalid type : seg_type")
        if seg_type not in (DR_LINE, DR_CIRCLE):
            raise DR_Error(DR_ERROR_VALUE, "Invalid value : seg_type")
        if (posx2 is None) is (seg_type == DR_CIRCLE):
            raise DR_Error(DR_ERROR_VALUE, "Invalid value : pos2")
        if type(radius) not in (int, float):
            raise DR_Error(DR_ERROR_TYPE, "Invalid type : radius")
        if radius < 0:
            raise DR_Error(DR_ERROR_VALUE, "Invalid value : radius")
        self._seg_type, self._radius = seg_type, radius
        self._posx1 = get_posx(posx1)
        self._posx2 = None if posx2 is None else get_posx(posx2)

    def to_list(self) -> list[Any]:
        """Return type, both positions and radius."""
        return [self._seg_type, self._posx1, self._posx2, self._radius]


def get_posj(pos: Any) -> posj:
    """Return positions of joints; a list of six numbers becomes one."""
    made: posj = _position(pos, posj)
    return made


def get_posx(pos: Any) -> posx:
    """Return a pose; a list of six numbers becomes one."""
    made: posx = _position(pos, posx)
    return made


def get_normal_pos(pos: Any, def_type: Any = None) -> Any:
    """Return a position of either kind as it is; a list becomes one of `def_type`."""
    if type(pos) in (posj, posx, np.ndarray):
        return pos
    if type(pos) is not list or def_type is None:
        raise DR_Error(DR_ERROR_TYPE, "Invalid type : pos", True)
    return _position(pos, def_type)


def _position(pos: Any, kind: Any) -> Any:
    is_list = type(pos) is list and len(pos) == POINT_COUNT
    if type(pos) is not kind and not is_list:
        raise DR_Error(DR_ERROR_TYPE, "Invalid type : pos", True)
    if not is_number(pos):
        raise DR_Error(DR_ERROR_VALUE, "Invalid value : pos", True)
    return pos if type(pos) is kind else kind(pos)


def is_number(data: Any) -> bool:
    """Return whether it is a number, or the first of some is one."""
    if isinstance(data, str):
        return False
    if isinstance(data, Iterable):
        return all(is_number(item) for item in list(data)[:1])
    try:
        float(data)
    except ValueError:
        return False
    return True


def dr_form(val: Any) -> str:
    """Return a value as text, numbers with three digits after the point."""
    if isinstance(val, list):
        return "[" + ", ".join(map(dr_form, val)) + "]"
    return f"{val:0.3f}" if type(val) in (int, float) else str(val)


def get_kargs(kargs: Mapping[str, Any], name: str) -> Any:
    """Return an argument by its name, None where it is not given."""
    return kargs.get(name)


__all__ = _exported(globals())
