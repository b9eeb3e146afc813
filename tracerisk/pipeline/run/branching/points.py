"""Where a run branches: its process is forked, and each fork goes on with faults of its own.

Between two chunks of the simulation all threads of the controller wait, and nothing of the
simulation is under way: there the process is copied whole. A branch has copies of the files that
the run has open, so that both write on as if they were alone.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import resource
import signal
import tempfile
from collections.abc import Callable
from pathlib import Path
from time import sleep

from tracerisk.common.sandbox.files.overlay import Overlay
from tracerisk.common.sandbox.forking import NotForkableError, fork_apart, open_descriptors
from tracerisk.common.sandbox.limited_process import POLL_S, lower_limit
from tracerisk.pipeline.run.branching.fate import FateWatch
from tracerisk.pipeline.run.controller_end import ControllerEnd
from tracerisk.pipeline.trace.run_files import (
    MOST_ROWS,
    TEMPORARY,
    Branch,
    BranchPlan,
    RunRequest,
    claimed,
)
from tracerisk.ros.controller.programs import Programs
from tracerisk.twin.faults.armed import step_at
from tracerisk.twin.recording.samples import SampleWriter
from tracerisk.twin.simulation.simulation import CHUNK
from tracerisk.twin.simulation.twin import Twin

_LOOK_S = POLL_S / 4
_HAS_ENDED = os.WEXITED | os.WNOHANG | os.WNOWAIT
_SPARE_CPU_S = 60
"""Who watches a branch ends it; this much later the system does [s]."""
# Bound before virtual time takes its place.
_sleep: Callable[[float], None] = sleep


class BranchPoints:
    """Forks the process of a run before the faults of its branches.

    `folder` is that of the recording of this process: of the run, or of the branch that it is.
    A branch would have no hold of the `programs` that the controller has started.
    """

    def __init__(
        self,
        request: RunRequest,
        twin: Twin,
        samples: SampleWriter,
        end: ControllerEnd,
        overlay: Overlay | None,
        fate: FateWatch | None = None,
        *,
        programs: Programs,
    ) -> None:
        self.folder = Path(request.folder)
        self._request = request
        self._twin, self._samples, self._end, self._overlay = twin, samples, end, overlay
        self._fate, self._programs = fate, programs
        self._alive: dict[int, int] = {}
        self._unread: set[int] = set()
        self._is_branch = False
        self._known: frozenset[int] = frozenset()
        plan = request.plan
        self._pending = sorted(
            () if plan is None else plan.branches,
            key=lambda branch: (_step_of(branch), branch.index),
        )

    def begin(self) -> None:
        """Branch from now on; what is open by now, each branch may share."""
        if self._pending:
            self._known = open_descriptors()
            self._twin.before_chunk = self._before_chunk
            self._end.before_exit = self.wait

    def wait(self) -> None:
        """Wait until all branches have ended."""
        while self._alive:
            self._reap()
            _sleep(_LOOK_S)

    def finish(self) -> None:
        """End this process where it is a branch; else wait for all branches."""
        if self._is_branch:
            os._exit(0)
        self.wait()

    def _before_chunk(self, now_ns: int) -> None:
        # A chunk that ends beyond the instant would be cut short in the run with the fault.
        reached = now_ns // self._twin.step_ns + CHUNK
        while self._pending and _step_of(self._pending[0]) < reached:
            self._leave(self._pending.pop(0))

    def _leave(self, branch: Branch) -> None:
        plan = self._request.plan
        assert plan is not None
        recording, written = plan.folders(branch.index)
        if plan.claims and not claimed(plan.claims, branch.index):
            return
        moved = {self._request.folder: recording}
        try:
            if self._programs.are_there:
                raise NotForkableError("a program that the controller has started goes on")
            if self._request.written is not None:
                self._check_files(self._request.written)
                moved[self._request.written] = written
            process = fork_apart(moved, self._known)
        except NotForkableError as error:
            self._note(index=branch.index, refused=str(error))
            return
        if process == 0:
            self._become(branch, plan)
        else:
            self._alive[process] = branch.index
            self._note(index=branch.index, process=process)
            # The run waits too: no more cores are busy than was asked for.
            while len(self._alive) + len(self._unread) >= plan.at_once:
                _sleep(_LOOK_S)
                self._reap()

    def _check_files(self, written: str) -> None:
        """Raise NotForkableError where the controller knows the path of a file that will move."""
        temporary = Path(written, TEMPORARY)
        if temporary.is_dir() and any(temporary.iterdir()):
            raise NotForkableError("the controller has temporary files")
        if Path.cwd().is_relative_to(written):
            raise NotForkableError("the controller works in a folder that it has made")

    def _become(self, branch: Branch, plan: BranchPlan) -> None:
        """Make this process the branch."""
        recording, written = plan.folders(branch.index)
        os.setpgid(0, 0)
        self._is_branch, self.folder = True, Path(recording)
        self._pending.clear()
        self._alive.clear()
        self._unread.clear()
        lower_limit(resource.RLIMIT_CPU, math.ceil(min(plan.cpu_limit_s, 1e9)) + _SPARE_CPU_S)
        lower_limit(resource.RLIMIT_FSIZE, MOST_ROWS)
        self._samples.moved(self.folder)
        self._end.forked()
        self._end.before_exit = lambda: None
        self._twin.before_chunk = lambda _: None
        if self._overlay is not None:
            self._overlay.moved(written)
            temporary = str(Path(written, TEMPORARY))
            os.environ["TMPDIR"] = temporary
            if tempfile.tempdir is not None:
                tempfile.tempdir = temporary
        for fault in branch.faults:
            self._twin.arm(fault)
        if self._fate is not None and branch.faults:
            self._fate.begin(branch.faults)

    def _reap(self) -> None:
        """Note which branches have ended and how; forget those that were read since."""
        plan = self._request.plan
        assert plan is not None
        for process, index in list(self._alive.items()):
            try:
                if os.waitid(os.P_PID, process, _HAS_ENDED) is None:
                    continue
                # What it has left running goes with it: its number is not another's yet.
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(process, signal.SIGKILL)
                _, status = os.waitpid(process, 0)
            except ChildProcessError:
                # The controller has waited for it: how it ended is lost.
                status = 255 << 8
            del self._alive[process]
            self._unread.add(index)
            self._note(index=index, code=os.waitstatus_to_exitcode(status))
        read = {number for number in self._unread if not os.path.lexists(plan.folders(number)[0])}
        self._unread -= read

    def _note(self, **cause: object) -> None:
        assert self._request.plan is not None
        log = os.open(
            self._request.plan.log, os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o644
        )
        try:
            os.write(log, f"{json.dumps(cause)}\n".encode())
        finally:
            os.close(log)


def _step_of(branch: Branch) -> int:
    """Return the first physics step that may differ from that of the run."""
    return step_at(branch.leaves_s)
