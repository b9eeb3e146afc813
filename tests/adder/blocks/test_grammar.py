from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.adder.blocks.random_blocks import blocks
from tracerisk.adder.blocks.block import Field, RiskBlock, Transition
from tracerisk.adder.blocks.grammar import parse_block, print_block
from tracerisk.adder.blocks.lines import BlockLine
from tracerisk.adder.blocks.values import (
    computed_next,
    computed_probability,
    profile_next,
    read_redundancy,
    read_transitions,
)
from tracerisk.errors import BlockError

DESIGN_BLOCK = """\
# | RiskAnnotation
# | @Function {
# |   name = place
# |   callSequence = 5
# |   next = init 9/10
# |   next = done 1/10
# | }
# | @Component {
# |   name = power_system
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
"""


def parsed(text: str) -> RiskBlock:
    lines = text.rstrip("\n").split("\n")
    return parse_block(
        [BlockLine(n, line.partition("|")[2]) for n, line in enumerate(lines, start=1)], "c.py"
    )


def test_a_block_says_what_its_text_says() -> None:
    block = parsed(DESIGN_BLOCK)
    assert block.name == "place"
    assert block.call_sequence.value == 5
    assert block.next is not None
    assert block.next.value == (
        Transition("init", Fraction(9, 10)),
        Transition("done", Fraction(1, 10)),
    )
    power, gripper = block.components
    assert (power.name, power.probability.value, power.quantity.value) == (
        "power_system",
        6.674e-08,
        2,
    )
    assert power.redundancy.value
    assert gripper.probability == Field(
        2e-07, "2e-07", True, "7.344e-08", "supplier derating, FMEA-112"
    )
    assert gripper.probability.location is not None
    assert gripper.probability.location.line == 16


def test_a_block_is_printed_as_it_was_written() -> None:
    assert print_block(parsed(DESIGN_BLOCK)) == tuple(DESIGN_BLOCK.rstrip("\n").split("\n"))


def test_fields_are_printed_in_their_fixed_order() -> None:
    shuffled = parsed(
        "# | RiskAnnotation\n# | @Component {\n# |   redundancy = true\n# |   quantity = 2\n"
        "# |   probability = 1e-08\n# |   name = power\n# | }\n# | @Function {\n"
        "# |   next = done 1\n# |   callSequence = 1\n# |   name = f\n# | }\n"
    )
    assert [line.split()[2] for line in print_block(shuffled) if "=" in line] == [
        "name",
        "callSequence",
        "next",
        "name",
        "probability",
        "quantity",
        "redundancy",
    ]


def test_a_long_reason_wraps_onto_lines_of_its_own_and_reads_back(read_block) -> None:
    reason = "the supplier derates the jaws above forty degrees, see the sheet of the lot " * 2
    block = read_block(
        f"""
        RiskAnnotation
        @Function {{
          name = f
          callSequence := 2  ! computed 1; {reason}
        }}
        """
    )
    lines = print_block(block, 60)
    assert max(map(len, lines)) <= 60
    assert sum(line.startswith("# |     ! ") for line in lines) >= 2
    assert parsed("\n".join(lines)) == block
    assert block.call_sequence.reason == reason.strip()


def test_the_next_lines_are_one_value_with_one_reason(read_block) -> None:
    block = read_block(
        """
        RiskAnnotation
        @Function {
          name = f
          callSequence = 1
          next := g 0.25
          next := done 0.75  ! computed g 1/2, done 1/2; the line stops
            ! for lunch
        }
        """
    )
    assert block.next == Field(
        read_transitions("g 0.25, done 0.75"),
        "g 0.25, done 0.75",
        True,
        "g 1/2, done 1/2",
        "the line stops for lunch",
    )


def test_an_omitted_component_may_leave_its_values_out(read_block) -> None:
    block = read_block(
        """
        RiskAnnotation
        @Function := {  ! seen on the bench
          name = f
          callSequence = 1
        }
        @Component := omit {  ! hangs on a hoist
          name = motor
        }
        @Component := {
          name = hoist
          probability := 1e-9
          quantity = 1
          redundancy = false
        }
        """
    )
    assert block.added
    assert block.reason == "seen on the bench"
    motor, hoist = block.components
    assert motor.omitted
    assert not motor.added
    assert motor.reason == "hangs on a hoist"
    assert not motor.probability.is_stated
    assert hoist.added
    assert "\n".join(print_block(block)).count("probability") == 1
    assert parsed("\n".join(print_block(block))) == block


