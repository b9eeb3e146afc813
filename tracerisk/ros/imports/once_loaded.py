"""Calls a function with a module of a library once a program has loaded it."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import Any

Serve = Callable[[ModuleType], None]
"""The function that is called with a module."""


@contextlib.contextmanager
def once_loaded(name: str, serve: Serve) -> Iterator[None]:
    """Call `serve` with the module `name` when it is loaded within the block, or was before."""
    finder = _Finder(name, serve)
    sys.meta_path.insert(0, finder)
    try:
        before = sys.modules.get(name)
        if before is not None:
            serve(before)
        yield
    finally:
        sys.meta_path.remove(finder)


class _Finder(MetaPathFinder):
    """Finds a module where it is installed."""

    def __init__(self, name: str, serve: Serve) -> None:
        self._name = name
        self._serve = serve
        self._is_looking = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        del path, target
        # A library may load a compiled module of its own name.
        if fullname != self._name or self._is_looking:
            return None
        self._is_looking = True
        try:
            spec = None if fullname in sys.modules else find_spec(fullname)
        finally:
            self._is_looking = False
        if spec is not None and spec.loader is not None:
            spec.loader = _Loader(spec.loader, self._serve)
        return spec


class _Loader(Loader):
    def __init__(self, real: Any, serve: Serve) -> None:
        self._real = real
        self._serve = serve

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        made: ModuleType | None = self._real.create_module(spec)
        return made

    def exec_module(self, module: ModuleType) -> None:
        self._real.exec_module(module)
        self._serve(sys.modules.get(module.__name__, module))
