"""The command at a terminal of its own: colours, width, progress, and what is left behind."""

import fcntl
import json
import os
import pty
import re
import select
import signal
import struct
import subprocess
import termios
import time
from dataclasses import dataclass
from typing import Any

import pytest

from tests.conftest import program
from tests.slow import slow_but
from tracerisk.cli.shared.output import broken
from tracerisk.pipeline.check.cached_run import last_duration_s

ESCAPE = re.compile(r"\x1b\[[0-9;?]*[a-zA-Z]")
HIDE, SHOW, ERASE = "\x1b[?25l", "\x1b[?25h", "\x1b[2K"
WIDTH_OF_THE_SETTING = {"COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR", "TERM"}


@dataclass
class Shown:
    """What a call wrote to its terminal, and to standard output where that is no terminal."""

    code: int
    raw: str
    out: bytes

    @property
    def lines(self) -> list[str]:
        """The lines that stand there in the end, those that were erased left out."""
        screen: list[str] = [""]
        row = 0
        for part in re.split(r"(\r\n|\r|\n|\x1b\[[0-9;?]*[a-zA-Z])", self.raw):
            if part in ("\n", "\r\n"):
                row += 1
                if row == len(screen):
                    screen.append("")
            elif part.endswith("A") and part.startswith("\x1b["):
                row = max(row - int(part[2:-1] or 1), 0)
            elif part == ERASE:
                screen[row] = ""
            elif part and not part.startswith("\x1b") and part != "\r":
                screen[row] += part
        return [line.rstrip() for line in screen]


