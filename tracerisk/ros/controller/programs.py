"""Programs that a controller starts: they run in real time, and simulated time waits for them.

Before simulated time goes on, nothing of the controller can. If a thread then waits for a program,
the run really waits until the program has answered or ended. So what a controller sees does not
depend on how fast the machine is.
"""

from __future__ import annotations

import _socket
import os
import stat
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from time import sleep  # the real one: a program runs in real time
from typing import Any

# Windows, where no controller runs, has none.
_clock_gettime: Callable[[int], float] = getattr(time, "clock_gettime", lambda _: -1.0)

WITHOUT_END = float("inf")
"""The patience with a program that alone can end a wait [s]."""
_MOST_PATIENCE_S = 10.0
_LONG_S = 0.5
_FIRST_STILL_S, _STILL_S = 0.3, 0.05
_SHORTEST_PAUSE_S, _LONGEST_PAUSE_S, _LONGEST_SILENT_PAUSE_S = 0.0001, 0.005, 0.2
_MOST_DESCRIPTORS = 1024

Identity = tuple[int, int]
"""What identifies an open file: its device and its number there."""


@dataclass(slots=True, eq=False)
class Awaited:
    """What a thread waits for that a program may bring."""

    ended: int | None = None
    """The program whose end it waits for; `None`: it waits for one of `descriptors`."""
    descriptors: tuple[int, ...] = ()
    """The files of which one must be ready; none and no `ended`: any program may end the wait."""
    limit_s: float | None = None
    """The simulated time after which the wait ends in any case [s]; `None`: never."""
    may_answer: bool = False
    """Whether what the thread waits for may also be what lets it answer a program: an event loop's
    timers."""
    silent_s: float = 0.0
    """For how long the programs have been silent during the wait [s]."""


