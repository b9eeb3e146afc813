"""The three-way merge of a block: what the tool wrote, what stands there, what it computes now.

The base is what the lock says was last written. A value that a person changed since is theirs
and never lost; a value that only the tool changed is refreshed.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Literal

from tracerisk.adder.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.lock import WrittenBlock, WrittenComponent
from tracerisk.adder.values import (
    CALL_SEQUENCE,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
)
from tracerisk.errors import EditInTheWayError, Location

NOISE = 0.01
"""The relative change of a computed probability up to which its text stays as written."""


@dataclass(frozen=True, slots=True)
class MergePolicy:
    """What becomes of a person's edits of `=` values, and of changes within the noise.

    `edits`: "stop" reports them, "accept" pins them (`:=`), "discard" writes the tool's value.
    `fresh` writes every computed value anew.
    """

    edits: Literal["stop", "accept", "discard"] = "stop"
    fresh: bool = False


@dataclass(frozen=True, slots=True)
class PersonEdit:
    """What a person changed among the values that the tool writes.

    `field` is its dotted path: `place.gripper.probability` for a value that is "changed",
    `place.gripper` or `place` for a component or a block that was "added" or "removed".
    `found` is what stands there, `written` what was last written and `computed` what the tool
    computes now, as text, where there is such a value.
    """

    kind: Literal["changed", "added", "removed"]
    field: str
    location: Location | None
    found: str | None = None
    written: str | None = None
    computed: str | None = None

    def __str__(self) -> str:
        place = "" if self.location is None else f"{self.location}: "
        if self.kind != "changed":
            return f"{place}{self.field} was {self.kind}"
        return (
            f"{place}{self.field} is {self.found} (last written {self.written or 'unknown'}, "
            f"computed {self.computed or 'none'})"
        )


@dataclass(frozen=True, slots=True)
class Merged:
    """The outcome of a merge: the block to write, `None` for none, and the edits found.

    With the policy "stop" and edits, the block is as if they were accepted; do not write it.
    """

    block: RiskBlock | None
    edits: tuple[PersonEdit, ...]


def edits_error(edits: Iterable[PersonEdit]) -> EditInTheWayError:
    """Return the error that names every edited field."""
    listed = sorted(edits, key=_edit_order)
    lines = "\n".join(f"  {edit}" for edit in listed)
    return EditInTheWayError(
        f"a person changed what tracerisk computes; nothing was written:\n{lines}\n"
        "Write `:=` for `=` to keep a value, or use --accept-edits to keep them all, "
        "--discard-edits to drop them all."
    )


def _edit_order(edit: PersonEdit) -> tuple[str, int, str]:
    place = edit.location or Location("")
    return (place.file, place.line or 0, edit.field)


def merge_block(
    base: WrittenBlock | None,
    current: RiskBlock | None,
    computed: RiskBlock | None,
    *,
    policy: MergePolicy,
) -> RiskBlock | None:
    """Return the block to write; `None` where there is to be none.

    Raises:
        EditInTheWayError: if a person edited a `=` value and the policy says "stop".
    """
    merged = merge(base, current, computed, policy=policy)
    if merged.edits and policy.edits == "stop":
        raise edits_error(merged.edits)
    return merged.block


def merge(
    base: WrittenBlock | None,
    current: RiskBlock | None,
    computed: RiskBlock | None,
    *,
    policy: MergePolicy,
) -> Merged:
    """Return what becomes of a block and which edits of a person were found.

    `base` is what was last written, `None` where the lock knows of nothing: then every
    difference between `current` and `computed` counts as a person's.
    `computed` is `None` for a function that is not relevant any more; a pinned field in it is
    a person's word by another way (an operational profile), its tool value in `computed`.
    """
    if current is None:
        return Merged(computed, ())
    merger = _Merger(base, current, computed, policy)
    return Merged(merger.block(), tuple(merger.edits))


class _Merger:
    def __init__(
        self,
        base: WrittenBlock | None,
        current: RiskBlock,
        computed: RiskBlock | None,
        policy: MergePolicy,
    ) -> None:
        self._base = base
        self._current = current
        self._computed = computed
        self._policy = policy
        self.edits: list[PersonEdit] = []

    def block(self) -> RiskBlock | None:
        current, computed = self._current, self._computed
        if current.added:
            return self._by_hand()
        if computed is None and self._base is None and not has_pins(current):
            # Neither the lock knows the block nor does the tool compute it.
            self._report("added", current.name, current.location)
            return None if self._policy.edits == "discard" else replace(current, added=True)
        values = self._base.values if self._base else {}
        call_sequence = self._field(
            current.name,
            CALL_SEQUENCE,
            values.get(CALL_SEQUENCE.key),
            current.call_sequence,
            computed.call_sequence if computed else None,
        )
        following = self._next(values.get(NEXT.key))
        components = self._components()
        block = replace(current, call_sequence=call_sequence, next=following, components=components)
        if computed is None and not has_pins(block):
            return None
        return block

    def _by_hand(self) -> RiskBlock:
        """Keep a block given by hand, with what the tool computes beside its pinned values."""
        current, computed = self._current, self._computed
        call_sequence = following = None
        others: dict[str, ComponentEntry] = {}
        if computed is not None:
            call_sequence, following = computed.call_sequence, computed.next
            others = {component.name: component for component in computed.components}
        return replace(
            current,
            call_sequence=_beside(current.call_sequence, call_sequence),
            next=None if current.next is None else _beside(current.next, following),
            components=tuple(
                _component_beside(component, others.get(component.name))
                for component in current.components
            ),
        )

    def _next(self, written: str | None) -> Field[Any] | None:
        current = self._current.next
        computed = self._computed.next if self._computed else None
        if current is None:
            # The published form, which has none; or lines taken away, with no word of a person
            # in them that could be kept.
            return computed
        path = self._current.name
        if self._computed is None or computed is not None or current.pinned:
            return self._field(path, NEXT, written, current, computed)
        if written is not None and NEXT.same(current.value, NEXT.read(written)):
            return None
        self._changed(path, NEXT, written, current, None)
        return None if self._policy.edits == "discard" else _pinned(current, None)

    def _components(self) -> tuple[ComponentEntry, ...]:
        computed = self._computed.components if self._computed else ()
        current = {component.name: component for component in self._current.components}
        merged = [self._component(new, current.pop(new.name, None)) for new in computed]
        left = [self._no_longer_computed(current[name]) for name in sorted(current)]
        return (*merged, *(component for component in left if component is not None))

    def _component(self, new: ComponentEntry, current: ComponentEntry | None) -> ComponentEntry:
        written = self._written(new.name)
        if current is None:
            is_known = self._base is None or (written is not None and not written.omitted)
            if not is_known:
                return new
            self._report("removed", f"{self._current.name}.{new.name}", self._current.location)
            if self._policy.edits == "discard":
                return new
            return replace(new, omitted=True)
        if current.added:
            return _component_beside(current, new)
        return self._fields(current, new, written)

    def _no_longer_computed(self, current: ComponentEntry) -> ComponentEntry | None:
        """Decide on a component that stands in the block and that the tool does not compute."""
        if current.added or current.omitted:
            return _component_beside(current, None)
        written = self._written(current.name)
        if self._computed is None:
            # The block stays for something a person set in it, and stays whole.
            return self._fields(current, None, written)
        if written is None and not _is_component_pinned(current):
            self._report("added", f"{self._current.name}.{current.name}", current.location)
            return None if self._policy.edits == "discard" else replace(current, added=True)
        merged = self._fields(current, None, written)
        return merged if _is_component_pinned(merged) else None

    def _fields(
        self, current: ComponentEntry, new: ComponentEntry | None, written: WrittenComponent | None
    ) -> ComponentEntry:
        computed = dict(component_fields(new)) if new else {}
        path = f"{self._current.name}.{current.name}"
        values = [
            self._field(
                path,
                kind,
                written.values.get(kind.key) if written else None,
                value,
                computed.get(kind),
            )
            for kind, value in component_fields(current)
        ]
        probability, quantity, redundancy = values
        return replace(current, probability=probability, quantity=quantity, redundancy=redundancy)

    def _written(self, component: str) -> WrittenComponent | None:
        return self._base.components.get(component) if self._base else None

    def _field(
        self,
        path: str,
        kind: FieldKind,
        written: str | None,
        current: Field[Any],
        computed: Field[Any] | None,
    ) -> Field[Any]:
        tool = None if computed is None else self._tool_field(kind, written, computed)
        edited = self._is_edited(kind, written, current, tool)
        if edited:
            self._changed(path, kind, written, current, tool)
        if edited and self._policy.edits != "discard":
            return _pinned(current, tool)
        if computed is not None and computed.pinned:
            # A pin from elsewhere is the newest word of a person.
            if current.pinned and kind.same(current.value, computed.value):
                return _beside(current, tool)
            return _beside(computed, tool)
        if current.pinned:
            return _beside(current, tool)
        if tool is not None:
            return tool
        # Nothing is computed: the value stays as last written beside what a person pinned.
        return current if written is None else Field(kind.read(written), written)

    def _tool_field(
        self, kind: FieldKind, written: str | None, computed: Field[Any]
    ) -> Field[Any] | None:
        """Return the tool's own value as it is to be written, noise left aside."""
        text = _tool_text(computed)
        if text is None:
            return None
        value = kind.read(text)
        if written is not None and not self._policy.fresh:
            before = kind.read(written)
            if kind.same(before, value) or (
                kind.is_noisy and abs(value - before) <= NOISE * abs(before)
            ):
                return Field(before, written)
        return Field(value, text)

    def _is_edited(
        self, kind: FieldKind, written: str | None, current: Field[Any], tool: Field[Any] | None
    ) -> bool:
        """Return whether a person changed a `=` value since it was written."""
        if current.pinned or not current.is_stated:
            return False
        if written is None and tool is None:
            # Kept as it stands beside something a person set: nothing is lost.
            return False
        known = [] if written is None else [kind.read(written)]
        known += [] if tool is None else [tool.value]
        return not any(kind.same(current.value, value) for value in known)

    def _changed(
        self,
        path: str,
        kind: FieldKind,
        written: str | None,
        current: Field[Any],
        tool: Field[Any] | None,
    ) -> None:
        self._report(
            "changed",
            f"{path}.{kind.key}",
            current.location,
            found=current.text,
            written=written,
            computed=None if tool is None else tool.text,
        )

    def _report(
        self,
        what: Literal["changed", "added", "removed"],
        path: str,
        location: Location | None,
        **texts: str | None,
    ) -> None:
        self.edits.append(PersonEdit(what, path, location, **texts))


