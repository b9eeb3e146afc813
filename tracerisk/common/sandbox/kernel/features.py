"""What the kernel offers to contain a process.

Landlock and seccomp need no privilege; a network and a control group of its own may need one.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import stat
import struct
import sys
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from tracerisk.common.sandbox.kernel.system_calls import is_known_machine, program

_CREATE, _ADD_RULE, _RESTRICT = 444, 445, 446
_ASK_VERSION = 1
_PATH_BENEATH = 1
_SCOPE_ABSTRACT_SOCKETS, _SCOPE_SIGNALS = 1, 2
_SET_DEATH_SIGNAL, _SET_SECCOMP, _SET_NO_NEW_PRIVILEGES, _SET_SUBREAPER = 1, 22, 38, 36
_DROP_FROM_BOUND = 24
_CAPABILITIES_VERSION = 0x20080522
_OPEN_FILES_OF_OTHERS = 1  # CAP_DAC_OVERRIDE
_MOST_CAPABILITIES = 64
_GET_SECCOMP = 21
_FILTER_MODE = 2
_MOST_OF_LINE = 4096


_NEW_USERS, _NEW_NETWORK, _NEW_MOUNTS = 0x10000000, 0x40000000, 0x20000
_RECURSIVE, _PRIVATE = 0x4000, 0x40000  # of a mount
_SHARED_MEMORY = b"/dev/shm"
_APPARMOR_RULE = Path("/proc/sys/kernel/apparmor_restrict_unprivileged_userns")
_SET_FLAGS, _UP = 0x8914, 0x1  # of a network interface
_LOOPBACK_INDEX = 1  # each network begins with this interface
_NEW_ROUTE, _MAKE = 24, 0x401  # a request of rtnetlink
_LOCAL_TABLE, _STATIC, _HOST, _LOCAL = 255, 4, 254, 2
_DESTINATION, _INTERFACE = 1, 4
# All addresses but those of groups: family, first address, bits that count.
_PLACES = (
    (2, bytes([0, 0, 0, 0]), 1),
    (2, bytes([128, 0, 0, 0]), 2),
    (2, bytes([192, 0, 0, 0]), 3),
    *((10, bytes([first]).ljust(16, b"\0"), bits) for first, bits in ((0x20, 3), (0xFC, 7))),
)

# The rights of Landlock on files, as bits.
_EXECUTE, _WRITE, _READ, _LIST = 1, 1 << 1, 1 << 2, 1 << 3
_DEVICES = 1 << 6 | 1 << 11  # to make character and block devices
_REFER, _TRUNCATE, _DEVICE_IOCTL = 1 << 13, 1 << 14, 1 << 15
_OF_FILES = _EXECUTE | _WRITE | _READ | _TRUNCATE | _DEVICE_IOCTL
_SIGNALS_SINCE = 6
_NEWEST = 7


@dataclass(frozen=True, slots=True)
class Support:
    """What of the sandbox works here."""

    landlock: int
    """The version of Landlock; 0 for none."""
    seccomp: bool
    """Whether filters of system calls work on this machine."""

    @property
    def missing(self) -> str:
        """What is missing, in words; empty where all is there."""
        parts = {"Landlock (Linux 5.13 or later, and enabled)": self.landlock > 0,
                 "seccomp filters on x86-64 or ARM64": self.seccomp}  # fmt: skip
        return " and ".join(name for name, is_there in parts.items() if not is_there)


def support() -> Support:
    """Return what of the sandbox works here."""
    if sys.platform != "linux":
        return Support(0, seccomp=False)
    version = _libc().syscall(_CREATE, None, ctypes.c_size_t(0), ctypes.c_uint32(_ASK_VERSION))
    has_filters = is_known_machine() and _libc().prctl(_GET_SECCOMP, 0, 0, 0, 0) in (0, 2)
    return Support(max(0, int(version)), has_filters)


def die_with_parent(signal_number: int) -> None:
    """Send this process a signal when its parent ends."""
    _called(_libc().prctl(_SET_DEATH_SIGNAL, signal_number, 0, 0, 0))


def adopt_orphans() -> None:
    """Make this process the parent of what its descendants leave behind."""
    _called(_libc().prctl(_SET_SUBREAPER, 1, 0, 0, 0))


def stat_fields(folder: str) -> list[bytes]:
    """Return the state of a process or thread, its parent, and what the kernel writes after that.

    `folder` is the one below /proc that stands for it.

    Raises:
        OSError: it is there no more.
    """
    return kernel_line(f"{folder}/stat").rpartition(b")")[2].split()


def kernel_line(path: str) -> bytes:
    """Return what the kernel writes into a short file below /proc, which may be read very often.

    Raises:
        OSError: it is there no more.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        return os.read(descriptor, _MOST_OF_LINE)
    finally:
        os.close(descriptor)


def processes() -> list[int]:
    """Return the numbers of the processes of the machine."""
    names = os.listdir("/proc")  # noqa: PTH208 - looked at often
    return [int(name) for name in names if name.isdecimal()]


