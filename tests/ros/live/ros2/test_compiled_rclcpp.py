"""A node on rclcpp, compiled here, moves the twin: its functions, verdict, blocks; nothing gets out.

RCLCPP_PREFIX names the prefixes that have rclcpp, rclcpp_action, control_msgs and std_srvs, and for
MoveIt's interface moveit_msgs, with colons between them, such as /opt/ros/jazzy; LDFLAGS are given to
the linker.
"""

import json
import os
import shlex
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.ros.live.picked import assert_picked

# Compiling a node takes as long as hundreds of other tests. Its parts are tested in each run: what
# the probe notes (`tests/probe/native`), what is made of it (`tests/pipeline/run/live`), and the
# twin as a node of ROS 2 (here).
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("real_rclpy")]

PROGRAMS = Path(__file__).parent / "programs"
PREFIXES = "RCLCPP_PREFIX"
LIBRARIES = ("rclcpp", "rclcpp_action", "rcl", "rcl_action", "rcutils", "rcpputils", "rmw")
MORE = ("rosidl_runtime_c", "tracetools", "libstatistics_collector")
MESSAGES = (
    *("trajectory_msgs", "sensor_msgs", "builtin_interfaces", "action_msgs", "std_msgs"),
    *("unique_identifier_msgs", "rcl_interfaces", "statistics_msgs", "rosgraph_msgs"),
)
OF_MOVEIT = (
    "moveit_msgs",
    "geometry_msgs",
    "shape_msgs",
    "object_recognition_msgs",
    "octomap_msgs",
)


@pytest.fixture(scope="module")
def compiled(tmp_path_factory, example_in):
    """Compiles a program with message packages in a folder of its own; skips where it cannot."""
    prefixes = [Path(item) for item in os.environ.get(PREFIXES, "").split(":") if item]
    compiler = shutil.which("c++")
    if not prefixes or compiler is None:
        pytest.skip(f"no C++ compiler, or {PREFIXES} names no prefix with rclcpp")

    def compile_program(name, packages):
        for package in packages:
            if not any((prefix / "include" / package).is_dir() for prefix in prefixes):
                pytest.skip(f"no prefix of {PREFIXES} has {package}")
        example = example_in(tmp_path_factory.mktemp("compiled"))
        example.write("pyproject.toml", "")
        example.write(f"{name}.cpp", (PROGRAMS / f"{name}.cpp").read_text())
        made = example.run("headers", f"{name}.cpp", "-o", "include")
        assert made.code == 0, made.err
        folders = [item for prefix in prefixes for item in sorted((prefix / "include").iterdir())]
        messages = [f"{package}__rosidl_typesupport_cpp" for package in (*MESSAGES, *packages)]
        subprocess.run(
            [
                *(compiler, "-std=c++17", "-g", "-O0", f"{name}.cpp", "-o", name, "-pthread"),
                *("-Wall", "-Wextra", "-Werror", "-Iinclude"),
                *(f"-isystem{folder}" for folder in folders),
                *(f"-L{prefix}/lib" for prefix in prefixes),
                *("-Wl,--as-needed", "-Wl,--allow-shlib-undefined"),
                *(f"-l{library}" for library in (*LIBRARIES, *MORE, *messages)),
                *shlex.split(os.environ.get("LDFLAGS", "")),
            ],
            cwd=example.folder,
            check=True,
        )
        return example

    return compile_program


@pytest.fixture(scope="module")
def lived(compiled):
    """The node, run in an environment that points to a robot's domain."""
    example = compiled("cell", ("control_msgs", "std_srvs"))
    example.write("angle.yaml", "cell:\n  ros__parameters:\n    angle: 0.4\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_DOMAIN_ID", "0")
        patch.setenv("ROS_STATIC_PEERS", "192.0.2.1")
        done = example.run(
            *("trace", "--live", "--robot", "panda", "-o", "live.json", "--log", "live.log"),
            *("--params", "angle.yaml", "--", "./cell", "--left"),
        )
    example.write("printed.txt", done.out + done.err)
    assert done.code == 1, done.out + done.err
    return example


def test_a_node_plans_with_moveit_where_there_is_none(compiled):
    example = compiled("picker", OF_MOVEIT)
    done = example.run(
        *("trace", "--live", "--robot", "panda", "-o", "live.json", "--", "./picker")
    )
    assert done.code == 0, done.out + done.err
    assert_picked(json.loads(example.read("live.json").decode()))


def test_functions_of_two_publishers_of_a_topic_do_not_swap_where_messages_are_lost(compiled):
    example = compiled("two_publishers", ())
    done = example.run(
        *("trace", "--live", "--robot", "panda", "-o", "live.json", "--", "./two_publishers")
    )
    trace = json.loads(example.read("live.json").decode())
    assert trace["end"]["cause"] == "ended", done.out + done.err
    ends = {(command["function"]["name"], command["end"]) for command in trace["commands"]}
    assert ends == {
        *(("Cell::turn", "replaced"), ("Cell::turn", "arrived"), ("Cell::mistake", "ignored"))
    }
    assert len(trace["commands"]) < 1200, "none of 1,201 was lost"


@pytest.fixture(scope="module")
def waits(compiled):
    return compiled("waits", ())


@pytest.mark.parametrize("way", ["spin", "poll"])
def test_a_node_that_only_waits_for_callbacks_ends_without_a_word(waits, way):
    done = waits.run(
        *("trace", "--live", "--speed", "20", "--robot", "panda", "-o", "live.json"),
        *("--", "./waits", way),
    )
    assert done.code == 0, done.out + done.err
    trace = json.loads(waits.read("live.json").decode())
    assert (trace["end"]["cause"], trace["verdict"]["kind"]) == ("idle", "complete")
    assert [command["end"] for command in trace["commands"]] == ["arrived"]


def test_the_node_reads_the_twin_moves_it_and_has_its_parameters(lived):
    printed = lived.read("printed.txt").decode()
    lines = [line for line in printed.splitlines() if line.startswith("> ")]
    assert lines == [
        *("> switched on", "> reached 0.40", "> back 4 0.00", "> gripped 1"),
        *("> simulated 1", "> args 2"),
    ]


def test_functions_are_those_of_the_source_in_threads_and_timers_too(lived):
    text = lived.read("live.log").decode()
    called = "CallSequence:cell::Cell::reach(),cell::Cell::back(),cell::Cell::grip()"
    assert called in text
    assert "Function:cell::Cell::grip()\nActiveComponents:gripper,electric_motor\n" in text


def test_the_verdict_is_as_strict_as_on_the_stand_ins(lived):
    trace = json.loads(lived.read("live.json").decode())
    assert trace["end"]["cause"] == "exited"
    reasons = {reason["code"]: reason["words"] for reason in trace["verdict"]["reasons"]}
    assert reasons.pop("run-exited").endswith("./cell ended with code 3")
    assert reasons.pop("error-logged") == "it logged ERROR: lost a part"
    assert reasons.pop("never-ran").startswith("cell::Cell::park can command hardware and never")
    assert reasons == {}
    assert not [line for line in trace["findings"] if "functions:" in line["message"]]


def test_blocks_are_written_into_the_functions_of_the_author(lived):
    done = lived.run("annotate", "cell.cpp", "--trace", "live.json")
    assert done.code == 0, done.err
    text = lived.read("cell.cpp").decode()
    for name in ("reach", "back", "grip"):
        assert f"name = cell::Cell::{name}\n" in text
    assert text.count("RiskAnnotation") == 3