@pytest.mark.parametrize(
    ("value", "text"),
    [(6.674e-08, "6.674e-08"), (1.23456e-07, "1.235e-07"), (0.0, "0"), (1.0, "1"), (0.25, "0.25")],
)
def test_a_computed_probability_has_four_significant_digits(value: float, text: str) -> None:
    field = computed_probability(value)
    assert field.text == text
    assert field.value == float(text)


def test_counts_of_visits_stay_unreduced_and_a_certain_transition_is_one() -> None:
    assert computed_next({"init": 8, "done": 2}).text == "init 8/10, done 2/10"
    assert computed_next({"place": 10}).text == "place 1"
    assert profile_next({"init": "0.9", "done": "0.1"}).value == (
        Transition("init", Fraction(9, 10)),
        Transition("done", Fraction(1, 10)),
    )


@given(blocks(), st.integers(20, 120))
def test_a_printed_block_parsed_again_is_the_same_block(block: RiskBlock, width: int) -> None:
    lines = print_block(block, width)
    again = parsed("\n".join(lines))
    assert again == block
    assert print_block(again, width) == lines


FUNCTION = "@Function {\n  name = f\n  callSequence = 1\n}\n"
COMPONENT = (
    "@Component {\n  name = m\n  probability = 1e-8\n  quantity = 1\n  redundancy = true\n}\n"
)

BAD_BLOCKS = {
    "no header": ("@Function {\n}", 1, "begins with the line `# | RiskAnnotation`"),
    "no function": (f"RiskAnnotation\n{COMPONENT}", 1, "has no `@Function {`"),
    "two functions": (f"RiskAnnotation\n{FUNCTION}{FUNCTION}", 6, "this is a second"),
    "two components": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT}{COMPONENT}",
        12,
        "duplicate component m in this block, first at line 6",
    ),
    "missing brace": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1",
        2,
        "the `@Function {` of this line has no `}`",
    ),
    "missing brace before a component": (
        f"RiskAnnotation\n@Function {{\n  name = f\n{COMPONENT}",
        4,
        "before the section of line 2 is closed",
    ),
    "line outside a section": (f"RiskAnnotation\n{FUNCTION}name = g", 6, "unexpected `name = g`"),
    "unknown section": ("RiskAnnotation\n@Functoin {", 2, "cannot read `@Functoin {`; allowed:"),
    "omitted function": ("RiskAnnotation\n@Function := omit {", 2, "a function cannot be omitted"),
    "text after a brace": ("RiskAnnotation\n@Function { f", 2, "unexpected `f` after the brace"),
    "reason without a person": ("RiskAnnotation\n@Function { ! why", 2, "write `:= {`"),
    "unknown key": (
        "RiskAnnotation\n@Function {\n  nmae = f",
        3,
        "unknown key nmae in `@Function`; did you mean 'name'? allowed: callSequence, name, next",
    ),
    "no assignment": ("RiskAnnotation\n@Function {\n  place", 3, "cannot read `place`; allowed: }"),
    "two names": (
        "RiskAnnotation\n@Function {\n  name = f\n  name = g",
        4,
        "duplicate name, first at line 3",
    ),
    "pinned name": ("RiskAnnotation\n@Function {\n  name := f", 3, "a name cannot be set by hand"),
    "no name": ("RiskAnnotation\n@Function {\n}", 2, "has no `name = ` line"),
    "name with a space": (
        "RiskAnnotation\n@Function {\n  name = f g\n  callSequence = 1\n}",
        3,
        "cannot be the qualified name of a function",
    ),
    "component without a name": (
        f"RiskAnnotation\n{FUNCTION}@Component {{\n  name =\n}}",
        7,
        "cannot be the name of a component",
    ),
    "no call sequence": (
        "RiskAnnotation\n@Function {\n  name = f\n}",
        2,
        "has no `callSequence = ` line",
    ),
    "no quantity": (
        f"RiskAnnotation\n{FUNCTION}" + COMPONENT.replace("  quantity = 1\n", ""),
        6,
        "has no `quantity = ` line",
    ),
    "probability above one": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT.replace('1e-8', '1e3')}",
        8,
        "probability = 1e3 is not allowed; allowed: a probability from 0 to 1",
    ),
    "probability that is not a number": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT.replace('1e-8', 'nan')}",
        8,
        "probability = nan is not allowed",
    ),
    "reason behind a semicolon": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT.replace('= 1e-8', ':= 1e-8 ; a new gear')}",
        8,
        "not after `;`; write `probability := 1e-8  ! a new gear`",
    ),
    "quantity of zero": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT.replace('quantity = 1', 'quantity = 0')}",
        9,
        "quantity = 0 is not allowed; allowed: a whole number from 1 up",
    ),
    "redundancy that is no flag": (
        f"RiskAnnotation\n{FUNCTION}{COMPONENT.replace('true', 'yes')}",
        10,
        "redundancy = yes is not allowed; allowed: true, false",
    ),
    "reason at the tool's value": (
        "RiskAnnotation\n@Function {\n  callSequence = 1 ! mine",
        3,
        "write `callSequence := `",
    ),
    "reason line at the tool's value": (
        "RiskAnnotation\n@Function {\n  callSequence = 1\n    ! mine",
        4,
        "none precedes it",
    ),
    "bad computed value": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence := 1 ! computed 1x\n}",
        4,
        "callSequence ! computed 1x is not allowed",
    ),
    "mixed next": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g 1/2\n"
        "  next := h 1/2\n}",
        6,
        "write `=` on all, or `:=` on all",
    ),
    "two reasons for next": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next := g 1/2 ! a\n"
        "  next := h 1/2 ! b\n}",
        6,
        "one value with one reason",
    ),
    "two targets on one line": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g 1/2, h 1/2\n}",
        5,
        "one `next` line for each target",
    ),
    "next without a share": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g\n}",
        5,
        "next = g is not allowed; allowed: a function (or done) and its share",
    ),
    "next divided by zero": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g 1/0\n}",
        5,
        "above 0 and up to 1",
    ),
    "next twice to one target": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g 1/2\n"
        "  next = g 1/2\n}",
        5,
        "not two for g",
    ),
    "next that does not sum to one": (
        "RiskAnnotation\n@Function {\n  name = f\n  callSequence = 1\n  next = g 1/2\n"
        "  next = h 1/3\n}",
        5,
        "shares that sum to 1, and not to 5/6",
    ),
    "conflict marker": (
        "RiskAnnotation\n@Function {\n<<<<<<< HEAD\n  name = f",
        3,
        "`<<<<<<< HEAD` is a conflict marker in a risk block",
    ),
}


