"""Run a program of ours in a process with limits, which end the command and decide nothing else.

Two clocks watch a process. Its own time is what it computes or sleeps: time in which the machine
keeps it waiting or stopped does not count, so a busy machine does not reach that limit. Wall time
is the generous limit behind it, for a process that is stopped or waits for the disk for ever.
Both count from the mark that the process sets once its interpreter and imports are ready; until
then it has the wall time alone.
"""

from __future__ import annotations

import contextlib
import gc
import math
import os
import select
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from pathlib import Path
from time import monotonic, process_time, sleep
from typing import NoReturn

from tracerisk.common.dependencies import require_linux
from tracerisk.common.limits import Limit, Limits
from tracerisk.common.sandbox.process import end, passed_environment, start
from tracerisk.common.sandbox.scratch import scratch
from tracerisk.errors import LimitError, Location

if sys.platform != "win32":
    import resource
    from time import clock_gettime  # the real one: a run puts its own clock into the module

POLL_S = 0.05
"""How often a process is looked at [s]."""

MOST_ANSWERED = 256 * 1024 * 1024
"""What a process may print in all [bytes]."""

_OUT_OF_MEMORY = 9
_MARK = "TRACERISK_START_MARK"
_MEMORY = "TRACERISK_MEMORY_LIMIT"
_MB = 1024 * 1024
# A process whose parent is gone ends by itself, well after the parent would have ended it.
_SPARE_CPU_S = 60
_TASKS = "/proc/{}/task"
_WEIGH_S = 0.1  # between two looks at the memory of several processes


class StartMark:
    """The pipe through which a child says that it is ready to do its work."""

    def __init__(self) -> None:
        self._read, self.descriptor = os.pipe()
        os.set_blocking(self._read, False)
        self._text = b""

    def environment(self, own: Limit) -> dict[str, str]:
        """Return the variable by which the child knows the pipe and its limit."""
        return {_MARK: f"{self.descriptor}:{math.ceil(min(own.value, 1e9)) + _SPARE_CPU_S}"}

    def handed_over(self) -> None:
        """Close this side's end for writing, which the child has by now."""
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

    @property
    def cpu_s(self) -> float | None:
        """The processor time of the child when it was ready [s]; None while it is not."""
        with contextlib.suppress(BlockingIOError):
            self._text += os.read(self._read, 64)
        return float(self._text.split()[1]) if self._text.endswith(b"\n") else None

    @property
    def pid(self) -> int | None:
        """The process that does the work; None while it is not ready."""
        return None if self.cpu_s is None else int(self._text.split()[0])

    def close(self) -> None:
        """Close the pipe."""
        self.handed_over()
        os.close(self._read)


def mark_start() -> None:
    """Signal the parent that the work begins; limits count from here. Once, in the child."""
    descriptor, _, cpu_s = os.environ.pop(_MARK, "").partition(":")
    if not cpu_s:
        return
    used_s = process_time()
    lower_limit(resource.RLIMIT_CPU, math.ceil(used_s) + int(cpu_s))
    os.write(int(descriptor), f"{os.getpid()} {used_s:.6f}\n".encode())
    os.close(int(descriptor))


def lower_limit(kind: int, most: int) -> None:
    """Give this process a limit of the system for good, or as little as it has already."""
    _, hard = resource.getrlimit(kind)
    wanted = most if hard == resource.RLIM_INFINITY else min(most, hard)
    # A soft limit would be one that a controller can raise.
    resource.setrlimit(kind, (wanted, wanted))


