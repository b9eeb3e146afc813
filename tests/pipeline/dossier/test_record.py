"""What a record says of a figure, and that nothing else than its inputs changes it."""

import hashlib
import json
import os
import subprocess
from dataclasses import replace
from importlib.resources import files

import pytest

from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.common.record import RobotOrigin, record_data
from tracerisk.common.verdict import Coverage, Verdict
from tracerisk.common.version import __version__
from tracerisk.config import Settings
from tracerisk.pipeline.dossier.record import make_record
from tracerisk.trace import RunEnd, Trace

COMMITTED = "2026-03-04T05:06:07+05:30"
TRACE = Trace(
    "arm.py",
    "panda",
    "empty",
    RunEnd("ended", "it returned", 1.0),
    (),
    (),
    (),
    verdict=Verdict("complete", (), Coverage(1, 1)),
    assumptions=("robot: panda, its source names it", "ros_distro: noetic, assumed"),
    files=("gripper.py",),
    inputs=("launch/arm.launch", "urdf/gone.urdf"),
)


@pytest.fixture
def here(repository, monkeypatch):
    """A commit with the files of a controller."""
    repository.write("arm.py", "import gripper\n")
    repository.write("gripper.py", "")
    repository.write("launch/arm.launch", "<launch/>\n")
    repository.write("pyproject.toml", "[tool.tracerisk]\n")
    repository.write("tracerisk.lock", "{}\n")
    repository.write("notes.txt", "notes\n")
    repository.commit()
    identity = {"GIT_COMMITTER_NAME": "a", "GIT_COMMITTER_EMAIL": "a@example.org"}
    subprocess.run(
        ["git", "commit", "-q", "--amend", "--no-edit", "--date", "2020-01-01T00:00:00+00:00"],
        cwd=repository.folder,
        env={**os.environ, **identity, "GIT_COMMITTER_DATE": COMMITTED},
        check=True,
    )
    monkeypatch.chdir(repository.folder)
    return repository


def made(here, settings=None, trace=TRACE, **more):
    sources = {"arm.py": here.read("arm.py")}
    return make_record(
        sources,
        settings or Settings(),
        trace=trace,
        hardware=None if trace is None else hardware_of("panda"),
        **more,
    )


def test_it_names_version_commit_and_every_file_with_its_digest(here):
    record = made(here)
    assert record.version == __version__
    assert record.commit is not None
    assert record.commit.id == here.git("rev-parse", "HEAD").strip()
    assert record.commit.committed == COMMITTED
    assert record.commit.changed == ()
    assert [(file.role, file.path, file.state) for file in record.files] == [
        ("source", "arm.py", "as committed"),
        ("source", "gripper.py", "as committed"),
        ("lock", "tracerisk.lock", "as committed"),
        ("settings", "pyproject.toml", "as committed"),
        ("hardware", "tracerisk/common/hardware/robots/panda.yaml", "with tracerisk"),
        ("other input", "launch/arm.launch", "as committed"),
    ]
    digests = {file.path: file.sha256 for file in record.files}
    assert digests["arm.py"] == hashlib.sha256(b"import gripper\n").hexdigest()


def test_what_differs_from_the_commit_is_named(here):
    here.write("arm.py", "import gripper  # now\n")
    here.write("notes.txt", "other notes\n")
    here.write("cell.yaml", "objects: []\n")
    record = made(here, Settings(scenario="cell.yaml"))
    assert record.commit.changed == ("arm.py", "notes.txt")
    states = {file.path: file.state for file in record.files}
    assert states["arm.py"] == "changed since"
    assert states["cell.yaml"] == "not committed"
    assert states["gripper.py"] == "as committed"


def assume_unchanged(here):
    here.git("update-index", "--assume-unchanged", "gripper.py")


def skip_worktree(here):
    here.git("update-index", "--skip-worktree", "gripper.py")


def clean_filter(here):
    here.git("config", "filter.committed.clean", "git cat-file blob HEAD:gripper.py")
    (here.folder / ".git" / "info" / "attributes").write_text("gripper.py filter=committed\n")


def line_ends(here):
    here.git("config", "core.autocrlf", "input")


def replaced_blob(here):
    (here.folder / "new").write_bytes(b"OPEN = 2\r\n")
    new = here.git("hash-object", "-w", "--no-filters", "new").strip()
    (here.folder / "new").unlink()
    here.git("replace", here.git("rev-parse", "HEAD:gripper.py").strip(), new)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    "hide", [assume_unchanged, skip_worktree, clean_filter, line_ends, replaced_blob]
)
def test_a_change_that_git_is_told_not_to_see_is_named(here, hide):
    here.write("gripper.py", "OPEN = 2\n")
    here.commit()
    before = made(here)
    assert before.commit.changed == ()
    hide(here)
    assert made(here) == before
    (here.folder / "gripper.py").write_bytes(b"OPEN = 2\r\n")
    record = made(here)
    assert {file.path: file.state for file in record.files}["gripper.py"] == "changed since"
    assert record.commit.changed == ("gripper.py",)


@pytest.mark.parametrize("hide", ["--assume-unchanged", "--skip-worktree"])
def test_of_files_without_a_part_in_the_figure_too(here, hide):
    here.git("update-index", hide, "notes.txt")
    assert made(here).commit.changed == ()
    here.write("notes.txt", "other notes\n")
    assert made(here).commit.changed == ("notes.txt",)
    assert made(here, made=(here.folder / "notes.txt",)).commit.changed == ()
    (here.folder / "notes.txt").unlink()
    assert made(here).commit.changed == ()


