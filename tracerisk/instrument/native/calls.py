"""What the preloaded probe recorded of compiled nodes: the functions behind each command.

`probe/native/calls.c` writes addresses, for names cost time that a node does not have; here they
become functions of the source. docs/probe.md describes the file.
"""

from __future__ import annotations

import json
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from tracerisk.common.function_ref import QualifiedName
from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.errors import InputError, Location
from tracerisk.instrument.native.binaries import Binary, Place
from tracerisk.instrument.native.cpp_names import (
    is_lambda,
    is_of_library,
    lambda_owner,
    source_name,
)

VARIABLE = "TRACERISK_CALLS"
"""The environment variable that names the file to the probe."""
KINDS = ("publish", "goal", "call", "end")
"""A message, a goal of an action, a call of a service, and the end of such a call."""
WAIT, WAITED = "wait", "waited"
"""In a live run, the beginning of a wait that ends by itself, and its end; they are no commands."""
_KEYS = {"probe", "modules", "kind", "exit", "spins", "calls_back", "made", "gone"}
"""Each line has one of these."""
_INSTALLED = ("/usr/", "/opt/ros/", "/build/", "/nix/")
"""Where sources of installed libraries are; their inlined functions are none of the controller."""
_REMEDY = (
    "compile with -g and link without -s; -fno-optimize-sibling-calls keeps a function that ends "
    "with a call"
)


@dataclass(frozen=True, slots=True)
class Frame:
    """A function of the controller that was active."""

    function: QualifiedName
    """Its name in the source: `Cell::swing`, without parameters."""
    file: str
    """Its source, as the compiler was given it; empty if unknown."""
    line: int
    """The line that made the next call or issued the command, from 1 on; 0 if unknown."""


@dataclass(frozen=True, slots=True)
class Call:
    """A command of a compiled node."""

    t_ns: int
    """The time of the machine's monotonic clock [ns]."""
    pid: int
    """The process."""
    tid: int
    """The thread, as the kernel numbers it."""
    kind: str
    """One of `KINDS`, `WAIT` or `WAITED`."""
    name: str
    """The topic, action or service."""
    seq: int
    """How many of this kind and name the process issued before, in ROS 2 by this publisher; of an
    `end`, that of its call."""
    stack: tuple[Frame, ...]
    """The active functions of the controller, the outermost first; empty if none is known."""
    is_cut: bool
    """Whether the stack was too deep, and its outermost functions are missing."""
    of: int = 0
    """The publisher of a message of ROS 2, among those of the process, from 1 on; 0 for others."""


@dataclass(frozen=True, slots=True)
class CallLog:
    """What the probe recorded."""

    calls: tuple[Call, ...]
    """The commands, in the order of the file."""
    programs: tuple[str, ...]
    """The executables that reported, each once; a statically linked one never reports."""
    notes: tuple[str, ...]
    """What is missing and why, with the remedy, a sentence each."""
    newer: Mapping[str, str]
    """The sources that have changed since the binary was made that was built from them."""


class _Module(NamedTuple):
    """A binary as it lay in the memory of a process."""

    path: str
    """Its file."""
    bias: int
    """What to subtract from an address to get the address as linked."""
    begin: int
    """Its first address."""
    end: int
    """The address after its last."""
    size: int
    """The length of its file when it was loaded [bytes]."""
    mtime_ns: int
    """When its file was last changed, when it was loaded [ns since 1970]."""


class _Address(NamedTuple):
    """An address in a binary."""

    module: _Module
    """The binary."""
    offset: int
    """The address as linked, within the instruction that calls."""


NamesAt = Callable[[str, int], Sequence[QualifiedName]]
"""Takes a source and a line of it; returns the functions that hold the line, the innermost last."""


