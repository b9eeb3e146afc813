"""What was computed where a refresh kept a written value within the tolerance of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock
from tracerisk.adder.blocks.values import PROBABILITY, computed_probability
from tracerisk.adder.lock.lock import ControllerLock


def as_computed(
    block: RiskBlock, entry: ControllerLock | None, file: str, function: str
) -> RiskBlock:
    """Return a block with what was computed in the place of what the last refresh kept.

    `file` is its source as the lock names it. A value that is not as written is someone's edit, and
    stays.
    """
    if entry is None or not entry.kept.get(file, {}).get(function):
        return block
    return replace(block, components=tuple(_computed(block, entry, file, function)))


def as_repeated(block: RiskBlock, earlier: RiskBlock | None, repeats: float) -> RiskBlock:
    """Return a block with each value of an earlier one from which it differs by no more.

    `repeats` is how far, relatively, two runs of the same differ. A value of a user stays.
    """
    if earlier is None or not repeats:
        return block
    before = {component.name: component.probability for component in earlier.components}
    components = (
        replace(component, probability=before[component.name])
        if component.name in before
        and _is_near(before[component.name], component.probability, repeats)
        else component
        for component in block.components
    )
    return replace(block, components=tuple(components))


def _is_near(before: Field[float], now: Field[float], repeats: float) -> bool:
    if before.pinned or now.pinned:
        return False
    return 0.0 < abs(now.value - before.value) <= repeats * before.value


def _computed(
    block: RiskBlock, entry: ControllerLock, file: str, function: str
) -> Iterator[ComponentEntry]:
    written = entry.blocks.get(file, {}).get(function)
    texts = entry.kept[file][function]
    for component in block.components:
        field = component.probability
        known = None if written is None else written.components.get(component.name)
        is_as_written = known is not None and known.values.get(PROBABILITY.key) == field.text
        if component.name in texts and is_as_written and not (field.pinned or component.added):
            value = computed_probability(float(texts[component.name]))
            yield replace(component, probability=replace(value, location=field.location))
        else:
            yield component
