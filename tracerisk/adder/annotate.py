"""From sources and computed blocks to annotated sources and the lock that goes with them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.model_names import model_names
from tracerisk.adder.blocks.values import DONE, computed_count
from tracerisk.adder.figures.instance_values import InstanceValues
from tracerisk.adder.figures.pinned_redundancy import check_redundancies
from tracerisk.adder.lock.digest import with_digest
from tracerisk.adder.lock.lock import (
    Behind,
    ControllerLock,
    Kept,
    Lock,
    WrittenBlock,
    written_block,
)
from tracerisk.adder.merge.authors import Evidence
from tracerisk.adder.merge.bases import SourceEvidence, merge_with_bases
from tracerisk.adder.merge.edits_found import HandEdit, MergePolicy, edits_error, in_the_way
from tracerisk.adder.merge.hand_edits import check_targets, give_way, is_next_by_hand, ranks_by_hand
from tracerisk.adder.merge.owned import owned_values
from tracerisk.adder.merge.steady import is_same_run, kept_values, steady_components
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.adder.sources.renames import FollowedSource, followed_sources
from tracerisk.adder.sources.write import FileWrite
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.errors import EditInTheWayError


@dataclass(frozen=True, slots=True)
class SourceBlocks:
    """One source of a controller and the blocks computed for its functions."""

    file: str
    """The path from the lock's folder, with slashes."""
    source: bytes
    """The content, with the `name` in each block brought up to date with renamed functions."""
    computed: Mapping[QualifiedName, RiskBlock]
    """The block computed for each function."""
    lines: Mapping[QualifiedName, int] = field(default_factory=dict)
    """The line of a function's `def`, needed where its name is defined twice."""
    shown_as: str | None = None
    """The path in messages; `None` for `file`."""
    original: bytes | None = None
    """The content of the file where `source` differs from it by renamed functions; else `None`."""
    instances: Mapping[QualifiedName, InstanceValues] = field(default_factory=dict)
    """How the units of each component fail, by function."""

    @property
    def name(self) -> str:
        """The name of the file in messages."""
        return self.file if self.shown_as is None else self.shown_as

    @property
    def before(self) -> bytes:
        """What the file holds."""
        return self.source if self.original is None else self.original


@dataclass(frozen=True, slots=True)
class AnnotatedSource:
    """A source whose bytes change."""

    file: str
    """The path from the lock's folder, with slashes."""
    before: bytes
    """The content of the file."""
    after: bytes
    """The content to write."""


@dataclass(frozen=True, slots=True)
class Unchanged:
    """Every block and the lock are as they would be written."""

    lock: Lock
    """The lock as it is."""


@dataclass(frozen=True, slots=True)
class Changed:
    """What is to be written."""

    sources: tuple[AnnotatedSource, ...]
    """The sources that change; empty where only the lock does."""
    lock: Lock
    """The lock once the sources are written."""
    pending: Lock
    """The lock while the sources are being written, which holds the old values too."""

    def writes(self, lock_path: Path) -> tuple[FileWrite, ...]:
        """Return the writes in the order in which a kill between them does no harm."""
        lock = FileWrite(lock_path, self.lock.dumps())
        if not self.sources:
            return (lock,)
        sources = (
            FileWrite(lock_path.parent / source.file, source.after, expected=source.before)
            for source in self.sources
        )
        return (FileWrite(lock_path, self.pending.dumps()), *sources, lock)


@dataclass(frozen=True, slots=True)
class EditsInTheWay:
    """A user edited computed values: nothing may be written."""

    edits: tuple[HandEdit, ...]
    """The edits for which nothing may be written."""

    def error(self) -> EditInTheWayError:
        """Return the error that names every edited field."""
        return edits_error(self.edits)


Annotation: TypeAlias = Unchanged | Changed | EditsInTheWay


@dataclass(frozen=True, slots=True)
class _MergedSource:
    blocks: Mapping[QualifiedName, RiskBlock | None]
    """The merged block of each function; `None` for one to remove."""
    edits: tuple[HandEdit, ...]
    """The edits of users that were found."""


