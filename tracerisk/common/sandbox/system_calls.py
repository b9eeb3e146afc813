"""The filter of system calls (seccomp) of a contained process, as a program for the kernel.

Landlock decides about files. What it does not know is decided here: the network, other processes,
the machine, and what changes a file without opening it. All else is allowed. A call is answered
as an ordinary failure, so that a program that can live without it does.
"""

from __future__ import annotations

import errno
import platform
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

_ALLOW, _ERRNO, _KILL = 0x7FFF0000, 0x00050000, 0x80000000
_LOAD, _AND, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x54, 0x15, 0x35, 0x06
_NUMBER_AT, _ARCH_AT, _ARGUMENTS_AT = 0, 4, 16
_X32 = 0x40000000

_TCP_FLAG_FASTOPEN = 0x20000000
_INET, _INET6, _UNIX = 2, 10, 1
_STREAM, _DATAGRAM, _PACKETS = 1, 2, 5
_TYPE = 0xF
_NAMESPACES = (0x02000000, 0x04000000, 0x08000000, 0x10000000, 0x20000000, 0x40000000, 0x00020000)
_PUSH_INTO_TERMINAL = (0x5412, 0x541C)
_O_TRUNC, _O_ACCMODE = 0o1000, 0o3
_DONE = 0  # the call is said to have succeeded, and does nothing

Condition = tuple[int, int, int]
"""An argument's number, a mask, and what the lower half of the argument is under that mask."""


@dataclass(frozen=True, slots=True)
class Rule:
    """What becomes of a system call."""

    call: str
    """The name of the call."""
    answer: int | None
    """The errno of the answer, 0 for a success without effect; `None` where the call is allowed."""
    conditions: tuple[Condition, ...] = ()
    """What must all hold of its arguments; empty for every such call."""
    null: int | None = None
    """The number of an argument that must be a null pointer besides; `None` for none."""


# By architecture: its name for the kernel, and the numbers of calls; `None` where it has none.
_MACHINES = {"x86_64": (0xC000003E, 0), "aarch64": (0xC00000B7, 1)}
_NUMBERS: dict[str, tuple[int | None, int | None]] = {
    "accept": (43, 202), "accept4": (288, 242), "acct": (163, 89), "add_key": (248, 217),
    "adjtimex": (159, 171), "bind": (49, 200), "bpf": (321, 280), "chmod": (90, None),
    "chown": (92, None), "chroot": (161, 51), "clock_adjtime": (305, 266),
    "clock_settime": (227, 112), "clone": (56, 220), "clone3": (435, 435), "connect": (42, 203),
    "delete_module": (176, 106), "fanotify_init": (300, 262), "fchmod": (91, 52),
    "fchmodat": (268, 53), "fchmodat2": (452, 452), "fchown": (93, 55), "fchownat": (260, 54),
    "finit_module": (313, 273), "fremovexattr": (199, 16), "fsconfig": (431, 431),
    "fsetxattr": (190, 7), "fsmount": (432, 432), "fsopen": (430, 430), "fspick": (433, 433),
    "futimesat": (261, None), "init_module": (175, 105), "io_uring_enter": (426, 426),
    "io_uring_register": (427, 427), "io_uring_setup": (425, 425), "ioctl": (16, 29),
    "ioperm": (173, None), "iopl": (172, None), "ioprio_set": (251, 30), "kcmp": (312, 272),
    "kexec_file_load": (320, 294), "kexec_load": (246, 104), "keyctl": (250, 219),
    "kill": (62, 129), "lchown": (94, None), "listen": (50, 201), "lremovexattr": (198, 15),
    "lsetxattr": (189, 6), "migrate_pages": (256, 238), "mount": (165, 40),
    "mount_setattr": (442, 442), "move_mount": (429, 429), "move_pages": (279, 239),
    "mq_open": (240, 180), "msgget": (68, 186), "name_to_handle_at": (303, 264),
    "open": (2, None), "open_by_handle_at": (304, 265), "open_tree": (428, 428),
    "openat": (257, 56), "openat2": (437, 437), "perf_event_open": (298, 241),
    "pidfd_getfd": (438, 438), "pidfd_open": (434, 434), "pidfd_send_signal": (424, 424),
    "pivot_root": (155, 41), "prlimit64": (302, 261), "process_madvise": (440, 440),
    "process_mrelease": (448, 448), "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271), "ptrace": (101, 117), "quotactl": (179, 60),
    "quotactl_fd": (443, 443), "reboot": (169, 142), "removexattr": (197, 14),
    "removexattrat": (466, 466), "request_key": (249, 218), "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240), "sched_setaffinity": (203, 122), "sched_setattr": (314, 274),
    "sched_setparam": (142, 118), "sched_setscheduler": (144, 119), "semget": (64, 190),
    "sendmmsg": (307, 269), "sendmsg": (46, 211), "sendto": (44, 206),
    "setdomainname": (171, 162), "sethostname": (170, 161), "setns": (308, 268),
    "setpriority": (141, 140), "settimeofday": (164, 170), "setxattr": (188, 5),
    "setxattrat": (463, 463), "shmget": (29, 194), "socket": (41, 198), "socketpair": (53, 199),
    "swapoff": (168, 225), "swapon": (167, 224), "syslog": (103, 116), "tgkill": (234, 131),
    "tkill": (200, 130), "truncate": (76, 45), "umount2": (166, 39), "unshare": (272, 97),
    "userfaultfd": (323, 282), "utime": (132, None), "utimensat": (280, 88), "utimes": (235, None),
}  # fmt: skip

