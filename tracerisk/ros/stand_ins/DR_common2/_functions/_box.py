"""What a program sets for later motions, and how arguments become fields of a request."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from DR_common2 import DR_ERROR_TYPE, DR_ERROR_VALUE, DR_Error, is_number
from std_msgs.msg import Float64MultiArray

from ._calls import call

DR_BASE, DR_TOOL, DR_WORLD = 0, 1, 2
DR_TC_USER_MIN, DR_TC_USER_MAX = 101, 200
DR_COND_NONE = -10000


class Defaults:
    """The speeds [deg/s; mm/s, deg/s], accelerations and the frame of motions that give none."""

    def __init__(self) -> None:
        self.velj, self.accj = [0.0] * 6, [0.0] * 6
        self.velx: list[float] = [0.0, DR_COND_NONE]
        self.accx: list[float] = [0.0, DR_COND_NONE]
        self.coord = DR_BASE


DEFAULTS = Defaults()


def asked(kind: str, service: str, /, **fields: Any) -> Any:
    """Call a service of the controller and return its response."""
    return call(kind, service, fields)


def done(kind: str, service: str, /, **fields: Any) -> int:
    """Call a service and return 0 for success, else -1."""
    answer = asked(kind, service, **fields)
    return 0 if answer is not None and answer.success else -1


def rows(lists: Iterable[Iterable[Any]]) -> list[Any]:
    """Return lists of numbers as messages."""
    return [Float64MultiArray(data=numbers(item)) for item in lists]


def numbers(values: Iterable[Any]) -> list[float]:
    """Return values as floating-point numbers."""
    return [float(value) for value in values]


def wrong_type(name: str) -> DR_Error:
    """Return the error of an argument of a wrong type."""
    return DR_Error(DR_ERROR_TYPE, f"Invalid type : {name}", True)


def wrong_value(name: str) -> DR_Error:
    """Return the error of an argument of a wrong value."""
    return DR_Error(DR_ERROR_VALUE, f"Invalid value : {name}", True)


def whole(value: Any, name: str, least: int | None = None, most: int | None = None) -> int:
    """Return a whole number within limits.

    Raises:
        DR_Error: it is none, or past a limit.
    """
    if type(value) is not int:
        raise wrong_type(name)
    if (least is not None and value < least) or (most is not None and value > most):
        raise wrong_value(name)
    return value


def duration(value: Any, name: str) -> float:
    """Return a number that is not negative; None is 0.

    Raises:
        DR_Error: it is no number, or negative.
    """
    if value is None:
        return 0.0
    if type(value) not in (int, float):
        raise wrong_type(name)
    if value < 0:
        raise wrong_value(name)
    return float(value)


def frame(ref: Any) -> int:
    """Return the frame of a motion; None is the one that was set."""
    return whole(DEFAULTS.coord if ref is None else ref, "ref", DR_BASE, DR_TC_USER_MAX)


def rates(given: Any, default: Sequence[float], name: str) -> list[float]:
    """Return a speed or an acceleration for each of as many as there are defaults.

    Of two the second is that of turns; one number alone is of the first then.

    Raises:
        DR_Error: it is of another type, no number, or negative.
    """
    count = len(default)
    if given is None:
        made = list(default)
    elif type(given) in (int, float):
        made = [given] * count if count != 2 else [given, DR_COND_NONE]
    elif type(given) is list and len(given) == count:
        made = given
    else:
        raise wrong_type(name)
    if not is_number(made):
        raise wrong_value(name)
    if any(value < 0 and value != DR_COND_NONE for value in made):
        raise wrong_value(name)
    return numbers(made)


def first(given: Any, short: Any) -> Any:
    """Return an argument that has a long and a short name; None where it is not given."""
    return short if given is None else given
