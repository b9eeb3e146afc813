"""A run whose files are replaced while it goes on, as editors save them."""

import contextlib
import threading
import time
from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tracerisk.api import load_controller, trace_controller
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.errors import InputError
from tracerisk.pipeline.run.ended_run import ProcessEnd, _replaced_file

contained = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")


@contextlib.contextmanager
def saved_endlessly(*files: Path):
    """Save files as they are, again and again, by renaming a new file: some hundred times a second.

    Whatever reads one of them by its name meets another file than the one of a moment before.
    """
    over, sources = threading.Event(), {file: file.read_bytes() for file in files}

    def save() -> None:
        while not over.wait(0.002):
            for file, source in sources.items():
                copy = file.with_name(f".{file.name}.swp")
                copy.write_bytes(source)
                copy.replace(file)

    thread = threading.Thread(target=save)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@contained
def test_a_run_goes_well_although_its_sources_are_saved_all_the_time(example):
    script = example.write("c.py", quick_controller("import late; assert late.STEP"))
    late = example.write("late.py", "STEP = 1\n")
    example.write(".git/HEAD", "ref: refs/heads/main\n")  # so that files are let in one by one
    quiet = example.run("trace", "c.py", "--json")
    with saved_endlessly(script, late):
        outcome = example.run("trace", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json == quiet.json


@pytest.fixture
def read_by_run(example):
    """A controller, its settings, and a file that its run reads."""
    script = example.write("c.py", quick_controller("assert rospy.get_param('/step') == 1"))
    params = example.write("params.yaml", "step: 1\n")
    controller = load_controller(script)
    return controller, controller.settings_with({"params": (str(params),)}), params


def set_clock(monkeypatch, ahead_s: float) -> None:
    """Let the clock be so far ahead of the one by which files are dated."""
    monkeypatch.setattr(time, "time_ns", lambda: int((time.time() + ahead_s) * 1e9))


@contained
@pytest.mark.parametrize("ahead_s", [0, 3600])
def test_a_run_says_that_a_file_which_it_read_was_changed_meanwhile(
    read_by_run, ahead_s, monkeypatch
):
    """Also where the clock was ahead as it began, and was set back before it ended."""
    controller, settings, params = read_by_run
    assert trace_controller(controller, settings).end.is_good

    def save(phase: str, _: float) -> None:
        if phase == "attributing":
            params.write_text("step: 2\n")
            set_clock(monkeypatch, 0)

    set_clock(monkeypatch, ahead_s)
    with pytest.raises(InputError, match="was changed while the run went on; run the same") as no:
        trace_controller(controller, settings, progress=save)
    assert no.value.location is not None
    assert no.value.location.file.endswith("params.yaml")


@contained
def test_a_file_that_is_dated_in_the_future_was_not_changed_meanwhile(read_by_run, monkeypatch):
    controller, settings, _ = read_by_run
    set_clock(monkeypatch, -3600)
    assert trace_controller(controller, settings).end.is_good


@contained
def test_a_file_that_the_controller_writes_for_good_may_change(example):
    params = example.write("log/params.yaml", "step: 1\n")
    script = example.write("c.py", quick_controller(f"open({str(params)!r}, 'w').write('step: 2')"))
    controller = load_controller(script)
    given = {"params": (str(params),), "writable": (str(params.parent),)}
    trace = trace_controller(controller, controller.settings_with(given))
    assert trace.end.is_good, trace.end
    assert params.read_text() == "step: 2"


def end_of(path: Path) -> ProcessEnd:
    return ProcessEnd(1, last_line=f"PermissionError: [Errno 13] Permission denied: '{path}'")


def test_only_a_file_of_the_controller_that_can_be_read_came_too_late(tmp_path):
    file = tmp_path / "c.py"
    file.write_text("")
    assert _replaced_file(end_of(file), tmp_path) == file
    assert _replaced_file(end_of(tmp_path / "gone.py"), tmp_path) is None
    assert _replaced_file(end_of(Path("/etc/hostname")), tmp_path) is None
    assert _replaced_file(ProcessEnd(1, last_line="ValueError: no"), tmp_path) is None
