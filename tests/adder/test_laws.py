"""The laws of insertion and removal, on generated sources and on the standard library."""

from __future__ import annotations

import ast
import sysconfig
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.adder.block import ComponentEntry, RiskBlock
from tracerisk.adder.definitions import MODULE, definitions, module_line, parse_python
from tracerisk.adder.insert import insert_blocks, insert_everywhere, strip_blocks
from tracerisk.adder.read import scan_blocks
from tracerisk.adder.values import (
    computed_count,
    computed_flag,
    computed_next,
    computed_probability,
)
from tracerisk.errors import SourceError

STANDARD_LIBRARY = Path(sysconfig.get_path("stdlib"))
SAMPLE_SIZE = 100


def standard_library() -> list[Path]:
    files = sorted(STANDARD_LIBRARY.rglob("*.py"))
    return [path for path in files if "site-packages" not in path.parts]


def sample() -> list[Path]:
    """Every n-th file below 60 kB, so that all corners of the library are there."""
    small = [path for path in standard_library() if path.stat().st_size < 60_000]
    return small[:: max(1, len(small) // SAMPLE_SIZE)][:SAMPLE_SIZE]


def block_for(name: str, sequence: int = 1) -> RiskBlock:
    power = ComponentEntry(
        "power", computed_probability(6.674e-08), computed_count(2), computed_flag(True)
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


def same_program(one: bytes, other: bytes) -> bool:
    try:
        return ast.dump(ast.parse(one)) == ast.dump(ast.parse(other))
    except RecursionError:
        return compile(one, "", "exec").co_consts == compile(other, "", "exec").co_consts


@pytest.mark.parametrize("path", sample(), ids=lambda path: path.stem)
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


@settings(max_examples=150, deadline=None)
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
