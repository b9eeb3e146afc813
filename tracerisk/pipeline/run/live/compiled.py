"""Which functions of compiled nodes issued a message or a call, as the preloaded probe saw them."""

from __future__ import annotations

import itertools
import time
from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.adder.sources.c_source import CFunction, CSource, parse_c
from tracerisk.adder.sources.lines_of_functions import functions_at
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.text.bounded import file_bytes
from tracerisk.errors import InputError, Location, TraceRiskError
from tracerisk.instrument.native.calls import WAIT, WAITED, Call
from tracerisk.instrument.native.calls import Frame as NativeFrame
from tracerisk.instrument.native.following import CallFollower
from tracerisk.instrument.source.language import is_c
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.instrument.tracer import Frame, RootKind
from tracerisk.pipeline.run.live.compiled_loops import CLoop, loops_around
from tracerisk.pipeline.workspace.controller import from_root
from tracerisk.ros.live.process_tree import has_ended

MAIN = QualifiedName("main")
Place = tuple[str, int]
"""The source of a loop, from the root, and its first line."""


def function_main(source: bytes, file: str) -> CFunction:
    """Return the function with which a node begins.

    Raises:
        InputError: the source has none.
    """
    for function in parse_c(source, file).functions:
        if function.name == MAIN:
            return function
    raise InputError(
        "has no main(); name the source in which the node begins, for what no other function is "
        "known to have done belongs to it",
        Location(file),
    )


@dataclass(frozen=True, slots=True)
class _Active:
    """A function that was active at a command."""

    ref: FunctionRef
    """The function."""
    line: int
    """The line on which it begins."""
    at: int
    """The line of it that was executed."""
    loops: tuple[CLoop, ...]
    """The loops of it around that line, the outermost first."""


