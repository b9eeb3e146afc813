"""Merge the block of one function with what was last written, without writing anything."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, TypeAlias

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.lock.lock import ControllerLock, WrittenBlock
from tracerisk.common.function_ref import QualifiedName

if TYPE_CHECKING:
    from tracerisk.adder.merge.authors import Evidence
    from tracerisk.adder.merge.merge import Merged, MergePolicy

SourceEvidence: TypeAlias = "Callable[[str], Evidence]"
"""What is known of a source beyond its blocks and the lock, by the name of its file."""


def bases_of(file: str, entry: ControllerLock | None) -> list[Mapping[str, WrittenBlock]]:
    """Return what was last written into a source, then all else that it may hold.

    That is what it held before a write that was cut short, and what other branches had written.
    """
    if entry is None:
        return [{}]
    return [blocks.get(file, {}) for blocks in entry.all_blocks]


def merge_with_bases(
    name: QualifiedName,
    bases: Sequence[Mapping[str, WrittenBlock]],
    current: RiskBlock | None,
    computed: RiskBlock | None,
    policy: MergePolicy,
    evidence: Callable[[], Evidence],
    renamed: Mapping[QualifiedName, QualifiedName],
    steady: Collection[str] = (),
) -> Merged:
    """Merge the block of one function; `bases` are those of its file, under the current names."""
    from tracerisk.adder.merge.merge import merge

    base, *others = [fields.get(name) for fields in bases]
    return merge(
        base,
        current,
        computed,
        policy=policy,
        others=[other for other in others if other is not None and other != base],
        evidence=evidence,
        names={str(new): str(old) for old, new in renamed.items()},
        steady=steady,
    )
