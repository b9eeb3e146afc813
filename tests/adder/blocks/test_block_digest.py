"""The digest on a block's first line: which values it vouches for, and which it does not."""

from dataclasses import replace

import pytest

from tracerisk.adder.blocks.grammar import print_block
from tracerisk.adder.blocks.values import NEXT, PROBABILITY, QUANTITY, computed_next
from tracerisk.adder.lock.digest import DigestReading, digest_of, is_as_written, with_digest
from tracerisk.adder.lock.lock import WrittenBlock, written_block
from tracerisk.adder.merge.authors import Evidence
from tracerisk.adder.merge.bases import EarlierNames
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.merge import merge
from tracerisk.adder.sources.insert import insert_blocks
from tracerisk.adder.sources.read import read_blocks

STOP, ACCEPT, DISCARD = MergePolicy(), MergePolicy("accept"), MergePolicy("discard")
SOURCE = b"def place():\n    go()\n"
NEXT_HALF = "next = place 1/2\n    # |   next = done 1/2\n"
COMPONENT = """\
    # | @Component {{
    # |   name = {}
    # |   probability = {}
    # |   quantity = 1
    # |   redundancy = false
    # | }}
"""
GRIPPER, HOSE = COMPONENT.format("gripper", "7.344e-08"), COMPONENT.format("hose", "6.543e-08")


def file_with(block) -> bytes:
    return insert_blocks(SOURCE, {"place": block}, "c.py")


def read(source: bytes):
    (placed,) = read_blocks(source, "c.py")
    return placed.block


def changed(block, before: str, after: str):
    """Return a block with other text in it, as a person or a merge leaves it."""
    text = file_with(block).decode()
    assert before in text
    return read(text.replace(before, after).encode())


@pytest.fixture
def block(make_block):
    return with_digest(make_block(gripper=7.344e-08, motor=9.5e-08))


def test_the_digest_stands_on_the_first_line_and_is_read_back(block) -> None:
    first, *others = print_block(block)
    assert first == f"# | RiskAnnotation {block.digest}"
    assert read(file_with(block)).digest == block.digest
    assert others == list(print_block(replace(block, digest=None)))[1:]


def test_the_digest_depends_on_what_is_said_and_not_on_how(block, make_block) -> None:
    written = written_block(block)
    assert written is not None
    other_order = WrittenBlock(written.values, dict(reversed(list(written.components.items()))))
    assert digest_of(other_order) == block.digest
    assert changed(block, "7.344e-08", "0.7344E-7").digest == block.digest
    assert with_digest(make_block(gripper=7.345e-08, motor=9.5e-08)).digest != block.digest


def test_it_vouches_for_each_value_by_itself(block) -> None:
    edited = changed(block, "7.344e-08", "2e-07")
    reading = DigestReading(edited)
    assert reading.is_there
    assert not reading.vouches("gripper", PROBABILITY, 2e-07)
    assert reading.vouches("gripper", PROBABILITY, 7.344e-08)
    assert reading.vouches("motor", PROBABILITY, 9.5e-08)
    assert not reading.vouches("motor", PROBABILITY, 7.344e-08)
    assert reading.vouches("gripper", QUANTITY, 1)
    assert reading.vouches(None, NEXT, block.next.value)
    assert reading.has_component("motor")
    assert not reading.has_component("hose")


def test_a_value_that_fits_by_chance_alone_is_not_believed(block) -> None:
    # Of the 62 checksums of a quantity one fits this one, and the whole does not.
    for quantity in range(2, 2000):
        edited = changed(block, "quantity = 1\n", f"quantity = {quantity}\n")
        groups = digest_of(written_block(edited)).split("-")
        if sorted(groups[1:]) == sorted(block.digest.split("-")[1:]):
            break
    else:
        pytest.fail("no quantity has the same checksum")
    assert not DigestReading(edited).is_there


def test_without_a_lock_what_the_tool_wrote_is_refreshed(block, make_block) -> None:
    now = make_block(gripper=1e-07, motor=2e-07)
    merged = merge(None, read(file_with(block)), now, policy=STOP, evidence=unasked)
    assert merged.edits == ()
    assert merged.block == now


def unasked() -> Evidence:
    raise AssertionError("nothing is to be asked where the digest knows")


def test_a_new_pin_without_a_lock_leaves_the_other_values_the_tools(block, make_block) -> None:
    pinned = changed(block, "= 7.344e-08", ":= 2e-07  ! why")
    now = make_block(gripper=1e-07, motor=2e-07)
    merged = merge(None, pinned, now, policy=STOP, evidence=unasked)
    assert merged.edits == ()
    assert merged.block is not None
    gripper, motor = merged.block.components
    assert (gripper.probability.text, gripper.probability.computed) == ("2e-07", "1e-07")
    assert motor.probability.text == "2e-07"


