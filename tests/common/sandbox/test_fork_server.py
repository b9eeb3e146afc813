"""A process that a server forks is as one that is started afresh, and leaves as little behind."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.api import load_controller, trace_controller
from tracerisk.common import trace_json
from tracerisk.common.limits import Sandbox
from tracerisk.common.sandbox import fork_server, process
from tracerisk.common.sandbox.fork_server import Forked
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.config import Settings

pytestmark = pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="needs Linux")
contained = pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")

# It imports what the module of a run imports of these.
MODULE = """\
import atexit, ctypes, gc, inspect, io, json, os, random, resource, signal, socket, subprocess, sys
import threading, time
from tracerisk.common.sandbox import process

def seen(is_contained):
    files, status = {}, []
    if not is_contained:
        folder = "/proc/self/fd/"
        files = {n: os.readlink(folder + n).split(":")[0] for n in os.listdir(folder)
            if os.path.exists(folder + n)}
        names = ("Umask", "Groups", "SigBlk", "SigIgn", "SigCgt", "Threads", "Cpus_allowed_list")
        lines = open("/proc/self/status").read().splitlines()
        status = [line for line in lines if line.split(":")[0] in names]
    return {
        "modules": sorted(sys.modules), "path": sys.path, "argv": sys.argv[1:],
        "original": sys.orig_argv[:4] + sys.orig_argv[5:], "flags": list(sys.flags),
        "environment": list(os.environ.items()), "files": files, "status": status,
        "cwd": os.getcwd(), "limits": [resource.getrlimit(n) for n in range(16)],
        "main": sys.modules["__main__"].__dict__ is globals(), "spec": __spec__.name,
        "priority": os.getpriority(0, 0), "depth": len(inspect.stack(0)),
        "most": sys.getrecursionlimit(), "gc": [gc.isenabled(), gc.get_threshold()],
        "streams": [[s.encoding, s.errors, s.line_buffering, s.write_through, s.isatty(),
            s.seekable(), type(s.buffer).__name__, s.fileno()]
            for s in (sys.stdin, sys.stdout, sys.stderr)],
        "is_leader": os.getsid(0) == os.getppid(), "group": os.getpgid(0) == os.getppid(),
        "threads": [t.name for t in threading.enumerate()],
    }

if __name__ == "__main__":
    exec(sys.argv[1])
    sys.exit(0)
