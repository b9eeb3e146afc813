"""Changes of components: their figures, and whether they count in a function at all."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.failures import are_close, read_failures
from tracerisk.adder.blocks.values import (
    FAILURES,
    PROBABILITY,
    QUANTITY,
    FieldKind,
    component_fields,
    computed_probability,
)
from tracerisk.prm.review.change_records import (
    NOISE,
    Cause,
    ChangedField,
    ChangeKind,
    is_noise,
)
from tracerisk.prm.review.flow_changes import Edit
from tracerisk.prm.review.model_parts import ModelParts, RiskVersion, counted_components
from tracerisk.prm.review.risk_diff import ratio_of

_ORDER = {"unaware": -2, "stopped late": -1, "stopped safely": 1}
"""Kinds of outcomes in the order in which they are listed, the gravest first."""


class ComponentItem(NamedTuple):
    """One change of one component in one function.

    Quantity and redundancy are one change where both differ, for either alone may make no sense.
    """

    kind: ChangeKind
    """What changed of the component."""
    fields: tuple[ChangedField, ...]
    """Values that differ, at least one."""
    ratio: float | None
    """Later probability over the earlier, infinite for one that was zero; `None` where
    something else changed."""
    edit: Edit
    """Makes the change in a model taken apart."""

    @property
    def field(self) -> ChangedField:
        """The first of its fields."""
        return self.fields[0]


def component_items(before: RiskVersion, after: RiskVersion) -> tuple[list[ComponentItem], int]:
    """Return what changed in functions that both versions have, and how much was only noise."""
    items: list[ComponentItem] = []
    noisy = 0
    for name in after.states:
        if name in before.blocks:
            result, quiet = _in_function(before.blocks[name], after.blocks[name])
            items += result
            noisy += quiet
    return items, noisy


def parted(item: ComponentItem, ratio: float | None) -> list[ComponentItem]:
    """Return a change of a probability in two: by the hardware's figure, and by all else.

    `ratio` is that of the figure, `None` where no one is known. A part that is noise is left out;
    a change with one cause stays whole.
    """
    first = item.field
    others = tuple(cause for cause in first.causes if cause != "hardware")
    has_both = "hardware" in first.causes and bool(others)
    if ratio is None or item.kind != "probability" or item.ratio is None or not has_both:
        return [item]
    rest = item.ratio / ratio
    if is_noise(1.0, ratio) or rest in (0.0, math.inf):
        return [item]
    parts = [_scaled(item, ratio, ("hardware",))]
    return parts if is_noise(1.0, rest) else [*parts, _scaled(item, rest, others)]


def _scaled(item: ComponentItem, ratio: float, causes: tuple[Cause, ...]) -> ComponentItem:
    """Return the change of a probability by a ratio alone."""
    field = item.field
    function, component = field.function, str(field.component)

    def edit(parts: ModelParts) -> None:
        held = parts.components[function]
        was = held[component].probability
        held[component] = replace(
            held[component], probability=replace(was, value=min(1.0, was.value * ratio))
        )

    after = computed_probability(min(1.0, float(field.before or 0.0) * ratio)).text
    return ComponentItem("probability", (replace(field, after=after, causes=causes),), ratio, edit)


def alike(items: Sequence[ComponentItem]) -> list[list[ComponentItem]]:
    """Return the items in groups that are one change made in several functions.

    They are of one component, kind and cause; probabilities by one ratio, noise left aside,
    other fields from one value to one other; of what follows failures the same kinds rise and fall.
    """
    groups: dict[tuple[object, ...], list[ComponentItem]] = {}
    for item in items:
        causes = tuple(field.causes for field in item.fields)
        key: tuple[object, ...] = (item.kind, item.field.component, causes)
        if item.kind == "failures":
            key = (*key, _directions(item.field))
        if item.kind in ("quantity", "redundancy"):
            key = (*key, *((field.key, field.before, field.after) for field in item.fields))
        groups.setdefault(key, []).append(item)
    return [part for group in groups.values() for part in _by_ratio(group)]


def failure_words(fields: Sequence[ChangedField]) -> str:
    """Return how what follows a component's failures changed, by the share of each kind.

    In several functions a share is given from the least to the greatest of these.
    """
    before = [_shares(field.before) for field in fields]
    after = [_shares(field.after) for field in fields]
    if not any(after):
        return "what follows its failures is no longer known"
    kinds = sorted({kind for shares in (*before, *after) for kind in shares}, key=_rank)
    if not any(before):
        shares = ", ".join(f"{kind} {_percent(after, kind)}" for kind in kinds)
        return f"what follows its failures is known now: {shares}"
    changes = [
        f"{kind} {_percent(before, kind)} -> {_percent(after, kind)}"
        for kind in kinds
        if any(_apart(old, new, kind) for old, new in zip(before, after, strict=True))
    ]
    if changes:
        return f"of its failures {', '.join(changes)}"
    return "the same follows its failures, of other modes or in other functions"


def _shares(text: str | None) -> dict[str, float]:
    """Return the share of a component's failures that each kind of outcome has."""
    shares: dict[str, float] = {}
    for mode in () if text is None else read_failures(text):
        for outcome in mode.outcomes:
            kind = f"back to {outcome.target}" if outcome.target else outcome.kind
            shares[kind] = shares.get(kind, 0.0) + float(mode.share * outcome.share)
    return shares