def annotate_sources(
    controller: str,
    sources: Sequence[SourceBlocks],
    lock: Lock,
    *,
    fingerprint: str,
    trace: Mapping[str, Any],
    inputs: Mapping[str, Any] | None = None,
    policy: MergePolicy,
    evidence: SourceEvidence | None = None,
    behind: Behind | None = None,
) -> Annotation:
    """Return what becomes of a controller's sources and of the lock.

    `controller` is the path of the controller relative to the lock's folder. The block of a
    function for which nothing is computed any more is removed, unless a user set something in it.
    `evidence` takes the name of a file in `sources` and returns what git and the inputs of the last
    run say about who wrote it; without it the lock alone decides. `behind` is what the computed
    values rest on; without it no written value is kept for a computed one.

    Raises:
        BlockError, SourceError: if a source or a block in it cannot be read, or a redundancy is
            set by hand over units that differ.
        InputError: if a function to annotate is not defined in its source.
        UnsafeRewriteError: if a source cannot be rewritten safely.
    """
    entry = lock.controllers.get(controller)
    evidence = evidence or (lambda _: Evidence(is_fresh=entry is not None))
    behind = behind or Behind()
    shown = {source.file: source.name for source in sources}
    followed = followed_sources({source.file: source.source for source in sources}, entry, shown)
    sources = _with_free_ranks([_with_names(source, followed[source.file]) for source in sources])
    merge = partial(
        _merge_source,
        followed=followed,
        entry=entry,
        behind=behind,
        policy=policy,
        evidence=evidence,
    )
    merged = {source.file: merge(source) for source in sources}
    edits = _in_the_way(merged, policy)
    if not edits and policy.edits == "accept":
        # An edited rank is now the user's, like one that was set by hand before.
        sources = _with_free_ranks(sources, _by_function(merged))
        merged = {source.file: merge(source) for source in sources}
        edits = _in_the_way(merged, policy)
    if edits:
        return EditsInTheWay(edits)
    merged = _with_digests(_leftover_blocks_last(sources, merged))
    _check_values_by_hand(sources, merged)
    blocks = {file: source.blocks for file, source in merged.items()}
    changed = tuple(_annotated(sources, blocks))
    same = entry if is_same_run(entry, fingerprint, behind, policy) else None
    final = ControllerLock(
        fingerprint=fingerprint,
        blocks={
            file: written
            for file, by_function in blocks.items()
            # A module of which no block is left is looked at no more.
            if (written := _written(by_function)) or file == controller
        },
        trace=trace,
        inputs=inputs or {},
        behind=behind,
        kept=_kept(sources, merged, same, policy),
    )
    final = replace(final, owned=owned_values(blocks, entry, _earlier_refs(followed), final))
    pending = replace(
        final,
        previous={file: {} for file in merged} if entry is None else entry.blocks,
        others=() if entry is None else entry.all_blocks[1:],
    )
    new_lock = lock.with_controller(controller, final)
    if not changed and new_lock.dumps() == lock.dumps():
        return Unchanged(lock)
    return Changed(changed, new_lock, lock.with_controller(controller, pending))


def _annotated(
    sources: Sequence[SourceBlocks],
    blocks: Mapping[str, Mapping[QualifiedName, RiskBlock | None]],
) -> Iterator[AnnotatedSource]:
    """Yield the sources that the blocks change."""
    for source in sources:
        after = insert_blocks(source.source, blocks[source.file], source.name, source.lines)
        if after != source.before:
            yield AnnotatedSource(source.file, source.before, after)


def _check_values_by_hand(
    sources: Sequence[SourceBlocks], merged: Mapping[str, _MergedSource]
) -> None:
    """Raise BlockError where a value by hand names no function, or sums up units that differ."""
    names = model_names(_by_function(merged)).values()
    for source in merged.values():
        by_hand = (block for block in source.blocks.values() if block)
        check_targets((block for block in by_hand if is_next_by_hand(block, None)), names)
    for blocks in sources:
        for function, values in blocks.instances.items():
            block = merged[blocks.file].blocks.get(function)
            if block is not None:
                check_redundancies(block, values)


def _earlier_refs(followed: Mapping[str, FollowedSource]) -> dict[FunctionRef, FunctionRef]:
    """Return the earlier function of each that was renamed in its file."""
    return {
        FunctionRef(file, QualifiedName(new)): FunctionRef(file, QualifiedName(old))
        for file, one in followed.items()
        for new, old in one.names.own.items()
    }


def _kept(
    sources: Sequence[SourceBlocks],
    merged: Mapping[str, _MergedSource],
    same: ControllerLock | None,
    policy: MergePolicy,
) -> Kept:
    """Return what was computed where blocks keep another value; `same`: a lock of the same run."""
    kept = {}
    for source in sources:
        earlier = None if same is None else same.kept.get(source.file, {})
        blocks = merged[source.file].blocks
        kept[source.file] = kept_values(blocks, source.computed, earlier, policy.tolerance)
    return {file: values for file, values in kept.items() if values}


