"""The `__all__` of a module: what it imports, or what it defines."""

from __future__ import annotations

from collections.abc import Mapping
from types import FunctionType, ModuleType


def exported(names: Mapping[str, object], *modules: str) -> list[str]:
    """Return the public names of a module, given its `globals()`, sorted.

    Modules are left out, for each import of a part of a package leaves one behind; those that the
    library gives to programs are named in `modules`.
    """
    public = (
        name
        for name, value in names.items()
        if not name.startswith("_") and not isinstance(value, ModuleType)
    )
    return sorted([*public, *modules])


def defined(names: Mapping[str, object], *others: str) -> list[str]:
    """Return the public functions and classes that a module defines, sorted, and `others`."""
    own = (
        name
        for name, value in names.items()
        if not name.startswith("_")
        and isinstance(value, FunctionType | type)
        and value.__module__ == names["__name__"]
    )
    return sorted([*own, *others])
