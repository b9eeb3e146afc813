"""Names that Python has removed, for controllers written for the Python of their ROS.

Noetic comes with Python 3.8 (REP 3 at ros.org): a controller that uses what 3.9, 3.10 and 3.11
removed works on its robot. "What's New in Python" names what was removed and what is the same.
"""

from __future__ import annotations

import base64
import collections
import collections.abc
import contextlib
import fractions
import inspect
import math
from collections.abc import Callable, Iterator
from sys import _getframe
from types import ModuleType
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import is_library
from tracerisk.ros.graph.runtime import current

_OLD = frozenset({"noetic"})
_REMOVED: dict[ModuleType, dict[str, Callable[[], Any]]] = {
    base64: {
        "encodestring": lambda: base64.encodebytes,
        "decodestring": lambda: base64.decodebytes,
    },
    collections: {
        name: lambda name=name: getattr(collections.abc, name)  # type: ignore[misc]
        for name in collections.abc.__all__
    },
    fractions: {"gcd": lambda: math.gcd},
    inspect: {"getargspec": lambda: _getargspec},
}
"""The modules, each with what has the removed names now."""

ArgSpec = collections.namedtuple("ArgSpec", "args varargs keywords defaults")


def _getargspec(function: Callable[..., Any]) -> ArgSpec:
    full = inspect.getfullargspec(function)
    return ArgSpec(full.args, full.varargs, full.varkw, full.defaults)


@contextlib.contextmanager
def removed_python_names(distro: str) -> Iterator[None]:
    """Serve the controller's code the names of the Python of its distribution, with a note."""
    changed = list(_REMOVED) if distro in _OLD else []
    for module in changed:
        vars(module)["__getattr__"] = _served(module, _REMOVED[module])
    try:
        yield
    finally:
        for module in changed:
            del vars(module)["__getattr__"]


def _served(module: ModuleType, names: dict[str, Callable[[], Any]]) -> Callable[[str], Any]:
    def served(name: str) -> Any:
        asker = _getframe(1)
        # A library in the environment asks which Python it has.
        if name not in names or is_library(asker.f_code.co_filename):
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        value = names[name]()
        where = f"{value.__module__}.{value.__name__}"
        if module is collections:
            where = f"collections.abc.{name}"
        what = f"{module.__name__}.{name}"
        current().recorder.finding(
            "removed_name",
            f"{what} is gone from Python; {where} stands for it, as in the Python of older ROS",
            Location(asker.f_code.co_filename, asker.f_lineno),
            object_name=what,
        )
        return value

    return served