"""


@pytest.fixture
def server():
    """Have a server from the first process on; it is gone afterwards."""
    kept = fork_server._KEPT
    kept.close()
    kept.is_wanted, before = True, kept.is_wanted
    yield kept
    kept.close()
    kept.is_wanted, kept.key = before, None


@pytest.fixture
def begin(tmp_path, monkeypatch, server):
    """Start a small module that does what it is told; afresh where that is asked for."""
    (tmp_path / "probe").mkdir()
    (tmp_path / "probe" / "probe_of_a_fork.py").write_text(MODULE)
    (tmp_path / "probe" / "another.py").write_text("print('another')\n")
    monkeypatch.syspath_prepend(str(tmp_path / "probe"))
    monkeypatch.chdir(tmp_path)

    def begin(
        code: str,
        *,
        module="probe_of_a_fork",
        afresh=False,
        mode="off",
        own="x",
        pass_fds=(),
        **environment,
    ):
        with monkeypatch.context() as patched:
            if afresh:
                patched.setattr(process, "forked", lambda *_, **__: None)
            child = process.start(
                module,
                code,
                "more",
                sandbox=Sandbox(mode),
                reads=[tmp_path],
                writes=[tmp_path],
                environment={"PATH": os.environ["PATH"], "OWN": own, **environment},
                options=("-u",),
                is_repeated=True,
                pass_fds=pass_fds,
                **process.OF_FORKED,
            )
        assert isinstance(child, Forked) is not afresh
        return child

    return begin


def said(child) -> str:
    out = child.stdout.read().decode()
    child.stdout.close()
    assert child.wait(60) == 0, out
    return out


def is_there(number: int) -> bool:
    try:
        state = Path(f"/proc/{number}/stat").read_bytes().rpartition(b")")[2].split()[0]
    except OSError:
        return False
    return state != b"Z"


def all_gone(numbers, within_s: float = 20.0) -> bool:
    until = time.monotonic() + within_s
    while any(map(is_there, numbers)) and time.monotonic() < until:
        time.sleep(0.02)
    return not any(map(is_there, numbers))


@pytest.mark.parametrize("mode", ["off", pytest.param("require", marks=contained)])
def test_a_forked_process_sees_what_a_fresh_one_sees(begin, mode):
    reading, writing = os.pipe()
    code = f"os.write(int(os.environ['FD']), json.dumps(seen({mode != 'off'})).encode())"
    reported = []
    for afresh in (True, False, False):
        child = begin(code, afresh=afresh, mode=mode, pass_fds=(writing,), FD=str(writing))
        assert said(child) == ""
        reported.append(json.loads(os.read(reading, 1_000_000)))
    os.close(reading)
    os.close(writing)
    for name, value in reported[0].items():
        assert reported[1][name] == reported[2][name] == value, name
    assert reported[0]["is_leader"]
    assert mode != "off" or str(writing) in reported[0]["files"]


# What a process does, the code with which it ends, and the last line that it has written.
ENDS = {
    "its end": ("pass", 0, []),
    "a code": ("sys.exit(3)", 3, []),
    "a message": ("sys.exit('no')", 1, ["no"]),
    "a sudden code": ("os._exit(4)", 4, []),
    "an exception": ("raise ValueError('no')", 1, ["ValueError: no"]),
    "a signal": ("os.kill(os.getpid(), signal.SIGKILL)", -9, []),
    "a fault": ("signal.signal(11, signal.SIG_DFL); os.kill(os.getpid(), 11)", -11, []),
    "a closed pipe": ("signal.signal(13, signal.SIG_DFL); os.kill(os.getpid(), 13)", -13, []),
    "processor time": (
        "resource.setrlimit(resource.RLIMIT_CPU, (1, 1))\nwhile True: pass",
        -signal.SIGKILL,
        [],
    ),
    "memory": (
        "resource.setrlimit(resource.RLIMIT_AS, (2**30,) * 2); bytes(2**31)",
        1,
        ["MemoryError"],
    ),
    "a child left": (
        "subprocess.Popen(['sleep', '60'], start_new_session=True); print('x')",
        0,
        ["x"],
    ),
    "a call at exit": ("atexit.register(print, 'late'); print('x')", 0, ["late"]),
    "a thread": (
        "threading.Thread(target=lambda: [time.sleep(0.1), print('late')]).start(); print('x')",
        0,
        ["late"],
    ),
    "a text that C holds": ("ctypes.CDLL(None).printf(b'held\\n')", 0, ["held"]),
    "a fork that ends otherwise": (
        "child = os.fork()\nif not child: sys.exit(5)\nprint(os.waitpid(child, 0)[1] >> 8)",
        0,
        ["5"],
    ),
}
LIKE_OTHERS = {"a code", "a fault", "an exception", "processor time"}
"""Ends that differ from another in the number or the text alone."""


@pytest.mark.parametrize("afresh", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.parametrize("how", slow_but(set(ENDS) - LIKE_OTHERS, list(ENDS)))
def test_it_ends_as_any_process(begin, how, afresh):
    code, expected, last = ENDS[how]
    child = begin(code, afresh=afresh)
    output = child.stdout.read().decode()
    child.stdout.close()
    assert (child.wait(60), output.splitlines()[-1:]) == (expected, last)
    assert child.poll() == child.wait() == child.returncode


def test_what_differs_belongs_to_each_alone(begin, server, tmp_path, monkeypatch):
    code = (
        "print(os.environ['OWN'], os.environ.get('A'), os.environ.get('B'), os.getcwd(), "
        "oct(os.umask(0)), resource.getrlimit(resource.RLIMIT_NOFILE)[0]); "
        "os.environ.clear(); os.chdir('/'); resource.setrlimit(resource.RLIMIT_AS, (2**32,) * 2)"
    )
    usual = resource.getrlimit(resource.RLIMIT_NOFILE)
    umask = os.umask(0o022)
    other = tmp_path / "other"
    other.mkdir()
    try:
        first = said(begin(code, own="1", A="1"))
        assert first.split()[:5] == ["1", "1", "None", str(tmp_path), "0o22"]
        number = server.server._process.pid
        assert said(begin(code, own="2", B="2")).split()[:3] == ["2", "None", "2"]
        assert server.server._process.pid == number
        monkeypatch.chdir(other)
        os.umask(0o077)
        resource.setrlimit(resource.RLIMIT_NOFILE, (200, usual[1]))
        assert said(begin(code, own="3")).split()[3:] == [str(other), "0o77", "200"]
    finally:
        os.umask(umask)
        resource.setrlimit(resource.RLIMIT_NOFILE, usual)


def test_the_first_of_a_kind_is_started_afresh(begin, server):
    server.is_wanted = False
    assert said(begin("print(1)", afresh=True)) == "1\n"
    with pytest.raises(AssertionError):
        begin("pass")
    assert server.server is None
    assert said(begin("print(1)")) == "1\n"
    assert server.server is not None


def test_another_module_has_another_server(begin):
    assert said(begin("print('this')")) == "this\n"
    assert said(begin("pass", module="another")) == "another\n"
    assert said(begin("print('this')")) == "this\n"


def test_what_is_read_once_has_another_server(begin, server):
    code = "import locale; print(locale.setlocale(locale.LC_CTYPE, ''), os.environ.get('LC_ALL'))"
    numbers = set()
    for language in ("C", None, "C"):
        given = {} if language is None else {"LC_ALL": language}
        assert said(begin(code, **given)) == said(begin(code, afresh=True, **given))
        numbers.add(server.server._process.pid)
    assert len(numbers) == 3


def test_forked_processes_draw_other_random_numbers(begin):
    assert said(begin("print(random.random())")) != said(begin("print(random.random())"))


def test_several_run_at_once(begin, tmp_path):
    first = begin(
        "print(sys.stdin.read(), 'first')\n"
        "while not os.path.exists('go'): time.sleep(0.01)\n"
        "print('over')"
    )
    assert said(begin("print('second')")) == "second\n"
    assert first.poll() is None
    (tmp_path / "go").touch()
    assert said(first) == " first\nover\n"


LASTING = (
    "p = subprocess.Popen(['sleep', '99'], start_new_session=True); print(os.getpid(), p.pid); "
    "time.sleep(99)"
)


def test_a_process_is_ended_with_all_that_it_started(begin):
    child = begin(LASTING)
    numbers = [child.pid, *map(int, child.stdout.readline().split())]
    with pytest.raises(subprocess.TimeoutExpired):
        child.wait(0.05)
    process.end(child)
    child.stdout.close()
    assert child.returncode == 128 + signal.SIGTERM
    assert all_gone(numbers, 0.0)


def test_after_the_server_was_killed_the_next_is_started(begin, server):
    assert said(begin("print('x')")) == "x\n"
    first = server.server._process.pid
    os.kill(first, signal.SIGKILL)
    assert all_gone([first])
    assert said(begin("print('x')")) == "x\n"
    assert server.server._process.pid != first


def test_where_a_server_cannot_fork_a_process_is_started_afresh(begin, server, monkeypatch):
    def fails(*_, **__):
        raise ConnectionError("gone")

    monkeypatch.setattr(fork_server._Server, "fork", fails)
    with pytest.raises(AssertionError):
        begin("pass")
    assert server.server is None


def test_a_server_that_dies_takes_its_processes_along(begin, server):
    child = begin(LASTING)
    numbers = [child.pid, *map(int, child.stdout.readline().split())]
    os.kill(server.server._process.pid, signal.SIGKILL)
    assert child.wait(20) == -signal.SIGKILL
    child.stdout.close()
    assert all_gone(numbers)


OWNER = """\
import os, signal, sys, time
signal.signal(signal.SIGINT, signal.default_int_handler)
sys.path[:0] = [{package!r}, {folder!r}]
from tracerisk.common.sandbox import fork_server, process
from tracerisk.common.limits import Sandbox
fork_server.several_come()
child = process.start("probe_of_a_fork", {code!r}, sandbox=Sandbox({mode!r}), options=("-u",),
    environment=dict(os.environ), is_repeated=True, **process.OF_FORKED)
