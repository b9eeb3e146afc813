"""The text that users read: plain English, in the field's own words."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCES = sorted((ROOT / "tracerisk").rglob("*.py"))
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]

# What native engineers stumbled over, and what to write instead.
INSTEAD = {
    "may be given again": "repeatable",
    "else told by": "default: inferred from",
    "else looked for": "default: searched for",
    "how sure": "uncertainty",
    "within the noise too": "also ... that changed by less than 1 %",
    "person's edit is in the way": "conflicting manual edit",
    "person's edit in the way": "conflicting manual edit",
    "fault of tracerisk": "internal error",
    "stands twice": "duplicate",
    "fails through hardware with probability": "probability that a hardware failure ends",
    "visits as they ran": "as executed",
    "told as": "reported as",
    "made anew": "recomputed",
    "whole groups": "all redundant units working",
    "slip of the pen": "misspelt",
    "must not be told from": "plain words",
    "is no state": "unknown state, or: is not a state",
    "is no pose": "not a valid pose",
    "is no probability": "is not a probability",
}
# Comments are for who works on the code; strings and docstrings are read by users.
UNPLAIN = re.compile("|".join(map(re.escape, INSTEAD)))
OPENINGS = re.compile(r"(?:Tell|Say|Have|Let)\b")


@pytest.mark.parametrize("words", INSTEAD)
def test_the_documentation_has_the_plain_words(words):
    found = [
        f"{path.relative_to(ROOT)}:{number}: write '{INSTEAD[words]}'"
        for path in PAGES
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if words in line
    ]
    assert not found, "\n".join(found)


def test_messages_and_docstrings_have_the_plain_words_and_open_with_what_is_done():
    found = []
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(text)))
        found += [
            f"{path.relative_to(ROOT)}:{each}" for each in [*unplain(nodes), *openings(nodes)]
        ]
    assert not found, "\n".join(found)


def unplain(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Each string, docstrings among them, that has words to replace."""
    for node in nodes:
        if isinstance(node, ast.JoinedStr):
            parts = [str(each.value) for each in node.values if isinstance(each, ast.Constant)]
            text = "{}".join(parts)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            text = node.value
        else:
            continue
        for words in UNPLAIN.findall(" ".join(text.split())):
            yield f"{node.lineno}: '{words}', write '{INSTEAD[words]}'"


def openings(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Each docstring that does not open with what is done."""
    for node in nodes:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Module, ast.AsyncFunctionDef)):
            opening = ast.get_docstring(node) or ""
            if OPENINGS.match(opening):
                yield f" {opening.splitlines()[0]}"
