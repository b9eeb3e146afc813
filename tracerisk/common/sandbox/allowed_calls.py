"""The system calls that a contained process may make, each with the reason; all others are refused.

By architecture: x86-64 and ARM64, `None` where it lacks the call. The numbers are those of Linux
(`asm/unistd_64.h`, `asm-generic/unistd.h`), which never change. A newer kernel opens nothing: its
calls are not in this table.
"""

from __future__ import annotations

import errno
from collections.abc import Mapping
from dataclasses import dataclass

Numbers = Mapping[str, tuple[int | None, int | None]]
"""Calls with their numbers on x86-64 and ARM64."""


@dataclass(frozen=True, slots=True)
class Calls:
    """System calls that are treated alike."""

    reason: str
    """What a controller needs them for, or how the refusal reads to it."""
    numbers: Numbers
    """The calls."""
    answer: int = 0
    """The errno in place of a call that is not made; 0 for a success without effect."""


ALLOWED = (
    Calls(
        "reads, writes and closes what is open",
        {
            "close": (3, 57), "close_range": (436, 436), "copy_file_range": (326, 285),
            "dup": (32, 23), "dup2": (33, None), "dup3": (292, 24), "fadvise64": (221, 223),
            "fallocate": (285, 47), "fdatasync": (75, 83), "flock": (73, 32), "fsync": (74, 82),
            "ftruncate": (77, 46), "lseek": (8, 62), "pread64": (17, 67), "preadv": (295, 69),
            "preadv2": (327, 286), "pwrite64": (18, 68), "pwritev": (296, 70),
            "pwritev2": (328, 287), "read": (0, 63), "readahead": (187, 213), "readv": (19, 65),
            "sendfile": (40, 71), "splice": (275, 76), "sync_file_range": (277, 84),
            "write": (1, 64), "writev": (20, 66),
        },
    ),
    Calls(
        "opens, makes, names and removes files; Landlock decides which",
        {
            "access": (21, None), "creat": (85, None), "faccessat": (269, 48),
            "faccessat2": (439, 439), "link": (86, None), "linkat": (265, 37), "mkdir": (83, None),
            "mkdirat": (258, 34), "mknod": (133, None), "mknodat": (259, 33), "rename": (82, None),
            "renameat": (264, 38), "renameat2": (316, 276), "rmdir": (84, None),
            "symlink": (88, None), "symlinkat": (266, 36), "umask": (95, 166), "unlink": (87, None),
            "unlinkat": (263, 35),
        },
    ),
    Calls(
        "looks at names and sizes of files, and at folders that Landlock lets it open",
        {
            "chdir": (80, 49), "fchdir": (81, 50), "fgetxattr": (193, 10), "flistxattr": (196, 13),
            "fstat": (5, 80), "fstatfs": (138, 44), "getcwd": (79, 17), "getdents": (78, None),
            "getdents64": (217, 61), "getxattr": (191, 8), "inotify_add_watch": (254, 27),
            "inotify_init": (253, None), "inotify_init1": (294, 26), "inotify_rm_watch": (255, 28),
            "lgetxattr": (192, 9), "listxattr": (194, 11), "llistxattr": (195, 12),
            "lstat": (6, None), "newfstatat": (262, 79), "readlink": (89, None),
            "readlinkat": (267, 78), "stat": (4, None), "statfs": (137, 43), "statx": (332, 291),
        },
    ),
    Calls(
        "waits for what is open: loops of events, pipes between threads",
        {
            "epoll_create": (213, None), "epoll_create1": (291, 20), "epoll_ctl": (233, 21),
            "epoll_pwait": (281, 22), "epoll_pwait2": (441, 441), "epoll_wait": (232, None),
            "eventfd": (284, None), "eventfd2": (290, 19), "pipe": (22, None), "pipe2": (293, 59),
            "poll": (7, None), "ppoll": (271, 73), "pselect6": (270, 72), "select": (23, None),
            "signalfd": (282, None), "signalfd4": (289, 74), "timerfd_create": (283, 85),
            "timerfd_gettime": (287, 87), "timerfd_settime": (286, 86),
        },
    ),
    Calls(
        "uses its own memory, within the limit",
        {
            "brk": (12, 214), "get_mempolicy": (239, 236), "madvise": (28, 233),
            "mbind": (237, 235), "membarrier": (324, 283), "mincore": (27, 232),
            "mlock": (149, 228), "mlock2": (325, 284), "mlockall": (151, 230), "mmap": (9, 222),
            "mprotect": (10, 226), "mremap": (25, 216), "msync": (26, 227), "munlock": (150, 229),
            "munlockall": (152, 231), "munmap": (11, 215), "pkey_alloc": (330, 289),
            "pkey_free": (331, 290), "pkey_mprotect": (329, 288), "set_mempolicy": (238, 237),
        },
    ),
    Calls(
        "reads clocks, sleeps, sets timers of its own",
        {
            "alarm": (37, None), "clock_getres": (229, 114), "clock_gettime": (228, 113),
            "clock_nanosleep": (230, 115), "getitimer": (36, 102), "gettimeofday": (96, 169),
            "nanosleep": (35, 101), "pause": (34, None), "setitimer": (38, 103),
            "time": (201, None), "timer_create": (222, 107), "timer_delete": (226, 111),
            "timer_getoverrun": (225, 109), "timer_gettime": (224, 108),
            "timer_settime": (223, 110), "times": (100, 153),
        },
    ),
    Calls(
        "handles signals",
        {
            "restart_syscall": (219, 128), "rt_sigaction": (13, 134), "rt_sigpending": (127, 136),
            "rt_sigprocmask": (14, 135), "rt_sigreturn": (15, 139), "rt_sigsuspend": (130, 133),
            "rt_sigtimedwait": (128, 137), "sigaltstack": (131, 132),
        },
    ),
    Calls(
        "starts and awaits processes and threads, which are contained too",
        {
            "arch_prctl": (158, None), "execve": (59, 221), "execveat": (322, 281),
            "exit": (60, 93), "exit_group": (231, 94), "fork": (57, None), "futex": (202, 98),
            "futex_waitv": (449, 449), "rseq": (334, 293), "set_robust_list": (273, 99),
            "set_tid_address": (218, 96), "setpgid": (109, 154), "setsid": (112, 157),
            "vfork": (58, None), "wait4": (61, 260), "waitid": (247, 95),
        },
    ),
    Calls(
        "asks about itself, its processes and the machine",
        {
            "capget": (125, 90), "getcpu": (309, 168), "getegid": (108, 177), "geteuid": (107, 175),
            "getgid": (104, 176), "getgroups": (115, 158), "getpgid": (121, 155),
            "getpgrp": (111, None), "getpid": (39, 172), "getppid": (110, 173),
            "getpriority": (140, 141), "getrandom": (318, 278), "getresgid": (120, 150),
            "getresuid": (118, 148), "getrlimit": (97, 163), "getrusage": (98, 165),
            "getsid": (124, 156), "gettid": (186, 178), "getuid": (102, 174),
            "ioprio_get": (252, 31), "sched_get_priority_max": (146, 125),
            "sched_get_priority_min": (147, 126), "sched_getaffinity": (204, 123),
            "sched_getattr": (315, 275), "sched_getparam": (143, 121),
            "sched_getscheduler": (145, 120), "sched_rr_get_interval": (148, 127),
            "sched_yield": (24, 124), "sysinfo": (99, 179), "uname": (63, 160),
        },
    ),
    Calls(
        "uses pairs of local sockets",
        {
            "getpeername": (52, 205), "getsockname": (51, 204), "getsockopt": (55, 209),
            "recvfrom": (45, 207), "recvmmsg": (299, 243), "recvmsg": (47, 212),
            "shutdown": (48, 210),
        },
    ),
    Calls(
        "gives up rights and lowers limits; none can be regained",
        {
            "capset": (126, 91), "landlock_add_rule": (445, 445),
            "landlock_create_ruleset": (444, 444), "landlock_restrict_self": (446, 446),
            "setrlimit": (160, 164),
        },
    ),
)  # fmt: skip
"""What a process may call with any arguments."""

