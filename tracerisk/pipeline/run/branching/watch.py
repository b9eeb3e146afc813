"""Watch the process of a run and those of its branches, each of which has limits of its own."""

from __future__ import annotations

import contextlib
import json
import os
import select
import signal
import subprocess
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tracerisk.common.sandbox.kernel.features import stat_fields
from tracerisk.common.sandbox.limited_process import POLL_S, OwnTime
from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import Settings
from tracerisk.errors import Location
from tracerisk.pipeline.run.child_output import stopped_at
from tracerisk.pipeline.run.controller_run import (
    RunningChild,
    reached_limit,
)
from tracerisk.pipeline.run.ended_run import ProcessEnd
from tracerisk.pipeline.run.run_folders import simulated_so_far, size_of
from tracerisk.pipeline.trace.run_files import EVENTS, STACKS, RunRequest, WallTime

_MOST_LOG = 16 * 1024**2
_MOST_WRITTEN = 1024**3
"""What a branch may have on the disk, recording and all [bytes]."""
_MOST_FILES = 100_000
_LOOK_AT_DISK_S = 0.5
_STACK_S = 0.5

Ended = Callable[[int, RunRequest, ProcessEnd], None]
"""Called with the index of a branch that has ended, the request with its folders, and its end."""


@dataclass(slots=True)
class _Live:
    """A branch that runs."""

    handle: int | None
    """The pidfd of its process; `None` where the process had ended."""
    request: RunRequest
    """The request of the branch, with its own folders."""
    own: OwnTime
    """The processor time of its process."""
    began: float = field(default_factory=time.monotonic)
    """When it began, by the monotonic clock [s]."""
    changed_s: float = 0.0
    """The processor time at which it last made progress [s]."""
    seen: tuple[int, int] = (-1, -1)
    """The size of its events [bytes] and the simulated time, when it was last looked at."""
    looked: float = 0.0
    """When its files were last counted, by the monotonic clock [s]."""
    end: ProcessEnd | None = None
    """The limit that it reached; `None` while it has reached none."""

    @property
    def folder(self) -> Path:
        return Path(self.request.folder)

    @property
    def runs(self) -> bool:
        return self.handle is not None and not _has_ended(self.handle)

    def send(self, number: int) -> None:
        with contextlib.suppress(ProcessLookupError, PermissionError):
            if self.handle is not None:
                signal.pidfd_send_signal(self.handle, number)

    def close(self) -> None:
        if self.handle is not None:
            os.close(self.handle)


