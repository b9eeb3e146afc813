"""Merge the block of one function with what was last written, without writing anything."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.lock.lock import Written
from tracerisk.common.function_ref import QualifiedName

if TYPE_CHECKING:
    from tracerisk.adder.merge.authors import Evidence
    from tracerisk.adder.merge.edits_found import MergePolicy
    from tracerisk.adder.merge.merge import Merged

SourceEvidence: TypeAlias = "Callable[[str], Evidence]"
"""What is known of a source beyond its blocks and the lock, by the name of its file."""


class EarlierNames(NamedTuple):
    """What functions were called when their blocks were written."""

    own: Mapping[str, str] = {}
    """The earlier name of each renamed function of one file, by the name that it has now."""
    following: Mapping[str, str] = {}
    """The earlier name of a function in what follows another, by the name that it has there now."""


NO_EARLIER_NAMES = EarlierNames()
"""Where no function was renamed."""


def merge_with_bases(
    name: QualifiedName,
    bases: Sequence[Written],
    current: RiskBlock | None,
    computed: RiskBlock | None,
    policy: MergePolicy,
    evidence: Callable[[], Evidence],
    names: EarlierNames,
    steady: Collection[str] = (),
) -> Merged:
    """Merge the block of one function; `bases` are those of its file, under the current names."""
    from tracerisk.adder.merge.merge import merge

    base, *others = [written.get(name) for written in bases]
    return merge(
        base,
        current,
        computed,
        policy=policy,
        others=[other for other in others if other is not None and other != base],
        evidence=evidence,
        names=names,
        steady=steady,
    )
