from dataclasses import replace
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.adder.blocks.random_blocks import blocks
from tracerisk.adder.blocks.block import Transition
from tracerisk.adder.blocks.grammar import parse_block, print_block
from tracerisk.adder.blocks.lines import BlockLine
from tracerisk.adder.blocks.values import profile_next
from tracerisk.adder.lock.digest import with_digest
from tracerisk.adder.lock.lock import WrittenBlock, as_written, written_block
from tracerisk.adder.merge.authors import Evidence
from tracerisk.adder.merge.edits_found import MergePolicy, edits_error, in_the_way
from tracerisk.adder.merge.merge import merge
from tracerisk.errors import EditInTheWayError

STOP = MergePolicy()
ACCEPT = MergePolicy("accept")
DISCARD = MergePolicy("discard")
FRESH = MergePolicy(fresh=True)

WRITTEN, EDITED, DRIFTED, NEAR = 7.344e-08, 2e-07, 9.9e-08, 7.37e-08


def block(probability: str = "= 7.344e-08", extra: str = "", following: str = "= done 1") -> str:
    return f"""
        RiskAnnotation
        @Function {{
          name = place
          callSequence = 5
          next {following}
        }}
        @Component {{
          name = gripper
          probability {probability}
          quantity = 1
          redundancy = false
        }}{extra}
        """


MOTOR = """
        @Component {
          name = motor
          probability = 9.5e-08
          quantity = 7
          redundancy = false
        }"""
MOTOR_ADDED = MOTOR.replace("@Component {", "@Component := {  ! it holds the hose")
MOTOR_OMITTED = MOTOR.replace("@Component {", "@Component := omit {  ! it hangs free")
PINNED = ":= 2e-07  ! computed 7.344e-08; FMEA-112"
PINNED_DRIFTED = ":= 2e-07  ! computed 9.9e-08; FMEA-112"
PINNED_BY_EDIT = ":= 2e-07  ! computed 7.344e-08"
PINNED_BY_EDIT_DRIFTED = ":= 2e-07  ! computed 9.9e-08"
TOOL, TOOL_DRIFTED = "= 7.344e-08", "= 9.9e-08"
EDIT = "= 2e-07"

# What the lock says was written (None: no lock), what stands in the file, what is computed
# now, and what becomes of it under the three policies; None: it stops.
TABLE = {
    "unchanged": (WRITTEN, TOOL, WRITTEN, TOOL, TOOL, TOOL),
    "changed by the tool": (WRITTEN, TOOL, DRIFTED, TOOL_DRIFTED, TOOL_DRIFTED, TOOL_DRIFTED),
    "changed within the noise": (WRITTEN, TOOL, NEAR, TOOL, TOOL, TOOL),
    "changed by a person": (WRITTEN, EDIT, WRITTEN, None, PINNED_BY_EDIT, TOOL),
    "changed by both": (WRITTEN, EDIT, DRIFTED, None, PINNED_BY_EDIT_DRIFTED, TOOL_DRIFTED),
    "changed by both alike": (WRITTEN, EDIT, EDITED, EDIT, EDIT, EDIT),
    "written in other digits": (WRITTEN, "= 0.7344E-7", WRITTEN, TOOL, TOOL, TOOL),
    "pinned": (WRITTEN, PINNED, WRITTEN, PINNED, PINNED, PINNED),
    "pinned and drifted": (
        WRITTEN,
        PINNED,
        DRIFTED,
        PINNED_DRIFTED,
        PINNED_DRIFTED,
        PINNED_DRIFTED,
    ),
    "pinned and within the noise": (WRITTEN, PINNED, NEAR, PINNED, PINNED, PINNED),
    "pinned anew": (WRITTEN, ":= 2e-07", WRITTEN) + (PINNED_BY_EDIT,) * 3,
    "pin taken back": (WRITTEN, TOOL, WRITTEN, TOOL, TOOL, TOOL),
    "no lock and the same": (None, TOOL, WRITTEN, TOOL, TOOL, TOOL),
    "no lock and another value": (None, EDIT, WRITTEN, None, PINNED_BY_EDIT, TOOL),
    "no lock and pinned": (None, PINNED, DRIFTED, PINNED_DRIFTED, PINNED_DRIFTED, PINNED_DRIFTED),
    "lock from another branch": (1e-09, EDIT, DRIFTED, None, PINNED_BY_EDIT_DRIFTED, TOOL_DRIFTED),
    "lock from another branch, same value": (1e-09, TOOL_DRIFTED, DRIFTED) + (TOOL_DRIFTED,) * 3,
}


def merge_block(base, current, computed, *, policy, steady=("gripper",)):
    """Return the block to write, or raise as every writer of blocks does."""
    merged = merge(base, current, computed, policy=policy, steady=steady)
    if in_the_way(merged.edits, policy):
        raise edits_error(merged.edits)
    return merged.block