UNCLEAR = Evidence(is_fresh=False)


@pytest.mark.parametrize("policy", [STOP, ACCEPT])
def test_what_nobody_can_say_the_author_of_is_left_alone_without_advice_to_pin_it(
    block, make_block, policy
) -> None:
    from tracerisk.adder.merge.edits_found import edits_error, in_the_way

    mixed = changed(block, "= 7.344e-08", "= 3.333e-08")
    now = make_block(gripper=1e-07, motor=2e-07)
    merged = merge(written_block(block), mixed, now, policy=policy, evidence=lambda: UNCLEAR)
    (edit,) = in_the_way(merged.edits, policy)
    assert (edit.field, edit.is_certain) == ("place.gripper.probability", False)
    text = str(edits_error([edit]))
    assert "it is unknown who wrote these values" in text
    assert "c.py:10: place.gripper.probability is 3.333e-08" in text
    assert ":=" not in text
    assert "--accept-edits" not in text
    assert "a user changed" not in text


def test_what_nobody_can_say_the_author_of_may_be_dropped(block, make_block) -> None:
    mixed = changed(block, "= 7.344e-08", "= 3.333e-08")
    now = make_block(gripper=1e-07, motor=2e-07)
    merged = merge(None, mixed, now, policy=DISCARD, evidence=lambda: UNCLEAR)
    assert merged.block == now


def with_value(block, text: str) -> WrittenBlock:
    written = written_block(changed(block, "= 7.344e-08", f"= {text}"))
    assert written is not None
    return written


# What git keeps, what stands there, and who wrote it.
FOUND = {
    "written on another branch": ("probability", "3.333e-08", "tool"),
    "never written anywhere": ("probability", "4.444e-08", "user"),
    "committed, and the tool's on no branch that is left": ("probability", "5.555e-08", "unknown"),
    "a small number that was written once": ("quantity", "2", "unknown"),
}


@pytest.mark.parametrize("case", FOUND)
def test_git_says_who_wrote_what_neither_digest_nor_lock_knows(
    case: str, block, make_block
) -> None:
    key, text, author = FOUND[case]
    two = written_block(changed(block, "quantity = 1\n", "quantity = 2\n"))
    assert two is not None
    kept = Evidence(
        is_fresh=False,
        is_complete=True,
        written={"place": [with_value(block, "3.333e-08"), two]},
        standing={"place": [changed(block, "= 7.344e-08", "= 5.555e-08")]},
    )
    before = "= 7.344e-08" if key == "probability" else "quantity = 1\n"
    after = f"= {text}" if key == "probability" else f"quantity = {text}\n"
    found = changed(block, before, after)
    now = make_block(gripper=1e-07, motor=2e-07)
    merged = merge(written_block(block), found, now, policy=STOP, evidence=lambda: kept)
    reported = {"tool": [], "user": [True], "unknown": [False]}[author]
    assert [edit.is_certain for edit in merged.edits] == [*reported, *reported][: len(merged.edits)]
    assert bool(merged.edits) == (author != "tool")


# What stood in the block of `elsewhere`, which is what `place` may be called on another branch, or
# is another function that stood beside it; what stands in that of `place`; and who wrote that.
ELSEWHERE = {
    "a figure of a branch that renamed it": (False, "= 7.344e-08", "= 4.444e-08", "unknown"),
    "a figure of the function beside it": (True, "= 7.344e-08", "= 4.444e-08", "unknown"),
    "`next` of a branch that renamed it": (False, "next = done 1\n", NEXT_HALF, "unknown"),
    "`next` of the function beside it": (True, "next = done 1\n", NEXT_HALF, "user"),
    "a component that a branch that renamed it lacks": (False, GRIPPER, "", "unknown"),
    "a component that the function beside it lacks": (True, GRIPPER, "", "user"),
    "a component of a branch that renamed it": (False, GRIPPER, GRIPPER + HOSE, "unknown"),
    "a component of the function beside it": (True, GRIPPER, GRIPPER + HOSE, "unknown"),
}


