from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.adder.blocks.random_blocks import blocks
from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.compact import with_names
from tracerisk.adder.blocks.grammar import parse_block, print_block
from tracerisk.adder.blocks.lines import BlockLine
from tracerisk.adder.lock.digest import with_digest
from tracerisk.config import BlockForm
from tracerisk.errors import BlockError, ExitCode, UnpinnedReasonError

COMPACT = """\
# | RiskAnnotation
# | place 2 -> home 9/10, done 1/10
# | power    6.674e-08   1 of 2
# | gripper  := 2e-07    1        ! computed 7.344e-08; supplier derating, FMEA-112
# | hose     := add  1e-06       1        ! it holds the hose
# | wrist    := omit              ! hangs free in this step
"""
PUBLISHED = """\
# | RiskAnnotation
# | @Function {
# |   name = place
# |   callSequence = 2
# |   next = home 9/10
# |   next = done 1/10
# | }
# | @Component {
# |   name = power
# |   probability = 6.674e-08
# |   quantity = 2
# |   redundancy = true
# | }
# | @Component {
# |   name = gripper
# |   probability := 2e-07  ! computed 7.344e-08; supplier derating, FMEA-112
# |   quantity = 1
# |   redundancy = false
# | }
# | @Component := {  ! it holds the hose
# |   name = hose
# |   probability = 1e-06
# |   quantity = 1
# |   redundancy = false
# | }
# | @Component := omit {  ! hangs free in this step
# |   name = wrist
# | }
"""


def parsed(text: str) -> RiskBlock:
    lines = text.rstrip("\n").split("\n")
    return parse_block(
        [BlockLine(n, line.partition("|")[2]) for n, line in enumerate(lines, start=1)], "c.py"
    )


def text_of(block: RiskBlock, width: int = 90) -> str:
    return "\n".join(print_block(block, width)) + "\n"


def test_both_forms_of_a_block_say_the_same() -> None:
    compact, published = parsed(COMPACT), parsed(PUBLISHED)
    assert (compact.form, published.form) == ("compact", "published")
    assert compact == published
    assert text_of(replace(published, form="compact")) == COMPACT
    assert text_of(replace(compact, form="published")) == PUBLISHED


@given(blocks(), st.integers(20, 120))
def test_any_block_is_the_same_in_both_forms_and_back(block: RiskBlock, width: int) -> None:
    published = text_of(with_digest(block), width)
    compact = text_of(replace(parsed(published), form="compact"), width)
    again = parsed(compact)
    assert again.form == "compact"
    assert again == parsed(published) == block
    assert again.digest == parsed(published).digest
    assert text_of(replace(again, form="published"), width) == published
    assert text_of(again, width) == compact


def typed_anew(text: str, breaks: list[bool]) -> str:
    """A block whose reasons are typed in other lines: on one long line, or broken elsewhere."""
    lines: list[str] = []
    for line in text.splitlines():
        words = line.removeprefix("# | ").strip()
        if not words.startswith("!") or "!" not in lines[-1]:
            lines.append(line)
        elif breaks[len(lines) % len(breaks)]:
            lines[-1] += words.removeprefix("!")
        else:
            first, _, rest = words.partition(" ")[2].partition(" ")
            lines.append(f"# |     ! {first}")
            lines += [f"# |     ! {rest}"] if rest else []
    return "".join(f"{line}\n" for line in lines)


@given(
    blocks(),
    st.integers(30, 120),
    st.sampled_from(["published", "compact"]),
    st.lists(st.booleans(), min_size=1, max_size=3),
)
def test_reasons_come_back_from_the_other_form_as_they_were_typed(
    block: RiskBlock, width: int, form: BlockForm, breaks: list[bool]
) -> None:
    wrapped = text_of(replace(block, form=form), width)
    typed = typed_anew(wrapped, breaks)
    other = "compact" if form == "published" else "published"
    moved = text_of(replace(parsed(typed), form=other, moved_from=form), width)
    assert parsed(moved) == block
    assert text_of(replace(parsed(moved), form=form, moved_from=other), width) == typed
    # What is written anew is wrapped, whoever typed it.
    assert text_of(parsed(typed), width) == wrapped