print(fork_server._KEPT.server._process.pid, child.pid, child.stdout.readline().decode().strip(),
    flush=True)
{then}
"""


@pytest.mark.parametrize(
    ("how", "mode"),
    [
        (signal.SIGKILL, "off"),
        pytest.param(signal.SIGINT, "require", marks=contained),
        (None, "off"),
        pytest.param(signal.SIGKILL, "require", marks=[contained, pytest.mark.slow]),
        pytest.param(signal.SIGINT, "off", marks=pytest.mark.slow),
        pytest.param(None, "require", marks=[contained, pytest.mark.slow]),
    ],
)
def test_nothing_outlives_the_owner(begin, tmp_path, mode, how):
    text = OWNER.format(
        package=str(Path(process.__file__).parents[3]),
        folder=str(tmp_path / "probe"),
        code=LASTING,
        mode=mode,
        then="os._exit(0)" if how is None else "time.sleep(60)",
    )
    owner = subprocess.Popen(
        [sys.executable, "-c", text], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    numbers = list(map(int, owner.stdout.readline().split()))
    assert len(numbers) == 4
    if how is not None:
        assert all(map(is_there, numbers))
        owner.send_signal(how)
    owner.wait(30)
    owner.stdout.close()
    assert all_gone(numbers)


REACHES = {
    "a signal": "os.kill(SERVER, 0)",
    "all signals": "ctypes.CDLL(None).kill(-1, 19); 1 / 0",
    "its files": "os.listdir(f'/proc/{SERVER}/fd')",
    "its memory": "open(f'/proc/{SERVER}/mem', 'rb')",
    "its environment": "open(f'/proc/{SERVER}/environ', 'rb').read()",
    "ptrace": "ctypes.CDLL(None).ptrace(16, SERVER, 0, 0) and 1 / 0",
    "a pidfd": "signal.pidfd_send_signal(os.pidfd_open(SERVER), 0)",
    "limits": "resource.prlimit(SERVER, resource.RLIMIT_NOFILE)",
}


@contained
@pytest.mark.parametrize(
    "tried",
    [
        pytest.param([*REACHES], id="all"),
        *(pytest.param([each], id=each, marks=pytest.mark.slow) for each in REACHES),
    ],
)
def test_a_contained_process_does_not_reach_the_server(begin, server, tried):
    assert said(begin("pass", mode="require")) == ""
    number = server.server._process.pid
    code = f"SERVER = {number}\nassert os.getppid() != SERVER\n"
    for what in tried:
        code += f"""
