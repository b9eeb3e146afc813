"""System calls by which a contained process might reach what lies outside; as a user and as root.

Each attack is made by itself in a contained process, which says what it got. What lies outside is
compared before and after.
"""

import array
import contextlib
import ctypes
import errno
import fcntl
import functools
import json
import os
import platform
import resource
import shutil
import socket
import struct
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from tests.forked import in_child
from tracerisk.common.sandbox.kernel import features
from tracerisk.common.sandbox.kernel.features import support

pytestmark = pytest.mark.skipif(
    bool(support().missing) or platform.machine() != "x86_64", reason="needs the sandbox on x86-64"
)
NOBODY = 65534
# What an attack gets is the answer of the system; it has failed where that is no error.
FILES = {
    "file_setattr": "S(469, -100, P, b'\\x20' + bytes(23), 24, 0)",
    "file_setattr by descriptor": "S(469, R, b'', b'\\x20' + bytes(23), 24, 0x1000)",
    "flags of a readable file": "I(R, 0x40086602, array.array('l', [FLAGS | 0x40]))",
    "flags of XFS": "I(R, 0x401C5820, bytearray(28))",
    "a readable file that nothing changes": "I(R, 0x40086602, array.array('l', [FLAGS | 0x10]))",
    "append by a descriptor for reading": "S(18, R, b'pwned', 5, 0)",
    "copy into a readable file": "S(326, R, None, R, None, 1, 0)",
    "a hole in a readable file": "S(285, R, 3, 0, 1)",
    "a lease on a readable file": "fcntl.fcntl(R, 1024, 0)",
    "a watch by signals": "fcntl.fcntl(R, 1026, 1)",
    "a hint for writing": "fcntl.fcntl(R, 1036, struct.pack('Q', 5))",
    "extended attribute": "S(188, P, b'user.a', b'x', 1, 0)",
    "extended attribute at a folder": "S(463, -100, P, 0, b'user.a', b'x', 16)",
    "no extended attribute at a folder": "S(466, -100, P, 0, b'user.a')",
    "a handle of a file": "S(303, -100, P, struct.pack('Ii', 128, 0) + bytes(128), bytes(8), 0)",
    "a file by its handle": "S(304, -100, struct.pack('II', 8, 1) + bytes(128), 2)",
    "open for writing": "S(2, P, 1, 0)",
    "open for cutting": "S(2, P, 0o1000, 0)",
    "open a file without a name": "S(257, -100, os.path.dirname(P), 0o20200002, 0o600)",
    "openat2": "S(437, -100, P, struct.pack('QQQ', 1, 0, 0), 24)",
    "open through the root of a process": "S(2, b'/proc/self/root' + P, 1, 0)",
    "open again for writing": "S(2, f'/proc/self/fd/{R}'.encode(), 1, 0)",
    "cut": "S(76, P, 0)",
    "link": "S(86, P, os.path.join(W, b'link'))",
    "link of a descriptor": "S(265, R, b'', -100, os.path.join(os.path.dirname(P), b'n'), 0x1000)",
    "exchange": "S(316, -100, P, -100, os.path.join(W, b'own'), 2)",
    "replace": "S(82, os.path.join(W, b'own'), P)",
    "remove": "S(87, P)",
    "a folder beside it": "S(83, os.path.dirname(P) + b'/new', 0o777)",
    "a fifo beside it": "S(133, os.path.dirname(P) + b'/new', 0o10777, 0)",
    "a link beside it": "S(88, b'/', os.path.dirname(P) + b'/new')",
    "another root": "S(161, W)",
    "a turned root": "S(155, W, W)",
    "a mount": "S(165, b'none', W, b'tmpfs', 0, 0)",
    "a mount of a tree": "S(428, -100, W, 1)",
    "a new file system": "S(430, b'tmpfs', 0)",
    "attributes of a mount": "S(442, -100, W, 0, bytes(32), 32)",
    "no mount": "S(166, W, 2)",
    "the list of mounts": "S(458, struct.pack('IIQQ', 24, 0, -1 & 2**64 - 1, 0), bytes(80), 10, 0)",
    "quotas": "S(179, 0x800001 << 8, None, 0, None)",
    "quotas of a descriptor": "S(443, R, 0x800001 << 8, 0, None)",
    "accounting": "S(163, None)",
    "watch of all files": "S(300, 0, 0)",
    "swap": "S(167, os.path.join(W, b'own'), 0)",
    "a clone of a file": "I(R, 0x40049409, R)",
    "a discard": "I(R, 0x1277, bytes(16))",
}
PROCESSES = {
    "trace": "S(101, 16, PARENT, 0, 0)",
    "seize": "S(101, 0x4206, PARENT, 0, 0)",
    "read memory": "S(310, PARENT, bytes(16), 1, bytes(16), 1, 0)",
    "write memory": "S(311, PARENT, bytes(16), 1, bytes(16), 1, 0)",
    "a descriptor of a process": "S(434, PARENT, 0)",
    "a file of a process": "S(438, os.open('/dev/null', 0), 0, 0)",
    "a signal by descriptor": "S(424, 0, 0, None, 0)",
    "advice for memory": "S(440, 0, bytes(16), 1, 4, 0)",
    "memory of a dead process": "S(448, 0, 0)",
    "compare": "S(312, PARENT, os.getpid(), 0, 0, 0)",
    "signal": "S(62, PARENT, 0)",
    "signal to a group": "S(62, -GROUP, 0)",
    "signal to init": "S(62, 1, 0)",
    "signal to a thread": "S(234, PARENT, PARENT, 0)",
    "old signal to a thread": "S(200, PARENT, 0)",
    "queued signal": "S(129, PARENT, 0, bytes(128))",
    "queued signal to a thread": "S(297, PARENT, PARENT, 0, bytes(128))",
    "signals of a file": "fcntl.fcntl(PIPE, 8, PARENT)",
    "other signals of a file": "fcntl.fcntl(PIPE, 10, 9)",
    "signals of a file by its request": "I(PIPE, 0x8901, struct.pack('i', PARENT))",
    "asynchronous": "I(PIPE, 0x5452, struct.pack('i', 1))",
    "limits": "S(302, PARENT, 7, None, bytes(16))",
    "limits set": "S(302, PARENT, 4, bytes(16), None)",
    "processors": "S(203, PARENT, 8, struct.pack('Q', 1))",
    "pages of memory": "S(279, PARENT, 0, None, None, None, 0)",
    "nodes of memory": "S(256, PARENT, 64, bytes(8), bytes(8))",
    "robust list": "S(274, PARENT, bytes(8), bytes(8))",
    "group of a process": "S(109, PARENT, 0)",
    "brother": "S(56, 0x8000 | 17, 0, 0, 0, 0) or os._exit(0)",
    "traced child": "S(56, 0x2000 | 17, 0, 0, 0, 0) or os._exit(0)",
    "clone3": "S(435, struct.pack('QQQQQQQQ', 0x10000000, 0, 0, 0, 17, 0, 0, 0), 64) or os._exit(0)",
    "child in a namespace of users": "S(56, 0x10000000 | 17, 0, 0, 0, 0) or os._exit(0)",
    "child in a namespace of mounts": "S(56, 0x20000 | 17, 0, 0, 0, 0) or os._exit(0)",
    "child in a namespace of networks": "S(56, 0x40000000 | 17, 0, 0, 0, 0) or os._exit(0)",
    "namespace of users": "S(272, 0x10000000)",
    "namespace of time": "S(272, 0x80)",
    "join a namespace": "S(308, R, 0)",
    "who may trace": "S(157, 0x59616D61, PARENT, 0, 0, 0)",
    "memory map": "S(157, 35, 1, 0, 0, 0)",
    "core scheduling": "S(157, 62, 1, PARENT, 0, 0)",
    "kind of process": "S(135, 0x40000)",
    "local table": "S(154, 1, bytes(16), 16)",
    "ports of the machine": "S(172, 3)",
    "some ports": "S(173, 0x80, 1, 1)",
}
RIGHTS = {
    "user": "S(105, 1)",
    "real user": "S(117, 1, 1, 1)",
    "saved user": "S(113, -1, 1)",
    "group": "S(106, 1)",
    "groups": "S(116, 0, None)",
    "group of files": "-1 if S(123, 1) in (-1, os.getegid()) else 0",
    "capabilities": "S(126, struct.pack('Ii', 0x20080522, 0), struct.pack('6I', *[0xFFFFFFFF] * 6))",
    "ambient capability": "S(157, 47, 2, 21, 0, 0)",
    "kept capabilities": "S(157, 8, 1, 0, 0, 0)",
    "secure bits": "S(157, 28, 0, 0, 0, 0)",
    "any capability": "-1 if not any(S(157, 23, n, 0, 0, 0) > 0 for n in range(41)) or os.geteuid() else 0",
    "a filter": "S(317, 1, 8, bytes(16))",
    "limit of memory": "resource.setrlimit(resource.RLIMIT_AS, (-1, -1))",
    "limit of files": "resource.setrlimit(resource.RLIMIT_NOFILE, (1 << 20, 1 << 20))",
    "a part of the keyring": "S(250, 0, -3, 1)",
    "a key": "S(248, b'user', b'a', b'b', 1, -3)",
    "a wanted key": "S(249, b'user', b'a', None, -3)",
    "shared memory": "S(29, 4242, 4096, 0o1666)",
    "shared memory of another": "S(30, SEGMENT, 0, 0)",
    "semaphores": "S(64, 4242, 1, 0o1666)",
    "semaphores of another": "S(65, 0, bytes(6), 1)",
    "messages": "S(68, 4242, 0o1666)",
    "queue": "S(240, b'pwned', 0o102, 0o600, None)",
    "no queue": "S(241, b'pwned')",
    "memory that no limit counts": "S(319, b'a', 0)",
    "secret memory": "S(447, 0)",
    "rings": "S(425, 8, bytes(120))",
    "old rings": "S(206, 8, bytes(8))",
    "faults of memory": "S(323, 1)",
    "program of the kernel": "S(321, 0, bytes(72), 72)",
    "events of the processor": "S(298, bytes(112), 0, -1, -1, 0)",
    "a module": "S(175, b'', 0, b'')",
    "a module of a file": "S(313, R, b'', 0)",
    "no module": "S(176, b'pwned', 0)",
    "another kernel": "S(246, 0, 0, None, 0)",
    "start again": "S(169, 0, 0, 0, None)",
    "log of the kernel": "S(103, 3, bytes(99), 99)",
    "time": "S(164, None, None)",
    "clock": "S(227, 0, None)",
    "rate of the clock": "S(159, bytes(208))",
    "rate of a clock": "S(305, 0, bytes(208))",
    "name of the machine": "S(170, os.uname().nodename.encode(), len(os.uname().nodename))",
    "name of the domain": "S(171, b'(none)', 6)",
    "hang up": "S(153)",
    "terminal": "I(0, 0x5412, b'x')",
    "terminal of the session": "I(0, 0x540E, 0)",
    "settings of a terminal": "I(0, 0x5402, bytes(36))",
    "a console": "I(0, 0x541C, b'\\x02' + bytes(9))",
    "upper half of a request": "S(16, 0, 0xDEAD_0000_5412, b'x')",
    "device": "S(133, os.path.join(W, b'zero'), 0o20666, os.makedev(1, 5))",
    "memory of the machine": "S(2, b'/dev/mem', 2, 0)",
    "terminal by name": "S(2, b'/dev/tty', 2, 0)",
    "pseudo-terminal": "S(2, b'/dev/ptmx', 2, 0)",
    "settings of the kernel": "S(2, b'/proc/sys/kernel/core_pattern', 1, 0)",
    "memory of init": "S(2, b'/proc/1/mem', 2, 0)",
    "groups of processes": "S(83, b'/sys/fs/cgroup/pwned', 0o777)",
}
NETWORK = {
    "group of IPv4": "SOCKET(2, 2).setsockopt(0, 35, socket.inet_aton('239.1.2.3') + bytes(4))",
    "group of IPv4 by name": "SOCKET(2, 2).setsockopt(0, 35, socket.inet_aton('239.1.2.3') + bytes(8))",
    "group with its source": "SOCKET(2, 2).setsockopt(0, 39, socket.inet_aton('239.1.2.3') + bytes(8))",
    "any group": "SOCKET(2, 2).setsockopt(0, 42, bytes(136))",
    "group of IPv6": "SOCKET(10, 2).setsockopt(41, 20, b'\\xff\\x02' + bytes(14) + bytes(4))",
    "a device": "SOCKET(2, 2).setsockopt(1, 25, b'lo\\0')",
    "a mark": "SOCKET(2, 2).setsockopt(1, 36, 1)",
    "forced buffer": "SOCKET(2, 2).setsockopt(1, 32, 1 << 20)",
    "filter of a socket": "SOCKET(2, 2).setsockopt(1, 26, bytes(16))",
    "options of packets": "SOCKET(2, 2).setsockopt(0, 4, b'\\x07\\x07\\x04' + bytes(5))",
    "tables of packets": "SOCKET(2, 2).setsockopt(0, 64, bytes(96))",
    "repair": "SOCKET(2, 1).setsockopt(6, 19, 1)",
    "first packet": "SOCKET(2, 1).setsockopt(6, 30, 1)",
    "upper half of an option": "S(54, UDP.fileno(), 0xDEAD_0000_0000, 35,"
    " socket.inet_aton('239.1.2.3') + bytes(4), 8)",
    "flags of an interface": "I(UDP.fileno(), 0x8914, b'lo'.ljust(16, b'\\0') + b'\\x49' + bytes(15))",
    "address": "I(UDP.fileno(), 0x8916, b'lo'.ljust(16, b'\\0') + HOME)",
    "route": "I(UDP.fileno(), 0x890B, bytes(120))",
    "neighbour": "I(UDP.fileno(), 0x8955, bytes(68))",
    "card": "I(UDP.fileno(), 0x8946, b'lo'.ljust(40, b'\\0'))",
    "tunnel": "I(UDP.fileno(), 0x89F1, b'lo'.ljust(40, b'\\0'))",
    "bridge": "I(UDP.fileno(), 0x89A1, b'pwned'.ljust(16, b'\\0'))",
    **{
        f"family {family}": f"max(S(41, {family}, kind, 0) for kind in (1, 2, 3, 5))"
        for family in (1, *range(3, 10), *range(11, 46))
    },
    "protocols": "max(S(41, family, *kind) for family in (2, 10) for kind in"
    " ((3, 255), (2, 1), (2, 58), (1, 132), (2, 136), (1, 262), (3, 1)))",
    "pair of datagrams": "S(53, 1, 2, 0, bytes(8))",
    "pair of another family": "S(53, 30, 1, 0, bytes(8))",
    "connection": "S(42, TCP.fileno(), TO, 16)",
    "connection of IPv6": "SOCKET(10, 1).connect(('::ffff:127.0.0.1', PORT))",
    "connection to another machine": "SOCKET(2, 1).connect(('192.0.2.1', PORT))",
    "port of the system": "SOCKET(2, 1).bind(('127.0.0.1', 80))",
    "a name without a file": "SOCKET(1, 1).connect('\\0x')",
}  # fmt: skip
# These a process may do in a network of its own, in which they reach nobody.
SPEAKING = {
    "connection of datagrams": "S(42, UDP.fileno(), TO, 16)",
    "message": "SOCKET(2, 2).sendmsg([b'pwned'], [], 0, ('127.0.0.1', PORT))",
    "messages at once": "S(307, UDP.fileno(), struct.pack('QIxxxx', ctypes.addressof(NAME), 16)"
    " + bytes(48), 1, 0)",
    "bound": "S(49, TCP.fileno(), bytes([2]) + bytes(15), 16)",
    "listens": "S(50, TCP.fileno(), 1)",
    "bound to the port of another": "SOCKET(2, 1).bind(('127.0.0.1', PORT))",
    "datagram": "SOCKET(2, 2).sendto(b'pwned', ('127.0.0.1', PORT))",
    "datagram to another machine": "SOCKET(2, 2).sendto(b'pwned', ('192.0.2.1', PORT))",
}  # fmt: skip
SILENT = {
    # These are said to have succeeded.
    "mode": "S(90, P, 0o777)",
    "mode of a readable file": "S(91, R, 0o777)",
    "mode at a folder": "S(268, -100, P, 0o777)",
    "newer mode": "S(452, -100, P, 0o777, 0)",
    "owner": "S(92, P, 1, 1)",
    "owner of a readable file": "S(93, R, 1, 1)",
    "owner at a folder": "S(260, -100, P, 1, 1, 0)",
    "times": "S(280, -100, P, bytes(32), 0)",
    "times of a readable file": "S(280, R, None, bytes(32), 0)",
    "old times": "S(235, P, bytes(32))",
    "priority": "S(141, 0, PARENT, 19)",
    "schedule": "S(144, PARENT, 3, bytes(4))",
    "attributes of a schedule": "S(314, PARENT, struct.pack('IIQiIQQQ', 48, 3, 0, 0, 0, 0, 0, 0), 0)",
    "priority of files": "S(251, 1, PARENT, 3 << 13)",
    "datagram": "SOCKET(2, 2).sendto(b'pwned', ('127.0.0.1', PORT))",
    "first packet": "SOCKET(2, 1).sendto(b'pwned', 0x20000000, ('127.0.0.1', PORT))",
    "sync": "S(162)",
}
ATTACKS = {
    "files": FILES,
    "processes": PROCESSES,
    "rights": RIGHTS,
    "network": NETWORK,
    "silent": SILENT,
}
ROOT = Path(__file__).parents[3]


