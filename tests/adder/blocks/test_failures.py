"""`@Failure` sections: read, printed in both forms, owned, merged and followed through renames."""

from dataclasses import replace
from fractions import Fraction

import pytest

from tracerisk.adder.blocks.computed_failures import failures_of
from tracerisk.adder.blocks.failures import are_close, read_failures, renamed_text
from tracerisk.adder.blocks.grammar import parse_block, print_block
from tracerisk.adder.blocks.lines import BlockLine
from tracerisk.adder.blocks.values import FAILURES
from tracerisk.adder.lock.digest import DigestReading, with_digest
from tracerisk.adder.lock.lock import as_written, written_block
from tracerisk.adder.merge.edits_found import MergePolicy
from tracerisk.adder.merge.merge import merge
from tracerisk.adder.sources.renames import source_with_names
from tracerisk.common.function_ref import QualifiedName
from tracerisk.errors import BlockError

MODES = "dead 3/4: stopped safely 1/2, unaware 1/2 | stuck 1/4: back to pick in place 1"


def text(*modes: str, component: str = "gripper") -> str:
    lines = "\n".join(f"  mode {mode}" for mode in modes)
    section = f"\n@Failure {{\n  component = {component}\n{lines}\n}}" if modes else ""
    return (
        "RiskAnnotation\n@Function {\n  name = place\n  callSequence = 2\n  next = done 1\n}\n"
        "@Component {\n  name = gripper\n  probability = 2e-07\n  quantity = 1\n"
        f"  redundancy = false\n}}{section}"
    )


def read(said: str):
    lines = [BlockLine(number, line) for number, line in enumerate(said.splitlines(), 1)]
    return parse_block(lines, "cell.py")


def block(*modes: str):
    return read(text(*modes))


def said(of) -> str:
    return of.components[0].failures.text


TOOL = block(*(f"= {mode}" for mode in MODES.split(" | ")))
OTHER = block("= dead 1: unaware 1")
PINNED = block("= dead 1: unaware 1".replace("=", ":=") + "  ! seen in the field")


@pytest.mark.parametrize("form", ["published", "compact"])
@pytest.mark.parametrize("width", [40, 79, 200])
@pytest.mark.parametrize("of", [TOOL, OTHER, PINNED], ids=["two modes", "one", "by hand"])
def test_what_is_printed_is_read_back(of, form, width):
    of = replace(of, form=form)
    of = replace(
        of,
        components=tuple(
            replace(
                entry,
                failures=replace(entry.failures, computed=MODES)
                if entry.failures.pinned
                else entry.failures,
            )
            for entry in of.components
        ),
    )
    printed = print_block(of, width)
    assert read("\n".join(line[4:] for line in printed)) == of


LONG = block(
    "= dead 3/4: stopped safely 1/2, unaware in place 1/4, back to pick in <module> 1/4",
    "= stuck 1/4: stopped late 1/3, stopped safely in place 2/3",
)


@pytest.mark.parametrize(
    ("form", "lines"),
    [
        (
            "published",
            [
                "# |   mode = dead 3/4: stopped safely 1/2,",
                "# |     unaware in place 1/4,",
                "# |     back to pick in <module> 1/4",
                "# |   mode = stuck 1/4: stopped late 1/3,",
                "# |     stopped safely in place 2/3",
            ],
        ),
        (
            "compact",
            [
                "# |   -> dead 3/4: stopped safely 1/2,",
                "# |     unaware in place 1/4,",
                "# |     back to pick in <module> 1/4",
                "# |   -> stuck 1/4: stopped late 1/3,",
                "# |     stopped safely in place 2/3",
            ],
        ),
    ],
)
def test_what_follows_is_wrapped_at_the_width_of_a_block_and_read_back(form, lines):
    printed = print_block(replace(LONG, form=form), 44)
    first = next(at for at, line in enumerate(printed) if "dead" in line)
    assert list(printed[first : first + len(lines)]) == lines
    assert read("\n".join(line.removeprefix("# | ") for line in printed)) == LONG


@pytest.mark.parametrize("form", ["published", "compact"])
def test_a_mistake_in_a_further_line_says_what_may_follow(form):
    said = "\n".join(line[4:] for line in print_block(replace(LONG, form=form), 44))
    for wrong in ("    unawre in place 1/4,", "    unaware in place 1/4,\n"):
        with pytest.raises(BlockError, match="`stopped late`, `unaware`, `back to FUNCTION`"):
            read(said.replace("    unaware in place 1/4,\n    back to pick in <module> 1/4", wrong))


def test_values_are_exact():
    first, second = TOOL.components[0].failures.value
    assert (first.name, first.share) == ("dead", Fraction(3, 4))
    assert second.outcomes == (("back", "pick", "place", Fraction(1)),)


