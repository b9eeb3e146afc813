"""`run --watch`: the figure follows each save."""

import contextlib
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from tests.conftest import program

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="looks at processes by /proc")

LONGEST_S = 90.0


class Watching:
    """A `run --watch` in a folder, and the lines that it prints."""

    def __init__(self, folder: Path, command: list[str], *arguments: str) -> None:
        self.folder = folder
        self.lines: list[str] = []
        self.process = subprocess.Popen(
            [*command, *arguments, "--watch"],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            stdin=subprocess.DEVNULL,
            text=True,
        )
        self.out: list[str] = []
        self._came = threading.Condition()
        pipes = ((self.process.stderr, self.lines), (self.process.stdout, self.out))
        self._readers = [
            threading.Thread(target=self._read, args=each, daemon=True) for each in pipes
        ]
        for reader in self._readers:
            reader.start()
        self.seen = 0

    def _read(self, stream, kept: list[str]) -> None:
        for line in stream:
            with self._came:
                kept.append(line.rstrip("\n"))
                self._came.notify_all()

    def until(self, begin: str) -> str:
        """The next line that begins so; those before it are passed over."""
        ends = time.monotonic() + LONGEST_S
        with self._came:
            while True:
                while self.seen < len(self.lines):
                    line = self.lines[self.seen]
                    self.seen += 1
                    if line.startswith(begin):
                        return line
                left = ends - time.monotonic()
                if left < 0 or not self._came.wait(left):
                    raise AssertionError(
                        f"no line begins with {begin!r}:\n" + "\n".join(self.lines)
                    )

    def until_out(self, text: str) -> None:
        """Wait until a line of standard output holds the text; they come by a pipe of their own."""
        ends = time.monotonic() + LONGEST_S
        with self._came:
            while not any(text in line for line in self.out):
                left = ends - time.monotonic()
                if left < 0 or not self._came.wait(left):
                    raise AssertionError(f"no line holds {text!r}:\n" + "\n".join(self.out))

    def settled(self) -> None:
        self.until("watching ")

    def figure(self) -> float:
        found = re.match(r"mission failure ([\d.e+-]+)", self.until("mission failure "))
        return float(found[1])

    def processes(self) -> set[int]:
        """All processes below this one, and those that are in its folder."""
        parents, found = {}, set()
        for folder in Path("/proc").iterdir():
            if folder.name.isdigit():
                with contextlib.suppress(OSError):
                    status = (folder / "stat").read_text()
                    parents[int(folder.name)] = int(status.rpartition(")")[2].split()[1])
                    if (folder / "cwd").readlink() == self.folder:
                        found.add(int(folder.name))
        waiting = [self.process.pid]
        while waiting:
            new = [each for each, parent in parents.items() if parent == waiting[0]]
            found |= set(new)
            waiting = [*waiting[1:], *new]
        return found

    def end(self, number: int = signal.SIGINT) -> int:
        self.process.send_signal(number)
        code = self.process.wait(30)
        for reader in self._readers:
            reader.join(5)
        return code


def gone(processes: set[int]) -> bool:
    """Whether all of them end within a few seconds."""
    ends = time.monotonic() + 10
    while time.monotonic() < ends:
        left = {each for each in processes if Path(f"/proc/{each}").exists()}
        left = {each for each in left if "Z" not in _state(each)}
        if not left:
            return True
        time.sleep(0.05)
    return False


def _state(process: int) -> str:
    try:
        return Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return "Z"


@pytest.fixture
def watching(tmp_path):
    started = []

    def start(*arguments: str, verb: str = "run", is_afresh: bool = False) -> Watching:
        command = program(os.environ, is_afresh=is_afresh)
        started.append(Watching(tmp_path, command, verb, *arguments))
        return started[-1]

    yield start
    for each in started:
        if each.process.poll() is None:
            each.end(signal.SIGKILL)


