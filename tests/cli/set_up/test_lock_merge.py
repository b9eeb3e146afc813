"""`tracerisk lock-merge`, by hand and as git's driver, and what git leaves without it."""

import json
import os
import re
import shutil
import subprocess
import sys

import pytest

from tests.conftest import RepositoryExample
from tests.slow import slow_but

HARDWARE = """\
components:
  motor: {{probability: {{value: {motor}, per: visit}}, quantity: 7, twin: {{joints: '*'}}}}
  gripper: {{probability: {{value: 2e-08, per: visit}}, quantity: 1, twin: {{joints: '*'}}}}
"""
LOG = "Function:home()\nActiveComponents:{}\n\nCallSequence:home()\n"
CODE = "def home(arm):\n    arm.go()\n"
LOCK = "tracerisk.lock"


@pytest.fixture(scope="module")
def both_once(tmp_path_factory):
    repository = RepositoryExample.empty(tmp_path_factory.mktemp("both"))
    refresh(repository, "motor")
    repository.write("other.py", CODE)
    refresh(repository, "motor", file="other.py")
    repository.commit()
    repository.git("branch", "theirs")
    repository.git("checkout", "--quiet", "-b", "ours")
    repository.write("c.py", repository.read("c.py").decode() + "    arm.go()\n")
    refresh(repository, "motor", figure="3e-08")
    repository.commit()
    repository.git("checkout", "--quiet", "theirs")
    repository.write("c.py", repository.read("c.py").decode().replace("def", "import os\n\n\ndef"))
    refresh(repository, "motor,gripper")
    repository.commit()
    repository.git("checkout", "--quiet", "ours")
    return repository


@pytest.fixture
def two_branches(repository, both_once):
    """Branch `ours` changed the motor, branch `theirs` the gripper; both were refreshed."""
    shutil.copytree(both_once.folder, repository.folder, dirs_exist_ok=True)
    return repository


def refresh(
    repository,
    components: str,
    *,
    figure: str = "1e-08",
    file: str = "c.py",
    called: str = "home",
):
    if not (repository.folder / file).exists():
        repository.write(file, CODE)
    repository.write("arm.yaml", HARDWARE.format(motor=figure))
    repository.write("run.log", LOG.format(components).replace("home", called))
    options = ("--log", "run.log", "--hardware", "arm.yaml", "--quiet")
    done = repository.run("annotate", file, *options)
    assert done.code == 0, done.err
    (repository.folder / "run.log").unlink()


