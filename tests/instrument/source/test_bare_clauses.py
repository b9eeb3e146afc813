"""`except A, b:` without parentheses: of Python 2, or of Python 3.14, whatever Python runs this."""

import sys

import pytest

from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.errors import SourceError
from tracerisk.instrument.source.python_source import is_python_2, parse_source

TRIED = "{}def f():\n    try:\n        g()\n    except{}:\n        {}\n"
IS_3_14 = sys.version_info >= (3, 14)


@pytest.mark.parametrize(
    ("first", "clause", "handler"),
    [
        ("", " ValueError, error", "pass"),
        ("", " ValueError , (e)", "print e"),
        ("", " (ValueError, TypeError), e", "pass"),
        ("e = None\n", " socket.error, e", "pass"),
        ("", " ValueError, Err", "pass"),
        ("", " ValueError, \\\n            e", "pass"),
        # It binds the name of a built-in exception, which the rest of the source shows.
        ("", " ValueError, TypeError", "print 'late'"),
        ("name = raw_input()\n", " ValueError, TypeError", "pass"),
        ("#!/usr/bin/env python2\n", " ValueError, TypeError", "pass"),
    ],
)
def test_a_name_that_is_no_exception_is_given_to_the_caught_one(first, clause, handler):
    assert is_python_2(TRIED.format(first, clause, handler).encode())


CAUGHT = [
    ("", " ValueError, TypeError"),
    ("", " ValueError, TypeError, KeyError"),
    ("", " ValueError, \\\n            TypeError"),
    ("", "* ValueError, TypeError"),
    ("from cell import Late, late\n", " Late, late"),
    ("from cell import *\n", " Late, Early"),
    ("import cell\n", " cell.Late, cell.Early"),
    ("class late(Exception):\n    pass\n", " ValueError, late"),
    ("Both = (KeyError, IndexError)\n", " ValueError, Both"),
    ("#!/usr/bin/env python3\n", " ValueError, e"),
    ('"""\n    except ValueError, e:\n"""\n', " ValueError, TypeError"),
]


@pytest.mark.parametrize(("first", "clause"), CAUGHT)
def test_exceptions_are_caught_alike(first, clause):
    source = TRIED.format(first, clause, "pass").encode()
    assert not is_python_2(source)
    if IS_3_14:
        assert parse_source(source, "cell.py").text == source.decode()


@pytest.mark.skipif(IS_3_14, reason="this Python reads them")
@pytest.mark.parametrize(("first", "clause"), CAUGHT)
def test_an_older_python_says_which_one_reads_them(first, clause):
    source = TRIED.format(first, clause, "pass").encode()
    for parse in (parse_source, parse_python):
        with pytest.raises(SourceError) as raised:
            parse(source, "cell.py")
        is_known = sys.version_info >= (3, 11) or not clause.startswith("*")  # `except*` is of 3.11
        if "python3" not in first and is_known:
            assert "Python 3.14 accepts it" in raised.value.message
            assert "write parentheses" in raised.value.message
        assert "this is Python 2" not in raised.value.message


@pytest.mark.parametrize(
    ("needed", "source"),
    [
        ((3, 12), "def f[T](given: T) -> T:\n    return given\n"),
        ((3, 12), "async def f[*Ts, **P](given):\n    pass\n"),
        ((3, 12), "class Cell[T]:\n    pass\n"),
        ((3, 12), "type Joints = list[float]\n"),
        ((3, 12), "cell = {'a': 1}\nprint(f'{cell['a']}')\n"),
        ((3, 13), "class Cell[T = int]:\n    pass\n"),
        ((3, 14), "x = 1\nprint(t'{x}')\n"),
        ((3, 14), 'x = 1\nprint(rt"{x}")\n'),
    ],
)
def test_newer_syntax_is_read_or_the_python_that_reads_it_named(needed, source):
    version = f"Python {needed[0]}.{needed[1]}"
    for parse in (parse_source, parse_python):
        if sys.version_info >= needed:
            assert parse(source.encode(), "cell.py").tree.body
            continue
        with pytest.raises(SourceError, match=f"install tracerisk under {version}"):
            parse(source.encode(), "cell.py")


def test_what_no_python_reads_names_none():
    with pytest.raises(SourceError) as raised:
        parse_source(b"def f(:\n    pass\n", "cell.py")
    assert "accepts it" not in raised.value.message


def test_brackets_that_no_python_reads_are_refused_at_once(monkeypatch):
    monkeypatch.setattr("tracerisk.instrument.source.python_source._read_python_2", None)
    with pytest.raises(SourceError, match="too many nested parentheses"):
        parse_source(b"x = " + b"[" * 300 + b"]" * 300, "cell.py")


def test_a_refused_conversion_is_not_tried_again(monkeypatch):
    from tracerisk.instrument.source import python_2_text

    source = b"print 'a'\nfor for refused\n"
    assert not is_python_2(source)
    monkeypatch.setattr(python_2_text, "_tool", None)
    with pytest.raises(SourceError, match="cannot be converted"):
        parse_source(source, "cell.py")
