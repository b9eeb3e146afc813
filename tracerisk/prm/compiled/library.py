"""The library of compiled loops, where there is one, and the sequences that its loops take.

It is C without a word of Python, so that one library serves every version of Python;
`hatch_build.py` makes it where there is a C compiler.
Where there is none, the functions of the same names run as Python, to the same last bit.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from functools import cache

from tracerisk.errors import DependencyError

TYPE_CHECKING = False
if TYPE_CHECKING:
    import ctypes
    from typing import Any

FILE = os.path.join(os.path.dirname(__file__), "loops.so")  # noqa: PTH118, PTH120 - no start needs pathlib
VERSION = 2
"""The version of the functions and arguments, as in `version.c`; an older library is not used."""
_MAPPED = 1 << 16
"""Longer sequences are mapped: their pages take memory when first written to, and are zeros."""


@cache
def library() -> ctypes.CDLL | None:
    """Return the compiled loops; `None` where they were not built, or for another machine."""
    if not os.path.exists(FILE):  # noqa: PTH110
        return None
    import ctypes

    try:
        loops = ctypes.CDLL(str(FILE))
        version = ctypes.c_int32.in_dll(loops, "loops_version").value
    except (OSError, ValueError):
        return None
    return loops if version == VERSION else None


def loop(name: str, takes: str, gives: type | None = None) -> Callable[..., Any]:
    """Return a compiled loop as a function.

    takes: a letter for each argument: `n` a whole number, `r` a real one; `i`, `l`, `d` and `?` a
        sequence of 32 bit or 64 bit integers, of doubles or of truth values in one piece, as
        `integers` and `floats` make them, or a NumPy array.
    gives: `int` where it returns a whole number.
    """
    import ctypes

    cdll = library()
    assert cdll is not None
    function = cdll[name]
    numbers: dict[str, tuple[Any, ...]] = {"n": (ctypes.c_int64,), "r": (ctypes.c_double,)}
    sequence = (ctypes.c_void_p, ctypes.c_int64)
    function.argtypes = [kind for letter in takes for kind in numbers.get(letter, sequence)]
    function.restype = ctypes.c_int64 if gives is int else None
    first_byte = ctypes.c_char.from_buffer
    address_of = ctypes.addressof

    def run(*arguments: Any) -> Any:
        passed: list[Any] = []
        for letter, argument in zip(takes, arguments, strict=True):
            if letter in numbers:
                passed.append(argument)
                continue
            view = memoryview(argument)
            if view.format != letter or not view.c_contiguous:
                raise TypeError(f"{name}: expected a sequence of '{letter}', found '{view.format}'")
            size = view.nbytes // view.itemsize
            if hasattr(argument, "ctypes"):
                passed += (argument.ctypes.data, size)
            else:
                passed += (address_of(first_byte(view)) if size else 0, size)
        return function(*passed)

    return run


def integers(size: int) -> Any:
    """Return so many zeros of 32 bits."""
    return _zeros("i", 4, size)


def floats(size: int) -> Any:
    """Return so many zeros of double precision."""
    return _zeros("d", 8, size)


def listed(items: Any) -> Any:
    """Return items as an array of 32-bit integers."""
    from array import array

    return array("i", items)


def listed_floats(items: Any) -> Any:
    """Return items as an array of double precision."""
    from array import array

    return array("d", items)


def _zeros(kind: str, width: int, size: int) -> Any:
    from array import array

    if size < _MAPPED:
        return array(kind, bytes(width * size))
    from mmap import mmap

    try:
        return memoryview(mmap(-1, width * size)).cast(kind)  # type: ignore[call-overload]
    except OSError as error:
        raise MemoryError(f"{width * size} bytes for a decision diagram") from error


def require_library(purpose: str) -> None:
    """Raise DependencyError where there are no compiled loops; `purpose` is what needs them."""
    if library() is None:
        raise no_library(purpose)


def no_library(purpose: str) -> DependencyError:
    """Return the error for a purpose that takes too long without the compiled loops."""
    if sys.platform == "win32":
        return DependencyError(
            f"{purpose} needs the compiled loops, which are for Linux and macOS; use WSL"
        )
    return DependencyError(
        f"{purpose} needs the compiled loops, which this installation of tracerisk lacks; "
        "install a C compiler, then reinstall: pip install --force-reinstall --no-binary "
        "tracerisk tracerisk"
    )
