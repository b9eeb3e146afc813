"""A path of the author's machine leads to the same file of the workspace here, and is reported."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tracerisk.sandbox.moved_files import MovedFiles

THEIRS = "/home/ann-of-nowhere/arm_ws"


@pytest.fixture
def workspace(tmp_path):
    """Return the folder of a package and what was found in it in place of another path."""
    arm = tmp_path / "clone" / "arm"
    (arm / "config").mkdir(parents=True)
    (arm / "config" / "poses.yaml").write_text("up: 1\n")
    found: dict[str, str] = {}
    with MovedFiles({"arm": arm}, tmp_path / "clone", found.__setitem__).active():
        yield arm, found


@pytest.mark.parametrize(
    "path",
    [
        f"{THEIRS}/src/arm/config/poses.yaml",
        f"{THEIRS}/install/arm/share/arm/config/poses.yaml",
    ],
)
def test_a_file_is_found_and_read_and_its_folder_is_not(workspace, path):
    arm, found = workspace
    assert os.path.exists(path)  # noqa: PTH110 - as controllers ask
    with open(path) as stream:  # noqa: PTH123
        assert stream.read() == "up: 1\n"
    assert Path(path).read_text() == "up: 1\n"
    assert not Path(path).parent.exists()
    assert found[path] == str(arm / "config" / "poses.yaml")


@pytest.mark.parametrize(
    "path",
    [
        f"{THEIRS}/src/arm/config/none.yaml",
        f"{THEIRS}/src/another/config/poses.yaml",
        "/etc/arm/config/poses.yaml",
        "arm/config/poses.yaml",
    ],
)
def test_what_is_nowhere_stays_so(workspace, path):
    _, found = workspace
    with pytest.raises(FileNotFoundError):
        open(path)  # noqa: PTH123, SIM115
    assert not found


def test_what_lacks_in_the_workspace_itself_is_not_looked_for_in_another_package(workspace):
    arm, found = workspace
    assert not (arm.parent / "src" / "arm" / "config" / "poses.yaml").exists()
    assert not found


def test_what_is_written_goes_where_it_is_meant_and_is_read_from_there(workspace, tmp_path):
    arm, found = workspace
    with pytest.raises(FileNotFoundError):
        Path(f"{THEIRS}/src/arm/config/log.txt").write_text("a line")
    there = tmp_path / "other" / "arm" / "config" / "poses.yaml"
    assert there.read_text() == "up: 1\n"
    there.parent.mkdir(parents=True)
    there.write_text("up: 3\n")
    assert there.read_text() == "up: 3\n"
    assert (arm / "config" / "poses.yaml").read_text() == "up: 1\n"
    assert list(found) == [str(there)]


def test_what_is_there_is_taken_as_it_is(workspace, tmp_path):
    _, found = workspace
    other = tmp_path / "elsewhere" / "arm" / "config"
    other.mkdir(parents=True)
    (other / "poses.yaml").write_text("up: 2\n")
    assert (other / "poses.yaml").read_text() == "up: 2\n"
    assert not found


@pytest.mark.parametrize("mode", ["auto", "off"])
def test_a_run_with_such_a_path_is_partial_and_says_so(example, mode):
    example.write("cell/package.xml", "<package format='3'><name>cell</name></package>")
    example.write("cell/config/angle.txt", "0.05\n")
    path = f"{THEIRS}/src/cell/config/angle.txt"
    example.write(
        "cell/turn.py",
        quick_controller(f"joints[0] += float(open({path!r}).read())", "arm.go(joints, wait=True)"),
    )
    outcome = example.run("trace", "cell/turn.py", "--sandbox", mode, "--json")
    assert outcome.code == 0, outcome.err
    verdict = outcome.json["verdict"]
    assert verdict["kind"] == "partial"
    (reason,) = (each for each in verdict["reasons"] if each["code"] == "input-assumed")
    assert reason["object"] == path
    assert "config/angle.txt of the workspace is taken for it" in reason["words"]
    assert reason["location"]["file"] == "turn.py"