class World:
    """What lies outside: a file, this process, and a socket that waits to be spoken to."""

    def __init__(self, user: int) -> None:
        # Not in pytest's folder, which another user cannot enter.
        folder = self.folder = Path(tempfile.mkdtemp())
        folder.chmod(0o711)
        self.victim, self.own = folder / "outside" / "victim", folder / "own"
        for new in (self.victim.parent, self.own):
            new.mkdir()
        self.victim.write_text("SECRET")
        (self.own / "own").write_text("own")
        for path in (self.victim.parent, self.victim, self.own, self.own / "own"):
            os.chown(path, user, user)
        self.tcp = socket.create_server(("127.0.0.1", 0))
        self.tcp.setblocking(False)
        self.udp = socket.socket(type=socket.SOCK_DGRAM)
        self.udp.bind(self.tcp.getsockname())
        self.udp.setblocking(False)
        libc = ctypes.CDLL(None, use_errno=True)
        self.segment = libc.shmget(0, 4096, 0o1666)

    def close(self) -> None:
        self.udp.close()
        self.tcp.close()
        ctypes.CDLL(None).shmctl(self.segment, 0, None)
        shutil.rmtree(self.folder)

    def flags(self) -> int:
        flags = array.array("l", [0])
        with self.victim.open() as stream, contextlib.suppress(OSError):
            fcntl.ioctl(stream, 0x80086601, flags, True)
        return flags[0]

    def state(self) -> dict[str, object]:
        status = self.victim.stat()
        schedule = os.sched_getscheduler(0), os.getpriority(os.PRIO_PROCESS, 0)
        got = []
        for receive in (lambda: self.udp.recv(9), self.tcp.accept):
            with contextlib.suppress(BlockingIOError):
                got.append(receive())
        return {
            "text": self.victim.read_text(),
            "status": [status.st_mode, status.st_uid, status.st_gid, status.st_mtime_ns],
            "links": status.st_nlink,
            "flags": self.flags(),
            "attributes": os.listxattr(self.victim),
            "beside": sorted(path.name for path in self.victim.parent.iterdir()),
            "process": [*schedule, sorted(os.sched_getaffinity(0)), os.getpgrp()],
            "files": [resource.getrlimit(kind) for kind in range(16)],
            "machine": list(os.uname()),
            "got": got,
            "mounts": Path("/proc/self/mountinfo").read_text(encoding="utf-8"),
            "groups": Path("/proc/net/igmp").read_text(encoding="ascii"),
        }


