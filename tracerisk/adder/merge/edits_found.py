"""What a user edited among the values that the tool writes, and when it is in the way."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from tracerisk.errors import EditInTheWayError, Location


@dataclass(frozen=True, slots=True)
class MergePolicy:
    """What becomes of a user's edits of `=` values, and of changes that are mere noise."""

    edits: Literal["stop", "accept", "discard"] = "stop"
    """`stop` reports them, `accept` pins them (`:=`), `discard` writes the tool's values."""
    fresh: bool = False
    """Whether computed values are written also where they changed by no more than noise."""
    tolerance: float = 0.005
    """The relative change of a computed probability up to which it is noise, and the written text
    stays, where nothing behind the value changed in kind."""


@dataclass(frozen=True, slots=True)
class HandEdit:
    """What a user changed among the values that the tool writes."""

    kind: Literal["changed", "added", "removed"]
    """Whether a value was changed, or a component or block was added or removed."""
    field: str
    """The dotted path: `place.gripper.probability` for a value, `place.gripper` or `place` for a
    component or a block."""
    location: Location | None
    """The file and line; `None` where not known."""
    found: str | None = None
    """The text in the block; `None` for an addition or removal."""
    written: str | None = None
    """The text last written; `None` where not known."""
    computed: str | None = None
    """The text that the tool computes now; `None` where it computes nothing."""
    is_certain: bool = True
    """Whether a user did it; false where another branch may have."""

    def __str__(self) -> str:
        place = "" if self.location is None else f"{self.location}: "
        if self.kind != "changed":
            return f"{place}{self.field} was {self.kind}"
        return (
            f"{place}{self.field} is {self.found} (last written {self.written or 'unknown'}, "
            f"computed {self.computed or 'none'})"
        )


def edits_error(edits: Iterable[HandEdit]) -> EditInTheWayError:
    """Return the error that names every edited field, and those of unknown author."""
    listed = sorted(edits, key=_edit_order)
    certain = [f"  {edit}" for edit in listed if edit.is_certain]
    doubtful = [f"  {edit}" for edit in listed if not edit.is_certain]
    parts = []
    if certain:
        parts += ["a user changed what tracerisk computes; nothing was written:", *certain]
        parts += [
            "Write `:=` for `=` (in the compact form before the value) to keep a value, or use "
            "--accept-edits to keep them all, "
            "--discard-edits to drop them all."
        ]
    if doubtful:
        parts += [
            "it is unknown who wrote these values, a user or tracerisk on another branch; "
            f"{'they were left alone' if certain else 'nothing was written'}:",
            *doubtful,
            "Use --discard-edits to overwrite them with the computed values, or take the whole "
            "block from a version that you trust.",
        ]
    return EditInTheWayError("\n".join(parts))


def _edit_order(edit: HandEdit) -> tuple[str, int, str]:
    place = edit.location or Location("")
    return (place.file, place.line or 0, edit.field)


def in_the_way(edits: Iterable[HandEdit], policy: MergePolicy) -> tuple[HandEdit, ...]:
    """Return the edits for which nothing may be written.

    `accept` covers only edits that a user certainly made, not values that may come from another
    branch.
    """
    if policy.edits == "discard":
        return ()
    return tuple(edit for edit in edits if policy.edits == "stop" or not edit.is_certain)
