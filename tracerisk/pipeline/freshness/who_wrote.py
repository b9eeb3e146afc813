"""What git and the inputs of the last run say of who wrote the values in a source's blocks.

It is asked only where a block's digest and the lock do not know a value: git takes its time.
"""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.values import CALL_SEQUENCE
from tracerisk.adder.lock.digest import digest_of
from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.sources.renames import base_with_names, follow_renames
from tracerisk.common.function_ref import QualifiedName
from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import RunInputs, stale_reasons, values_reasons
from tracerisk.pipeline.workspace.controller import Controller

if TYPE_CHECKING:
    from tracerisk.adder.merge.authors import Evidence
    from tracerisk.adder.merge.bases import SourceEvidence


def evidence_for(
    controller: Controller, entry: ControllerLock | None, settings: Settings
) -> SourceEvidence:
    """Return a function that finds, file by file, who wrote what the lock does not know."""

    @cache
    def is_fresh() -> bool:
        if entry is None or not entry.is_settled:
            return False
        recorded = RunInputs.from_data(entry.inputs)
        reasons = stale_reasons(recorded, controller, settings)
        return not (reasons or values_reasons(recorded, controller, settings))

    @cache
    def of_file(file: str) -> Evidence:
        # Imported here: of most blocks nobody has to ask git.
        from tracerisk.adder.merge.authors import Evidence
        from tracerisk.pipeline.history.kept_by_git import kept_by_git

        kept = kept_by_git(controller.root.resolve(), file)
        is_of_one = is_fresh() and _is_as_locked(controller, entry, file)
        return Evidence(is_of_one, kept.is_complete, kept.written, kept.standing, kept.versions)

    return of_file


def _is_as_locked(controller: Controller, entry: ControllerLock | None, file: str) -> bool:
    """Return whether every block of a file was last written as the lock says.

    Where one was written otherwise, another branch has come into the file. So it has where more
    than one rank is another: a function that is new on a branch moves all that come after it.
    """
    last = {} if entry is None else entry.blocks.get(file, {})
    names = [QualifiedName(name) for name in last]
    row = follow_renames(controller.source_of(file), str(controller.path_of(file)), names)
    written = base_with_names(last, row.renamed)
    blocks = [
        placed_block.block for placed_block in row.placed if placed_block.block.name in written
    ]
    moved = 0
    for block in blocks:
        base = written[block.name]
        if block.digest is not None and block.digest != digest_of(base):
            return False
        rank = block.call_sequence
        moved += not rank.pinned and rank.text != base.values.get(CALL_SEQUENCE.key)
    return moved < 2