def made(world: World, code: str, user: int, *, own_network: bool = False) -> str:
    """Make an attack in a contained process; return what it got, empty where that is an error."""
    parent = os.getpid()

    def attack() -> str:
        if user != os.geteuid():
            os.setgroups([])
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
            # As after `exec`: else /proc/self belongs to root.
            ctypes.CDLL(None).prctl(4, 1, 0, 0, 0)
        os.setpgid(0, 0)
        if own_network and not features.leave_network():
            raise RuntimeError("the kernel allows no network of its own")
        space = attacker(world, parent)
        for kind, most in ((resource.RLIMIT_AS, 1 << 36), (resource.RLIMIT_NOFILE, 512)):
            resource.setrlimit(kind, (most, most))
        features.restrict(
            ["/usr", str(world.victim)],
            [],
            [str(world.own)],
            own_network=own_network,
        )
        return tried(code, space)

    return in_child(attack)


def tried(code: str, space: dict[str, object]) -> str:
    try:
        result = eval(code, space)
    except (OSError, ValueError) as error:
        if isinstance(error, OSError) and error.errno == errno.EBADF:
            raise
        return ""
    return "" if isinstance(result, int) and result < 0 else f"got {result!r}"


def address(port: int) -> bytes:
    loopback = socket.inet_aton("127.0.0.1")
    return struct.pack("=H", socket.AF_INET) + struct.pack("!H", port) + loopback + bytes(8)


