"""How a function of a controller is named: by its file and its qualified name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NewType

QualifiedName = NewType("QualifiedName", str)
"""A function's qualified name within its module: `place`, `PickNode.place`, `<module>`."""


@dataclass(frozen=True, slots=True)
class FunctionRef:
    """A function of the controller."""

    file: str
    """Its file, from the controller's root."""
    name: QualifiedName
    """Its name within the file."""

    def __lt__(self, other: FunctionRef) -> bool:
        # All that sorting asks for.
        return (self.file, self.name) < (other.file, other.name)

    def with_file(self, file_of: Callable[[str], str]) -> FunctionRef:
        """Return it with another name of the file; `file_of` takes a file."""
        return FunctionRef(file_of(self.file), self.name)