CHECKED = (
    Calls(
        "starts processes and threads; no namespace",
        {"clone": (56, 220)},
        errno.EPERM,
    ),
    Calls(
        "makes sockets of TCP and UDP, and pairs of local ones",
        {"socket": (41, 198), "socketpair": (53, 199)},
        errno.EOPNOTSUPP,  # of all errors the one with which ZeroMQ goes on
    ),
    Calls(
        "sends to the other end of a pair, and within a network of its own to any address; else a"
        " datagram to an address is lost",
        {"sendto": (44, 206)},
    ),
    Calls(
        "reaches what listens in a network of its own; else is answered as by a machine that does"
        " not listen",
        {"connect": (42, 203)},
        errno.ECONNREFUSED,
    ),
    Calls(
        "listens and sends in a network of its own; else is answered as a user who may not",
        {
            "accept": (43, 202), "accept4": (288, 242), "bind": (49, 200), "listen": (50, 201),
            "sendmmsg": (307, 269), "sendmsg": (46, 211),
        },
        errno.EACCES,
    ),
    Calls(
        "sets times and buffers of sockets; joins no group, binds to no device",
        {"setsockopt": (54, 208)},
        errno.ENOPROTOOPT,
    ),
    Calls(
        "asks terminals and network cards, and changes none",
        {"ioctl": (16, 29)},
        errno.ENOTTY,
    ),
    Calls(
        "copies descriptors, locks files; sends no signal, takes no lease",
        {"fcntl": (72, 25)},
        errno.EINVAL,
    ),
    Calls(
        "names threads, asks about itself, gives up rights",
        {"prctl": (157, 167)},
        errno.EINVAL,
    ),
    Calls(
        "asks for the kind of process",
        {"personality": (135, 92)},
        errno.EPERM,
    ),
    Calls(
        "limits and places itself, no other process",
        {"prlimit64": (302, 261), "sched_setaffinity": (203, 122)},
        errno.EPERM,
    ),
    Calls(
        "signals itself, and where Landlock keeps signals in, what it has started",
        {"kill": (62, 129), "tgkill": (234, 131), "tkill": (200, 130)},
        errno.EPERM,
    ),
    Calls(
        "opens and cuts files that Landlock lets it write",
        {"open": (2, None), "openat": (257, 56), "truncate": (76, 45)},
        errno.EACCES,
    ),
)  # fmt: skip
"""What it may call with those arguments that `system_calls.checks` lists."""

