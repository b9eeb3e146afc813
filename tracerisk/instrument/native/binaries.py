"""Which function and line of the source an address of a compiled binary belongs to.

Lines and inlined functions come from DWARF, read by `addr2line` of binutils. Where there is none of
either, names come from the binary's symbol table alone.
"""

from __future__ import annotations

import bisect
import ctypes
import ctypes.util
import re
import shutil
import struct
import subprocess
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from typing import NamedTuple

from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes
from tracerisk.instrument.native.cpp_names import is_mangled_of_library, is_of_library, source_name

_SYMTAB, _DYNSYM = 2, 11
_FUNCTION = 2
_UNKNOWN = "??"
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

    def places(self, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
        """Return the functions active at each address as linked, the innermost first.

        Those after the first have the ones before inlined. An address of no known function has
        none.
        """
        lines = _by_addr2line(self.path, addresses)
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
        places = _by_addr2line(self.path, own)
        return tuple(sorted({place.file for there in places.values() for place in there}))

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


def _by_addr2line(path: str, addresses: Sequence[int]) -> dict[int, tuple[Place, ...]]:
    program = shutil.which("addr2line")
    if program is None or not addresses:
        return {}
    asked = "".join(f"{address:#x}\n" for address in addresses)
    done = subprocess.run(
        [program, "-a", "-f", "-i", "-C", "-e", path],
        input=asked,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )
    places: dict[int, list[Place]] = {}
    now: list[Place] = []
    lines = iter(done.stdout.splitlines())
    for line in lines:
        if line.startswith("0x"):
            now = places.setdefault(int(line, 16), [])
            continue
        file, _, number = _DISCRIMINATOR.sub("", next(lines, "")).rpartition(":")
        if file != _UNKNOWN:
            now.append(Place(line, file, int(number) if number.isdigit() else 0))
    return {
        address: tuple(there)
        for address, there in places.items()
        if there and there[0].symbol != _UNKNOWN
    }


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
