"""Start tracerisk, or a program, on this machine as if it were Windows or macOS.

    python other_system.py windows check cell.py
    python other_system.py macos -c 'print(__import__("sys").platform)'

What the system's Python lacks is gone: modules, names of `os`, `signal`, `socket`, `select` and
`time`, as typeshed has them under `sys.platform`. What Windows does otherwise, it does here too:
a folder cannot be opened, a file that is open cannot be renamed, replaced or deleted, a text file
gets CR LF, and `os.kill` ends a process whatever the number. Paths stay those of this machine.
"""

from __future__ import annotations

import asyncio  # noqa: F401 - these modules ask for the system once, when they are imported
import builtins
import concurrent.futures.process  # noqa: F401
import ctypes.util
import errno
import fcntl
import importlib.abc
import io
import multiprocessing.popen_spawn_posix  # noqa: F401
import os
import platform
import runpy
import shutil
import signal
import socket
import socketserver  # noqa: F401
import ssl  # noqa: F401
import stat
import subprocess
import sys
import sysconfig
import tempfile
import types
import urllib.request  # noqa: F401
import webbrowser  # noqa: F401
from pathlib import Path
from typing import Any

NOT_ON_WINDOWS = {
    "os": """
        O_ACCMODE O_ASYNC O_CLOEXEC O_DIRECT O_DIRECTORY O_DSYNC O_NDELAY O_NOATIME O_NOCTTY
        O_NOFOLLOW O_NONBLOCK O_PATH O_RSYNC O_SYNC O_TMPFILE P_ALL P_PGID P_PID P_PIDFD WEXITED
        WEXITSTATUS WIFEXITED WIFSIGNALED WIFSTOPPED WNOHANG WNOWAIT WSTOPSIG WTERMSIG WUNTRACED
        chown chroot confstr copy_file_range ctermid environb eventfd fchdir fchmod fchown fdatasync
        fork forkpty fpathconf fstatvfs fwalk get_blocking getegid getenvb geteuid getgid
        getgrouplist getgroups getloadavg getpgid getpgrp getpriority getrandom getresgid getresuid
        getsid getuid getxattr initgroups killpg lchown listxattr lockf makedev memfd_create mkfifo
        mknod nice openpty pathconf pidfd_open pipe2 posix_fadvise posix_fallocate posix_spawn
        posix_spawnp pread preadv pwrite pwritev readv register_at_fork removexattr
        sched_getaffinity sched_setaffinity sched_yield sendfile set_blocking setegid seteuid setgid
        setgroups setpgid setpgrp setpriority setresuid setreuid setsid setuid setxattr splice
        statvfs sync sysconf tcgetpgrp tcsetpgrp ttyname uname wait wait3 wait4 waitid writev
        """,
    "signal": """
        ITIMER_PROF ITIMER_REAL ITIMER_VIRTUAL ItimerError SIGALRM SIGBUS SIGCHLD SIGCONT SIGHUP
        SIGKILL SIGPIPE SIGPROF SIGQUIT SIGSTOP SIGTSTP SIGTTIN SIGTTOU SIGUSR1 SIGUSR2 SIGVTALRM
        SIGWINCH SIGXCPU SIGXFSZ SIG_BLOCK SIG_SETMASK SIG_UNBLOCK alarm getitimer pause
        pidfd_send_signal pthread_kill pthread_sigmask setitimer siginterrupt sigpending sigwait
        """,
    "socket": "AF_UNIX CMSG_LEN MSG_DONTWAIT SCM_RIGHTS SO_PEERCRED SO_REUSEPORT recv_fds send_fds",
    "select": "POLLERR POLLHUP POLLIN POLLOUT epoll poll",
    "time": "CLOCK_MONOTONIC CLOCK_PROCESS_CPUTIME_ID CLOCK_REALTIME clock_getres clock_gettime "
    "clock_gettime_ns tzset",
}
NOT_ON_MACOS = {
    "os": """
        O_PATH O_TMPFILE P_PIDFD copy_file_range eventfd fdatasync getrandom getresgid getresuid
        getxattr memfd_create pidfd_open pipe2 posix_fadvise posix_fallocate sched_getaffinity
        sched_setaffinity setresuid setxattr splice waitid
        """,
    "signal": "SIGPOLL SIGPWR SIGRTMAX SIGRTMIN pidfd_send_signal sigtimedwait sigwaitinfo",
    "socket": "AF_NETLINK AF_PACKET SO_BINDTODEVICE SO_PEERCRED SOCK_CLOEXEC",
    "select": "POLLRDHUP epoll",
    "time": "CLOCK_BOOTTIME",
}
MODULES = "crypt fcntl grp nis ossaudiodev posix pty pwd readline resource spwd syslog termios tty"
"""Those that Windows has not; macOS has them all that tracerisk may need."""

_real_open, _real_os_open, _real_socketpair = io.open, os.open, socket.socketpair


