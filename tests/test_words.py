"""The text that users read: plain English, in the field's own words."""

import ast
import re
import tokenize
from collections.abc import Iterable
from functools import cache
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
OPENINGS = re.compile(r"(?:Tell|Say|Have|Let)\b")
MAY_OPEN = re.compile(rf"[\"']\s*{OPENINGS.pattern}")
# What a trace holds, a file names and a sensor reports is not told; who edits a block is a user.
VAGUE = re.compile(r"\b(?:tell|tells|told|persons?)\b", re.IGNORECASE)
VAGUE_IN = [
    *("tracerisk/**/*.py", "probe/**/*.py", "benchmarks/*.py"),
    *("README.md", "CHANGELOG.md", "docs/**/*.md"),
]
# Strings that stand in files of evidence and in tables for programs.
KEPT = {"told", "told after s"}
_CODE = re.compile(r"`[^`]*`")


@cache
def read(path: Path) -> tuple[list[tuple[int, str]], list[str]]:
    """All strings of a source, docstrings among them, with their lines; and its docstrings."""
    found, docstrings = [], []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef, ast.Module, ast.AsyncFunctionDef)):
            docstrings.append(ast.get_docstring(node) or "")
        elif isinstance(node, ast.JoinedStr):
            parts = [each.value for each in node.values if isinstance(each, ast.Constant)]
            found.append((node.lineno, "{}".join(parts)))
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.append((node.lineno, node.value))
    return found, docstrings


def may_hold(path: Path, wanted: Iterable[str]) -> bool:
    """Whether the letters of a source are those of a text, whatever stands between its lines."""
    no_letter_of_a_text = r"\\[a-z]|\b[bfr]+(?=[\"'])|[^A-Za-z]"
    letters = re.sub(no_letter_of_a_text, "", path.read_text(encoding="utf-8"))
    return any(re.sub("[^A-Za-z]", "", each) in letters for each in wanted)


def comments(path: Path) -> list[tuple[int, str]]:
    """All comments of a source, with their lines."""
    with path.open("rb") as stream:
        tokens = list(tokenize.tokenize(stream.readline))
    return [(each.start[0], each.string) for each in tokens if each.type == tokenize.COMMENT]


@pytest.mark.parametrize("words", INSTEAD)
def test_the_documentation_has_the_plain_words(words):
    found = [
        f"{path.relative_to(ROOT)}:{number}: write '{INSTEAD[words]}'"
        for path in PAGES
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1)
        if words in line
    ]
    assert not found, "\n".join(found)


def test_messages_help_and_docstrings_have_the_plain_words():
    found = []
    for path in SOURCES:
        if not may_hold(path, INSTEAD):
            continue
        for line, text in read(path)[0]:
            plain = " ".join(text.split())
            found += [
                f"{path.relative_to(ROOT)}:{line}: '{words}', write '{INSTEAD[words]}'"
                for words in INSTEAD
                if words in plain
            ]
    assert not found, "\n".join(found)


def test_docstrings_open_with_what_is_done():
    found = [
        f"{path.relative_to(ROOT)}: {opening.splitlines()[0]}"
        for path in SOURCES
        if MAY_OPEN.search(path.read_text(encoding="utf-8"))
        for opening in read(path)[1]
        if OPENINGS.match(opening)
    ]
    assert not found, "\n".join(found)


def test_texts_and_comments_name_what_is_done_and_by_whom():
    found = []
    for path in sorted(each for pattern in VAGUE_IN for each in ROOT.glob(pattern)):
        whole = path.read_text(encoding="utf-8")
        if not VAGUE.search(whole):
            continue
        lines = list(enumerate(whole.splitlines(), 1))
        if path.suffix == ".py":
            lines = [each for each in read(path)[0] if each[1] not in KEPT] + comments(path)
        found += [
            f"{path.relative_to(ROOT)}:{line}: '{vague[0]}'; write print, report, list, hold or user"
            for line, text in lines
            if (vague := VAGUE.search(_CODE.sub("", text)))
        ]
    assert not found, "\n".join(found)


# A verb that works on a controller is named with it, so that the command can be copied.
VERBS = ("run", "refresh", "annotate", "evidence", "trace", "solve", "check", "scenario")
BARE = re.compile(rf"`tracerisk ({'|'.join(VERBS)})`")
VAGUE_ADVICE = re.compile(
    r"\brun (?:tracerisk|it|the controller|the command) again\b|\brecord the run again\b"
    r"|[;:] refresh (?:it|with)\b|\brefresh` (?:it|mends)\b"
)
# A source that has none of these is not read.
MAY_ASK = (
    *(f"`tracerisk {verb}`" for verb in VERBS),
    *(f"{whose} again" for whose in ("tracerisk", "it", "controller", "command", "the run")),
    *("refresh it", "refresh with", "refresh mends"),
)
HELP = {"run it again whenever a file", "run it again in worlds"}


def test_a_message_that_asks_names_the_whole_command():
    found = []
    for path in SOURCES:
        if not may_hold(path, MAY_ASK):
            continue
        strings, docstrings = read(path)
        plain_strings = ((line, " ".join(text.split())) for line, text in strings)
        asking = [
            (line, plain)
            for line, plain in plain_strings
            if BARE.search(plain) or VAGUE_ADVICE.search(plain)
        ]
        texts = {*docstrings, *texts_of_names(path)} if asking else set()
        for line, plain in asking:
            is_text = any(plain in " ".join(each.split()) for each in texts)
            if not is_text and not any(each in plain for each in HELP):
                found.append(f"{path.relative_to(ROOT)}:{line}: {plain}")
    assert not found, "name the command with its FILE:\n" + "\n".join(found)


def texts_of_names(path: Path) -> list[str]:
    """The strings of a source that stand alone, as those below a constant or a field do."""
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    values = [node.value for node in nodes if isinstance(node, ast.Expr)]
    return [
        each.value for each in values if isinstance(each, ast.Constant) and each.value is not ...
    ]