def test_a_long_line_of_a_user_stays_one_and_what_the_tool_wrapped_is_wrapped() -> None:
    long = "  ! computed 1e-09; service log of cell 3, 2026: the drive belt was changed in June"
    source = (
        "# | RiskAnnotation\n# | @Function {\n# |   name = f\n# |   callSequence = 1\n# | }\n"
        "# | @Component {\n# |   name = gripper\n"
        f"# |   probability := 5e-08{long}\n# |   quantity = 1\n# |   redundancy = false\n# | }}\n"
    )
    compact = text_of(replace(parsed(source), form="compact", moved_from="published"), 79)
    assert any(line.endswith(long) for line in compact.splitlines())
    wrapped = text_of(parsed(source), 79)
    moved = text_of(replace(parsed(wrapped), form="compact", moved_from="published"), 79)
    assert max(map(len, moved.splitlines())) <= 79


def test_the_digest_does_not_depend_on_the_form() -> None:
    compact, published = with_digest(parsed(COMPACT)), with_digest(parsed(PUBLISHED))
    assert compact.digest == published.digest


def test_each_value_that_a_user_set_has_its_own_reason() -> None:
    block = parsed(
        "# | RiskAnnotation\n"
        "# | f := 3 -> := g 0.5, done 0.5  ! computed 1; first\n"
        "# |   next  ! computed g 1/2, done 1/2; a long one\n"
        "# |     ! that goes on\n"
        "# | m := 1e-7 := 2 of 3, spare cold  ! derated\n"
        "# |   redundancy  ! computed false; two hold\n"
        "# | n 1e-8 2 := required 1  ! computed true\n"
    )
    assert (block.call_sequence.pinned, block.call_sequence.reason) == (True, "first")
    assert block.next is not None
    assert (block.next.computed, block.next.reason) == (
        "g 1/2, done 1/2",
        "a long one that goes on",
    )
    m, n = block.components
    assert (m.probability.pinned, m.probability.reason) == (True, "derated")
    assert (m.quantity.pinned, m.quantity.value, m.quantity.reason) == (True, 3, None)
    assert m.redundancy.text == "required 2, spare cold"
    assert (m.redundancy.computed, m.redundancy.reason) == ("false", "two hold")
    assert (n.quantity.pinned, n.redundancy.pinned) == (False, True)
    assert (n.redundancy.text, n.redundancy.computed) == ("required 1", "true")


def test_many_targets_go_on_in_further_lines() -> None:
    steps = ", ".join(f"function_{n} 1/8" for n in range(8))
    block = parsed(f"# | RiskAnnotation\n# | f 1 -> {steps}\n# | m 1e-8 1\n")
    lines = print_block(block, 60)
    assert max(map(len, lines)) <= 60
    assert [line.split()[2] for line in lines[2:4]] == ["->", "->"]
    assert parsed("\n".join(lines)) == block


def test_an_omitted_component_may_state_some_values() -> None:
    text = "# | RiskAnnotation\n# | f 1\n# | m  := omit  -           2 -\n"
    (entry,) = parsed(text).components
    assert entry.omitted
    assert [entry.probability.text, entry.quantity.text, entry.redundancy.text] == ["", "2", ""]
    assert text_of(parsed(text)) == text.replace(" 2 -", " 2 -")


