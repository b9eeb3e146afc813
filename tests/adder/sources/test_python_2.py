"""Blocks in sources of Python 2: lines go in and come out, and no other byte changes."""

import ast
from pathlib import Path

import pytest
from lossless import check

from tracerisk.adder.sources.functions import functions_in
from tracerisk.adder.sources.insert import insert_blocks, strip_blocks
from tracerisk.errors import SourceError
from tracerisk.instrument.source.python_source import is_python_2

from .test_insert import expand, short_block
from .test_laws import standard_library

CASES = {
    "tabs after spaces": (
        "A.f",
        "class A:\n    def f(self):\n\t<block>\n\tprint self\n\n    def g(self): print 1\n",
    ),
    "a header over lines": (
        "f",
        "def f(a, (b, c),\n      d=0777):\n  <block>\n  print `a`, # why\n",
    ),
    "before a docstring": ("f", 'def f():\n\t<block>\n\t"""Print\n\ta tab."""\n\tprint "x"\n'),
    "nested": (
        "f.<locals>.g",
        "def f():\n  def g(x):\n    <block>\n    # first\n    exec x\n  raise E, 'x'\n",
    ),
    "line ends of another system": ("f", "def f():\r\n    <block>\r\n    print 1\r\nf()\r\n"),
    "the module": ("<module>", "#!/usr/bin/env python\n<block>\nprint 1\n"),
    "names alone": ("f", "def f():\n    <block>\n    return raw_input()\n"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_block_goes_in_and_comes_out(name):
    function, after = CASES[name]
    before = "".join(line for line in after.splitlines(keepends=True) if "<block>" not in line)
    source, expected = before.encode(), expand(after, function).encode()
    assert is_python_2(source)
    assert insert_blocks(source, {function: short_block(function)}, "c.py") == expected
    assert strip_blocks(expected, "c.py") == source
    assert function in dict(functions_in(expected, "c.py"))


def test_many_sources_keep_every_byte(tmp_path: Path):
    """The standard library, in files that a `print` at their end makes sources of Python 2."""
    outcomes = []
    library = [path for path in standard_library() if "test" not in path.parts]
    for number, path in enumerate(library[::25]):
        source = path.read_bytes()
        if b"f'" in source or b'f"' in source or len(source) > 20_000:
            continue
        copy = tmp_path / f"{number}.py"
        copy.write_bytes(source.replace(b"        ", b"\t") + b"\nprint 'the end'\n")
        if is_python_2(copy.read_bytes()):
            outcomes.append(check(copy))
    assert {outcome.verdict for outcome in outcomes} == {"exact"}
    assert len(outcomes) >= 8
    assert sum(outcome.functions for outcome in outcomes) > 30


def test_what_cannot_be_converted_is_refused_with_its_place():
    source = b"def f():\n    print 'x'\n    if x = 1: pass\n"
    with pytest.raises(SourceError, match="at line 3: Python 2 cannot read it either") as caught:
        functions_in(source, "c.py")
    assert str(caught.value).startswith("c.py:2:5: this is Python 2")
    with pytest.raises(SyntaxError):
        ast.parse(source)