def read_calls(file: Path, names_at: NamesAt | None = None) -> CallLog:
    """Read the file of the probe, and name the functions in it.

    `names_at` reads sources: what a compiler calls an inlined function often lacks its scopes. It
    is asked about those alone that have not changed since the binary was made.

    Raises:
        InputError: if the file cannot be read, or is not one of the probe.
    """
    try:
        data = file_bytes(file, MOST_OF_A_RUN)
    except OSError as error:
        raise InputError(
            f"cannot be read ({error.strerror}); the probe writes the file that {VARIABLE} names",
            Location(str(file)),
        ) from error
    lines = data.replace(b"\0", b"").decode("utf-8", "surrogateescape").split("\n")
    torn = 0
    entries: list[dict[str, Any]] = []
    for number, line in enumerate(lines, 1):
        if not line:
            continue
        try:
            entry = json.loads(line)
        except ValueError:
            torn += 1  # a process was killed while it wrote
            continue
        if not isinstance(entry, dict) or not entry.keys() & _KEYS:
            raise InputError("is no line of the probe", Location(str(file), number))
        if entry.get("kind") not in (WAIT, WAITED):
            entries.append(entry)
    log = named_calls(entries, names_at)
    if not torn:
        return log
    note = f"{file}: torn lines: {torn}; a process was killed while it wrote"
    return replace(log, notes=(*log.notes, note))


def named_calls(entries: Iterable[dict[str, Any]], names_at: NamesAt | None = None) -> CallLog:
    """Name the functions in lines of the probe; `names_at` is that of `read_calls`."""
    modules: dict[tuple[int, int], list[_Module]] = {}
    programs: dict[str, None] = {}
    commands: list[tuple[dict[str, Any], list[_Address]]] = []
    for entry in entries:
        if "probe" in entry:
            programs[entry["exe"]] = None
        elif "modules" in entry:
            there = [_Module(*module) for module in entry["modules"]]
            modules[entry["pid"], entry["map"]] = there
        elif "kind" in entry:
            known = modules.get((entry.get("pid", 0), entry.get("map", 0)), [])
            commands.append((entry, _addresses(entry.get("at", ()), known)))
    names = _Names((address for _, addresses in commands for address in addresses), names_at)
    calls = (call_of(entry, _stack(entry, addresses, names)) for entry, addresses in commands)
    return CallLog(tuple(calls), tuple(programs), tuple(names.notes), names.newer)


def _addresses(at: Iterable[int], modules: Iterable[_Module]) -> list[_Address]:
    """Return the addresses that lie in a binary of the node, the innermost first."""
    return [
        # The byte before a return address belongs to the call.
        _Address(module, address - 1 - module.bias)
        for address in at
        for module in modules
        if module.begin <= address - 1 < module.end
    ]


def _stack(
    entry: Mapping[str, Any], addresses: Iterable[_Address], names: _Names
) -> tuple[Frame, ...]:
    if "stack" in entry:  # already resolved
        return tuple(Frame(QualifiedName(name), of, line) for name, of, line in entry["stack"])
    return names.stack(addresses)


def call_of(entry: Mapping[str, Any], stack: tuple[Frame, ...]) -> Call:
    """Return the command of a line of the probe, with the functions of its stack."""
    return Call(
        entry["t"],
        entry.get("pid", 0),
        entry["tid"],
        entry["kind"],
        entry["name"],
        entry["seq"],
        stack,
        bool(entry.get("cut")),
        entry.get("of", 0),
    )


@cache
def _binary(module: _Module) -> Binary:
    """Return a binary as it was when it was loaded; each is read once."""
    return Binary(module.path)


