"""The laws of insertion and removal, on generated sources and on the standard library."""

import ast
import os
import sysconfig
from pathlib import Path
from types import CodeType

import pytest
from hypothesis import HealthCheck, given, reject, settings
from hypothesis import strategies as st
from lossless import insert_everywhere

from tests.slow import slow_but_every
from tracerisk.adder.blocks.block import ComponentEntry, RiskBlock
from tracerisk.adder.blocks.values import (
    computed_count,
    computed_next,
    computed_probability,
    computed_redundancy,
)
from tracerisk.adder.sources.insert import in_form, insert_blocks, strip_blocks
from tracerisk.adder.sources.python_lines import module_line, parse_python
from tracerisk.adder.sources.read import scan_blocks
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import SourceError, UnsafeRewriteError
from tracerisk.instrument.source.function_definitions import MODULE, definitions

STANDARD_LIBRARY = Path(sysconfig.get_path("stdlib"))
SAMPLE_SIZE = 100


def standard_library() -> list[Path]:
    found = []
    for folder, folders, names in os.walk(STANDARD_LIBRARY):
        folders[:] = [name for name in folders if name not in ("site-packages", "__pycache__")]
        found += [Path(folder, name) for name in names if name.endswith(".py")]
    return sorted(found)


def sample() -> list[Path]:
    """Every n-th file below 60 kB, so that all corners of the library are there."""
    small = [path for path in standard_library() if path.stat().st_size < 60_000]
    return small[:: max(1, len(small) // SAMPLE_SIZE)][:SAMPLE_SIZE]


def block_for(name: str, sequence: int = 1) -> RiskBlock:
    power = ComponentEntry(
        "power",
        computed_probability(6.674e-08),
        computed_count(2),
        computed_redundancy(Redundancy(True)),
    )
    return RiskBlock(name, computed_count(sequence), computed_next({"a": 9, "done": 1}), (power,))


def check_laws(source: bytes, file: str) -> None:
    """Check them with a block into every function of the source at once."""
    try:
        parsed = parse_python(source, file)
    except SourceError:
        return
    sites = [(d.name, d.line) for d in definitions(parsed.tree)]
    if parsed.tree.body:
        sites.append((MODULE, module_line(parsed)))
    after = insert_everywhere(source, {site: block_for(site[0]) for site in sites}, file)
    assert strip_blocks(after, file) == source
    assert same_program(source, after)
    placed = scan_blocks(parse_python(after, file))
    assert sorted(b.function for b in placed) == sorted(name for name, _ in sites)
    again = {(b.function, b.line): b.block for b in placed}
    assert insert_everywhere(after, again, file) == after
    longer = {site: block_for(site[0], 1000) for site in again}
    assert strip_blocks(insert_everywhere(after, longer, file), file) == source
    assert strip_blocks(source, file) == source
    compact = in_form(after, file, "compact")
    assert len(compact) < len(after) or not sites
    assert strip_blocks(compact, file) == source
    assert in_form(compact, file, "published") == after


def same_program(one: bytes, other: bytes) -> bool:
    try:
        return ast.dump(ast.parse(one)) == ast.dump(ast.parse(other))
    except RecursionError:
        return same_code(compile(one, "", "exec"), compile(other, "", "exec"))


def same_code(one: object, other: object) -> bool:
    """Compare what is compiled, the lines aside, for what nests too deeply to be dumped."""
    if not isinstance(one, CodeType) or not isinstance(other, CodeType):
        return one == other
    parts = ("co_code", "co_names", "co_varnames", "co_freevars", "co_flags", "co_name")
    return (
        all(getattr(one, part) == getattr(other, part) for part in parts)
        and len(one.co_consts) == len(other.co_consts)
        and all(map(same_code, one.co_consts, other.co_consts))
    )


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("path", slow_but_every(10, sample()), ids=lambda path: path.stem)
def test_the_laws_hold_on_a_sample_of_the_standard_library(path: Path) -> None:
    check_laws(path.read_bytes(), str(path))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_the_laws_hold_on_the_whole_standard_library() -> None:
    files = standard_library()
    assert len(files) > SAMPLE_SIZE
    for path in files:
        check_laws(path.read_bytes(), str(path))


def test_a_sum_of_a_thousand_terms_is_no_obstacle() -> None:
    source = b"def f():\n    " + b" + ".join([b"'a'"] * 1500) + b"\n"
    after = insert_blocks(source, {"f": block_for("f")}, "c.py")
    assert after.startswith(b"def f():\n    # | RiskAnnotation\n")
    assert strip_blocks(after, "c.py") == source


newlines = st.sampled_from(["\n", "\r\n", "\r"])
indents = st.sampled_from(["  ", "    ", "\t", " \t"])
headers = st.sampled_from(
    [
        "def {}():",
        "def {}(a, *, b=(1, 2)) -> 'x':",
        "async def {}():  # | RiskAnnotation",
        "def {}(a,\n b='''\n# | RiskAnnotation\n'''):",
        "@property\ndef {}(self):",
        "def {}(  # | RiskAnnotation\n  a=1,\n):",
        "class {}:",
        "def {}() \\\n :",
    ]
)
leads = st.sampled_from(
    ["", "# word\n", "\n", '"""Doc\n# | RiskAnnotation\n"""\n', "'a' 'b'\n", "\n\n# | no block\n\n"]
)


@st.composite
def definitions_text(draw, depth: int = 0):
    name, header = draw(st.sampled_from(["f", "g", "é"])), draw(headers)
    if header.startswith("def") and draw(st.booleans()):
        return header.format(name) + " pass\n"
    body = draw(leads) if depth or header != "class {}:" else ""
    if body.endswith("# | no block\n\n") and draw(st.booleans()):
        body = ""
    inner = draw(definitions_text(depth + 1)) if depth < 2 and draw(st.booleans()) else ""
    body += inner + draw(st.sampled_from(["pass\n", "x = 1; y = 2\n", "return_ = '''\n'''\n"]))
    indent = draw(indents)
    lines = [indent + line if line.strip() else line for line in body.splitlines(keepends=True)]
    return header.format(name) + "\n" + "".join(lines)


@given(
    st.lists(definitions_text(), min_size=1, max_size=3),
    newlines,
    st.sampled_from(["", "#!/bin/x\n", "# coding: latin-1\n", '"""Doc."""\n', "\f\n"]),
    st.booleans(),
    st.booleans(),
)
def test_the_laws_hold_on_generated_sources(
    parts: list[str], newline: str, start: str, mark: bool, cut: bool
) -> None:
    text = start + "".join(parts)
    if cut:
        text = text.rstrip("\n")
    encoding = "latin-1" if "latin-1" in start else "utf-8-sig" if mark else "utf-8"
    source = text.replace("\n", newline).encode(encoding)
    ast.parse(source)
    check_laws(source, "c.py")


# Harder sources: what CPython accepts and people rarely write.

HARD_HEADERS = (
    "def {}():",
    "def {}(a, b=lambda: 0, *, c: 'int' = 1) -> 'x':",
    "def {}(self, a=(1,\n2), # why\n  b='''\n# | RiskAnnotation\n''' ,):",
    "async def {}():  # | RiskAnnotation",
    "def \\\n  {} \\\n (\\\n): ",
    "@overload\ndef {}(a: int) -> int:",
    "@a.b(\n  c=1,\n\n  # | word\n)\n@d\nasync def {}(self):",
    "@staticmethod\n\n# between\ndef {}():",
    "@(lambda f: f)\ndef {} ( ) :",
)
HARD_OPENINGS = (
    "",
    "# first\n",
    "\n\n",
    "\n# | RiskAnnotation of another tool\n",
    "#|no gutter\n",
    '"""Doc\n\n    # | RiskAnnotation\n"""\n',
    "'a' 'b' \\\n 'c'\n",
    "f'{1!s  }' f\"{2 :>{3}}\"\n",
    "r'\\' u'x'; y = 1\n",
    "x = [\n# inside\n1,\n]\n",
    "global z\n",
)
HARD_STATEMENTS = (
    "pass\n",
    "x = 1; y = 2 ;\n",
    "z = \\\n  3\n",
    "try: pass\nexcept (A, B) : pass\nelse : pass\nfinally: pass\n",
    "with a as b, c: pass\n",
    "match x:\n  case 1: pass\n  case {'a': [*_]}: pass\n",
    "s = '''\n# | RiskAnnotation\n# | @Function {\n'''\n",
    "t = 'a' 'b' 'c'  # | @Component {\n",
    "print ( 'x' ) # comment\n",
    "class Empty: x = 1; y = 2\n",
    "x = lambda: 1\n",
    "for i in (): pass\nelse: pass\n",
)
WRAPPERS = (
    "if a:\n{}else:\n{}",
    "if a:\n{}elif b:\n{}",
    "try:\n{}except X :\n{}",
    "try:\n{}finally:\n{}",
    "while a:\n{}else:\n{}",
    "with a, \\\n  b:\n{}if c:\n{}",
    "match a:\n case 1:\n{} case _:\n{}",
    "class A(B, metaclass=C):\n{}class D:\n{}",
)
ON_ONE_LINE = ("pass", "...; x = 1", "return [1,\n2]")
NAMES = (
    "f",
    "g",
    "h\N{LATIN SMALL LETTER E WITH ACUTE}",
    "\N{LATIN SMALL LIGATURE FI}x",
    "__init__",
)


def indented(text: str, indent: str, *, leaves_comments: bool) -> str:
    """Indent the lines of a text; those inside strings, brackets and continuations keep theirs."""
    lines, is_string, depth, is_continued = [], False, 0, False
    for line in text.splitlines(keepends=True):
        is_inside = is_string or depth > 0 or is_continued
        is_comment = line.lstrip().startswith("#")
        keeps = is_inside or not line.strip() or (is_comment and leaves_comments)
        lines.append(line if keeps else indent + line)
        was_string = is_string
        is_string ^= bool((line.count("'''") + line.count('"""')) % 2)
        if not was_string and not is_string:
            bare = line.partition("#")[0]
            depth += sum(bare.count(c) for c in "([{") - sum(bare.count(c) for c in ")]}")
        is_continued = line.endswith("\\\n")
    return "".join(lines)


@st.composite
def hard_functions(draw, depth: int = 0) -> str:
    header = draw(st.sampled_from(HARD_HEADERS)).format(draw(st.sampled_from(NAMES)))
    if draw(st.integers(0, 4)) == 0:
        return f"{header} {draw(st.sampled_from(ON_ONE_LINE))}\n"
    body = draw(st.sampled_from(HARD_OPENINGS)) + draw(st.sampled_from(HARD_STATEMENTS))
    if depth < 2 and draw(st.booleans()):
        body += draw(hard_parts(depth + 1))
    indent = draw(st.sampled_from([" ", "  ", "    ", "\t", "\t ", "        "]))
    return f"{header}\n" + indented(body, indent, leaves_comments=draw(st.booleans()))


@st.composite
def hard_parts(draw, depth: int = 0) -> str:
    kind = draw(st.integers(0, 5))
    if kind == 0:
        return draw(st.sampled_from(HARD_STATEMENTS))
    if kind <= 3 or depth >= 2:
        return draw(hard_functions(depth))
    indent = draw(st.sampled_from(["  ", "    ", "\t"]))
    parts = [indented(draw(hard_parts(depth + 1)), indent, leaves_comments=False) for _ in range(2)]
    return draw(st.sampled_from(WRAPPERS)).format(*parts)


def with_line_ends(draw, text: str) -> str:
    """End the lines in one way, or each in its own."""
    ends = draw(st.sampled_from(["\n", "\r\n", "\r", "mixed"]))
    if ends != "mixed":
        return text.replace("\n", ends)
    chance = draw(st.randoms(use_true_random=False))
    return "".join(chance.choice(["\n", "\r\n"]) if c == "\n" else c for c in text)


ENCODINGS = (
    ("utf-8", ""),
    ("utf-8-sig", ""),
    ("utf-8-sig", "# -*- coding: utf-8 -*-\n"),
    ("latin-1", "# vim: set fileencoding=latin-1 :\n"),
    ("cp1252", "#!/usr/bin/python\n# coding=cp1252\n"),
    ("shift_jis", "# coding: shift_jis\n"),
    ("gb18030", "# coding: gb18030\n"),
)
STARTS = (
    "",
    "\f\n",
    "\n\n",
    "# word\n",
    '"""Doc."""\n',
    "'a' ; x = 1\n",
    "from __future__ import a\n",
)
BETWEEN = ("", "\n", "\f\n", "   \n", "# | word\n\n", "\t\f \n")


@st.composite
def hard_sources(draw) -> bytes:
    encoding, cookie = draw(st.sampled_from(ENCODINGS))
    parts = draw(st.lists(hard_parts(), min_size=1, max_size=4))
    text = cookie + draw(st.sampled_from(STARTS)) + draw(st.sampled_from(BETWEEN)).join(parts)
    if draw(st.booleans()):
        text = text.rstrip("\n")
    # A letter that the encoding lacks becomes one that it has.
    known = "".join(c if c.encode(encoding, "ignore") else "q" for c in text)
    return with_line_ends(draw, known).encode(encoding)


@settings(suppress_health_check=[HealthCheck.filter_too_much])
@given(hard_sources())
def test_the_laws_hold_on_hard_sources(source: bytes) -> None:
    try:
        ast.parse(source)
    except (SyntaxError, ValueError):
        reject()
    check_laws(source, "c.py")


@pytest.mark.slow
@settings(max_examples=2_000, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(hard_sources())
def test_the_laws_hold_on_many_hard_sources(source: bytes) -> None:
    try:
        ast.parse(source)
    except (SyntaxError, ValueError):
        reject()
    check_laws(source, "c.py")


@pytest.mark.parametrize(
    "newline", [b"\n", pytest.param(b"\r\n", marks=pytest.mark.slow)], ids=["LF", "CRLF"]
)
@pytest.mark.parametrize(
    "first",
    [
        b"'a'" + b" 'b'" * 1000,
        b"(" + b"\n    'a'" * 1000 + b")",
        b"'a'" + b" \\\n    'b'" * 1000,
        b"f'{1!s  }'" + b" f'{2}'" * 1000,
        b"x = 'a'" + b" + 'b'" * 1000,
    ],
    ids=["on one line", "in brackets", "continued", "of f-strings", "as a sum"],
)
def test_a_string_of_a_thousand_parts_first_in_a_body_is_no_obstacle(
    first: bytes, newline: bytes
) -> None:
    source = b"def f():\n    " + first + b"\n    return 1\n"
    check_laws(source.replace(b"\n", newline), "c.py")


@pytest.mark.parametrize("comment", ["# | gutter", "# | ", "# |", "#|  gutter"])
def test_a_comment_that_would_run_into_the_block_is_refused_and_the_file_left(comment: str) -> None:
    source = f"def f():\n    {comment}\n    pass\n".encode()
    with pytest.raises(UnsafeRewriteError, match=r"^c\.py"):
        insert_blocks(source, {"f": block_for("f")}, "c.py")