class CompiledCalls:
    """Says which functions of compiled nodes issued what the twin receives.

    `file` is that of the probe, `main` the name of the source with `main()`, from `root`.
    `on_function` and `on_source` get each function and source when they are first seen. `ros` is
    the version of ROS: in ROS 1 a goal is a message, and who calls a service waits for it.
    """

    def __init__(
        self,
        file: Path,
        root: Path,
        main: str,
        on_function: Callable[[FunctionRef, int], None],
        on_source: Callable[[str, bytes], None],
        ros: RosVersion = 1,
    ) -> None:
        self._follower = CallFollower(file, functions_at)
        self._ros = ros
        self._root = root.resolve()
        self._on_function, self._on_source = on_function, on_source
        self._sources: dict[str, CSource | None] = {}
        self._known: dict[NativeFrame, _Active | None] = {}
        self._met: set[FunctionRef] = set()
        self._pending: defaultdict[str, list[Call]] = defaultdict(list)
        self._late: set[int] = set()
        self._latest: dict[str, tuple[Frame, ...]] = {}
        # Of the probe's numbers from a publisher's, by its process, topic and number there.
        self._shifts: dict[tuple[int, str, int], int] = {}
        self._before: dict[int, list[tuple[_Active, int]]] = {}
        # Of each thread that waits, by its process, the endless loop in which it does.
        self._waits: defaultdict[int, dict[int, Place | None]] = defaultdict(dict)
        self._waited_at: defaultdict[int, set[tuple[NativeFrame, ...]]] = defaultdict(set)
        self._rounds: list[tuple[int, Place]] = []
        self._next = itertools.count(1).__next__
        source = self._source(main)
        assert source is not None
        function = function_main(source.source, main)
        self._main = _Active(FunctionRef(main, MAIN), function.line, function.line, ())
        self._of_main = (self._frame(self._main, self._next(), is_first=True),)
        self.n_unknown = 0
        """How many messages and calls have no other function than `main`."""
        self.n_known = 0
        """How many have the functions that issued them."""

    @property
    def notes(self) -> tuple[str, ...]:
        """What is missing of names and lines, and why, a sentence each."""
        return tuple(self._follower.notes)

    @property
    def newer(self) -> dict[str, str]:
        """The controller's sources that changed after a binary was built from them, and which."""
        own = ((self.own_file(file), binary) for file, binary in self._follower.newer.items())
        return {file: binary for file, binary in own if file is not None}

    @property
    def has_reported(self) -> bool:
        """Whether the probe was loaded by any process."""
        return bool(self._follower.programs)

    def stack(self, name: str, number: int | None, at_ns: int | None = None) -> tuple[Frame, ...]:
        """Return the functions behind what came on a topic or service, the outermost first.

        `number` is that by which roscpp, in the message's header, or the transport of ROS 2 counts
        those of a publisher, from 0 on again when a node has destroyed the publisher and made
        another. `at_ns` is when the transport of ROS 2 sent it [ns since 1970].
        """
        self._take()
        call = self._call(self._pending[name], number, at_ns)
        frames = () if call is None else self._frames(call)
        if call is None and number is not None:
            frames = self._latest.get(name, ())  # what is latched goes out again
        if frames:
            self.n_known += 1
            self._latest[name] = frames
            return frames
        self.n_unknown += 1
        return self._of_main

    def read_sources(self) -> None:
        """Read the controller's other sources that its binaries were built from.

        No command came from them: their functions that can command never did.
        """
        for file in self._follower.sources():
            own = self.own_file(file)
            if own is not None:
                self._source(own)

    def settled(self) -> None:
        """Forget what was sent and reached nobody, now that nothing is under way."""
        self._take()
        late: set[int] = set()
        for calls in self._pending.values():
            calls[:] = [call for call in calls if id(call) not in self._late]
            # In ROS 1 its end says that a call is over.
            late.update(id(call) for call in calls if call.kind != "call" or self._ros == 2)
        self._late = late

    def new_ends(self) -> list[dict[str, Any]]:
        """Return the probe's lines on topics and services of ROS 2 that have come since."""
        self._take()
        ends, self._follower.ends = self._follower.ends, []
        return ends

    def only_wait(self, pid: int) -> bool:
        """Return whether a process does nothing by itself, but for waits of loops without an end.

        Its main thread waits for callbacks or the end, or in such a loop, and so does every thread
        that waits for some time; no callback is in progress.
        """
        waits = self._waits[pid]
        if pid in self._follower.calling_back or None in waits.values():
            return False
        return pid in self._follower.spinning or pid in waits

    def loops(self, pid: int) -> bool:
        """Return whether the main thread of a process waits in a loop without an end."""
        return pid not in self._follower.spinning and self._waits[pid].get(pid) is not None

    def new_rounds(self) -> list[tuple[int, Place]]:
        """Return each iteration of an endless loop that a main thread has begun, and its process.

        It begins where the thread comes again to a wait of the loop itself, of no loop within.
        """
        self._take()
        rounds, self._rounds = self._rounds, []
        return rounds

    @property
    def processes(self) -> tuple[int, ...]:
        """The processes of the controller's nodes."""
        return tuple(self._follower.own_processes)

    def ended(self) -> list[tuple[int, str, int | None]]:
        """Return each process of the controller's nodes that is there no more, and its program.

        With it comes the code with which it ended; `None` if a signal or `_exit` ended it.
        """
        self._take()
        processes = self._follower.own_processes
        gone = [pid for pid in processes if has_ended(pid)]
        self._take()  # what they wrote last
        return [(pid, processes[pid], self._follower.codes.get(pid)) for pid in gone]

    def _take(self) -> None:
        for call in self._follower.new():
            if call.kind in (WAIT, WAITED):
                self._note_wait(call)
                continue
            is_message = call.kind == "goal" and self._ros == 1
            topic = f"{call.name}/goal" if is_message else call.name
            pending = self._pending[topic]
            if call.kind != "end":
                pending.append(call)
                continue
            # A call that is over and has not come reached nobody.
            of = ("call", call.pid, call.seq)
            pending[:] = [one for one in pending if (one.kind, one.pid, one.seq) != of]

    def _note_wait(self, call: Call) -> None:
        waits, is_main = self._waits[call.pid], call.tid == call.pid
        if not is_main or waits.get(call.tid) is None:  # such a loop is never left
            waits.pop(call.tid, None)
        own = self._active(call) if call.kind == WAIT else []
        if not own:
            return
        loops = [(active, loop) for active in own for loop in active.loops]
        place = next(
            ((of.ref.file, loop.first) for of, loop in reversed(loops) if loop.is_endless),
            None,
        )
        waits[call.tid] = place
        if place is None or not is_main or not loops[-1][1].is_endless:
            return
        met = self._waited_at[call.pid]
        if call.stack in met:
            self._rounds.append((call.pid, place))
            met.clear()
        met.add(call.stack)

    def _call(self, calls: list[Call], number: int | None, at_ns: int | None) -> Call | None:
        """Take out of what is pending on one name the command that has come.

        Of several publishers of a topic each counts its own; the time says whose number it is.
        """
        if not calls:
            return None
        fit = [call for call in calls if number is None or call.seq == self._seq(call, number)]
        call = (fit or calls)[0]
        if at_ns is not None:
            at_ns -= time.time_ns() - time.monotonic_ns()  # on the clock of the probe
            call = min(fit or calls, key=lambda call: abs(call.t_ns - at_ns))
        if number is not None:
            self._shifts[call.pid, call.name, call.of] = call.seq - number
        # What the same publisher sent earlier was lost on its way.
        of = call.pid, call.of
        calls[:] = [
            one
            for one in calls
            if one is not call and ((one.pid, one.of) != of or one.seq > call.seq or number is None)
        ]
        return call

    def _seq(self, call: Call, number: int) -> int:
        """Return the number by which the probe counts what has a number of its publisher's."""
        return number + self._shifts.get((call.pid, call.name, call.of), 0)

    # From the probe's frames to ours

    def _active(self, call: Call) -> list[_Active]:
        """Return the controller's own functions that were active, the outermost first."""
        active: list[_Active] = []
        for native in call.stack:
            if native not in self._known:
                self._known[native] = self._own(native)
            known = self._known[native]
            # A lambda belongs to the function that holds it.
            if known is not None and not (active and active[-1].ref == known.ref):
                active.append(known)
        return active

    def _frames(self, call: Call) -> tuple[Frame, ...]:
        active = self._active(call)
        if not active:
            return ()
        before = self._before.get(call.tid, [])
        n_same = _n_same([one for one, _ in before], active)
        numbered = [
            (one, before[place][1] if place < n_same else self._next())
            for place, one in enumerate(active)
        ]
        self._before[call.tid] = numbered
        is_main = call.tid == call.pid
        return tuple(
            self._frame(one, number, is_first=place == 0, is_main=is_main)
            for place, (one, number) in enumerate(numbered)
        )

    def _frame(
        self, active: _Active, activation: int, *, is_first: bool, is_main: bool = True
    ) -> Frame:
        if active.ref not in self._met:
            self._met.add(active.ref)
            self._on_function(active.ref, active.line)
        root: RootKind | None = None
        if is_first:
            root = "main" if is_main else "thread"
        return Frame(active.ref, active.line, activation, (active.at, 0), root)

    def _own(self, native: NativeFrame) -> _Active | None:
        """Return a function of the controller's own sources; None for what is none of these."""
        file = self._file(native)
        source = None if file is None else self._source(file)
        if source is None or file is None:
            return None
        named = [one for one in source.functions if one.name == native.function]
        around = [one for one in named or source.functions if _holds(source, one, native.line)]
        function = max(around, key=lambda one: one.start, default=named[-1] if named else None)
        if function is None:
            return None
        at = native.line or function.line
        loops = tuple(loops_around(source, function, at))
        return _Active(FunctionRef(file, function.name), function.line, at, loops)

    def _file(self, native: NativeFrame) -> str | None:
        """Return the name from the root of the source of a function; None for one elsewhere."""
        if not native.file:
            # A build without lines: the source with main() may still have a function of the name.
            own = self._sources[self._main.ref.file]
            is_own = own is not None and any(one.name == native.function for one in own.functions)
            return self._main.ref.file if is_own else None
        return self.own_file(native.file)

    def own_file(self, file: str) -> str | None:
        """Return the name from the root of a source as a compiler was given it.

        `None` where it is none below the root. A name that is relative to the folder of a build,
        such as `../src/pick.cpp`, is looked for from the source with `main()` upwards.
        """
        tail = Path(*(part for part in Path(file).parts if part != ".."))
        above = (self._root / self._main.ref.file).parents
        for path in (Path(file), *(folder / tail for folder in above)):
            if path.is_file() and path.resolve().is_relative_to(self._root):
                return from_root(self._root, path.resolve())
        return None

    def _source(self, file: str) -> CSource | None:
        if file not in self._sources:
            source = None
            if is_c(file):
                content = file_bytes(self._root / file)
                try:
                    source = parse_c(content, file)
                except TraceRiskError:
                    source = None  # no text: nobody can write blocks into it
                else:
                    self._on_source(file, content)
            self._sources[file] = source
        return self._sources[file]


def _n_same(before: Sequence[_Active], now: Sequence[_Active]) -> int:
    """Return how many of the outermost activations are still those of the command before.

    Where a function goes on to a later line it is the same; where it is at the same line again, or
    at an earlier one, it is only if a loop of it leads there.
    """
    if not before:
        return 0
    place = 0
    while place < min(len(before), len(now)) and before[place] == now[place]:
        place += 1
    if place == len(before) or place == len(now):
        place -= 1
    elif before[place].ref != now[place].ref:
        return place
    elif now[place].at > before[place].at:
        return place + 1
    while not _is_in_one_loop(before[place], now[place]):
        if place == 0:
            # A callback is called anew by the library; main() is called once.
            return int(now[0].ref.name == MAIN)
        place -= 1
    return place + 1


def _is_in_one_loop(one: _Active, other: _Active) -> bool:
    return one.ref == other.ref and not set(one.loops).isdisjoint(other.loops)


def _holds(source: CSource, function: CFunction, line: int) -> bool:
    return source.line_of(function.begins) <= line <= source.line_of(function.end - 1)
