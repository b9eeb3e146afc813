"""`run --live` and `trace --live`: the published log and block from real rospy, and no way out."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.ros.live.test_differential import LOST_TRANSITION, MOST_RACES, assert_same, logged
from tracerisk.common import trace_json

CALL_OUT = """\
def call_out():
    import os
    import socket

    print("- master", os.environ.get("ROS_MASTER_URI", "none"))
    try:
        socket.create_connection(("192.0.2.1", 11311), timeout=1.0)
        print("- reached")
    except OSError as error:
        print("- refused", error.errno)


def wait_in_vain():
    import time

    began = rospy.get_time()
    time.sleep(0.3)
    print("- slept", round(rospy.get_time() - began, 3))
    try:
        rospy.wait_for_message("/nobody", JointTrajectoryPoint, timeout=0.5)
    except rospy.ROSException:
        print("- waited", round(rospy.get_time() - began, 3))


def main():
    call_out()
"""
SERVED = 'print("> server", client.wait_for_server())\n'
PROGRAM = (
    (Path(__file__).parent / "programs" / "goals_and_services.py")
    .read_text(encoding="utf-8")
    .replace("def main():\n", CALL_OUT)
    .replace(SERVED, f"{SERVED}    wait_in_vain()\n")
)
CONNECTION_REFUSED = 111


def _has_a_network_of_its_own() -> bool:
    code = (
        "from tracerisk.common.sandbox.kernel.features import leave_network; print(leave_network())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip() == "True"


@pytest.fixture(scope="module")
def lived(tmp_path_factory, example_in, real_ros):
    """A controller traced on real rospy, in an environment that points to a robot."""
    del real_ros
    example = example_in(tmp_path_factory.mktemp("lived"))
    # A live run waits for others, which is no processor time of the controller's.
    example.write("pyproject.toml", "[tool.tracerisk]\ncpu_limit_s = 0.01\n")
    example.write("steps.py", PROGRAM)
    given = {"ROS_MASTER_URI": "http://192.0.2.1:11311", "ROS_IP": "192.0.2.2"}
    with pytest.MonkeyPatch.context() as patch:
        for name, value in given.items():
            patch.setenv(name, value)
        # Again only where actionlib itself says that it dropped a status.
        for _ in range(MOST_RACES):
            done = example.run(
                *("trace", "steps.py", "--live", "--speed", "5", "--robot", "panda"),
                *("-o", "live.json", "--log", "live.log", "--record", "live.mcap"),
            )
            if LOST_TRANSITION not in done.out + done.err:
                break
    # It calls a service with too many arguments on purpose, and catches what that raises.
    assert done.code == 1, done.err
    assert "raised TypeError" in done.out
    assert "ServiceException" not in done.out.partition("\n")[0]
    example.write("printed.txt", done.out + done.err)
    example.write("pyproject.toml", "")
    return example


def test_the_run_has_its_own_master_and_no_way_out(lived):
    printed = lived.read("printed.txt").decode()
    assert "- master http://127.0.0.1:" in printed
    assert "- reached" not in printed
    if _has_a_network_of_its_own():
        assert f"- refused {CONNECTION_REFUSED}" in printed


def test_waits_of_rospy_and_sleeps_take_simulated_time(lived):
    printed = lived.read("printed.txt").decode()
    took_s = {
        name: float(s) for name, s in re.findall(r"^- (\w+) ([\d.]+)$", printed, re.MULTILINE)
    }
    assert took_s["slept"] == pytest.approx(0.3, abs=0.1), "five times as long on the wall clock"
    assert took_s["waited"] == pytest.approx(0.8, abs=0.3)


def test_the_trace_says_that_it_is_measured_and_what_is_lost(lived):
    trace = json.loads(lived.read("live.json").decode())
    reported = trace["assumptions"]
    assert reported[0] == "measured: live, on real rospy with the twin as a node"
    assert any(each.startswith("lost: repeatability") for each in reported)
    assert trace["end"]["cause"] == "ended"


def test_the_recording_holds_the_goals_of_the_trace_as_numbers(lived):
    from rosbags.highlevel import AnyReader

    trace = trace_json.loads(lived.read("live.json").decode(), "live.json")
    with AnyReader([lived.folder / "live.mcap"]) as reader:
        goals = [
            (time_ns, reader.deserialize(raw, connection.msgtype))
            for connection, time_ns, raw in reader.messages()
            if connection.topic == "/tracerisk/goals"
        ]
    moves = [command for command in trace.commands if command.end != "refused"]
    assert goals
    assert [round(time_ns * 1e-9, 9) for time_ns, _ in goals] == [move.issue_s for move in moves]
    assert [tuple(goal.name) for _, goal in goals] == [move.elements for move in moves]


@pytest.fixture(scope="module")
def simulated(lived):
    """What the same controller prints under the stand-ins."""
    done = lived.run(
        *("trace", "steps.py", "--robot", "panda", "--no-draft"),
        *("-o", "twin.json", "--log", "twin.log"),
    )
    # It calls a service with too many arguments on purpose, and catches what that raises.
    assert done.code == 1, done.err
    assert "raised TypeError: Invalid number of arguments" in done.out
    return done.out + done.err


def test_the_published_log_is_that_of_the_stand_ins(lived, simulated):
    del simulated
    assert lived.read("live.log").decode() == lived.read("twin.log").decode()
    assert "CallSequence:reach(),back()" in lived.read("live.log").decode()


def test_goals_feedback_and_services_do_the_same_under_real_rospy(lived, simulated):
    printed = logged(simulated)
    assert printed, "the program printed nothing to compare"
    assert logged(lived.read("printed.txt").decode()) == printed
    live, twin = (
        trace_json.loads(lived.read(name).decode(), name) for name in ("live.json", "twin.json")
    )
    assert_same(live, twin)


def test_the_published_block_is_written_and_never_fresh(lived):
    done = lived.run("annotate", "steps.py", "--trace", "live.json")
    assert done.code == 0, done.err
    source = lived.read("steps.py").decode()
    assert "# |   name = reach" in source
    assert source.count("RiskAnnotation") == 2
    checked = lived.run("check", "steps.py")
    assert checked.code == 1
    text = " ".join((checked.out + checked.err).split())
    assert "stale: setting measured was True" in text


def test_nothing_is_written_by_a_live_run_itself():
    from tracerisk.cli.parser import whole_parser
    from tracerisk.cli.running.finished_run import keeps_files

    options = whole_parser().parse_args(["run", "steps.py", "--live"])
    assert keeps_files(options)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "steps.py", "--speed", "2"), "--speed goes with --live"),
        (("run", "steps.py", "--live", "--check"), "--check goes with runs that can be repeated"),
        (("run", "steps.py", "--live", "--cpu-limit", "9"), "is ended by --wall-limit"),
        (("run", "two.cpp", "--live", "--", "./two"), "the program ./two of the command is not"),
        (("run", "two.cpp", "--live"), "`ros2 run PACKAGE NODE`, `ros2 launch PACKAGE FILE`"),
        (("trace", "steps.py", "--live", "--sandbox", "require"), "the sandbox is required"),
        (("attach",), "--robot is missing"),
    ],
)
def test_what_does_not_go_together_is_said(tmp_path, example_in, arguments, message):
    example = example_in(tmp_path)
    example.write("steps.py", PROGRAM)
    example.write("two.py", "import rclpy\n")
    example.write("two.cpp", "#include <rclcpp/rclcpp.hpp>\nint main() { return 0; }\n")
    done = example.run(*arguments)
    assert done.code == 2
    assert message in " ".join(done.err.split())