def _in_the_way(merged: Mapping[str, _MergedSource], policy: MergePolicy) -> tuple[HandEdit, ...]:
    return in_the_way((edit for one in merged.values() for edit in one.edits), policy)


def _with_names(source: SourceBlocks, followed: FollowedSource) -> SourceBlocks:
    if followed.source == source.source:
        return source
    return replace(source, source=followed.source, original=source.source)


def _by_function(merged: Mapping[str, _MergedSource]) -> dict[FunctionRef, RiskBlock]:
    return {
        FunctionRef(file, name): block
        for file, one in merged.items()
        for name, block in one.blocks.items()
        if block is not None
    }


def _with_free_ranks(
    sources: Sequence[SourceBlocks], found: Mapping[FunctionRef, RiskBlock] | None = None
) -> list[SourceBlocks]:
    """Move computed ranks out of the way of those that a user set in the blocks `found`.

    By default `found` are the blocks that stand in the sources.
    """
    if found is None:
        found = {
            FunctionRef(source.file, placed.function): placed.block
            for source in sources
            for placed in read_blocks(source.source, source.name)
        }
    by_hand = ranks_by_hand(found)
    computed = {
        FunctionRef(source.file, name): block
        for source in sources
        for name, block in source.computed.items()
    }
    free = give_way(computed, by_hand)
    return [
        replace(
            source,
            computed={name: free[FunctionRef(source.file, name)] for name in source.computed},
        )
        for source in sources
    ]


def _merge_source(
    source: SourceBlocks,
    followed: Mapping[str, FollowedSource],
    entry: ControllerLock | None,
    behind: Behind,
    policy: MergePolicy,
    evidence: SourceEvidence,
) -> _MergedSource:
    of_file = followed[source.file]
    current = {placed.function: placed.block for placed in of_file.placed}
    blocks: dict[QualifiedName, RiskBlock | None] = {}
    edits: list[HandEdit] = []
    for name in sorted({*current, *source.computed}):
        outcome = merge_with_bases(
            name,
            of_file.bases,
            current.get(name),
            source.computed.get(name),
            policy,
            lambda: evidence(source.file),
            of_file.names,
            steady_components(entry, behind, source.file, name, source.computed.get(name)),
        )
        blocks[name] = outcome.block
        edits += outcome.edits
    return _MergedSource(blocks, tuple(edits))


def _with_digests(merged: Mapping[str, _MergedSource]) -> dict[str, _MergedSource]:
    return {
        file: replace(
            one,
            blocks={
                name: None if block is None else with_digest(block)
                for name, block in one.blocks.items()
            },
        )
        for file, one in merged.items()
    }


def _leftover_blocks_last(
    sources: Sequence[SourceBlocks], merged: Mapping[str, _MergedSource]
) -> dict[str, _MergedSource]:
    """Rank the blocks that remain only because of a manual edit after those of the run.

    Nothing is computed for them, so what the tool once wrote may contradict the run's blocks:
    their rank may be another's by now, and their `next` may name a function without a block.
    """
    computed = {source.file: source.computed for source in sources}
    by_function = _by_function(merged)
    placed = [(ref.file, ref.name, block) for ref, block in by_function.items()]
    leftover = [
        row
        for row in placed
        if row[1] not in computed[row[0]] and not row[2].added and not row[2].call_sequence.pinned
    ]
    names = {*model_names(by_function).values(), DONE}
    ranks = [row[2].call_sequence.value for row in placed if row not in leftover]
    result = dict(merged)
    leftover.sort(key=lambda row: (row[2].call_sequence.value, row[0], row[1]))
    for rank, (file, name, block) in enumerate(leftover, start=max(ranks, default=0) + 1):
        following = block.next
        if following is not None and not following.pinned:
            leads_on = all(transition.target in names for transition in following.value)
            following = following if leads_on else None
        moved = replace(block, call_sequence=computed_count(rank), next=following)
        result[file] = replace(result[file], blocks={**result[file].blocks, name: moved})
    return result


def _written(blocks: Mapping[QualifiedName, RiskBlock | None]) -> dict[str, WrittenBlock]:
    written = {
        name: None if block is None else written_block(block) for name, block in blocks.items()
    }
    return {name: block for name, block in written.items() if block is not None}