def test_the_figure_follows_and_no_source_is_written(watching, example, quick):
    path = example.write("a.py", quick())
    watched = watching("a.py", "--json")
    first = watched.figure()
    watched.settled()
    faster = quick().replace("joints[0] += 0.05", "joints[0] += 0.5")
    path.write_text(faster)
    assert watched.until("a.py changed")
    second = watched.figure()
    assert second > 1.5 * first
    watched.settled()
    assert path.read_text() == faster
    assert list(example.files()) == ["a.py"]
    assert watched.end() == 130
    # Each update is one document of JSON.
    text, found = "\n".join(watched.out), []
    while text.strip():
        data, end = json.JSONDecoder().raw_decode(text.lstrip())
        found.append(data)
        text = text.lstrip()[end:]
    assert [each["verb"] for each in found] == ["run", "run"]
    # The same as by a run of its own, to the digits that are printed.
    reported = example.run("run", "a.py", "--diff", "--json").json
    figure = reported["assessment"]["mission"]["failure_probability"]
    assert f"{figure:.4g}" == f"{second:.4g}"


def test_what_changes_no_run_is_not_run_again(watching, example, quick):
    hardware = (
        Path(__file__).parents[3] / "tracerisk/common/hardware/robots/panda.yaml"
    ).read_text()
    example.write("cell.yaml", hardware)
    path = example.write("a.py", quick())
    watched = watching("a.py", "--hardware", "cell.yaml")
    first = watched.figure()
    watched.settled()
    path.write_text(quick() + "\n# a remark\n")
    assert watched.until("mission failure ").endswith("without a run")
    watched.settled()
    path.touch()
    assert watched.until("a.py: nothing")
    watched.settled()
    example.write("cell.yaml", hardware.replace("9.5e-08", "9.5e-07"))
    reported = watched.until("mission failure ")
    assert reported.endswith("without a run")
    assert float(reported.split()[2].rstrip(",")) > 5 * first


def test_sources_are_written_when_that_is_asked_for(watching, example, quick):
    path = example.write("a.py", quick())
    watched = watching("a.py", "--write")
    watched.settled()
    assert "RiskAnnotation" in path.read_text()
    assert (example.folder / "tracerisk.lock").is_file()
    assert example.run("check", "a.py").code == 0
    path.write_text(path.read_text().replace("joints[0] += 0.05", "joints[0] += 0.5"))
    watched.figure()
    watched.settled()
    assert example.run("check", "a.py").code == 0
    # What it writes itself is no change that it runs for.
    time.sleep(1.0)
    reported = [line for line in watched.lines if line.startswith("mission failure")]
    assert len(reported) == 2


def test_a_broken_and_a_deleted_file_are_reported_and_waited_for(watching, example, quick):
    path = example.write("a.py", quick())
    watched = watching("a.py")
    watched.settled()
    path.write_text(quick() + "\ndef (\n")
    assert "[source]" in watched.until("tracerisk: a.py:")
    watched.settled()
    path.unlink()
    assert "cannot be read" in watched.until("tracerisk: a.py")
    watched.settled()
    path.write_text(quick().replace("+= 0.05", "+= 0.5"))
    watched.figure()
    watched.settled()
    path.write_text(quick("raise ValueError('x')"))
    assert watched.until("a.py changed")
    watched.settled()
    assert any("ValueError" in line for line in [*watched.lines, *watched.out])
    path.write_text(quick())
    watched.figure()


# One that breaks later is waited for in the test above.
@pytest.mark.slow
def test_one_that_is_broken_from_the_start_is_waited_for(watching, example, quick):
    path = example.write("a.py", "def (\n")
    watched = watching("a.py")
    watched.until("tracerisk: a.py:")
    watched.settled()
    path.write_text(quick("home(arm)"))
    watched.figure()


