"""The file of the preloaded probe, read while compiled nodes still write it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import regular_file
from tracerisk.instrument.native.binaries import Binary
from tracerisk.instrument.native.calls import WAIT, Call, Frame, NamesAt, call_of, named_calls

_INSTALLED = ("/usr/", "/bin/", "/sbin/", "/opt/ros/")
_PIECE = 1 << 16
"""How much of the file a process takes at a time [bytes]; probe/native/calls.c."""


class CallFollower:
    """Reads the commands that have come since it was asked last.

    A stack is named once, however often it issues a command; `names_at` is that of `read_calls`.
    `notes` (an attribute) are the sentences of `CallLog` on what is missing, `newer` its sources
    that have changed, `programs` those that reported, `codes` those with which processes have
    ended by themselves, `spinning` those whose main thread waits for callbacks alone or for the
    end, `calling_back` those in which a callback is in progress, `ends` the lines on topics and
    services of nodes of ROS 2 that have come.
    """

    def __init__(self, file: Path, names_at: NamesAt | None = None) -> None:
        self.notes: dict[str, None] = {}
        self.newer: dict[str, str] = {}
        self.programs: dict[str, None] = {}
        self.codes: dict[int, int] = {}
        self.spinning: set[int] = set()
        self.calling_back: set[int] = set()
        self.ends: list[dict[str, Any]] = []
        self._file = file
        self._names_at = names_at
        self._open: dict[int, int] = {}  # the pieces that may grow, and what is read of each
        self._filled_by: dict[int, int] = {}  # the open piece of each process
        self._n_pieces = 0
        self._modules: list[dict[str, Any]] = []
        self._known: dict[str, tuple[Frame, ...]] = {}
        self._processes: dict[int, str] = {}  # the programs of those that no node has forked
        self._binaries: dict[str, None] = {}
        self._own: set[int] = set()  # the processes in which code of the controller commanded

    def new(self) -> list[Call]:
        """Return the commands and waits that have come, each process's in its order."""
        calls: list[tuple[str, dict[str, Any]]] = []
        unknown: dict[str, dict[str, Any]] = {}
        waits: dict[str, dict[str, Any]] = {}
        for entry in self._new_entries():
            self._note_process(entry)
            if "kind" in entry:
                key = _key(entry)
                calls.append((key, entry))
                if key not in self._known:
                    (waits if entry["kind"] == WAIT else unknown)[key] = entry
        # Libraries wait too, in threads of their own: nothing is missing of their functions.
        for named, are_commands in ((unknown, True), (waits, False)):
            if named:
                self._name(named, with_notes=are_commands)
        return [call_of(entry, self._known[key]) for key, entry in calls]

    @property
    def own_processes(self) -> dict[int, str]:
        """The processes of nodes with code of the controller, each with its program."""
        return {
            pid: program
            for pid, program in self._processes.items()
            if pid in self._own or not program.startswith(_INSTALLED)
        }

    def sources(self) -> list[str]:
        """Return the sources of the nodes' own binaries, as compilers were given them."""
        return [
            file
            for path in self._binaries
            if Path(path).is_file()
            for file in Binary(path).sources()
        ]

    def _note_process(self, entry: dict[str, Any]) -> None:
        pid = entry.get("pid", 0)
        if "probe" in entry:
            self.programs[entry["exe"]] = None
            if "forked" not in entry:
                self._processes[pid] = entry["exe"]
        elif "modules" in entry:
            self._modules.append(entry)
            if entry["modules"]:
                self._own.add(pid)
            self._binaries.update((module[0], None) for module in entry["modules"])
        elif "made" in entry or "gone" in entry:
            self.ends.append(entry)
        elif "exit" in entry:
            self.codes[pid] = entry["exit"]
        elif "spins" in entry:
            (self.spinning.add if entry["spins"] else self.spinning.discard)(pid)
        elif "calls_back" in entry:
            (self.calling_back.add if entry["calls_back"] else self.calling_back.discard)(pid)

    def _name(self, unknown: dict[str, dict[str, Any]], *, with_notes: bool) -> None:
        log = named_calls([*self._modules, *unknown.values()], self._names_at)
        for key, call in zip(unknown, log.calls, strict=True):
            self._known[key] = call.stack
        if with_notes:
            self.notes.update(dict.fromkeys(log.notes))
            self.newer.update(log.newer)

    def _new_entries(self) -> list[dict[str, Any]]:
        entries: list[dict[str, Any]] = []
        try:
            stream = regular_file(self._file)
        except FileNotFoundError:
            return entries  # no process has begun yet
        with stream:
            n_pieces = -(-stream.seek(0, 2) // _PIECE)
            self._open.update(dict.fromkeys(range(self._n_pieces, n_pieces), 0))
            self._n_pieces = n_pieces
            for piece, begun in list(self._open.items()):
                stream.seek(piece * _PIECE + begun)
                data = stream.read(_PIECE - begun)
                end = data.rfind(b"\n", 0, _end_of(data)) + 1
                self._open[piece] = begun + end
                read = [_entry(line) for line in data[:end].split(b"\n")]
                for entry in filter(None, read):
                    self._fills(entry.get("pid", 0), piece)
                    entries.append(entry)
        return entries

    def _fills(self, pid: int, piece: int) -> None:
        """Note which piece a process fills; the one before it is full."""
        before = self._filled_by.get(pid, piece)
        if before != piece:
            self._open.pop(before, None)
        self._filled_by[pid] = piece


def _end_of(data: bytes) -> int:
    """Return where the text of a piece ends and its zeros begin."""
    zeros = data.find(b"\0")
    return len(data) if zeros < 0 else zeros


def _entry(line: bytes) -> dict[str, Any] | None:
    try:
        entry = json.loads(line.decode("utf-8", "surrogateescape"))
    except ValueError:
        return None  # blank, or of a process that was killed while it wrote
    return entry if isinstance(entry, dict) else None


def _key(entry: dict[str, Any]) -> str:
    """Return what stands for the stack of a command."""
    stack = entry.get("stack", entry.get("at"))
    return json.dumps([entry.get("pid"), entry.get("map"), stack])
