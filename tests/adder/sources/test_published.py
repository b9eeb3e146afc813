"""Blocks in plain comments, of C, C++, Java and Python."""

import re

import pytest

from tracerisk.adder.sources.published import read_c_blocks, read_plain_blocks
from tracerisk.errors import BlockError
from tracerisk.instrument.source.language import is_c_like

C = b"""\
#include <stdio.h>
const char *text = "/* RiskAnnotation @Function { no block */";

/***
 * RiskAnnotation
 * @Function {
 *   name = init
 *   callSequence = 1
 * }
 * @Component {
 *   name = electric_motor
 *   probability = 9.5e-08
 *   quantity = 7
 *   redundancy = false
 * }
 ***/
void init(void) {}  // RiskAnnotation @Function {

/* RiskAnnotation
@Function {
  name = place
  callSequence = 2
  next = init 9/10
  next = done 1/10
}
Places the part. */
void place(void) { char c = '"'; }
"""
JAVA = b'''\
class Cell {
    String text = """
        /* @Function { */
        """;
    /** RiskAnnotation
      * @Function {
      *   name = Cell.pick
      *   callSequence = 1
      * }
      */
    void pick() {}
}
'''
PYTHON = b'''\
def place():
    """# @Function { no block"""
    # @Function {
    #   name = place
    #   callSequence = 5
    # }
    # @Component {
    #   name = gripper
    #   probability = 7.344e-08
    #   quantity = 1
    #   redundancy = false
    # }
    # Mind the rack.
    go()
'''


def test_blocks_of_c_are_read_where_comments_are_and_nowhere_else():
    blocks = read_c_blocks(C, "arm.c")
    assert [(block.name, block.call_sequence.value) for block in blocks] == [
        ("init", 1),
        ("place", 2),
    ]
    (motor,) = blocks[0].components
    assert (motor.probability.value, motor.quantity.value) == (9.5e-08, 7)
    assert motor.probability.location.line == 12
    assert [step.target for step in blocks[1].next.value] == ["init", "done"]


def test_line_ends_of_windows_change_nothing():
    assert read_c_blocks(C.replace(b"\n", b"\r\n"), "arm.c") == read_c_blocks(C, "arm.c")


def test_raw_strings_of_cpp_hold_no_comment():
    source = b'auto s = R"x(" /* RiskAnnotation @Function { )x";\n' + C
    assert len(read_c_blocks(source, "arm.cpp")) == 2


def test_text_blocks_of_java_hold_no_comment():
    (block,) = read_c_blocks(JAVA, "Cell.java")
    assert block.name == "Cell.pick"
    assert block.location.line == 5


def test_plain_comments_of_python_are_read_without_a_header_too():
    (block,) = read_plain_blocks(PYTHON, "c.py")
    assert block.name == "place"
    assert block.components[0].probability.location.line == 9
    (same,) = read_plain_blocks(
        PYTHON.replace(b"    # @F", b"    # RiskAnnotation\n    # @F"), "c.py"
    )
    assert same == block


@pytest.mark.parametrize("end", [b"\n", b"\r\n", b"\r"])
@pytest.mark.parametrize("lead", [b"", b"\xef\xbb\xbf", b"x = 1\n", b"if x:\n    y = 1\n\t\f"])
def test_plain_comments_are_found_after_any_line_end(lead, end):
    lines = (b"# @Function {", b"#   name = f", b"#   callSequence = 1", b"# }", b"x = 1", b"")
    (found,) = read_plain_blocks(lead + end.join(lines), "x.py")
    assert found.name == "f"


def test_what_stands_behind_the_gutter_is_not_plain():
    gutter = (
        b"def f():\n    # | RiskAnnotation\n    # | @Function {\n    # |   name = f\n    # | }\n"
    )
    assert read_plain_blocks(gutter + b"    pass\n", "c.py") == ()


@pytest.mark.parametrize(
    ("change", "line", "message"),
    [
        ((b"quantity = 7", b"quantity = 0"), 13, "quantity = 0 is not allowed"),
        ((b"callSequence = 1", b"calls = 1"), 8, "unknown key calls"),
        ((b"redundancy = false\n * }", b"redundancy = false"), 10, "has no `}`"),
        ((b"Places the part. */", b"Places the part."), 19, "has no `*/`"),
    ],
)
def test_what_is_wrong_is_reported_with_its_line(change, line, message):
    with pytest.raises(BlockError, match=re.escape(message)) as caught:
        read_c_blocks(C.replace(*change), "arm.c")
    assert caught.value.location.line == line


@pytest.mark.parametrize("name", ["a.c", "a.CPP", "dir/a.hpp", "A.java", "a.ino"])
def test_the_ending_says_the_language(name):
    assert is_c_like(name)
    assert not is_c_like("a.py")


def test_a_model_is_built_of_several_languages(example):
    example.write("arm.c", C.replace(b"next = init 9/10", b"next = pick 9/10"))
    example.write("pick.py", PYTHON.replace(b"place", b"pick"))
    outcome = example.run("build", "arm.c", "pick.py", "--json")
    assert outcome.code == 0, outcome.err
    names = [state["name"] for state in outcome.json["model"]["states"]]
    assert names == ["init", "place", "pick"]


@pytest.mark.parametrize(
    ("redundancy", "detected"),
    [
        ("true", "each_visit"),
        ("required 2", "each_visit"),
        ("true, detected mission_start", "mission_start"),
    ],
)
def test_groups_of_the_published_form_are_whole_at_each_visit_unless_it_says_more(
    redundancy, detected
):
    source = C.replace(b"redundancy = false", f"redundancy = {redundancy}".encode())
    (motor,) = read_c_blocks(source, "cell.c")[0].components
    assert motor.redundancy.value.detected == detected
    assert motor.redundancy.text == redundancy


COMPACT = b"""\
/***
 * RiskAnnotation
 * init 1 -> place 1
 * motor  9.5e-08     3 true
 ***/
"""


def test_a_compact_block_is_read_in_comments_too_with_the_same_meaning():
    (block,) = read_c_blocks(COMPACT, "Cell.java")
    assert (block.form, block.name) == ("compact", "init")
    (motor,) = block.components
    assert motor.redundancy.value.detected == "each_visit"
    lines = COMPACT.replace(b"/***\n", b"").replace(b" ***/\n", b"").replace(b" *", b"#")
    assert read_plain_blocks(lines, "c.py") == (block,)
    assert read_plain_blocks(b"# RiskAnnotation\n# says what may fail\n", "c.py") == ()
