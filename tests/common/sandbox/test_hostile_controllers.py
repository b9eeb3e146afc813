"""Hostile controllers: things to try, times ways to try them; none gets out of its run."""

import contextlib
import os
import socket
import sys
import tempfile
from pathlib import Path

import pytest

from tracerisk.api import trace_controller
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.config import Settings
from tracerisk.pipeline.workspace.controller import load_controller

pytestmark = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")

# Each thing to try is a statement about what lies outside; `say` sends what was found out.
READS = {
    "a key in the home": "{home}/.ssh/id_ed25519",
    "a token in the home": "{home}/.netrc",
    "a file of the home": "{home}/notes.txt",
    "git's settings": "{root}/.git/config",
    "secrets beside the source": "{root}/.env",
    "a key beside the source": "{root}/robot.pem",
    "a key in a folder": "{root}/certs/robot.pem",
    "secrets in a folder of a folder": "{root}/sub/deep/.env",
    "git's settings of a submodule": "{root}/sub/.git/config",
    "a link to the home": "{root}/link.txt",
    "another project": "{outside}/secret.txt",
    "the parent's environment": "/proc/{parent}/environ",
    "the parent's memory map": "/proc/{parent}/maps",
    "the own environment as a file": "/proc/self/environ",
    "passwords of the system": "/etc/shadow",
}
WRITES = {
    "the own source": "{root}/cell.py",
    "a module beside it": "{root}/other.py",
    "git's hooks": "{root}/.git/hooks/post-commit",
    "the lock": "{root}/tracerisk.lock",
    "a start-up file": "{home}/.bashrc",
    "another project": "{outside}/secret.txt",
    "a new file elsewhere": "{outside}/new",
    "the interpreter": "{prefix}/pwned.pth",
    "our own package": "{package}/pwned.py",
    "shared memory": "/dev/shm/tracerisk-pwned-{parent}",
}
# Ways to read a path P, each leaves bytes in DATA.
READ_WAYS = {
    "open": "DATA = open(P, 'rb').read()",
    "os.open": "DATA = os.read(os.open(P, os.O_RDONLY), 99)",
    "C library": "f = C.open(P.encode(), 0); b = ctypes.create_string_buffer(99);"
    " n = C.read(f, b, 99); DATA = b.raw[:max(n, 0)]",
    "program": "DATA = subprocess.run(['cat', P], capture_output=True).stdout",
    "link": "L = os.path.join(tempfile.gettempdir(), 'l'); C.symlink(P.encode(), L.encode());"
    " DATA = subprocess.run(['cat', L], capture_output=True).stdout",
    "hard link": "L = os.path.join(tempfile.gettempdir(), 'h'); C.link(P.encode(), L.encode());"
    " DATA = open(L, 'rb').read()",
}
WRITE_WAYS = {
    "open": "open(P, 'a').write('pwned')",
    "os.open": "os.write(os.open(P, os.O_WRONLY | os.O_CREAT | os.O_APPEND), b'pwned')",
    "C library": "f = C.open(P.encode(), 0o2101, 0o644); C.write(f, b'pwned', 5)",
    "shell": "os.system(f\"echo pwned >>'{P}'\")",
    "program": "subprocess.run(['tee', P], input=b'pwned', capture_output=True)",
    "move": "L = os.path.join(tempfile.gettempdir(), 'm'); C.close(C.open(L.encode(), 0o2101, 420));"
    " C.rename(L.encode(), P.encode())",
    "truncate": "C.truncate(P.encode(), 0)",
    "mode": "C.chmod(P.encode(), 0o777); C.unlink(P.encode())",
}
OTHERS = {
    "tcp": "socket.create_connection(('127.0.0.1', PORT), 2).sendall(b'pwned')",
    "tcp by a program": "subprocess.run([sys.executable, '-c', f\"import socket;"
    " socket.create_connection(('127.0.0.1', {PORT})).sendall(b'pwned')\"])",
    "tcp with its first packet": "s = socket.socket(); s.sendto(b'pwned', 0x20000000,"
    " ('127.0.0.1', PORT))",
    "udp": "socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b'pwned', ('127.0.0.1', PORT))",
    "udp by sendmsg": "socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendmsg([b'pwned'], [], 0,"
    " ('127.0.0.1', PORT))",
    "local stream": "s = socket.socket(socket.AF_UNIX); s.connect(UNIX); s.sendall(b'pwned')",
    "local datagram": "a, b = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM);"
    " a.sendmsg([b'pwned'], [], 0, UNIX)",
    "abstract": "s = socket.socket(socket.AF_UNIX); s.connect('\\0tracerisk-test'); s.send(b'pwned')",
    "netlink": "socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0); say('reached netlink')",
    "its own server at the port of another": "s = socket.create_server(('127.0.0.1', PORT));"
    " socket.create_connection(('127.0.0.1', PORT), 2).sendall(b'pwned')",
    "every port of loopback": "for port in (*range(PORT - 50, PORT + 50), 22, 631, 5432, 11311):\n"
    "    s = socket.socket(); s.connect_ex(('127.0.0.1', port)) or say('reached a port')",
    "IPv6": "socket.create_connection(('::ffff:127.0.0.1', PORT), 2).sendall(b'pwned')",
    "socket of a pair by name": "a, b = socket.socketpair(); a.connect(UNIX); a.sendall(b'pwned')",
    "io_uring": "r = C.syscall(425, 8, ctypes.create_string_buffer(120));"
    " r >= 0 and say('reached io_uring')",
    "kill the parent": "os.kill(PARENT, 0); say('reached the parent')",
    "kill all": "C.kill(-1, 0) == 0 and open('/dev/null') and None; os.kill(1, 0);"
    " say('reached init')",
    "ptrace": "C.ptrace(16, PARENT, 0, 0) == 0 and say('reached by ptrace')",
    "memory": "os.open(f'/proc/{PARENT}/mem', os.O_RDWR); say('reached memory')",
    "limits": "import resource; resource.prlimit(PARENT, resource.RLIMIT_NOFILE);"
    " say('reached limits')",
    "mount": "C.mount(b'none', b'/mnt', b'tmpfs', 0, 0) == 0 and say('reached mount')",
    "namespace": "C.unshare(0x10000000) == 0 and say('reached a namespace')",
    "chroot": "os.chroot(tempfile.gettempdir()); say('reached chroot')",
    "keyring": "C.syscall(250, 0, -3, 1) >= 0 and say('reached keyring')",
    "shared memory": "C.shmget(4242, 4096, 0o1666) >= 0 and say('reached shared memory')",
    "queue": "C.msgget(4243, 0o1666) >= 0 and say('reached a queue')",
    "terminal": "import fcntl; fcntl.ioctl(2, 0x5412, b'x'); say('reached the terminal')",
    "device": "os.open('/dev/tty', os.O_RDWR); say('reached a device')",
    "daemon": "subprocess.Popen(['sleep', MARK], start_new_session=True, env={})",
    "daemon of a daemon": "subprocess.Popen(['sh', '-c', f'setsid sh -c \"setsid sleep {MARK} &\" &'],"
    " env={})",
    "forks": "subprocess.Popen(['sh', '-c', f'for i in $(seq 200); do (sleep {MARK} &); done'], env={})",
    "fork in C": "C.fork() == 0 and (C.setsid(), C.execlp(b'sleep', b'sleep', MARK.encode(), None))",
    "thread": "import threading; threading.Thread(target=lambda: os.system("
    "f\"echo pwned >>'{OUTSIDE}'\")).start()",
    "environment": "say(str([k for k in os.environ if 'TOKEN' in k])) if any('TOKEN' in k for k in"
    " os.environ) else None",
    "environment of a program": "t = subprocess.run(['env'], capture_output=True, text=True).stdout;"
    " 'TOKEN' in t and say(t)",
    "file by its handle": "b = ctypes.create_string_buffer(b'\x50\0\0\0', 99); i = ctypes.c_int();"
    " C.syscall(303, -100, HOME.encode(), b, ctypes.byref(i), 0) == 0 and say('got a handle')",
    "process descriptor": "C.syscall(434, PARENT, 0) >= 0 and say('got a descriptor of the parent')",
    "memory by vectors": "b = ctypes.create_string_buffer(8);"
    " v = (ctypes.c_void_p * 2)(ctypes.addressof(b), 8);"
    " C.syscall(310, PARENT, v, 1, (ctypes.c_void_p * 2)(0x400000, 8), 1, 0) != -1"
    " and say('read memory of the parent')",
    "performance events": "a = ctypes.create_string_buffer(b'\1\0\0\0\x70', 112);"
    " C.syscall(298, a, 0, -1, -1, 0) >= 0 and say('got performance events')",
    "program in the kernel": "C.syscall(321, 0, ctypes.create_string_buffer(bytes([1, 0, 0, 0, 4,"
    " 0, 0, 0, 4, 0, 0, 0, 1]), 128), 128) >= 0 and say('made a map in the kernel')",
    "page faults": "C.syscall(323, 1) >= 0 and say('handles page faults')",
    "log of the kernel": "b = ctypes.create_string_buffer(99);"
    " C.syscall(103, 3, b, 99) > 0 and say('read the log of the kernel')",
    "packets": "socket.socket(17, socket.SOCK_RAW, 0x300); say('hears packets')",
    "raw": "socket.socket(socket.AF_INET, socket.SOCK_RAW, 1); say('sends raw packets')",
    "cryptography of the kernel": "socket.socket(38, 5, 0); say('reached the kernel by AF_ALG')",
    "virtual machines": "socket.socket(40, socket.SOCK_STREAM); say('reached by AF_VSOCK')",
    "watched files": "C.syscall(300, 0, 0) >= 0 and say('watches all files')",
    "mount by descriptor": "C.syscall(430, b'tmpfs', 0) >= 0 and say('made a file system')",
    "copy of the tree": "C.syscall(428, -100, b'/', 1) >= 0 and say('copied the tree')",
    "namespace of the parent": "os.open(f'/proc/{PARENT}/ns/net', 0); say('opened a namespace')",
    "root of the parent": "open(f'/proc/{PARENT}/root{HOME}/notes.txt'); say('through its root')",
    "inherited descriptors": "for d in range(3, 99):\n"
    "    try: data = os.pread(d, 9999, 0)\n"
    "    except OSError: continue\n"
    "    b'SECRET' in data and say('read a descriptor')",
    "queue by name": "C.syscall(240, b'pwned', 0o102, 0o600, None) >= 0 and say('made a queue')",
    "pages of the parent": "C.syscall(279, PARENT, 0, None, None, None, 0) == 0 and say('asked')",
    "descriptors compared": "C.syscall(312, PARENT, os.getpid(), 0, 0, 0) >= 0 and say('compared')",
    "signal by a descriptor": "import fcntl; a, b = os.pipe(); fcntl.fcntl(a, fcntl.F_SETOWN, PARENT);"
    " say('owned by the parent')",
    "name of the machine": "b = ctypes.create_string_buffer(65); C.gethostname(b, 65);"
    " C.sethostname(b.value, len(b.value)) == 0 and say('named the machine')",
    "clock": "import time; time.clock_settime(time.CLOCK_REALTIME, time.clock_gettime("
    "time.CLOCK_REALTIME)); say('set the clock')",
    "place of the parent": "os.sched_setaffinity(PARENT, os.sched_getaffinity(PARENT));"
    " say('placed the parent')",
    "list the home": "C.opendir.restype = ctypes.c_void_p; C.opendir(HOME.encode())"
    " and say('reached the home')",
}

