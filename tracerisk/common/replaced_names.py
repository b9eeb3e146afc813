"""Names of modules and classes that stand for something else for a while."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from typing import Any


@contextmanager
def replaced(replacements: Iterable[tuple[Any, str, Any]]) -> Iterator[None]:
    """Give each name of its owner another value while this is open; then all is as it was."""
    with ExitStack() as undo:
        for owner, name, value in replacements:
            # A module may make a name when it is first asked for.
            if name in vars(owner):
                undo.callback(setattr, owner, name, vars(owner)[name])
            else:
                undo.callback(delattr, owner, name)
            setattr(owner, name, value)
        yield
