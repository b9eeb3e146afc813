"""What manual edits in the blocks of one controller ask of its other blocks.

A rank set by hand stays, so the computed ones give way to it; a `next` set by hand has to lead to
a function that there is.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.values import DONE, NEXT, computed_count
from tracerisk.adder.lock.lock import Written
from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import BlockError, one_of

Blocks = Mapping[FunctionRef, RiskBlock]


def ranks_by_hand(blocks: Blocks) -> dict[FunctionRef, Field[int]]:
    """Return the `callSequence` of each block in which a user set it.

    Raises:
        BlockError: if two are the same, with both places.
    """
    ranks: dict[FunctionRef, Field[int]] = {}
    for ref, block in blocks.items():
        if not (block.added or block.call_sequence.pinned):
            continue
        for other, rank in ranks.items():
            if rank.value == block.call_sequence.value:
                place = "" if rank.location is None else f" ({rank.location})"
                raise BlockError(
                    f"callSequence {rank.value} is set by hand for {ref.name}, and for "
                    f"{other.name} too{place}; give each function its own",
                    block.call_sequence.location or block.location,
                )
        ranks[ref] = block.call_sequence
    return ranks


def give_way(computed: Blocks, by_hand: Mapping[FunctionRef, Field[int]]) -> Blocks:
    """Return the computed blocks with ranks that no user took, in their order.

    A block whose own rank is set by hand keeps its computed rank, which is written beside the
    user's.
    """
    taken = {rank.value for rank in by_hand.values()}
    free = sorted(
        (ref for ref in computed if ref not in by_hand),
        key=lambda ref: computed[ref].call_sequence.value,
    )
    moved = dict(computed)
    last = 0
    for ref in free:
        rank = max(last + 1, computed[ref].call_sequence.value)
        while rank in taken:
            rank += 1
        if rank != computed[ref].call_sequence.value:
            moved[ref] = replace(computed[ref], call_sequence=computed_count(rank))
        last = rank
    return moved


def check_targets(blocks: Iterable[RiskBlock], names: Collection[str]) -> None:
    """Refuse a `next` that leads to no function; `names` are those of the model.

    Raises:
        BlockError: with the place of the `next`, and the names that are allowed.
    """
    for block in blocks:
        for transition in block.next.value if block.next is not None else ():
            if transition.target != DONE and transition.target not in names:
                place = block.next.location if block.next is not None else None
                raise BlockError(
                    f"next of `{block.name}` leads to '{transition.target}', not a function "
                    f"with a risk block; {one_of({*names, DONE}, transition.target)}",
                    place or block.location,
                )


def is_next_by_hand(block: RiskBlock, base: Written | None) -> bool:
    """Return whether a user changed the `next` of a block since it was last written.

    If the tool's own `next` leads to a function that has since been removed, the next run repairs
    it. Without a `base`, what is not pinned is taken for the tool's.
    """
    if block.next is None:
        return False
    if block.added or block.next.pinned or base is None:
        return block.added or block.next.pinned
    written = base.get(block.name)
    if written is None or NEXT.key not in written.values:
        return True
    return not NEXT.same(block.next.value, NEXT.read(written.values[NEXT.key]))
