"""The file of the preloaded probe, read while compiled nodes still write it."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from tracerisk.common.text.bounded import regular_file
from tracerisk.instrument.native.binaries import Binary
from tracerisk.instrument.native.calls import Call, Frame, read_calls

_INSTALLED = ("/usr/", "/bin/", "/sbin/", "/opt/ros/")
_PIECE = 1 << 16
"""How much of the file a process takes at a time [bytes]; probe/native/calls.c."""


class CallFollower:
    """Reads the commands that have come since it was asked last.

    A stack is named once, however often it issues a command. `notes` (an attribute) are the
    sentences of `CallLog` on what is missing, `newer` its sources that have changed, `programs`
    those that reported, `codes` those with which processes have ended by themselves.
    """

    def __init__(self, file: Path) -> None:
        self.notes: dict[str, None] = {}
        self.newer: dict[str, str] = {}
        self.programs: dict[str, None] = {}
        self.codes: dict[int, int] = {}
        self._file = file
        self._open: dict[int, int] = {}  # the pieces that may grow, and what is read of each
        self._filled_by: dict[int, int] = {}  # the open piece of each process
        self._n_pieces = 0
        self._heads: list[str] = []
        self._known: dict[str, tuple[tuple[Frame, ...], bool]] = {}
        self._processes: dict[int, str] = {}  # the programs of those that no node has forked
        self._binaries: dict[str, None] = {}
        self._own: set[int] = set()  # the processes in which code of the controller commanded

    def new(self) -> list[Call]:
        """Return the commands that have come, each process's in its order.

        Raises:
            InputError: the file is not one of the probe.
        """
        entries = self._new_entries()
        for entry in entries:
            self._note_process(entry)
        heads = [json.dumps(entry) for entry in entries if entry.keys() & {"probe", "modules"}]
        calls = [entry for entry in entries if "kind" in entry]
        self._heads += heads
        unknown = {_key(entry): entry for entry in calls if _key(entry) not in self._known}
        if unknown or heads:
            self._name(unknown)
        return [self._call(entry) for entry in calls]

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
        if "probe" in entry and "forked" not in entry:
            self._processes[pid] = entry["exe"]
        elif entry.get("modules"):
            self._own.add(pid)
            self._binaries.update((module[0], None) for module in entry["modules"])
        elif "exit" in entry:
            self.codes[pid] = entry["exit"]

    def _name(self, unknown: dict[str, dict[str, Any]]) -> None:
        with tempfile.NamedTemporaryFile("w", suffix=".jsonl", encoding="utf-8") as part:
            lines = [*self._heads, *map(json.dumps, unknown.values())]
            part.write("".join(f"{line}\n" for line in lines))
            part.flush()
            log = read_calls(Path(part.name))
        for key, call in zip(unknown, log.calls, strict=True):
            self._known[key] = call.stack, call.is_cut
        self.programs.update(dict.fromkeys(log.programs))
        self.notes.update(dict.fromkeys(log.notes))
        self.newer.update(log.newer)

    def _call(self, entry: dict[str, Any]) -> Call:
        stack, is_cut = self._known[_key(entry)]
        issued = entry["t"], entry.get("pid", 0), entry["tid"]
        return Call(*issued, entry["kind"], entry["name"], entry["seq"], stack, is_cut)

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