BAD = {
    "no rank": ("place -> home 1", 2, "begins with its function, `NAME RANK -> "),
    "bad rank": ("place two -> home 1", 2, "callSequence = two is not allowed"),
    "shares": ("f 1 -> g 1/2", 2, "shares that sum to 1"),
    "no units": ("f 1\nm 1e-8", 3, "as a component; allowed: `NAME PROBABILITY UNITS`"),
    "added without values": ("f 1\nm := add", 3, "as a component; allowed:"),
    "probability": ("f 1\nm 2 1", 3, "probability = 2 is not allowed; allowed: a probability"),
    "units": ("f 1\nm 1e-8 0", 3, "quantity = 0 is not allowed"),
    "redundancy": ("f 1\nm 1e-8 2 maybe", 3, "redundancy = maybe is not allowed"),
    "left out": ("f 1\nm - 2 -", 3, "probability is left out; only `:= omit`"),
    "reason of the tool": ("f 1\nm 1e-8 1 ! why", 3, "a reason is allowed only for what a user"),
    "goes on from nothing": ("f 1\n! why", 3, "but none precedes it"),
    "reason of another": (
        "f 1\nm := 1e-8 1\nquantity ! why",
        4,
        "quantity has a reason but is not set by hand; set by hand: probability",
    ),
    "two reasons": ("f 1\nm := 1e-8 1 ! a\nprobability ! b", 4, "a second reason for probability"),
    "twice": ("f 1\nm 1e-8 1\nm 1e-8 1", 4, "duplicate component m in this block, first at line 3"),
    "conflict": ("f 1\n=======", 3, "is a conflict marker in a risk block"),
    "name": ('f 1\n"m\\q" 1e-8 1', 3, "cannot read the name"),
    "sections": ("f 1\n@Component {", 3, "cannot read `@Component {` as a component"),
    "no mark": (
        "f 1\nm := 1e-8 1 ! computed 2e-8\n! endurance test",
        3,
        "write `;` before the reason: `! computed 2e-8; endurance test`",
    ),
    "hash": ("f 1\nm := 1e-8 1 # why", 3, "redundancy = # why is not allowed"),
}


@pytest.mark.parametrize(
    "comment",
    [
        "computed 4e-08; May",
        "computed 4e-08 ! May",
        "computed 4e-08  !May",
        "computed 4e-08\n! ; May",
    ],
)
def test_a_reason_stands_behind_either_mark_after_what_was_computed(comment: str) -> None:
    rows = "".join(f"# | {row}\n" for row in f"f 1\nm := 1e-7 1 ! {comment}".split("\n"))
    block = parsed(f"# | RiskAnnotation\n{rows}")
    value = block.components[0].probability
    assert (value.computed, value.reason) == ("4e-08", "May")
    # The tool writes one form, and reads it back.
    again = parsed(text_of(block)).components[0].probability
    assert (again.computed, again.reason) == ("4e-08", "May")


def test_a_reason_of_a_computed_value_is_an_edit() -> None:
    for row in ("m 1e-8 1 ! why", "m 1e-8 1\n# | ! why", "m := 1e-8 1\n# | quantity ! why"):
        with pytest.raises(UnpinnedReasonError) as caught:
            parsed(f"# | RiskAnnotation\n# | f 1\n# | {row}\n")
        assert (caught.value.exit_code, caught.value.code) == (ExitCode.EDIT_IN_THE_WAY, "reason")


@pytest.mark.parametrize(("text", "line", "message"), BAD.values(), ids=BAD)
def test_a_mistake_is_reported_with_its_line(text: str, line: int, message: str) -> None:
    with pytest.raises(BlockError) as caught:
        parsed("# | RiskAnnotation\n" + "".join(f"# | {row}\n" for row in text.split("\n")))
    assert message in caught.value.message
    assert caught.value.location is not None
    assert caught.value.location.line == line


@pytest.mark.parametrize(
    ("line", "renamed"),
    [
        (" f 1 -> g 1/2, f 1/2", " h 1 -> g 1/2, h 1/2"),
        (" g := 2 -> := f 0.5,g 0.5 ! f stays here", " g := 2 -> := h 0.5,g 0.5 ! f stays here"),
        ("   -> f 1/4,  g 1/4\n", "   -> h 1/4,  g 1/4\n"),
        (" ff 1 -> MoveTo (f) 1", " ff 1 -> MoveTo (f) 1"),
        (" operator-> 1", ' "->x" 1'),
        (" }", " }"),
    ],
)
def test_names_are_changed_in_the_line_of_a_function(line: str, renamed: str) -> None:
    assert with_names(line, {"f": "h", "operator->": "->x"}) == renamed