class OwnTime:
    """The time that a process computes or sleeps [s], as far as it was looked at.

    Where the system does not report what a process does (all but Linux), it is wall time.
    Beside it, how much memory the process and those that it has started hold together. Those that
    it left behind are children of the `keeper`, the process that `start` returns.
    """

    held_bytes = 0
    """The memory of the process with those that it has started; 0 while there are none [bytes]."""
    apart: Collection[int] = ()
    """Processes that lead groups of their own, and are weighed by themselves."""

    def __init__(
        self, pid: int, cpu_s: float = 0.0, *, keeper: int, leads_group: bool = False
    ) -> None:
        self.pid = pid
        self._keeper, self._leads_group = keeper, leads_group
        self._first_s = self._cpu_s = cpu_s
        self._slept_s = 0.0
        self._looked = self._weighed = monotonic()
        self._was_asleep = False

    @property
    def cpu_s(self) -> float:
        """The processor time since the beginning [s]."""
        return self._cpu_s - self._first_s

    @property
    def seconds(self) -> float:
        """The time that it computed or slept since the beginning [s]."""
        return self.cpu_s + self._slept_s

    def look(self) -> None:
        """Look at the process; to be called every `POLL_S`."""
        now = monotonic()
        # Who looks late, for it was kept waiting itself, cannot know what went on meanwhile.
        passed, self._looked = min(now - self._looked, 2 * POLL_S), now
        if now - self._weighed > _WEIGH_S:
            self._weighed, self.held_bytes = now, self._held_bytes()
        cpu_s = _cpu_s(self.pid)
        if cpu_s is not None and cpu_s > self._cpu_s:
            self._cpu_s, self._was_asleep = cpu_s, False
            return
        is_asleep = _is_asleep(self.pid)
        if is_asleep and self._was_asleep:
            self._slept_s += passed
        self._was_asleep = is_asleep

    def _held_bytes(self) -> int:
        """Return the memory of the process and its descendants [bytes]; 0 where it has none.

        What several of them share is counted once. The system itself limits a single process.
        """
        left_behind = (child for child in _children(self._keeper) if child != self.pid)
        processes = [self.pid, *(child for child in left_behind if self._has_left(child))]
        for process in processes:
            processes += (child for child in _children(process) if child not in self.apart)
        return sum(map(_share_bytes, processes)) if len(processes) > 1 else 0

    def _has_left(self, orphan: int) -> bool:
        """Return whether it was this process, and none of those apart, that left an orphan."""
        with contextlib.suppress(OSError):
            group = os.getpgid(orphan)
            return group == self.pid if self._leads_group else group not in self.apart
        return False


def _cpu_s(pid: int) -> float | None:
    """Return the processor time of a process and its threads [s]; None where it is unknown."""
    if sys.platform != "linux":
        return None
    # clock_getcpuclockid(3): the clock of a process, in the form that the kernel reads.
    with contextlib.suppress(OSError):
        return clock_gettime((~pid << 3) | 2)
    return None


def _children(pid: int) -> Iterator[int]:
    tasks = _TASKS.format(pid)
    with contextlib.suppress(OSError):
        for task in os.listdir(tasks):  # noqa: PTH208 - looked at ten times a second
            with contextlib.suppress(OSError):
                yield from map(int, Path(f"{tasks}/{task}/children").read_bytes().split())


