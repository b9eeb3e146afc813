"""Values that users set by hand in blocks, where what they stand for has changed since."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.figures.instance_values import kept_values
from tracerisk.adder.figures.pinned_redundancy import unfounded_redundancies
from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.merge.owned import moved_in
from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location
from tracerisk.pipeline.check.against_lock import CheckedSource
from tracerisk.pipeline.check.finding import CheckFinding


def unequal_units(
    entry: ControllerLock, sources: Sequence[CheckedSource]
) -> Iterable[CheckFinding]:
    """Yield the redundancies set by hand over units that differed when it was last run."""
    names = model_names(
        [
            FunctionRef(source.file, placed.function)
            for source in sources
            for placed in source.placed
        ]
    )
    for source in sources:
        for placed in source.placed:
            name = names[FunctionRef(source.file, placed.function)]
            instances = kept_values(entry.trace, name)
            written = source.followed.bases[0].get(placed.function)
            for redundancy in unfounded_redundancies(placed.block, instances, written):
                place = redundancy.location or Location(source.shown, placed.first_line)
                yield CheckFinding("unequal", redundancy.message, place, redundancy.path)


def moved_values(
    entry: ControllerLock,
    sources: Sequence[CheckedSource],
    blocks: Mapping[FunctionRef, RiskBlock],
) -> Iterable[CheckFinding]:
    """Yield the values set by hand for what their functions do no more, or not alone."""
    shown = {source.file: source.shown for source in sources}
    for moved, component in moved_in(entry, blocks):
        place = component.location or Location(shown[moved.ref.file])
        yield CheckFinding("moved", f"{moved.message}; {moved.remedy}", place, moved.path)
