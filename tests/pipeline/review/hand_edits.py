"""Random edits of risk blocks by hand: pins, edits, omissions, and what is deleted."""

import random
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.values import (
    DONE,
    NOTHING_COMPUTED,
    component_fields,
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.common.hardware.redundancy import Redundancy

Key = tuple[str, str]
"""A function: its file and its qualified name there."""


def edited_by_hand(blocks: dict[Key, RiskBlock], chance: random.Random) -> str:
    """Edit one of the blocks that the tool has written, whose digest stays; return what was done."""
    if not blocks:
        return "nothing"
    key = chance.choice(list(blocks))
    if chance.random() < 0.05:
        del blocks[key]
        return "delete_block"
    edits: tuple[Callable[[RiskBlock, random.Random], RiskBlock], ...] = (
        *(_pin, _pin, _edit, _omit, _by_hand_component, _drop_component, _pin_rank, _pin_next),
        *(_drop_next, _drop_digest, _mark_block),
    )
    edit = chance.choice(edits)
    blocks[key] = edit(blocks[key], chance)
    return f"{edit.__name__.lstrip('_')} {key[1]}"


def _with_value(
    chance: random.Random, block: RiskBlock, change: Callable[[Field[Any], Field[Any]], Field[Any]]
) -> RiskBlock:
    entries = [each for each in block.components if not each.omitted]
    if not entries:
        return block
    entry = chance.choice(entries)
    kind, value = chance.choice(component_fields(entry))
    new: Field[Any] = {
        "probability": computed_probability(chance.choice((0.0, 3e-7, 1.0))),
        "quantity": computed_count(chance.randint(1, 3)),
        "redundancy": computed_redundancy(Redundancy(chance.random() < 0.5)),
    }[kind.key]
    changed = replace(entry, **{kind.key: change(value, new)})
    return _with(block, entry, changed)


def _pin(block: RiskBlock, chance: random.Random) -> RiskBlock:
    def pinned(value: Field[Any], new: Field[Any]) -> Field[Any]:
        computed = value.computed if value.pinned else value.text
        computed = chance.choice((computed, computed, None, NOTHING_COMPUTED))
        return replace(new, pinned=True, computed=computed, reason="as measured")

    return _with_value(chance, block, pinned)


def _edit(block: RiskBlock, chance: random.Random) -> RiskBlock:
    return _with_value(chance, block, lambda _, new: new)


def _omit(block: RiskBlock, chance: random.Random) -> RiskBlock:
    if not block.components:
        return block
    entry = chance.choice(block.components)
    if entry.added:
        return block
    unstated: Field[Any] = Field(None, "")
    bare = {"probability": unstated, "quantity": unstated, "redundancy": unstated}
    changed = replace(entry, omitted=True, reason=chance.choice((None, "shielded")))
    return _with(block, entry, replace(changed, **(bare if chance.random() < 0.5 else {})))


def _by_hand_component(block: RiskBlock, chance: random.Random) -> RiskBlock:
    entry = replace(
        new_component(f"hose {chance.randrange(1000)}", 4e-7), added=True, reason="bought"
    )
    return replace(block, components=(*block.components, entry))


def _drop_component(block: RiskBlock, chance: random.Random) -> RiskBlock:
    return replace(block, components=block.components[1:])


def _pin_rank(block: RiskBlock, chance: random.Random) -> RiskBlock:
    rank = computed_count(chance.choice((100, 1000)) + chance.randrange(1000))
    computed = chance.choice((block.call_sequence.text, None))
    pin = replace(rank, pinned=True, computed=computed)
    return replace(block, call_sequence=pin if chance.random() < 0.7 else rank)


def _pin_next(block: RiskBlock, chance: random.Random) -> RiskBlock:
    if block.next is None:
        return block
    steps = computed_next({DONE: 1})
    return replace(block, next=replace(steps, pinned=True, computed=block.next.text))


def _drop_next(block: RiskBlock, chance: random.Random) -> RiskBlock:
    return replace(block, next=None)


def _drop_digest(block: RiskBlock, chance: random.Random) -> RiskBlock:
    return replace(block, digest=chance.choice((None, "4kQ9xa-b7QxZ1")))


def _mark_block(block: RiskBlock, chance: random.Random) -> RiskBlock:
    if any(entry.omitted for entry in block.components):
        return block
    entries = tuple(replace(each, added=False) for each in as_computed(block.components))
    following = None if block.next is None else Field(block.next.value, block.next.text)
    return RiskBlock(
        block.name,
        Field(block.call_sequence.value, block.call_sequence.text),
        following,
        entries,
        added=True,
        reason="never run",
    )


def as_computed(entries: tuple[ComponentEntry, ...]) -> tuple[ComponentEntry, ...]:
    """Return components as the tool writes them: nothing set by hand, none omitted."""
    return tuple(
        replace(
            entry,
            added=False,
            reason=None,
            **{kind.key: Field(value.value, value.text) for kind, value in component_fields(entry)},
        )
        for entry in entries
        if not entry.omitted
    )


def new_component(name: str, probability: float) -> ComponentEntry:
    return ComponentEntry(
        name,
        computed_probability(probability),
        computed_count(1),
        computed_redundancy(Redundancy(False)),
    )


def _with(block: RiskBlock, old: ComponentEntry, new: ComponentEntry) -> RiskBlock:
    entries = tuple(new if entry is old else entry for entry in block.components)
    return replace(block, components=entries)
