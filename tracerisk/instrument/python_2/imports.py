"""The import statement of Python 2: its library's names, and modules beside the one that imports.

A module of the library that lost or changed names is seen through a view: what the view has not is
the module's own, and what is assigned to it goes there.
"""

from __future__ import annotations

import builtins
import importlib
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from types import ModuleType
from typing import Any

from tracerisk.instrument.python_2.library import CHANGED, changed_names
from tracerisk.instrument.source.python_2 import RENAMED


class View(ModuleType):
    """A module of the library as Python 2 has it."""

    def __init__(self, name: str, sources: Sequence[ModuleType], names: Mapping[str, Any]) -> None:
        super().__init__(name, sources[0].__doc__ if sources else None)
        self.__dict__["_sources"] = tuple(sources)
        self.__dict__.update(names)
        public = {key for source in sources for key in _public(source)}
        self.__dict__["__all__"] = sorted(public | names.keys())

    def __getattr__(self, name: str) -> Any:
        for source in self.__dict__["_sources"]:
            if hasattr(source, name):
                return getattr(source, name)
        raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'", name=name)

    def __setattr__(self, name: str, value: Any) -> None:
        sources = self.__dict__["_sources"]
        if name in self.__dict__ or not sources:
            self.__dict__[name] = value
        else:
            setattr(sources[0], name, value)


def _public(module: ModuleType) -> Sequence[str]:
    return getattr(module, "__all__", None) or [n for n in dir(module) if not n.startswith("_")]


_views: dict[str, ModuleType] = {}


def import_module(
    name: str,
    names: Mapping[str, Any] | None = None,
    own: Mapping[str, Any] | None = None,
    wanted: Sequence[str] | None = (),
    level: int = 0,
) -> ModuleType:
    """Import a module for a source of Python 2; the arguments are those of `__import__`."""
    names = names or {}
    if level <= 0 and _stands_beside(name.partition(".")[0], names):
        return builtins.__import__(name, names, own, wanted or (), 1)
    if level > 0:
        return builtins.__import__(name, names, own, wanted or (), level)
    if name in _DOTTED:
        _serve(name)
    if name in RENAMED and not _is_there(name):
        return _view(name, RENAMED[name])
    module = builtins.__import__(name, names, own, wanted or (), 0)
    if name in CHANGED:
        return _view(name, (name,))
    top = name.partition(".")[0]
    return _view(top, (top,)) if top in CHANGED and not wanted else module


def reload_module(module: ModuleType) -> ModuleType:
    """Execute a module anew; of one of the library nothing is done."""
    if isinstance(module, View) or module.__name__ in sys.stdlib_module_names:
        return module
    return importlib.reload(module)


def _stands_beside(top: str, names: Mapping[str, Any]) -> bool:
    """Return whether a package holds a module that its own module imports by the bare name."""
    package = names.get("__package__") or ""
    if not package or names.get("__name__") == "__main__" or "absolute_import" in names:
        return False
    try:
        return find_spec(f"{package}.{top}") is not None
    except (ImportError, ValueError, AttributeError):
        return False


def _is_there(name: str) -> bool:
    """Return whether someone has written, or installed, a module by the name of the library's."""
    try:
        return find_spec(name) is not None
    except (ImportError, ValueError):
        return False


def _view(name: str, sources: Sequence[str]) -> ModuleType:
    if name not in _views:
        modules = [importlib.import_module(source) for source in sources]
        _views[name] = View(name, modules, changed_names(name))
    return _views[name]


_DOTTED = {"xml.etree.cElementTree": "xml.etree.ElementTree", "email.Utils": "email.utils"}


def _serve(name: str) -> None:
    """Make a module of a package importable by the name that it had."""
    module = importlib.import_module(_DOTTED[name])
    parent, _, leaf = name.rpartition(".")
    sys.modules.setdefault(name, module)
    setattr(importlib.import_module(parent), leaf, module)
