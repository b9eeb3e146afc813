"""A redundancy set by hand, over units that are alike and over such that are not."""

import pytest

from tracerisk.adder.annotate import Changed, SourceBlocks, Unchanged, annotate_sources
from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.figures.instance_values import kept_values
from tracerisk.adder.lock.lock import Lock
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.common.hardware.redundancy import ALL_NEEDED
from tracerisk.errors import BlockError

SOURCE = b"def place():\n    release()\n"
UNLIKE = {"motor": {"joint1": 1.2e-9, "joint2": 3.4e-8}}


def computed_block() -> RiskBlock:
    motor = ComponentEntry(
        "motor", computed_probability(2e-8), computed_count(2), computed_redundancy(ALL_NEEDED)
    )
    return RiskBlock("place", computed_count(1), computed_next({"done": 1}), (motor,))


def annotated(source, lock=Lock(), instances=UNLIKE, policy=MergePolicy()):  # noqa: B008
    blocks = SourceBlocks(
        "place.py", source, {"place": computed_block()}, instances={"place": instances}
    )
    outcome = annotate_sources("place.py", [blocks], lock, fingerprint="1", trace={}, policy=policy)
    assert isinstance(outcome, Changed | Unchanged)
    changed = outcome.sources if isinstance(outcome, Changed) else ()
    return changed[0].after if changed else source, outcome.lock


def by_hand(source, before, after):
    assert before in source
    return source.replace(before, after, 1)


PINNED = (b"redundancy = false", b"redundancy := true  ! computed false; two drives")


def test_a_redundancy_over_units_that_differ_is_an_error_that_says_what_to_do():
    source, lock = annotated(SOURCE)
    with pytest.raises(BlockError) as caught:
        annotated(by_hand(source, *PINNED), lock)
    assert str(caught.value) == (
        "place.py:12: function 'place', component 'motor': 'redundancy := true' is set for "
        "units that differ (joint2 3.4e-08, joint1 1.2e-09 per visit); the block's probability "
        "holds only with 'redundancy = false'; state the redundancy in the hardware "
        "description, or set the probability of a unit by hand too (probability := ...)"
    )


def test_an_accepted_edit_is_no_way_around_it():
    source, lock = annotated(SOURCE)
    edited = by_hand(source, b"redundancy = false", b"redundancy = true")
    with pytest.raises(BlockError, match="is set for units that differ"):
        annotated(edited, lock, policy=MergePolicy(edits="accept"))


def test_with_the_probability_by_hand_too_it_stays():
    source, lock = annotated(SOURCE)
    source = by_hand(source, *PINNED)
    source = by_hand(source, b"probability = 2e-08", b"probability := 3e-08  ! computed 2e-08; b")
    assert b"redundancy := true" in annotated(source, lock)[0]


@pytest.mark.parametrize(
    "instances",
    [{}, {"motor": {}}, {"motor": {"joint1": 1e-9, "joint2": 1.009e-9}}, {"gripper": {"g": 1.0}}],
)
def test_over_units_that_are_alike_it_stays(instances):
    source, lock = annotated(SOURCE)
    assert b"redundancy := true" in annotated(by_hand(source, *PINNED), lock, instances)[0]


def test_the_redundancy_of_the_description_stays():
    source, lock = annotated(SOURCE)
    same = by_hand(
        source, b"redundancy = false", b"redundancy := false  ! computed false; so be it"
    )
    assert b"redundancy := false" in annotated(same, lock)[0]


def test_more_units_than_a_line_holds_are_counted():
    source, lock = annotated(SOURCE)
    many = {"motor": {f"joint{number}": number * 1e-9 for number in range(1, 13)}}
    with pytest.raises(
        BlockError, match=r"\(joint12 1.2e-08, .*, joint5 5e-09, and 4 more per visit"
    ):
        annotated(by_hand(source, *PINNED), lock, many)


@pytest.mark.parametrize(
    "summary",
    [
        {},
        {"functions": []},
        {"functions": {"place": 3}},
        {"functions": {"place": {"instances": {"motor": 1}}}},
        {"functions": {"place": {"instances": {"motor": {"joint1": "1e-9"}}}}},
    ],
)
def test_a_lock_edited_by_hand_says_no_instances(summary):
    assert not any(kept_values(summary, "place").values())
