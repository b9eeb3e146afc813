"""Which parts of the places that a run is given it may read, each looked through once."""

import os
from pathlib import Path

import pytest

from tracerisk.common.sandbox import process
from tracerisk.common.sandbox.readable_parts import readable_parts


def may_read(parts: dict[str, bool], path: Path) -> bool:
    return any(parts.get(str(place)) for place in (path, *path.parents))


@pytest.fixture
def scanned(monkeypatch):
    """Return the folders that are looked through."""
    seen: list[str] = []
    real = os.scandir

    def scandir(folder):
        seen.append(os.fspath(folder))
        return real(folder)

    monkeypatch.setattr(process.os, "scandir", scandir)
    return seen


@pytest.fixture
def workspace(tmp_path):
    for name in (
        "src/arm/arm.py",
        "src/arm/robot.pem",
        "src/.hidden/ws/cell.py",
        "src/b/deep/b.py",
    ):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    return tmp_path


def test_overlapping_places_are_looked_through_once(workspace, scanned):
    source = workspace / "src"
    given = [source / "b", source / "arm", workspace, source, workspace / "src", source / "b/deep"]
    parts = readable_parts([], given)
    assert sorted(scanned) == sorted(set(scanned))
    assert parts == readable_parts([], [workspace])
    assert may_read(parts, source / "arm/arm.py")
    assert may_read(parts, source / "b/deep/b.py")
    assert not may_read(parts, source / "arm/robot.pem")
    assert not may_read(parts, source / ".hidden/ws/cell.py")


@pytest.mark.parametrize("name", [".setup_assistant", ".catkin", ".colcon_install_layout"])
def test_a_hidden_file_that_libraries_of_ros_read_is_read(workspace, name):
    folder = workspace / "src/arm"
    secrets = [folder / secret for secret in (".env", ".netrc", ".git/config", f"{name}.key")]
    for path in (folder / name, *secrets):
        path.parent.mkdir(exist_ok=True)
        path.write_text("")
    parts = readable_parts([], [workspace])
    assert may_read(parts, folder / name)
    assert not any(may_read(parts, path) for path in secrets)


def test_what_lies_in_a_hidden_folder_named_as_such_a_file_is_not_all_read(workspace):
    folder = workspace / "src/arm/.catkin"
    folder.mkdir()
    for name in (".env", "robot.pem"):
        (folder / name).write_text("")
    parts = readable_parts([], [workspace])
    assert not may_read(parts, folder / ".env")
    assert not may_read(parts, folder / "robot.pem")


def test_a_place_within_what_is_hidden_is_read_where_it_is_given(workspace):
    hidden = workspace / "src/.hidden/ws"
    parts = readable_parts([], [workspace, hidden])
    assert may_read(parts, hidden / "cell.py")
    assert not may_read(parts, workspace / "src/arm/robot.pem")


def test_what_is_read_anyway_is_not_looked_through(workspace, scanned):
    installed = workspace / "src/b"
    readable_parts(
        [installed], [installed, installed / "deep", Path("/usr/share"), Path("/opt/ros")]
    )
    assert scanned == [str(installed)]


@pytest.mark.parametrize("depth", [99, 100, 101, 103])
def test_a_key_is_not_read_however_deep_it_lies(tmp_path, depth):
    folder = tmp_path.joinpath(*["d"] * depth)
    folder.mkdir(parents=True)
    for name in ("robot.pem", "poses.yaml"):
        (folder / name).write_text("")
    (tmp_path / "cell.py").write_text("")
    parts = readable_parts([], [tmp_path])
    assert may_read(parts, tmp_path / "cell.py")
    assert not may_read(parts, folder / "robot.pem")
    assert may_read(parts, folder / "poses.yaml") == (depth < 100)