def descendants(top: int, but: Collection[int] = ()) -> list[int]:
    """Return the processes that descend from one, sorted; `but` and theirs are left out."""
    children: dict[int, list[int]] = {}
    for pid in processes():
        with contextlib.suppress(OSError, ValueError, IndexError):
            parent = int(stat_fields(f"/proc/{pid}")[1])
            children.setdefault(parent, []).append(pid)
    waiting, pids = [top], []
    while waiting:
        inner = [pid for pid in children.get(waiting.pop(), ()) if pid not in but]
        waiting += inner
        pids += inner
    return sorted(pids)


def keep_signals_in(version: int) -> bool:
    """Restrict signals of this process and its descendants to each other; False if not possible."""
    if version < _SIGNALS_SINCE:
        return False
    _restrict(_ruleset(0, 0, _SCOPE_SIGNALS))
    # Whoever relies on it must know that it holds.
    for outside in (1, os.getppid()):
        try:
            os.kill(outside, 0)
        except PermissionError:
            continue
        except ProcessLookupError:
            continue
        return False
    return True


def leave_network(*, also_memory: bool = False) -> bool:
    """Give this process and those it starts a network that has loopback alone; return whether.

    With `also_memory` they also share memory by name with nobody else.
    False where the kernel or a container does not allow it. To be called while the process has one
    thread. A user who is not root becomes the only one of a namespace of users for it, and gains
    no capability.
    """
    libc = _libc()
    wanted = _NEW_NETWORK | (_NEW_MOUNTS if also_memory else 0)
    if libc.unshare(wanted) == 0:
        return _has_loopback() and (not also_memory or _has_own_memory())
    # There root would no longer open what others own.
    if os.geteuid() == 0 or _stops_half_way():
        return False
    user, group = os.geteuid(), os.getegid()
    if libc.unshare(_NEW_USERS | wanted) != 0:
        return False
    names = {
        "setgroups": "deny",
        "uid_map": f"{user} {user} 1",
        "gid_map": f"{group} {group} 1",
    }
    try:
        for name, text in names.items():
            Path("/proc/self", name).write_text(text, encoding="utf-8")
        return _has_loopback() and (not also_memory or _has_own_memory())
    except OSError:
        return False
    finally:
        _give_up_capabilities(0)


def offers_own_network() -> bool:
    """Return whether `leave_network` works here, as a process of its own finds out."""
    if sys.platform != "linux":
        return False
    child = os.fork()
    if child == 0:
        os._exit(not leave_network())
    return os.waitpid(child, 0)[1] == 0


def _stops_half_way() -> bool:
    """Return whether AppArmor lets users make a namespace and then do nothing in it."""
    with contextlib.suppress(OSError):
        return _APPARMOR_RULE.read_bytes().strip() != b"0"
    return False


def _has_own_memory() -> bool:
    """Put an empty place where memory is shared by name; return whether that is allowed."""
    libc = _libc()
    if not Path(os.fsdecode(_SHARED_MEMORY)).is_dir():
        return True
    if libc.mount(None, b"/", None, _RECURSIVE | _PRIVATE, None) != 0:
        return False
    return bool(libc.mount(b"tmpfs", _SHARED_MEMORY, b"tmpfs", 0, None) == 0)


def _has_loopback() -> bool:
    """Take the loopback interface of a new network up; return whether that is allowed."""
    import _socket
    import fcntl

    with contextlib.ExitStack() as opened:
        try:
            asking = _socket.socket(_socket.AF_INET, _socket.SOCK_DGRAM)
            opened.callback(asking.close)
            telling = _socket.socket(_socket.AF_NETLINK, _socket.SOCK_RAW, 0)
            opened.callback(telling.close)
            fcntl.ioctl(asking, _SET_FLAGS, struct.pack("16sH14x", b"lo", _UP))
            for family, address, bits in _PLACES:
                telling.send(_route_to_loopback(family, address, bits))
        except OSError:  # also where the system has no sockets of one of these kinds
            return False
    return True


def _route_to_loopback(family: int, address: bytes, bits: int) -> bytes:
    """Return the request for a route: what is sent to these addresses, this machine refuses.

    Otherwise the system would say that there is no way to them, as on no machine with a network.
    """
    kind = struct.pack("=BBBBBBBBI", family, bits, 0, 0, _LOCAL_TABLE, _STATIC, _HOST, _LOCAL, 0)
    to = struct.pack("=HH", 4 + len(address), _DESTINATION) + address
    by = struct.pack("=HHI", 8, _INTERFACE, _LOOPBACK_INDEX)
    size = 16 + len(kind) + len(to) + len(by)
    return struct.pack("=IHHII", size, _NEW_ROUTE, _MAKE, 0, 0) + kind + to + by


