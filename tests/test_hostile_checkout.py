"""Ways in which a file of a checkout could run in CI, or reach a token; none of them works."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.slow import slow_but, slow_but_every
from tests.test_action import ACTION, ROOT, Runner
from tests.test_gitlab_template import TEMPLATE, job, server  # noqa: F401 - fixtures

SECRET = "t0ken-of-the-checkout"

pytestmark = pytest.mark.skipif(
    not ACTION.is_file() or shutil.which("bash") is None or shutil.which("curl") is None,
    reason="needs the repository, bash and curl",
)

MODULES = (
    *("venv", "pip", "pathlib", "json", "queue", "tracerisk", "sitecustomize", "usercustomize"),
    *("encodings", "ruamel", "setuptools", "os", "runpy", "importlib", "zipimport", "site"),
)
PROGRAMS = (
    *("git", "python", "python3", "od", "tr", "grep", "gh", "curl", "mktemp", "cat", "head"),
    *("bash", "sh", "dirname", "rm", "cp", "mkdir"),
)
FILES = ("-o pwn.py", "--output=pwn.py", "$(touch dollar).py", "`touch tick`.py", ";touch semi;.py",
         "::error title=t::msg.py", "a\n::add-path::/pwn.py", "##[add-path]pwn.py", "&& touch and.py",
         "'|touch pipe|'.py")  # fmt: skip


class Trap:
    """A checkout full of files that leave a mark if anything runs them."""

    def __init__(self, repository, marks: Path, block: str) -> None:
        self.repository = repository
        self.folder = Path(repository.folder)
        self.marks = marks
        marks.mkdir()
        self._modules()
        self._programs()
        self._settings()
        self._git()
        self._names(block)
        repository.git("add", "--all", "--force")
        repository.commit()
        self.set()

    def set(self) -> None:
        """Forget what was run so far."""
        for each in self.marks.iterdir():
            each.unlink()

    def python(self, name: str) -> str:
        return f"open({str(self.marks / name)!r}, 'w').close()\n"

    def shell(self, name: str) -> str:
        return f"#!/bin/sh\n: >'{self.marks / name}'\n"

    def put(self, name: str, text: str, mode: int = 0o755) -> None:
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(mode)

    def _modules(self) -> None:
        for name in MODULES:
            self.put(f"{name}.py", self.python(f"module-{name}"))
        for name in ("yaml", "numpy", "platformdirs"):
            self.put(f"{name}/__init__.py", self.python(f"package-{name}"))
        self.put("tracerisk_hook.pth", f"import os; {self.python('pth')}")
        self.put("setup.py", self.python("setup"))
        self.put("conftest.py", self.python("conftest"))

    def _programs(self) -> None:
        for name in PROGRAMS:
            self.put(name, self.shell(f"program-{name}"))
            self.put(f"node_modules/.bin/{name}", self.shell(f"bin-{name}"))
        self.put("env.sh", self.shell("bash-env"))

    def _settings(self) -> None:
        self.put("pip.conf", "[install]\nrequire-virtualenv = true\n")
        self.put(
            "pyproject.toml",
            "[build-system]\nrequires = []\nbuild-backend = 'setup'\nbackend-path = ['.']\n",
        )
        self.put("setup.cfg", "[global]\ncommand_packages = setup\n")
        self.put(".curlrc", "output = curlrc\n")
        self.put(".netrc", "machine localhost login a password b\n")
        self.put(".python-version", "../evil\n")

    def _git(self) -> None:
        self.put("hooks/reference-transaction", self.shell("hook-reference-transaction"))
        self.put("hooks/post-checkout", self.shell("hook-post-checkout"))
        self.repository.git("config", "core.hooksPath", "hooks")
        self.put(".gitattributes", "* filter=evil diff=evil\n")
        self.put(".gitmodules", "[submodule 'x']\npath = x\nurl = ext::sh -c touch% ext\n")
        monitor = self.folder / "monitor.sh"
        self.put("monitor.sh", self.shell("bare-fsmonitor"))
        # A folder that git takes for a repository of its own, with settings that name programs.
        bare = "bare"
        self.put(f"{bare}/HEAD", "ref: refs/heads/main\n")
        config = f"[core]\nrepositoryformatversion = 0\nbare = false\nworktree = .\nfsmonitor = {monitor}\n"
        self.put(f"{bare}/config", config)
        for each in ("objects/x", "refs/x"):
            self.put(f"{bare}/{each}", "")

    def _names(self, block: str) -> None:
        for name in FILES:
            self.put(name.replace("/", "-"), block)
        (self.folder / "git-config.py").symlink_to(".git/config")
        (self.folder / "environment.py").symlink_to("/proc/self/environ")
        self.repository.git("config", "http.extraheader", f"AUTHORIZATION: basic {SECRET}")

    @property
    def sprung(self) -> set[str]:
        """What was run: the marks, and what a shell would have made of a name."""
        made = ("dollar", "tick", "semi", "and.py", "pipe", "ext", "curlrc", "pwn.py")
        below = {str(each) for each in made for _ in self.folder.rglob(each)}
        return {each.name for each in self.marks.iterdir()} | below


@pytest.fixture
def trap(repository, annotated_source, tmp_path):
    def block(gripper):
        return annotated_source(place=("done 1", f"gripper = {gripper}"))

    repository.write("cell.py", block("2e-07"))
    base = repository.commit()
    repository.write("cell.py", block("4e-07"))
    found = Trap(repository, tmp_path / "marks", block("4e-07"))
    found.base = base
    return found


def hostile_environment(trap: Trap) -> dict[str, str]:
    """Variables of a careless workflow, which point into the checkout."""
    return {
        "PATH": f".:node_modules/.bin::{Path(sys.executable).parent}:{os.environ['PATH']}",
        "PYTHONPATH": ".",
        "PYTHONUSERBASE": ".",
        "BASH_ENV": "env.sh",
        "ENV": "./env.sh",
        "CDPATH": ".",
    }


def commands_of(log: str) -> list[str]:
    """The lines of a log that a runner takes for commands."""
    found, stopped = [], None
    for line in log.splitlines():
        if stopped is not None:
            stopped = None if line == f"::{stopped}::" else stopped
        elif line.lstrip().startswith("::stop-commands::"):
            stopped = line.rpartition("::")[2]
        elif line.lstrip().startswith("::") or "##[" in line:
            found.append(line)
    return found


@pytest.fixture
def runner(trap, tmp_path):
    folder = tmp_path / "runner"
    folder.mkdir()
    return Runner(folder, trap.repository)


@pytest.mark.parametrize(
    ("working", "asked"),
    slow_but(
        [(".", "all"), (".", ""), ("bare", "all")],
        [(working, asked) for working in (".", "bare") for asked in ("all", "cell.py", "")],
    ),
)
def test_no_file_of_a_checkout_runs_in_the_action(trap, runner, working, asked):
    around = hostile_environment(trap)
    # The runner itself starts bash for each step, with this variable of the workflow.
    del around["BASH_ENV"]
    around["PATH"] = f".:node_modules/.bin::{runner.path}"
    up = "" if working == "." else "../"
    names = [f"{up}{each}" for each in ("cell.py", *FILES, "git-config.py", "environment.py")]
    around["GITHUB_STEP_SUMMARY"] = str(runner.temp / "summary.md")
    runner.run(
        trap.base,
        around=around,
        files={"all": "\n".join(names), "cell.py": f"{up}cell.py", "": ""}[asked],
        may_fail=working == "bare",
        **{"working-directory": working},
    )
    assert trap.sprung == set()
    shown = runner.log + "".join(runner.comments)
    for each in runner.temp.rglob("*"):
        if each.is_file() and "venv" not in each.parts:
            shown += each.read_text(errors="replace")
    assert SECRET not in shown
    assert "GH_TOKEN" not in shown
    for line in commands_of(runner.log):
        assert re.match(r"::(warning|error) title=tracerisk", line), line
    if working == "." and asked != "all":
        assert len(runner.comments) == 1


def test_no_file_of_a_checkout_runs_while_the_action_installs(trap, tmp_path):
    wheel = tmp_path / "tracerisk-0-py3-none-any.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("tracerisk/__init__.py", "")
        archive.writestr("tracerisk/__main__.py", "print('tracerisk 0')")
        archive.writestr(
            "tracerisk-0.dist-info/METADATA", "Metadata-Version: 2.1\nName: tracerisk\nVersion: 0\n"
        )
        archive.writestr(
            "tracerisk-0.dist-info/WHEEL",
            "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
        )
        archive.writestr("tracerisk-0.dist-info/RECORD", "")
    (tmp_path / "temp").mkdir()
    done = subprocess.run(
        ["/bin/bash", "-p", str(ROOT / "action" / "install.sh")],
        cwd=trap.folder,
        env={
            **os.environ,
            **hostile_environment(trap),
            "RUNNER_TEMP": str(tmp_path / "temp"),
            "ACTION": str(wheel),
            "PIP_NO_INDEX": "1",
        },
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "tracerisk 0\n", done.stderr
    assert trap.sprung == set()


def test_no_file_of_a_merge_request_runs_in_the_template(trap, server, job, tmp_path):  # noqa: F811
    for name in ("tracerisk.md", "tracerisk.sarif", "note.json"):
        (trap.folder / name).symlink_to(tmp_path / "outside")
    trap.repository.git("add", "--all", "--force")
    trap.repository.commit()
    trap.set()
    around = hostile_environment(trap)
    around["PATH"] = f".:node_modules/.bin::{Path(sys.executable).parent}:{os.environ['PATH']}"
    job(trap.base, **around, CI_PROJECT_DIR=str(trap.folder))
    assert trap.sprung == set()
    assert not (tmp_path / "outside").exists()
    shown = "".join(server.notes)
    for name in ("tracerisk.md", "tracerisk.sarif"):
        shown += (trap.folder / name).read_text() if (trap.folder / name).exists() else ""
    assert SECRET not in shown
    assert "TRACERISK_TOKEN" not in shown


@pytest.mark.parametrize("name", slow_but_every(3, MODULES[:9]))
def test_the_trap_works_where_nobody_is_careful(trap, name):
    """Without isolation the current folder's modules are taken: the marks are no decoration."""
    code = "import sys; sys.path.insert(0, '.'); sys.modules.pop(sys.argv[1], None); __import__(sys.argv[1])"
    subprocess.run(
        [sys.executable, "-S", "-c", code, name], cwd=trap.folder, check=False, capture_output=True
    )
    assert f"module-{name}" in trap.sprung


def test_the_traps_of_git_work_where_nobody_is_careful(trap):
    subprocess.run(["git", "update-ref", "refs/x/y", "HEAD"], cwd=trap.folder, check=True)
    subprocess.run(["git", "status"], cwd=trap.folder / "bare", check=False, capture_output=True)
    assert {"hook-reference-transaction", "bare-fsmonitor"} <= trap.sprung