@pytest.mark.parametrize("case", sorted(BAD_BLOCKS))
def test_a_bad_block_is_an_error_with_file_and_line(case: str, read_block) -> None:
    text, line, message = BAD_BLOCKS[case]
    with pytest.raises(BlockError) as caught:
        read_block(text)
    assert message in str(caught.value)
    assert str(caught.value).startswith(f"c.py:{line}: ")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("maybe", "true, false, required K"),
        ("false, common_cause 0.1", "true, false, required K"),
        ("required 0", "required K with K from 1 up"),
        ("true, common_cause 1.5", "the share of failures that hit every unit, from 0 to 1"),
        (
            "true, spare warm 2",
            "the failure rate of a waiting spare divided by that of a working one",
        ),
        ("true, switch 3", "the probability that a spare fails to take over, from 0 to 1"),
        ("true, detected hourly", "the first failures of a group stay"),
    ],
)
def test_a_redundancy_that_cannot_be_is_reported_with_what_can(read_block, text, message):
    with pytest.raises(BlockError, match=f"redundancy = {text} is not allowed; .*{message}"):
        read_block(
            f"""
            RiskAnnotation
            @Function {{
              name = place
              callSequence = 1
            }}
            @Component {{
              name = power
              probability = 0.1
              quantity = 2
              redundancy = {text}
            }}
            """
        )


def test_a_group_hides_its_failures_until_the_mission_ends_unless_it_is_stated():
    assert read_redundancy("true, detected mission_start") == read_redundancy("true")
    assert read_redundancy("true").detected == "mission_start"
    assert read_redundancy("required 2, detected each_visit").detected == "each_visit"


@pytest.mark.parametrize(
    "reason",
    ["computed by the supplier", "computed offline; FMEA-112", "computed", "computed none of it"],
)
def test_a_reason_may_begin_with_the_word_computed(read_block, reason):
    text = f"RiskAnnotation\n@Function {{\n  name = f\n  callSequence := 2  ! {reason}\n}}"
    rank = read_block(text).call_sequence
    assert (rank.computed, rank.reason) == (None, reason)
    again = read_block("\n".join(line[4:] for line in print_block(read_block(text))))
    assert again.call_sequence.reason == reason


def test_a_reason_behind_a_hash_is_reported_where_it_goes(read_block):
    text = "RiskAnnotation\n@Function {\n  name = f\n  callSequence := 2  # why, FMEA-1\n}"
    with pytest.raises(BlockError, match="write `callSequence := 2  ! why, FMEA-1`"):
        read_block(text)