def attacker(world: World, parent: int) -> dict[str, object]:
    libc = ctypes.CDLL(None, use_errno=True)
    libc.syscall.restype = ctypes.c_long

    def call(number: int, *arguments: object) -> int:
        given = [ctypes.c_long(item) if isinstance(item, int) else item for item in arguments]
        return int(libc.syscall(ctypes.c_long(number), *given))

    def request(descriptor: int, number: int, what: object) -> int:
        result = fcntl.ioctl(descriptor, number, what)
        return 0 if isinstance(result, bytes) else result

    return {
        **{name: globals()[name] for name in ("array", "ctypes", "fcntl", "os", "resource", "socket", "struct")},
        "NAME": ctypes.create_string_buffer(address(world.udp.getsockname()[1]), 16),
        "S": call,
        "I": request,
        "P": os.fsencode(world.victim),
        "FLAGS": world.flags(),
        "R": os.open(world.victim, os.O_RDONLY),
        "W": os.fsencode(world.own),
        "PIPE": os.pipe()[0],
        "PARENT": parent,
        "GROUP": os.getpgid(parent),
        "SEGMENT": world.segment,
        "PORT": world.udp.getsockname()[1],
        "TO": address(world.udp.getsockname()[1]),
        "HOME": address(0),
        "TCP": socket.socket(),
        "UDP": socket.socket(type=socket.SOCK_DGRAM),
        "SOCKET": socket.socket,
    }  # fmt: skip