class _Names:
    """The functions of all addresses of a file."""

    def __init__(self, addresses: Iterable[_Address], names_at: NamesAt | None) -> None:
        self.notes: list[str] = []
        self.newer: dict[str, str] = {}
        by_module: dict[_Module, dict[int, None]] = {}
        for module, offset in addresses:
            by_module.setdefault(module._replace(bias=0, begin=0, end=0), {})[offset] = None
        self._active: dict[tuple[str, int], list[tuple[Frame, bool]]] = {}
        for module, offsets in by_module.items():
            problem = _changed(module)
            if problem is not None:
                self.notes.append(problem)
                continue
            places = _binary(module).places(list(offsets))
            names = _unchanged_since(module.mtime_ns, names_at)
            for offset, there in places.items():
                self._active[module.path, offset] = _active(there, names)
                for frame, _ in self._active[module.path, offset]:
                    if (_changed_ns(frame.file) or 0) > module.mtime_ns:
                        self.newer[frame.file] = module.path
            without_line = Counter(place.line > 0 for there in places.values() for place in there)
            if not all(places.values()):
                self.notes.append(f"{module.path} has functions without names: {_REMEDY}")
            elif not without_line[True]:
                self.notes.append(f"{module.path} has names but no lines: {_REMEDY}")

    def stack(self, addresses: Iterable[_Address]) -> tuple[Frame, ...]:
        """Return the functions of the controller, the outermost first."""
        frames: list[Frame] = []
        for module, offset in reversed(list(addresses)):
            for frame, is_part in self._active.get((module.path, offset), ()):
                if is_part and frames and frames[-1].function == frame.function:
                    frames.pop()
                frames.append(frame)
        return tuple(frames)


def _unchanged_since(time_ns: int, names_at: NamesAt | None) -> NamesAt:
    """Return `names_at` for sources that were last changed before a time [ns since 1970]."""

    def names(file: str, line: int) -> Sequence[QualifiedName]:
        changed_ns = None if names_at is None else _changed_ns(file)
        is_unchanged = changed_ns is not None and changed_ns <= time_ns
        return names_at(file, line) if names_at is not None and is_unchanged else ()

    return names


def _changed_ns(file: str) -> int | None:
    """Return when a source was last changed [ns since 1970]; `None` if it is not there."""
    try:
        return os.stat(file).st_mtime_ns  # noqa: PTH116 - an empty name is none of this folder
    except (OSError, ValueError):
        return None


def _active(places: Sequence[Place], names_at: NamesAt) -> list[tuple[Frame, bool]]:
    """Return the controller's functions at an address, the outermost first.

    With each comes whether it is a part of the function of its name, if that comes before it: a
    lambda in it, or the same function once more after what was inlined between.
    """
    active: list[tuple[Frame, bool]] = []
    for at in reversed(range(len(places))):
        name, is_part = _function(places[at:], names_at)
        if name is not None:
            frame = Frame(name, places[at].file, places[at].line)
            active.append((frame, is_part or bool(active)))
    return active


def _function(places: Sequence[Place], names_at: NamesAt) -> tuple[QualifiedName | None, bool]:
    """Return the controller's function at the first place, and whether it is a lambda in it.

    The places after it are those it was inlined into.
    """
    symbol, file, line = places[0]
    name = source_name(symbol)
    if file.startswith(_INSTALLED) or (not file and is_of_library(name)):
        return None, False
    # In a file of the controller only a lambda has such a name.
    is_part = is_lambda(symbol) or is_of_library(name) or name == "operator()"
    around = names_at(file, line)
    if around:
        is_apart = name in around and not around[-1].startswith(f"{name}::")
        name = name if is_apart else around[-1]
        return (None if is_of_library(name) else name), is_part
    if is_part:  # what calls it says whose it is
        owners = (lambda_owner(place.symbol) for place in places)
        return next((owner for owner in owners if owner), None), True
    return name or None, False


def _changed(module: _Module) -> str | None:
    """Return why a binary's addresses cannot be named; `None` if they can."""
    try:
        now = os.stat(module.path)  # noqa: PTH116 - its path may not be UTF-8
    except OSError as error:
        return f"{module.path} cannot be read ({error.strerror}), so its functions have no names"
    if (now.st_size, now.st_mtime_ns) != (module.size, module.mtime_ns):
        return (
            f"{module.path} was built again after the run, so its addresses say nothing: "
            "run the new one"
        )
    return None
