"""What a controller's process hands back is bounded, and nothing in it is taken on trust."""

import fcntl
import os
import time

import pytest

from tests.slow import slow_but_every
from tracerisk.api import trace_controller
from tracerisk.config import Settings
from tracerisk.errors import LimitError, LogError
from tracerisk.pipeline.history import file_lock
from tracerisk.pipeline.run import controller_run, run_folders
from tracerisk.pipeline.workspace.controller import load_controller

CELL = """\
import json, os, sys
import rospy, moveit_commander

def folder():
    return next(
        os.path.dirname(os.readlink(f"/proc/self/fd/{{n}}"))
        for n in range(3, 64)
        if os.path.exists(f"/proc/self/fd/{{n}}")
        and os.readlink(f"/proc/self/fd/{{n}}").endswith("events.jsonl")
    )

def put(text):
    file = os.open(os.path.join(folder(), "events.jsonl"), os.O_WRONLY | os.O_APPEND)
    os.write(file, text.encode())
    os.close(file)

def main():
    rospy.init_node("cell")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    joints = arm.get_current_joint_values()
    joints[0] += 0.02
    arm.go(joints, wait=True)
    FOLDER = folder()
    events = os.path.join(FOLDER, "events.jsonl")
    {attack}

if __name__ == "__main__":
    main()
"""


@pytest.fixture
def attacked(tmp_path):
    """Run a controller that turns on its own recording; where it is, shows only uncontained."""

    def run(attack: str):
        (tmp_path / "cell.py").write_text(CELL.format(attack=attack))
        began = time.monotonic()
        try:
            return trace_controller(load_controller(tmp_path / "cell.py"), Settings(sandbox="off"))
        finally:
            assert time.monotonic() - began < 120

    return run


def test_a_fifo_in_place_of_a_file_holds_nobody_up(attacked):
    with pytest.raises(LogError, match="not a regular file"):
        attacked("os.remove(events); os.mkfifo(events)")


def test_a_recording_that_is_removed_is_reported(attacked):
    with pytest.raises(LogError, match="has removed it"):
        attacked("os.remove(events)")


def test_a_recording_folder_that_is_removed_is_reported(attacked):
    with pytest.raises(LogError, match="has removed it"):
        attacked("import shutil; shutil.rmtree(FOLDER); arm.go([0.0] * 7, wait=True)")


def test_a_process_that_dies_before_it_begins_is_reported_with_its_last_line(attacked, monkeypatch):
    start = controller_run.start_process
    monkeypatch.setattr(
        controller_run,
        "start_process",
        lambda _, *more, **how: start("tracerisk.gone", *more, **how),
    )
    with pytest.raises(RuntimeError, match=r"code 1 before it began: .*tracerisk\.gone"):
        attacked("pass")


@pytest.mark.slow
def test_a_fifo_that_is_looked_at_during_the_run_holds_nobody_up(attacked):
    with pytest.raises(LogError):
        attacked(
            'header = os.path.join(FOLDER, "samples.json"); os.remove(header); os.mkfifo(header)'
            "; arm.go([0.0] * 7, wait=True)"
        )


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["events.jsonl", "contact_bodies.jsonl", "samples.json"])
def test_a_file_that_is_too_large_is_not_read(attacked, name):
    with pytest.raises((LimitError, LogError)):
        attacked(f'os.truncate(os.path.join(FOLDER, "{name}"), 1_500_000_000); os._exit(0)')


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "line",
    slow_but_every(
        2,
        [
            '"[" * 200_000',
            '\'{"event": "note", "ns": 1, "kind": "given", "data": 7}\'',
            '\'{"event": "finding", "ns": "x", "kind": "a", "message": "b", "location": null}\'',
            '\'{"event": "function", "ns": 1, "id": 99, "file": ["a"], "name": "b", "line": 1}\'',
            '\'{"event": "note", "ns": 99999999999999999999999, "kind": "a", "data": {}}\'',
        ],
    ),
)
def test_a_line_that_is_no_event_is_an_error_that_says_so(attacked, line):
    with pytest.raises(LogError, match="not an event of a recording"):
        attacked(f'put({line} + "\\n"); os.kill(os.getpid(), 9)')


def test_a_forged_refusal_is_none(attacked):
    forged = (
        '{"event": "note", "ns": 1, "kind": "failed", "data":'
        ' {"error": "ExitCode", "message": 3, "location": null}}'
    )
    attacked(f"put({forged!r} + chr(10)); os.kill(os.getpid(), 9)")


def test_what_it_was_given_is_not_for_a_controller_to_say(attacked):
    forged = (
        '{"event": "note", "ns": 1, "kind": "launch", "data":'
        ' {"notes": ["forged"], "inputs": ["/dev/zero"]}}'
    )
    trace = attacked(f"put({forged!r} + chr(10)); os.kill(os.getpid(), 9)")
    assert trace.inputs == ()
    assert "forged" not in trace.assumptions


def test_a_folder_that_another_process_keeps_locked_is_waited_for_with_a_limit(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(file_lock, "LONGEST_WAIT_S", 0.2)
    other = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(other, fcntl.LOCK_EX)
    with (
        pytest.raises(LimitError, match="has kept this folder locked"),
        file_lock.one_writer(tmp_path),
    ):
        pass
    os.close(other)
    with file_lock.one_writer(tmp_path):
        pass


def test_a_recording_that_is_kept_has_regular_files_alone(tmp_path):
    recording, kept = tmp_path / "recording", tmp_path / "kept"
    recording.mkdir()
    kept.mkdir()
    (tmp_path / "secret").write_text("SECRET")
    (recording / "events.jsonl").write_text("{}\n")
    (recording / "link").symlink_to(tmp_path / "secret")
    os.mkfifo(recording / "fifo")
    (kept / "events.jsonl").symlink_to(tmp_path / "secret")
    run_folders.keep_recording(recording, kept)
    assert sorted(each.name for each in kept.iterdir()) == ["events.jsonl"]
    assert (tmp_path / "secret").read_text() == "SECRET"
    assert not (kept / "events.jsonl").is_symlink()
