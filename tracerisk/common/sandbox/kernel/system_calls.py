"""The filter of system calls (seccomp) of a contained process, as a program for the kernel.

Landlock decides about files. What it does not know is decided here: the network, other processes,
the machine, and what changes a file without opening it. What `allowed_calls` does not list is
refused as an ordinary failure, so that a program that can live without it does.
"""

from __future__ import annotations

import errno
import itertools
import platform
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from tracerisk.common.sandbox.allowed_calls import ALLOWED, ANSWERED, CHECKED

_ALLOW, _ERRNO, _KILL = 0x7FFF0000, 0x00050000, 0x80000000
_LOAD, _AND, _JUMP, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x54, 0x05, 0x15, 0x35, 0x06
_NUMBER_AT, _ARCH_AT, _ARGUMENTS_AT = 0, 4, 16
_UPPER_HALF = 4
# From here on libraries expect that a kernel lacks a call, and take an older one.
_FIRST_NEW = 424
# By architecture: its name for the kernel, and the column of its numbers.
_MACHINES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}

_INET, _INET6, _UNIX = 2, 10, 1
_STREAM, _DATAGRAM, _PACKETS = 1, 2, 5
_TYPE = 0xF
_TCP_FLAG_FASTOPEN = 0x20000000
_O_TRUNC, _O_ACCMODE = 0o1000, 0o3

