"""The filter of system calls: for each number of a kernel it allows with a reason, or refuses."""

import ctypes
import errno
import faulthandler
import itertools
import json
import os
import platform
import re
import signal
import struct
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.common.sandbox.allowed_calls import ALLOWED, ANSWERED, CHECKED
from tracerisk.common.sandbox.kernel import features
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.common.sandbox.kernel.system_calls import checks, program

PAGE = Path(__file__).parents[3] / "docs" / "sandbox.md"
HEADERS = (
    ("x86_64", "/usr/include/x86_64-linux-gnu/asm/unistd_64.h"),
    ("aarch64", "/usr/include/asm-generic/unistd.h"),
)
ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
COLUMN = {"x86_64": 0, "aarch64": 1}
ALLOW, ERRNO, KILL = 0x7FFF0000, 0x00050000, 0x80000000
NEWEST = 470  # of Linux 6.17
BEYOND = 64
X32 = 0x40000000
NEW = 424  # from here on all architectures number alike, and libraries know of older calls
PROCESS = 4321


def answer(text: bytes, machine: str, number: int, arguments=(0,) * 6) -> int:
    """Return what a filter answers to a call, as the kernel computes it."""
    data = struct.pack("=IIQ6Q", number, ARCHITECTURES[machine], 0, *arguments)
    lines = [struct.unpack_from("=HBBI", text, at) for at in range(0, len(text), 8)]
    at = value = 0
    while True:
        what, hit, miss, figure = lines[at]
        at += 1
        if what == 0x20:
            (value,) = struct.unpack_from("=I", data, figure)
        elif what == 0x54:
            value &= figure
        elif what == 0x05:
            at += figure
        elif what == 0x15:
            at += hit if value == figure else miss
        elif what == 0x35:
            at += hit if value >= figure else miss
        else:
            assert what == 0x06
            return figure


def calls(groups, machine: str) -> dict[int, tuple[str, int]]:
    """Return the name and the answer of each call of some groups by its number."""
    column = COLUMN[machine]
    return {
        numbers[column]: (call, group.answer)
        for group in groups
        for call, numbers in group.numbers.items()
        if numbers[column] is not None
    }


@pytest.mark.parametrize("machine", ARCHITECTURES)
@pytest.mark.parametrize("landlock", [1, 2, 3, 6, 7])
def test_each_number_is_allowed_with_a_reason_or_refused(machine, landlock):
    text = program(landlock=landlock, process=PROCESS, machine=machine)
    allowed, answered = calls(ALLOWED, machine), calls(ANSWERED, machine)
    checked = calls(CHECKED, machine)
    numbers = range(NEWEST + 1 + BEYOND)
    assert max(allowed) < NEWEST
    for number in (*numbers, *(X32 + number for number in numbers), 0xFFFFFFFF):
        found = answer(text, machine, number, (0xDEAD_BEEF_DEAD_BEEF,) * 6)
        if number in allowed:
            assert found == ALLOW, number
        elif number in answered:
            assert found == ERRNO | answered[number][1], number
        elif number not in checked:
            assert found == ERRNO | (errno.EPERM if number < NEW else errno.ENOSYS), number


SPEAKING = {
    *("accept", "accept4", "bind", "connect", "listen", "sendmmsg", "sendmsg", "sendto"),
}


def test_only_a_network_of_its_own_opens_calls_and_only_those_that_speak():
    alone = checks(landlock=7, process=PROCESS)
    with_network = checks(landlock=7, process=PROCESS, own_network=True)
    assert {call for call in alone if with_network[call] != alone[call]} == SPEAKING
    assert {with_network[call] for call in SPEAKING} == {((),)}
    assert {alone[call] for call in SPEAKING - {"sendto"}} == {()}


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("own_network", [False, True])
@pytest.mark.parametrize(
    ("machine", "landlock"),
    slow_but([("x86_64", 7), ("aarch64", 1)], [*itertools.product(sorted(ARCHITECTURES), [1, 7])]),
)
def test_each_checked_call_is_allowed_with_its_arguments_alone(machine, landlock, own_network):
    setting = {"landlock": landlock, "process": PROCESS, "own_network": own_network}
    text = program(**setting, machine=machine)
    ways_of = checks(**setting)
    found = calls(CHECKED, machine)
    assert {call for call, _ in found.values()} <= ways_of.keys()
    for number, (call, refused) in found.items():
        ways = ways_of[call]
        if ways in ((), ((),)):
            expected = ALLOW if ways else ERRNO | refused
            assert answer(text, machine, number, (2**64 - 1,) * 6) == expected, call
        looked_at = {check.argument for way in ways for check in way}
        for given in (given for way in ways for given in fitting(way)):
            assert answer(text, machine, number, given) == ALLOW, (call, given)
            for argument, bit in itertools.product(looked_at, range(64)):
                other = list(given)
                other[argument] ^= 1 << bit
                expected = ALLOW if any(fits(way, other) for way in ways) else ERRNO | refused
                assert answer(text, machine, number, other) == expected, (call, other)


def fits(way, given) -> bool:
    return all(
        given[check.argument] >> 32 * check.is_upper & check.mask in check.values for check in way
    )


def fitting(way):
    """Yield arguments for each combination of values; what is not looked at has all bits."""
    for values in itertools.product(*(check.values for check in way)):
        given = [2**64 - 1] * 6
        for check, value in zip(way, values, strict=True):
            given[check.argument] &= ~(check.mask << 32 * check.is_upper)
            given[check.argument] |= value << 32 * check.is_upper
        yield given