@pytest.fixture(params=[NOBODY, 0], ids=["user", "root"])
def user(request):
    if os.geteuid() not in (0, request.param):
        pytest.skip("only root can become another user")
    return request.param


@pytest.fixture
def world(user):
    new = World(user)
    yield new
    new.close()


def made_apart(
    kind: str, user: int, *, own_network: bool = False
) -> tuple[dict[str, str], dict[str, str]]:
    """Return what each attack of a kind got, and what has changed outside.

    They are made by a process of their own: to fork the one of all tests takes long, for it is large.
    """
    code = f"from {__spec__.name} import write_made; write_made({kind!r}, {user}, {own_network})"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    got, changed = json.loads(done.stdout)
    assert got.keys() == ATTACKS[kind].keys()
    return got, changed


def write_made(kind: str, user: int, own_network: bool) -> None:
    world = World(user)
    before = world.state()
    got = {
        name: made(world, code, user, own_network=own_network)
        for name, code in ATTACKS[kind].items()
    }
    after = world.state()
    world.close()
    changed = {
        name: f"{before[name]} became {after[name]}"
        for name in before
        if before[name] != after[name]
    }
    sys.stdout.write(json.dumps([got, changed]))


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("kind", sorted(ATTACKS.keys() - {"silent"}))
@pytest.mark.parametrize("own_network", [False, True], ids=["no_network", "own_network"])
def test_no_call_reaches_what_lies_outside(kind, user, own_network):
    may_have(own_network, user)
    got, changed = made_apart(kind, user, own_network=own_network)
    assert {name: text for name, text in got.items() if text} == {}
    assert changed == {}