def test_a_link_is_as_committed_with_its_target_and_what_it_leads_to(here):
    here.write("cell/soft.yaml", "components: {}\n")
    here.write("cell/rosy.yaml", "components: {}\n")
    (here.folder / "own.yaml").symlink_to("./cell/soft.yaml")
    settings = Settings(hardware="own.yaml")

    def state():
        return {file.path: file.state for file in made(here, settings).files}["own.yaml"]

    assert state() == "not committed"
    here.commit()
    assert state() == "as committed"
    here.git("update-index", "--assume-unchanged", "own.yaml", "cell/soft.yaml")
    (here.folder / "own.yaml").unlink()
    (here.folder / "own.yaml").symlink_to("cell/rosy.yaml")
    assert state() == "changed since"
    assert made(here, settings).commit.changed == ("own.yaml",)
    (here.folder / "own.yaml").unlink()
    (here.folder / "own.yaml").symlink_to("./cell/soft.yaml")
    here.write("cell/soft.yaml", "components: {gear: {}}\n")
    assert state() == "changed since"
    assert made(here, settings).commit.changed == ("cell/soft.yaml",)


def test_a_file_that_is_added_and_in_no_commit_is_not_committed(here):
    here.write("cell.yaml", "objects: []\n")
    here.git("add", "cell.yaml")
    states = {file.path: file.state for file in made(here, Settings(scenario="cell.yaml")).files}
    assert states["cell.yaml"] == "not committed"


def test_a_file_that_is_only_touched_is_as_committed(here):
    os.utime(here.folder / "arm.py", (0, 0))
    assert made(here).commit.changed == ()


def test_a_report_in_git_does_not_change_its_own_record(here):
    here.write("report.html", "first")
    here.commit()
    before = made(here, made=(here.folder / "report.html",))
    here.write("report.html", "second")
    assert made(here, made=(here.folder / "report.html",)) == before
    assert made(here).commit.changed == ("report.html",)


def test_the_place_of_the_clone_is_no_part_of_it(here, tmp_path, monkeypatch):
    first = made(here, fingerprint="ab")
    clone = tmp_path / "elsewhere" / "clone"
    subprocess.run(["git", "clone", "-q", str(here.folder), str(clone)], check=True)
    monkeypatch.chdir(clone / "launch")
    sources = {"../arm.py": (clone / "arm.py").read_bytes()}
    hardware = hardware_of("panda")
    second = make_record(sources, Settings(), trace=TRACE, hardware=hardware, fingerprint="ab")
    assert second == first
    assert str(tmp_path) not in str(record_data(second))


def test_outside_git_it_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.py").write_text("")
    record = make_record({"arm.py": b""}, Settings())
    assert record.commit is None
    assert record.no_commit.startswith("git names no commit: is in no git repository")
    assert [file.state for file in record.files] == [""]


def test_without_git_it_says_so(here, monkeypatch):
    monkeypatch.setenv("PATH", "")
    assert made(here).no_commit.startswith("git names no commit: git is not installed")


def test_a_repository_without_a_commit_has_none(repository, monkeypatch):
    monkeypatch.chdir(repository.folder)
    repository.write("arm.py", "")
    record = make_record({"arm.py": b""}, Settings())
    assert (record.commit, record.no_commit) == (None, "the repository has no commit yet")


def test_the_hardware_file_and_the_evidence_are_in_it_if_they_are_used(here):
    here.write("cell/own.yaml", "components: {}\n")
    here.write("tracerisk.evidence", "{}\n")
    paths = {file.path: file.role for file in made(here, Settings(evidence=False)).files}
    assert "tracerisk.evidence" not in paths
    settings = Settings(hardware="cell/own.yaml", evidence=True)
    paths = {file.path: file.role for file in made(here, settings).files}
    assert paths["cell/own.yaml"] == "hardware"
    assert paths["tracerisk.evidence"] == "evidence"
    assert "tracerisk/common/hardware/robots/panda.yaml" not in paths


@pytest.mark.slow(but=3)
@pytest.mark.parametrize(
    ("changes", "settings", "kind"),
    [
        ({}, Settings(), "shipped with tracerisk"),
        ({"inputs": ("urdf/arm.urdf.xacro",)}, Settings(), "own description"),
        ({}, Settings(robot="cell/arm.xml"), "own description"),
        ({}, Settings(robot="panda"), "shipped with tracerisk"),
        ({"robot": "generic"}, Settings(), "assumed"),
        (
            {"assumptions": ("robot: the figures of panda are approximate: some are assumed",)},
            Settings(),
            "assumed",
        ),
    ],
)
def test_whose_description_of_the_robot_was_taken(here, changes, settings, kind):
    trace = replace(TRACE, **{"inputs": (), **changes})
    robot = made(here, settings, trace).robot
    assert robot.kind == kind
    assert robot.name == trace.robot


def test_without_a_run_there_is_no_robot_and_no_outcome(here):
    record = made(here, trace=None)
    assert (record.robot, dict(record.outcome), record.fingerprint) == (None, {}, "")
    assert made(here).robot == RobotOrigin(
        "panda", "own description", ("panda, its source names it",)
    )


def test_a_lock_names_the_file_of_a_scene_from_the_project(example_in, quick, tmp_path):
    example = example_in(tmp_path)
    scene = files("tracerisk.twin.physics.scenes").joinpath("empty.yaml").read_text()
    example.write("cell.scene.yaml", scene)
    example.write("pyproject.toml", '[tool.tracerisk]\nscene = "cell.scene.yaml"\n')
    example.write("controller.py", quick())
    done = example.run("run", "controller.py", "--trace", "trace.json")
    assert done.code == 0, done.err
    assert str(tmp_path) not in example.read("tracerisk.lock").decode()
    assert json.loads(example.read("trace.json"))["scene"] == "cell.scene.yaml"
    assert str(tmp_path) not in done.out
