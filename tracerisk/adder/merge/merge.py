"""The three-way merge of a block: what the tool wrote, what stands there, what it computes now.

The base is known value by value, from the block's digest and the lock: see `authors.py`. A value
that a user changed since is theirs and never lost; a value that only the tool changed, on any
branch, is refreshed; where it is unknown which of the two it is, it is left alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from tracerisk.adder.blocks.block import NO_FAILURES, ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.failures import are_close
from tracerisk.adder.blocks.values import (
    CALL_SEQUENCE,
    FAILURES,
    NEXT,
    NOTHING_COMPUTED,
    FieldKind,
    component_fields,
    has_pins,
    is_component_pinned,
)
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.adder.merge.authors import Author, Evidence, KnownBlock
from tracerisk.adder.merge.bases import NO_EARLIER_NAMES, EarlierNames
from tracerisk.adder.merge.edits_found import HandEdit, MergePolicy
from tracerisk.errors import Location


@dataclass(frozen=True, slots=True)
class Merged:
    """The outcome of a merge.

    With the policy `stop` and edits, the block is as if they were accepted; do not write it.
    """

    block: RiskBlock | None
    """The block to write; `None` for no block."""
    edits: tuple[HandEdit, ...]
    """The edits of a user that were found."""


def is_noise(kind: FieldKind, before: Any, value: Any, tolerance: float) -> bool:
    """Return whether a value differs from the one before by no more than noise."""
    if kind is FAILURES:
        return are_close(before, value, tolerance)
    return kind.is_noisy and bool(abs(value - before) <= tolerance * abs(before))


def merge(
    base: WrittenBlock | None,
    current: RiskBlock | None,
    computed: RiskBlock | None,
    *,
    policy: MergePolicy,
    others: Sequence[WrittenBlock] = (),
    evidence: Callable[[], Evidence] = Evidence,
    names: EarlierNames = NO_EARLIER_NAMES,
    steady: Collection[str] = (),
) -> Merged:
    """Return what becomes of a block and which edits of a user were found.

    `base` is what the lock says was last written, `None` where it knows of nothing, `others` what
    else it says that the tool may have written there; `evidence` is asked only where these and
    the block's own digest do not suffice. `names` are earlier names of functions renamed since.
    `steady` are the components behind whose values nothing changed in kind.
    `computed` is `None` for a function that is not relevant any more; if one of its own fields is
    pinned, the user set it elsewhere (in an operational profile), and the tool's value is in that
    field's `computed`.
    """
    if current is None:
        return Merged(computed, ())
    bases = [other for other in (base, *others) if other is not None]
    known = KnownBlock(current, bases, evidence, names)
    merger = _Merger(known, current, computed, policy, steady)
    return Merged(merger.block(), tuple(merger.edits))


@dataclass(slots=True)
class _Merger:
    known: KnownBlock
    """Who wrote the values of the current block."""
    current: RiskBlock
    """The block in the source."""
    computed: RiskBlock | None
    """The block that the tool computes; `None` for a function that is not relevant any more."""
    policy: MergePolicy
    """What becomes of edits."""
    steady: Collection[str] = ()
    """The components behind whose values nothing changed in kind."""
    edits: list[HandEdit] = field(default_factory=list)
    """The edits found so far."""

    def block(self) -> RiskBlock | None:
        current, computed = self.current, self.computed
        if current.added:
            return self._by_hand()
        if computed is None and not self.known.is_known and not has_pins(current):
            # Neither the lock knows the block nor does the tool compute it.
            author = self.known.author_of_block()
            if author != "tool":
                self._report("added", current.name, current.location, author)
                return None if self.policy.edits == "discard" else replace(current, added=True)
        call_sequence = self._field(
            None,
            CALL_SEQUENCE,
            current.call_sequence,
            computed.call_sequence if computed else None,
        )
        following = self._next()
        components = self._components()
        block = replace(
            current,
            call_sequence=call_sequence,
            next=following,
            components=components,
            has_evidence=computed is not None and computed.has_evidence,
        )
        if computed is None and not has_pins(block):
            return None
        return block

    def _by_hand(self) -> RiskBlock:
        """Keep a block given by hand, with what the tool computes beside its pinned values."""
        current, computed = self.current, self.computed
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

    def _next(self) -> Field[Any] | None:
        current = self.current.next
        computed = self.computed.next if self.computed else None
        if current is None:
            # Either the published form, which has no `next`, or the lines were deleted; nothing of
            # the user's is left to keep.
            return computed
        if self.computed is None or computed is not None or current.pinned:
            return self._field(None, NEXT, current, computed)
        written, is_there = self.known.last(None, NEXT, current)
        if is_there or not self._changed(None, NEXT, written, current, None):
            return None
        return None if self.policy.edits == "discard" else _pinned(current, None)

    def _components(self) -> tuple[ComponentEntry, ...]:
        computed = self.computed.components if self.computed else ()
        current = {component.name: component for component in self.current.components}
        merged = [self._component(new, current.pop(new.name, None)) for new in computed]
        left = [self._no_longer_computed(current[name]) for name in sorted(current)]
        return (*merged, *(component for component in left if component is not None))

    def _component(self, new: ComponentEntry, current: ComponentEntry | None) -> ComponentEntry:
        if current is None:
            if self.known.held(new.name) is False:
                return new
            author = self.known.author_of_removal(new.name)
            if author == "tool":
                return new
            path = f"{self.current.name}.{new.name}"
            self._report("removed", path, self.current.location, author)
            if self.policy.edits == "discard":
                return new
            return replace(new, omitted=True)
        if current.added:
            return _component_beside(current, new)
        return self._fields(current, new)

    def _no_longer_computed(self, current: ComponentEntry) -> ComponentEntry | None:
        """Decide on a component that stands in the block and that the tool does not compute."""
        if current.added or current.omitted:
            return _component_beside(current, None)
        if self.computed is None:
            # The block stays for something a user set in it, and stays whole.
            return self._fields(current, None)
        if not self.known.knows(current.name) and not is_component_pinned(current):
            author = self.known.author_of_component(current.name, current.probability.value)
            if author == "tool":
                return None
            path = f"{self.current.name}.{current.name}"
            self._report("added", path, current.location, author)
            return None if self.policy.edits == "discard" else replace(current, added=True)
        merged = self._fields(current, None)
        return merged if is_component_pinned(merged) else None

    def _fields(self, current: ComponentEntry, new: ComponentEntry | None) -> ComponentEntry:
        computed = dict(component_fields(new)) if new else {}
        probability, quantity, redundancy = (
            self._field(current.name, kind, value, computed.get(kind))
            for kind, value in component_fields(current)[:-1]
        )
        return replace(
            current,
            probability=probability,
            quantity=quantity,
            redundancy=redundancy,
            failures=self._failures(current, new),
        )

    def _failures(self, current: ComponentEntry, new: ComponentEntry | None) -> Field[Any]:
        """Decide on what follows a component's failures; not each component says that."""
        field, computed = current.failures, None if new is None else new.failures
        if not field.is_stated:
            return field if computed is None else computed
        if new is None or (computed is not None and computed.is_stated) or field.pinned:
            said = computed if computed is not None and computed.is_stated else None
            return self._field(current.name, FAILURES, field, said)
        # The tool says nothing there now: what it wrote goes, what a user wrote is an edit.
        written, is_there = self.known.last(current.name, FAILURES, field)
        if is_there or not self._changed(current.name, FAILURES, written, field, None):
            return NO_FAILURES
        return NO_FAILURES if self.policy.edits == "discard" else _pinned(field, None)

    def _field(
        self,
        component: str | None,
        kind: FieldKind,
        current: Field[Any],
        computed: Field[Any] | None,
    ) -> Field[Any]:
        written, is_there = self.known.last(component, kind, current)
        tool = None if computed is None else self._tool_field(component, kind, written, computed)
        edited = (
            not is_there
            and self._looks_edited(kind, written, current, tool)
            and self._changed(component, kind, written, current, tool)
        )
        if edited and self.policy.edits != "discard":
            return _pinned(current, tool)
        if computed is not None and computed.pinned:
            # A pin from elsewhere is the newest value of a user.
            if current.pinned and kind.same(current.value, computed.value):
                return _beside(current, tool)
            return _beside(computed, tool)
        if current.pinned:
            return _beside(current, tool)
        if tool is not None:
            return tool
        # Nothing is computed: the value stays as last written beside what a user pinned.
        return current if written is None else Field(kind.read(written), written)

    def _tool_field(
        self, component: str | None, kind: FieldKind, written: str | None, computed: Field[Any]
    ) -> Field[Any] | None:
        """Return the tool's own value as it is to be written, noise left aside."""
        text = _tool_text(computed)
        if text is None:
            return None
        value = kind.read(text)
        if written is not None and not self.policy.fresh:
            before = kind.read(written)
            if kind.same(before, value):
                return Field(value, text) if kind.is_noisy else Field(before, written)
            # The new value is compared with the written one, which is no kept one: so none creeps.
            if component in self.steady and is_noise(kind, before, value, self.policy.tolerance):
                return Field(before, written)
        return Field(value, text)

    def _looks_edited(
        self, kind: FieldKind, written: str | None, current: Field[Any], tool: Field[Any] | None
    ) -> bool:
        """Return whether a `=` value, not known to be the tool's, differs from the tool's."""
        if current.pinned or not current.is_stated:
            return False
        if tool is None:
            # Kept as it stands beside something a user set: nothing is lost.
            return written is not None or self.known.is_known
        return not kind.same(current.value, tool.value)

    def _changed(
        self,
        component: str | None,
        kind: FieldKind,
        written: str | None,
        current: Field[Any],
        tool: Field[Any] | None,
    ) -> bool:
        """Report a value that the tool is not known to have written; `False` if it did."""
        author = self.known.author_of_value(component, kind, current.value)
        if author == "tool":
            return False
        path = ".".join(part for part in (self.current.name, component, kind.key) if part)
        texts = {
            "found": current.text,
            "written": written,
            "computed": None if tool is None else tool.text,
        }
        self._report("changed", path, current.location, author, **texts)
        return True

    def _report(
        self,
        what: Literal["changed", "added", "removed"],
        path: str,
        location: Location | None,
        author: Author,
        **texts: str | None,
    ) -> None:
        self.edits.append(HandEdit(what, path, location, **texts, is_certain=author == "user"))


def _pinned(current: Field[Any], tool: Field[Any] | None) -> Field[Any]:
    """Return a value that a user edited as the user's own."""
    return replace(current, pinned=True, computed=NOTHING_COMPUTED if tool is None else tool.text)


def _tool_text(computed: Field[Any]) -> str | None:
    """Return the tool's text; `None` where it has none, as for an omitted component only named."""
    return (computed.computed if computed.pinned else computed.text) or None


def _beside(current: Field[Any], tool: Field[Any] | None) -> Field[Any]:
    """Return a user's value with what the tool computes now written beside it."""
    if not current.pinned:
        return current
    return replace(current, computed=NOTHING_COMPUTED if tool is None else _tool_text(tool))


def _component_beside(current: ComponentEntry, new: ComponentEntry | None) -> ComponentEntry:
    computed = dict(component_fields(new)) if new else {}
    probability, quantity, redundancy, failures = (
        _beside(value, computed.get(kind)) for kind, value in component_fields(current)
    )
    return replace(
        current,
        probability=probability,
        quantity=quantity,
        redundancy=redundancy,
        failures=failures,
    )