def _pinned(current: Field[Any], tool: Field[Any] | None) -> Field[Any]:
    """Return a value that a person edited as the person's own."""
    return replace(current, pinned=True, computed=NOTHING_COMPUTED if tool is None else tool.text)


def _tool_text(computed: Field[Any]) -> str | None:
    """Return the tool's text; `None` where it has none, as for an omitted component by name."""
    return (computed.computed if computed.pinned else computed.text) or None


def _beside(current: Field[Any], tool: Field[Any] | None) -> Field[Any]:
    """Return a person's value with what the tool computes now written beside it."""
    if not current.pinned:
        return current
    return replace(current, computed=NOTHING_COMPUTED if tool is None else _tool_text(tool))


def _component_beside(current: ComponentEntry, new: ComponentEntry | None) -> ComponentEntry:
    computed = dict(component_fields(new)) if new else {}
    probability, quantity, redundancy = (
        _beside(value, computed.get(kind)) for kind, value in component_fields(current)
    )
    return replace(current, probability=probability, quantity=quantity, redundancy=redundancy)


def _is_component_pinned(component: ComponentEntry) -> bool:
    return (
        component.added
        or component.omitted
        or any(value.pinned for _, value in component_fields(component))
    )


def has_pins(block: RiskBlock) -> bool:
    """Return whether anything in a block is a person's."""
    return (
        block.added
        or block.call_sequence.pinned
        or (block.next is not None and block.next.pinned)
        or any(map(_is_component_pinned, block.components))
    )
