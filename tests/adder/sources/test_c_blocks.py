"""Risk blocks in C and C++: put in at the right place, read back, taken out to the byte."""

import time

import pytest
from lossless import insert_everywhere

from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.adder.blocks.values import computed_count
from tracerisk.adder.sources.insert import in_form, insert_blocks, strip_blocks
from tracerisk.adder.sources.placed import MisplacedBlockError
from tracerisk.adder.sources.read import block_lines, read_blocks
from tracerisk.adder.sources.renames import follow_renames
from tracerisk.common.function_ref import QualifiedName
from tracerisk.errors import BlockError, InputError, SourceError, UnsafeRewriteError
from tracerisk.instrument.source.c_tokens import code_of

pytest.importorskip("tree_sitter_cpp", reason="the extra cpp is not installed")

from tracerisk.adder.sources.c_source import parse_c

SOURCE = """\
#include <ros/ros.h>
#define TWICE(x) do { x; \\
  x; } while (0)

namespace cell {

class Robot {
 public:
  Robot() : arm_("arm") {
    arm_.move();
  }
  bool ok() const { return ok_; }
  void place();
};

// Puts it down.
void Robot::place()
{ /* begins here
     and ends here */ int x = 1'000;
  hand_.open();
}

}  // namespace cell

template <typename T>
T twice(T a) { return a + a; }

extern "C" {
static inline int *find(int (*wanted)(int), const char* text = "{ /***")
try {
  auto here = [&](int x) { return wanted(x); };
  const char* raw = R"x(
    } /*** @Function { )x";
  return 0;
} catch (...) { return 0; }
}

int main() {
}
"""
NAMES = ["cell::Robot::Robot", "cell::Robot::ok", "cell::Robot::place", "twice", "find", "main"]


def block(name, rank=1, **more):
    return RiskBlock(QualifiedName(name), computed_count(rank), None, (), **more)


def blocks(names=NAMES):
    return {QualifiedName(name): block(name, rank) for rank, name in enumerate(names, start=1)}