CONTROLLER = """\
import ctypes, os, socket, subprocess, sys, tempfile
import rospy, moveit_commander
PARENT, PORT, UNIX, MARK, HOME, OUTSIDE = {parent}, {port}, {unix!r}, {mark!r}, {home!r}, {outside!r}
C = ctypes.CDLL(None)
def say(text):
    print('FOUND ' + text, flush=True)
def main():
    rospy.init_node("cell")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    joints = arm.get_current_joint_values()
    joints[0] += 0.02
    arm.go(joints, wait=True)
    for name, code in {attempts!r}:
        P, DATA = None, b""
        space = dict(globals())
        try:
            exec(code, space)
        except BaseException as error:
            pass
        if space.get("DATA"):
            say(name + " " + repr(space["DATA"]))
    arm.go(joints, wait=True)
if __name__ == "__main__":
    main()
"""


class World:
    """A home, a project and another one, with secrets; and servers that wait to be spoken to."""

    def __init__(self, folder: Path) -> None:
        self.home, self.root, self.outside = (folder / n for n in ("home", "home/work", "outside"))
        for each in (self.home / ".ssh", self.root / ".git" / "hooks", self.outside):
            each.mkdir(parents=True)
        for path in (
            *(self.home / name for name in (".ssh/id_ed25519", ".netrc", "notes.txt", ".bashrc")),
            *(self.root / name for name in (".git/config", ".env", "robot.pem")),
            self.outside / "secret.txt",
        ):
            path.write_text("SECRET\n")
        for name in ("certs/robot.pem", "sub/deep/.env", "sub/.git/config"):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text("SECRET\n")
        (self.root / "link.txt").symlink_to(self.home / "notes.txt")
        (self.root / "other.py").write_text("SPEED = 1\n")
        self.mark = f"77{os.getpid()}"
        self.tcp, self.udp = socket.socket(), socket.socket(type=socket.SOCK_DGRAM)
        self.unix, self.datagram = socket.socket(socket.AF_UNIX), None
        self.tcp.bind(("127.0.0.1", 0))
        self.udp.bind(self.tcp.getsockname())
        self.unix_path = str(folder / "u")
        self.unix.bind(self.unix_path)
        self.tcp.listen()
        self.unix.listen()
        self.servers = (self.tcp, self.udp, self.unix)

    def state(self) -> dict[str, tuple[bytes, int]]:
        folders = (self.home, self.outside)
        return {
            str(path): (path.read_bytes(), path.stat().st_mode)
            for folder in folders
            for path in sorted(folder.rglob("*"))
            if path.is_file()
        }

    def reached(self) -> list[str]:
        found = []
        for each in self.servers:
            each.settimeout(0)
            with contextlib.suppress(BlockingIOError):
                found.append(str(each.recv(9) if each.type == socket.SOCK_DGRAM else each.accept()))
        return found

    def left_running(self) -> list[str]:
        found = []
        for each in Path("/proc").glob("[0-9]*"):
            try:
                words = (each / "cmdline").read_bytes().split(b"\0")
            except OSError:
                continue
            if self.mark.encode() in words and b"sleep" in words[0]:
                found.append(each.name)
        return found

    def close(self) -> None:
        for each in self.servers:
            each.close()


