"""What git and the inputs of the last run say of who wrote the values in a source's blocks.

It is asked only where a block's digest and the lock do not know a value: git takes its time.
"""

from __future__ import annotations

from functools import cache

from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.merge.authors import Evidence
from tracerisk.adder.merge.bases import SourceEvidence
from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import RunInputs, stale_reasons, values_reasons
from tracerisk.pipeline.workspace.controller import Controller


def evidence_for(
    controller: Controller, entry: ControllerLock | None, settings: Settings
) -> SourceEvidence:
    """Return what tells, of a file of a controller, who wrote what the lock does not know."""

    @cache
    def is_fresh() -> bool:
        if entry is None or not entry.is_settled:
            return False
        recorded = RunInputs.from_data(entry.inputs)
        reasons = stale_reasons(recorded, controller, settings)
        return not (reasons or values_reasons(recorded, settings))

    @cache
    def of_file(file: str) -> Evidence:
        # Imported here: of most blocks nobody has to ask git.
        from tracerisk.pipeline.history.kept_by_git import kept_by_git

        kept = kept_by_git(controller.root.resolve(), file)
        return Evidence(is_fresh(), kept.is_complete, kept.written, kept.standing, kept.versions)

    return of_file
