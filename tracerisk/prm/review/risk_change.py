"""Compare two versions of a controller's risk model: what changed, and what each change does."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import NEXT, block_fields
from tracerisk.prm.review.change_records import (
    ENTRY,
    KIND_OF_CAUSE,
    Cause,
    CauseKind,
    CauseShare,
    ChangedField,
    FunctionChange,
    FunctionFigures,
    Mark,
    RiskChange,
    SinglePoint,
)
from tracerisk.prm.review.component_changes import (
    ComponentItem,
    alike,
    component_items,
    failure_words,
    parted,
)
from tracerisk.prm.review.contributions import contribution
from tracerisk.prm.review.flow_changes import Edit, FlowItem, flow_items, joined
from tracerisk.prm.review.model_parts import (
    RiskVersion,
    single_points,
    tolerated_failures,
)
from tracerisk.prm.review.pin_changes import pin_changes
from tracerisk.prm.review.risk_diff import RiskDiff

CauseOf = Callable[[ChangedField], tuple[Cause, ...]]
"""Returns why a value that no user pinned is another one now."""


def compare(
    before: RiskVersion | None,
    after: RiskVersion | None,
    *,
    name: str,
    was: str | None = None,
    renamed: Mapping[str, str] | None = None,
    cause_of: CauseOf,
    inputs: tuple[str, ...] = (),
    moved: Mapping[str, Sequence[str]] | None = None,
    rated: Mapping[str, float] | None = None,
) -> RiskDiff:
    """Return the difference in risk between two versions of one controller.

    `renamed` gives the later name of functions by their earlier one; `name` and `was` are those
    of the controller. `inputs` lists what the runs behind the blocks depended on that differs.
    `moved` gives the other components of the units of one that only one version has, `rated` the
    ratio of later to earlier figures of components in the hardware description.
    A version is `None` where it has no blocks.
    The contribution of a change is F(before with only that change) - F(before), with F the
    mission's failure probability; `interaction` is what the contributions leave of
    F(after) - F(before).
    """
    names = dict(renamed or {})
    earlier = None if before is None else before.renamed(names)
    changes: tuple[RiskChange, ...] = ()
    causes: tuple[CauseShare, ...] = ()
    interaction = None
    noisy = 0
    points: tuple[SinglePoint, ...] = ()
    if earlier is not None and after is not None:
        if earlier.figures.mission.reading != after.figures.mission.reading:
            # That cycles are counted now, or no longer, is no change of risk.
            earlier, after = earlier.read_as_geometric(), after.read_as_geometric()
        points = _new_single_points(earlier, after, moved or {})
        marks = _Marks(earlier, after, points, moved or {})
        changes, causes, noisy = _changes(earlier, after, marks, cause_of, rated or {})
        total = _mission(after) - _mission(earlier)
        interaction = total - math.fsum(change.contribution or 0.0 for change in changes)
    return RiskDiff(
        name=name,
        was=was,
        before=None if earlier is None else earlier.figures.mission,
        after=None if after is None else after.figures.mission,
        changes=changes,
        interaction=interaction,
        functions=tuple(_functions(earlier, after, names)),
        pins=pin_changes(
            {} if earlier is None else earlier.blocks, {} if after is None else after.blocks
        ),
        single_points=points,
        within_noise=noisy,
        inputs=inputs,
        causes=causes,
    )


class _Part(NamedTuple):
    """A change with the edits that make it."""

    change: RiskChange
    """The change; its contribution is `None` until solved."""
    edits: tuple[Edit, ...]
    """Functions that make the change in a model taken apart."""


def _changes(
    before: RiskVersion,
    after: RiskVersion,
    marks: _Marks,
    cause_of: CauseOf,
    rated: Mapping[str, float],
) -> tuple[tuple[RiskChange, ...], tuple[CauseShare, ...], int]:
    def explained(field: ChangedField) -> ChangedField:
        """Return a change with its cause: a user's pin, else what the caller knows."""
        pinned = any(
            function in blocks and _is_pinned(blocks[function], field.component, key)
            for blocks in (before.blocks, after.blocks)
            for function, key in field.stated
        )
        return replace(field, causes=("pin",) if pinned else cause_of(field))

    flows, quiet_flows = flow_items(before, after)
    items, quiet = component_items(before, after)
    flows = [item._replace(field=explained(item.field)) for item in flows]
    items = [item._replace(fields=tuple(map(explained, item.fields))) for item in items]
    items = [part for item in items for part in parted(item, rated.get(str(item.field.component)))]
    parts = _solved([_component_part(group, marks) for group in alike(items)], before)
    of_flow = _solved([_flow_part(group, marks) for group in joined(flows)], before)
    if any(entry.change.contribution is None for entry in of_flow):
        # One of them alone leads nowhere: they are one change.
        of_flow = _solved([_flow_part(flows, marks)], before)
    parts += of_flow
    ordered = sorted((part.change for part in parts), key=_order)
    return tuple(ordered), _causes(parts, before, marks.moved), quiet + quiet_flows