_REFUSED = (
    *("acct", "add_key", "adjtimex", "bpf", "chroot", "clock_adjtime", "clock_settime"),
    *("delete_module", "fanotify_init", "finit_module", "fsconfig", "fsmount", "fsopen", "fspick"),
    *("init_module", "ioperm", "iopl", "kcmp", "kexec_file_load", "kexec_load", "keyctl"),
    *("migrate_pages", "mount", "mount_setattr", "move_mount", "move_pages", "name_to_handle_at"),
    *("open_by_handle_at", "open_tree", "perf_event_open", "pidfd_getfd", "pidfd_send_signal"),
    *("pivot_root", "process_madvise", "process_mrelease", "process_vm_readv"),
    *("process_vm_writev", "ptrace", "quotactl", "quotactl_fd", "reboot", "request_key"),
    *("rt_sigqueueinfo", "rt_tgsigqueueinfo", "setdomainname", "sethostname", "setns"),
    *("settimeofday", "swapoff", "swapon", "syslog", "umount2", "unshare", "userfaultfd"),
    # What these make outlives the process.
    *("mq_open", "msgget", "semget", "shmget"),
)
# A program that copies a file sets its mode and its times too; nothing of it is kept.
_METADATA = (
    *("chmod", "chown", "fchmod", "fchmodat", "fchmodat2", "fchown", "fchownat", "futimesat"),
    *("lchown", "utime", "utimensat", "utimes"),
    *("ioprio_set", "sched_setattr", "sched_setparam", "sched_setscheduler", "setpriority"),
)
_ATTRIBUTES = (
    *("fremovexattr", "fsetxattr", "lremovexattr", "lsetxattr", "removexattr", "removexattrat"),
    *("setxattr", "setxattrat"),
)
# The C library takes an older call where these are absent, which the filter can look into.
_ABSENT = ("clone3", "openat2", "pidfd_open", "io_uring_enter", "io_uring_register",
           "io_uring_setup")  # fmt: skip


def rules(*, landlock: int, process: int) -> Iterator[Rule]:
    """Yield the rules for a kernel with this version of Landlock; the first that fits decides.

    `process` is the contained process, which may always signal itself.
    """
    yield from (Rule(call, errno.EPERM) for call in _REFUSED)
    yield from (Rule(call, _DONE) for call in _METADATA)
    yield from (Rule(call, errno.ENOTSUP) for call in _ATTRIBUTES)
    yield from (Rule(call, errno.ENOSYS) for call in _ABSENT)
    yield from (
        Rule("clone", errno.EPERM, ((0, namespace, namespace),)) for namespace in _NAMESPACES
    )
    yield from (Rule("ioctl", errno.EPERM, ((1, -1, number),)) for number in _PUSH_INTO_TERMINAL)
    for call in ("prlimit64", "sched_setaffinity"):
        yield from (Rule(call, None, ((0, -1, number),)) for number in (0, process))
        yield Rule(call, errno.EPERM)
    yield from _network()
    if landlock < 6:  # From there on Landlock itself keeps signals within.
        own = (process, 0, -process)
        yield from (Rule("kill", None, ((0, -1, number),)) for number in own)
        yield Rule("tgkill", None, ((0, -1, process),))
        yield Rule("tkill", None, ((0, -1, process),))
        yield from (Rule(call, errno.EPERM) for call in ("kill", "tgkill", "tkill"))
    if landlock < 3:  # From there on Landlock itself knows of truncation.
        yield Rule("truncate", errno.EACCES)
        yield Rule("open", errno.EACCES, ((1, _O_TRUNC | _O_ACCMODE, _O_TRUNC),))
        yield Rule("openat", errno.EACCES, ((2, _O_TRUNC | _O_ACCMODE, _O_TRUNC),))