def restrict(
    readable: Iterable[str],
    listable: Iterable[str],
    writable: Iterable[str],
    *,
    own_network: bool = False,
) -> None:
    """Contain this process and all that it starts, for good.

    It can read and execute what is `readable`, list the folders that are `listable`, and change
    what is below a `writable` one; it has no network but its `own_network`, which `leave_network`
    has given it, and reaches no other process. To be called before there is a second thread.
    Raises OSError where the kernel refuses.

    It keeps no capability, also as root, but for one: where a place belongs to another user, or
    lies in a folder that is closed to root without it, root can still open what Landlock allows.
    """
    version = min(support().landlock, _NEWEST)
    handled = _handled(version)
    ports = 3 if version >= 4 and not own_network else 0
    scope = _SCOPE_ABSTRACT_SOCKETS | _SCOPE_SIGNALS if version >= _SIGNALS_SINCE else 0
    ruleset = _ruleset(handled, ports, scope)
    are_ours = True
    folders: set[str] = set()
    for paths, wanted in (
        (readable, _EXECUTE | _READ | _LIST),
        (listable, _LIST),
        (writable, handled & ~_DEVICES),
        ((os.devnull,), _READ | _WRITE | _TRUNCATE),
    ):
        for path in paths:
            are_ours &= _allow(ruleset, path, wanted & handled)
            folders.add(path.rpartition(os.sep)[0] or os.sep)
    are_ours = are_ours and not any(map(_is_closed, _with_parents(folders)))
    _restrict(ruleset)
    _give_up_capabilities(0 if are_ours else 1 << _OPEN_FILES_OF_OTHERS)
    text = program(landlock=version, process=os.getpid(), own_network=own_network)
    lines = ctypes.create_string_buffer(text, len(text))
    header = struct.pack("HxxxxxxP", len(text) // 8, ctypes.addressof(lines))
    _called(_libc().prctl(_SET_SECCOMP, _FILTER_MODE, ctypes.create_string_buffer(header), 0, 0))


def _handled(version: int) -> int:
    rights = (1 << 13) - 1
    for since, right in ((2, _REFER), (3, _TRUNCATE), (5, _DEVICE_IOCTL)):
        rights |= right if version >= since else 0
    return rights


def _ruleset(files: int, ports: int, scope: int) -> int:
    known = struct.pack("=QQQ", files, ports, scope)
    # An older kernel takes no more than it knows of.
    known = known if scope else known[:16] if ports else known[:8]
    answer = _libc().syscall(
        _CREATE, ctypes.create_string_buffer(known), ctypes.c_size_t(len(known)), ctypes.c_uint32(0)
    )
    return _called(answer)


def _allow(ruleset: int, path: str, rights: int) -> bool:
    """Allow a place; return whether it belongs to the user of this process, or to root."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError, PermissionError):
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
        try:
            status = os.fstat(place)
            if not stat.S_ISDIR(status.st_mode):
                rights &= _OF_FILES
            if rights:
                rule = ctypes.create_string_buffer(struct.pack("=Qi", rights, place))
                _called(
                    _libc().syscall(_ADD_RULE, ruleset, _PATH_BENEATH, rule, ctypes.c_uint32(0))
                )
            return status.st_uid in (0, os.geteuid())
        finally:
            os.close(place)
    return True


def _with_parents(folders: Iterable[str]) -> set[str]:
    """Return folders with those around them, by their names and by where these lead."""
    found: set[str] = set()
    for folder in folders:
        for name in (folder, os.path.realpath(folder)):
            above = name
            while above not in found:
                found.add(above)
                above = above.rpartition(os.sep)[0] or os.sep
    return found


def _is_closed(folder: str) -> bool:
    """Return whether a folder belongs to another user, and not everybody may enter it."""
    with contextlib.suppress(OSError):
        status = os.stat(folder)  # noqa: PTH116 - dozens of them at each start
        return status.st_uid not in (0, os.geteuid()) and not status.st_mode & stat.S_IXOTH
    return False


def _give_up_capabilities(kept: int) -> None:
    """Give up all capabilities but those that are `kept`, as bits, for good."""
    libc = _libc()
    for number in range(_MOST_CAPABILITIES):
        # Without new privileges, the bound matters to programs that only look at it.
        if not kept >> number & 1 and libc.prctl(_DROP_FROM_BOUND, number, 0, 0, 0) < 0:
            break
    header = struct.pack("=Ii", _CAPABILITIES_VERSION, 0)
    had = ctypes.create_string_buffer(24)
    _called(libc.capget(ctypes.create_string_buffer(header), had))
    permitted = struct.unpack("=6I", had.raw)
    kept &= permitted[1]
    left = struct.pack("=6I", kept, kept, 0, 0, 0, 0)
    _called(libc.capset(ctypes.create_string_buffer(header), ctypes.create_string_buffer(left)))


def _restrict(ruleset: int) -> None:
    _called(_libc().prctl(_SET_NO_NEW_PRIVILEGES, 1, 0, 0, 0))
    _called(_libc().syscall(_RESTRICT, ruleset, ctypes.c_uint32(0)))
    os.close(ruleset)


@lru_cache(maxsize=1)
def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _called(answer: int) -> int:
    if answer < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return answer
