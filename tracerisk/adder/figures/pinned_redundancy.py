"""A redundancy set by hand over units that differ, which no block can state."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import NOTHING_COMPUTED, REDUNDANCY, read_redundancy
from tracerisk.adder.figures.instance_values import InstanceValues, are_alike
from tracerisk.adder.lock.lock import WrittenBlock
from tracerisk.errors import BlockError, Location

_MOST_SHOWN = 8


def check_redundancies(block: RiskBlock, instances: InstanceValues) -> None:
    """Raise BlockError where a redundancy is set by hand for units that differ.

    The block's one probability stands for unlike units only under the gate of the hardware
    description; under another gate it means nothing, unless the user sets the probability too.
    """
    for redundancy in unfounded_redundancies(block, instances):
        raise BlockError(redundancy.message, redundancy.location or block.location)


@dataclass(frozen=True, slots=True)
class Unfounded:
    """A redundancy over units that differ."""

    path: str
    """The dotted path of the value, such as `place.motor.redundancy`."""
    location: Location | None
    """The file and line of the value; `None` where not known."""
    message: str
    """What is wrong and what to do."""


def unfounded_redundancies(
    block: RiskBlock, instances: InstanceValues, written: WrittenBlock | None = None
) -> Iterator[Unfounded]:
    """Yield each such redundancy of a block.

    What the tool computed stands beside the user's value after a refresh; before it, only in the
    block as it was last `written`.
    """
    if block.added:
        return
    for entry in block.components:
        values = instances.get(entry.name, {})
        computed = entry.redundancy.computed or _written_redundancy(written, entry.name)
        if _is_set_alone(entry, computed) and not are_alike(values.values()):
            yield Unfounded(
                f"{block.name}.{entry.name}.redundancy",
                entry.redundancy.location or entry.location,
                f"function '{block.name}', component '{entry.name}': 'redundancy := "
                f"{entry.redundancy.text}' is set for units that differ ({_shown(values)} per "
                f"visit); the block's probability holds only with 'redundancy = "
                f"{computed}'; state the redundancy in the hardware "
                "description, or set the probability of a unit by hand too (probability := ...)",
            )


def _is_set_alone(entry: ComponentEntry, computed: str | None) -> bool:
    """Whether a user set another redundancy than the tool's, and no probability."""
    redundancy = entry.redundancy
    if entry.added or entry.omitted or not redundancy.pinned or entry.probability.pinned:
        return False
    if computed is None or computed == NOTHING_COMPUTED:
        return False
    return read_redundancy(computed) != redundancy.value


def _written_redundancy(written: WrittenBlock | None, component: str) -> str | None:
    known = None if written is None else written.components.get(component)
    return None if known is None else known.values.get(REDUNDANCY.key)


def _shown(values: Mapping[str, float]) -> str:
    """Return the instances' values, the greatest first."""
    ordered: Sequence[tuple[str, float]] = sorted(
        values.items(), key=lambda item: (-item[1], item[0])
    )
    texts = [f"{element} {value:.4g}" for element, value in ordered[:_MOST_SHOWN]]
    left = len(ordered) - len(texts)
    return ", ".join([*texts, f"and {left} more"] if left else texts)