@pytest.fixture
def world(tmp_path, monkeypatch):
    found = World(tmp_path)
    monkeypatch.setenv("HOME", str(found.home))
    monkeypatch.setenv("SECRET_TOKEN", "SECRET")
    monkeypatch.chdir(found.root)
    (tmp_path / "tmp").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    monkeypatch.setattr(tempfile, "tempdir", None)
    yield found
    found.close()


def attempts(world: World, paths: dict[str, str], ways: dict[str, str]) -> list[tuple[str, str]]:
    import tracerisk

    places = {
        "home": world.home,
        "root": world.root,
        "outside": world.outside,
        "parent": os.getpid(),
        "prefix": sys.prefix,
        "package": Path(tracerisk.__file__).parent,
    }
    return [
        (f"{what} by {way}", f"P = {path.format(**places)!r}; {code}")
        for what, path in paths.items()
        for way, code in ways.items()
    ]


def run(world: World, tried, capfd, **options) -> str:
    text = CONTROLLER.format(
        parent=os.getpid(),
        port=world.tcp.getsockname()[1],
        unix=world.unix_path,
        mark=world.mark,
        home=str(world.home),
        outside=str(world.outside / "new"),
        attempts=list(tried),
    )
    (world.root / "cell.py").write_text(text)
    controller = load_controller(world.root / "cell.py")
    trace = trace_controller(controller, Settings(**options))
    assert trace.visits, trace.end
    return "\n".join(
        line for line in capfd.readouterr().err.splitlines() if line.startswith("FOUND")
    )