@pytest.mark.slow
def test_a_module_that_is_used_is_watched_too(watching, example, quick):
    source = quick().replace("import os", "import moves, os", 1)
    example.write("a.py", source.replace("    act(arm)", "    moves.home(arm)\n    act(arm)"))
    watched = watching("a.py")
    watched.until("watching ")
    module = 'def home(arm):\n    arm.set_named_target("{}")\n    arm.go()\n'
    path = example.write("moves.py", module.format("extended"))
    first = watched.figure()
    watched.settled()
    path.write_text(module.format("ready"))
    watched.until("moves.py changed")
    assert watched.figure() != first


def test_rapid_saves_come_to_the_last(watching, example, quick):
    path = example.write("a.py", quick())
    watched = watching("a.py")
    watched.settled()
    for number in range(12):
        path.write_text(quick().replace("+= 0.05", f"+= 0.{number + 10}"))
        time.sleep(0.05)
    last = watched.figure()
    time.sleep(1.5)
    reported = [line for line in watched.lines if line.startswith("mission failure")]
    assert len(reported) <= 3
    assert watched.end() == 130
    if len(reported) > 2:
        last = float(reported[-1].split()[2].rstrip(","))
    figure = example.run("run", "a.py", "--diff", "--json").json["assessment"]["mission"]
    assert f"{figure['failure_probability']:.4g}" == f"{last:.4g}"


@pytest.mark.parametrize(
    ("is_afresh", "is_busy", "number", "code"),
    [
        # The figure that follows is ended so each time, while nothing runs.
        pytest.param(False, False, signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param(False, True, signal.SIGINT, 130, marks=pytest.mark.slow),
        (False, True, signal.SIGTERM, 143),
        # A controller ends with the process that runs it: test_process has it killed each time.
        pytest.param(True, True, signal.SIGKILL, -9, marks=pytest.mark.slow),
        pytest.param(True, False, signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param(True, True, signal.SIGINT, 130, marks=pytest.mark.slow),
        pytest.param(True, True, signal.SIGTERM, 143, marks=pytest.mark.slow),
    ],
)
def test_its_end_leaves_no_process(watching, example, quick, number, code, is_afresh, is_busy):
    to = "arm.go([{}, 0.5, 0, -2, 0, 1.5, 0.8])".format
    moves = f"for _ in range(300): {to(0.5)}; {to(-1)}"
    path = example.write("a.py", quick())
    watched = watching("a.py", is_afresh=is_afresh)
    watched.settled()
    below = watched.processes()
    if is_busy:
        before = below
        path.write_text(quick(moves))
        watched.until("a.py changed")
        while not (below := watched.processes()) - before:
            assert watched.process.poll() is None
            time.sleep(0.01)
    assert below
    assert watched.end(number) == code
    assert gone(below)


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--write",), "--write goes with --watch"),
        (("--watch", "--check"), "--check goes with a single run"),
        (("--watch", "--fault", "gripper:stuck@1"), "--fault goes with a single run"),
    ],
)
def test_what_does_not_go_with_it_is_refused(example, quick, arguments, expected):
    example.write("a.py", quick())
    done = example.run("run", "a.py", *arguments)
    assert done.code == 2
    assert expected in done.err


def test_a_check_follows_each_save(watching, example, quick):
    path = example.write("a.py", quick())
    assert example.run("run", "a.py").code == 0
    written = path.read_bytes()
    watched = watching(verb="check")
    watched.until("1 controller checked, 0 to mend")
    watched.settled()
    path.write_bytes(written.replace(b"+= 0.05", b"+= 0.5"))
    watched.until("1 controller checked, 1 to mend")
    watched.settled()
    watched.until_out("stale")
    path.unlink()
    watched.until("1 controller checked, 1 to mend")
    watched.settled()
    watched.until_out("gone")
    path.write_bytes(written)
    watched.until("1 controller checked, 0 to mend")
    watched.settled()
    lock = example.folder / "tracerisk.lock"
    kept = lock.read_bytes()
    lock.write_bytes(b"{")
    assert "[lock]" in watched.until("tracerisk: ")
    watched.settled()
    lock.write_bytes(kept)
    watched.until("1 controller checked, 0 to mend")
    assert watched.end() == 130
