"""What a component did where a user set its figure by hand, and where that is done now.

A value with `:=`, or an omission, is for what the component did in that function when it was
written. The lock keeps that; a run compares. So a function that is split, merged or inlined does
not count a use twice, or not at all, without a word.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import PROBABILITY
from tracerisk.adder.lock.lock import ControllerLock, OwnedValue, Uses
from tracerisk.common.function_ref import FunctionRef, QualifiedName

OMITTED = "omit"
"""What stands for the value of a component that a user excluded."""

_NOISE = 0.01  # the law of refactoring
_SAME_USE = 0.25  # without another function that takes part


class MovedUse(NamedTuple):
    """A value set by hand that is not for what its function does now."""

    ref: FunctionRef
    """The function whose block has the value."""
    component: str
    """The component."""
    owned: OwnedValue
    """The value, and what it was written for."""
    computed: str
    """What is computed there now; empty for nothing."""
    took: tuple[FunctionRef, ...] = ()
    """The functions that use the component now and did not then, with a computed figure."""
    gave: tuple[FunctionRef, ...] = ()
    """The functions that used it then and do not now."""

    @property
    def path(self) -> str:
        """The dotted path of the component in its block."""
        return f"{self.ref.name}.{self.component}"

    @property
    def message(self) -> str:
        """What is wrong, with the names of the functions."""
        here, component = self.ref.name, self.component
        verb = "omitted" if self.owned.value == OMITTED else "set by hand"
        before = self.owned.uses.get(self.ref.file, {}).get(here, "none")
        text = (
            f"{component} is {verb} in {here} for what it did there when that was written "
            f"(computed {before}, now {self.computed or 'none'})"
        )
        if self.took:
            text += f", and {_names(self.took)} took over a part, which is counted beside it"
        if self.gave:
            text += f", and what {_names(self.gave)} did with it then is counted nowhere else now"
        return text

    def is_of(self, component: str | None, functions: Collection[str]) -> bool:
        """Whether a change is of it: of the component, or of the chain, in one of its functions."""
        names = {ref.name for ref in (self.ref, *self.took, *self.gave)}
        return component in (None, self.component) and not names.isdisjoint(functions)

    @property
    def remedy(self) -> str:
        """What a user does about it."""
        move = f"move what is set by hand to {_names(self.took)}, or " if self.took else ""
        return f"{move}write there what holds now, with a reason (`! why`) that says so"


def _names(refs: Collection[FunctionRef]) -> str:
    return ", ".join(ref.name for ref in refs)


def owned_values(
    merged: Mapping[str, Mapping[QualifiedName, RiskBlock | None]],
    before: ControllerLock | None,
    renamed: Mapping[FunctionRef, FunctionRef],
    final: ControllerLock,
) -> dict[str, dict[str, dict[str, OwnedValue]]]:
    """Return what values set by hand are for, as the lock of these blocks is to keep it.

    `renamed` gives the earlier function of each that has another name now. What was kept stays
    as long as value and reason do; a new value is for what the lock before said, where it knew
    the function, because its user saw that.
    """
    kept: dict[str, dict[str, dict[str, OwnedValue]]] = {}
    for file, blocks in merged.items():
        for name, block in blocks.items():
            for entry in () if block is None or block.added else block.components:
                value = owned_text(entry)
                if value is None:
                    continue
                ref = FunctionRef(file, name)
                owned = _owned(ref, entry, value, before, renamed, final)
                kept.setdefault(file, {}).setdefault(name, {})[entry.name] = owned
    return kept


def owned_text(entry: ComponentEntry) -> str | None:
    """Return the figure that a user set for a component that tracerisk computes, or `OMITTED`."""
    if entry.added:
        return None
    if entry.omitted:
        return OMITTED
    return entry.probability.text if entry.probability.pinned else None


def reason_of(entry: ComponentEntry) -> str:
    """Return the reason for what a user set for a component, in one line."""
    reason = entry.reason if entry.omitted else entry.probability.reason
    return " ".join((reason or "").split())


def _owned(
    ref: FunctionRef,
    entry: ComponentEntry,
    value: str,
    before: ControllerLock | None,
    renamed: Mapping[FunctionRef, FunctionRef],
    final: ControllerLock,
) -> OwnedValue:
    data = final.behind.components.get(entry.name, "")
    now = OwnedValue(value, reason_of(entry), uses_of(final, entry.name), data)
    if before is None:
        return now
    # Else its figures may be of one branch, and its data of another.
    is_of_one = before.is_settled
    was = renamed.get(ref, ref)
    new_names = {old: new for new, old in renamed.items()}
    then = _renamed(uses_of(before, entry.name), new_names)
    kept = before.owned.get(was.file, {}).get(was.name, {}).get(entry.name)
    if kept is None or not kept.is_of(now.value, now.reason):
        is_of_data = before.behind.components.get(entry.name, data) == data
        if was.name not in _ran(before, was.file) or not (is_of_one and is_of_data):
            return now
        return now._replace(uses=then)
    kept = kept._replace(uses=_renamed(kept.uses, new_names))
    if kept.data == data:
        return kept
    is_new_data = is_of_one and before.behind.components.get(entry.name, kept.data) == kept.data
    is_used = ref in _by_ref(then) and ref in _by_ref(now.uses)
    if is_new_data and is_used and before.fingerprint == final.fingerprint:
        # The same run with other data: each use counts by its new figure.
        return kept._replace(uses=_scaled(kept.uses, then, now.uses), data=data)
    is_moved = any(_moves(ref, entry.name, kept, now.uses, frozenset(), only_names=True))
    return kept if is_moved else now


def uses_of(entry: ControllerLock, component: str) -> Uses:
    """Return the computed figure of a component in each function that uses it, by source.

    A function that did not run uses nothing, whatever its block says of an earlier run.
    """
    uses: dict[str, dict[str, str]] = {}
    for file, written in entry.blocks.items():
        ran = _ran(entry, file)
        for name, block in written.items():
            held = block.components.get(component) if name in ran else None
            text = None if held is None else held.values.get(PROBABILITY.key)
            if text is not None and float(text) > 0.0:
                uses.setdefault(file, {})[name] = text
    return uses


def _ran(entry: ControllerLock, file: str) -> Collection[str]:
    """Return the functions of a file that ran; all with a block where the lock does not say."""
    return (entry.behind.functions or entry.blocks).get(file, ())


def _renamed(uses: Uses, new_names: Mapping[FunctionRef, FunctionRef]) -> Uses:
    renamed: dict[str, dict[str, str]] = {}
    for ref, text in _by_ref(uses).items():
        new = new_names.get(ref, ref)
        renamed.setdefault(new.file, {})[new.name] = text
    return renamed


def _scaled(kept: Uses, then: Uses, now: Uses) -> Uses:
    before, after = _by_ref(then), _by_ref(now)
    scaled: dict[str, dict[str, str]] = {}
    for ref, text in _by_ref(kept).items():
        if ref in before and ref in after:
            text = f"{float(text) * float(after[ref]) / float(before[ref]):.4g}"
        scaled.setdefault(ref.file, {})[ref.name] = text
    return scaled


def _by_ref(uses: Uses) -> dict[FunctionRef, str]:
    return {
        FunctionRef(file, QualifiedName(name)): text
        for file, row in uses.items()
        for name, text in row.items()
    }


def moved_in(
    entry: ControllerLock, blocks: Mapping[FunctionRef, RiskBlock]
) -> Iterator[tuple[MovedUse, ComponentEntry]]:
    """Yield `moved_uses` with their entries in blocks, unless a user wrote another value there."""
    if not entry.owned:
        return
    for moved in moved_uses(entry):
        block = blocks.get(moved.ref)
        for component in () if block is None else block.components:
            value = owned_text(component) or ""
            if component.name == moved.component and moved.owned.is_of(value, reason_of(component)):
                yield moved, component


def moved_uses(entry: ControllerLock) -> Iterator[MovedUse]:
    """Yield the values set by hand that are not for what their functions do now, by the lock."""
    by_hand: dict[str, set[FunctionRef]] = {}
    for file, functions in entry.owned.items():
        for name, row in functions.items():
            for component in row:
                of_component = by_hand.setdefault(component, set())
                of_component.add(FunctionRef(file, QualifiedName(name)))
    for file, functions in entry.owned.items():
        for name, row in functions.items():
            for component, owned in row.items():
                ref = FunctionRef(file, QualifiedName(name))
                uses = uses_of(entry, component)
                is_other_data = owned.data != entry.behind.components.get(component, "")
                yield from _moves(
                    ref, component, owned, uses, by_hand[component], only_names=is_other_data
                )


def _moves(
    ref: FunctionRef,
    component: str,
    owned: OwnedValue,
    uses: Uses,
    by_hand: Collection[FunctionRef],
    *,
    only_names: bool,
) -> Iterator[MovedUse]:
    """Yield the value where its use has moved; `only_names` where figures are of other data."""
    then, now = _by_ref(owned.uses), _by_ref(uses)
    took = tuple(sorted(now.keys() - then.keys() - {ref, *by_hand}))
    gave = tuple(sorted(then.keys() - now.keys() - {ref}))
    moved = MovedUse(ref, component, owned, now.get(ref, ""), took, gave)
    if ref not in then:
        # Set for a use that tracerisk did not see: nothing is known of it.
        return
    if owned.value == OMITTED and not took:
        return
    if ref not in now:
        yield moved._replace(gave=())
    elif not only_names:
        change = abs(float(now[ref]) - float(then[ref])) / float(then[ref])
        if change > (_NOISE if took or gave else _SAME_USE):
            yield moved