@pytest.mark.parametrize("file", ["a.cpp", "a.hpp", "a.ino"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_a_block_in_each_function_and_out_again(file, newline, mark):
    source = (mark + SOURCE).replace("\n", newline).encode()
    annotated = insert_blocks(source, blocks(), file)
    assert strip_blocks(annotated, file) == source
    assert {
        each.function: each.block.call_sequence.value for each in read_blocks(annotated, file)
    } == {name: rank for rank, name in enumerate(NAMES, start=1)}
    assert insert_blocks(annotated, blocks(), file) == annotated
    assert annotated.count(newline.encode()) == annotated.count(b"\n") or newline == "\n"


def lines_with(name, source=SOURCE):
    annotated = insert_blocks(source.encode(), blocks([name]), "a.cpp").decode()
    lines = annotated.split("\n")
    at = next(i for i, line in enumerate(lines) if line.strip() == "/***")
    end = next(i for i, line in enumerate(lines) if line.strip() == "***/")
    return lines[at - 1], lines[at:end], lines[end + 1]


@pytest.mark.parametrize(
    ("name", "before", "after", "indent"),
    [
        ("cell::Robot::Robot", '  Robot() : arm_("arm") {', "    arm_.move();", 4),
        ("cell::Robot::ok", "  }", "  bool ok() const { return ok_; }", 2),
        ("cell::Robot::place", "     and ends here */ int x = 1'000;", "  hand_.open();", 2),
        ("twice", "", "template <typename T>", 0),
        ("find", "try {", "  auto here = [&](int x) { return wanted(x); };", 2),
        ("main", "int main() {", "}", 2),
    ],
)
def test_it_stands_at_the_top_of_the_body_or_above_a_body_of_one_line(name, before, after, indent):
    above, lines, below = lines_with(name)
    assert (above, below) == (before, after)
    assert all(line.startswith(" " * indent) for line in lines)
    assert not lines[0].startswith(" " * (indent + 1))


@pytest.mark.parametrize("between", ["\n\n", "// a word\n", "\n/* a\n word */\n\n// b\n"])
def test_blank_lines_and_comments_may_follow_a_block_above_a_function(between):
    source = "int a;\nvoid f() { go(); }\n"
    annotated = insert_blocks(source.encode(), blocks(["f"]), "a.cpp")
    apart = annotated.replace(b" ***/\n", f" ***/\n{between}".encode())
    assert [each.function for each in read_blocks(apart, "a.cpp")] == ["f"]
    assert insert_blocks(apart, blocks(["f"]), "a.cpp") == apart
    assert strip_blocks(apart, "a.cpp").decode() == source.replace("void", f"{between}void")


def test_its_form_is_the_published_one():
    _, lines, _ = lines_with("main")
    assert lines == [
        "  /***",
        "   * RiskAnnotation",
        "   * @Function {",
        "   *   name = main",
        "   *   callSequence = 1",
        "   * }",
    ]


def test_a_pinned_reason_that_would_end_the_comment_is_refused():
    pinned = Field(1, "1", pinned=True, reason="see */ there")
    with pytest.raises(UnsafeRewriteError, match="would end its comment"):
        insert_blocks(
            SOURCE.encode(),
            {QualifiedName("main"): RiskBlock(QualifiedName("main"), pinned, None, ())},
            "a.cpp",
        )


def test_a_function_behind_other_code_on_its_line_is_refused_where_its_body_is_too():
    with pytest.raises(UnsafeRewriteError, match="no place for the risk block"):
        insert_blocks(b"int x; int f() { return x; }\n", blocks(["f"]), "a.cpp")


def test_what_a_macro_continues_is_left_alone():
    source = b"#define ONE \\\n  1\n#define F \\\nint f() { return 1; }\nint g() {\n  F();\n}\n"
    assert [each.name for each in parse_c(source, "a.cpp").functions] == ["g"]
    assert strip_blocks(insert_blocks(source, blocks(["g"]), "a.cpp"), "a.cpp") == source


def test_a_body_whose_first_line_goes_on_takes_the_block_below():
    source = b"int f() { \\\n  int x = 1;\n  return x;\n}\n"
    annotated = insert_blocks(source, blocks(["f"]), "a.cpp").decode().split("\n")
    assert annotated[2] == "  /***"


def test_a_short_name_reports_the_only_function_around():
    source = SOURCE.encode()
    annotated = insert_blocks(source, blocks(["cell::Robot::place"]), "a.cpp")
    by_hand = annotated.replace(b"name = cell::Robot::place", b"name = place")
    assert [each.function for each in read_blocks(by_hand, "a.cpp")] == ["cell::Robot::place"]


def test_a_block_under_another_name_is_reported_with_the_function_that_it_is_in():
    annotated = insert_blocks(SOURCE.encode(), blocks(["main"]), "a.cpp")
    with pytest.raises(MisplacedBlockError, match="`name = main`"):
        read_blocks(annotated.replace(b"name = main", b"name = other"), "a.cpp")


def test_a_block_outside_all_functions_is_refused():
    text = b"/***\n * @Function {\n *   name = f\n *   callSequence = 1\n * }\n ***/\nint x;\n"
    with pytest.raises(BlockError, match="where no function is"):
        read_blocks(text, "a.cpp")


def test_two_blocks_in_one_comment_are_refused():
    annotated = insert_blocks(SOURCE.encode(), blocks(["main"]), "a.cpp")
    one = b"   * @Function {\n   *   name = main\n   *   callSequence = 1\n   * }\n"
    with pytest.raises(BlockError, match="several risk blocks"):
        read_blocks(annotated.replace(one, one + one), "a.cpp")


def test_code_on_a_line_of_a_block_is_not_taken_out_with_it():
    annotated = insert_blocks(SOURCE.encode(), blocks(["main"]), "a.cpp")
    with pytest.raises(BlockError, match="lines of its own"):
        strip_blocks(annotated.replace(b"   ***/\n}", b"   ***/ go();\n}"), "a.cpp")


def test_the_star_of_an_operator_is_part_of_its_name():
    source = b"struct A {\n  int operator*(int x) {\n    return x;\n  }\n};\n"
    annotated = insert_blocks(source, blocks(["A::operator*"]), "a.cpp")
    assert [each.function for each in read_blocks(annotated, "a.cpp")] == ["A::operator*"]
    assert strip_blocks(annotated, "a.cpp") == source


@pytest.mark.parametrize(
    ("declared", "name"),
    [
        ("Step::operator double() const", "Step::operator_double"),
        ("template <class T> Box<T> Box<T>::operator*(const Box<T> &)", "Box::operator*"),
        ("template <class T> Box<T>::operator std::vector<T>()", "Box::operator_std::vector"),
        ("arm::Cell::operator bool()", "arm::Cell::operator_bool"),
    ],
)
def test_an_operator_defined_apart_from_its_class_is_named_as_within(declared, name):
    (function,) = parse_c(f"{declared} {{\n  go();\n}}\n".encode(), "a.cpp").functions
    assert function.name == name


def test_overloads_have_a_block_each_where_that_is_asked():
    source = b"void f(int a) {\n  go();\n}\nvoid f(double a) {\n  go();\n}\n"
    both = {(QualifiedName("f"), 1): block("f"), (QualifiedName("f"), 4): block("f", 2)}
    annotated = insert_everywhere(source, both, "a.cpp")
    assert annotated.count(b"@Function") == 2
    with pytest.raises(BlockError, match="two risk blocks"):
        read_blocks(annotated, "a.cpp")
    assert strip_blocks(annotated, "a.cpp") == source
    # Of one block for the name the last definition has it.
    assert insert_blocks(source, blocks(["f"]), "a.cpp").index(b"@Function") > source.index(b"dou")


def test_an_unknown_function_is_reported_with_those_there_are():
    with pytest.raises(InputError, match=r"no function mian.*did you mean 'main'"):
        insert_blocks(SOURCE.encode(), blocks(["mian"]), "a.cpp")


def test_a_function_that_cannot_be_read_is_reported_with_the_place():
    source = b"int f() {\n}\nint g() {\n  MACRO\n}\n"
    with pytest.raises(
        InputError, match=r"no function g .*from line 5 on something cannot be read"
    ):
        insert_blocks(source, blocks(["g"]), "a.cpp")


@pytest.mark.parametrize(
    ("source", "file", "message"),
    [
        (b"int f() {\n}\n", "a.java", "not a C or C"),
        (b"int f() {\n\0}\n", "a.cpp", "zero byte"),
    ],
)
def test_what_is_no_c_is_refused(source, file, message):
    with pytest.raises(SourceError, match=message):
        insert_blocks(source, blocks(["f"]), file)


@pytest.mark.parametrize(
    "source",
    [
        b"",
        b"}}}} ((( \n",
        b"int f() {\n",
        b"void f(\n",
        b'R"x(\n',
        b"/* never closed",
        b"int f() { '\n}\n",
        b"\xff\xfe\n int f() {\n}\n",
        b"#if A\nint f() {\n#else\nint f(int x) {\n#endif\n  return 1;\n}\n",
    ],
)
def test_broken_sources_lose_nothing(source):
    names = {each.name for each in parse_c(source, "a.cpp").functions}
    for name in names:
        try:
            annotated = insert_blocks(source, blocks([name]), "a.cpp")
        except UnsafeRewriteError:
            continue
        assert strip_blocks(annotated, "a.cpp") == source
    assert strip_blocks(source, "a.cpp") == source


def test_the_lines_of_blocks_are_reported():
    annotated = insert_blocks(SOURCE.encode(), blocks(["main"]), "a.cpp")
    first = annotated.decode().split("\n").index("  /***") + 1
    assert block_lines(annotated, "a.cpp") == tuple(range(first, first + 7))


def test_a_source_of_c_may_use_words_of_cpp():
    source = b"int class(int new) {\n  return new;\n}\n"
    annotated = insert_blocks(source, blocks(["class"]), "a.c")
    assert strip_blocks(annotated, "a.c") == source


@pytest.mark.parametrize(
    "part",
    [
        'R"(x',
        '"""a',
        '"\\',
        "'",
        "/*",
        "{",
        "int f(){",
        "int f(){}",
        " ",
        " \n",
        "f(",
        "1'",
        "#if A\n",
    ],
)
def test_a_source_of_any_text_is_read_in_time_that_grows_with_it(part):
    """Forty kilobytes took minutes where the end of each literal was looked for by backtracking."""
    source = (part * (40_000 // len(part))).encode()
    began = time.monotonic()
    strip_blocks(source, "a.cpp")
    parse_c(source, "a.cpp")
    code_of(source)
    assert time.monotonic() - began < 5.0


@pytest.mark.parametrize(
    ("source", "same"),
    [
        (b"int x = 1; // one\n", b"int x = 1;\n"),
        (b"int  x =\t1;\n\n\n", b"int x = 1;\n"),
        (b"int x /* of\nits own */ = 1;\n", b"int x = 1;\n"),
        (b'auto s = R"(a // b)";\r\n', b'auto s = R"(a // b)";\n'),
    ],
)
def test_what_a_source_says_leaves_out_comments_and_spaces(source, same):
    assert code_of(source) == code_of(same)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (b'f("a  b");', b'f("a b");'),
        (b'f("a // b");', b'f("a");'),
        (b'auto s = R"(a /* b */)";', b'auto s = R"(a )";'),
        (b"#define A 1\nint x;", b"#define A 1 int x;"),
        (b"f(1'000);", b"f(1'001);"),
        (b"f('\"'); // x", b"f('\"'); g(); // x"),
    ],
)
def test_what_a_source_says_has_all_that_counts(one, other):
    assert code_of(one) != code_of(other)


def test_the_compact_form_is_written_read_converted_and_taken_out():
    published = insert_blocks(SOURCE.encode(), blocks(), "a.cpp")
    compact = in_form(published, "a.cpp", "compact")
    assert compact.count(b"@Function") == 1, "the text of a string"
    assert compact.count(b"   * cell::Robot::place 3\n") == 1
    assert [placed.block for placed in read_blocks(compact, "a.cpp")] == [
        placed.block for placed in read_blocks(published, "a.cpp")
    ]
    assert len(block_lines(compact, "a.cpp")) == 4 * len(NAMES)
    assert in_form(compact, "a.cpp", "published") == published
    assert strip_blocks(compact, "a.cpp") == SOURCE.encode()


COMPACT = """\
void pick() {
  /***
   * RiskAnnotation
   * pick 1 -> done 1
   * arm  := 1e-8  2  ! bench
   *   ! test
   ***/
  move();
}
"""


def test_a_compact_block_reaches_to_the_end_of_its_comment():
    (placed,) = read_blocks(COMPACT.encode(), "a.cpp")
    (arm,) = placed.block.components
    assert (arm.probability.reason, arm.probability.location.line) == ("bench test", 5)
    more = COMPACT.replace("   *   ! test\n", "   *\n   * hand 1e-7 1\n")
    (placed,) = read_blocks(more.encode(), "a.cpp")
    assert [entry.name for entry in placed.block.components] == ["arm", "hand"]
    prose = COMPACT.replace("! test", "Mind the rack, please.").encode()
    with pytest.raises(BlockError, match=r"cannot read `Mind the rack, please\.` as a component"):
        read_blocks(prose, "a.cpp")


@pytest.mark.parametrize("text", ["RiskAnnotation", "RiskAnnotation\n * is what we write here"])
def test_a_comment_that_speaks_of_blocks_is_none(text):
    assert read_blocks(f"/* {text} */\nint main() {{\n}}\n".encode(), "a.cpp") == ()


def test_a_compact_block_follows_a_renamed_function():
    blocks_of = {QualifiedName("Robot::operator->"): block("Robot::operator->")}
    source = b"struct Robot {\n  int operator->() {\n    return 1;\n  }\n};\n"
    written = insert_blocks(source, blocks_of, "a.cpp")
    compact = in_form(written, "a.cpp", "compact").replace(b"operator->()", b"operator+()")
    known = [QualifiedName("Robot::operator->")]
    followed = follow_renames(compact, "a.cpp", known)
    assert followed.renamed == {"Robot::operator->": "Robot::operator+"}
    assert [placed.block.name for placed in followed.placed] == ["Robot::operator+"]
