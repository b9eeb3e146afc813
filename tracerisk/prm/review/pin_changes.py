"""What became of the values that users set: new, removed, changed, or drifted from."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
)
from tracerisk.errors import Location
from tracerisk.prm.review.change_records import PinChange, is_noise


class _Pin(NamedTuple):
    text: str
    """The value as its line states it; `block`, `component` or `omit` for a whole entry."""
    value: Any
    """The value as read; `None` for a whole entry."""
    computed: str | None
    """Text of the computed value beside the pin; `None` where there is none."""
    reason: str | None
    """The user's reason; `None` where none is given."""
    location: Location | None
    """Line of the pin; `None` for a block without a file."""
    kind: FieldKind | None
    """Which value of the block it is; `None` for a whole entry."""


def pin_changes(
    before: Mapping[str, RiskBlock], after: Mapping[str, RiskBlock]
) -> tuple[PinChange, ...]:
    """Return what changed of the pins of a controller, in the order of their paths."""
    old = {path: pin for block in before.values() for path, pin in _pins(block)}
    new = {path: pin for block in after.values() for path, pin in _pins(block)}
    changes = []
    for path in sorted({*old, *new}):
        change = _change(path, old.get(path), new.get(path))
        if change is not None:
            changes.append(change)
    return tuple(changes)


def _change(path: str, old: _Pin | None, new: _Pin | None) -> PinChange | None:
    pin = new or old
    assert pin is not None
    if old is None:
        kind = "new"
    elif new is None:
        kind = "removed"
    elif old.text != new.text and not (new.kind and new.kind.same(old.value, new.value)):
        kind = "changed"
    elif _drifted(old, new):
        kind = "drifted"
    else:
        return None
    return PinChange(
        kind=kind,  # type: ignore[arg-type]
        path=path,
        before=None if old is None else old.text,
        after=None if new is None else new.text,
        computed_before=None if old is None else old.computed,
        computed_after=None if new is None else new.computed,
        reason=pin.reason,
        location=pin.location,
    )


def _drifted(old: _Pin, new: _Pin) -> bool:
    if new.kind is None or old.computed is None or new.computed is None:
        return False
    figures = (old.computed, new.computed)
    if NOTHING_COMPUTED in figures:
        return figures[0] != figures[1]
    earlier, later = map(new.kind.read, figures)
    if new.kind.is_noisy:
        return not is_noise(earlier, later)
    return not new.kind.same(earlier, later)


def _pins(block: RiskBlock) -> Iterator[tuple[str, _Pin]]:
    if block.added:
        yield block.name, _Pin("block", None, None, block.reason, block.location, None)
    for kind, field in ((CALL_SEQUENCE, block.call_sequence), (NEXT, block.next)):
        if field is not None and field.pinned:
            yield f"{block.name}.{kind.key}", _of_field(kind, field)
    for entry in block.components:
        path = f"{block.name}.{entry.name}"
        if entry.added or entry.omitted:
            what = "omit" if entry.omitted else "component"
            yield path, _Pin(what, None, None, entry.reason, entry.location, None)
        for kind, field in component_fields(entry):
            if field.pinned:
                yield f"{path}.{kind.key}", _of_field(kind, field)


def _of_field(kind: FieldKind, field: Field[Any]) -> _Pin:
    return _Pin(field.text, field.value, field.computed, field.reason, field.location, kind)