def _solved(parts: Sequence[_Part], before: RiskVersion) -> list[_Part]:
    return [_solved_part(part, before) for part in parts]


def _solved_part(part: _Part, before: RiskVersion) -> _Part:
    alone = contribution(before, part.edits)
    change = replace(part.change, contribution=alone.failure, undetected=alone.undetected)
    return part._replace(change=change)


def _causes(
    parts: Sequence[_Part], before: RiskVersion, moved: Mapping[str, Sequence[str]]
) -> tuple[CauseShare, ...]:
    """Put changes together by component and kind of cause; each of the chain stays alone.

    A component whose units were another one's is one with that.
    """
    groups: dict[tuple[object, ...], list[_Part]] = {}
    for number, part in enumerate(parts):
        change = part.change
        name = change.component
        key: object = number if name is None else next(iter(moved.get(name, ())), name)
        groups.setdefault((key, *_kinds(change)), []).append(part)
    cause_shares = []
    for group in groups.values():
        first = group[0].change
        functions = tuple(sorted({name for part in group for name in part.change.functions}))
        together, summary = first.contribution, first.summary
        if len(group) > 1:
            edits = (edit for part in group for edit in part.edits)
            together = contribution(before, edits).failure
            named = dict.fromkeys(str(part.change.component) for part in group)
            where = _where([part.change for part in group], together or 0.0)
            summary = f"{' and '.join(sorted(named))} in {where}"
        cause_shares.append(
            CauseShare(first.component, _kinds(first), functions, summary, together)
        )
    return tuple(sorted(cause_shares, key=_order_of_cause))


def _where(changes: Sequence[RiskChange], together: float) -> str:
    """Return the functions of changes, those apart in which the figure goes the other way."""
    along: dict[str, None] = {}
    against: dict[str, None] = {}
    for change in changes:
        is_against = (change.contribution or 0.0) * together < 0.0
        (against if is_against else along).update(dict.fromkeys(change.functions))
    others = [name for name in against if name not in along]
    named = list(along or against)
    where = named[0] if len(named) == 1 else f"{len(named)} functions"
    if not along or not others:
        return where
    other_way = "falling" if together > 0.0 else "rising"
    return f"{where} ({other_way} in {_listed(sorted(others))})"


def _kinds(change: RiskChange) -> tuple[CauseKind, ...]:
    return tuple(dict.fromkeys(KIND_OF_CAUSE[cause] for cause in change.causes))


def _order_of_cause(cause: CauseShare) -> tuple[float, str, tuple[CauseKind, ...]]:
    return (-float(f"{abs(cause.contribution or 0.0):.9g}"), cause.summary, cause.kinds)


def _order(change: RiskChange) -> tuple[float, str, str]:
    # To nine digits: what differs by rounding alone is ordered the same on every machine.
    size = float(f"{abs(change.contribution or 0.0):.9g}")
    return (-size, change.kind, change.fields[0].path)


def _component_part(group: Sequence[ComponentItem], marks: _Marks) -> _Part:
    first = group[0]
    ordered = sorted(group, key=lambda item: item.field.path)
    change = RiskChange(
        kind=first.kind,
        summary=_component_summary(ordered, marks.moved),
        component=first.field.component,
        functions=tuple(item.field.function for item in ordered),
        fields=tuple(field for item in ordered for field in item.fields),
        marks=marks.of_components(group),
    )
    return _Part(change, tuple(item.edit for item in group))


def _component_summary(group: Sequence[ComponentItem], moved: Mapping[str, Sequence[str]]) -> str:
    first = group[0]
    one = first.field
    where = one.function if len(group) == 1 else f"{len(group)} functions"
    lead = f"{one.component} in {where}"
    others = moved.get(str(one.component), ())
    match first.kind:
        case "component_added":
            apart = f" apart from {_listed(others)}" if others else ""
            return f"{lead}: now counted{apart}"
        case "component_removed":
            within = f" apart, but within {_listed(others)}" if others else ""
            return f"{lead}: no longer counted{within}"
        case "component_omitted":
            return f"{lead}: left out by hand"
        case "component_restored":
            return f"{lead}: no longer left out"
    if first.kind == "failures":
        return f"{lead}: {failure_words([item.field for item in group])}"
    text = f"{lead}: {', '.join(map(_values, first.fields))}"
    if first.kind != "probability":
        return text
    if first.ratio is None or first.ratio in (0.0, float("inf")):
        return text if len(group) == 1 else f"{lead}: {one.key}, to or from 0"
    if len(group) == 1:
        return f"{text} (x{first.ratio:.4g})"
    return f"{lead}: {one.key} x{first.ratio:.4g}"


