"""Columns and qualified names, which Python 3.10 does not keep itself."""

import ast
import sys
import textwrap
from types import CodeType

import pytest

from tracerisk.instrument.code_positions import (
    compile_with_positions,
    qualified_name,
    source_position,
)


def run(source: str) -> list[tuple[int | None, int | None, str]]:
    """Run a program that calls `here()`; return the place and the function of each call."""
    text = textwrap.dedent(source)
    seen = []

    def note(frame):
        name = qualified_name(frame.f_code, frame.f_globals)
        seen.append((*source_position(frame.f_code, frame.f_lasti), name))

    class Chain:
        def __call__(self, *values, **named):
            note(sys._getframe(1))
            return self

        @property
        def shown(self):
            note(sys._getframe(1))
            return self

        def here(self, *values, **named):
            note(sys._getframe(1))
            return self

    here = Chain()
    exec(compile_with_positions(ast.parse(text), "<program>"), {"here": here})
    return seen


def test_two_calls_on_one_line_have_columns_of_their_own():
    assert run("here(); here()") == [(1, 0, "<module>"), (1, 8, "<module>")]


def test_a_call_within_a_call_has_its_own_column():
    assert run("here(here(), here())") == [
        (1, 5, "<module>"),
        (1, 13, "<module>"),
        (1, 0, "<module>"),
    ]


def test_a_method_on_a_line_of_its_own_is_at_its_name():
    source = """\
    x = (here()
         .here(1)
         .here(a=2)
         .shown)
    """
    assert run(source) == [
        (1, 5, "<module>"),
        (2, 6, "<module>"),
        (3, 6, "<module>"),
        (4, 6, "<module>"),
    ]


def test_starred_calls_and_calls_over_many_lines_are_at_their_begin():
    source = """\
    here(
        *[1],
        **{},
    )
    """
    assert run(source) == [(1, 0, "<module>")]


@pytest.mark.parametrize(
    "statement",
    [
        "for i in range(2):\n    if i: continue\n    here()",
        "while 1:\n    here()\n    break",
        "try:\n    here()\nfinally:\n    pass",
        "try:\n    pass\nfinally:\n    here()",
        "if 1:\n    pass\nelse:\n    pass\nhere()",
        "x = 1 if here() else 2",
        "assert here()",
        "y = [here() for _ in range(1)]",
        "(lambda: here())()",
    ],
)
def test_each_statement_keeps_line_and_column_of_the_call(statement):
    lines = statement.split("\n")
    expected = next((i, line.index("here()")) for i, line in enumerate(lines, 1) if "here" in line)
    assert [place[:2] for place in run(statement)] == [expected]


def test_names_are_qualified_by_classes_and_functions():
    source = """\
    class Arm:
        def move(self):
            def step():
                here()
            step()
            (lambda: here())()
        class Tool:
            here()
    Arm().move()
    """
    assert [name for *_, name in run(source)] == [
        "Arm.Tool",
        "Arm.move.<locals>.step",
        "Arm.move.<locals>.<lambda>",
    ]


def test_an_empty_module_compiles():
    assert isinstance(compile_with_positions(ast.parse(""), "<program>"), CodeType)


def test_functions_of_a_library_are_named_by_its_module():
    def frames():
        yield sys._getframe()

    import threading

    code = threading.Thread.join.__code__
    assert qualified_name(code, vars(threading)) == "Thread.join"
    assert qualified_name(frames.__code__, {}).endswith("frames")