@pytest.mark.parametrize(
    ("modes", "message"),
    [
        (["= dead 1/2: gone 1"], "what may follow: `stopped safely`"),
        (["= dead 1/2: unaware 1/2"], "sum to 1, and not to 1/2"),
        (["= dead 2/3: unaware 1", "= stuck 2/3: unaware 1"], "sum to 1 at most, and not to 4/3"),
        (["= dead 1/2: unaware 1", "= dead 1/2: unaware 1"], "not two for dead"),
        (["= dead 1/2: unaware 1/2, unaware 1/2"], "each said once"),
        (["= dead 1/2: unaware 1", ":= stuck 1/2: unaware 1"], "write `=` on all, or `:=` on all"),
        (["= dead 1/2: unaware 1 | stuck 1/2: unaware 1"], "one `mode` line for each mode"),
        (["= dead 0: unaware 1"], "a mode with its share"),
    ],
)
def test_mistakes_are_named_with_their_line(modes, message):
    with pytest.raises(BlockError) as caught:
        block(*modes)
    assert message in caught.value.message
    assert caught.value.location is not None
    assert caught.value.location.line >= 15


def test_a_section_of_no_component_is_a_mistake():
    with pytest.raises(BlockError, match="`@Failure` of wrist, which is no component"):
        read(text("= dead 1: unaware 1", component="wrist"))


def test_a_digest_holds_the_section_and_is_as_before_without_one():
    assert read("\n".join(line[4:] for line in print_block(with_digest(TOOL)))) == TOOL
    plain, full = with_digest(block()), with_digest(TOOL)
    assert len(full.digest.split("-")[1]) == len(plain.digest.split("-")[1]) + 2
    digest = DigestReading(full)
    assert digest.vouches("gripper", FAILURES, read_failures(MODES))
    assert not digest.vouches("gripper", FAILURES, read_failures("dead 1: unaware 1"))


def test_the_lock_gives_the_section_back():
    written = written_block(TOOL)
    assert as_written("place", written).components[0].failures.value == read_failures(MODES)


@pytest.mark.parametrize(
    ("current", "computed", "policy", "expected"),
    [
        (TOOL, TOOL, "stop", MODES),
        (TOOL, OTHER, "stop", "dead 1: unaware 1"),
        (TOOL, block(), "stop", ""),
        (block(), TOOL, "stop", MODES),
        (PINNED, TOOL, "stop", "dead 1: unaware 1"),
        (PINNED, block(), "stop", "dead 1: unaware 1"),
        (OTHER, TOOL, "accept", "dead 1: unaware 1"),
        (OTHER, TOOL, "discard", MODES),
        (OTHER, block(), "accept", "dead 1: unaware 1"),
        (OTHER, block(), "discard", ""),
    ],
)
def test_a_section_is_merged_as_any_value(current, computed, policy, expected):
    base = written_block(TOOL)
    merged = merge(base, current, computed, policy=MergePolicy(policy))
    assert said(merged.block) == expected
    is_edited = current is OTHER
    assert bool(merged.edits) == is_edited
    again = merge(written_block(computed), merged.block, computed, policy=MergePolicy())
    assert print_block(again.block) == print_block(merged.block)


def test_a_pin_keeps_what_is_computed_beside_it():
    merged = merge(written_block(TOOL), PINNED, TOOL, policy=MergePolicy())
    field = merged.block.components[0].failures
    assert (field.computed, field.reason) == (MODES, "seen in the field")


def test_noise_keeps_the_text():
    near = block("= dead 0.7501: stopped safely 0.5, unaware 0.5", "= stuck 0.2499: unaware 1")
    far = block("= dead 0.8: stopped safely 0.5, unaware 0.5", "= stuck 0.2: unaware 1")
    base = block("= dead 3/4: stopped safely 1/2, unaware 1/2", "= stuck 1/4: unaware 1")
    written = written_block(base)
    for computed, kept in ((near, True), (far, False)):
        merged = merge(written, base, computed, policy=MergePolicy(), steady=("gripper",))
        assert (said(merged.block) == said(base)) == kept
    assert not are_close(read_failures(MODES), read_failures("dead 1: unaware 1"), 0.5)


@pytest.mark.parametrize("form", ["published", "compact"])
def test_a_renamed_function_keeps_its_name_in_sections(form):
    source = "\n".join(print_block(replace(TOOL, form=form))).encode()
    names = {
        QualifiedName("pick"): QualifiedName("grip"),
        QualifiedName("place"): QualifiedName("put"),
    }
    renamed = source_with_names(source, names).decode()
    assert "back to grip in put 1" in renamed
    source = "\n".join(print_block(replace(LONG, form=form), 44)).encode()
    renamed = source_with_names(source, names).decode()
    assert "# |     unaware in put 1/4,\n# |     back to grip in <module> 1/4\n" in renamed
    broken = source.replace(b"# |     back to", b"# | \n# |     back to")
    assert "back to grip in <module>" in source_with_names(broken, names).decode()
    assert renamed_text("in place 1/2: back to in 1", {"in": "on", "place": "x"}) == (
        "in place 1/2: back to on 1"
    )


def test_the_tool_writes_four_digits_that_sum_up():
    field = failures_of(
        {
            "dead": {("unaware", ""): 0.1234567, ("stopped safely", ""): 0.5},
            "stuck": {("stopped late", "place"): 0.3765433},
        }
    )
    assert field.text == (
        "dead 0.6235: unaware 0.198, stopped safely 0.802 | stuck 0.3765: stopped late in place 1"
    )
    assert sum(mode.share for mode in field.value) == 1
