"""A controller of Python 2 is run, annotated, checked and refreshed as it is."""

import pytest

CONTROLLER = """#!/usr/bin/env python
import rospy
import moveit_commander
import Queue
import steps


class Cell:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
	self.turns = Queue.Queue()

    def turn(self, (joint, by)):
        # by its number
        joints = self.arm.get_current_joint_values()
        joints[joint / 2] += by
        try:
            self.arm.go(joints, wait=True)
        except Exception, e:
            print "failed", `e`


rospy.init_node("cell")
cell = Cell()
for n in xrange(2):
    cell.turns.put((1, 0.1 + n / 2))
while not cell.turns.empty():
    cell.turn(cell.turns.get())
steps.finish(cell.arm)
"""
STEPS = """def finish(arm):
    joints = arm.get_current_joint_values()
    joints[0] = 0.2
    print arm.go(joints)
"""


@pytest.fixture
def cell(example):
    example.write("c.py", CONTROLLER)
    example.write("steps.py", STEPS)
    example.write("pyproject.toml", "")
    return example


def test_it_runs_as_it_is_and_the_run_says_so(cell):
    ran = cell.run("run", "c.py", "--robot", "panda", "--json")
    assert ran.code == 0, ran.err
    trace = ran.json["trace"]
    # In Python 3 a list has no index 0.5.
    assert [f["ref"]["name"] for f in trace["functions"]] == ["Cell.turn", "finish"]
    assert sum(visit["function"]["name"] == "Cell.turn" for visit in trace["visits"]) == 2
    (line,) = [each for each in trace["assumptions"] if each.startswith("source: ")]
    assert line.startswith("source: c.py, steps.py are Python 2, converted in memory for the run")

    annotated = cell.read("c.py").decode()
    blocks = [line for line in annotated.splitlines() if line.lstrip().startswith("# |")]
    assert blocks
    assert [
        line for line in annotated.splitlines() if line not in blocks
    ] == CONTROLLER.splitlines()
    assert cell.run("check", "c.py").code == 0

    cell.write("c.py", annotated.replace("0.1 + n / 2", "0.3 + n / 2"))
    assert "stale" in cell.run("check", "c.py").out
    assert cell.run("refresh").code == 0
    assert cell.run("check", "c.py").code == 0
    assert cell.run("strip", "c.py", "steps.py").code == 0
    assert cell.read("c.py") == CONTROLLER.replace("0.1 + n / 2", "0.3 + n / 2").encode()
    assert cell.read("steps.py") == STEPS.encode()


def test_how_it_is_cut_into_functions_changes_no_figure(cell):
    whole = cell.run("trace", "c.py", "--robot", "panda", "--json").json["trace"]
    cell.write(
        "c.py",
        CONTROLLER.replace(
            "            self.arm.go(joints, wait=True)\n",
            "            self.really(joints)\n",
        ).replace(
            "    def turn(self",
            "    def really(self, joints):\n\tself.arm.go(joints, wait=True)\n\n    def turn(self",
        ),
    )
    cut = cell.run("trace", "c.py", "--robot", "panda", "--json").json["trace"]
    assert cut["active"] == whole["active"]


@pytest.mark.slow
def test_it_is_not_mutated(cell):
    ran = cell.run("mutate", "c.py", "--robot", "panda")
    assert ran.code == 2
    assert "c.py, steps.py is Python 2, of which no part is changed for a trial" in ran.err
