"""What a run brought about, read out of its recording."""

import json
import math
from itertools import pairwise

import pytest

from tracerisk.common import trace_json
from tracerisk.common.outcome.changes import outcome_changes
from tracerisk.common.outcome.kept import kept_outcome
from tracerisk.common.outcome.outcome import Outcome

CELL = """\
import actionlib
import moveit_commander
import rospy
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_msgs.msg import String
from std_srvs.srv import SetBool

rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")
glue = rospy.ServiceProxy("/glue/enable", SetBool)
sign = rospy.Publisher("/sign", String, queue_size=1)
alive = rospy.Publisher("/alive", String, queue_size=1)
drive = actionlib.SimpleActionClient("/move_base", MoveBaseAction)
rospy.Timer(rospy.Duration(0.1), lambda event: alive.publish("alive"))


def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] = angle
    arm.go(joints, wait=True)


turn(0.3)
glue(True)
turn(0.0)
glue(False)
sign.publish("done after 12.25 s")
drive.wait_for_server()
drive.send_goal(MoveBaseGoal())
drive.wait_for_result()
"""
SCENARIO = """\
services:
  - {name: /glue/enable, type: std_srvs/SetBool, replies: [{success: true}, {success: false}]}
actions:
  - {name: /move_base, type: move_base_msgs/MoveBase, after: 2}
"""


@pytest.fixture(scope="module")
def cell(tmp_path_factory, example_in) -> Outcome:
    example = example_in(tmp_path_factory.mktemp("cell"))
    example.write("cell.py", CELL)
    example.write("cell.yaml", SCENARIO)
    run = example.run("trace", "cell.py", "--scenario", "cell.yaml", "--json")
    outcome = trace_json.loads(json.dumps(run.json["trace"]), "trace").outcome
    assert outcome is not None
    return outcome


def test_tubes_end_in_the_target_rack_and_the_others_stay(short_trace):
    outcome = short_trace.outcome
    moved = outcome.moved
    assert [found.name for found in moved] == ["tube_1", "tube_2"]
    assert len(outcome.objects) == 10
    for found in moved:
        assert found.end_m[1] == pytest.approx(-0.2, abs=0.003)
        assert found.tilt_deg <= 3.0
        assert (found.rests_on, found.held_in, found.heading_deg) == ("target_rack", "", None)


def test_grips_follow_one_another(short_trace):
    holds = [use.holds for use in short_trace.outcome.grips]
    assert holds == ["", "tube_1", "", "tube_2", ""]


def test_the_arm_rests_where_its_motions_end(short_trace):
    rests = short_trace.outcome.rests
    assert rests[0].joints == pytest.approx((0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785), abs=1e-3)
    assert rests[0].tool_m == pytest.approx((0.307, 0.0, 0.590), abs=1e-3)
    above = rests[1].tool_m
    assert above[:2] == pytest.approx((0.3, 0.2), abs=1e-3)
    assert all(math.dist(one.joints, other.joints) > 0.0 for one, other in pairwise(rests))


def test_the_lock_keeps_what_the_trace_has(short_run, short_trace):
    example, _ = short_run
    lock = json.loads(example.read("tracerisk.lock"))
    (entry,) = lock["controllers"].values()
    kept = kept_outcome(entry["trace"])
    assert kept is not None
    assert not outcome_changes(kept, short_trace.outcome).sentences
    assert len(json.dumps(entry["trace"]["outcome"], indent=1)) < 4000


def test_the_run_says_what_moved_in_one_line(short_run):
    example, _ = short_run
    out = example.run("trace", "pick_and_place.py", "-q").out
    assert "2 objects moved: tube_1 to (" in out


def test_the_cell_is_asked_in_order(cell):
    assert [(use.kind, use.interface, use.content, use.succeeded) for use in cell.cell] == [
        ("call", "/glue/enable", "data=true", True),
        ("call", "/glue/enable", "", False),
        ("message", "/sign", "data='done after # s'", True),
        ("goal", "/move_base", "", True),
    ]
    orders = [step.order for step in (*cell.rests, *cell.cell)]
    assert sorted(orders) == list(range(6))
    assert [use.order for use in cell.cell] == [1, 3, 4, 5]


def test_messages_at_a_steady_rate_are_a_stream(cell):
    assert cell.streams == ("/alive",)


def test_the_robots_own_interfaces_are_no_cell(example, quick):
    example.write("controller.py", quick())
    run = example.run("trace", "controller.py", "--json")
    assert run.json["trace"]["outcome"]["cell"] == []
