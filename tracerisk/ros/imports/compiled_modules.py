"""A Cython module of the workspace that is not built here: `<name>.pyx` where it is looked for.

It can be imported, and the run says so. What its source defines raises where it is called.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from importlib.abc import Loader
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any, NoReturn

from tracerisk.ros.graph.runtime import current

_DEFINED = re.compile(
    r"^(?:(?:cpdef|def)[ \t]+(?:[\w.\[\],* \t]+[ \t])?|(?:cdef[ \t]+)?class[ \t]+)(\w+)[ \t]*[(:]",
    re.MULTILINE,
)


class NotBuiltError(RuntimeError):
    """Something of a compiled module is used, and the module is not built here."""


def compiled_module(fullname: str, path: Sequence[str]) -> ModuleSpec | None:
    """Return the spec of a module whose Cython source lies below one of `path`; None for none."""
    leaf = fullname.rpartition(".")[2]
    for each in path:
        file = Path(each, f"{leaf}.pyx")
        if file.is_file():
            return ModuleSpec(fullname, _CompiledLoader(file), origin=str(file))
    return None


class _CompiledLoader(Loader):
    def __init__(self, file: Path) -> None:
        self._file = file

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:  # noqa: ARG002
        return None

    def exec_module(self, module: ModuleType) -> None:
        name = module.__name__
        message = f"module '{name}' is compiled from {self._file.name}, and it is not built here"
        remedy = "build it in place: python setup.py build_ext --inplace"
        current().recorder.finding(
            "unprovided",
            f"{message}: what it defines raises when called; {remedy}",
            object_name=name,
        )
        text = self._file.read_text(encoding="utf-8", errors="replace")
        for each in _DEFINED.findall(text):
            vars(module)[each] = _raising(f"{message}: {each} cannot be called; {remedy}")


def _raising(message: str) -> Callable[..., NoReturn]:
    def function(*_: Any, **__: Any) -> NoReturn:
        raise NotBuiltError(message)

    return function
