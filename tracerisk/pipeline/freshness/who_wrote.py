"""What git and the inputs of the last run say of who wrote the values in a source's blocks.

It is asked only where a block's digest and the lock do not know a value: git takes its time.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import TYPE_CHECKING

from tracerisk.adder.blocks.values import CALL_SEQUENCE
from tracerisk.adder.lock.digest import digest_of, digests_of_versions
from tracerisk.adder.lock.lock import ControllerLock
from tracerisk.adder.merge.authors import Evidence
from tracerisk.adder.sources.renames import FollowedSource, followed_sources
from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import stale_reasons, values_reasons
from tracerisk.pipeline.freshness.known_controllers import sources_with_blocks
from tracerisk.pipeline.freshness.run_inputs import RunInputs
from tracerisk.pipeline.workspace.controller import Controller

if TYPE_CHECKING:
    from tracerisk.adder.merge.bases import SourceEvidence
    from tracerisk.pipeline.history.kept_by_git import Kept


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
    def of_controller() -> Mapping[str, FollowedSource]:
        sources, shown = sources_with_blocks(controller, entry)
        return followed_sources(sources, entry, shown)

    @cache
    def of_file(file: str) -> Evidence:
        # Imported here: of most blocks nobody has to ask git.
        from tracerisk.pipeline.history.kept_by_git import kept_by_git

        kept = kept_by_git(controller.root.resolve(), file)
        followed = of_controller()
        here = followed.get(file)
        is_of_run = is_fresh() and (here is None or _is_as_locked(here))
        is_known = kept.is_complete and (here is None or _is_of_one_version(here, kept, entry))
        versions = {*kept.versions, *_versions_here(entry, followed)}
        return Evidence(is_of_run, is_known, kept.written, kept.standing, versions)

    return of_file


def _versions_here(
    entry: ControllerLock | None, followed: Mapping[str, FollowedSource]
) -> Iterable[frozenset[str]]:
    """Yield the functions with a block in the sources, and in what the lock says was written."""
    yield frozenset(str(block.function) for one in followed.values() for block in one.placed)
    # Lines that a merge has mixed may name a function twice, as it was and as it is.
    for blocks in () if entry is None or entry.is_mixed else entry.all_blocks:
        yield frozenset(name for written in blocks.values() for name in written)


def _is_as_locked(followed: FollowedSource) -> bool:
    """Return whether every block of a file was last written as the lock says.

    Where one was written otherwise, another branch has come into the file. So it has where more
    than one rank is another: a function that is new on a branch moves all that come after it.
    """
    written = followed.bases[0]
    moved = 0
    for placed in followed.placed:
        block, base = placed.block, written.get(placed.block.name)
        if block.digest is not None and (base is None or block.digest != digest_of(base)):
            return False
        rank = block.call_sequence
        if base is not None:
            moved += not rank.pinned and rank.text != base.values.get(CALL_SEQUENCE.key)
    return moved < 2


def _is_of_one_version(followed: FollowedSource, kept: Kept, entry: ControllerLock | None) -> bool:
    """Return whether one version of a file, or of the lock, has the digests of all its blocks.

    Else a merge has brought lines of several together, and may have left out some.
    """
    here = {placed.block.digest for placed in followed.placed} - {None}
    locked = () if entry is None or entry.is_mixed else digests_of_versions(entry)
    return any(here <= digests for digests in (*kept.digests, *locked))