def _values(field: ChangedField) -> str:
    return f"{field.key} {field.before or 'not given'} -> {field.after or 'not given'}"


def _flow_part(group: Sequence[FlowItem], marks: _Marks) -> _Part:
    # A state must be there before a `next` leads to it, and is dropped when none does.
    ordered = sorted(group, key=lambda item: item.field.path)
    change = RiskChange(
        kind="structure",
        summary="; ".join(_flow_summaries(ordered)),
        component=None,
        functions=tuple(dict.fromkeys(item.field.function for item in ordered)),
        fields=tuple(item.field for item in ordered),
        marks=marks.of_flow(ordered),
    )
    return _Part(change, tuple(item.edit for item in ordered))


def _flow_summaries(group: Sequence[FlowItem]) -> Iterator[str]:
    for mark, words in (("new_state", "new state"), ("lost_state", "removed state:")):
        names = [item.field.function for item in group if item.mark == mark]
        if names:
            yield f"{words}{'s' if len(names) > 1 and mark == 'new_state' else ''} {_listed(names)}"
    following = [item.field for item in group if item.field.key == NEXT.key]
    if len(following) == 1:
        one = following[0]
        yield f"{one.function}: next {one.before} -> {one.after}"
    elif following:
        yield f"next of {_listed([field.function for field in following])}"
    for item in group:
        if item.field.key == ENTRY:
            yield f"the mission starts with {item.field.after}, no longer {item.field.before}"


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:3])
    return shown if len(names) <= 3 else f"{shown} and {len(names) - 3} more"


class _Marks:
    """What a reviewer should see of a change beside its figure."""

    def __init__(
        self,
        before: RiskVersion,
        after: RiskVersion,
        points: Sequence[SinglePoint],
        moved: Mapping[str, Sequence[str]],
    ) -> None:
        self.moved = moved
        self._before = before.states
        self._after = after.states
        self._points = {point.component: point.functions for point in points}

    def of_components(self, group: Sequence[ComponentItem]) -> tuple[Mark, ...]:
        marks: list[Mark] = []
        kind, component = group[0].kind, str(group[0].field.component)
        functions = [item.field.function for item in group]
        if kind in ("quantity", "redundancy") and any(
            self._lost(name, component) for name in functions
        ):
            marks.append("lost_redundancy")
        if kind in ("quantity", "redundancy", "component_added", "component_restored") and set(
            functions
        ) & set(self._points.get(component, ())):
            marks.append("single_point_of_failure")
        return tuple(marks)

    def of_flow(self, group: Sequence[FlowItem]) -> tuple[Mark, ...]:
        marks = {item.mark for item in group if item.mark is not None}
        added = {item.field.function for item in group if item.mark == "new_state"}
        if any(added & set(functions) for functions in self._points.values()):
            marks.add("single_point_of_failure")
        return tuple(sorted(marks))

    def _lost(self, function: str, component: str) -> bool:
        before = tolerated_failures(self._before[function].tree)
        after = tolerated_failures(self._after[function].tree)
        return after.get(component, 0) < before.get(component, 0)


def _new_single_points(
    before: RiskVersion, after: RiskVersion, moved: Mapping[str, Sequence[str]]
) -> tuple[SinglePoint, ...]:
    old, new = single_points(before.model), single_points(after.model)
    known = {parameter.component for parameter in before.model.parameters}
    # A unit that one component gave up to another fails the mission as it did.
    apart = {name for name, others in moved.items() if others and set(others) <= set(old)}
    return tuple(
        SinglePoint(name, tuple(new[name]), name not in known)
        for name in sorted(set(new) - set(old) - apart)
    )


def _is_pinned(block: RiskBlock, component: str | None, key: str | None) -> bool:
    if key is not None:
        fields = block_fields(block, component)
        return key in fields and fields[key][1].pinned
    if component is None:
        return block.added
    return any(
        entry.name == component and (entry.added or entry.omitted) for entry in block.components
    )


def _functions(
    before: RiskVersion | None, after: RiskVersion | None, renamed: Mapping[str, str]
) -> Iterable[FunctionChange]:
    was = {new: old for old, new in renamed.items()}
    old = {} if before is None else before.states
    new = {} if after is None else after.states
    for name in [*new, *(name for name in old if name not in new)]:
        yield FunctionChange(
            name, was.get(name), _figures(before, name, old), _figures(after, name, new)
        )


def _figures(
    version: RiskVersion | None, name: str, states: Mapping[str, object]
) -> FunctionFigures | None:
    if version is None or name not in states:
        return None
    figures = version.figures
    return FunctionFigures(figures.top_events[name], figures.expected_visits[name])


def _mission(version: RiskVersion) -> float:
    return version.figures.mission.failure_probability
