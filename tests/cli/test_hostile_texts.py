"""Names of files, reasons, settings and messages of git reach no output otherwise than as texts."""

import io
import json
import random
import re
from pathlib import Path

import pytest

from tests.slow import slow_but_every
from tracerisk.cli.shared import output

PIECES = (
    *("\x1b[2J", "\x1b]52;c;aGk=\x07", "\x1b]8;;http://a\x1b\\", "\x9b31m", "\r", "\x08", "\x7f", "\x85"),
    *("\u2028", "\u202e", "\u2066", "\u200f", "\ufeff", "\udcff", "\U000e0041", "##[group]", "##vso[x]"),
    *("::error title=a::b", " ::add-mask::x", "<script>", "`", "|", "@a", "a", "größer", " ", "=1"),
)  # fmt: skip
OF_NAMES = ("\n", "\n::stop-commands::x", "\n\n ::debug::y", "--output=x", "-")
CONTROL = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u206f\ufeff\ud800-\udfff"
    "\U000e0000-\U000e007f]"
)


def harm_in(text):
    """What a terminal or a log of CI would do about a text, rather than show it."""
    commands = [
        line
        for line in re.split(r"[\r\n]", text)
        if line.lstrip().startswith("::") or re.search(r"##\w*\[", line)
    ]
    return [*map(ascii, CONTROL.findall(text)), *commands]


def hostile(chance, pieces, most):
    return "".join(chance.choices(pieces, k=chance.randint(1, most)))


class Project:
    """A repository with a controller, settings and commits of hostile names and words."""

    def __init__(self, repository, annotated_source, chance):
        self.repository = repository
        words = (*PIECES, *OF_NAMES)
        self.names = []
        for number in range(2):
            text = hostile(chance, words, 5).replace("/", "-").replace("\0", "")
            self.names.append(f"{text}{number}.py")
        reason = hostile(chance, [p for p in PIECES if p not in "\r\u2028\x85\udcff"], 4)
        for name in self.names:
            self._write(name, annotated_source(place=("done 1", f"gripper := 2e-07  ! {reason}")))
        self._write("pyproject.toml", "[tool.tracerisk]\n")
        self._commit(hostile(chance, PIECES, 4))
        for name in self.names:
            self._write(name, annotated_source(place=("done 1", f"gripper := 3e-07  ! x{reason}")))
        self._commit(hostile(chance, PIECES, 4))
        self._write(self.names[0], annotated_source(place=("done 1", "gripper = 4e-07")))
        self._write("broken.yaml", f"components: {{\x1b: {reason!a}")

    def _write(self, name, text):
        data = text.encode("utf-8", "surrogateescape")
        (Path(self.repository.folder) / name).write_bytes(data)

    def _commit(self, subject):
        self.repository.git("add", "--all")
        self.repository.git("commit", "--quiet", "--message", f"x{subject}")

    def outputs(self):
        """What each verb prints and writes; none may fail by a fault of its own."""
        one, two = (f"./{name}" for name in self.names)
        asked = (
            ("check", one, two),
            ("check", "--json", one, two),
            ("check", "--sarif", "a.sarif", "--code-quality", "a.json", one, two),
            ("diff",),
            ("diff", "--json"),
            ("diff", "HEAD~1", "--format", "markdown", "--metrics", "a.txt"),
            ("diff", "--sarif", "b.sarif", "HEAD~1"),
            ("diff", self.names[0] + ".absent"),
            ("history", one),
            ("history", "--json", one),
            ("overrides", one, two),
            ("overrides", "--json", one, two),
            ("solve", one),
            ("solve", "--json", one),
            ("solve", "absent\x1b[2J\n::error::x.py"),
            ("build", one),
            ("cut-sets", one),
            ("report", one, "-o", "page.html"),
            ("strip", "--diff", one),
            ("hardware", "broken.yaml"),
        )
        for words in asked:
            # A process of its own writes into a pipe; a diff in a file is as it is.
            outcome = self.repository.run(
                *words, environment={"CI": "true"}, is_afresh="--diff" in words
            )
            assert outcome.code != 5, (words, outcome.err)
            yield words, outcome.out
            yield words, outcome.err
            if "--json" in words and outcome.out:
                json.loads(outcome.out)
        for name in ("a.sarif", "a.json", "b.sarif", "a.txt", "page.html"):
            text = self.repository.read(name).decode()
            if name.endswith(("json", "sarif")):
                json.loads(text)
            yield name, text


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("seed", slow_but_every(12, range(24)))
def test_no_verb_prints_or_writes_what_acts(repository, annotated_source, seed):
    project = Project(repository, annotated_source, random.Random(seed))
    for asked, text in project.outputs():
        # A page is no log.
        harm = CONTROL.findall(text) if asked == "page.html" else harm_in(text)
        assert harm == [], asked


@pytest.mark.parametrize("is_file", [True, False], ids=["file", "pipe"])
def test_a_diff_of_dos_lines_can_be_applied_in_ci(repository, annotated_source, is_file):
    text = annotated_source(place=("done 1", "gripper = 4e-07")).replace("\n", "\r\n")
    if is_file:
        text = f"# \x0c\r\n{text}"
    path = Path(repository.folder) / "c.py"
    path.write_bytes(text.encode())
    # A process that is forked here writes into a file, one of its own into a pipe.
    patch = repository.run(
        "strip", "--diff", "c.py", environment={"CI": "1"}, is_afresh=not is_file
    )
    (path.parent / "p.patch").write_bytes(patch.out.encode())
    repository.git("apply", "-p0", "p.patch")
    data = path.read_bytes()
    assert b"RiskAnnotation" not in data
    assert data.count(b"\r\n") == data.count(b"\n") > 1


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_no_command_stands_at_the_begin_of_a_line_that_is_broken(monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.setenv("TERM", "xterm")
    terminal = Terminal()
    monkeypatch.setattr("sys.stdout", terminal)
    for length in range(20, 50):
        output.show(f"{'x' * length} ::error::pwned {'y' * 30}")
    text = terminal.getvalue()
    assert text.count("\n") > 40
    assert harm_in(text) == []
    assert "./" in text
