"""The tutorial and the how-to guides, done step by step: what they show is what is printed.

In a page, blocks of `sh` and `console` are run in their order (what stands below a `$` line is its
output, `...` for anything), those with a `title` are written as files, and a `diff` is applied.
Commands run on a terminal of 80 columns, because their readers have one and see less there.
"""

from __future__ import annotations

import fcntl
import math
import os
import pty
import re
import shlex
import struct
import subprocess
import termios
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.conftest import program

DOCS = Path(__file__).parents[1] / "docs"
BLOCK = re.compile(r'^```(\w+)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)
MEASURED = r"\d+\.\d+(?:e-\d+)?|\d+e-\d+"


def alike(shown: str, printed: str) -> bool:
    """Whether a text is what was printed: `...` is anything, numbers may differ by 1 %.

    The last digits of a simulation depend on the processor.
    """
    pattern, numbers = "", []
    for part in re.split(rf"( ?\.\.\. ?|{MEASURED})", " ".join(shown.split())):
        if part.strip() == "...":
            pattern += ".*?"
        elif re.fullmatch(MEASURED, part):
            pattern += f"({MEASURED})"
            numbers.append(float(part))
        else:
            pattern += re.escape(part)
    found = re.fullmatch(pattern, " ".join(printed.split()))
    return found is not None and all(
        math.isclose(number, float(other), rel_tol=0.01)
        for number, other in zip(numbers, found.groups(), strict=True)
    )


@dataclass(frozen=True)
class Shell:
    """A folder, and a shell in which `tracerisk` is the one under test."""

    folder: Path
    commands: Path

    def run(self, command: str) -> tuple[int, str]:
        kept = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
        kept.pop("COLUMNS", None)  # the terminal says how wide it is
        ours, terminal = pty.openpty()
        fcntl.ioctl(terminal, termios.TIOCSWINSZ, struct.pack("4H", 40, 80, 0, 0))
        process = subprocess.Popen(
            ["bash", "-c", command],
            cwd=self.folder,
            stdin=subprocess.DEVNULL,
            stdout=terminal,
            stderr=terminal,
            env={
                **kept,
                "PATH": f"{self.commands}:{os.environ['PATH']}",
                "GIT_CONFIG_GLOBAL": str(self.commands / "gitconfig"),
                "GIT_CONFIG_NOSYSTEM": "1",
                "GIT_PAGER": "cat",
                "NO_COLOR": "1",
                "TERM": "dumb",  # neither progress nor colours
            },
        )
        os.close(terminal)
        printed = b""
        with os.fdopen(ours, "rb", buffering=0) as screen, suppress(OSError):
            while piece := screen.read(65536):  # an error says that nobody writes to it any more
                printed += piece
        return process.wait(timeout=300), printed.decode()


@pytest.fixture
def shell(tmp_path, pick_and_place, page) -> Shell:
    commands = tmp_path / "commands"
    commands.mkdir()
    command = commands / "tracerisk"
    command.write_text(f'#!/bin/sh\nexec {shlex.join(program(os.environ))} "$@"\n')
    command.chmod(0o755)
    (commands / "gitconfig").write_text(
        "[user]\nname = a\nemail = a@example.org\n[init]\ndefaultBranch = main\n"
    )
    samples = tmp_path / "tracerisk" / "sample_controllers"
    samples.mkdir(parents=True)
    # All of its tubes are in the figures of the tutorial alone.
    fewer = pick_and_place.replace(b"TUBES = 10", b"TUBES = 1")
    (samples / "pick_and_place.py").write_bytes(pick_and_place if page == "tutorial.md" else fewer)
    folder = tmp_path / "cell"
    folder.mkdir()
    return Shell(folder, commands)


def follow(page: str, shell: Shell) -> int:
    """Do what a page says; return the number of commands."""
    text = (DOCS / page).read_text(encoding="utf-8")
    count = 0
    for language, title, body in BLOCK.findall(text):
        if title:
            path = shell.folder / title
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(body, encoding="utf-8")
        elif language == "diff":
            (shell.commands / "change.diff").write_text(body)
            assert shell.run(f"git apply {shell.commands}/change.diff") == (0, "")
        elif language == "sh":
            code, out = shell.run(f"set -e\n{body}")
            assert code == 0, f"{body}\n{out}"
            count += body.count("\n")
        elif language == "console":
            for command, output in re.findall(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", body, re.MULTILINE):
                code, out = shell.run(command)
                assert code == 0, f"{command}\n{out}"
                assert alike(output, out), f"{command}\nshown:\n{output}\nprinted:\n{out}"
                count += 1
        elif language == "python":
            written = "".join(each.read_text() for each in shell.folder.rglob("*.py"))
            assert alike(f"...{body}...", written), body
    return count


@pytest.mark.parametrize(
    "page",
    [
        "tutorial.md",
        *sorted(path.name for path in DOCS.glob("howto-*.md")),
    ],
)
def test_what_a_guide_shows_is_what_happens(page, shell):
    assert follow(page, shell) >= 3


def test_what_is_alike():
    assert alike("a 1.00e-07 ... c", "a 1.001e-07 b\nb c")
    assert not alike("a 1.00e-07 c", "a 1.03e-07 c")
    assert not alike("a b", "a c")
    assert not alike("a 1 ... 2", "a 1 3")
