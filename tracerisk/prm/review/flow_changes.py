"""Changes of the chain: states, what follows them, where the mission begins.

A new state makes sense only with the `next` that leads to it, so that what depends on each other
is one change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from tracerisk.adder.blocks.block import Field
from tracerisk.common.strong_components import joined_parts
from tracerisk.prm.hybrid.elements import DONE
from tracerisk.prm.review.change_records import ENTRY, ChangedField, Mark, is_noise
from tracerisk.prm.review.model_parts import ModelParts, RiskVersion, Steps

Edit = Callable[[ModelParts], None]


class FlowItem(NamedTuple):
    """One step of a change of the chain."""

    field: ChangedField
    """The value or block that differs."""
    mark: Mark | None
    """What a reviewer should see of it; `None` for nothing."""
    needs: frozenset[str]
    """Functions in only one version that the step mentions; steps that share one are one
    change."""
    edit: Edit
    """Makes the step in a model taken apart."""


def flow_items(before: RiskVersion, after: RiskVersion) -> tuple[list[FlowItem], int]:
    """Return what changed in the chain, and how many `next` changed by no more than the noise."""
    in_one_version = set(before.blocks) ^ set(after.blocks)
    items = [
        *(
            _added(after, name, in_one_version)
            for name in after.states
            if name not in before.blocks
        ),
        *(
            _removed(before, name, in_one_version)
            for name in before.states
            if name not in after.blocks
        ),
    ]
    noisy = 0
    old, new = before.states, after.states
    for name in new:
        if name not in old or _same(old[name].next, new[name].next):
            continue
        if _is_noise(old[name].next, new[name].next):
            noisy += 1
        else:
            items.append(_next(before, after, name, in_one_version))
    if before.model.entry != after.model.entry:
        items.append(_entry(before, after, in_one_version))
    return items, noisy


def joined(items: Iterable[FlowItem]) -> list[list[FlowItem]]:
    """Return the items in groups that cannot be separated: each function is in one group."""
    return [members for _, members in joined_parts((set(item.needs), [item]) for item in items)]


def _added(after: RiskVersion, name: str, in_one_version: set[str]) -> FlowItem:
    block = after.blocks[name]
    needs = {name} | _mentioned(after.states[name].next, in_one_version)
    changed = ChangedField(name, name, None, None, None, "block", block.location)
    return FlowItem(changed, "new_state", frozenset(needs), lambda parts: parts.put(after, name))


def _removed(before: RiskVersion, name: str, in_one_version: set[str]) -> FlowItem:
    block = before.blocks[name]
    needs = {name} | _mentioned(before.states[name].next, in_one_version)
    changed = ChangedField(name, name, None, None, "block", None, block.location, is_gone=True)
    return FlowItem(changed, "lost_state", frozenset(needs), lambda parts: parts.drop(name))


def _next(before: RiskVersion, after: RiskVersion, name: str, in_one_version: set[str]) -> FlowItem:
    old, new = before.states[name].next, after.states[name].next
    stated = after.blocks[name].next
    place = after.blocks[name].location if stated is None else stated.location
    texts = _text(before.blocks[name].next, old), _text(stated, new)
    changed = ChangedField(f"{name}.next", name, None, "next", *texts, place)
    needs = _mentioned(old, in_one_version) | _mentioned(new, in_one_version)

    def edit(parts: ModelParts) -> None:
        parts.steps[name] = new

    is_new = _targets(old).keys() != _targets(new).keys()
    return FlowItem(changed, "new_next" if is_new else None, frozenset(needs), edit)


def _entry(before: RiskVersion, after: RiskVersion, in_one_version: set[str]) -> FlowItem:
    old, new = before.model.entry, after.model.entry
    place = after.blocks[new].call_sequence.location
    changed = ChangedField(ENTRY, new, None, ENTRY, old, new, place)

    def edit(parts: ModelParts) -> None:
        parts.entry = new

    return FlowItem(changed, None, frozenset({old, new} & in_one_version), edit)


def _text(stated: Field[Any] | None, steps: Steps) -> str:
    if stated is not None and stated.is_stated:
        return stated.text
    return ", ".join(f"{step.target} {step.weight}" for step in steps)


def _targets(steps: Steps) -> dict[str, float]:
    return {step.target: float(step.weight) for step in steps if step.weight > 0}


def _mentioned(steps: Steps, in_one_version: set[str]) -> set[str]:
    return (set(_targets(steps)) - {DONE}) & in_one_version


def _same(one: Steps, other: Steps) -> bool:
    return {(s.target, s.weight) for s in one} == {(s.target, s.weight) for s in other}


def _is_noise(one: Steps, other: Steps) -> bool:
    old, new = _targets(one), _targets(other)
    return old.keys() == new.keys() and all(is_noise(old[name], new[name]) for name in old)