class Programs:
    """The programs that a controller has started, and the files that they have in common with it.

    A program that computes is given the time that it needs. One that is silent, neither computing
    nor answering, is waited for as long as the wait says: without end if it has no limit, else for
    its limit. It is waited for briefly where a program may not be meant at all, as by a server that
    accepts connections, and where it may be silent since a thread owes it an answer.
    `have_been` (an attribute) says whether one was ever started: what comes later may differ in
    when it ended, and not in that.
    """

    def __init__(self) -> None:
        self._living: list[int] = []
        self.have_been = False
        self._given: set[Identity] = set()
        self._partners: dict[Identity, Identity] = {}
        self._asking: set[Identity] = set()
        self._owed: dict[int, tuple[Identity, object]] = {}
        self._known_still: tuple[float, ...] | None = None
        self._still_s = _FIRST_STILL_S
        self._is_restless = False

    def started(self, process: int, files: Iterable[Identity] = ()) -> None:
        """Note a program, and the files and pipes that it was given."""
        self._living.append(process)
        self.have_been = True
        self._given.update(files)
        self._known_still, self._still_s, self._is_restless = None, _FIRST_STILL_S, False

    def paired(self, one: int, other: int) -> None:
        """Note that two descriptors are the ends of one pair of sockets."""
        first, second = identity(one), identity(other)
        self._partners[first], self._partners[second] = second, first

    def accepted(self, descriptor: int) -> None:
        """Note a connection on which a program may ask, as of a server."""
        self._asking.add(identity(descriptor))

    def received(self, descriptor: int, thread: object) -> None:
        """Note that something came to a thread, which may owe a program an answer from now on."""
        if self._living:
            file = identity(descriptor)
            if file in self._asking or self._partners.get(file) in self._given:
                self._owed[descriptor] = file, thread

    def sent(self, descriptor: int, *, is_all: bool = False) -> None:
        """Note that a program may have been sent something: one that was silent may go on.

        `is_all`: it is owed nothing more then.
        """
        self._known_still = None
        if is_all:
            self._owed.pop(descriptor, None)

    @property
    def are_there(self) -> bool:
        """Whether one lives."""
        if self._living:
            self._living = [process for process in self._living if not has_ended(process)]
        return bool(self._living)

    def wait(
        self,
        awaited: Mapping[Any, Awaited],
        is_answered: Callable[[], bool],
        *,
        only: bool,
        on_silence: Callable[[], None],
    ) -> None:
        """Really wait for programs; time is to pass where nothing is answered afterwards.

        `awaited` is what each thread waits for, `is_answered` returns whether one can go on, and
        `only` says that nothing but a program can make anything happen. `on_silence` is called
        where the wait is without end and takes long. Of several answers none counts before the
        programs are silent: which came first depends on the machine.
        """
        if not self.are_there:
            return
        # A thread that waits for a program itself answers none meanwhile.
        owes = any(
            (thread not in awaited or awaited[thread].may_answer) and _is_open(descriptor, file)
            for descriptor, (file, thread) in self._owed.items()
        )
        waits = list(awaited.values())
        is_single = sum(map(self._meant, waits)) <= 1
        patience_s = max(self._patience_s(wait, owes=owes) for wait in waits)
        if only and patience_s > 0.0:
            patience_s = WITHOUT_END
        still_s = waited_s = 0.0
        pause_s = _SHORTEST_PAUSE_S
        seen = self._processor_times()
        while self.are_there:
            if is_answered():
                if is_single:
                    return
                patience_s = min(patience_s, self._still_s)
            if still_s >= patience_s:
                break
            if patience_s < WITHOUT_END and waited_s > _MOST_PATIENCE_S:
                self._is_restless = True
                return
            if patience_s == WITHOUT_END and waited_s < _LONG_S <= waited_s + pause_s:
                on_silence()
            sleep(pause_s)
            # By the time asked for: on a busy machine the programs are kept waiting too.
            still_s, waited_s = still_s + pause_s, waited_s + pause_s
            for wait in waits:
                wait.silent_s += pause_s
            now = self._processor_times()
            if now != seen:
                seen, still_s = now, 0.0
            # Who watches a process sees it asleep only where that takes some time.
            longest_s = min(max(_LONGEST_PAUSE_S, still_s / 4), _LONGEST_SILENT_PAUSE_S)
            pause_s = min(2 * pause_s, longest_s)
        if still_s >= self._still_s:
            self._known_still, self._still_s = seen, _STILL_S

    def _patience_s(self, awaited: Awaited, *, owes: bool) -> float:
        """Return how long a program may be silent before simulated time goes on [s]."""
        is_meant = awaited.ended in self._living
        is_possible = is_meant or (awaited.ended is None and not awaited.descriptors)
        for descriptor in awaited.descriptors:
            answer = self._can_answer(descriptor)
            is_meant, is_possible = is_meant or answer is True, is_possible or answer is not False
        if not is_possible:
            return 0.0
        if is_meant and awaited.limit_s is None and not owes:
            return WITHOUT_END
        limit_s = 0.0
        if is_meant and awaited.limit_s is not None and not owes:
            limit_s = min(awaited.limit_s, _MOST_PATIENCE_S) - awaited.silent_s
        is_still = self._is_restless or self._known_still == self._processor_times()
        return limit_s if is_still else max(limit_s, self._still_s)

    def _meant(self, awaited: Awaited) -> int:
        """Return how many answers of programs may come, in an order that matters."""
        count = int(awaited.ended in self._living) + sum(
            self._can_answer(descriptor) is True for descriptor in awaited.descriptors
        )
        return count if awaited.may_answer else min(count, 1)

    def _can_answer(self, descriptor: int) -> bool | None:
        """Return whether a program can make a file ready; None where that is unknown."""
        try:
            status = os.fstat(descriptor)
        except OSError:
            return False
        file = (status.st_dev, status.st_ino)
        if file in self._given or self._partners.get(file) in self._given:
            return True
        if not stat.S_ISSOCK(status.st_mode) or file in self._partners:
            return False
        sock = _socket.socket(fileno=os.dup(descriptor))
        try:
            if sock.family not in (_socket.AF_INET, _socket.AF_INET6):
                return None
            try:
                peer = sock.getpeername()
            except OSError:
                return None
            return not _is_of_this_process(sock.getsockname(), peer)
        finally:
            sock.close()

    def _processor_times(self) -> tuple[float, ...]:
        return tuple(map(_processor_s, self._living))


def has_ended(process: int) -> bool:
    """Return whether a program has ended, and leave its exit code where it is."""
    try:
        return os.waitid(os.P_PID, process, os.WEXITED | os.WNOHANG | os.WNOWAIT) is not None
    except ChildProcessError:
        return True


def identity(descriptor: int) -> Identity:
    """Return what identifies the open file of a descriptor."""
    status = os.fstat(descriptor)
    return status.st_dev, status.st_ino


def _is_open(descriptor: int, file: Identity) -> bool:
    try:
        return identity(descriptor) == file
    except OSError:
        return False


def _processor_s(process: int) -> float:
    try:
        # clock_getcpuclockid(3): the clock of a process, in the form that the kernel reads.
        return _clock_gettime((~process << 3) | 2)
    except OSError:
        return -1.0


def _is_of_this_process(own: Any, peer: Any) -> bool:
    """Return whether the other end of a connection is a socket of this process too."""
    for descriptor in range(_MOST_DESCRIPTORS):
        try:
            if not stat.S_ISSOCK(os.fstat(descriptor).st_mode):
                continue
            sock = _socket.socket(fileno=os.dup(descriptor))
            try:
                if sock.getsockname() == peer and sock.getpeername() == own:
                    return True
            finally:
                sock.close()
        except OSError:
            continue
    return False