def merge(repository) -> str:
    """Merge `theirs`, take theirs of the sources, and return the files in conflict."""
    scripts = repository.folder.parent / "bin"
    scripts.mkdir(exist_ok=True)
    command = scripts / "tracerisk"
    command.write_text(f'#!/bin/sh\nexec {sys.executable} -m tracerisk "$@"\n')
    command.chmod(0o755)
    done = subprocess.run(
        ["git", "-c", "user.name=a", "-c", "user.email=a@b", "merge", "theirs"],
        cwd=repository.folder,
        env={**os.environ, "PATH": f"{scripts}:{os.environ['PATH']}"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stderr
    return repository.git("diff", "--name-only", "--diff-filter=U")


def test_git_merges_the_lock_controller_by_controller(two_branches):
    done = two_branches.run("lock-merge", "--install")
    assert done.code == 0, done.err
    assert two_branches.read(".gitattributes") == b"tracerisk.lock merge=tracerisk-lock\n"
    assert LOCK not in merge(two_branches)
    lock = two_branches.read(LOCK)
    assert b"<<<<<<<" not in lock
    two_branches.git("checkout", "--theirs", "c.py")
    checked = two_branches.run("check")
    assert "edited" not in checked.out + checked.err
    assert "c.py:1: stale" in checked.out
    entries = json.loads(lock)["controllers"]
    assert "others" in entries["c.py"]
    assert "others" not in entries["other.py"]
    refresh(two_branches, "motor,gripper")
    assert two_branches.run("check", "c.py").code == 0


def test_installing_twice_changes_nothing_and_keeps_what_is_there(repository):
    repository.write(".gitattributes", "*.py diff=tracerisk")
    assert repository.run("lock-merge", "--install").code == 0
    files = repository.files()
    assert files[".gitattributes"] == b"*.py diff=tracerisk\ntracerisk.lock merge=tracerisk-lock\n"
    again = repository.run("lock-merge", "--install", "--json")
    assert (again.code, len(again.json["done"])) == (0, 1)
    assert repository.files() == files


# Two tests below begin with lines that git has merged without a driver.
@pytest.mark.parametrize("harm", slow_but(["no tracerisk"], ["no driver", "no tracerisk"]))
def test_where_it_is_not_set_up_git_merges_the_lines(two_branches, harm, monkeypatch):
    if harm == "no driver":
        two_branches.write(".gitattributes", "tracerisk.lock merge=tracerisk-lock\n")
    else:
        assert two_branches.run("lock-merge", "--install").code == 0
        command = two_branches.git("config", "merge.tracerisk-lock.driver")
        gone = command.replace("tracerisk lock-merge", "no-such-command lock-merge")
        two_branches.git("config", "merge.tracerisk-lock.driver", gone)
    assert LOCK in merge(two_branches)
    assert b"<<<<<<<" in two_branches.read(LOCK)


def test_after_a_merge_what_the_tool_wrote_on_a_branch_is_nobodys_edit(two_branches):
    """The sources are those of one branch, and the lock is as git left it."""
    assert LOCK in merge(two_branches)
    two_branches.git("checkout", "--theirs", "c.py")
    two_branches.write("c.py", two_branches.read("c.py").decode() + "    arm.go()\n")
    checked = two_branches.run("check", "c.py")
    assert checked.code == 1, checked.out
    assert ": edited" not in checked.out
    refresh(two_branches, "motor,gripper", figure="3e-08")
    assert two_branches.run("check", "c.py").code == 0
    assert b":=" not in two_branches.read("c.py")


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "how",
    # Where there is no git, the lock is that of ours too.
    slow_but(
        ["no lock", "older lock", "no git"], ["no lock", "older lock", "lock of ours", "no git"]
    ),
)
def test_whatever_became_of_the_lock_a_mixed_block_is_nobodys_edit(two_branches, how):
    """The first line is ours, and so are the figures; a component came with theirs."""
    ours = two_branches.read("c.py").decode()
    merge(two_branches)
    two_branches.git("checkout", "--theirs", "c.py")
    theirs = two_branches.read("c.py").decode()
    section = theirs[theirs.index("    # | @Component {\n    # |   name = gripper") :]
    section = section[: section.index("# | }\n") + len("# | }\n")]
    first = ours.index("    # | @Component {")
    mixed = ours[:first] + section + ours[first:]
    # The code is that of both branches.
    two_branches.write("c.py", mixed.replace("def home", "import os\n\n\ndef home"))
    if how == "no lock":
        (two_branches.folder / LOCK).unlink()
    else:
        side = {"older lock": "HEAD~1", "lock of ours": "HEAD", "no git": "HEAD"}[how]
        two_branches.write(LOCK, two_branches.git("show", f"{side}:{LOCK}") + "\n")
    if how == "no git":
        shutil.rmtree(two_branches.folder / ".git")
    if how != "no lock":
        checked = two_branches.run("check", "c.py")
        assert ": edited" not in checked.out
        assert ":=" not in checked.out
        assert checked.code in (1, 3)
    two_branches.write("arm.yaml", HARDWARE.format(motor="5e-08"))
    two_branches.write("run.log", LOG.format("motor"))
    options = ("--log", "run.log", "--hardware", "arm.yaml", "--quiet")
    done = two_branches.run("annotate", "c.py", *options, "--accept-edits")
    assert done.code in (0, 3)
    assert "a user changed" not in done.err
    assert ":=" not in done.err
    assert b":=" not in two_branches.read("c.py")
    assert two_branches.run("annotate", "c.py", *options, "--discard-edits").code == 0
    assert b"gripper" not in two_branches.read("c.py")


def test_a_figure_of_a_branch_that_did_not_rename_the_function_is_nobodys_edit(repository):
    """Ours renamed the function; a figure of theirs came into its block, and no line else."""
    refresh(repository, "motor")
    repository.commit()
    repository.git("branch", "theirs")
    repository.write("c.py", repository.read("c.py").decode().replace("home", "rest"))
    refresh(repository, "motor", figure="3e-08", called="rest")
    repository.commit()
    ours = repository.read("c.py").decode()
    repository.git("checkout", "--quiet", "theirs")
    refresh(repository, "motor", figure="5e-08")
    repository.commit()
    repository.git("checkout", "--quiet", "-")
    repository.write("c.py", ours.replace("= 3e-08", "= 5e-08").replace("arm.go()", "arm.turn()"))
    checked = repository.run("check", "c.py")
    assert checked.code == 3, checked.out
    assert "rest.motor.probability is 5e-08" in checked.out
    assert "it is unknown" in checked.out
    assert ":=" not in checked.out
    assert ": edited" not in checked.out


def test_blocks_of_an_earlier_version_are_reported_and_written_anew(repository):
    refresh(repository, "motor")
    new = repository.files()
    old = re.sub(rb"(RiskAnnotation) \S+", rb"\1", repository.read("c.py"))
    repository.write("c.py", old)
    lock = json.loads(repository.read(LOCK))
    lock["version"] = 1
    del lock["controllers"]["c.py"]["digest"]
    repository.write(LOCK, json.dumps(lock))
    checked = repository.run("check")
    assert checked.code == 1
    assert "c.py:2: stale: the risk block of home was written by an earlier version" in checked.out
    assert repository.run("refresh").code == 0
    assert repository.files() == new


def test_a_value_of_another_run_in_a_fresh_file_is_stale(two_branches):
    """The whole file of another commit whose code is the same."""
    two_branches.write("c.py", two_branches.read("c.py").decode() + "# A word.\n")
    old = two_branches.read("c.py")
    refresh(two_branches, "motor", figure="9e-08")
    two_branches.write("c.py", old)
    checked = two_branches.run("check", "c.py")
    assert checked.code == 1
    assert "c.py:2: stale: the risk block of home holds values of another run" in checked.out


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ((), "expected three locks, BASE OURS THEIRS, and not 0; or --install"),
        (("a", "b", "c"), "a: there is no such file; git gives three locks"),
        (("--install", "a"), "--install takes no files"),
    ],
)
def test_what_cannot_be_merged_is_an_error(repository, words, expected):
    done = repository.run("lock-merge", *words)
    assert done.code == 2
    assert expected in done.err


def test_a_lock_that_cannot_be_read_is_left_alone(repository):
    for name, text in (("base", ""), ("ours", "{"), ("theirs", "")):
        repository.write(name, text)
    done = repository.run("lock-merge", "base", "ours", "theirs")
    assert done.code == 2
    assert "ours:1:2: is not JSON" in done.err
    assert repository.read("ours") == b"{"


def test_without_a_repository_nothing_is_set_up(example):
    done = example.run("lock-merge", "--install")
    assert done.code == 2
    assert "is in no git repository" in done.err
    assert example.files() == {}