def at_terminal(
    example,
    *arguments: str,
    width: int = 80,
    environment: dict[str, str] | None = None,
    out_is_terminal: bool = True,
    interrupt_at: str | None = None,
) -> Shown:
    """Run the command at a pseudo-terminal; press Ctrl-C once a text has appeared."""
    ours, theirs = pty.openpty()
    fcntl.ioctl(theirs, termios.TIOCSWINSZ, struct.pack("HHHH", 40, width, 0, 0))
    inherited = {key: each for key, each in os.environ.items() if key not in WIDTH_OF_THE_SETTING}
    around = {**inherited, "TERM": "xterm-256color", **(environment or {})}
    process: subprocess.Popen[Any] = subprocess.Popen(
        [*program(around), *arguments],
        cwd=example.folder,
        stdin=theirs,
        stdout=theirs if out_is_terminal else subprocess.PIPE,
        stderr=theirs,
        env=around,
        start_new_session=True,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    os.close(theirs)
    piped = None if process.stdout is None else process.stdout.fileno()
    found = {ours: bytearray(), piped: bytearray()}
    open_ends = [each for each in (ours, piped) if each is not None]
    end = time.monotonic() + 120.0
    try:
        while open_ends:
            assert time.monotonic() < end, found[ours].decode("utf-8", "replace")
            for descriptor in select.select(open_ends, [], [], 1.0)[0]:
                try:
                    data = os.read(descriptor, 65536)
                except OSError:  # the other side of a pseudo-terminal is closed
                    data = b""
                if not data:
                    open_ends.remove(descriptor)
                found[descriptor] += data
            if interrupt_at is not None and interrupt_at.encode() in found[ours]:
                interrupt_at = None
                process.send_signal(signal.SIGINT)
        code = process.wait(timeout=30)
    finally:
        process.kill()
        process.wait()
        os.close(ours)
        if process.stdout is not None:
            process.stdout.close()
    return Shown(code, found[ours].decode(), bytes(found[piped]))


ROUNDS = 6
TALKING = ('print("one tube")', 'print("half a ", end=""); print("tube")')


@pytest.fixture
def talking(example, quick):
    """A controller that prints while it moves, for some seconds of simulated time."""
    source = quick(*TALKING).replace(
        "    act(arm)\n", f"    for _ in range({ROUNDS}): home(arm); act(arm)\n"
    )
    example.write("controller.py", source)
    return example


def test_phases_and_simulated_seconds_appear_and_the_bar_is_gone_at_the_end(talking):
    shown = at_terminal(talking, "run", "controller.py", "--report", "out.html")
    assert shown.code == 0, shown.raw
    text = ESCAPE.sub("", shown.raw)
    places = [text.find(f" {each} ") for each in ("reading", "starting the twin", "simulating")]
    assert -1 not in places, text
    assert places == sorted(places)
    assert re.search(r"report +\S+ +\d+\.\d s simulated", text)
    seconds = [float(each) for each in re.findall(r"simulating +\S+ +(\d+\.\d) s sim", text)]
    # A line of the controller may draw the bar once more as it was a moment before.
    assert all(before <= after for before, after in zip(seconds, seconds[2:], strict=False))
    assert seconds[-1] > 0.0
    left = "\n".join(shown.lines)
    assert not re.search("reading|starting|simulating|annotating|solving", left), left
    assert shown.raw.rindex(SHOW) > shown.raw.rindex(HIDE)
    # What the controller prints stands whole above the bar.
    assert shown.lines.count("one tube") == shown.lines.count("half a tube") == ROUNDS


def test_json_through_a_pipe_is_clean_while_the_terminal_shows_progress(talking):
    shown = at_terminal(talking, "run", "controller.py", "--json", out_is_terminal=False)
    assert json.loads(shown.out)["exit_code"] == 0
    assert shown.out.startswith(b"{\n")
    assert "simulating" in shown.raw


@pytest.mark.slow
def test_json_at_the_terminal_is_clean_too(talking):
    shown = at_terminal(talking, "run", "controller.py", "--json", width=200)
    begin = shown.raw.index("{\r\n")
    assert begin > shown.raw.rindex(SHOW)
    assert json.loads(shown.raw[begin:])["exit_code"] == 0


def test_a_terminal_that_cannot_draw_gets_no_bar(talking):
    shown = at_terminal(talking, "run", "controller.py", environment={"TERM": "dumb"})
    assert shown.code == 0
    assert "\x1b" not in shown.raw
    assert "simulating" not in shown.raw
    assert "one tube" in shown.raw
    assert "Functions" in shown.raw


def test_quiet_prints_what_is_asked_for_and_nothing_else(talking):
    options = ("--quiet", "--explain", "act", "--max-failure-probability", "0")
    shown = at_terminal(talking, "run", "controller.py", *options, out_is_terminal=False)
    derived = shown.out.decode()
    assert shown.code == 1
    assert derived.startswith("act")
    assert "Functions" not in derived
    # Not even what the controller prints.
    reported = [line for line in shown.lines if line]
    assert len(reported) == 1
    assert reported[0].endswith("is over --max-failure-probability 0")
    # Solving is asked for to see the figures.
    assert "Functions" in talking.run("solve", "controller.py", "--quiet").out


def test_ctrl_c_leaves_the_terminal_clean(talking):
    # It is still running when the key is pressed, however fast the machine.
    longer = talking.read("controller.py").decode().replace(f"range({ROUNDS})", "range(300)")
    talking.write("controller.py", longer)
    before = talking.files()
    shown = at_terminal(talking, "run", "controller.py", interrupt_at="simulating")
    assert shown.code == 130
    assert shown.raw.rindex(SHOW) > shown.raw.rindex(HIDE)
    # The key may have been pressed in the middle of a line of the controller.
    of_the_controller = ("", "one tube", "half a", "half a tube")
    left = [line for line in shown.lines if line not in of_the_controller]
    assert left == ["tracerisk: interrupted"]
    assert talking.files() == before


@pytest.mark.slow
def test_a_failing_controller_is_reported_of_where_the_bar_was(example, quick):
    example.write("controller.py", quick("raise SystemError('no tube')"))
    shown = at_terminal(example, "run", "controller.py")
    assert shown.code == 1
    left = "\n".join(shown.lines)
    assert "no tube" in left
    assert "simulating" not in left


def test_without_colours_eighty_columns_of_a_terminal_are_what_a_pipe_gets(annotated):
    piped = annotated.run("solve", "model.json").out
    assert "\x1b" not in piped
    for environment in ({"NO_COLOR": "1"}, {"TERM": "dumb"}, {"NO_COLOR": "1", "FORCE_COLOR": "1"}):
        shown = at_terminal(annotated, "solve", "model.json", environment=environment)
        assert shown.raw.replace("\r\n", "\n") == piped
    colored = at_terminal(annotated, "solve", "model.json")
    assert "\x1b[1m" in colored.raw
    bare = ESCAPE.sub("", colored.raw).splitlines()
    assert [line.rstrip() for line in bare] == piped.splitlines()


def test_colours_where_they_are_forced_and_no_empty_setting_counts(annotated):
    forced = annotated.run("solve", "model.json", environment={"FORCE_COLOR": "1", "NO_COLOR": ""})
    assert "\x1b[1m" in forced.out
    plain = annotated.run("solve", "model.json", environment={"FORCE_COLOR": ""}).out
    bare = ESCAPE.sub("", forced.out).splitlines()
    assert [line.rstrip() for line in bare] == plain.splitlines()
    assert "\x1b" in at_terminal(annotated, "solve", "model.json", environment={"NO_COLOR": ""}).raw


def test_the_option_color_has_the_last_word(annotated):
    colored = annotated.run("solve", "model.json", "--color", "always")
    assert "\x1b[1m" in colored.out
    asked = {"NO_COLOR": "1"}
    still = annotated.run("solve", "model.json", "--color", "always", environment=asked)
    assert still.out == colored.out
    forced = {"FORCE_COLOR": "1"}
    plain = annotated.run("solve", "model.json", "--color", "never", environment=forced)
    assert plain.out == annotated.run("solve", "model.json").out
    wrong = annotated.run("solve", "model.json", "--color", "blue")
    assert wrong.code == 2
    assert "'auto', 'always', 'never'" in wrong.err


@pytest.mark.slow
def test_the_time_left_is_shown_once_a_run_is_known(talking):
    known = talking.folder / "controller.py"
    assert last_duration_s(known) is None
    first = at_terminal(talking, "run", "controller.py", width=120)
    assert first.code == 0
    assert not re.search(r"about \d+ s left", first.raw)
    again = at_terminal(talking, "run", "controller.py", width=120)
    assert re.search(r"about \d+ s left", again.raw)
    # A lock that cannot be read gives none.
    assert last_duration_s(known) == pytest.approx(sum_of_durations(talking))
    for damaged in (b"", b"{", b"[1]", b'{"schema": "tracerisk.lock"}'):
        talking.write("tracerisk.lock", damaged.decode())
        assert last_duration_s(known) is None


def sum_of_durations(example):
    (entry,) = json.loads(example.read("tracerisk.lock"))["controllers"].values()
    return sum(each["duration_s"] for each in entry["trace"]["functions"].values())


def test_a_wide_terminal_is_made_use_of(annotated):
    wide = ESCAPE.sub("", at_terminal(annotated, "solve", "model.json", width=120).raw)
    assert "absorbed" in wide
    assert "\N{FULL BLOCK}" in wide


@pytest.mark.parametrize("encoding", ["ascii", pytest.param("latin-1", marks=pytest.mark.slow)])
def test_an_encoding_without_lines_and_bars_gets_plain_signs(annotated, encoding):
    setting = {"PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"}
    done = annotated.run("solve", "model.json", environment=setting)
    assert done.code == 0, done.err
    assert "------" in done.out
    wide = at_terminal(annotated, "solve", "model.json", width=120, environment=setting)
    assert "##" in wide.raw


@pytest.mark.slow
def test_refresh_says_its_phases_too(annotated):
    path = annotated.folder / "controller.py"
    path.write_text(path.read_text().replace("+= 0.05", "+= 0.06"))
    shown = at_terminal(annotated, "refresh")
    text = ESCAPE.sub("", shown.raw)
    assert shown.code == 0, text
    places = [text.find(f" {each} ") for each in ("reading", "simulating", "annotating")]
    assert -1 not in places
    assert places == sorted(places)
    verdict, done = [line for line in shown.lines if line]
    assert verdict.startswith("controller.py: complete, ")
    assert done.startswith("controller.py: changed (")


HARDWARE = """\
components:
  a_component_with_a_long_name:
    active: always
    failure_rate: {value: 2e-6, per: hour, error_factor: 3, source: a supplier}
"""


@pytest.mark.parametrize("options", [("--robot", "panda"), ("cell.yaml",)])
def test_a_table_of_hardware_fits_the_terminal_and_only_there(example, options):
    example.write("cell.yaml", HARDWARE)
    shown = at_terminal(example, "hardware", "show", *options, width=72)
    assert shown.code == 0, shown.raw
    table = shown.lines[1 : shown.lines.index("")]
    assert max(map(len, table)) <= 72
    piped = example.run("hardware", "show", *options).out.splitlines()[1:]
    assert max(map(len, piped[: piped.index("")])) > 72


def test_a_long_line_is_broken_between_words_and_set_in():
    line = "  faulted: " + "one two three four " * 6 + "(src/cell/scripts/pick.py:42)"
    shown = broken(line, 60).split("\n")
    assert max(map(len, shown)) <= 60
    assert shown[0].startswith("  faulted: ")
    assert all(each.startswith("    ") and each[4] != " " for each in shown[1:])
    assert " ".join(each.strip() for each in shown) == line.strip()
    assert broken("short", 60) == "short"
    path = "x" * 90
    assert path in broken(f"see {path}", 60), "a path stays whole"


@pytest.mark.parametrize("text", ["89.9 % of it", "10.76 s, then", "0.94 mm off", "3 N, 2 of 3"])
def test_a_number_keeps_its_unit_wherever_the_line_is_broken(text):
    number, unit, _ = text.split(" ", 2)
    line = "one two three four five six seven eight nine ten " * 2 + text
    for width in range(40, len(line)):
        assert f"{number} {unit}" in broken(line, width)


WORDS = {
    "check": "check",
    "diff": "diff HEAD",
    "doctor of a typo": "doctor controller.py --robott panda --scnee tube_racks",
    "history": "history",
    "hardware": "hardware show --robot panda",
    "an unknown option": "sweep controller.py --cells 3 --over robot=panda --seeed 1",
    "an unknown robot": "run controller.py --robot pandaa",
    "explain": "solve controller.py --explain act",
    "importance": "solve controller.py --importance --pairs",
    "overrides": "overrides",
    "robots": "robots",
    "a robot": "robots ur5e",
    "scenario": "scenario controller.py",
    "set": "solve controller.py --set electric_motor=1e-6",
    "sweep": "solve controller.py --sweep electric_motor=1e-9:1e-5:4",
    "verbose": "run controller.py -v",
}


# Of tables and of errors that are broken alike, one each time.
_ALIKE = ("an unknown robot", "hardware", "robots", "a robot", "set")


@pytest.mark.slow(but=4)
@pytest.mark.parametrize(
    "what", slow_but([what for what in WORDS if what not in _ALIKE], list(WORDS))
)
def test_no_line_is_wider_than_the_terminal(annotated, what):
    git = ["git", "-c", "user.name=a", "-c", "user.email=a@b"]
    for each in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "A controller of a quick arm"]):
        subprocess.run([*git, *each], cwd=annotated.folder, check=True)
    shown = at_terminal(annotated, *WORDS[what].split(), width=80)
    assert any(shown.lines)
    assert [line for line in shown.lines if len(line) > 80] == []
    two_empty = "\n\n\n"
    assert two_empty not in "\n".join(shown.lines).strip()
