"""What a controller starts programs with, and asks and awaits them by: it waits in virtual time.

While one thread waits for a program the others run: the program may wait for one of them.
"""

from __future__ import annotations

import functools
import io
import os
import select
import stat
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from sys import _getframe
from typing import Any

from tracerisk.ros.controller.programs import Awaited, has_ended, identity
from tracerisk.ros.time.busy_wait import READ_STEP_NS, has_looked
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.ros.time.threads import for_controller, nanoseconds

_PIECE = 4096
"""What a pipe takes at once that is ready to be written to [bytes]."""
_Popen: type[subprocess.Popen[Any]] = subprocess.Popen  # a run puts a class of its own there
_PASSED, _ENDS = 4, (10, 13, 15)  # where `Popen._execute_child` is given the program's files


def program_replacements(scheduler: Scheduler) -> Iterator[tuple[Any, str, Any]]:
    """Yield owner, name and value of what starts a program or waits for its end or its output."""
    kind = _Popen
    yield kind, "_execute_child", _starting(scheduler, vars(kind)["_execute_child"])
    yield kind, "wait", _waiting(scheduler, kind.wait)
    yield kind, "poll", _polling(scheduler, kind.poll)
    yield (
        subprocess,
        "_time",
        for_controller(scheduler, lambda: scheduler.now_ns / 1e9, vars(subprocess)["_time"]),
    )
    for name in ("posix_spawn", "posix_spawnp"):
        yield os, name, _spawning(scheduler, getattr(os, name))
    yield os, "waitpid", _waiting_by_number(scheduler, os.waitpid)
    yield os, "read", _reading(scheduler, os.read)


def may_answer(scheduler: Scheduler) -> bool:
    """Return whether the thread that runs may wait for a program."""
    return scheduler.may_wait and scheduler.programs.have_been


def is_ready(descriptor: int, event: int) -> Callable[[], bool]:
    """Return what asks whether a file is ready for an event of `select.poll`."""
    poll = select.poll()
    poll.register(descriptor, event)
    return lambda: bool(poll.poll(0))


def _starting(scheduler: Scheduler, real: Callable[..., None]) -> Callable[..., None]:
    @functools.wraps(real)
    def execute(self: Any, *args: Any) -> None:
        if scheduler.current is None:
            real(self, *args)
            return
        ends = [args[at] for at in _ENDS if args[at] >= 0]
        # Looked at before: they are closed here when the program has them.
        files = [identity(end) for end in (*ends, *args[_PASSED])]
        real(self, *args)
        scheduler.programs.started(self.pid, files)
        for stream in (self.stdout, self.stderr):
            if stream is not None:
                _read_in_virtual_time(scheduler, _raw(stream))
        if self.stdin is not None:
            _write_in_virtual_time(scheduler, _raw(self.stdin))

    return execute


def _raw(stream: Any) -> Any:
    buffered = getattr(stream, "buffer", stream)
    return getattr(buffered, "raw", buffered)


def _read_in_virtual_time(scheduler: Scheduler, raw: io.FileIO) -> None:
    """Make a pipe wait for its other end: what is buffered on it asks the object."""
    descriptor = raw.fileno()

    def readinto(buffer: Any, /) -> int | None:
        _await_file(scheduler, descriptor, select.POLLIN)
        try:
            return os.readv(descriptor, [buffer])
        except BlockingIOError:
            return None

    def read(size: int | None = -1, /) -> bytes | None:
        if size is None or size < 0:
            return readall()
        buffer = bytearray(size)
        count = readinto(buffer)
        return None if count is None else bytes(buffer[:count])

    def readall() -> bytes | None:
        parts = []
        while part := read(io.DEFAULT_BUFFER_SIZE):
            parts.append(part)
        return b"".join(parts) if parts or part is not None else None

    vars(raw).update(read=read, readinto=readinto, readall=readall)


