"""Modules that are not there: all at once, each with what to do."""

import csv

import pytest

from tracerisk.ros.imports.vendor_libraries import distributions

HERE = "the environment in which tracerisk runs"


@pytest.fixture
def reported(example, quick):
    def reported(*statements: str, **files: str) -> str:
        for name, text in files.items():
            example.write(f"{name}.py", text)
        lines = "\n".join(statements)
        example.write("c.py", f"{lines}\n{quick()}")
        outcome = example.run("run", "c.py", "--robot", "panda", "--no-draft")
        assert outcome.code == 2, outcome.err
        (line,) = [each for each in outcome.err.splitlines() if "tracerisk: " in each]
        return line

    return reported


def test_all_missing_modules_are_reported_at_once_each_with_its_remedy(reported):
    line = reported(
        "import pyquaternion_not",
        "import roslibpy, ikpy.chain",
        "from nothing_msgs.msg import Thing",
        "import pymycobot",
        "import beside",
        "def late():\n    import other_module",
        "try:\n    import optional_module\nexcept ImportError:\n    optional_module = None",
        beside="from kinpy import chain\nimport ikpy\n",
    )
    assert line.startswith(
        "tracerisk: c.py:1: No modules named 'pyquaternion_not', 'ikpy', 'kinpy', 'nothing_msgs', "
        "'other_module', 'pymycobot' and 'roslibpy'; 'pyquaternion_not' and 'other_module': "
        f"put it beside the controller, or install it in {HERE}; "
        f"'ikpy', 'kinpy' and 'roslibpy': `pip install ikpy kinpy roslibpy` in {HERE}; "
    )
    assert "'nothing_msgs': " in line
    assert (
        "it looks like a ROS package, which is neither found in the controller's workspace" in line
    )
    assert "'pymycobot': it speaks to the robot on a serial port" in line
    assert "optional_module" not in line


def test_a_library_of_the_package_index_has_one_command(reported):
    line = reported("from urdf_parser_py.urdf import URDF")
    assert f"No module named 'urdf_parser_py': `pip install urdf-parser-py` in {HERE}" in line


def test_the_name_of_the_distribution_need_not_be_the_modules(reported):
    assert "`pip install scikit-image`" in reported("import skimage")


def test_a_module_of_its_own_that_is_no_python_goes_before_what_is_missing(reported):
    turns = "def turn():\n    print 'x'\n    print(1, file=x)\n"
    line = reported("import ikpy", "from turns import turn", turns=turns)
    assert "turns.py:2:5: this is Python 2: `print 'x'`" in line
    assert "install" not in line


def test_a_module_of_the_package_index_has_one_command(reported):
    line = reported("import kinpy")
    assert f"`pip install kinpy` in {HERE}" in line


def test_what_the_library_of_python_2_has_is_not_missing(reported):
    line = reported("import Queue, thread, cPickle", "import kinpy", "print xrange(2)")
    assert "c.py:" in line
    assert "No module named 'kinpy': " in line


def test_six_is_there(example, quick):
    source = quick("assert six.moves.range(2) and six.PY3").replace(
        "import os", "import six, os", 1
    )
    example.write("c.py", source)
    outcome = example.run("trace", "c.py")
    assert outcome.code == 0, outcome.err


def test_the_table_is_sorted_and_names_each_module_once():
    from tracerisk.ros.imports.vendor_libraries import _MODULES

    rows = list(csv.reader(_MODULES.read_text(encoding="utf-8").splitlines()))
    assert rows[0] == ["module", "distribution"]
    assert rows[1:] == sorted(rows[1:])
    assert len(distributions()) == len(rows) - 1
    assert distributions()["cv2"] == "opencv-python"


@pytest.mark.parametrize(
    ("module", "is_told"), [("onrobot_rg_msgs.msg", True), ("colorama_that_nobody_has", False)]
)
def test_what_a_program_goes_on_without_is_told_if_it_is_of_a_robot(example, module, is_told):
    example.write(
        "go.py",
        "import rospy, moveit_commander\n"
        f"try:\n    from {module} import Command\nexcept ImportError:\n    Command = None\n"
        "rospy.init_node('n')\narm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "arm.go([0.1, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)\n",
    )
    ran = example.run("trace", "go.py", "--robot", "panda", "--json")
    assert ran.code == 0, ran.err
    verdict = ran.json["verdict"]
    assert verdict["kind"] == ("partial" if is_told else "complete")
    words = f"{module.partition('.')[0]} is not here, and the program went on without"
    assert any(words in each["words"] for each in verdict["reasons"]) == is_told


def test_what_comes_by_another_path_at_last_is_not_gone_without(example):
    (example.folder / "lib" / "panda_msgs").mkdir(parents=True)
    example.write("lib/panda_msgs/__init__.py", "Command = 1\n")
    example.write(
        "go.py",
        "import sys, rospy, moveit_commander\n"
        "try:\n    from panda_msgs import Command\nexcept ImportError:\n"
        "    sys.path.append(sys.path[0] + '/lib')\n    from panda_msgs import Command\n"
        "rospy.init_node('n')\narm = moveit_commander.MoveGroupCommander('panda_arm')\n"
        "arm.go([0.1, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)\n",
    )
    ran = example.run("trace", "go.py", "--robot", "panda", "--json")
    assert ran.code == 0, ran.err
    assert "went on without" not in ran.out