class BranchWatch:
    """Waits for the end of a run; `on_ended` is called with each branch as it ends.

    `refused` says in words why branches could not leave the run, by their index; `left` are those
    that have.
    """

    def __init__(self, on_ended: Ended) -> None:
        self._on_ended = on_ended
        self._live: dict[int, _Live] = {}
        self._read = 0
        self.left: set[int] = set()
        self.refused: dict[int, str] = {}

    def __call__(self, child: RunningChild) -> ProcessEnd:
        """Wait for the end of the child, or for a limit, and so with each of its branches."""
        try:
            return self._wait(child)
        finally:
            self._read_log(child)
            for live in self._live.values():
                live.close()

    def _wait(self, child: RunningChild) -> ProcessEnd:
        start, settings, folder = child.start, child.settings, Path(child.request.folder)
        own: OwnTime | None = None
        looked, wall_s, changed_s, seen = time.monotonic(), 0.0, 0.0, (-1, -1)
        while True:
            with contextlib.suppress(subprocess.TimeoutExpired):
                return ProcessEnd(child.process.wait(timeout=POLL_S))
            self._read_log(child)
            for live in self._live.values():
                self._look(live, settings)
            now = time.monotonic()
            # While branches run, which have limits of their own, it may wait for them.
            may_wait = any(live.runs for live in self._live.values())
            wall_s, looked = wall_s + (0.0 if may_wait else now - looked), now
            if own is None and (cpu_s := start.cpu_s) is not None:
                own, wall_s = child.own_time(cpu_s), 0.0
            if own is not None:
                own.apart = {live.own.pid for live in self._live.values() if live.runs}
                own.look()
            grown = (size_of(folder / EVENTS), simulated_so_far(folder))
            if grown != seen or may_wait:
                seen, changed_s = grown, 0.0 if own is None else own.seconds
                child.show("branching", grown[1])
            reached = reached_limit(own, changed_s, wall_s, settings)
            if reached is not None:
                return ProcessEnd(0) if WallTime.is_in(folder) else ProcessEnd(1, reached)

    def _read_log(self, child: RunningChild) -> None:
        """Read what the run has noted since; what is malformed is another's, and passed over."""
        plan = child.request.plan
        assert plan is not None
        try:
            text = file_bytes(plan.log, _MOST_LOG, through_links=False)
        except OSError:
            return
        whole = text.rfind(b"\n") + 1
        lines, self._read = text[self._read : whole].splitlines(), max(whole, self._read)
        for line in lines:
            with contextlib.suppress(ValueError, TypeError, KeyError, RecursionError):
                self._noted(json.loads(line), child)

    def _noted(self, entry: dict[str, Any], child: RunningChild) -> None:
        request = child.request
        assert request.plan is not None
        index, known = entry["index"], {branch.index for branch in request.plan.branches}
        if not isinstance(index, int) or index not in known:
            return
        if "refused" in entry:
            self.refused[index] = str(entry["refused"])[:500]
        elif "process" in entry and index not in self.left:
            process = entry["process"]
            handle = _of(process, child.start.pid)
            own = OwnTime(int(process), keeper=child.process.pid, leads_group=True)
            self.left.add(index)
            recording, written = request.plan.folders(index)
            moved = replace(request, folder=recording)
            if request.written is not None:
                moved = replace(moved, written=written)
            self._live[index] = _Live(handle, moved, own)
        elif "code" in entry and index in self._live:
            live = self._live.pop(index)
            live.close()
            end = live.end or ProcessEnd(int(entry["code"]))
            self._on_ended(index, live.request, replace(end, has_begun=True))

    def _look(self, live: _Live, settings: Settings) -> None:
        """End a branch that has reached a limit."""
        if live.end is not None or not live.runs:
            return
        live.own.look()
        grown = (size_of(live.folder / EVENTS), simulated_so_far(live.folder))
        if grown != live.seen:
            live.seen, live.changed_s = grown, live.own.seconds
        now = time.monotonic()
        reached = reached_limit(live.own, live.changed_s, now - live.began, settings)
        if reached is None and now - live.looked > _LOOK_AT_DISK_S:
            live.looked = now
            if not _is_small(live.folder.parent):
                reached = f"it has written more than {_MOST_WRITTEN // 1024**2} MB"
        if reached is None or WallTime.is_in(live.folder):
            return
        live.end = ProcessEnd(-signal.SIGKILL, *self._stopped_at(live, reached))
        live.send(signal.SIGKILL)

    @staticmethod
    def _stopped_at(live: _Live, limit: str) -> tuple[str, Location | None]:
        """Ask a branch where it stands; return how the limit ended it, and where."""
        stacks = live.folder / STACKS
        before, deadline = size_of(stacks), time.monotonic() + _STACK_S
        live.send(signal.SIGUSR1)
        while size_of(stacks) == before and time.monotonic() < deadline:
            time.sleep(POLL_S)
        time.sleep(POLL_S)
        return stopped_at(stacks, Path(live.request.root), limit)


def _of(process: Any, parent: int | None) -> int | None:
    """Return a pidfd of a process; None where it has ended, or is no child of the parent."""
    if not isinstance(process, int) or process <= 1:
        return None
    try:
        handle = os.pidfd_open(process)
    except OSError:
        return None
    try:
        if int(stat_fields(f"/proc/{process}")[1]) == parent:
            return handle
    except (OSError, ValueError, IndexError):
        pass
    os.close(handle)
    return None


def _has_ended(handle: int) -> bool:
    poll = select.poll()
    poll.register(handle, select.POLLIN)
    return bool(poll.poll(0))


def _is_small(top: Path) -> bool:
    """Return whether a folder holds no more than a branch may have on the disk."""
    size, count, folders = 0, 0, [str(top)]
    while folders:
        try:
            with os.scandir(folders.pop()) as entries:
                for entry in entries:
                    count += 1
                    if entry.is_dir(follow_symlinks=False):
                        folders.append(entry.path)
                    else:
                        size += entry.stat(follow_symlinks=False).st_blocks * 512
                    if size > _MOST_WRITTEN or count > _MOST_FILES:
                        return False
        except OSError:
            continue
    return True
