"""Controllers that fail, hang, die or ask for what is not there: one clear message each, the
documented exit code, the trace so far, and no byte of the folder changed."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.common.sandbox.kernel.features import support

HELD = "1 act (line 9, 1 visit): panda_joint1"
"""What the trace so far tells of the quick controller, once it has moved."""


def line_of(source: str, text: str) -> int:
    """The line on which a text stands first."""
    return source[: source.index(text)].count("\n") + 1


def assert_untouched(example, before) -> None:
    assert example.files() == before, "neither source nor lock nor anything else is written"


FAILURES = {
    "raises": (['raise RuntimeError("tube lost")'], "raised RuntimeError: tube lost"),
    "exits at once": (["os._exit(3)"], "called os._exit(3)"),
    "exits with a text": (['sys.exit("no part")'], "exited with the message: no part"),
    "recurses without end": (["def again(): again()", "again()"], "raised RecursionError"),
    "forks": (["os.fork()"], "a traced controller runs in one process"),
    "interrupts itself": (["raise KeyboardInterrupt"], "raised KeyboardInterrupt"),
    "closes its streams and raises": (
        ["sys.stdout.close()", "sys.stderr.close()", "1 / 0"],
        "raised ZeroDivisionError: division by zero",
    ),
    "names an unknown target": (
        ['arm.set_named_target("nowhere")'],
        "no named target 'nowhere'; allowed: extended, ready, transport",
    ),
    "ignores no pose out of reach": (
        [
            "pose = Pose()",
            "pose.position.x = 5.0",
            "pose.orientation.w = 1.0",
            "arm.set_pose_target(pose)",
            'if not arm.go(): raise RuntimeError("out of reach")',
        ],
        "raised RuntimeError: out of reach",
    ),
}


ALIKE = (
    "raises",
    "interrupts itself",
    "names an unknown target",
    "ignores no pose out of reach",
)
"""Failures that others show as well: exceptions of every kind, an unknown group, and a pose that
the controller handles."""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    "name", slow_but([each for each in FAILURES if each not in ALIKE], [*FAILURES])
)
def test_a_failure_of_the_controller_makes_its_run_faulted_with_place_and_blocks(
    name, example, quick
):
    statements, message = FAILURES[name]
    path = example.write("controller.py", quick(*statements))
    outcome = example.run("run", path.name)
    assert outcome.code == 1
    assert outcome.out.startswith("faulted: ")
    text = next(line for line in outcome.out.splitlines() if message in line)
    annotated = example.read("controller.py").decode()
    assert f"controller.py:{line_of(annotated, statements[-1])}, in act" in text
    assert "RiskAnnotation" in annotated
    assert b'"kind": "faulted"' in example.read("tracerisk.lock")
    assert "/tracerisk/" not in outcome.err, "a traceback shows the controller's frames alone"


def test_a_wait_that_nothing_can_end_is_stuck_and_writes_nothing(example, quick):
    source = quick('rospy.wait_for_service("/nobody")')
    path = example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", path.name, "--no-draft")
    assert outcome.code == 4
    (reported,) = (line for line in outcome.err.splitlines() if line.startswith("tracerisk: "))
    assert reported.startswith(f"tracerisk: controller.py:{line_of(source, 'wait_for_service')}: ")
    assert "waits for service /nobody, which nothing provides" in reported
    assert "verdict: stuck" in outcome.err
    assert HELD in outcome.err
    assert "No source was changed." in outcome.err
    assert_untouched(example, before)


def test_of_a_run_that_ended_badly_no_report_is_written_and_an_earlier_one_is_reported(
    example, quick
):
    example.write("controller.py", quick("os.kill(os.getpid(), 9)"))
    outcome = example.run("run", "controller.py", "--report", "run.html")
    assert outcome.code == 4
    assert outcome.err.endswith("run.html: no report is written of a run that ended badly\n")
    assert "run.html" not in example.files()
    example.write("run.html", b"earlier")
    outcome = example.run("run", "controller.py", "--report", "run.html")
    assert outcome.err.endswith("ended badly; the file is an earlier one\n")
    assert example.read("run.html") == b"earlier"


DEATHS = {
    "kills itself": (["os.kill(os.getpid(), 9)"], "ended by SIGKILL"),
    "gets a signal without a name": (["os.kill(os.getpid(), 40)"], "ended by signal 40"),
    "reads a null pointer": (["import ctypes", "ctypes.string_at(0)"], "ended by SIGSEGV"),
    "leaves through libc": (["import ctypes", "ctypes.CDLL(None)._exit(7)"], "ended with code 7"),
}


# That it kills itself is reported where it reads a null pointer: both are signals.
@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "name", slow_but(["reads a null pointer", "leaves through libc"], [*DEATHS])
)
def test_a_sudden_death_leaves_the_trace_and_the_place_of_the_last_command(name, example, quick):
    statements, message = DEATHS[name]
    source = quick(*statements)
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py", "--no-draft")
    assert outcome.code == 4
    place = f"controller.py:{line_of(source, 'arm.go(joints')}"
    assert f"tracerisk: {place}: the controller's process" in outcome.err
    assert message in outcome.err
    assert HELD in outcome.err
    assert_untouched(example, before)


def test_an_endless_loop_is_stopped_and_its_line_is_reported(example, quick):
    source = quick("for _ in iter(int, 1): pass")
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py", "--stall-limit", "1")
    assert outcome.code == 4
    assert f"tracerisk: controller.py:{line_of(source, 'for _ in')}: " in outcome.err
    assert "nothing has moved" in outcome.err
    assert "1 s of computing or sleeping" in outcome.err
    assert HELD in outcome.err
    assert_untouched(example, before)


LOOPS = {
    "busy": "while not rospy.is_shutdown(): pass",
    "with a rate": "rate = rospy.Rate(10)\n    while not rospy.is_shutdown(): rate.sleep()",
}


# The one with a rate, `test_run_ends.py` has.
@pytest.mark.parametrize("name", slow_but(["busy"], [*LOOPS]))
def test_a_loop_in_which_nothing_was_ever_commanded_is_a_failure(name, example, quick):
    source = quick().replace("    act(arm)\n", f"    {LOOPS[name]}\n")
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py", "--duration", "3", "--no-draft")
    assert outcome.code == 4
    place = f"controller.py:{line_of(source, 'while not rospy')}"
    assert f"tracerisk: {place}: nothing was commanded, and the 3 s of simulated" in outcome.err
    assert_untouched(example, before)


def test_commands_that_nobody_receives_are_named(example):
    example.write(
        "controller.py",
        "import rospy\n"
        "from std_msgs.msg import String\n"
        "from visualization_msgs.msg import Marker\n"
        "rospy.init_node('talker')\n"
        "shown = rospy.Publisher('marker', Marker, queue_size=1)\n"
        "heard = rospy.Publisher('echo', String, queue_size=1)\n"
        "rospy.Subscriber('echo', String, print)\n"
        "orders = rospy.Publisher('servo/orders', String, queue_size=1)\n"
        "for publisher, message in ((shown, Marker()), (heard, 'a'), (orders, 'b'), (orders, 'c')):\n"
        "    publisher.publish(message)\n"
        "rospy.sleep(1.0)\n",
    )
    outcome = example.run("run", "controller.py", "--robot", "panda")
    text = (
        "the controller ended; nobody receives what it publishes on /servo/orders (std_msgs/String)"
    )
    assert f"{text}, and it commanded no hardware" in outcome.err


def test_what_went_wrong_is_reported_before_what_was_assumed(example):
    example.write(
        "controller.py",
        "import moveit_commander\n"
        "FIRST = 'panda_joint1'\n"
        "arm = moveit_commander.MoveGroupCommander('arm')\n"
        "arm.set_position_target([9.0, 0.0, 0.0])\n"
        "arm.go()\n",
    )
    outcome = example.run("run", "controller.py", "--no-draft")
    assert "tracerisk: controller.py:5:1: the controller ended, and it commanded" in outcome.err
    assert "; planning for group 'arm' failed: " in outcome.err
    assert " (and 1 more, which `tracerisk trace controller.py` prints)" in outcome.err


def test_a_loop_that_asks_for_keys_that_never_come_ends(example, quick):
    source = quick('while sys.stdin.readline() != "q": pass')
    example.write("controller.py", source)
    outcome = example.run("trace", "controller.py", "--no-draft")
    assert outcome.code == 4
    line = line_of(source, "while sys")
    asked = f"the answer to a read of the standard input in line {line} was asked for 200"
    assert f"controller.py:{line}: {asked}" in outcome.err


def test_a_controller_that_takes_too_much_memory_is_reported_the_limit(example, quick):
    source = quick("hoard = bytearray(4_000_000_000)")
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py", "--memory-limit", "2500")
    assert outcome.code == 4
    place = f"controller.py:{line_of(source, 'hoard')}"
    assert f"tracerisk: {place}: the controller ran out of memory" in outcome.err
    assert "2500 MB (--memory-limit)" in outcome.err
    assert HELD in outcome.err
    assert_untouched(example, before)


def test_a_controller_cannot_raise_its_limits(example, quick):
    source = quick(
        "import resource",
        "kinds = (resource.RLIMIT_AS, resource.RLIMIT_CPU, resource.RLIMIT_CORE)",
        "print('limits', *(most for kind in kinds for most in resource.getrlimit(kind)))",
        "resource.setrlimit(resource.RLIMIT_AS, (-1, -1))",
    )
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--check", "--memory-limit", "3000")
    (found,) = re.findall(r"limits (.*)", outcome.out + outcome.err)
    memory, most_memory, cpu, most_cpu, *core = map(int, found.split())
    assert memory == most_memory == 3000 * 2**20
    assert 0 < cpu == most_cpu
    assert core == [0, 0]
    if not support().missing:
        assert outcome.code == 1
        assert "not allowed to raise maximum limit" in outcome.err


@pytest.mark.slow
def test_processes_that_take_too_much_memory_together_are_ended(example, quick):
    hoard = "import time; hoard = b'x' * 300_000_000; time.sleep(100)"
    source = quick(
        "import subprocess",
        f'started = [subprocess.Popen([sys.executable, "-c", {hoard!r}]) for _ in range(3)]',
        "started[0].wait()",
    )
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--memory-limit", "800")
    assert outcome.code == 4
    assert "the processes of the run take more than 800 MB of memory together" in outcome.err
    assert "raise it with --memory-limit" in outcome.err
    assert not running(hoard)


def test_a_memory_limit_below_what_the_simulation_takes_is_bad_input(example, quick):
    example.write("controller.py", quick())
    outcome = example.run("run", "controller.py", "--memory-limit", "250")
    assert outcome.code == 2
    assert "250 MB are too little to start the simulation" in outcome.err


def running(word: str) -> list[int]:
    """The processes that have a word among their arguments."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            words = (folder / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if word.encode() in words:
            found.append(int(folder.name))
    return found