@pytest.mark.parametrize(("machine", "kill"), [("x86_64", 62), ("aarch64", 129)])
@pytest.mark.parametrize("landlock", [1, 5])
def test_who_keeps_watch_gets_no_signal_where_landlock_does_not_keep_signals_in(
    machine, kill, landlock
):
    text = program(landlock=landlock, process=PROCESS, machine=machine)
    refused = ERRNO | errno.EPERM
    # The parent that keeps watch is in the group of the process, to which a 0 leads.
    for receiver in (0, 1, 2**32 - 1, PROCESS - 1, 2**32 - (PROCESS - 1)):
        assert answer(text, machine, kill, (receiver, signal.SIGKILL, 0, 0, 0, 0)) == refused
    for receiver in (PROCESS, 2**32 - PROCESS):
        assert answer(text, machine, kill, (receiver, signal.SIGUSR2, 0, 0, 0, 0)) == ALLOW


@pytest.mark.parametrize("machine", ARCHITECTURES)
def test_calls_of_another_architecture_end_the_process(machine):
    (other,) = ARCHITECTURES.keys() - {machine}
    text = program(landlock=7, process=PROCESS, machine=machine)
    assert answer(text, other, 64) == KILL
    assert answer(text, machine, 0 if machine == "x86_64" else 63) == ALLOW


@pytest.mark.parametrize(("machine", "header"), HEADERS)
def test_the_numbers_are_those_of_the_header(machine, header):
    try:
        lines = Path(header).read_text(encoding="utf-8")
    except OSError:
        pytest.skip(f"{header} is not installed")
    found = re.findall(r"^#define __NR(?:3264)?_(\w+)\s+(\d+)$", lines, re.MULTILINE)
    numbers = {{"fstatat": "newfstatat"}.get(name, name): int(text) for name, text in found}
    ours = calls((*ALLOWED, *CHECKED, *ANSWERED), machine)
    assert {call: numbers[call] for call, _ in ours.values()} == {
        call: number for number, (call, _) in ours.items()
    }
    groups = (*ALLOWED, *CHECKED, *ANSWERED)
    lacking = {
        call
        for group in groups
        for call, row in group.numbers.items()
        if row[COLUMN[machine]] is None
    }
    assert not lacking & numbers.keys()
    assert sum(len(group.numbers) for group in groups) == len(ours) + len(lacking)


def test_the_page_lists_each_call_with_its_reason():
    rows = [
        f"| {', '.join(f'`{call}`' for call in sorted(group.numbers))} | {group.reason} |"
        for group in (*ALLOWED, *CHECKED, *ANSWERED)
    ]
    text = PAGE.read_text(encoding="utf-8")
    assert [row for row in text.splitlines() if row in rows] == rows, "\n".join(rows)


HARMLESS = 2**64 - 1
# `uretprobe` and `uprobe` of x86-64 go past every filter: only code that the kernel has put there
# may call them, others get an error or end.
PAST_FILTERS = (335, 336)


def tried(numbers: list[int], user: int) -> dict[int, int]:
    """Make system calls in a contained process, and return the error of each."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            faulthandler.disable()
            os.close(reading)
            if user != os.geteuid():
                os.setgroups([])
                os.setresgid(user, user, user)
                os.setresuid(user, user, user)
            libc = ctypes.CDLL(None, use_errno=True)
            libc.syscall.restype = ctypes.c_long
            given = [ctypes.c_ulong(HARMLESS) for _ in range(6)]
            features.restrict(["/usr"], [], [])
            found = {}
            for number in numbers:
                ctypes.set_errno(0)
                done = libc.syscall(ctypes.c_long(number), *given)
                found[number] = 0 if done >= 0 else ctypes.get_errno()
            with os.fdopen(writing, "w") as stream:
                json.dump(found, stream)
        finally:
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as stream:
        text = stream.read()
    _, status = os.waitpid(child, 0)
    if not text:
        return dict.fromkeys(numbers, -os.WTERMSIG(status))
    return {int(number): error for number, error in json.loads(text).items()}


@pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")
@pytest.mark.parametrize("user", [0, 65534])
def test_the_kernel_refuses_each_number_that_is_not_listed(user):
    if os.geteuid() not in (0, user):
        pytest.skip("only root can become another user")
    machine = platform.machine()
    allowed, answered = calls((*ALLOWED, *CHECKED), machine), calls(ANSWERED, machine)
    numbers = [number for number in range(NEWEST + 1 + BEYOND) if number not in allowed]
    assert len(numbers) > 300
    expected = {
        number: answered[number][1]
        if number in answered
        else errno.EPERM
        if number < NEW
        else errno.ENOSYS
        for number in numbers
    }
    alone = [number for number in PAST_FILTERS if machine == "x86_64"]
    assert tried([number for number in numbers if number not in alone], user) == {
        number: error for number, error in expected.items() if number not in alone
    }
    for number in alone:
        assert tried([number], user)[number] in (-signal.SIGILL, errno.ENXIO, errno.EPERM)
    with_x32 = [X32 + number for number in (0, 1, 39, 512, 547)]
    assert set(tried(with_x32, user).values()) == {errno.ENOSYS}


I386_GETPID = bytes([0xB8, 20, 0, 0, 0, 0xCD, 0x80, 0xC3])


@pytest.mark.skipif(
    bool(support().missing) or platform.machine() != "x86_64", reason="needs the sandbox on x86-64"
)
def test_a_call_of_32_bits_ends_the_process():
    import mmap

    child = os.fork()
    if child == 0:
        with mmap.mmap(-1, 4096, prot=mmap.PROT_READ | mmap.PROT_WRITE | mmap.PROT_EXEC) as page:
            page.write(I386_GETPID)
            call = ctypes.CFUNCTYPE(ctypes.c_int)(ctypes.addressof(ctypes.c_char.from_buffer(page)))
            features.restrict(["/usr"], [], [])
            call()
            os._exit(0)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGSYS
