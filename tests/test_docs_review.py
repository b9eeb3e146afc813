"""The commands and the code that docs/review.md shows do what it says."""

import os
import re
import shlex
import subprocess
from pathlib import Path

import pytest

from tests.conftest import program

TEXT = (Path(__file__).parents[1] / "docs" / "review.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", TEXT, re.MULTILINE | re.DOTALL)


@pytest.fixture
def branch(repository, annotated_source):
    """A branch that left main by one commit: a controller changed, another deleted."""

    def source(figure):
        return annotated_source(pick=("done 1", f"gripper = {figure}"))

    repository.write("src/pick.py", source("1e-7"))
    repository.write("gone.py", source("1e-7"))
    repository.commit()
    repository.git("checkout", "--quiet", "-b", "side")
    repository.write("src/pick.py", source("1.05e-7"))
    repository.commit()
    (repository.folder / "gone.py").unlink()
    return repository


@pytest.fixture
def shell(branch, tmp_path):
    """Run commands in that branch, `tracerisk` being the one under test."""
    command = tmp_path / "bin" / "tracerisk"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec {shlex.join(program(os.environ))} "$@"\n')
    command.chmod(0o755)

    def run(script: str) -> str:
        done = subprocess.run(
            ["sh", "-e", "-c", script],
            cwd=branch.folder,
            capture_output=True,
            env={**os.environ, "PATH": f"{command.parent}:{os.environ['PATH']}"},
            check=False,
        )
        assert done.returncode == 0, done.stderr.decode()
        return done.stdout.decode()

    return run


def test_the_commands_that_choose_versions(shell):
    script = next(each for each in blocks("sh") if "tracerisk diff gone.py" in each)
    commands = [line.partition("#")[0] for line in script.splitlines()]
    found = [shell(command).split(":")[0] for command in commands]
    assert found == [
        "gone.py has no risk blocks any more; its mission failed with 1.000e-07.\n\nbefore",
        "The risk of 2 of 2 controllers changed. The greatest change",
        "src/pick.py",
        "src/pick.py",
        "src/pick.py",
        found[0],
    ]


def test_the_commands_of_formats_and_limits(shell):
    script = next(each for each in blocks("sh") if "--format markdown" in each)
    out = shell(script)
    assert out.startswith("<!-- tracerisk-diff -->")
    assert '"verb": "diff"' in out
    assert "mission failure rises from 1.000e-07 to 1.050e-07 (x1.05)" in out


def test_plain_git_diff_as_it_is_set_up(shell):
    script = next(each for each in blocks("sh") if "textconv" in each)
    out = shell(script).splitlines()
    assert out.count("+risk model: mission failure 1.05e-07, per cycle 1.05e-07") == 2
    assert [line for line in out if line.startswith("@@") and line.endswith("def pick(arm):")]


def test_the_library_example_prints_what_the_text_says(capsys):
    (code,) = blocks("python")
    exec(compile(code, "review.md", "exec"), {})
    assert f"This prints `{capsys.readouterr().out.strip()}`." in TEXT
