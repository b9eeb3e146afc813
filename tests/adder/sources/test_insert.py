import ast
import sys

import pytest
from lossless import insert_everywhere

from tracerisk.adder.blocks.block import RiskBlock
from tracerisk.adder.blocks.values import computed_count, computed_next
from tracerisk.adder.sources.insert import insert_blocks, strip_blocks
from tracerisk.adder.sources.read import read_blocks
from tracerisk.errors import BlockError, InputError, UnsafeRewriteError

SIGN = "<block>"


def short_block(name: str, sequence: int = 1) -> RiskBlock:
    return RiskBlock(name, computed_count(sequence), computed_next({"done": 1}), ())


def expand(text: str, name: str) -> str:
    """Replace each line that holds the sign by the block, indented and ended as that line."""
    lines = []
    for line in text.splitlines(keepends=True):
        before, sign, after = line.partition(SIGN)
        if sign:
            content = (
                "RiskAnnotation",
                "@Function {",
                f"  name = {name}",
                "  callSequence = 1",
                "  next = done 1",
                "}",
            )
            lines += [f"{before}# | {part}{after}" for part in content]
        else:
            lines.append(line)
    return "".join(lines)


def check(name: str, after: str, encoding: str = "utf-8", lines=None) -> None:
    """Insert the block of `name` into `after` without its sign; expect `after`; take it out."""
    before = "".join(line for line in after.splitlines(keepends=True) if SIGN not in line)
    source, expected = before.encode(encoding), expand(after, name).encode(encoding)
    blocks = {name: short_block(name)}
    assert insert_blocks(source, blocks, "c.py", lines) == expected
    assert insert_blocks(expected, blocks, "c.py") == expected
    assert strip_blocks(expected, "c.py") == source
    assert insert_blocks(expected, {name: None}, "c.py") == source
    assert ast.dump(ast.parse(source)) == ast.dump(ast.parse(expected))


CASES = {
    "before the docstring": ("f", 'def f():\n    <block>\n    """Do."""\n    return 1\n'),
    "before a comment": ("f", "def f():  # why\n    <block>\n\n    # first\n    return 1\n"),
    "after a signature over lines": (
        "f",
        "def f(\n    a=(1,\n       2),\n) -> int:\n    <block>\n    return 1\n",
    ),
    "under decorators": ("f", "@a\n@b(\n  1)\nasync def f():\n  <block>\n  return 1\n"),
    "in a method": ("A.f", "class A:\n\tdef f(self):\n\t\t<block>\n\t\tpass\n"),
    "in a class within a function": (
        "g.<locals>.A.f",
        "def g():\n  class A:\n    def f(self):\n      <block>\n      pass\n",
    ),
    "in a nested function": (
        "f.<locals>.g",
        "def f():\n    def g():\n        <block>\n        pass\n    return g\n",
    ),
    "before a decorated inner function": (
        "f",
        "def f():\n    <block>\n    @a\n    def g(): pass\n    return g\n",
    ),
    "in a branch": ("f", "match a:\n  case 1:\n    def f():\n      <block>\n      pass\n"),
    "with carriage returns": ("f", "def f():\r\n    <block>\r\n    pass\r\n"),
    "with lone carriage returns": ("f", "def f():\r    <block>\r    pass\r"),
    "with mixed line ends": ("f", "x = 1\r\ndef f():\n    <block>\n    pass\r\n"),
    "without a last newline": ("f", "def f():\n    <block>\n    pass"),
    "with a form feed": ("f", "\x0cx = 1\n\x0cdef f():\n    <block>\n    pass\n"),
    "after a header with a continuation": ("f", "def f() \\\n  :\n    <block>\n    pass\n"),
    "where libcst loses a space": (
        "f",
        "try:\n    pass\nexcept X :\n    pass\ndef f():\n    <block>\n    return 1\n",
    ),
    "where libcst cannot parse": ("f", "(x): int = 1\ndef f(\n):\n    <block>\n    pass\n"),
    "above a one-line function": ("f", "x = 1\n<block>\ndef f(): return 1\n"),
    "above a one-line method under its decorator": (
        "A.f",
        "class A:\n    @property\n    <block>\n    def f(self): return 1; pass  # short\n",
    ),
    "above a one-line function over two lines": ("f", "<block>\ndef f(\n  a): return 1\n"),
    "above a one-line function at the end": ("f", "x = 1\r\n<block>\r\ndef f(): return 1"),
    "in the last of equal names": (
        "f",
        "if a:\n    def f():\n        pass\nelse:\n    def f():\n        <block>\n        pass\n",
    ),
    "in a script": ("<module>", "<block>\nmove()\n"),
    "in a script after its first lines": (
        "<module>",
        "#!/usr/bin/env python3\n# -*- coding: utf-8 -*-\n<block>\n# Licence\nmove()\n",
    ),
    "in a script before its docstring": (
        "<module>",
        '#!x\n<block>\n"""Move."""\n\nfrom __future__ import annotations\nmove()\n',
    ),
    "in a script whose docstring shares its line": ("<module>", '<block>\n"""Move."""; move()\n'),
    "in a script that begins with a function": ("<module>", "<block>\ndef f(): pass\n"),
    "in a script with a byte order mark": ("<module>", "\ufeff#!x\n<block>\nmove()\n"),
}


@pytest.mark.parametrize("case", sorted(CASES))
def test_a_block_goes_in_and_comes_out_without_a_trace(case: str) -> None:
    name, after = CASES[case]
    check(name, after)


def test_a_block_at_the_very_top_stays_behind_the_byte_order_mark() -> None:
    source = b"\xef\xbb\xbfmove()\n"
    after = insert_blocks(source, {"<module>": short_block("<module>")}, "c.py")
    assert after.startswith(b"\xef\xbb\xbf# | RiskAnnotation\n")
    assert strip_blocks(after, "c.py") == source


