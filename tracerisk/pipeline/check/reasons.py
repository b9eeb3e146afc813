"""What a user set in blocks, and what without saying why."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import component_fields
from tracerisk.adder.sources.placed import PlacedBlock
from tracerisk.errors import Location
from tracerisk.pipeline.check.finding import CheckFinding
from tracerisk.pipeline.check.remedies import with_remedy


def without_reason(blocks: Iterable[PlacedBlock], shown: str) -> Iterable[CheckFinding]:
    """Yield a finding for each thing that a user set without a reason in a file's blocks."""
    for placed in blocks:
        for path, place, reason in set_by_hand(placed.block):
            if reason is None:
                message = f"{path} is set by hand without a reason"
                finding = CheckFinding("unjustified", message, place or Location(shown), path)
                yield with_remedy(finding, Path(shown))


def set_by_hand(block: RiskBlock) -> Iterator[tuple[str, Location | None, str | None]]:
    """Yield what a user set in a block: its dotted path, its place, its reason if it has one."""
    if block.added:
        yield block.name, block.location, block.reason
    for key, value in (("callSequence", block.call_sequence), ("next", block.next)):
        if value is not None and value.pinned:
            yield f"{block.name}.{key}", value.location, value.reason
    for component in block.components:
        path = f"{block.name}.{component.name}"
        if component.added or component.omitted:
            yield path, component.location, component.reason
        for kind, field in component_fields(component):
            if field.pinned:
                yield f"{path}.{kind.key}", field.location, field.reason
