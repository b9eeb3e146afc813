"""A package that cannot be imported is named, with the interpreter and what to do."""

import os
import re
import subprocess
from pathlib import Path

import pytest

from tests.other_python import python_with
from tests.slow import slow_but
from tracerisk.common import dependencies
from tracerisk.common.version import __version__
from tracerisk.errors import DependencyError, ExitCode

CONTROLLER = "def home(arm):\n    arm.go()\n"


@pytest.fixture
def command(tmp_path):
    """Runs tracerisk where a module cannot be imported; returns the code, both outputs, Python."""

    def call(*words: str, broken: str) -> tuple[int, str, Path]:
        folder = tmp_path / "broken"
        folder.mkdir()
        (folder / f"{broken}.py").write_text(
            f"raise ImportError('lib{broken}.so: cannot open shared object file', name='{broken}')\n"
        )
        (tmp_path / "cell").mkdir()
        (tmp_path / "cell" / "cell.py").write_text(CONTROLLER)
        python = python_with(tmp_path / "python", folder)
        done = subprocess.run(
            [python, "-m", "tracerisk", *words],
            cwd=tmp_path / "cell",
            capture_output=True,
            text=True,
        )
        return done.returncode, done.stdout + done.stderr, python

    return call


@pytest.mark.parametrize("module", slow_but(["mujoco"], ["mujoco", "daqp", "libcst"]))
def test_a_run_names_the_module_the_interpreter_and_what_to_do(command, module):
    code, out, python = command("run", "cell.py", "--robot", "panda", broken=module)
    assert code == ExitCode.BAD_INPUT
    last = out.strip().splitlines()[-1]
    assert last.startswith(f"tracerisk: module '{module}' cannot be imported by Python 3.")
    assert f"({python}): lib{module}.so: cannot open shared object file; install" in last
    assert f"pip install --force-reinstall --only-binary=:all: {module}`" in last
    assert last.endswith("[dependency]")
    assert "this is a fault of tracerisk" not in out
    if module == "mujoco":
        text = (Path(__file__).parents[2] / "docs" / "errors.md").read_text(encoding="utf-8")
        (shown,) = re.findall(r"^tracerisk: module 'mujoco' .*$", text, re.MULTILINE)
        assert re.fullmatch(".*".join(map(re.escape, shown.split("..."))), last)


def test_doctor_names_each_package_that_cannot_be_imported(command):
    code, out, _ = command("doctor", broken="daqp")
    assert code == ExitCode.INTERNAL_FAULT
    assert "daqp: FAILS: module 'daqp' cannot be imported" in out
    assert "mujoco 3." in out


def test_a_module_that_is_not_ours_is_no_dependency():
    assert dependencies.distribution_of(ImportError("x", name="my_vision")) is None
    assert dependencies.distribution_of(ImportError("x", name="PIL._imaging")) == "pillow"


def test_the_version_of_a_package_that_is_there_is_given():
    assert dependencies.version_of("numpy").startswith("2.")
    with pytest.raises(KeyError):
        dependencies.version_of("my_vision")
    assert issubclass(DependencyError, ImportError)


def test_a_namespace_package_is_installed_and_a_folder_of_a_name_is_not(tmp_path, monkeypatch):
    assert dependencies.is_installed("rosbags")
    (tmp_path / "spare").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(dependencies.MODULES, "spare", "spare")
    assert not dependencies.is_installed("spare")


def test_an_internal_error_keeps_a_log_to_send(tmp_path):
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken" / "libcst.py").write_text("raise RuntimeError('no such node')\n")
    (tmp_path / "cell.py").write_text(CONTROLLER)
    python = python_with(tmp_path / "python", tmp_path / "broken")
    cache = tmp_path / "cache"

    def trace() -> tuple[int, str]:
        done = subprocess.run(
            [python, "-m", "tracerisk", "trace", "cell.py", "--robot", "panda"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            env={**os.environ, "XDG_CACHE_HOME": str(cache)},
        )
        return done.returncode, done.stderr.strip().splitlines()[-1]

    log = cache / "tracerisk" / "error.log"
    code, last = trace()
    assert code == ExitCode.INTERNAL_FAULT
    assert last == (
        f"tracerisk: this is an internal error of tracerisk; please report it with the file {log}"
    )
    kept = log.read_text()
    assert kept.startswith(f"tracerisk {__version__}\ncommand: ['trace', 'cell.py',")
    assert "mujoco 3." in kept
    assert kept.endswith("RuntimeError: no such node\n")
    # Without a place for the log the lines above have to do.
    log.unlink()
    log.parent.rmdir()
    log.parent.write_text("a file")
    assert trace() == (
        ExitCode.INTERNAL_FAULT,
        "tracerisk: this is an internal error of tracerisk; please report it with the lines above",
    )
