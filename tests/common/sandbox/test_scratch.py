"""Temporary folders go with their process, or with the next one where it was killed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

from tracerisk.common.sandbox.scratch import new_scratch, remove_ownerless, remove_scratch, scratch

OWNER = """\
import sys, time
from tracerisk.common.sandbox.scratch import new_scratch
print(new_scratch("evidence-"), flush=True)
time.sleep(600)
"""


def begun(top: Path) -> tuple[subprocess.Popen[str], Path]:
    """Start a process that has a folder below `top`."""
    process = subprocess.Popen(
        [sys.executable, "-c", OWNER],
        env={**os.environ, "TMPDIR": str(top)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    return process, Path(process.stdout.readline().strip())


def test_a_folder_is_gone_after_its_use_whatever_was_forbidden_in_it():
    with scratch("cells-") as folder:
        (folder / "deep").mkdir()
        (folder / "deep" / "file").touch()
        (folder / "deep").chmod(0)
    assert not folder.exists()
    assert folder.name.startswith("tracerisk-cells-")


def test_the_folder_of_a_process_that_was_killed_goes_with_the_next(tmp_path):
    killed, left = begun(tmp_path)
    alive, kept = begun(tmp_path)
    other = tmp_path / "tracerisk-of-another"
    other.mkdir()
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    assert left.is_dir()
    remove_ownerless(tmp_path)
    assert not left.exists()
    # One that lives keeps its own, and of another's nothing is known.
    assert kept.is_dir()
    assert other.is_dir()
    third, _ = begun(tmp_path)
    for each in (alive, third):
        each.kill()
        each.wait()


def test_a_folder_that_a_link_leads_to_is_not_removed(tmp_path):
    folder = new_scratch()
    target = tmp_path / "elsewhere"
    target.mkdir()
    (target / ".owner").touch()
    (tmp_path / "tracerisk-link").symlink_to(target)
    remove_ownerless(tmp_path)
    assert target.is_dir()
    remove_scratch(folder)
    assert not folder.exists()


def test_a_process_that_is_forked_removes_nothing_of_its_parents():
    folder = new_scratch()
    child = os.fork()
    if child == 0:
        from tracerisk.common.sandbox import scratch as module

        module._remove_all()
        os._exit(0)
    os.waitpid(child, 0)
    assert folder.is_dir()
    remove_scratch(folder)