def test_nothing_that_a_controller_started_is_left_running(example, quick):
    seconds = f"3000.{os.getpid()}"
    example.write(
        "controller.py",
        quick(
            "import subprocess",
            f"subprocess.Popen(['sleep', '{seconds}'])",
            f"subprocess.Popen(['sleep', '{seconds}'], start_new_session=True)",
            f"subprocess.run(['setsid', 'sh', '-c', 'sleep {seconds} &'])",
        ),
    )
    outcome = example.run("trace", "controller.py")
    assert outcome.code == 0, outcome.err
    assert "the controller ended" in outcome.err
    assert running(seconds) == []


def test_what_a_controller_prints_stays_out_of_the_json(example, quick):
    printing = quick('print("one")', 'os.write(1, b"two\\n")', 'os.system("echo three")')
    example.write("controller.py", printing)
    outcome = example.run("trace", "controller.py", "--json")
    assert outcome.code == 0
    assert outcome.json["verb"] == "trace"
    assert all(word in outcome.err for word in ("one", "two", "three"))


def test_a_failed_run_is_reported_as_json_too(example, quick):
    source = quick('raise RuntimeError("tube lost")')
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--json")
    assert outcome.code == outcome.json["exit_code"] == 1
    assert outcome.json["verdict"]["kind"] == "faulted"
    source = example.read("controller.py").decode()
    assert outcome.json["error"] == {
        "kind": "ControllerFailedError",
        "code": "run-raised",
        "message": "the controller raised RuntimeError: tube lost",
        "file": "controller.py",
        "line": line_of(source, "raise "),
        "column": None,
        "scenario": None,
    }
    assert [f["ref"]["name"] for f in outcome.json["trace"]["functions"]] == ["act"]


