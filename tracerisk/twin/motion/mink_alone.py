"""Import mink without the solvers that it offers, of which no run calls one.

mink imports `qpsolvers`, and that scipy: a fifth of what a run's process imports.
"""

from __future__ import annotations

import sys
from contextlib import ExitStack
from importlib import import_module
from types import ModuleType
from typing import Any

from tracerisk.twin.physics import builder  # noqa: F401 - says that no window is needed

__all__ = ["mink"]

_SOLVERS = "qpsolvers"


class _OnFirstUse(ModuleType):
    """A package that is imported when something of it is first used."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module(self.__name__), name)


with ExitStack() as _without_solvers:
    if _SOLVERS not in sys.modules:
        _later = sys.modules[_SOLVERS] = _OnFirstUse(_SOLVERS)
        # The type that mink names of what a function of it returns.
        vars(_later)["Problem"] = object
        _without_solvers.callback(vars(_later).pop, "Problem")
        _without_solvers.callback(sys.modules.pop, _SOLVERS)
    import mink