class _Absent(importlib.abc.MetaPathFinder):
    """Finds none of the modules that only Unix has."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> None:
        if name in MODULES.split():
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def become(system: str) -> None:
    """Make this process as one of a system is: `windows`, or `macos`."""
    missing = NOT_ON_WINDOWS if system == "windows" else NOT_ON_MACOS
    for module, names in missing.items():
        for name in names.split():
            vars(sys.modules[module]).pop(name, None)
    # The standard library has asked for these when it was imported.
    tempfile._O_TMPFILE_WORKS = False  # type: ignore[attr-defined]
    shutil._USE_CP_SENDFILE = False  # type: ignore[attr-defined]
    sysconfig.get_config_vars()
    platform.uname.__globals__["_uname_cache"] = None
    if system == "macos":
        sys.platform = "darwin"
        return
    for name in MODULES.split():
        sys.modules.pop(name, None)
    sys.meta_path.insert(0, _Absent())
    sys.modules["msvcrt"] = _msvcrt()
    socket.socketpair = _socketpair  # type: ignore[assignment]
    ctypes.WinDLL = _NoFunctions  # type: ignore[attr-defined]
    shutil._use_fd_functions = False  # type: ignore[attr-defined]
    shutil.which = _which  # there programs have endings, and here none
    sys.platform = "win32"
    _open_files_stay()
    _text_has_crlf()


def _socketpair(
    family: int = socket.AF_UNIX, kind: int = socket.SOCK_STREAM, number: int = 0
) -> tuple[socket.socket, socket.socket]:
    """A pair of connected sockets; which ones they are by default is the system's affair."""
    return _real_socketpair(family, kind, number)


def _which(name: str, mode: int = os.X_OK, path: str | None = None) -> str | None:
    """The first program of a name in the folders of a path."""
    folders = (os.environ["PATH"] if path is None else path).split(os.pathsep)
    files = (str(Path(folder, name)) for folder in folders)
    return next((file for file in files if os.access(file, mode)), None)


class _NoFunctions:
    """A library of Windows, without what is in it."""

    def __init__(self, *_: object, **__: object) -> None:
        pass


def _msvcrt() -> types.ModuleType:
    """The module by which Windows locks bytes of a file, on the lock that this system has."""
    module = types.ModuleType("msvcrt")
    module.LK_LOCK, module.LK_NBLCK, module.LK_UNLCK = 1, 2, 0  # type: ignore[attr-defined]

    def locking(descriptor: int, mode: int, count: int) -> None:
        how = fcntl.LOCK_UN if mode == 0 else fcntl.LOCK_EX | fcntl.LOCK_NB
        try:
            fcntl.flock(descriptor, how)
        except BlockingIOError:
            raise PermissionError(errno.EACCES, "Permission denied") from None

    module.locking = locking  # type: ignore[attr-defined]
    return module


def _open_files_stay() -> None:
    """Refuse what Windows refuses."""

    def os_open(path: Any, *args: Any, **more: Any) -> int:
        descriptor = _real_os_open(path, *args, **more)
        if stat.S_ISDIR(os.fstat(descriptor).st_mode):
            os.close(descriptor)
            raise PermissionError(errno.EACCES, "Permission denied", str(path))
        return descriptor

    def guarded(real: Any) -> Any:
        def wrapped(*paths: Any, **more: Any) -> Any:
            for path in paths:
                if _is_open(path):
                    raise PermissionError(
                        errno.EACCES, "the file is used by another process", str(path)
                    )
            return real(*paths, **more)

        return wrapped

    def rename(before: Any, after: Any, **more: Any) -> None:
        if Path(after).exists():
            raise FileExistsError(errno.EEXIST, "the file exists", str(after))
        guarded(real_rename)(before, after, **more)

    def kill(process: int, number: int) -> None:
        assert number == signal.SIGTERM, f"os.kill({process}, {number}) would end the process"
        real_kill(process, number)

    def popen(self: Any, *args: Any, **more: Any) -> None:
        for name in ("preexec_fn", "pass_fds"):
            if more.get(name):
                raise ValueError(f"{name} is not supported on Windows platforms")
        real_popen(self, *args, **more)

    real_rename, real_kill, real_popen = os.rename, os.kill, subprocess.Popen.__init__
    os.open, os.kill = os_open, kill  # type: ignore[assignment]
    os.replace, os.unlink, os.remove = map(guarded, (os.replace, os.unlink, os.remove))
    os.rename = rename  # type: ignore[assignment]
    subprocess.Popen.__init__ = popen  # type: ignore[method-assign,assignment]


def _is_open(path: Any) -> bool:
    """Whether this process has the file at a path open."""
    try:
        wanted = os.lstat(path)
    except (OSError, ValueError, TypeError):
        return False
    if not stat.S_ISREG(wanted.st_mode):
        return False
    for entry in Path("/proc/self/fd").iterdir():
        try:
            seen = os.fstat(int(entry.name))
        except OSError:
            continue
        if (seen.st_dev, seen.st_ino) == (wanted.st_dev, wanted.st_ino):
            return True
    return False


def _text_has_crlf() -> None:
    def opened(file: Any, mode: str = "r", *args: Any, **more: Any) -> Any:
        is_written = "b" not in mode and set(mode) & set("wax+")
        if is_written and len(args) < 4 and more.get("newline") is None:
            more["newline"] = "\r\n"
        return _real_open(file, mode, *args, **more)

    io.open = builtins.open = opened  # type: ignore[assignment]


def main() -> None:
    """Run `tracerisk` with the arguments that follow the system's name, or a program after -c."""
    system, *arguments = sys.argv[1:]
    sys.argv[:] = ["tracerisk", *arguments]
    sys.path[0] = str(Path.cwd())  # as `python -m` has it
    become(system)
    if arguments[:1] == ["-c"]:
        exec(arguments[1], {"__name__": "__main__"})
        return
    runpy.run_module("tracerisk", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
