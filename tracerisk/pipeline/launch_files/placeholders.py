"""Values that launch files compute with what is not here: libraries, packages, programs.

Such a value can be handed on, asked for attributes, called and indexed, and gives more of its
kind; a parameter that comes to hold one is left out, and the reading says so.
"""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

ABSENT_FOLDER = Path("/absent/share")
"""Where packages that are not here are said to be, by their names."""


class AbsentError(RuntimeError):
    """A text or a number is needed of a value that cannot be computed here."""


class Absent:
    """A value that cannot be computed here; `words` says what it would come from."""

    def __init__(self, words: str) -> None:
        self._words = words

    @property
    def words(self) -> str:
        """What the value would come from."""
        return self._words

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Absent(self._words)

    def __call__(self, *_: Any, **__: Any) -> Absent:
        """Return another such value."""
        return Absent(self._words)

    def __mro_entries__(self, _: tuple[Any, ...]) -> tuple[type, ...]:
        """Return what a class that derives from the value derives from instead."""
        words = self._words

        class FromAbsent:
            def __getattr__(self, name: str) -> Any:
                if name.startswith("__"):
                    raise AttributeError(name)
                return Absent(words)

        return (FromAbsent,)

    def __getitem__(self, _: Any) -> Absent:
        return Absent(self._words)

    def __setitem__(self, _: Any, __: Any) -> None:
        """Take what is put in, and forget it."""

    def __iter__(self) -> Iterator[Any]:
        return iter(())

    def __len__(self) -> int:
        return 0

    def __bool__(self) -> bool:
        return True

    def __enter__(self) -> Absent:
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the block."""

    def __add__(self, _: Any) -> Absent:
        return self

    __radd__ = __add__

    def __fspath__(self) -> str:
        raise AbsentError(f"{self._words} is not here")

    def __str__(self) -> str:
        raise AbsentError(f"{self._words} is not here")

    __format__ = object.__format__

    def __repr__(self) -> str:
        return f"Absent({self._words!r})"


class AbsentModule(ModuleType):
    """A module whose names are all absent values."""

    __path__: list[str]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Absent(f"{self.__name__}.{name}")


class AbsentFinder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds what nothing else finds: modules whose names are all absent values."""

    def __init__(self, never: Sequence[str]) -> None:
        self._never = frozenset(never)
        self._installed = tuple({*sysconfig.get_paths().values(), "<frozen"})

    def find_spec(
        self,
        fullname: str,
        path: Any = None,  # noqa: ARG002 - the import system gives it
        target: Any = None,  # noqa: ARG002
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for any module but those below the packages that are served whole."""
        top = fullname.partition(".")[0]
        if top in self._never or top in sys.stdlib_module_names:
            return None
        parent = sys.modules.get(fullname.rpartition(".")[0])
        if parent is not None and not isinstance(parent, AbsentModule):
            return None
        # An installed library knows how to do without what it looks for.
        if parent is None and self._asks_library():
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=True)

    def _asks_library(self) -> bool:
        frame = sys._getframe(2)
        while frame.f_back is not None and "importlib" in frame.f_code.co_filename:
            frame = frame.f_back
        return frame.f_code.co_filename.startswith(self._installed)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Return the module."""
        module = AbsentModule(spec.name)
        module.__path__ = []
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: the module has no code."""
