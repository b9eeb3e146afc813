"""What a reviewer does works on Windows and macOS; what runs controllers says what it needs.

The other system is this one without what it lacks: see `tests/other_system.py`.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests import other_system
from tests.slow import slow_but
from tracerisk.cli.shared.output import use_color
from tracerisk.editor.session import path_of

ROOT = Path(__file__).parents[1]
SYSTEMS = ("windows", "macos")
REVIEWERS_TESTS = (
    *(f"tests/cli/test_{name}.py" for name in ("diff", "history", "overrides", "init", "help")),
    *(f"tests/cli/test_{name}.py" for name in ("report", "report_all", "sarif", "solve_linked")),
    *(f"tests/cli/test_{name}.py" for name in ("model_files", "what_if", "hardware", "verdict")),
    *(f"tests/cli/test_{name}.py" for name in ("bad_blocks", "brief", "completion", "lock_merge")),
    *(f"tests/cli/test_{name}.py" for name in ("robots", "hardware_spread", "doctor_settings")),
    *(f"tests/cli/test_{name}.py" for name in ("field", "verbs", "hardware_and_settings")),
    *(f"tests/editor/test_{name}.py" for name in ("figures", "completion", "diagnostics")),
    *("tests/pipeline/check/test_check.py", "tests/pipeline/review/test_review.py"),
    *("tests/cli/serving/test_serve.py", "tests/adder/test_annotate.py"),
)
"""The files of the verbs that work everywhere."""
NEEDS_LINUX = (
    "tracerisk: {} needs Linux, and this is {}; open a shell of Linux with {}`docker run -it --rm "
    "-v .:/work -w /work python:3.13 bash`, and run there `pip install 'tracerisk[sim]'` and this "
    "command again [system]"
)


def elsewhere(system: str, folder: Path, *words: str, **variables: str):
    """Run a command as if on another system; bytes, as a pipe gets them."""
    return subprocess.run(
        [sys.executable, other_system.__file__, system, *words],
        cwd=folder,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        env={**os.environ, "PYTHONPATH": str(ROOT), **variables},
        timeout=300,
        check=False,
    )


@pytest.fixture
def cell(repository, annotated_source):
    """A repository with a controller whose last commit made a motor worse."""
    for figure in ("2e-7", "3e-7"):
        source = annotated_source(
            home=("pick 1", f"motor = {figure} x7"),
            pick=("done 1", "gripper := 1e-7 ! a datasheet"),
        )
        repository.write("cell.py", source)
        repository.commit()
    return repository


COMMANDS = (
    *(
        "check cell.py",
        "build cell.py",
        "solve cell.py --importance",
        "diff HEAD~1 HEAD",
        "history",
    ),
    *("overrides cell.py", "report cell.py -o out.html", "convert cell.py -o out.xml"),
    *("strip --discard-edits cell.py", "init --yes", "hardware schema", "robots", "--help"),
    *("lock-merge --install", "completion bash", "drivers list", "lsp --stdio"),
)


@pytest.mark.slow(but=3)
@pytest.mark.parametrize(
    ("system", "command"),
    slow_but(
        [
            *(("windows", command) for command in COMMANDS[:9]),
            *(("macos", command) for command in COMMANDS[7:9]),
        ],
        [(system, command) for system in SYSTEMS for command in COMMANDS],
    ),
)
def test_a_command_of_reviewers_says_and_writes_what_it_does_on_linux(cell, system, command):
    done = elsewhere(system, cell.folder, *command.split())
    written = cell.files()
    cell.git("reset", "--quiet", "--hard")
    cell.git("clean", "-dfq")
    here = cell.run(*command.split())
    assert done.returncode == here.code, done.stderr.decode()
    assert (done.stdout.decode(), done.stderr.decode()) == (here.out, here.err)
    assert without_index(written) == without_index(cell.files())


def without_index(files: dict[str, bytes]) -> dict[str, bytes]:
    """Files without those that git writes for itself."""
    kept = (".git/config",)
    return {name: data for name, data in files.items() if name[:5] != ".git/" or name in kept}


@pytest.mark.parametrize(
    ("words", "purpose"),
    slow_but(
        [("run cell.py", "running a controller"), ("attach --robot panda", "listening to a robot")],
        [
            ("run cell.py", "running a controller"),
            ("run --watch cell.py", "running a controller"),
            ("trace cell.py", "running a controller"),
            ("scenario cell.py", "running a controller"),
            ("success cell.py", "running a controller"),
            ("evidence cell.py", "trying failures"),
            ("sweep cell.py --over seed=1,2", "sweeping over runs"),
            ("mutate cell.py", "running changes of a controller"),
            ("attach --robot panda", "listening to a robot"),
        ],
    ),
)
@pytest.mark.parametrize("system", slow_but(["windows"], SYSTEMS))
def test_what_runs_a_controller_says_that_it_needs_linux(cell, system, words, purpose):
    before = cell.files()
    done = elsewhere(system, cell.folder, *words.split())
    name, wsl = ("Windows", "`wsl` or ") if system == "windows" else ("macOS", "")
    expected = NEEDS_LINUX.format(purpose, name, wsl)
    assert (done.returncode, done.stderr.decode().splitlines()[-1]) == (2, expected)
    assert cell.files() == before


def test_what_an_encoding_lacks_is_escaped(cell):
    cell.write("größe_π.py", cell.read("cell.py").replace(b"home", "wärme_π".encode()))
    for command in ("solve größe_π.py", "check größe_π.py"):
        done = elsewhere("windows", cell.folder, *command.split(), PYTHONIOENCODING="cp1252")
        assert done.returncode in (0, 1), done.stderr.decode("cp1252")
        assert b"gr\xf6\xdfe_\\u03c0" in done.stdout


def test_a_terminal_of_windows_without_escape_sequences_gets_no_colours(monkeypatch):
    class Kernel:
        def __init__(self, takes: int) -> None:
            self.SetConsoleMode = lambda console, mode: takes and mode & 4
            self.GetStdHandle = abs
            self.GetConsoleMode = lambda console, mode: 1

    for name in ("NO_COLOR", "FORCE_COLOR", "TERM"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
    for takes in (0, 1):
        windll = type("windll", (), {"kernel32": Kernel(takes)})
        monkeypatch.setattr("ctypes.windll", windll, raising=False)
        assert use_color() == bool(takes)


@pytest.mark.parametrize(
    ("uri", "path"),
    [
        ("file:///c%3A/work/pick%20up.py", "c:/work/pick up.py"),
        ("file:///C:/work/cell.py", "C:/work/cell.py"),
        ("file://server/share/cell.py", "//server/share/cell.py"),
        ("untitled:cell.py", None),
    ],
)
def test_an_editor_names_files_on_drives(monkeypatch, uri, path):
    monkeypatch.setattr(sys, "platform", "win32")
    assert path_of(uri) == (None if path is None else Path(path))


def test_the_leftover_of_a_killed_writer_goes_and_no_process_is_ended(cell):
    ours, old = (cell.folder / f".cell.py.{os.getpid()}-{number}.tmp" for number in (0, 1))
    for path in (ours, old):
        path.touch()
    os.utime(old, (time.time() - 7200,) * 2)
    done = elsewhere("windows", cell.folder, "strip", "--discard-edits", "cell.py")
    assert done.returncode == 0, done.stderr.decode()
    assert (ours.exists(), old.exists()) == (True, False)


def test_one_process_at_a_time_writes_in_a_folder(tmp_path):
    program = (
        "import sys; from pathlib import Path\n"
        "from tracerisk.errors import LimitError\n"
        "from tracerisk.pipeline.history import file_lock\n"
        "file_lock.LONGEST_WAIT_S = 0.0\n"
        f"with file_lock.one_writer(Path({str(tmp_path)!r})):\n"
        "    print('locked', flush=True)\n"
        "    sys.stdin.read()\n"
    )
    variables = {"TMPDIR": str(tmp_path / "temporary"), "PYTHONPATH": str(ROOT)}
    (tmp_path / "temporary").mkdir()
    command = [sys.executable, other_system.__file__, "windows", "-c", program]
    first = subprocess.Popen(
        command,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env={**os.environ, **variables},
    )
    assert first.stdout is not None
    assert first.stdout.readline() == b"locked\n"
    second = elsewhere("windows", tmp_path, "-c", program, **variables)
    first.communicate(b"")
    third = elsewhere("windows", tmp_path, "-c", program, **variables)
    assert (first.returncode, second.returncode, third.returncode) == (0, 1, 0)
    assert b"another process has kept this folder locked" in second.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["temporary"]


def test_a_checkout_with_the_line_ends_of_windows_is_as_fresh_as_any(repository, quick):
    repository.write("arm.yaml", repository.run("hardware", "init", "--robot", "panda").out)
    repository.write("pyproject.toml", '[tool.tracerisk]\nhardware = "arm.yaml"\n')
    repository.write("cell.py", quick())
    assert repository.run("run", "cell.py", "--quiet").code == 0
    repository.commit()
    fresh = repository.run("check")
    repository.git("config", "core.autocrlf", "true")
    for name in ("arm.yaml", "pyproject.toml", "cell.py", "tracerisk.lock"):
        repository.write(name, repository.read(name).replace(b"\n", b"\r\n"))
    assert (repository.run("check"), fresh.code) == (fresh, 0)
    assert "unchanged" in repository.run("diff").out
    repository.write("arm.yaml", repository.read("arm.yaml") + b"# another\r\n")
    assert repository.run("check").code == 1


@pytest.mark.slow
@pytest.mark.parametrize("system", SYSTEMS)
@pytest.mark.parametrize("file", REVIEWERS_TESTS)
def test_the_tests_of_reviewers_pass_there(system, file):
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--system", system, file],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-5000:]
