"""Cython modules of a workspace that nobody has built."""

import re

import pytest

SEARCH = """\
import numpy as np
cimport numpy as np

cdef double _cost(double x):
    return x

def cheapest(np.ndarray grid, start):
    return start

cpdef int steps_of(grid):
    return 1

cdef class Grid:
    pass
"""
PROGRAM = """\
#!/usr/bin/env python3
import moveit_commander, rospy
from planner import search as planning


def main():
    rospy.init_node("program")
    group = moveit_commander.MoveGroupCommander("panda_arm")
    group.go([0.1, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=True)
    {more}


if __name__ == "__main__":
    main()
"""


@pytest.fixture
def run(example):
    def run(more: str):
        example.write("package.xml", "<package><name>demo</name></package>\n")
        example.write("planner/__init__.py", "")
        example.write("planner/search.pyx", SEARCH)
        example.write("program.py", PROGRAM.replace("{more}", more))
        return example.run("run", "program.py", "--check", "--json")

    return run


def test_a_controller_that_imports_one_is_run_and_the_run_is_partial(run):
    outcome = run(
        "print(planning.Grid, planning.steps_of)\n"
        "    try:\n"
        "        planning._cost(1.0)\n"
        "    except AttributeError as error:\n"
        "        print('caught:', error)"
    )
    assert len(outcome.json["trace"]["functions"]) == 1
    verdict = outcome.json["verdict"]
    assert verdict["kind"] == "partial"
    (reason,) = [each for each in verdict["reasons"] if each["code"] == "unmet-need"]
    assert reason["object"] == "planner.search"
    assert "compiled from search.pyx, and it is not built here" in reason["words"]
    # What it does not define is not there.
    assert re.search(r"caught: .* has no attribute '_cost'", outcome.out + outcome.err)


def test_what_it_defines_raises_where_it_is_called(run):
    outcome = run("planning.cheapest(1, 2)")
    assert outcome.json["verdict"]["kind"] == "faulted"
    assert "cheapest cannot be called; build it in place" in outcome.err
