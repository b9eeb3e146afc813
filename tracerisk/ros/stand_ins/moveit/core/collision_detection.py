"""Requests for collision checks, their results, and what may touch."""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement
from typing import Any

__all__ = ["AllowedCollisionMatrix", "CollisionRequest", "CollisionResult"]


class _Closed:
    """A class of the real library: a name that it lacks cannot be set."""

    def __setattr__(self, name: str, value: Any) -> None:
        if not name.startswith("_") and name not in self._fields():
            raise AttributeError(
                f"'{type(self).__name__}' object has no attribute '{name}'; "
                f"it has: {', '.join(sorted(self._fields()))}"
            )
        object.__setattr__(self, name, value)

    @classmethod
    def _fields(cls) -> frozenset[str]:
        return frozenset(name for name in cls.__annotations__ if not name.startswith("_"))


class CollisionRequest(_Closed):
    """What a collision check looks at; an empty group name means the whole robot."""

    joint_model_group_name: str
    distance: bool
    cost: bool
    contacts: bool
    max_contacts: int
    max_contacts_per_pair: int
    max_cost_sources: int
    verbose: bool

    def __init__(self) -> None:
        self.joint_model_group_name = ""
        self.distance = self.cost = self.contacts = self.verbose = False
        self.max_contacts = self.max_contacts_per_pair = self.max_cost_sources = 1


class CollisionResult(_Closed):
    """What a collision check found; as in the real library contacts can only be counted."""

    collision: bool
    distance: float
    contact_count: int
    cost_sources: set[Any]

    def __init__(self) -> None:
        self.collision = False
        self.distance = sys.float_info.max
        self.contact_count = 0
        self.cost_sources = set()

    @property
    def contacts(self) -> dict[tuple[str, str], list[Any]]:
        """The contacts by pair of names; only where there are none.

        Raises:
            TypeError: there are some, which the real library cannot return either.
        """
        if self.contact_count:
            raise TypeError(
                "Unable to convert function return value to a Python type! The real library "
                "cannot return contacts either; read collision and contact_count"
            )
        return {}


class AllowedCollisionMatrix:
    """The pairs of names, of links and objects, that may touch."""

    def __init__(self, names: Sequence[str] = (), default_entry: bool = False) -> None:
        self._entries: dict[frozenset[str], bool] = {
            frozenset(pair): bool(default_entry) for pair in combinations_with_replacement(names, 2)
        }
        self._changed: Callable[[], None] = _nothing

    def get_entry(self, name1: str, name2: str) -> tuple[bool, str]:
        """Return whether there is an entry, and ALWAYS, NEVER, or UNKNOWN where there is none."""
        entry = self._entries.get(frozenset((name1, name2)))
        if entry is None:
            return (False, "UNKNOWN")
        return (True, "ALWAYS" if entry else "NEVER")

    def set_entry(self, name1: str, name2: str, allowed: bool) -> None:
        """Allow two to touch, or not."""
        self._entries[frozenset((name1, name2))] = bool(allowed)
        self._changed()

    def remove_entry(self, name1: str, name2: str) -> None:
        """Forget an entry, where there is one."""
        self._entries.pop(frozenset((name1, name2)), None)
        self._changed()

    def clear(self) -> None:
        """Forget every entry."""
        self._entries.clear()
        self._changed()

    def _allowed(self) -> frozenset[frozenset[str]]:
        return frozenset(pair for pair, allowed in self._entries.items() if allowed)


def _nothing() -> None:
    """Do nothing: the matrix belongs to no scene."""
