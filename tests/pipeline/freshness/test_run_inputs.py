"""What a live run of a compiled node depended on, and when its blocks are stale."""

import json
from types import SimpleNamespace

import pytest

from tracerisk.config import Settings
from tracerisk.pipeline.freshness.freshness import stale_reasons
from tracerisk.pipeline.freshness.run_inputs import run_inputs
from tracerisk.pipeline.workspace.controller import load_controller

FILES = {
    "pick.cpp": "int main() { return 0; }\n",
    "place.cpp": "void place() {}\n",
    "cell.h": "void place();\n",
    "cell.yaml": "speed: 1\n",
}


@pytest.fixture
def depended(tmp_path):
    """Return how stale the blocks of the run are after a file has got some text more."""
    (tmp_path / "pyproject.toml").write_text("")
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    given = {"inputs": ("place.cpp", "cell.h", "cell.yaml"), "files": ("pick.cpp",)}
    trace = SimpleNamespace(**given, is_measured=True, is_live=True)
    settings = Settings(robot="panda")
    controller = load_controller(tmp_path / "pick.cpp")
    recorded = run_inputs(controller, trace, settings)

    def after(name, more):
        (tmp_path / name).write_text(FILES[name] + more)
        return stale_reasons(recorded, load_controller(tmp_path / "pick.cpp"), settings)

    return after


@pytest.mark.parametrize("name", FILES)
def test_a_change_of_any_file_of_the_run_makes_blocks_stale(depended, name):
    assert depended(name, "") == ()
    reasons = depended(name, "int more;\n")
    assert len(reasons) == 1
    assert name in str(reasons[0])


@pytest.mark.parametrize("name", ["pick.cpp", "place.cpp", "cell.h"])
def test_comments_of_sources_and_headers_change_no_run(depended, name):
    assert depended(name, "/* a block of another node */ // said\n") == ()


NODE = """\
import actionlib, rospy
from control_msgs.msg import GripperCommandAction, GripperCommandGoal

rospy.init_node("c")
hand = actionlib.SimpleActionClient("/franka_gripper/gripper_action", GripperCommandAction)
hand.wait_for_server()
goal = GripperCommandGoal()
goal.command.position = 0.01


def close():
    hand.send_goal_and_wait(goal)


close()
"""
HARDWARE = """\
robot: panda
components:
  finger: {{probability: {{value: {}, per: minute}}, twin: {{joints: [panda_joint1]}}}}
"""


def test_only_the_hardware_description_of_a_run_counts_and_needs_no_new_run(tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("package.xml", "<package><name>one</name></package>")
    example.write("pyproject.toml", "[tool.tracerisk]\nrobot = 'panda'\nhardware = 'data.yaml'\n")
    example.write("c.py", NODE)
    for name in ("data.yaml", "two/figures.yaml"):
        example.write(name, HARDWARE.format("1e-8"))
    example.write("two/package.xml", "<package><name>two</name></package>")
    ran = example.run("run", "c.py", "--no-draft")
    assert ran.code <= 1, ran.err
    entry = json.loads(example.read("tracerisk.lock"))["controllers"]["c.py"]
    assert not {"data.yaml", "two/figures.yaml"} & entry["inputs"]["files"].keys()
    example.write("two/figures.yaml", HARDWARE.format("3e-8"))
    assert "stale" not in example.run("check", "c.py").out
    example.write("data.yaml", HARDWARE.format("2e-8"))
    assert "data.yaml has changed since" in example.run("check", "c.py").out
    assert "values recomputed" in example.run("refresh", "c.py").err
