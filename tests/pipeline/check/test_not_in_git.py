"""A lock or an input of a run that git does not track: a clone would lack it."""

import pytest

HARDWARE = 'components:\n  motor: {probability: {value: 1e-07, per: visit}, twin: {joints: "*"}}\n'
LOG = "Function:home()\nActiveComponents:motor\n\nCallSequence:home()\n"
SOURCE = "def home(arm):\n    arm.go()\n"


@pytest.fixture
def cell(repository):
    """A controller that git tracks as it was before its blocks were written."""
    repository.write("arm.yaml", HARDWARE)
    repository.write("run.log", LOG)
    repository.write("cell.py", SOURCE)
    repository.git("add", "cell.py")
    annotated = repository.run("annotate", "cell.py", "--log", "run.log", "--hardware", "arm.yaml")
    assert annotated.code == 0, annotated.err
    return repository


def test_nothing_is_asked_for_before_the_blocks_are_staged(cell):
    outcome = cell.run("check")
    assert outcome.code == 0, outcome.out


def test_blocks_that_are_staged_without_lock_and_hardware_do_not_pass(cell):
    cell.git("add", "cell.py")
    outcome = cell.run("check")
    assert outcome.code == 1
    assert (
        "cell.py:1: untracked: git tracks the blocks, but not tracerisk.lock, arm.yaml; a clone "
        "would lack that: `git add tracerisk.lock arm.yaml`\n"
    ) in outcome.out
    cell.git("add", "tracerisk.lock")
    assert "git tracks the blocks, but not arm.yaml;" in cell.run("check", "cell.py").out
    cell.git("add", "arm.yaml")
    assert cell.run("check").code == 0


def test_a_clone_of_its_own_inside_of_the_repository_is_not_checked_with_it(cell):
    cell.git("add", "cell.py", "tracerisk.lock", "arm.yaml")
    cell.git("clone", "--quiet", ".", "copy")
    for name in ("cell.py", "tracerisk.lock", "arm.yaml"):
        cell.write(f"copy/{name}", cell.read(name))
    assert "1 controller checked" in cell.run("check").err
    assert "1 controller checked" in cell.run("check", "copy").err
    (cell.folder / "copy/tracerisk.lock").unlink()
    assert "1 controller checked" in cell.run("check").err


def test_a_lock_that_git_ignores_does_not_pass(cell):
    cell.write(".gitignore", "*.lock\n")
    cell.git("add", "cell.py", "arm.yaml")
    outcome = cell.run("check")
    assert outcome.code == 1
    assert "but not tracerisk.lock; a clone would lack that: `git add --force" in outcome.out
    cell.git("add", "--force", "tracerisk.lock")
    assert cell.run("check").code == 0


def test_inputs_that_git_ignores_and_blocks_that_it_does_not_track_ask_for_nothing(cell):
    cell.write(".gitignore", "arm.yaml\n")
    cell.git("add", "cell.py", "tracerisk.lock")
    assert cell.run("check").code == 0
    (cell.folder / ".gitignore").unlink()
    assert cell.run("check").code == 1
    cell.git("rm", "--cached", "--quiet", "cell.py")
    assert cell.run("check").code == 0


def test_ends_of_lines_as_another_system_has_them_are_no_change(cell):
    cell.git("config", "core.autocrlf", "true")
    text = cell.read("cell.py")
    cell.write("cell.py", text.replace(b"\n", b"\r\n"))
    cell.git("add", "cell.py")
    assert "untracked: " in cell.run("check").out


def test_no_filter_of_the_repository_runs(cell):
    cell.write(".gitattributes", "*.py filter=mine\n")
    cell.git("add", "cell.py")
    cell.git("config", "filter.mine.clean", "touch ran; cat")
    assert "untracked: " in cell.run("check").out
    assert not (cell.folder / "ran").exists()