def _network() -> Iterator[Rule]:
    """Yield the rules by which nothing leaves the process but through pairs of local sockets.

    Sockets of TCP and UDP can be made, as on a machine on which nobody answers: `connect` is
    refused, and what is sent without it is lost. `sendmsg` names its receiver in memory, which a
    filter cannot read.
    """
    for family in (_INET, _INET6):
        for kind, protocol in ((_STREAM, 6), (_DATAGRAM, 17)):
            for named in (0, protocol):
                asked = ((0, -1, family), (1, _TYPE, kind), (2, -1, named))
                yield Rule("socket", None, asked)
    yield Rule("socket", errno.EACCES)
    for kind in (_STREAM, _PACKETS):
        yield Rule("socketpair", None, ((0, -1, _UNIX), (1, _TYPE, kind)))
    yield Rule("socketpair", errno.EACCES)
    yield Rule("connect", errno.ECONNREFUSED)
    yield Rule("sendto", errno.EACCES, ((3, _TCP_FLAG_FASTOPEN, _TCP_FLAG_FASTOPEN),))
    yield Rule("sendto", None, null=4)
    yield Rule("sendto", _DONE)
    others = ("accept", "accept4", "bind", "listen", "sendmmsg", "sendmsg")
    yield from (Rule(call, errno.EACCES) for call in others)


def is_known_machine() -> bool:
    """Return whether there is a filter for this machine's processor."""
    return platform.machine() in _MACHINES and struct.calcsize("P") == 8


def program(found: Iterable[Rule], machine: str | None = None) -> bytes:
    """Return the rules as a program: instructions of 8 bytes, `struct sock_filter`.

    Raises KeyError for a machine that `is_known_machine` does not know.
    """
    name, column = _MACHINES[machine or platform.machine()]
    lines = [
        (_LOAD, 0, 0, _ARCH_AT),
        (_EQUAL, 1, 0, name),
        (_RETURN, 0, 0, _KILL),
        (_LOAD, 0, 0, _NUMBER_AT),
        (_AT_LEAST, 0, 1, _X32),
        (_RETURN, 0, 0, _KILL),
    ]
    for rule in found:
        number = _NUMBERS[rule.call][column]
        if number is not None:
            lines += _instructions(rule, number)
    lines.append((_RETURN, 0, 0, _ALLOW))
    return b"".join(struct.pack("=HBBI", *line) for line in lines)


def _instructions(rule: Rule, number: int) -> Sequence[tuple[int, int, int, int]]:
    tests = [(_ARGUMENTS_AT + 8 * at, mask, value) for at, mask, value in rule.conditions]
    if rule.null is not None:
        low = _ARGUMENTS_AT + 8 * rule.null
        tests += [(low, -1, 0), (low + 4, -1, 0)]
    answer = _ALLOW if rule.answer is None else _ERRNO | rule.answer
    # Each test takes three instructions; one that fails goes on behind the answer.
    left = 3 * len(tests) + 1
    # What was loaded for a test is not a number of a call any more.
    after = 1 if tests else 0
    lines = [(_EQUAL, 0, left + after, number)]
    for at, mask, value in tests:
        left -= 3
        lines += [
            (_LOAD, 0, 0, at),
            (_AND, 0, 0, mask & 0xFFFFFFFF),
            (_EQUAL, 0, left, value & 0xFFFFFFFF),
        ]
    lines.append((_RETURN, 0, 0, answer))
    if after:
        lines.append((_LOAD, 0, 0, _NUMBER_AT))
    return lines
