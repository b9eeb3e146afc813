"""How the end of a process is waited for that was started afresh."""

import os
import subprocess
import time

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
