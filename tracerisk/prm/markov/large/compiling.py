"""How the loops of large chains are compiled: by numba, when they are first called."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from tracerisk.dependencies import require_large

_Function = TypeVar("_Function", bound=Callable[..., Any])


def compiled_by_numba(function: _Function) -> _Function:
    """Return a function compiled when first called, and kept on disk where a folder can be.

    Raises DependencyError where numba is not installed.
    """
    require_large("numba")
    import numba

    try:
        return cast(_Function, numba.njit(cache=True)(function))
    except RuntimeError:
        # No folder for the cache can be written: neither beside the package nor the user's.
        return cast(_Function, numba.njit(function))