def _directions(field: ChangedField) -> tuple[object, ...]:
    """Return which version knows what follows failures, and which kinds of it rise or fall."""
    before, after = _shares(field.before), _shares(field.after)
    kinds = sorted({*before, *after})
    moved = [kind for kind in kinds if _apart(before, after, kind)]
    rises = [(kind, after.get(kind, 0.0) > before.get(kind, 0.0)) for kind in moved]
    return bool(before), bool(after), *rises


def _rank(kind: str) -> tuple[int, str]:
    return _ORDER.get(kind, 0), kind


def _apart(before: Mapping[str, float], after: Mapping[str, float], kind: str) -> bool:
    """Return whether a share is another one as it is printed."""
    return _digits(before.get(kind, 0.0)) != _digits(after.get(kind, 0.0))


def _percent(shares: Sequence[Mapping[str, float]], kind: str) -> str:
    """Return the share that a kind has in several functions."""
    values = [of_kind.get(kind, 0.0) for of_kind in shares]
    ends = dict.fromkeys(map(_digits, (min(values), max(values))))
    return f"{' to '.join(ends)} %"


def _digits(share: float) -> str:
    return f"{100.0 * share:.3g}"


def _by_ratio(group: Sequence[ComponentItem]) -> Iterator[list[ComponentItem]]:
    ordered = sorted(group, key=lambda item: item.ratio or 0.0)
    part: list[ComponentItem] = []
    for item in ordered:
        if part and not _near(part[0].ratio, item.ratio):
            yield part
            part = []
        part.append(item)
    if part:
        yield part


def _near(one: float | None, other: float | None) -> bool:
    if one is None or other is None:
        return one is other
    if math.inf in (one, other):
        return one == other
    return abs(other - one) <= NOISE * one


def _in_function(before: RiskBlock, after: RiskBlock) -> tuple[list[ComponentItem], int]:
    old, new = counted_components(before), counted_components(after)
    omitted_before = {entry.name for entry in before.components if entry.omitted}
    omitted_after = {entry.name: entry for entry in after.components if entry.omitted}
    items: list[ComponentItem] = []
    noisy = 0
    for name in dict.fromkeys([*new, *old]):
        if name not in old:
            kind: ChangeKind = "component_restored" if name in omitted_before else "component_added"
            items.append(_put(kind, after.name, new[name]))
        elif name not in new:
            kind = "component_omitted" if name in omitted_after else "component_removed"
            items.append(_drop(kind, after.name, old[name], omitted_after.get(name)))
        else:
            changed_items, quiet = _fields(after.name, old[name], new[name])
            items += changed_items
            noisy += quiet
    return items, noisy


def _fields(
    function: str, old: ComponentEntry, new: ComponentEntry
) -> tuple[list[ComponentItem], int]:
    earlier = dict(component_fields(old))
    later = dict(component_fields(new))
    items = []
    noisy = 0
    units: list[tuple[FieldKind, Field[Any] | None, Field[Any] | None]] = []
    for kind in dict.fromkeys([*earlier, *later]):
        before, after = earlier.get(kind), later.get(kind)
        if before is not None and after is not None:
            if kind.same(before.value, after.value):
                continue
            if kind is FAILURES and are_close(before.value, after.value, NOISE):
                noisy += 1
                continue
            if kind.is_noisy and is_noise(before.value, after.value):
                noisy += 1
                continue
        if kind is PROBABILITY:
            items.append(_changed("probability", function, new, [(kind, before, after)]))
        elif kind is FAILURES:
            items.append(_changed("failures", function, new, [(kind, before, after)]))
        else:
            units.append((kind, before, after))
    if units:
        only_quantity = all(kind is QUANTITY for kind, _, _ in units)
        named: ChangeKind = "quantity" if only_quantity else "redundancy"
        items.append(_changed(named, function, new, units))
    return items, noisy


def _changed(
    named: ChangeKind,
    function: str,
    entry: ComponentEntry,
    values: Sequence[tuple[FieldKind, Field[Any] | None, Field[Any] | None]],
) -> ComponentItem:
    component = entry.name
    held_after: dict[str, Any] = {kind.key: after for kind, _, after in values}
    ratio = None
    _, before, after = values[0]
    if named == "probability" and before is not None and after is not None:
        ratio = ratio_of(before.value, after.value)
        ratio = math.inf if ratio is None else ratio

    def edit(parts: ModelParts) -> None:
        held = parts.components[function]
        held[component] = replace(held[component], **held_after)

    fields = tuple(
        ChangedField(
            path=f"{function}.{component}.{kind.key}",
            function=function,
            component=component,
            key=kind.key,
            before=None if old is None else old.text or None,
            after=None if new is None else new.text or None,
            location=entry.location if new is None else new.location,
        )
        for kind, old, new in values
    )
    return ComponentItem(named, fields, ratio, edit)


def _put(kind: ChangeKind, function: str, entry: ComponentEntry) -> ComponentItem:
    def edit(parts: ModelParts) -> None:
        parts.components[function][entry.name] = entry

    path, text = f"{function}.{entry.name}", entry.probability.text
    changed = ChangedField(path, function, entry.name, None, None, text, entry.location)
    return ComponentItem(kind, (changed,), None, edit)


def _drop(
    kind: ChangeKind, function: str, entry: ComponentEntry, omitted: ComponentEntry | None
) -> ComponentItem:
    def edit(parts: ModelParts) -> None:
        del parts.components[function][entry.name]

    path, text = f"{function}.{entry.name}", entry.probability.text
    changed = ChangedField(path, function, entry.name, None, text, None, entry.location, True)
    if omitted is not None:
        changed = replace(changed, after="omit", location=omitted.location, is_gone=False)
    return ComponentItem(kind, (changed,), None, edit)
