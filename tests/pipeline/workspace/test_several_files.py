"""Controllers of several files, packages and workspaces."""

import pytest

SCRIPT = """\
import sys
import moveit_commander, rospy
from arm_task import moves
from arm_task.msg import Step
from other.limits import SPEED

def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("quick")
    arm = moveit_commander.MoveGroupCommander("panda_arm")
    arm.set_max_velocity_scaling_factor(SPEED)
    moves.turn(arm, Step(0.1))
    turn(arm)

def turn(arm):
    joints = arm.get_current_joint_values()
    joints[1] += 0.1
    arm.go(joints, wait=True)

main()
"""
MOVES = """\
from . import names

def turn(arm, step):
    joints = arm.get_current_joint_values()
    joints[names.FIRST] += step.shift
    arm.go(joints, wait=True)

def never(arm):
    arm.go()
"""
FILES = {
    "src/arm_task/package.xml": "<package><name>arm_task</name></package>\n",
    "src/arm_task/msg/Step.msg": "float64 shift\n",
    "src/arm_task/src/arm_task/__init__.py": "",
    "src/arm_task/src/arm_task/moves.py": MOVES,
    "src/arm_task/src/arm_task/names.py": "FIRST = 0\n",
    "src/arm_task/scripts/task.py": SCRIPT,
    "src/other/package.xml": "<package><name>other</name></package>\n",
    "src/other/other/__init__.py": "",
    "src/other/other/limits.py": "SPEED = 1.0\n",
}
TASK = "src/arm_task/scripts/task.py"
MODULE = "src/arm_task/src/arm_task/moves.py"


@pytest.fixture(scope="module")
def workspace(tmp_path_factory, example_in):
    example = example_in(tmp_path_factory.mktemp("ws"))
    for name, text in FILES.items():
        example.write(name, text)
    outcome = example.run("run", TASK, "--json")
    assert outcome.code == 0, outcome.err
    return example, outcome


def test_a_workspace_is_importable_as_if_built_and_every_own_module_is_traced(workspace):
    _, outcome = workspace
    functions = [each["ref"] for each in outcome.json["trace"]["functions"]]
    assert functions == [
        {"file": "src/arm_task/moves.py", "name": "turn"},
        {"file": "scripts/task.py", "name": "turn"},
    ]
    assert [u["ref"]["name"] for u in outcome.json["trace"]["uncovered"]] == ["never"]


def test_blocks_stand_in_each_source_and_the_model_says_equal_names_apart(workspace):
    example, outcome = workspace
    states = [state["name"] for state in outcome.json["model"]["states"]]
    assert states == ["moves.turn", "task.turn"]
    assert b"# |   name = turn\n" in example.read(TASK)
    assert b"# |   name = turn\n" in example.read(MODULE)
    assert b"# |   next = task.turn 1\n" in example.read(MODULE)
    built = example.run("build", TASK, MODULE, "--json").json["model"]
    assert built["states"] == outcome.json["model"]["states"]


def test_a_second_run_changes_no_byte_and_nothing_else_is_written(workspace):
    example, outcome = workspace
    before = example.files()
    assert set(before) == {*FILES, "src/arm_task/tracerisk.lock"}
    assert not list(example.folder.rglob("__pycache__"))
    again = example.run("run", TASK, "--json")
    assert again.code == 0, again.err
    assert example.files() == before
    assert example.run("run", TASK, "--check").code == 0
    assert again.json["assessment"] == outcome.json["assessment"]


def test_a_module_of_two_controllers_is_an_error_that_names_both(workspace):
    example, _ = workspace
    other = "src/arm_task/scripts/other_task.py"
    example.write(other, "import task\n")
    before = example.files()
    outcome = example.run("run", other)
    assert outcome.code == 2
    assert "scripts/task.py (turn) and scripts/other_task.py" in outcome.err
    assert "`helpers`" in outcome.err
    assert example.files() == before
    (example.folder / other).unlink()


def test_a_node_within_a_package_runs_as_its_module(example, quick):
    example.write("pkg/__init__.py", "")
    example.write("pkg/step.py", "SHIFT = 0.05\n")
    source = quick().replace("+= 0.05", "+= SHIFT")
    example.write("pkg/node.py", f"from .step import SHIFT\n{source}")
    outcome = example.run("trace", "pkg/node.py", "--json")
    assert outcome.code == 0, outcome.err
    assert [f["ref"]["name"] for f in outcome.json["trace"]["functions"]] == ["act"]


def test_a_module_that_is_no_python_is_named_with_its_line(example, quick):
    example.write("beside.py", "x = 1\nprint 'x'\nprint(x, file=y)\n")
    example.write("c.py", f"import beside\n{quick()}")
    outcome = example.run("trace", "c.py")
    assert outcome.code == 2
    assert "beside.py:2" in outcome.err
    assert "Python 2" in outcome.err
