"""A path of the author's machine or start leads to the same file here, and is reported."""

import os
from pathlib import Path

import pytest

from tests.conftest import quick_controller
from tracerisk.common.sandbox.files.moved_files import MovedFiles
from tracerisk.pipeline.workspace.package_folders import name_of

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


@pytest.mark.parametrize(
    ("rules", "more", "is_found"),
    [
        ("('share/arm', ['arm/places/pose.yaml'])", "", True),
        ("('share/arm', glob('arm/places/*'))", "", True),
        ("('share/arm', ['package.xml'])", "", False),
        ("('share/arm', ['arm/places/pose.yaml'])", "old/pose.yaml", False),
        ("('share/arm', ['arm/places/pose.yaml'])", "build/arm/pose.yaml", True),
    ],
)
def test_a_file_that_a_build_puts_elsewhere_is_found_in_the_sources(
    workspace, rules, more, is_found
):
    arm, found = workspace
    for name in ("arm/places/pose.yaml", *([more] if more else [])):
        (arm / name).parent.mkdir(parents=True, exist_ok=True)
        (arm / name).write_text("home: 1\n")
    (arm / "setup.py").write_text(f"setup(data_files=[{rules}])\n")
    assert (arm / "pose.yaml").is_file() is is_found
    assert ([str(arm / "pose.yaml")] == list(found)) is is_found


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


@pytest.mark.slow(but=1)
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


@pytest.fixture
def started_elsewhere(tmp_path, monkeypatch):
    """Return the starts of a program, and what was found in them in place of another path."""
    starts = [tmp_path / "clone/arm/scripts", tmp_path / "clone/arm", tmp_path / "clone"]
    for folder in starts:
        folder.mkdir(parents=True, exist_ok=True)
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    found: dict[str, str] = {}
    with MovedFiles({}, tmp_path, found.__setitem__, starts).active():
        yield starts, found


@pytest.mark.parametrize("start", [0, 1, 2])
@pytest.mark.parametrize("path", ["gains.txt", "data/gains.txt", "./data/../gains.txt"])
def test_a_relative_file_is_found_where_its_author_starts(started_elsewhere, start, path):
    starts, found = started_elsewhere
    (starts[start] / "data").mkdir()
    (starts[start] / path).write_text("1.5\n")
    assert os.path.exists(path)  # noqa: PTH110 - as controllers ask
    assert Path(path).read_text() == "1.5\n"
    assert Path.cwd().joinpath(path).read_text() == "1.5\n"
    assert found[path] == f"{starts[start]}/{path}"


def test_the_file_beside_the_program_goes_before_the_one_at_the_top(started_elsewhere):
    starts, _ = started_elsewhere
    for number, folder in enumerate(starts):
        (folder / "gains.txt").write_text(str(number))
    assert Path("gains.txt").read_text() == "0"
    Path("gains.txt").write_text("here")
    assert (Path("gains.txt").read_text(), (starts[0] / "gains.txt").read_text()) == ("here", "0")


@pytest.mark.parametrize("path", ["none.txt", "scripts", "../beside.txt", ""])
def test_no_folder_and_nothing_outside_is_found_by_a_relative_path(started_elsewhere, path):
    starts, found = started_elsewhere
    (starts[0] / "beside.txt").write_text("1\n")
    assert not os.path.exists(path)  # noqa: PTH110 - as controllers ask
    assert not found


def test_a_run_with_a_file_beside_its_script_is_partial_and_says_so(example):
    example.write("cell/scripts/angle.txt", "0.05\n")
    lines = ('joints[0] += float(open("angle.txt").read())', "arm.go(joints, wait=True)")
    example.write("cell/scripts/turn.py", quick_controller(*lines))
    outcome = example.run("trace", "cell/scripts/turn.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["verdict"]["kind"] == "partial"
    reasons = outcome.json["verdict"]["reasons"]
    (reason,) = (each for each in reasons if each["code"] == "input-assumed")
    assert (reason["object"], reason["location"]["file"]) == ("angle.txt", "turn.py")


def test_what_our_own_code_looks_for_is_no_file_of_the_program(started_elsewhere):
    starts, found = started_elsewhere
    (starts[0] / "package.xml").write_text("<package><name>arm</name></package>")
    assert name_of(Path.cwd()) != "arm"
    assert not found
    assert Path("package.xml").is_file()
    assert list(found) == ["package.xml"]


@pytest.mark.parametrize("start", [0, 1, 2])
@pytest.mark.parametrize("kept", ["data/gains.txt", "gains.txt", "homework/data/gains.txt"])
def test_a_path_without_a_package_is_found_by_its_end(started_elsewhere, start, kept):
    starts, found = started_elsewhere
    path = "/home/ann-of-nowhere/disk/homework/data/gains.txt"
    here = starts[start] / kept
    here.parent.mkdir(parents=True, exist_ok=True)
    here.write_text("1.5\n")
    assert Path(path).read_text() == "1.5\n"
    assert found == {path: str(here)}


def test_the_longest_end_of_a_path_goes_before_what_is_nearer(started_elsewhere):
    starts, _ = started_elsewhere
    (starts[0] / "gains.txt").write_text("near")
    (starts[2] / "data").mkdir()
    (starts[2] / "data" / "gains.txt").write_text("alike")
    assert Path("/home/ann-of-nowhere/data/gains.txt").read_text() == "alike"


@pytest.mark.parametrize(
    "path",
    [
        "/tmp/of-no-program/gains.txt",
        "/home/ann-of-nowhere/.config/gains.txt",
        "/gains.txt",
        "/home/ann-of-nowhere/gains.py",
    ],
)
def test_what_may_be_of_this_machine_is_not_found_by_its_end(started_elsewhere, path):
    starts, found = started_elsewhere
    (starts[0] / "gains.txt").write_text("1.5\n")
    (starts[0] / "gains.py").write_text("")
    with pytest.raises(FileNotFoundError):
        Path(path).read_text()
    assert not found


def test_a_file_that_was_found_elsewhere_is_removed_for_the_program_alone(started_elsewhere):
    starts, _ = started_elsewhere
    log, here = Path("/home/ann-of-nowhere/cell/log.csv"), starts[0] / "log.csv"
    here.write_text("1\n")
    assert log.exists()
    log.unlink()
    assert not log.exists()
    assert here.read_text() == "1\n"
    with pytest.raises(FileNotFoundError):
        os.remove(log)  # noqa: PTH107 - as controllers do
