"""Which function and line of the source an address of a compiled binary belongs to.

Lines and inlined functions come from DWARF, read by `addr2line` of binutils. Where there is none of
either, names come from the binary's symbol table alone.
"""

from __future__ import annotations

import bisect
import contextlib
import ctypes
import ctypes.util
import re
import shutil
import struct
import subprocess
import weakref
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.instrument.native.cpp_names import is_mangled_of_library, is_of_library, source_name

_SYMTAB, _DYNSYM = 2, 11
_FUNCTION = 2
_UNKNOWN = "??"
_AT_ONCE = 1000
"""How many addresses are asked for at once."""
_LAST = 2**64 - 1
"""The address that is asked for last, which is in no function."""
_DISCRIMINATOR = re.compile(r" \(discriminator \d+\)$")


class Place(NamedTuple):
    """A function that is active at an address."""

    symbol: str
    """Its demangled name."""
    file: str
    """Its source, as the compiler was given it; empty if unknown."""
    line: int
    """The line that is executed; 0 if unknown."""


class _Symbol(NamedTuple):
    """A function of a symbol table."""

    begins: int
    """Its address in the binary, as linked."""
    size: int
    """Its length [bytes]."""
    name: str
    """Its name, mangled."""


class Binary:
    """An executable or shared object whose addresses are asked for."""

    def __init__(self, path: str) -> None:
        self.path = path
        data = file_bytes(path, MOST_WRITTEN)
        try:
            self._symbols = sorted(_symbols(data))
        except (struct.error, ArithmeticError, LookupError, ValueError):
            self._symbols = []  # it was cut off, or is none
        self._begins = [symbol.begins for symbol in self._symbols]
        self._lines: _Lines | None = None

    def places(self, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
        """Return the functions active at each address as linked, the innermost first.

        Those after the first have the ones before inlined. An address of no known function has
        none.
        """
        lines = self._places(addresses)
        return {
            address: lines.get(address) or self._by_symbol(address) for address in sorted(addresses)
        }

    def file_of(self, symbol: str) -> str:
        """Return the source of a function by its mangled name; empty if it is not known."""
        begins = (known.begins for known in self._symbols if known.name == symbol)
        address = next(begins, None)
        places = () if address is None else self.places([address])[address]
        return places[-1].file if places else ""

    def sources(self) -> tuple[str, ...]:
        """Return the sources of its functions but for those of libraries of ROS and C++, sorted."""
        own = [
            symbol.begins
            for symbol in self._symbols
            if not is_mangled_of_library(symbol.name)
            and not is_of_library(source_name(demangled(symbol.name)))
        ]
        places = self._places(own)
        return tuple(sorted({place.file for there in places.values() for place in there}))

    def _places(self, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
        """Return what `addr2line` says of addresses; nothing where the machine has none."""
        program = shutil.which("addr2line")
        if program is None or not addresses:
            return {}
        if self._lines is None:
            self._lines = _Lines(program, self.path)
        return self._lines.places(addresses)

    def _by_symbol(self, address: int) -> tuple[Place, ...]:
        at = bisect.bisect_right(self._begins, address) - 1
        if at < 0 or address >= self._symbols[at].begins + self._symbols[at].size:
            return ()
        return (Place(demangled(self._symbols[at].name), "", 0),)


def _symbols(data: bytes) -> Iterator[_Symbol]:
    """Yield the functions of an ELF file of 64 bits, of the full table if it has one."""
    if data[:5] != b"\x7fELF\x02":
        return
    order = "<" if data[5] == 1 else ">"
    (offset,) = struct.unpack_from(order + "Q", data, 0x28)
    size, count = struct.unpack_from(order + "HH", data, 0x3A)
    sections = [
        struct.unpack_from(order + "IIQQQQIIQQ", data, offset + index * size)
        for index in range(count)
    ]
    tables = {section[1]: section for section in sections if section[1] in (_SYMTAB, _DYNSYM)}
    if not tables:
        return
    table = tables.get(_SYMTAB, tables.get(_DYNSYM))
    assert table is not None
    names = sections[table[6]][4]
    for at in range(table[4], table[4] + table[5], 24):
        name, kind, _, section, value, length = struct.unpack_from(order + "IBBHQQ", data, at)
        if kind & 15 == _FUNCTION and section and length:
            end = data.index(b"\0", names + name)
            yield _Symbol(value, length, data[names + name : end].decode("utf-8", "replace"))


class _Lines:
    """An `addr2line` that is asked again and again: to read what g++ writes takes it seconds."""

    def __init__(self, program: str, path: str) -> None:
        self._process = subprocess.Popen(
            [program, "-a", "-f", "-i", "-C", "-e", path],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            errors="replace",
        )
        self.pid = self._process.pid
        """The number of its process."""
        _ALL_LINES.add(self)
        weakref.finalize(self, _end, self._process)

    def places(self, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
        """Return what is active at each address of a known function, the innermost first."""
        known: dict[int, tuple[Place, ...]] = {}
        # So few that neither side waits for the other to read.
        for first in range(0, len(addresses), _AT_ONCE):
            known |= self._places(addresses[first : first + _AT_ONCE])
        return known

    def _places(self, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
        writes, reads = self._process.stdin, self._process.stdout
        assert writes is not None
        assert reads is not None
        with contextlib.suppress(BrokenPipeError):  # it has ended, for the file is no binary
            writes.write("".join(f"{address:#x}\n" for address in (*addresses, _LAST)))
            writes.flush()
        places: dict[int, list[Place]] = {}
        now: list[Place] = []
        for line in map(str.rstrip, reads):
            if line.startswith("0x"):
                now = places.setdefault(int(line, 16), [])
                continue
            file, _, number = _DISCRIMINATOR.sub("", next(reads, "").rstrip()).rpartition(":")
            if _LAST in places:
                break
            if file != _UNKNOWN:
                now.append(Place(line, file, int(number) if number.isdigit() else 0))
        return {
            address: tuple(there)
            for address, there in places.items()
            if there and there[0].symbol != _UNKNOWN
        }


_ALL_LINES: weakref.WeakSet[_Lines] = weakref.WeakSet()


def readers() -> tuple[int, ...]:
    """Return the processes that this one has started to read binaries, and that still wait."""
    return tuple(lines.pid for lines in _ALL_LINES)


def _end(process: subprocess.Popen[str]) -> None:
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            with contextlib.suppress(BrokenPipeError):
                pipe.close()
    process.wait()


@cache
def demangled(name: str) -> str:
    """Return a symbol as C++ writes it; the symbol itself if it is none of C++."""
    if not name.startswith("_Z"):
        return name
    plain, dot, copy = name.partition(".")
    return _demangler()(plain) + (f" [clone {dot}{copy}]" if dot else "")


@cache
def _demangler() -> Callable[[str], str]:
    library = ctypes.util.find_library("stdc++")
    if library is None:
        return lambda name: name
    demangle = ctypes.CDLL(library).__cxa_demangle
    demangle.restype = ctypes.c_void_p
    free = ctypes.CDLL(None).free
    free.argtypes = [ctypes.c_void_p]

    def by_runtime(name: str) -> str:
        status = ctypes.c_int()
        made = demangle(name.encode(), None, None, ctypes.byref(status))
        if status.value or not made:
            return name
        text = ctypes.string_at(made).decode("utf-8", "replace")
        free(made)
        return text

    return by_runtime