def test_nothing_outside_is_read(world, capfd):
    tried = attempts(world, READS, READ_WAYS)
    assert len(tried) >= 60
    assert run(world, tried, capfd, sandbox="require") == ""


def test_nothing_outside_is_changed(world, capfd):
    tried = attempts(world, WRITES, WRITE_WAYS)
    assert len(tried) >= 70
    (world.root / "cell.py").write_text("")
    before = world.state()
    run(world, tried, capfd, sandbox="require")
    after = world.state()
    ours = str(world.root / "cell.py")
    assert b"attempt" not in before.pop(ours)[0]
    assert b"moveit_commander" in after.pop(ours)[0]
    assert after == before
    for path in WRITES.values():
        assert "pwned" not in path or not list(Path(sys.prefix).glob("pwned*"))
    assert not list(Path("/dev/shm").glob("tracerisk-pwned*"))


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("part", range(4))
def test_nobody_outside_is_reached(world, capfd, part):
    reaches_nobody(world, capfd, list(OTHERS)[part::4])


@pytest.mark.slow
@pytest.mark.parametrize("name", OTHERS)
def test_nobody_outside_is_reached_by_one_attempt_alone(world, capfd, name):
    reaches_nobody(world, capfd, [name])


def reaches_nobody(world, capfd, names):
    assert run(world, [(name, OTHERS[name]) for name in names], capfd, sandbox="require") == ""
    assert world.reached() == []
    assert world.left_running() == []
    assert not (world.outside / "new").exists()
    assert list(Path(tempfile.gettempdir()).iterdir()) == []


def test_the_attempts_work_where_nothing_contains_them(world, capfd):
    """Without the sandbox most of it gets through, so that the tests above can fail."""
    tried = attempts(world, {k: READS[k] for k in ("a token in the home", "another project")},
                     READ_WAYS)  # fmt: skip
    found = run(world, tried, capfd, sandbox="off").splitlines()
    assert len(found) == len(tried)
    tried = attempts(world, {"another project": WRITES["another project"]}, WRITE_WAYS)
    for each in tried:
        (world.outside / "secret.txt").write_text("SECRET\n")
        before = world.state()
        run(world, [each], capfd, sandbox="off")
        after = world.state()
        before.pop(str(world.root / "cell.py"), None)
        after.pop(str(world.root / "cell.py"))
        assert after != before, each
        break
    run(world, [("tcp", OTHERS["tcp"]), ("udp", OTHERS["udp"])], capfd, sandbox="off")
    assert len(world.reached()) == 2


def test_no_process_is_left_without_a_sandbox_either(world, capfd):
    names = ("daemon", "daemon of a daemon", "fork in C")
    run(world, [(name, OTHERS[name]) for name in names], capfd, sandbox="off")
    assert world.left_running() == []
