"""What a user set in blocks without saying why."""

from __future__ import annotations

from collections.abc import Iterable
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
        for path, place in _values_without_reason(placed.block):
            message = f"{path} is set by hand without a reason"
            finding = CheckFinding("unjustified", message, place or Location(shown), path)
            yield with_remedy(finding, Path(shown))


def _values_without_reason(block: RiskBlock) -> Iterable[tuple[str, Location | None]]:
    if block.added and block.reason is None:
        yield block.name, block.location
    for key, value in (("callSequence", block.call_sequence), ("next", block.next)):
        if value is not None and value.pinned and value.reason is None:
            yield f"{block.name}.{key}", value.location
    for component in block.components:
        path = f"{block.name}.{component.name}"
        if (component.added or component.omitted) and component.reason is None:
            yield path, component.location
        for kind, value in component_fields(component):
            if value.pinned and value.reason is None:
                yield f"{path}.{kind.key}", value.location
