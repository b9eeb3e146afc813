"""Processes with limits: what counts, and what ends with which message."""

import os
import select
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from tracerisk.common.limits import DEFAULT_LIMITS, Limit, Sandbox
from tracerisk.common.sandbox.kernel.features import support
from tracerisk.common.sandbox.limited_process import OwnTime, run_limited
from tracerisk.config import Settings
from tracerisk.errors import ExitCode, LimitError, Location

CHILD = """\
from tracerisk.common.sandbox.limited_process import end_with, limit_memory, mark_start
import os, signal, sys, time

def main():
    limit_memory()
    {before}
    mark_start()
    {after}
    return 0

end_with(main)
"""
PLACE = Location("arm.xacro")
# A keeper with a process, which forks one that leads its own group; both leave one behind.
FAMILY = """\
import os, signal, sys
from tracerisk.common.sandbox.kernel.features import adopt_orphans

def hold(name, size):
    global held
    held = b"x" * size * 1_000_000
    print(name, os.getpid(), flush=True)

def leave_behind(name, size):
    if os.fork() == 0:
        if os.fork() == 0:
            hold(name, size)
            signal.pause()
        os._exit(0)
    os.wait()

adopt_orphans()
if os.fork() == 0:
    leave_behind("orphan", ORPHAN) if ORPHAN else None
    if os.fork() == 0:
        os.setpgid(0, 0)
        leave_behind("orphan", 40)
        hold("branch", 80)
        signal.pause()
    hold("worker", 10)
    signal.pause()
signal.pause()
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run a child that does something before and after its start mark."""

    monkeypatch.syspath_prepend(tmp_path)

    def run_child(after="pass", before="pass", request=b"", sandbox="auto", **limits):
        (tmp_path / "the_child.py").write_text(CHILD.format(before=before, after=after))
        changed = {
            name: replace(getattr(DEFAULT_LIMITS, name), value=value)
            for name, value in limits.items()
        }
        return run_limited(
            "the_child",
            request=request,
            limits=replace(DEFAULT_LIMITS, sandbox=Sandbox(sandbox), **changed),
            doing="expanding the xacro file",
            place=PLACE,
            reads=[tmp_path],
        )

    return run_child


def test_the_defaults_are_those_of_the_settings():
    assert Settings().limits == DEFAULT_LIMITS


def test_what_a_child_is_asked_and_answers_is_passed_on_whole(run):
    text = b"x" * 1_000_000
    done = run("sys.stdout.write(sys.stdin.read().upper())", request=text)
    assert (done.returncode, done.stdout) == (0, text.upper())


@pytest.mark.parametrize(
    "after",
    # Who waits for a signal sleeps too.
    [
        "while True: pass",
        "time.sleep(1000)",
        pytest.param("signal.pause()", marks=pytest.mark.slow),
    ],
)
def test_a_child_that_computes_or_sleeps_too_long_ends_with_its_limit(run, after):
    with pytest.raises(LimitError) as error:
        run(after, own=0.3)
    assert error.value.exit_code is ExitCode.CONTROLLER_FAILED
    assert error.value.with_code == (
        "arm.xacro: expanding the xacro file took more than 0.3 s of CPU time or sleep; raise "
        "it with --stall-limit or the setting stall_limit_s (now 0.3) [limit]"
    )


@pytest.mark.parametrize(
    ("given", "what", "wall"),
    [
        ({"after": "os.kill(os.getpid(), signal.SIGSTOP)"}, "took more than", 1.0),
        ({"before": "os.kill(os.getpid(), signal.SIGSTOP)"}, "did not start within", 0.3),
    ],
)
def test_a_child_that_is_stopped_uses_no_time_of_its_own_but_wall_time(run, given, what, wall):
    with pytest.raises(LimitError) as error:
        run(**given, own=0.01, wall=wall)
    assert error.value.message == (
        f"expanding the xacro file {what} {wall:g} s of wall time; raise it with --wall-limit or "
        f"the setting wall_limit_s (now {wall:g})"
    )


def test_what_comes_before_the_start_mark_does_not_count(run):
    compute = "while time.process_time() < 0.25: pass"
    assert run(before=compute, own=0.1).returncode == 0
    with pytest.raises(LimitError, match=r"0\.1 s of CPU time"):
        run(
            after="begun = time.process_time()\n    while time.process_time() < begun + 1: pass",
            own=0.1,
        )


def test_a_child_without_memory_ends_with_its_limit(run):
    with pytest.raises(LimitError) as error:
        run("bytearray(600 * 2**20)", memory=2000)
    assert error.value.message == (
        "expanding the xacro file took more than 500 MB of memory, a quarter of a controller's limit; raise it with --memory-limit or the setting memory_limit_mb (now 2000)"
    )
    assert run("bytearray(600 * 2**20)", memory=4000).returncode == 0


