"""A Cython module of the workspace that is not built here: `<name>.pyx` where it is looked for.

It can be imported, and the run says so. What its source defines raises where it is called.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import partial
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any, NoReturn

from tracerisk.common.text.bounded import file_text
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.cfg_modules import FilledLoader

_DEFINED = re.compile(
    r"^(?:(?:cpdef|def)[ \t]+(?:[\w.\[\],* \t]+[ \t])?|(?:cdef[ \t]+)?class[ \t]+)(\w+)[ \t]*[(:]",
    re.MULTILINE,
)


class NotBuiltError(RuntimeError):
    """Something of a compiled module is used, and the module is not built here."""


def compiled_module(fullname: str, path: Sequence[str]) -> ModuleSpec | None:
    """Return the spec of a module whose Cython source lies below one of `path`; None for none."""
    leaf = fullname.rpartition(".")[2]
    for name in path:
        file = Path(name, f"{leaf}.pyx")
        if file.is_file():
            return ModuleSpec(fullname, FilledLoader(partial(_defined, file)), origin=str(file))
    return None


def _defined(file: Path, name: str) -> dict[str, Any]:
    """Return what raises for each name that a source defines, and note that it is not built."""
    message = f"module '{name}' is compiled from {file.name}, and it is not built here"
    remedy = "build it in place: python setup.py build_ext --inplace"
    current().recorder.finding(
        "unprovided",
        f"{message}: what it defines raises when called; {remedy}",
        object_name=name,
    )
    text = file_text(file, errors="replace")
    return {
        item: _raising(f"{message}: {item} cannot be called; {remedy}")
        for item in _DEFINED.findall(text)
    }


def _raising(message: str) -> Callable[..., NoReturn]:
    def function(*_: Any, **__: Any) -> NoReturn:
        raise NotBuiltError(message)

    return function