def _write_in_virtual_time(scheduler: Scheduler, raw: io.FileIO) -> None:
    descriptor = raw.fileno()

    def write(data: Any, /) -> int | None:
        _await_file(scheduler, descriptor, select.POLLOUT)
        scheduler.programs.sent(descriptor)
        try:
            with memoryview(data) as view, view.cast("B") as octets:
                return os.write(descriptor, octets[:_PIECE])
        except BlockingIOError:
            return None

    vars(raw).update(write=write)


def _await_file(scheduler: Scheduler, descriptor: int, event: int) -> None:
    if may_answer(scheduler) and os.get_blocking(descriptor):
        scheduler.wait_until(
            is_ready(descriptor, event),
            reason="a program that it has started",
            awaited=Awaited(descriptors=(descriptor,)),
        )


def _waiting(scheduler: Scheduler, real: Callable[..., int]) -> Callable[..., int]:
    @functools.wraps(real)
    def wait(self: Any, timeout: float | None = None) -> int:
        if self.returncode is not None or not scheduler.may_wait:
            return real(self, timeout)
        if not scheduler.wait_until(
            lambda: has_ended(self.pid),
            timeout_ns=None if timeout is None else nanoseconds(timeout),
            reason=f"the end of the program {_name(self.args)}",
            awaited=Awaited(ended=self.pid, limit_s=timeout),
        ):
            assert timeout is not None
            raise subprocess.TimeoutExpired(self.args, timeout)
        return real(self)

    return wait


def _name(args: Any) -> str:
    first = args if isinstance(args, str | bytes | os.PathLike) else next(iter(args), "")
    return Path(os.fsdecode(first).split(" ")[0]).name


def _polling(
    scheduler: Scheduler, real: Callable[[Any], int | None]
) -> Callable[[Any], int | None]:
    @functools.wraps(real)
    def poll(self: Any) -> int | None:
        # `send_signal` asks it too, and waits for nothing.
        if self.returncode is None and _getframe(1).f_globals is not vars(subprocess):
            _look(scheduler, self.pid)
        return real(self)

    return poll


def _look(scheduler: Scheduler, process: int) -> None:
    """Give a program that a thread has looked at the time that it computes.

    A second look at the same instant moves the clock as one at a state of the controller's own.
    """
    thread = scheduler.current
    if thread is None or not scheduler.may_wait or thread.is_undisturbed:
        return
    step_ns = READ_STEP_NS if has_looked(thread, scheduler.now_ns) else 1
    scheduler.wait_until(
        lambda: has_ended(process),
        timeout_ns=step_ns,
        reason="the end of a program",
        awaited=Awaited(ended=process, limit_s=0.0),
    )
    thread.read_ns = scheduler.now_ns


def _spawning(scheduler: Scheduler, real: Callable[..., int]) -> Callable[..., int]:
    @functools.wraps(real)
    def spawn(*args: Any, **kwargs: Any) -> int:
        process = real(*args, **kwargs)
        if scheduler.current is not None:
            scheduler.programs.started(process)
        return process

    return spawn


def _waiting_by_number(scheduler: Scheduler, real: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(real)
    def waitpid(process: int, options: int, /) -> Any:
        if process > 0 and may_answer(scheduler):
            if options & os.WNOHANG:
                _look(scheduler, process)
            else:
                scheduler.wait_until(
                    lambda: has_ended(process),
                    reason="the end of a program",
                    awaited=Awaited(ended=process),
                )
        return real(process, options)

    return waitpid


def _reading(scheduler: Scheduler, real: Callable[[int, int], bytes]) -> Callable[..., bytes]:
    @functools.wraps(real)
    def read(descriptor: int, size: int, /) -> bytes:
        if may_answer(scheduler) and _is_pipe(descriptor):
            _await_file(scheduler, descriptor, select.POLLIN)
        return real(descriptor, size)

    return read


def _is_pipe(descriptor: int) -> bool:
    try:
        return stat.S_ISFIFO(os.fstat(descriptor).st_mode)
    except OSError:
        return False