try:
    {REACHES[what]}
except (OSError, ZeroDivisionError):
    pass
else:
    print('reached by {what}')
"""
    assert said(begin(code, mode="require")) == ""
    assert server.server._process.pid == number
    assert Path(f"/proc/{number}/stat").read_text().split()[2] in "RS"


CELL = """\
import os, signal, subprocess, sys, time
import rospy, moveit_commander

def main():
    rospy.init_node("cell")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    joints = arm.get_current_joint_values()
    joints[0] += 0.02
    arm.go(joints, wait=True)
    {code}
    arm.go([0.0] * 7, wait=True)

if __name__ == "__main__":
    main()
"""
SEES = "print(len(sys.modules), sys.path, sorted(os.listdir(os.getcwd())))"
RUNS = {
    "well": (SEES, {}),
    "exits": ("sys.exit(3)", {}),
    "is killed": ("os.kill(os.getpid(), signal.SIGKILL)", {}),
    "recurses": (f"{SEES}; f = lambda n: print(n) or f(n + 1); f(0)", {}),
    "hangs": ("while True: pass", {"cpu_limit_s": 1.0}),
    "takes memory": ("x = bytearray(3 << 30)", {"memory_limit_mb": 2048}),
}
QUICK_RUNS = (("well", "auto"),)
"""What every test run looks at; how else a process ends, `ENDS` has in little."""


def shown_afresh_and_forked(monkeypatch, capfd, settings) -> list[tuple[str, str]]:
    """The trace of `cell.py` and what it printed, of a fresh process and of a forked one."""
    controller, found = load_controller(Path("cell.py")), []
    for afresh in (True, False):
        given = []

        def forked(*arguments, afresh=afresh, given=given, **more):
            given.append(None if afresh else fork_server.forked(*arguments, **more))
            return given[-1]

        with monkeypatch.context() as patched:
            patched.setattr(process, "forked", forked)
            trace = trace_controller(controller, settings)
        assert [each is None for each in given] == [afresh]
        found.append((trace_json.dumps(trace), capfd.readouterr().err))
    return found


@pytest.mark.parametrize(
    ("name", "mode"),
    [
        each if each in QUICK_RUNS else pytest.param(*each, marks=pytest.mark.slow)
        for each in [*((name, "auto") for name in RUNS), ("well", "off"), ("is killed", "off")]
    ],
)
def test_a_run_shows_the_same(tmp_path, monkeypatch, capfd, name, mode):
    code, options = RUNS[name]
    monkeypatch.chdir(tmp_path)
    Path("cell.py").write_text(CELL.format(code=code))
    settings = Settings(sandbox=mode, **options)
    afresh, forked = shown_afresh_and_forked(monkeypatch, capfd, settings)
    assert forked == afresh


NODE = "import sys, rclpy\nprint(sorted(sys.modules))\n"


@pytest.mark.slow  # that it does is shown above; a run of ROS 2 differs in what is imported
def test_a_run_of_ros_2_shows_the_same(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path("cell.py").write_text(NODE)
    afresh, forked = shown_afresh_and_forked(monkeypatch, capfd, Settings())
    assert forked == afresh
    assert "'rosbags.typesys'" in forked[1]
    assert "ros1_noetic" not in forked[1]


def test_what_a_module_prepares_a_server_does_once(begin, tmp_path):
    module = tmp_path / "probe" / "probe_of_a_fork.py"
    prepare = "def prepare():\n    os.environ['HAS'] = os.environ.get('HAS', '') + 'x'\n\n"
    module.write_text(MODULE.replace("if __name__", prepare + "if __name__"))
    for _ in range(2):
        assert said(begin("print(os.environ['HAS'])")) == "x\n"