@pytest.mark.parametrize("case", sorted(TABLE))
def test_a_probability_becomes_what_the_table_promises(case: str, make_block, read_block) -> None:
    written, found, now, *promised = TABLE[case]
    base = None if written is None else written_block(make_block(gripper=written))
    current, computed = read_block(block(found)), make_block(gripper=now)
    for policy, text in zip((STOP, ACCEPT, DISCARD), promised, strict=True):
        if text is None:
            with pytest.raises(EditInTheWayError, match=r"place\.gripper\.probability"):
                merge_block(base, current, computed, policy=policy)
            continue
        merged = merge_block(base, current, computed, policy=policy)
        assert merged == read_block(block(text))
        again = merge(written_block(merged), merged, computed, policy=STOP, steady=("gripper",))
        assert again.block == merged
        assert again.edits == ()


def test_fresh_writes_changes_within_the_noise(make_block, read_block) -> None:
    base = written_block(make_block(gripper=WRITTEN))
    merged = merge_block(base, read_block(block()), make_block(gripper=NEAR), policy=FRESH)
    assert merged == read_block(block("= 7.37e-08"))


@pytest.mark.parametrize(
    ("policy", "steady"),
    [(MergePolicy(tolerance=0.0), ("gripper",)), (STOP, ()), (STOP, ("motor",))],
)
def test_no_change_is_noise_without_a_tolerance_or_where_what_is_behind_it_changed(
    policy, steady, make_block, read_block
) -> None:
    base = written_block(make_block(gripper=WRITTEN))
    computed = make_block(gripper=NEAR)
    merged = merge_block(base, read_block(block()), computed, policy=policy, steady=steady)
    assert merged == read_block(block("= 7.37e-08"))


def test_noise_does_not_add_up_over_runs(make_block) -> None:
    current = make_block(gripper=1e-07)
    texts = []
    for value in (1.004e-07, 1.008e-07, 1.012e-07, 1.004e-07):
        current = merge_block(
            written_block(current), current, make_block(gripper=value), policy=STOP
        )
        texts.append(current.components[0].probability.text)
    assert texts == ["1e-07", "1.008e-07", "1.008e-07", "1.008e-07"]


@given(a=blocks(), b=blocks(), c=blocks(), edits=st.sampled_from(["stop", "accept", "discard"]))
def test_the_merge_of_either_form_is_the_same(a, b, c, edits) -> None:
    """What was written, what stands there and what is computed may be any blocks at all."""
    policy = MergePolicy(edits)
    base = written_block(a)
    current = with_digest(replace(b, digest=None))
    computed = as_written(b.name, written_block(replace(c, added=False)) or WrittenBlock({}, {}))
    outcomes = []
    for form in ("published", "compact"):
        lines = print_block(replace(current, form=form))
        rows = [BlockLine(n, line.partition("|")[2]) for n, line in enumerate(lines, start=1)]
        merged = merge(base, parse_block(rows, "c.py"), computed, policy=policy)
        edited = [replace(edit, location=None) for edit in merged.edits]
        outcomes.append((merged.block, edited))
        if merged.block is not None:
            assert merged.block.form == form
    assert outcomes[0] == outcomes[1]


# The components: what was written, what stands there, what is computed, what becomes of them.
BOTH = {"gripper": WRITTEN, "motor": 9.5e-08}
ONE = {"gripper": WRITTEN}
SEVEN = "quantity = 7"
MOTOR_OF_ONE = MOTOR.replace(SEVEN, "quantity = 1")
COMPONENTS = {
    "new": (ONE, "", BOTH, MOTOR_OF_ONE, MOTOR_OF_ONE, MOTOR_OF_ONE),
    "gone": (BOTH, MOTOR_OF_ONE, ONE, "", "", ""),
    "added by a person": (ONE, MOTOR_ADDED, ONE) + (MOTOR_ADDED,) * 3,
    "added by a person and computed since": (ONE, MOTOR_ADDED, BOTH) + (MOTOR_ADDED,) * 3,
    "added without a word": (ONE, MOTOR, ONE, None, MOTOR.replace("t {", "t := {"), ""),
    "omitted by a person": (BOTH, MOTOR_OMITTED.replace(SEVEN, "quantity = 1"), BOTH)
    + (MOTOR_OMITTED.replace(SEVEN, "quantity = 1"),) * 3,
    "omitted in short": (
        BOTH,
        "\n@Component := omit {\n name = motor\n}",
        BOTH,
        *(MOTOR_OF_ONE.replace("t {", "t := omit {"),) * 3,
    ),
    "omitted and not computed any more": (BOTH, MOTOR_OMITTED, ONE) + (MOTOR_OMITTED,) * 3,
    "taken out without a word": (
        BOTH,
        "",
        BOTH,
        None,
        MOTOR_OF_ONE.replace("t {", "t := omit {"),
        MOTOR_OF_ONE,
    ),
    "taken out with no lock": (
        None,
        "",
        BOTH,
        None,
        MOTOR_OF_ONE.replace("t {", "t := omit {"),
        MOTOR_OF_ONE,
    ),
    "with a pin and not computed any more": (
        BOTH,
        MOTOR_OF_ONE.replace("= 9.5e-08", ":= 1e-06  ! computed 9.5e-08; old"),
        ONE,
        *(MOTOR_OF_ONE.replace("= 9.5e-08", ":= 1e-06  ! computed none; old"),) * 3,
    ),
    "edited and not computed any more": (
        BOTH,
        MOTOR_OF_ONE.replace("9.5e-08", "1e-06"),
        ONE,
        None,
        MOTOR_OF_ONE.replace("= 9.5e-08", ":= 1e-06  ! computed none"),
        "",
    ),
}


