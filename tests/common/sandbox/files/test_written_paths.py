"""What a controller writes, and is refused, is known by the paths that it gave."""

import os
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import quick_controller
from tracerisk.common.sandbox.files.overlay import Overlay

HOME = "/home/ann-of-nowhere"


@pytest.fixture
def assumed(tmp_path, monkeypatch):
    """Redirect what is written, from a working folder; return the homes that were assumed."""
    work, written = tmp_path / "work", tmp_path / "written"
    work.mkdir()
    written.mkdir()
    monkeypatch.chdir(work)
    homes: list[str] = []
    with Overlay(str(written), (), lambda *_: None, homes.append).active():
        yield homes


@pytest.mark.parametrize(
    "write",
    [
        lambda path: open(path, "w"),  # noqa: PTH123, SIM115
        lambda path: os.open(path, os.O_WRONLY | os.O_CREAT),
        lambda path: Path(path).write_text("up"),
        lambda path: np.savetxt(path, np.eye(2)),
        lambda path: os.mkdir(path),  # noqa: PTH102
    ],
    ids=["open", "os.open", "pathlib", "numpy", "mkdir"],
)
@pytest.mark.parametrize("path", ["lacking/log.txt", "/opt/lacking-of-nowhere/log.txt"])
def test_a_folder_that_is_lacking_is_named_as_it_was_given(assumed, write, path):
    with pytest.raises(FileNotFoundError) as refused:
        write(path)
    assert refused.value.filename == path
    assert "written" not in str(refused.value)
    assert not assumed


def test_the_names_of_a_move_are_those_that_were_given(assumed):
    Path("log.txt").write_text("up")
    with pytest.raises(FileNotFoundError) as refused:
        os.rename("log.txt", "lacking/log.txt")  # noqa: PTH104
    assert refused.value.filename.endswith("/work/log.txt") or refused.value.filename == "log.txt"
    assert "written" not in str(refused.value)


def test_a_log_in_the_home_of_the_author_is_written_and_reported_once(assumed):
    for name in ("log.txt", "runs/deep/log.txt"):
        with open(f"{HOME}/{name}", "a+") as stream:  # noqa: PTH123
            stream.write("up")
        assert Path(f"{HOME}/{name}").read_text() == "up"
    os.makedirs(f"{HOME}/more", exist_ok=True)  # noqa: PTH103
    assert assumed == [HOME]
    assert not os.path.lexists(f"{HOME}-of-another")


def test_a_run_says_where_the_log_went(example):
    log = f"open('{HOME}/poses.log', 'w').write('1')"
    example.write("cell/turn.py", quick_controller("arm.go(joints, wait=True)", log))
    outcome = example.run("trace", "cell/turn.py", "--sandbox", "require", "--json")
    assert outcome.code == 0, outcome.err
    (reason,) = (r for r in outcome.json["verdict"]["reasons"] if r["code"] == "input-assumed")
    assert reason["words"].startswith(f"{HOME} is not here")
    assert reason["location"]["file"] == "turn.py"


def test_what_an_opener_opens_in_another_folder_is_not_what_was_written_in_this_one(assumed):
    Path("poses.yaml").write_text("written")
    there = os.open("/usr", os.O_RDONLY)
    with pytest.raises(FileNotFoundError):
        open("poses.yaml", opener=lambda path, flags: os.open(path, flags, dir_fd=there))  # noqa: SIM115
    os.close(there)
    with open("poses.yaml", opener=os.open) as stream:
        assert stream.read() == "written"
