"""A C++ node, compiled here, moves the twin: its functions, verdict, blocks; nothing gets out."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from tests.ros.live.picked import assert_picked

# Compiling a node takes as long as hundreds of other tests. Its parts are tested in each run: what a
# node of roscpp records and how its functions are called (`tests/probe/native`), live runs of nodes
# in Python (here), and blocks in C++ (`tests/adder`).
pytestmark = pytest.mark.slow

PROGRAMS = Path(__file__).parent / "programs"
LIBRARIES = ("actionlib", "roscpp", "roscpp_serialization", "rosconsole", "rostime")
FLAGS = ("-g", "-O0", "-Iinclude", "-I/opt/ros/noetic/include", "-L/opt/ros/noetic/lib")
AFTER = """\
  cell.home();
  int parts = 0, more = 0;
  std::cin >> parts >> more;  // the second answer is missing
  ROS_ERROR("lost %d parts", parts + more);
  ROS_INFO("master %s", ros::master::getURI().c_str());
  const ros::Time until = ros::Time::now() + ros::Duration(0.2);
  while (ros::Time::now() < until) ros::spinOnce();  // without a sleep, as many nodes wait
  cell.leave();
  return 3;
"""
LATE = """\
static cell::Cell* arm = nullptr;
static void late(const ros::TimerEvent&)
{
  ros::Duration(15.0).sleep();
  arm->home();
}
"""
LATE_THREAD = """\
#include <thread>
static cell::Cell* arm = nullptr;
static void late()
{
  ros::Duration(70.0).sleep();
  arm->home();
}
"""
POLLS = """\
  std::thread(late).detach();
  ros::Rate rate(20.0);
  while (ros::ok()) {
    ros::spinOnce();
    rate.sleep();
  }
"""
CYCLES = """\
  ros::Rate rate(20.0);
  while (ros::ok()) {
    cell.home();
    cell.place();
    rate.sleep();
  }
"""
MORE = """\
  void place();
  void park() { swing(1.0, 1.0); }
  void leave() { hand_.sendGoal(control_msgs::GripperCommandGoal()); ros::Duration(0.1).sleep(); }