@functools.cache
def offers_own_network(user: int) -> bool:
    child = os.fork()
    if child == 0:
        if user != os.geteuid():
            os.setresgid(user, user, user)
            os.setresuid(user, user, user)
            ctypes.CDLL(None).prctl(4, 1, 0, 0, 0)
        os._exit(not features.leave_network())
    return os.waitpid(child, 0)[1] == 0


def may_have(own_network: bool, user: int) -> None:
    if own_network and not offers_own_network(user):
        pytest.skip("the kernel allows no network of its own")


@pytest.mark.parametrize("name", SPEAKING)
def test_who_speaks_in_a_network_of_its_own_reaches_nobody_outside(world, user, name):
    may_have(True, user)
    before = world.state()
    alone = made(world, SPEAKING[name], user)
    # Without such a network it is refused, or lost.
    assert alone == ("got 0" if name.startswith("datagram") else "")
    assert made(world, SPEAKING[name], user, own_network=True).startswith("got")
    assert world.state() == before


@pytest.mark.slow(but=1)
def test_what_is_said_to_succeed_has_no_effect(user):
    got, changed = made_apart("silent", user)
    assert {name for name, text in got.items() if "Traceback" in text or "made" in text} == set()
    assert changed == {}


def test_a_contained_process_has_no_capability_and_gains_none(world, user):
    text = "open('/proc/self/status').read()"
    assert made(world, text, user) == ""  # which it cannot read; what it execs neither
    names = ("CapInh", "CapPrm", "CapEff", "CapAmb", *(["CapBnd"] if user == 0 else []))
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            # Another user may no longer open it.
            with Path("/proc/self/status").open(encoding="ascii") as status:
                if user != os.geteuid():
                    os.setresgid(user, user, user)
                    os.setresuid(user, user, user)
                features.restrict(["/usr"], [], [])
                os.write(writing, status.read().encode())
        finally:
            os._exit(0)
    os.close(writing)
    os.waitpid(child, 0)
    lines = dict(line.split(":") for line in os.read(reading, 9999).decode().splitlines())
    os.close(reading)
    assert {lines[name].strip() for name in names} == {"0" * 16}
    assert lines["NoNewPrivs"].strip() == "1"
    assert lines["Seccomp"].strip() == "2"