@pytest.mark.parametrize("case", sorted(COMPONENTS))
def test_a_component_becomes_what_the_table_promises(case: str, make_block, read_block) -> None:
    written, found, now, *promised = COMPONENTS[case]
    base = None if written is None else written_block(make_block(**written))
    current, computed = read_block(block(extra=found)), make_block(**now)
    for policy, text in zip((STOP, ACCEPT, DISCARD), promised, strict=True):
        if text is None:
            with pytest.raises(EditInTheWayError, match=r"place\.motor"):
                merge_block(base, current, computed, policy=policy)
            continue
        merged = merge_block(base, current, computed, policy=policy)
        assert merged == read_block(block(extra=text))
        assert merge(written_block(merged), merged, computed, policy=STOP).block == merged


def test_an_omission_taken_back_gives_the_component_again(make_block, read_block) -> None:
    computed = make_block(**BOTH)
    omitted = read_block(block(extra=MOTOR_OMITTED.replace(SEVEN, "quantity = 1")))
    base = written_block(omitted)
    merged = merge(base, read_block(block()), computed, policy=STOP)
    assert merged.block == computed
    assert merged.edits == ()


def test_components_keep_the_order_computed_and_a_persons_own_follow(
    make_block, read_block
) -> None:
    added = MOTOR_ADDED.replace("name = motor", "name = axle")
    current = read_block(block(extra=added + MOTOR_ADDED))
    merged = merge_block(None, current, make_block(wrist=1e-8, gripper=WRITTEN), policy=ACCEPT)
    assert [c.name for c in merged.components] == ["wrist", "gripper", "axle", "motor"]


def test_next_is_pinned_and_compared_as_one_value(make_block, read_block) -> None:
    computed = make_block(following={"init": 9, "done": 1})
    base = written_block(computed)
    swapped = read_block(block(following="= done 1/10\n next = init 9/10"))
    assert merge_block(base, swapped, computed, policy=STOP) == computed
    edited = read_block(block(following="= done 1/5\n next = init 4/5"))
    merged = merge(base, edited, computed, policy=ACCEPT)
    assert [edit.field for edit in merged.edits] == ["place.next"]
    assert "# |   next := done 1/5" in print_block(merged.block)
    assert "# |   next := init 4/5  ! computed init 9/10, done 1/10" in print_block(merged.block)


def test_a_profile_pins_next_and_keeps_the_count_of_the_run_beside_it(
    make_block, read_block
) -> None:
    counted = make_block(following={"init": 9, "done": 1})
    profile = profile_next({"init": "0.8", "done": "0.2"}, computed=counted.next.text)
    merged = merge_block(
        written_block(counted), counted, replace(counted, next=profile), policy=STOP
    )
    assert merged.next.pinned
    assert merged.next.value[0] == Transition("init", Fraction(4, 5))
    assert merged.next.computed == "init 9/10, done 1/10"
    assert merge_block(written_block(merged), merged, counted, policy=STOP) == merged


def test_next_lines_that_are_not_computed_go_unless_a_person_wrote_them(
    make_block, read_block
) -> None:
    computed = replace(make_block(), next=None)
    assert merge_block(written_block(make_block()), make_block(), computed, policy=STOP) == computed
    with pytest.raises(EditInTheWayError, match=r"place\.next is done 1 \(last written unknown"):
        merge_block(None, make_block(), computed, policy=STOP)
    kept = merge_block(None, make_block(), computed, policy=ACCEPT)
    assert kept.next.pinned
    assert merge_block(None, make_block(), computed, policy=DISCARD).next is None


def test_a_block_without_next_is_completed(make_block) -> None:
    current = replace(make_block(), next=None)
    assert merge_block(None, current, make_block(), policy=STOP) == make_block()


