"""A process that is started afresh: whose modules it has, and how its end is waited for."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tracerisk.common.sandbox import process


def test_a_wait_for_a_process_looks_for_its_end_only_once(monkeypatch: pytest.MonkeyPatch):
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    # It reads its input to the end.
    child = process.start("code", sandbox=None, environment=dict(os.environ), **pipes)
    assert child.stdin is not None
    naps: list[float] = []
    monkeypatch.setattr(time, "sleep", naps.append)
    began = time.monotonic()
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(0.1)
    assert time.monotonic() - began >= 0.1
    child.stdin.close()
    assert child.wait(60.0) == 0
    assert child.wait(60.0) == 0
    assert naps == []


OF_CHILD = """
import sys
print(sorted({module.__file__ for name, module in sys.modules.items() if "tracerisk" in name}))
"""
OF_PARENT = f"""
import os, subprocess
from tracerisk.common.sandbox import process
child = process.start("code", sandbox=None, environment=dict(os.environ), stdin=subprocess.PIPE)
child.communicate({OF_CHILD!r}.encode())
"""


def test_a_process_has_all_its_modules_from_where_its_parent_has_them(tmp_path):
    """With half of them from what is installed it would take the other half for a controller's."""
    here = Path(process.__file__).parents[2]
    copy = tmp_path / "tracerisk"
    shutil.copytree(here / "common", copy / "common")
    (copy / "__init__.py").touch()
    shutil.copy(here / "errors.py", copy)
    said = subprocess.run(
        [sys.executable, "-c", OF_PARENT],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert str(copy / "common" / "sandbox" / "files" / "held_files.py") in said
    assert str(here) not in said
