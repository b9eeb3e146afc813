"""`tracerisk docs`: the pages, for those who have no checkout; what messages name is there."""

import ast
import re
from pathlib import Path

import pytest

from tracerisk.cli.set_up.docs import page_names, page_text, section_of

ROOT = Path(__file__).parents[2]
NAMED = re.compile(r"`tracerisk docs ([a-z-]+)(?:#([a-z0-9-]+))?`")


def strings() -> list[tuple[str, str]]:
    """All strings of files that name docs, but docstrings, each with its place."""
    found = []
    for path in sorted((ROOT / "tracerisk").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        if "docs" not in text:
            continue
        tree = ast.parse(text)
        docs = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            is_text = isinstance(node, ast.Constant) and isinstance(node.value, str)
            if is_text and id(node) not in docs:
                found.append((f"{path.relative_to(ROOT)}:{node.lineno}", node.value))
    return found


def test_each_page_is_listed_with_its_title(example):
    outcome = example.run("docs")
    assert outcome.code == 0, outcome.err
    pages = sorted(path.stem for path in (ROOT / "docs").glob("*.md"))
    assert [line.split()[0] for line in outcome.out.splitlines() if line[0] != " "] == pages
    assert re.search(r"^howto-robot +How to: ", outcome.out, re.MULTILINE)
    assert [each["name"] for each in example.run("docs", "--json").json["pages"]] == pages


def test_a_page_is_printed_as_it_is(example):
    for name in ("howto-robot", "docs/howto-robot.md"):
        outcome = example.run("docs", name)
        assert outcome.code == 0, outcome.err
        assert outcome.out == (ROOT / "docs/howto-robot.md").read_text(encoding="utf-8")


def test_a_section_is_printed_alone(example):
    outcome = example.run("docs", "theory#groups")
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith("## Groups\n")
    assert not re.search(r"^## (?!Groups)", outcome.out, re.MULTILINE)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("howto-robots", "did you mean 'howto-robot'?"),
        ("theory#group", "did you mean 'groups'?"),
        ("../README", "allowed: "),
    ],
)
def test_what_is_not_there_is_refused_with_what_is(example, name, said):
    outcome = example.run("docs", name)
    assert outcome.code == 2
    assert said in outcome.err


def test_a_string_names_a_page_as_it_is_read_and_only_pages_that_there_are():
    named = 0
    for place, text in strings():
        assert not re.search(r"\bdocs/[\w-]+\.md", text), f"{place}: {text}"
        for page, section in NAMED.findall(text):
            named += 1
            assert page in page_names(), f"{place}: {text}"
            if section:
                assert section_of(page_text(page), section), f"{place}: {text}"
    assert named > 8