def test_a_block_of_a_function_no_longer_relevant_goes(make_block) -> None:
    base = written_block(make_block())
    assert merge_block(base, make_block(), None, policy=STOP) is None


def test_a_block_with_a_pin_stays_whole_when_its_function_is_not_relevant(
    make_block, read_block
) -> None:
    base = written_block(make_block(**BOTH))
    current = read_block(block(PINNED, extra=MOTOR_OF_ONE))
    merged = merge_block(base, current, None, policy=STOP)
    none = ":= 2e-07  ! computed none; FMEA-112"
    assert merged == read_block(block(none, extra=MOTOR_OF_ONE))
    assert merge_block(written_block(merged), merged, None, policy=STOP) == merged


def test_a_block_that_neither_lock_nor_tool_knows_is_a_persons(make_block) -> None:
    with pytest.raises(EditInTheWayError, match="place was added"):
        merge_block(None, make_block(), None, policy=STOP)
    assert merge_block(None, make_block(), None, policy=ACCEPT) == replace(make_block(), added=True)
    assert merge_block(None, make_block(), None, policy=DISCARD) is None


def test_an_edited_block_of_a_function_no_longer_relevant_is_not_lost(
    make_block, read_block
) -> None:
    base = written_block(make_block())
    current = read_block(block(EDIT))
    with pytest.raises(EditInTheWayError, match="computed none"):
        merge_block(base, current, None, policy=STOP)
    assert merge_block(base, current, None, policy=DISCARD) is None
    merged = merge_block(base, current, None, policy=ACCEPT)
    assert merged == read_block(block(":= 2e-07  ! computed none"))


def test_a_block_given_by_hand_keeps_every_value(make_block, read_block) -> None:
    by_hand = replace(read_block(block(PINNED, extra=MOTOR)), added=True)
    merged = merge_block(None, by_hand, make_block(gripper=DRIFTED), policy=STOP)
    assert merged == replace(read_block(block(PINNED_DRIFTED, extra=MOTOR)), added=True)
    assert written_block(merged) is None


def test_the_error_names_every_field_with_file_and_line(make_block, read_block) -> None:
    current = read_block(
        block(EDIT)
        .replace("quantity = 1", "quantity = 2")
        .replace("callSequence = 5", "callSequence = 4")
    )
    with pytest.raises(EditInTheWayError) as caught:
        merge_block(written_block(make_block()), current, make_block(), policy=STOP)
    assert str(caught.value) == (
        "a user changed what tracerisk computes; nothing was written:\n"
        "  c.py:4: place.callSequence is 4 (last written 5, computed 5)\n"
        "  c.py:9: place.gripper.probability is 2e-07 (last written 7.344e-08, "
        "computed 7.344e-08)\n"
        "  c.py:10: place.gripper.quantity is 2 (last written 1, computed 1)\n"
        "Write `:=` for `=` (in the compact form before the value) to keep a value, or use "
        "--accept-edits to keep them all, "
        "--discard-edits to drop them all."
    )


# What a merge brings into a block from another function, or from a branch whose digest is lost.
CAMERA_MOVED = MOTOR.replace("motor", "camera").replace("= 9.5e-08", ":= 1e-05  ! computed 8e-08")
MOTOR_MOVED = MOTOR.replace("= 9.5e-08", ":= 1e-05  ! why")
MOTOR_OF_BRANCH = MOTOR.replace("= 9.5e-08", ":= 1e-05  ! computed 8e-08").replace("= 7", "= 8")


@pytest.mark.parametrize(
    ("last", "found", "now", "edit"),
    [
        (MOTOR, CAMERA_MOVED, MOTOR, "place.motor"),
        ("", MOTOR_MOVED, MOTOR.replace("= 7", "= 8"), "place.motor.quantity"),
        (MOTOR, MOTOR_OF_BRANCH, MOTOR, "place.motor.quantity"),
    ],
    ids=["removed", "changed", "of a branch"],
)
def test_lines_that_a_merge_moved_into_a_block_are_no_persons(
    last: str, found: str, now: str, edit: str, read_block
) -> None:
    written = with_digest(read_block(block(TOOL, last)))
    current = replace(read_block(block(TOOL, found)), digest=written.digest)
    base, elsewhere = written_block(written), written_block(read_block(block(TOOL, MOTOR)))
    assert base is not None
    assert elsewhere is not None
    kept = {"place": [base], "home": [elsewhere]}
    evidence = Evidence(
        is_complete=True, written=kept, standing={}, versions=[frozenset({"place", "home"})]
    )
    computed = read_block(block(TOOL, now))
    merged = merge(base, current, computed, policy=STOP, evidence=lambda: evidence)
    assert [(one.field, one.is_certain) for one in merged.edits if one.field == edit] == [
        (edit, False)
    ]
