"""Modules that are not there: all at once, each with what to do; one hint for Python 2."""

import csv

import pytest

from tracerisk.instrument.source.python_2 import python_2_hint
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


def test_python_2_has_one_hint(reported):
    line = reported(
        "import thread",
        "import Queue",
        "import nothing_else",
        "def ask():\n    return raw_input('go? ')",
        "def each(table):\n    return table.iteritems()",
    )
    assert line.startswith(
        "tracerisk: c.py:1: c.py is Python 2: `import thread` (line 1), `import Queue` (line 2), "
        "`raw_input` (line 5), `.iteritems()` (line 7); convert it first, e.g. with `2to3 -w c.py`"
    )
    assert "install" not in line


def test_a_module_of_its_own_that_is_python_2_goes_before_what_is_missing(reported):
    line = reported("import ikpy", "from turns import turn", turns="def turn():\n    print 'x'\n")
    assert "turns.py:2:5: this is Python 2: `print 'x'`" in line
    assert "install" not in line


def test_a_module_of_the_package_index_has_one_command(reported):
    line = reported("import kinpy")
    assert f"`pip install kinpy` in {HERE}" in line


def test_a_name_of_python_2_that_is_met_late_has_the_same_hint(reported):
    line = reported("for n in xrange(3):\n    pass")
    assert "c.py is Python 2: `xrange` (line 1); convert it first" in line


@pytest.mark.parametrize(
    "source",
    [
        "try:\n    import Queue\nexcept ImportError:\n    import queue as Queue\n",
        "try:\n    input = raw_input\nexcept NameError:\n    pass\n",
        "import sys\nif sys.version_info[0] < 3:\n    import thread\nelse:\n    import _thread\n",
        "from six.moves import xrange\nxrange(3)\n",
        "def long(arm):\n    return arm\nlong(1)\n",
        "print 'x'\n",
        "\x00",
    ],
)
def test_a_source_for_both_pythons_is_not_python_2(source):
    assert python_2_hint(source.encode(), "c.py") is None


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