ANSWERED = (
    Calls(
        "as if it had succeeded; a program that copies a file sets its mode and times too",
        {
            "chmod": (90, None), "chown": (92, None), "fchmod": (91, 52), "fchmodat": (268, 53),
            "fchown": (93, 55), "fchownat": (260, 54), "futimesat": (261, None),
            "lchown": (94, None), "utime": (132, None), "utimensat": (280, 88),
            "utimes": (235, None),
        },
    ),
    Calls(
        "as if it had succeeded; nothing of it is kept",
        {
            "ioprio_set": (251, 30), "sched_setattr": (314, 274), "sched_setparam": (142, 118),
            "sched_setscheduler": (144, 119), "setpriority": (141, 140), "sync": (162, 81),
            "syncfs": (306, 267),
        },
    ),
    Calls(
        "as by a file system without such attributes",
        {
            "fremovexattr": (199, 16), "fsetxattr": (190, 7), "lremovexattr": (198, 15),
            "lsetxattr": (189, 6), "removexattr": (197, 14), "setxattr": (188, 5),
        },
        errno.ENOTSUP,
    ),
    Calls(
        "as by an older kernel; it holds memory that no limit counts",
        {"memfd_create": (319, 279)},
        errno.ENOSYS,
    ),
)  # fmt: skip
"""What is not made, and answered so that programs go on."""
