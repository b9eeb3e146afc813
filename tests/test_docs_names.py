"""What the pages name is there: commands with their options, Python names, benchmarks."""

import re
import shlex
from argparse import ArgumentParser
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

from tracerisk.cli.parser import whole_parser
from tracerisk.cli.verbs import VERBS

ROOT = Path(__file__).parents[1]
PAGES = sorted([*(ROOT / "docs").glob("*.md"), *ROOT.glob("*.md"), *ROOT.glob("*/*/README.md")])
FENCED = re.compile(r"^ *```(\w*)[^\n]*\n(.*?)^ *```$", re.MULTILINE | re.DOTALL)
SHELLS = {"", "sh", "bash", "console"}
OPTION = re.compile(r"(?<![\w-])--[a-z][\w-]*")


@cache
def parser() -> ArgumentParser:
    return whole_parser()


def options_of(verb_parser: ArgumentParser) -> set[str]:
    """The options of a verb, and of its actions: `hardware` has several."""
    known: set[str] = set()
    for action in verb_parser._actions:
        known.update(action.option_strings)
        if isinstance(action.choices, dict):
            for inner in action.choices.values():
                known |= options_of(inner)
    return known


@cache
def options(verb: str) -> set[str]:
    (verbs,) = [action.choices for action in parser()._actions if action.dest == "verb"]
    return options_of(verbs[verb])


def commands(text: str) -> Iterator[list[str]]:
    """The arguments of each `tracerisk` in the blocks of a page that show a shell."""
    for language, body in FENCED.findall(text):
        if language not in SHELLS:
            continue
        for line in body.replace("\\\n", " ").splitlines():
            if language == "console" and not line.startswith("$ "):
                continue
            if re.search(r"\btracerisk [a-z-]", line):
                yield from commands_of(line.removeprefix("$ "))


def commands_of(line: str) -> Iterator[list[str]]:
    """The arguments of each `tracerisk` in one line of a shell."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars=True)
    lexer.whitespace_split = True
    words: list[str] = []
    for word in (*lexer, ";"):
        if set(word) <= set("|&;<>()"):
            if words and Path(words[0]).name == "tracerisk":
                yield words[1:]
            words = []
        else:
            words.append(word)


def in_line(text: str) -> list[str]:
    return re.findall(r"`([^`\n]+)`", FENCED.sub("", text))


def test_a_shell_line_is_cut_into_its_commands():
    line = "a | venv/bin/tracerisk check x.py > out && tracerisk diff 'a b'  # main"
    assert list(commands_of(line)) == [["check", "x.py"], ["diff", "a b"]]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_commands_in_blocks_are_understood(page, capsys):
    for arguments in commands(page.read_text(encoding="utf-8")):
        with suppress(SystemExit):
            parser().parse_args(arguments)
        assert capsys.readouterr().err == "", shlex.join(arguments)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_verbs_and_options_in_the_text_are_there(page):
    for code in in_line(page.read_text(encoding="utf-8")):
        words = code.split(" -- ")[0].removeprefix("tracerisk ").split()
        if code.startswith("tracerisk ") and words[0].islower() and words[0][0].isalpha():
            assert words[0] in VERBS, code
        if words and words[0] in VERBS:
            assert set(OPTION.findall(" ".join(words))) <= options(words[0]), code


def is_there(name: str) -> bool:
    """Whether a dotted name can be imported, or is that of a field."""
    parts = name.split(".")
    for count in range(len(parts), 0, -1):
        try:
            value = import_module(".".join(parts[:count]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[count:]:
            if attribute in getattr(value, "__dataclass_fields__", {}):
                return True
            if not hasattr(value, attribute):
                return False
            value = getattr(value, attribute)
        return True
    return False


@cache
def sources() -> str:
    """What an editor or an entry point asks for by its name."""
    files = [*(ROOT / "tracerisk").rglob("*.py"), ROOT / "editors" / "vscode" / "package.json"]
    return "\n".join(file.read_text(encoding="utf-8") for file in files)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_dotted_names_are_there(page):
    text = page.read_text(encoding="utf-8")
    for name in sorted(set(re.findall(r"(?<![\w/.-])tracerisk(?:\.\w+)+", text))):
        assert is_there(name) or f'"{name}' in sources() or f"{name}`" in sources(), name


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_benchmarks_have_the_options_that_are_named(page):
    text = page.read_text(encoding="utf-8")
    for path, rest in re.findall(r"python (benchmarks/\w+\.py)([^`\n]*)", text):
        program = (ROOT / path).read_text(encoding="utf-8")
        for option in OPTION.findall(rest):
            assert re.search(rf"{option}\b", program), f"{path} {option}"
