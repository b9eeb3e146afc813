"""Control groups: how much memory and how many processes a run may have."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterable
from pathlib import Path

_CGROUPS = (Path("/sys/fs/cgroup"), Path("/sys/fs/cgroup/unified"))


_OWN_CGROUP = Path("/proc/self/cgroup")


_GROUP = "tracerisk-"


_MOST_PROCESSES = 4096  # with all their threads


def group_folder(mounts: Iterable[Path] = _CGROUPS, own: Path = _OWN_CGROUP) -> Path | None:
    """Return where this user may make a control group (cgroup v2) with limits; None for nowhere.

    That is the group of this process, or one around it, which hands limits on to those within.
    """
    with contextlib.suppress(OSError, StopIteration):
        lines = own.read_text(encoding="utf-8").splitlines()
        name = next(line[3:] for line in lines if line.startswith("0::"))
        for top in mounts:
            group = top / name.lstrip("/")
            for folder in (group, *group.parents):
                if _hands_on_limits(folder) and os.access(folder, os.W_OK):
                    return folder
                if folder == top:
                    break
    return None


def _hands_on_limits(group: Path) -> bool:
    with contextlib.suppress(OSError):
        given = (group / "cgroup.subtree_control").read_text(encoding="utf-8").split()
        return {"memory", "pids"} <= set(given) and os.access(group / "cgroup.procs", os.W_OK)
    return False


def new_group(folder: Path | None, memory_bytes: int) -> Path | None:
    """Return a new control group within a folder that limits what is in it; None for no group.

    Those of processes that were killed are removed first.
    """
    if folder is None:
        return None
    group = folder / f"{_GROUP}{os.getpid()}"
    for old in folder.glob(f"{_GROUP}*"):
        if not Path("/proc", old.name.removeprefix(_GROUP)).exists():
            end_group(old)
    with contextlib.suppress(OSError):
        group.mkdir()
        # Who weighs the processes says what took too much; the kernel stops what is faster.
        most = memory_bytes + memory_bytes // 8
        for name, text in {"memory.max": most, "pids.max": _MOST_PROCESSES}.items():
            (group / name).write_text(str(text), encoding="utf-8")
        for name, text in {"memory.swap.max": 0, "memory.oom.group": 1}.items():
            with contextlib.suppress(OSError):  # a kernel without swap has no limit of it
                (group / name).write_text(str(text), encoding="utf-8")
        return group
    end_group(group)
    return None


def enter_group(group: Path | None) -> None:
    """Move this process into a control group, and with it all that it starts."""
    if group is not None:
        with contextlib.suppress(OSError):
            (group / "cgroup.procs").write_text("0", encoding="utf-8")


def end_group(group: Path | None) -> None:
    """End all processes in a control group at once, and remove it where they are reaped."""
    if group is not None:
        with contextlib.suppress(OSError):
            (group / "cgroup.kill").write_text("1", encoding="utf-8")
        with contextlib.suppress(OSError):
            group.rmdir()