@pytest.mark.parametrize("is_fresh", [True, False])
@pytest.mark.parametrize("case", ELSEWHERE)
def test_what_a_renamed_function_had_on_another_branch_is_no_persons(
    case: str, is_fresh: bool, block
) -> None:
    is_beside, before, after, author = ELSEWHERE[case]
    found = changed(block, before, after)
    theirs = replace(found, name="elsewhere")
    names = {"place", "elsewhere"}
    kept = Evidence(
        is_fresh=is_fresh,
        is_complete=True,
        written={"place": [written_block(block)], "elsewhere": [written_block(theirs)]},
        standing={"place": [block], "elsewhere": [theirs]},
        versions=[frozenset(names)] if is_beside else [frozenset({name}) for name in names],
    )
    merged = merge(written_block(block), found, block, policy=STOP, evidence=lambda: kept)
    (edit,) = merged.edits
    assert edit.is_certain == (author == "user")


def test_an_omission_that_was_taken_back_is_no_omission(block, make_block) -> None:
    text = file_with(block).decode()
    head, section, rest = text.partition("    # | @Component {\n    # |   name = gripper")
    body, brace, rest = rest.partition("    # | }\n")
    omitted = read((head + section.replace("{", ":= omit {") + body + brace + rest).encode())
    without = read((head + rest).encode())
    kept = Evidence(is_fresh=True, is_complete=True, standing={"place": [omitted]})
    merged = merge(written_block(block), without, block, policy=ACCEPT, evidence=lambda: kept)
    assert merged.edits == ()
    assert merged.block == block
    # Without git the same bytes are those of a section that was deleted.
    (edit,) = merge(written_block(block), without, block, policy=STOP).edits
    assert (edit.kind, edit.field) == ("removed", "place.gripper")


def test_a_component_that_another_branch_brought_or_took_is_no_edit(block, make_block) -> None:
    """The lock is that of the other branch; the digest is that of the block."""
    one = make_block(gripper=7.344e-08)
    merged = merge(written_block(one), block, one, policy=STOP, evidence=unasked)
    assert (merged.block, merged.edits) == (one, ())
    of_one = with_digest(one)
    merged = merge(written_block(block), of_one, block, policy=STOP, evidence=unasked)
    assert (merged.block, merged.edits) == (block, ())


def test_a_renamed_target_is_known_under_its_earlier_name(make_block) -> None:
    block = with_digest(replace(make_block(), next=computed_next({"home": 9, "done": 1})))
    renamed = changed(block, "next = home", "next = rest")
    assert not DigestReading(renamed).vouches(None, NEXT, renamed.next.value)
    assert DigestReading(renamed, {"rest": "home"}).vouches(None, NEXT, renamed.next.value)


def test_git_knows_a_target_by_the_name_that_it_had_before_a_renaming(make_block) -> None:
    block = with_digest(make_block())
    elsewhere = replace(block, next=computed_next({"home": 1, "done": 1}))
    found = changed(block, "next = done 1\n", NEXT_HALF.replace("place", "rest"))
    for is_fresh in (True, False):
        kept = Evidence(
            is_fresh=is_fresh,
            is_complete=True,
            written={"place": [written_block(block), written_block(elsewhere)]},
        )
        merged = merge(
            written_block(block),
            found,
            block,
            policy=STOP,
            evidence=lambda kept=kept: kept,
            names=EarlierNames({}, {"rest": "home"}),
        )
        (edit,) = merged.edits
        assert (edit.field, edit.is_certain) == ("place.next", False)


def test_a_block_is_as_written_but_for_a_persons_words(block) -> None:
    written = written_block(block)
    assert is_as_written(block, written)
    assert is_as_written(changed(block, "= 7.344e-08", ":= 2e-07  ! why"), written)
    assert is_as_written(changed(block, "= 7.344e-08", ":= 2e-07  ! computed 7.344e-08"), written)
    assert not is_as_written(changed(block, "= 7.344e-08", ":= 2e-07  ! computed 1"), written)
    assert not is_as_written(changed(block, "= 7.344e-08", "= 2e-07"), written)
    assert not is_as_written(changed(block, "    # |   next = done 1\n", ""), written)
    assert not is_as_written(replace(block, digest=None), written)
    assert not is_as_written(block, with_value(block, "3.333e-08"))


@pytest.mark.parametrize("text", ["12345", "123456-", "123456-12345", "a person's words"])
def test_what_is_no_digest_begins_no_block(text: str) -> None:
    from tracerisk.errors import BlockError

    bad = SOURCE.decode().replace(
        "    go()", f"    # | RiskAnnotation {text}\n    # | @Function {{\n    # | }}\n    go()"
    )
    with pytest.raises(BlockError, match="is outside a risk block"):
        read_blocks(bad.encode(), "c.py")