def test_root_opens_what_another_user_owns_and_the_sandbox_allows():
    if os.geteuid() != 0:
        pytest.skip("only root can open what another owns")
    world = World(NOBODY)
    world.victim.chmod(0o600)
    (world.own / "own").chmod(0o600)
    code = "len(os.read(os.open(P, os.O_RDONLY), 9)) + os.open(os.path.join(W, b'own'), os.O_RDWR)"
    assert made(world, code, 0).startswith("got")
    for name in ("user", "capabilities", "kept capabilities", "limit of files"):
        assert made(world, RIGHTS[name], 0) == "", name
    assert made(world, "S(90, P, 0o777)", 0) == "got 0"
    assert world.victim.stat().st_mode & 0o777 == 0o600
    world.close()


@pytest.mark.parametrize("mode", [0o700, 0o750, 0o711])
def test_root_opens_its_own_below_a_folder_of_another_user(mode):
    if os.geteuid() != 0:
        pytest.skip("only root can enter what another closes")
    world = World(0)
    os.chown(world.folder, NOBODY, NOBODY)
    world.folder.chmod(mode)
    code = "len(os.read(os.open(P, os.O_RDONLY), 9)) + os.open(os.path.join(W, b'own'), os.O_RDWR)"
    assert made(world, code, 0).startswith("got")
    # It keeps what opens a folder that is closed to it, and nothing where none is.
    assert bool(made(world, RIGHTS["any capability"], 0)) == (mode != 0o711)
    world.close()


def test_the_attacks_work_where_nothing_contains_them(world, user, monkeypatch):
    """Without the sandbox some of each kind get through, so that the tests above can fail."""
    monkeypatch.setattr(features, "restrict", lambda *_, **__: None)
    before = world.state()
    for name, code in {
        "flags": FILES["flags of a readable file"],
        "attribute": FILES["extended attribute"],
        "a handle": FILES["a handle of a file"],
        "signal": PROCESSES["signal"] if user == 0 else "0",
        "group": NETWORK["group of IPv4"],
        "mode": SILENT["mode"],
        "datagram": SILENT["datagram"],
        "shared memory": RIGHTS["shared memory of another"],
        "memory": RIGHTS["memory that no limit counts"],
    }.items():
        assert made(world, code, user).startswith("got"), name
    after = world.state()
    assert before["status"] != after["status"]
    assert after["got"]
