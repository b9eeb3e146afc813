"""Names that NumPy has removed, for controllers written for the NumPy of their ROS.

NumPy 1.24 took away `np.int` and its like, 2.0 more, and others arguments of functions. Noetic and
Humble come with a NumPy that has them, so a controller that uses them works on its robot.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
from collections.abc import Callable, Iterator
from sys import _getframe
from types import FrameType
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import is_library
from tracerisk.ros.graph.runtime import current

_BUILTINS: dict[str, Any] = {
    **{item.__name__: item for item in (int, float, bool, object, str, complex)},
    "long": int,
    "unicode": str,
}
_RENAMED = {
    "float_": "float64",
    "complex_": "complex128",
    "unicode_": "str_",
    "string_": "bytes_",
    "Inf": "inf",
    "Infinity": "inf",
    "infty": "inf",
    "PINF": "inf",
    "NaN": "nan",
    "product": "prod",
    "cumproduct": "cumprod",
    "alltrue": "all",
    "sometrue": "any",
    "round_": "round",
    "row_stack": "vstack",
    "in1d": "isin",
    "trapz": "trapezoid",
    "mat": "asmatrix",
}
_REMOVED_ARGUMENTS = {
    "save": ("fix_imports", ""),
    "histogram": ("normed", "density"),
    "histogram2d": ("normed", "density"),
}
"""Arguments by function, each with what it is called now; empty where it changed nothing."""


@contextlib.contextmanager
def removed_numpy_names() -> Iterator[None]:
    """Serve the controller's code the names that the installed NumPy has removed, with a note."""
    import numpy as np

    names: dict[str, Any] = vars(np)
    own: Callable[[str], Any] = names["__getattr__"]

    def served(name: str) -> Any:
        renamed = _RENAMED.get(name, "")
        asker = _getframe(1)
        # A library in the environment asks which NumPy it has.
        if is_library(asker.f_code.co_filename) or not (name in _BUILTINS or renamed in names):
            return own(name)
        text = f"numpy.{renamed}" if renamed else f"the builtin {_BUILTINS[name].__name__}"
        _note(f"numpy.{name}", f"{text} stands for it", asker)
        return names[renamed] if renamed else _BUILTINS[name]

    changed: dict[str, Any] = {"__getattr__": served}
    for name, (argument, renamed) in _REMOVED_ARGUMENTS.items():
        if argument not in inspect.signature(names[name]).parameters:
            changed[name] = _without(names[name], argument, renamed)
    before = {name: names[name] for name in changed}
    names.update(changed)
    try:
        yield
    finally:
        names.update(before)


def _without(function: Callable[..., Any], argument: str, renamed: str) -> Callable[..., Any]:
    """Return a function for who gives it an argument that it no longer takes."""

    @functools.wraps(function)
    def called(*values: Any, **named: Any) -> Any:
        asker = _getframe(1)
        if argument in named and not is_library(asker.f_code.co_filename):
            value = named.pop(argument)
            if renamed:
                named.setdefault(renamed, value)
            text = f"{renamed} stands for it" if renamed else "it is left out"
            _note(f"argument {argument} of numpy.{function.__name__}", text, asker)
        return function(*values, **named)

    return called


def _note(what: str, instead: str, asker: FrameType) -> None:
    current().recorder.finding(
        "removed_name",
        f"{what} is gone from the NumPy that is installed here; {instead}, as in the NumPy of "
        "older ROS",
        Location(asker.f_code.co_filename, asker.f_lineno),
        object_name=what,
    )
