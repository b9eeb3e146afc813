"""`launch.substitution`: a text that is known only while a description is walked through."""

from __future__ import annotations

from typing import Any


class Substitution:
    """Base of all substitutions."""

    def describe(self) -> str:
        """Return a text that names the substitution."""
        return type(self).__name__

    def perform(self, context: Any) -> str:
        """Return the text; the base has none."""
        raise NotImplementedError(f"{type(self).__name__} has no perform()")