def _share_bytes(pid: int) -> int:
    """Return the memory of a process, of what it shares its part [bytes]; 0 where it has ended."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text(encoding="ascii").splitlines():
            name, _, figure = line.partition(":")
            if name == "Pss":
                return int(figure.split()[0]) * 1024
    return 0


def _is_asleep(pid: int) -> bool:
    """Return whether every thread of a process sleeps: none computes, waits to, or is stopped."""
    if sys.platform != "linux":
        return True
    states = set()
    try:
        for task in Path(_TASKS.format(pid)).iterdir():
            states.add((task / "stat").read_bytes().rpartition(b")")[2].split()[0])
    except OSError:
        return False
    return states == {b"S"}


def run_limited(
    module: str,
    *arguments: str,
    request: bytes,
    limits: Limits,
    doing: str,
    place: Location | None = None,
    folder: Path | None = None,
    environment: Mapping[str, str | None] | None = None,
    reads: Iterable[Path] | None = None,
) -> subprocess.CompletedProcess[bytes]:
    """Run a module of ours on a request at its standard input, and return what it answers.

    `doing` says in a message what took too much: `expanding the xacro file`.
    `reads` are the files and folders that the module may read of a stranger's code or data, which
    it runs contained; `None` for a module that runs none. It can write into a temporary folder,
    which `TMPDIR` names, and which is gone afterwards. `environment` are variables that it gets
    besides those that every such process has, `None` for one that it does not get.
    The module calls `limit_memory`, `mark_start` and `end_with` of this module.
    Raises LimitError at `place` where a limit ends it, or the system does, or where it answers
    more than `MOST_ANSWERED` bytes; OtherSystemError where the system is not Linux.
    """
    require_linux(doing)
    mark = StartMark()
    is_strange = reads is not None
    inherited = passed_environment(limits.sandbox) if is_strange else dict(os.environ)
    with (
        contextlib.closing(mark),
        tempfile.TemporaryFile() as given,
        scratch() as folder_of_its_own,
    ):
        given.write(request)
        given.seek(0)
        child = start(
            module,
            *arguments,
            sandbox=limits.sandbox if is_strange else None,
            reads=reads or (),
            writes=(folder_of_its_own,),
            memory_bytes=limits.memory_bytes,
            environment={
                name: value
                for name, value in {
                    **inherited,
                    **(environment or {}),
                    **mark.environment(limits.own),
                    _MEMORY: str(limits.memory_bytes),
                    "TMPDIR": str(folder_of_its_own),
                }.items()
                if value is not None
            },
            pass_fds=(mark.descriptor,),
            stdin=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=folder,
        )
        mark.handed_over()
        try:
            out, err = _watched(child, mark, limits, doing, place)
        finally:
            end(child)
            for stream in (child.stdout, child.stderr):
                if stream is not None:
                    stream.close()
    if child.returncode == _OUT_OF_MEMORY:
        raise _too_much_memory(limits, doing, place)
    if child.returncode in (-signal.SIGKILL, -signal.SIGXCPU):
        name = signal.Signals(-child.returncode).name
        raise LimitError(
            f"{doing} was ended by {name}: the system may be short of memory, or impose its own "
            "limits; free memory, or raise the limits",
            place,
        )
    return subprocess.CompletedProcess(child.args, child.returncode, out, err)


def _too_much_memory(limits: Limits, doing: str, place: Location | None) -> LimitError:
    used = f"{limits.memory_bytes // _MB} MB of memory, a quarter of a controller's limit"
    return LimitError(f"{doing} took more than {used}; {limits.memory.advice}", place)


def last_words(done: subprocess.CompletedProcess[bytes]) -> str:
    """Return the last line of what a process that failed printed as its errors, or its code."""
    lines = done.stderr.decode(errors="replace").strip().splitlines()
    return lines[-1].strip() if lines else f"its process ended with code {done.returncode}"


def _watched(
    child: subprocess.Popen[bytes],
    mark: StartMark,
    limits: Limits,
    doing: str,
    place: Location | None,
) -> tuple[bytes, bytes]:
    began = monotonic()
    own: OwnTime | None = None
    answered = _Answers(child)
    while True:
        if answered.wait() and child.poll() is not None:
            return answered.out, answered.err
        if answered.size > MOST_ANSWERED:
            raise LimitError(f"{doing} printed more than {MOST_ANSWERED // _MB} MB", place)
        if own is None and (cpu_s := mark.cpu_s) is not None:
            own = OwnTime(mark.pid or child.pid, cpu_s, keeper=child.pid)
            began = monotonic()
        if own is not None:
            own.look()
            if own.seconds > limits.own.value:
                raise LimitError(
                    f"{doing} took more than {limits.own.value:g} s of CPU time or sleep; "
                    f"{limits.own.advice}",
                    place,
                )
            if own.held_bytes > limits.memory_bytes:
                raise _too_much_memory(limits, doing, place)
        if monotonic() - began > limits.wall.value:
            what = "did not start within" if own is None else "took more than"
            raise LimitError(
                f"{doing} {what} {limits.wall.value:g} s of wall time; {limits.wall.advice}", place
            )


class _Answers:
    """What a process prints, read as it comes."""

    def __init__(self, child: subprocess.Popen[bytes]) -> None:
        self._parts: dict[int, bytearray] = {}
        self._poll = select.poll()
        for stream in (child.stdout, child.stderr):
            assert stream is not None
            os.set_blocking(stream.fileno(), False)
            self._parts[stream.fileno()] = bytearray()
            self._poll.register(stream.fileno(), select.POLLIN)
        self._open = set(self._parts)

    @property
    def out(self) -> bytes:
        """What came to standard output."""
        return bytes(next(iter(self._parts.values())))

    @property
    def err(self) -> bytes:
        """What came to standard error."""
        return bytes(list(self._parts.values())[1])

    @property
    def size(self) -> int:
        """How much came in all [bytes]."""
        return sum(map(len, self._parts.values()))

    def wait(self) -> bool:
        """Read what comes within `POLL_S`; return whether nothing can come any more."""
        if not self._open:
            sleep(POLL_S)
            return True
        for descriptor, _ in self._poll.poll(POLL_S * 1000):
            part = os.read(descriptor, 65536)
            self._parts[descriptor] += part
            if not part:
                self._poll.unregister(descriptor)
                self._open.discard(descriptor)
        return not self._open


def limit_memory() -> None:
    """Apply the limit of memory that the parent has set, and write no core dump."""
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    wanted = os.environ.pop(_MEMORY, None)
    if wanted is not None:
        lower_limit(resource.RLIMIT_AS, int(wanted))


def end_with(main: Callable[[], int]) -> NoReturn:
    """Run `main` of a limited process and end with its code, or with that of a lack of memory."""
    gc.enable()
    try:
        code = main()
    except MemoryError:
        code = _OUT_OF_MEMORY
    sys.exit(code)