_CLONE = {
    "signal at the end": 0xFF, "VM": 0x100, "FS": 0x200, "FILES": 0x400, "SIGHAND": 0x800,
    "PIDFD": 0x1000, "VFORK": 0x4000, "THREAD": 0x10000, "SYSVSEM": 0x40000,
    "SETTLS": 0x80000, "PARENT_SETTID": 0x100000, "CHILD_CLEARTID": 0x200000,
    "DETACHED": 0x400000, "CHILD_SETTID": 0x1000000,
}  # fmt: skip
_FCNTL = {
    "DUPFD": 0, "GETFD": 1, "SETFD": 2, "GETFL": 3, "SETFL": 4, "GETLK": 5, "SETLK": 6,
    "SETLKW": 7, "GETOWN": 9, "GETSIG": 11, "OFD_GETLK": 36, "OFD_SETLK": 37, "OFD_SETLKW": 38,
    "GETLEASE": 1025, "DUPFD_QUERY": 1027, "DUPFD_CLOEXEC": 1030, "SETPIPE_SZ": 1031,
    "GETPIPE_SZ": 1032, "GET_SEALS": 1034,
}  # fmt: skip
_IOCTL = {
    "TCGETS": 0x5401, "TCGETS2": 0x802C542A, "TIOCGPGRP": 0x540F, "TIOCGSID": 0x5429,
    "TIOCOUTQ": 0x5411, "TIOCGWINSZ": 0x5413, "FIONREAD": 0x541B, "FIONBIO": 0x5421,
    "FIONCLEX": 0x5450, "FIOCLEX": 0x5451, "FIOQSIZE": 0x5460,
    "SIOCGIFNAME": 0x8910, "SIOCGIFCONF": 0x8912, "SIOCGIFFLAGS": 0x8913,
    "SIOCGIFADDR": 0x8915, "SIOCGIFBRDADDR": 0x8919, "SIOCGIFNETMASK": 0x891B,
    "SIOCGIFMTU": 0x8921, "SIOCGIFHWADDR": 0x8927, "SIOCGIFINDEX": 0x8933,
}  # fmt: skip
_PRCTL = {
    "SET_PDEATHSIG": 1, "GET_PDEATHSIG": 2, "GET_DUMPABLE": 3, "GET_KEEPCAPS": 7,
    "SET_NAME": 15, "GET_NAME": 16, "GET_SECCOMP": 21, "SET_SECCOMP": 22, "CAPBSET_READ": 23,
    "CAPBSET_DROP": 24, "GET_TSC": 25, "SET_TIMERSLACK": 29, "GET_TIMERSLACK": 30,
    "SET_CHILD_SUBREAPER": 36, "GET_CHILD_SUBREAPER": 37, "SET_NO_NEW_PRIVS": 38,
    "GET_NO_NEW_PRIVS": 39, "SET_THP_DISABLE": 41, "GET_THP_DISABLE": 42, "SVE_SET_VL": 50,
    "SVE_GET_VL": 51, "GET_TAGGED_ADDR_CTRL": 56, "GET_AUXV": 0x41555856,
    "SET_VMA": 0x53564D41,
}  # fmt: skip
_OPTIONS_OF_SOCKETS: Mapping[int, Mapping[str, int]] = {
    1: {
        "SO_REUSEADDR": 2, "SO_BROADCAST": 6, "SO_SNDBUF": 7, "SO_RCVBUF": 8,
        "SO_KEEPALIVE": 9, "SO_OOBINLINE": 10, "SO_LINGER": 13, "SO_REUSEPORT": 15,
        "SO_PASSCRED": 16, "SO_RCVLOWAT": 18, "SO_RCVTIMEO": 20, "SO_SNDTIMEO": 21,
        "SO_TIMESTAMP": 29, "SO_RCVTIMEO of 64 bits": 66, "SO_SNDTIMEO of 64 bits": 67,
    },
    0: {"IP_TOS": 1, "IP_TTL": 2, "IP_MULTICAST_TTL": 33, "IP_MULTICAST_LOOP": 34},
    6: {
        "TCP_NODELAY": 1, "TCP_KEEPIDLE": 4, "TCP_KEEPINTVL": 5, "TCP_KEEPCNT": 6,
        "TCP_QUICKACK": 12, "TCP_USER_TIMEOUT": 18,
    },
    41: {"IPV6_UNICAST_HOPS": 16, "IPV6_MULTICAST_HOPS": 18, "IPV6_V6ONLY": 26},
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Check:
    """What the lower half of an argument of a call must be; the kernel takes it for an `int`."""

    argument: int
    """The number of the argument."""
    values: tuple[int, ...]
    """What it may be."""
    mask: int = 0xFFFFFFFF
    """The bits that are looked at."""
    is_upper: bool = False
    """Whether the upper half is meant; both halves of a null pointer are 0."""


_SPEAKING = ("accept", "accept4", "bind", "connect", "listen", "sendmmsg", "sendmsg")

Checks = Sequence[tuple[Check, ...]]
"""Which arguments a call may have: in one of these ways all checks must hold."""
_ALWAYS: Checks = ((),)

Lines = tuple[tuple[int, int, int, int], ...]
"""Instructions of the kernel's filter: what to do, two distances to jump, and a figure."""


_ALLOWED: Lines = ((_RETURN, 0, 0, _ALLOW),)
_UNKNOWN: Lines = ((_RETURN, 0, 0, _ERRNO | errno.EPERM),)
_UNKNOWN_NEW: Lines = ((_RETURN, 0, 0, _ERRNO | errno.ENOSYS),)


def checks(*, landlock: int, process: int, own_network: bool = False) -> dict[str, Checks]:
    """Return the arguments that calls may have on a kernel with this version of Landlock.

    `process` is the contained process, which may always signal itself. A 0 would be its group, in
    which is also the parent that ends what it leaves behind. With its `own_network`, in which
    there is nobody else, it may speak to any address.
    """
    spoken = _ALWAYS if own_network else ()
    itself = ((Check(0, (0, process)),),)
    signalled = ((Check(0, (process, -process & 0xFFFFFFFF)),),)
    return {
        "clone": ((Check(0, (0,), ~sum(_CLONE.values()) & 0xFFFFFFFF),),),
        "socket": tuple(
            (Check(0, (_INET, _INET6)), Check(1, (kind,), _TYPE), Check(2, (0, protocol)))
            for kind, protocol in ((_STREAM, 6), (_DATAGRAM, 17))
        ),
        "socketpair": ((Check(0, (_UNIX,)), Check(1, (_STREAM, _PACKETS), _TYPE)),),
        # `sendmsg` names its receiver in memory, which a filter cannot read.
        "sendto": spoken
        or ((Check(4, (0,)), Check(4, (0,), is_upper=True), Check(3, (0,), _TCP_FLAG_FASTOPEN)),),
        **dict.fromkeys(_SPEAKING, spoken),
        "setsockopt": tuple(
            (Check(1, (level,)), Check(2, tuple(options.values())))
            for level, options in _OPTIONS_OF_SOCKETS.items()
        ),
        "ioctl": ((Check(1, tuple(_IOCTL.values())),),),
        "fcntl": ((Check(1, tuple(_FCNTL.values())),),),
        "prctl": ((Check(0, tuple(_PRCTL.values())),),),
        "personality": ((Check(0, (0, 0xFFFFFFFF)),),),
        "prlimit64": itself,
        "sched_setaffinity": itself,
        # From version 6 on Landlock itself keeps signals within, from 3 on it knows of truncation.
        "kill": signalled if landlock < 6 else _ALWAYS,
        "tgkill": ((Check(0, (process,)),),) if landlock < 6 else _ALWAYS,
        "tkill": ((Check(0, (process,)),),) if landlock < 6 else _ALWAYS,
        "truncate": () if landlock < 3 else _ALWAYS,
        "open": _cutting_what_it_writes(1) if landlock < 3 else _ALWAYS,
        "openat": _cutting_what_it_writes(2) if landlock < 3 else _ALWAYS,
    }


def _cutting_what_it_writes(flags: int) -> Checks:
    writes = (Check(flags, (1, 2, 3), _O_ACCMODE),)
    return ((Check(flags, (0,), _O_TRUNC),), writes)


def is_known_machine() -> bool:
    """Return whether there is a filter for this machine's processor."""
    return platform.machine() in _MACHINES and struct.calcsize("P") == 8


def program(
    *, landlock: int, process: int, own_network: bool = False, machine: str | None = None
) -> bytes:
    """Return the filter as a program: instructions of 8 bytes, `struct sock_filter`.

    Raises KeyError for a machine that `is_known_machine` does not know.
    """
    name, column = _MACHINES[machine or platform.machine()]
    found: dict[int | None, Lines] = {}
    arguments = checks(landlock=landlock, process=process, own_network=own_network)
    for group in ALLOWED:
        found |= dict.fromkeys((pair[column] for pair in group.numbers.values()), _ALLOWED)
    for group in (*CHECKED, *ANSWERED):
        refused = (_RETURN, 0, 0, _ERRNO | group.answer)
        for call, numbers in group.numbers.items():
            found[numbers[column]] = (*_tested(arguments.get(call, ())), refused)
    # A call that the machine lacks has no number.
    found.pop(None, None)
    begun = (
        (_LOAD, 0, 0, _ARCH_AT),
        (_EQUAL, 1, 0, name),
        (_RETURN, 0, 0, _KILL),
        (_LOAD, 0, 0, _NUMBER_AT),
    )
    lines = (*begun, *_searched(_ranges(found)))
    return struct.pack("=" + "HBBI" * len(lines), *itertools.chain.from_iterable(lines))


def _ranges(found: Mapping[int | None, Lines]) -> list[tuple[int, Lines]]:
    """Return what is to be done from which number on; the last goes on without end."""
    ranges: list[tuple[int, Lines]] = []
    for number in range(max(filter(None, found)) + 2):
        lines = found.get(number, _UNKNOWN if number < _FIRST_NEW else _UNKNOWN_NEW)
        if not ranges or ranges[-1][1] != lines:
            ranges.append((number, lines))
    return ranges


def _searched(ranges: Sequence[tuple[int, Lines]]) -> Lines:
    """Return a search for the range of a number: a call takes few steps, be they ever so many."""
    if len(ranges) == 1:
        return ranges[0][1]
    middle = len(ranges) // 2
    below, above = _searched(ranges[:middle]), _searched(ranges[middle:])
    # A test jumps over 255 instructions at most, and a jump over any number of them.
    return (
        (_AT_LEAST, 0, 1, ranges[middle][0]),
        (_JUMP, 0, 0, len(below)),
        *below,
        *above,
    )


def _tested(ways: Checks) -> Lines:
    """Return the tests of a call's arguments, which allow it or go on behind them."""
    lines: Lines = ()
    for way in ways:
        tests = _ALLOWED
        for check in reversed(way):
            at = _ARGUMENTS_AT + 8 * check.argument + _UPPER_HALF * check.is_upper
            count, behind = len(check.values), len(tests)
            compared = tuple(
                (_EQUAL, count - index, 0 if index < count else behind, value)
                for index, value in enumerate(check.values, 1)
            )
            tests = ((_LOAD, 0, 0, at), (_AND, 0, 0, check.mask), *compared, *tests)
        lines += tests
    return lines
