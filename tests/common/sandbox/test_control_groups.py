"""Control groups: found where limits are handed on, and ended with all that is in them.

The trees here are folders that look like those of the kernel; where the machine has cgroup v2 and
lets this user make a group, one of the kernel is ended too.
"""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tracerisk.common.sandbox.kernel.control_groups import (
    end_group,
    enter_group,
    group_folder,
    new_group,
)

UNIFIED = [Path("/sys/fs/cgroup"), Path("/sys/fs/cgroup/unified")]
MEMORY = 800_000_000


def tree(cgroups: Path, **given: str) -> Path:
    """Make a tree of groups: user/app/cell, each with the controllers it hands on."""
    folder = cgroups
    for name in ("", "user", "app", "cell"):
        folder = folder / name
        folder.mkdir(exist_ok=True)
        (folder / "cgroup.procs").write_text("")
        (folder / "cgroup.subtree_control").write_text(given.get(name or "top", ""))
    return folder


@pytest.fixture
def own(tmp_path):
    path = tmp_path / "own"
    path.write_text("8:pids:/elsewhere\n0::/user/app/cell\n")
    return path


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"app": "cpu memory pids"}, "user/app"),
        ({"user": "memory pids", "app": "memory"}, "user"),
        ({"cell": "pids memory", "user": "memory pids"}, "user/app/cell"),
        ({"top": "memory pids"}, "."),
        ({"app": "memory", "user": "pids"}, None),
        ({}, None),
    ],
)
def test_the_nearest_group_that_hands_on_both_limits_is_taken(tmp_path, own, given, expected):
    top = tmp_path / "cgroup"
    tree(top, **given)
    found = group_folder([tmp_path / "absent", top], own)
    assert found == (None if expected is None else top / expected)


def test_there_is_none_without_cgroup_v2(tmp_path):
    only_v1 = tmp_path / "own"
    only_v1.write_text("8:pids:/\n4:memory:/\n")
    assert group_folder([tmp_path], only_v1) is None
    assert group_folder([tmp_path], tmp_path / "absent") is None
    assert new_group(None, MEMORY) is None
    enter_group(None)
    end_group(None)


def test_a_group_has_limits_of_memory_and_processes_and_none_of_time(tmp_path, own):
    top = tmp_path / "cgroup"
    tree(top, app="memory pids")
    group = new_group(group_folder([top], own), MEMORY)
    assert group == top / "user" / "app" / f"tracerisk-{os.getpid()}"
    assert int((group / "memory.max").read_text()) == MEMORY * 9 // 8
    assert int((group / "pids.max").read_text()) == 4096
    assert (group / "memory.swap.max").read_text() == "0"
    assert not list(group.glob("cpu*"))
    enter_group(group)
    assert (
        group / "cgroup.procs"
    ).read_text() == "0"  # the kernel takes it for the one that writes
    end_group(group)
    assert (group / "cgroup.kill").read_text() == "1"


def test_groups_of_processes_that_were_killed_are_removed(tmp_path, own):
    top = tmp_path / "cgroup"
    tree(top, app="memory pids")
    folder = group_folder([top], own)
    ended = subprocess.Popen([sys.executable, "-c", ""])
    ended.wait()
    left, used = folder / f"tracerisk-{ended.pid}", folder / "tracerisk-1"
    left.mkdir()
    used.mkdir()
    new_group(folder, MEMORY)
    assert used.exists()
    assert (left / "cgroup.kill").read_text() == "1"


@pytest.mark.skipif(
    not any((top / "cgroup.procs").exists() and os.access(top, os.W_OK) for top in UNIFIED),
    reason="needs cgroup v2 that this user may write",
)
def test_the_kernel_ends_all_that_is_in_a_group():
    top = next(top for top in UNIFIED if (top / "cgroup.procs").exists())
    group = top / f"tracerisk-test-{os.getpid()}"
    group.mkdir()
    try:
        if not (group / "cgroup.kill").exists():
            pytest.skip("needs Linux 5.14")
        code = (
            "import os, sys; sys.stdin.read(1); [os.fork() for _ in range(3)]; print(flush=True); "
        )
        code += "os.setsid() if os.getpid() != os.getpgrp() else 0; sys.stdin.read()"
        child = subprocess.Popen(
            [sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        (group / "cgroup.procs").write_text(str(child.pid))
        child.stdin.write(b"x")
        child.stdin.flush()
        for _ in range(8):
            child.stdout.readline()
        assert len((group / "cgroup.procs").read_text().split()) == 8
        end_group(group)
        child.wait(20)
        assert child.stdout.read() == b""  # at its end once all that hold it have ended
        assert child.returncode == -9
        # The kernel says so a moment later, unless the group was empty soon enough to be removed.
        until = time.monotonic() + 20.0
        events = group / "cgroup.events"
        while group.exists() and "populated 0" not in events.read_text():
            assert time.monotonic() < until
            time.sleep(0.02)
    finally:
        end_group(group)
        for _ in range(100):
            if not group.exists():
                break
            time.sleep(0.02)  # the system reaps what has no parent any more
            end_group(group)
    assert not group.exists()