def test_processes_of_a_child_that_take_too_much_together_end_with_its_limit(run):
    hoard = "for _ in range(3): os.fork() or (bytearray(b'x' * 200_000_000), signal.pause())"
    with pytest.raises(LimitError, match="took more than 500 MB of memory"):
        run(f"{hoard}\n    signal.pause()", memory=2000)


@pytest.mark.slow(but=1)
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is weighed")
@pytest.mark.parametrize("sandbox", ["off", "auto"])
def test_processes_that_a_child_left_behind_count_too(run, sandbox):
    eat = "held = b'x' * 200_000_000; __import__('time').sleep(600)"
    daemons = f'for _ in 1 2 3; do ({sys.executable} -c "{eat}" &) ; done'
    with pytest.raises(LimitError, match="took more than 500 MB of memory"):
        run(
            f"import subprocess; subprocess.run({daemons!r}, shell=True)\n    time.sleep(600)",
            memory=2000,
            sandbox=sandbox,
        )


@pytest.mark.skipif(bool(support().missing) and os.geteuid() == 0, reason="root may, uncontained")
def test_a_child_cannot_raise_its_limits(run):
    lift = "import resource; resource.setrlimit(resource.RLIMIT_AS, (2**40, 2**40))"
    done = run(lift)
    assert done.returncode == 1
    assert b"not allowed to raise maximum limit" in done.stderr


@pytest.mark.parametrize("name", ["SIGKILL", "SIGXCPU"])
def test_a_child_that_the_system_ends_is_no_bad_file(run, name):
    with pytest.raises(LimitError, match=f"was ended by {name}: the system may be short of memory"):
        run(f"os.kill(os.getpid(), signal.{name})")


def test_a_child_that_fails_by_itself_is_left_to_the_caller(run):
    done = run("sys.exit('no such macro')")
    assert (done.returncode, done.stderr) == (1, b"no such macro\n")
    assert run("os.kill(os.getpid(), signal.SIGSEGV)").returncode == -signal.SIGSEGV


def test_nothing_of_an_ended_child_is_left(run, tmp_path):
    # Whoever lives holds the pipe open for writing.
    os.mkfifo(tmp_path / "alive")
    reader = os.open(tmp_path / "alive", os.O_RDONLY | os.O_NONBLOCK)
    start = f"os.open({str(tmp_path / 'alive')!r}, os.O_WRONLY); os.fork(); signal.pause()"
    with pytest.raises(LimitError):
        run(start, own=0.3, sandbox="off")
    ended, _, _ = select.select([reader], [], [], 60)
    assert ended
    assert os.read(reader, 1) == b""
    os.close(reader)


def test_the_limit_of_a_controllers_processor_time_names_its_option():
    assert Limit("cpu_limit_s", 120.0).advice == (
        "raise it with --cpu-limit or the setting cpu_limit_s (now 120)"
    )


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere it is wall time")
def test_time_in_which_a_process_is_stopped_is_not_its_own():
    with subprocess.Popen([sys.executable, "-c", "while True: pass"]) as child:
        try:
            os.kill(child.pid, signal.SIGSTOP)
            os.waitpid(child.pid, os.WUNTRACED)
            own = OwnTime(child.pid, keeper=os.getpid())
            own.look()
            stopped_s = own.seconds
            for _ in range(100):
                own.look()
            assert own.seconds == stopped_s
            os.kill(child.pid, signal.SIGCONT)
            while own.seconds < stopped_s + 0.2:
                own.look()
            assert own.cpu_s == own.seconds
        finally:
            child.kill()


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is weighed")
@pytest.mark.parametrize("orphan", [0, 20])
def test_a_process_with_limits_of_its_own_is_weighed_apart_with_what_it_leaves_behind(orphan):
    code = FAMILY.replace("ORPHAN", str(orphan))
    started = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    with started as keeper:
        lines = [keeper.stdout.readline().split() for _ in range(4 if orphan else 3)]
        pids = {name: int(pid) for name, pid in lines}
        try:
            branch = OwnTime(pids["branch"], keeper=keeper.pid, leads_group=True)
            run = OwnTime(pids["worker"], keeper=keeper.pid)
            together = OwnTime(pids["worker"], keeper=keeper.pid)
            run.apart = {pids["branch"]}
            for own in (branch, run, together):
                while own.held_bytes == 0 and own.seconds < 0.3:
                    own.look()
            assert 120e6 < branch.held_bytes < 170e6
            # A process by itself the system limits.
            assert (30e6 < run.held_bytes < 80e6) if orphan else run.held_bytes == 0
            assert together.held_bytes > 130e6 + orphan * 1e6
        finally:
            for _, pid in lines:
                os.kill(int(pid), signal.SIGKILL)
            keeper.kill()