"""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory, example_in, real_ros):
    """Compiles a source under a name in a folder of its own; skips where that is impossible."""
    del real_ros

    def compile_source(name, text):
        compiler = shutil.which("c++")
        if compiler is None:
            pytest.skip("no C++ compiler")
        example = example_in(tmp_path_factory.mktemp("compiled"))
        example.write("pyproject.toml", "")
        example.write(f"{name}.cpp", text)
        made = example.run("headers", f"{name}.cpp", "-o", "include")
        if made.code:
            pytest.skip(made.err)
        linked = [f"-l{library}" for library in LIBRARIES]
        linked += ["-lboost_system", "-lboost_thread", "-lpthread"]
        built = subprocess.run(
            [compiler, *FLAGS, f"{name}.cpp", "-o", name, *linked],
            cwd=example.folder,
            capture_output=True,
            text=True,
            check=False,
        )
        if "ros/ros.h: No such file" in built.stderr:
            pytest.skip("no roscpp")
        assert built.returncode == 0, built.stderr
        return example

    return compile_source


@pytest.fixture(scope="module")
def lived(compiled):
    """A node that logs an error and ends with 3, run in an environment that points to a robot."""
    text = (PROGRAMS / "pick.cpp").read_text().replace("  cell.home();\n  return 0;\n", AFTER)
    assert AFTER in text
    begun = '  ROS_INFO("clock %d", int(ros::Time::isValid()));\n  cell::Cell cell;\n'
    assert "  cell::Cell cell;\n" in text
    text = text.replace("  cell::Cell cell;\n", begun)
    example = compiled("pick", text.replace("  void place();\n", MORE))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("ROS_MASTER_URI", "http://192.0.2.1:11311")
        patch.setenv("ROS_IP", "192.0.2.2")
        done = example.run(
            *("trace", "--live", "--speed", "20", "--robot", "panda", "-o", "live.json"),
            *("--log", "live.log", "--answer", "2", "--", "./pick"),
        )
    example.write("printed.txt", done.out + done.err)
    assert done.code == 1, done.out + done.err
    return example


def test_the_published_log_names_the_functions_of_the_node(lived):
    text = lived.read("live.log").decode()
    assert "Function:cell::Cell::pick()\nActiveComponents:gripper,electric_motor\n" in text
    assert "CallSequence:cell::Cell::pick(),cell::Cell::place(),cell::Cell::home()" in text


def test_a_node_has_the_time_when_it_begins(lived):
    assert "clock 1" in lived.read("printed.txt").decode()


def test_a_goal_may_be_pursued_when_the_node_ends(lived):
    commands = json.loads(lived.read("live.json").decode())["commands"]
    assert commands[-1]["function"]["name"] == "cell::Cell::leave"


def test_the_verdict_is_as_strict_as_on_the_stand_ins(lived):
    trace = json.loads(lived.read("live.json").decode())
    assert trace["end"]["cause"] == "exited"
    reasons = {reason["code"]: reason["words"] for reason in trace["verdict"]["reasons"]}
    assert reasons["run-exited"].endswith("pick ended with code 3")
    assert reasons["error-logged"] == "it logged ERROR: lost 2 parts"
    assert "reads its standard input after 1 answers" in reasons["input-assumed"]
    assert reasons["never-ran"].startswith("cell::Cell::park can command hardware and never ran")
    assert not [line for line in trace["findings"] if "functions:" in line["message"]]


def test_the_node_has_a_master_on_loopback_alone(lived):
    printed = lived.read("printed.txt").decode()
    assert "master http://127.0.0.1:" in printed
    assert "192.0.2" not in printed


def test_blocks_are_written_into_the_functions_of_the_author(lived):
    done = lived.run("annotate", "pick.cpp", "--trace", "live.json")
    assert done.code == 0, done.err
    text = lived.read("pick.cpp").decode()
    names = ("cell::Cell::home", "cell::Cell::pick", "cell::Cell::place")
    assert [f"name = {name}\n" in text for name in names] == [True] * 3
    assert text.count("RiskAnnotation") == 4
    solved = lived.run("solve", "pick.cpp")
    assert solved.code == 0, solved.err
    assert "cell::Cell::pick" in solved.out


def live(example, name):
    """Run a node on the twin, at many times the speed of the clock; return its trace."""
    done = example.run(
        *("trace", "--live", "--speed", "20", "--robot", "panda", "-o", "live.json"),
        *("--", f"./{name}"),
    )
    assert done.code == 0, done.out + done.err
    return json.loads(example.read("live.json").decode())


def ending(rest, before=""):
    """Return the node that picks, with another rest of its `main()`."""
    text = (PROGRAMS / "pick.cpp").read_text().replace("  cell.home();\n  return 0;\n", rest)
    text = text.replace("int main(", f"{before}int main(")
    text = text.replace("  cell::Cell cell;\n", "  cell::Cell cell;\n  arm = &cell;\n")
    assert rest in text
    assert text.count("arm = &cell") == 1
    return text


def test_what_a_callback_commands_late_is_kept_and_a_node_that_only_spins_ends(compiled):
    late = "  const ros::Timer timer = node.createTimer(ros::Duration(1.0), late, true);\n"
    trace = live(compiled("late", ending(f"{late}  ros::spin();\n", LATE)), "late")
    assert (trace["end"]["cause"], trace["verdict"]["kind"]) == ("idle", "complete")
    before, last = trace["commands"][-2:]
    assert last["issue_s"] - before["end_s"] > 15.0


def test_a_node_that_polls_ends_once_its_threads_have_waited_to_their_end(compiled):
    trace = live(compiled("polls", ending(POLLS, LATE_THREAD)), "polls")
    assert (trace["end"]["cause"], trace["verdict"]["kind"]) == ("idle", "complete")
    before, last = trace["commands"][-2:]
    assert last["issue_s"] - before["end_s"] > 65.0


def test_a_cycle_that_a_node_repeats_for_ever_ends_at_the_third(compiled):
    trace = live(compiled("cycles", ending(CYCLES, "static cell::Cell* arm;\n")), "cycles")
    assert (trace["end"]["cause"], trace["verdict"]["kind"]) == ("cycles", "complete")


def test_a_node_plans_with_moveit_where_there_is_none(compiled):
    if Path("/usr/include/moveit").exists() or list(Path("/opt/ros").glob("*/include/moveit")):
        pytest.skip("MoveIt is installed")
    example = compiled("move_group", (PROGRAMS / "move_group.cpp").read_text())
    done = example.run(
        *("trace", "--live", "--speed", "20", "--robot", "panda", "-o", "live.json"),
        *("--", "./move_group"),
    )
    assert done.code == 0, done.out + done.err
    assert_picked(json.loads(example.read("live.json").decode()))


def test_the_published_case_as_a_node_ends_as_blocks_in_its_five_functions(compiled):
    text = (PROGRAMS / "tube_cell.cpp").read_text()
    example = compiled("tube_cell", text.replace("kTubes = 10", "kTubes = 2"))
    done = example.run(
        *("trace", "--live", "--speed", "20", "--robot", "panda", "--scene", "tube_racks"),
        *("-o", "live.json", "--", "./tube_cell"),
    )
    assert done.code == 0, done.out + done.err
    trace = json.loads(example.read("live.json").decode())
    assert trace["verdict"]["kind"] == "complete"
    assert example.run("annotate", "tube_cell.cpp", "--trace", "live.json").code == 0
    solved = example.run("solve", "tube_cell.cpp", "--json").json["assessment"]
    steps = ("init", "pickPosition", "pick", "placePosition", "place")
    states = {state["name"]: state for state in solved["states"]}
    assert list(states) == [f"TubeCell::{step}" for step in steps]
    assert all(state["top_event"] > 0.0 for state in states.values())