REFUSED = {
    "a syntax error": ("def f(:\n    pass\n", "controller.py:1:7: not valid Python"),
    "Python 2": (
        "import rospy\nprint 'hi'\nprint(1, file=x)\n",
        "controller.py:2:1: this is Python 2",
    ),
    "an encoding that Python does not know": (
        "# -*- coding: klingon -*-\n",
        "controller.py:1: unknown encoding: klingon",
    ),
    "bytes that are not UTF-8": (
        b"import rospy\n\nNAME = 'Gr\xfc\xdfe'\n",
        "controller.py:3:11: byte 0xfc is not utf-8",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_controller_is_refused_before_anything_runs(name, example):
    source, message = REFUSED[name]
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py")
    assert outcome.code == 2
    (line,) = outcome.err.splitlines()
    assert line.startswith("tracerisk: ")
    assert message in line
    assert_untouched(example, before)


@pytest.mark.parametrize(
    ("name", "reason"), [("nowhere.py", "No such file or directory"), (".", "Is a directory")]
)
def test_a_controller_that_cannot_be_read_is_bad_input(name, reason, example):
    outcome = example.run("run", name)
    assert outcome.code == 2
    assert f"tracerisk: {name}: the controller cannot be read: {reason}" in outcome.err


IMPORTS = {
    "a module": ("import nothere", "No module named 'nothere': put it beside the controller"),
    "a module of a package": ("from nothere.deep import thing", "No module named 'nothere'"),
    "a ROS package": (
        "import nav2_msgs",
        "which is neither found in the controller's workspace nor served",
    ),
    "a name of a ROS package": ("from rospy import nope", "rospy has no 'nope'"),
}


# A module of a package is reported by the package, as a module is.
@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "name", slow_but([each for each in IMPORTS if each != "a module of a package"], [*IMPORTS])
)
def test_an_import_of_what_is_not_there_is_bad_input(name, example, quick):
    statement, message = IMPORTS[name]
    source = quick().replace("import moveit", f"{statement}\nimport moveit", 1)
    example.write("controller.py", source)
    before = example.files()
    outcome = example.run("run", "controller.py", "--no-draft")
    assert outcome.code == 2
    assert "Traceback" not in outcome.err
    assert "tracerisk: controller.py:2: " in outcome.err
    assert message in outcome.err
    assert_untouched(example, before)


def test_an_import_that_fails_late_keeps_the_trace_so_far(example, quick):
    source = quick("import nothere")
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--json", "--no-draft")
    assert outcome.code == outcome.json["exit_code"] == 2
    assert outcome.json["error"]["line"] == line_of(source, "import nothere")
    assert HELD in outcome.err


def test_a_module_beside_is_imported_and_an_import_whose_failure_is_handled_is_none(example, quick):
    example.write("cell.py", "STEP = 0.05\n")
    handled = ("try: import nothere", "except ImportError: pass")
    example.write("controller.py", quick("import cell", "assert cell.STEP == 0.05", *handled))
    outcome = example.run("trace", "controller.py")
    assert outcome.code == 0, outcome.err
    assert not (example.folder / "__pycache__").exists()


def test_a_broken_module_beside_the_controller_is_reported_by_its_own_line(example, quick):
    example.write("cell.py", "STEP = 0.05\ndef f(:\n")
    example.write("controller.py", quick("import cell"))
    outcome = example.run("run", "controller.py")
    assert outcome.code == 2
    assert "tracerisk: cell.py:2:7: not valid Python: invalid syntax" in outcome.err


def test_an_old_name_of_python_is_reported_with_the_new_one(example):
    example.write("controller.py", "import time\n\nimport rospy\n\ntime.clock()\n")
    outcome = example.run("run", "controller.py", "--robot", "panda", "--no-draft")
    assert outcome.code == 4
    assert "no attribute 'clock'; write time.perf_counter() in place of time.clock" in outcome.err


def test_an_unknown_group_is_reported_with_those_that_are_there(example, quick):
    source = quick().replace('"panda_arm"', '"panda_leg"')
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--robot", "panda", "--no-draft")
    assert outcome.code == 4
    place = f"controller.py:{line_of(source, 'panda_leg')}"
    assert f"tracerisk: {place}: the controller raised" in outcome.err
    assert "did you mean 'panda_arm'?" in outcome.err


def test_a_pose_out_of_reach_that_the_controller_handles_is_a_finding(example, quick):
    source = quick(
        "pose = Pose()",
        "pose.position.x = 5.0",
        "pose.orientation.w = 1.0",
        "arm.set_pose_target(pose)",
        "assert not arm.go(wait=True)",
    )
    example.write("controller.py", source)
    outcome = example.run("trace", "controller.py", "--json")
    assert outcome.code == 1, outcome.err
    assert outcome.json["verdict"]["reasons"][0]["code"] == "planning-failed"
    (finding,) = outcome.json["trace"]["findings"]
    assert finding["location"]["line"] == line_of(source, "assert not")
    assert "no position of group 'panda_arm'" in finding["message"]


def test_a_thread_that_dies_is_a_finding(example, quick):
    source = quick(
        "import threading",
        "def work(): raise ValueError('no tube')",
        "thread = threading.Thread(target=work, name='worker')",
        "thread.start(); thread.join()",
    )
    example.write("controller.py", source)
    outcome = example.run("trace", "controller.py", "--json")
    assert outcome.code == 1
    assert outcome.json["verdict"]["reasons"][0]["function"] == "act.<locals>.work"
    (finding,) = outcome.json["trace"]["findings"]
    assert finding["message"].startswith("thread worker died of ValueError: no tube")
    assert finding["location"]["line"] == line_of(source, "def work")


def test_latin_1_and_crlf_survive_a_run(example, quick):
    source = "# -*- coding: latin-1 -*-\nNAME = 'Grü\xdfe'\n" + quick("assert NAME[2] == chr(252)")
    data = source.replace("\n", "\r\n").encode("latin-1")
    example.write("controller.py", data)
    outcome = example.run("run", "controller.py")
    assert outcome.code == 0, outcome.err
    annotated = example.read("controller.py")
    assert re.search(rb"# \| RiskAnnotation [0-9A-Za-z-]+\r\n", annotated)
    assert annotated.count(b"\n") == annotated.count(b"\r\n")
    assert example.run("strip", "controller.py").code == 0
    assert example.read("controller.py") == data


def test_arguments_after_two_dashes_are_the_controllers(example, quick):
    example.write("controller.py", quick('assert sys.argv[1:] == ["--speed", "2", "x"], sys.argv'))
    outcome = example.run("trace", "controller.py", "--", "--speed", "2", "x")
    assert outcome.code == 0, outcome.err


def test_answers_are_given_in_turn_and_then_enter(example, quick):
    source = quick(
        'assert input("go? ") == "yes"',
        "assert not os.isatty(sys.stdin.fileno()) and not sys.stdin.isatty()",
        'assert sys.stdin.readline() == "no\\n"',
        'assert sys.stdin.read(1) == "k"',
        'assert sys.stdin.readline() == "\\n"',
        'assert input() == ""',
        "assert [*sys.stdin] == []",
    )
    example.write("controller.py", source)
    answers = [word for text in ("yes", "no", "k") for word in ("--answer", text)]
    outcome = example.run("trace", "controller.py", *answers)
    assert outcome.code == 0, outcome.err
    assert "assumed: input: 3 questions got scripted answers, 1 got Enter" in outcome.err


def test_answers_are_read_as_bytes_too(example, quick):
    source = quick(
        'assert sys.stdin.buffer.readline() == "größer\\n".encode()',
        'assert sys.stdin.buffer.read(1) == b"k"',
        'assert sys.stdin.buffer.readline() == b"\\n"',
        'assert sys.stdin.readline() == "no\\n"',
        'assert [*sys.stdin.buffer] == [b"yes\\n"]',
        'assert sys.stdin.buffer.read() == b""',
    )
    example.write("controller.py", source)
    answers = [word for text in ("größer", "k", "no", "yes") for word in ("--answer", text)]
    outcome = example.run("trace", "controller.py", *answers)
    assert outcome.code == 0, outcome.err


def test_a_text_that_is_no_utf_8_and_a_command_of_a_log_are_only_shown(example, quick):
    source = quick(
        'name = b"calib\\xff.yaml".decode(errors="surrogateescape")',
        'rospy.logerr("cannot read %s", name)',
        'print("\\x1b]52;c;aGk=\\x07 \\x1b[31mred\\x1b[0m", flush=True)',
        'print(":", end="", flush=True)',
        'print(":error::pwned\\r::add-mask::x", flush=True)',
    )
    example.write("controller.py", source)
    outcome = example.run("trace", "controller.py", "--json")
    assert outcome.code in (0, 1), outcome.err  # the log line is a finding
    assert "\x1b" not in outcome.err + outcome.out
    assert "\\x1b]52;c;aGk=\\x07 red\n" in outcome.err
    lines = outcome.err.splitlines()
    assert [line for line in lines if "pwned" in line or "add-mask" in line] == [
        "./::error::pwned",
        "./::add-mask::x",
    ]
    assert not [line for line in lines if line.lstrip().startswith("::")]


def test_a_limit_to_the_size_of_files_is_said_to_be_one(example, quick):
    example.write("controller.py", quick())
    command = f"ulimit -f 100; exec '{sys.executable}' -m tracerisk run controller.py"
    done = subprocess.run(
        ["bash", "-c", command], cwd=example.folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 4, done.stderr
    assert "raise the limit with `ulimit -f unlimited`, and run the same command" in done.stderr


def test_an_empty_file_commands_nothing_and_is_left_alone(example):
    example.write("controller.py", "")
    before = example.files()
    outcome = example.run("run", "controller.py", "--no-draft")
    assert outcome.code == 4
    assert "controller.py:1: the controller ended, and it commanded no hardware" in outcome.err
    assert_untouched(example, before)