@pytest.mark.parametrize("encoding", ["latin-1", "cp1251", "shift_jis", "gb18030"])
def test_the_encoding_of_the_file_is_kept(encoding: str) -> None:
    word = {"latin-1": "é", "cp1251": "я"}.get(encoding, "表")
    check("f", f"# coding: {encoding}\ndef f():\n    <block>\n    return '{word}'\n", encoding)


def test_a_line_says_which_of_equal_names_is_meant() -> None:
    after = "if a:\n    def f():\n        <block>\n        pass\nelse:\n    def f(): pass\n"
    check("f", after, lines={"f": 2})


def test_a_block_moves_to_the_definition_that_the_line_says() -> None:
    source = b"if a:\n    def f():\n        pass\nelse:\n    def f():\n        pass\n"
    blocks = {"f": short_block("f")}
    last = insert_blocks(source, blocks, "c.py")
    first = insert_blocks(last, blocks, "c.py", {"f": 2})
    assert first == insert_blocks(source, blocks, "c.py", {"f": 2})
    assert first != last


def test_a_block_is_replaced_and_others_are_left_as_a_person_spaced_them() -> None:
    source = expand("def f():\n  <block>\n  pass\ndef g():\n  <block>\n  pass\n", "f").encode()
    source = source.replace(
        b"def g():\n  # | RiskAnnotation\n", b"def g():\n  # |  RiskAnnotation\n"
    )
    head, tail = source.split(b"def g")
    source = head + b"def g" + tail.replace(b"name = f", b"name  =  g")
    after = insert_blocks(source, {"f": short_block("f", 7)}, "c.py")
    assert after == source.replace(b"callSequence = 1", b"callSequence = 7", 1)


@pytest.mark.parametrize("between", ["\n\n", "\n# a word\n\n", "@a\n\n@b\n"])
def test_a_block_apart_from_its_function_on_one_line_stays_where_it_is(between) -> None:
    source = expand(f"import os\n<block>\n{between}def f(): pass\n", "f").encode()
    after = insert_blocks(source, {"f": short_block("f", 7)}, "c.py")
    assert after == source.replace(b"callSequence = 1", b"callSequence = 7", 1)
    assert strip_blocks(after, "c.py").decode() == f"import os\n{between}def f(): pass\n"


def test_every_function_of_a_file_may_take_a_block_at_once() -> None:
    source = b"def f():\n    def g(): pass\n    def f(): pass\ndef f(): pass\n"
    sites = [("f", 1), ("f.<locals>.g", 2), ("f.<locals>.f", 3), ("f", 4), ("<module>", 1)]
    after = insert_everywhere(source, {site: short_block(site[0]) for site in sites}, "c.py")
    assert after.count(b"RiskAnnotation") == 5
    assert strip_blocks(after, "c.py") == source


def test_reasons_wrap_to_the_room_beside_the_indentation(read_block) -> None:
    block = read_block(
        f"RiskAnnotation\n@Function := {{ ! {'because ' * 40}\nname = f.<locals>.g\n"
        "callSequence = 1\n}"
    )
    source = b"def f():\n" + b" " * 12 + b"def g():\n" + b" " * 24 + b"pass\n"
    after = insert_blocks(source, {"f.<locals>.g": block}, "c.py")
    assert max(map(len, after.splitlines())) <= 79
    assert strip_blocks(after, "c.py") == source


def test_an_unknown_function_is_an_error_that_lists_those_there_are() -> None:
    with pytest.raises(InputError) as caught:
        insert_blocks(b"def place(): pass\n", {"plase": short_block("plase")}, "c.py")
    assert str(caught.value) == (
        "c.py: there is no function plase to annotate; did you mean 'place'? "
        "allowed: <module>, place"
    )


def test_a_block_under_another_name_is_an_error() -> None:
    with pytest.raises(InputError, match=r"c\.py:1: the risk block of `g` is meant for `f`"):
        insert_blocks(b"def f(): pass\n", {"f": short_block("g")}, "c.py")


def test_a_comment_that_reads_like_a_block_line_is_refused() -> None:
    source = b"def f():\n    # | a | b |\n    pass\n"
    with pytest.raises(UnsafeRewriteError, match="not be distinguished from a comment beside it"):
        insert_blocks(source, {"f": short_block("f")}, "c.py")


@pytest.mark.parametrize(
    "source",
    [
        b"x = 1\n\\\ndef f(): pass\n",
        pytest.param(
            b"type A[*T = *\n    # a comment\n    int] = int\n\n\ndef f():\n    pass\n",
            marks=pytest.mark.skipif(sys.version_info < (3, 13), reason="of Python 3.13"),
        ),
    ],
)
def test_a_function_whose_line_libcst_miscounts_gets_its_block(source) -> None:
    after = insert_blocks(source, {"f": short_block("f")}, "c.py")
    assert [placed.function for placed in read_blocks(after, "c.py")] == ["f"]
    assert strip_blocks(after, "c.py") == source


def test_a_character_that_the_encoding_lacks_is_refused(read_block) -> None:
    block = read_block("RiskAnnotation\n@Function := { ! façade\nname = f\ncallSequence = 1\n}")
    with pytest.raises(UnsafeRewriteError, match="the file's encoding ascii cannot write"):
        insert_blocks(b"# coding: ascii\ndef f():\n  pass\n", {"f": block}, "c.py")


def test_a_file_with_a_bad_block_is_not_rewritten() -> None:
    with pytest.raises(BlockError, match=r"c\.py:2"):
        strip_blocks(b"def f():\n    # | RiskAnnotation\n    pass\n", "c.py")
