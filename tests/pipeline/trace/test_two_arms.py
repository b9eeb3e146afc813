"""Two arms moved at once by two functions: each function answers for its own arm."""

import pytest

from tracerisk.common import trace_json
from tracerisk.trace import Trace

CONTROLLER = """\
import threading

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["s0", "s1", "e0", "e1", "w0", "w1", "w2"]
NEUTRAL = [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0]


def arm(side):
    client = actionlib.SimpleActionClient(
        "/robot/limb/%s/follow_joint_trajectory" % side, FollowJointTrajectoryAction
    )
    client.wait_for_server()
    return client


def wipe(client):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = [
        "left_s0", "left_s1", "left_e0", "left_e1", "left_w0", "left_w1", "left_w2"
    ]
    for index, turn in enumerate((0.3, -0.3, 0.0)):
        place = [turn] + NEUTRAL[1:]
        after = rospy.Duration(2.0 * (index + 1))
        goal.trajectory.points.append(JointTrajectoryPoint(positions=place, time_from_start=after))
    client.send_goal_and_wait(goal)


def lift(client):
    rospy.sleep(1.0)
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = ["right_" + name for name in JOINTS]
    place = NEUTRAL[:3] + [1.25] + NEUTRAL[4:]
    goal.trajectory.points.append(
        JointTrajectoryPoint(positions=place, time_from_start=rospy.Duration(2.0))
    )
    client.send_goal_and_wait(goal)


def main():
    rospy.init_node("two_arms")
    works = [
        threading.Thread(target=wipe, args=(arm("left"),)),
        threading.Thread(target=lift, args=(arm("right"),)),
    ]
    for work in works:
        work.start()
    for work in works:
        work.join()


if __name__ == "__main__":
    main()
"""


@pytest.fixture(scope="module")
def outcome(tmp_path_factory, example_in):
    example = example_in(tmp_path_factory.mktemp("two_arms"))
    example.write("two_arms.py", CONTROLLER)
    ran = example.run(
        "run", "two_arms.py", "--json", "--trace", "trace.json", "--model", "model.json"
    )
    assert ran.code == 0, ran.err
    return example, ran


@pytest.fixture(scope="module")
def trace(outcome) -> Trace:
    example, _ = outcome
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


def moved(trace: Trace, function: str) -> dict[str, float]:
    """How long each element moved in the visits of a function [s]."""
    total: dict[str, float] = {}
    for visit in trace.visits:
        if visit.function.name == function:
            for name, exposure in visit.exposures.items():
                if exposure is not None and exposure.moving_s > 0.0:
                    total[name] = total.get(name, 0.0) + exposure.moving_s
    return total


def test_each_function_moves_its_own_arm_alone(trace):
    assert trace.robot == "baxter"
    assert {each.ref.name for each in trace.functions} == {"wipe", "lift"}
    wiped, lifted = moved(trace, "wipe"), moved(trace, "lift")
    # Encoder and torque sensor of a joint move with it.
    assert {name.partition("/")[0] for name in wiped} == {"left_s0"}
    assert {name.partition("/")[0] for name in lifted} == {"right_e1"}
    assert wiped["left_s0"] == pytest.approx(6.0, abs=0.5)
    assert lifted["right_e1"] == pytest.approx(2.0, abs=0.3)


def test_they_ran_at_once_and_it_is_reported(trace):
    spans = {
        visit.function.name: (visit.start_s, visit.start_s + (visit.duration_s or 0.0))
        for visit in trace.visits
    }
    assert spans["wipe"][0] < spans["lift"][0] < spans["wipe"][1]
    assert any(
        finding.kind == "concurrent_owners"
        and "wipe" in finding.message
        and "lift" in finding.message
        for finding in trace.findings
    )


def test_every_active_second_belongs_to_one_visit(trace):
    for name, whole in trace.active.items():
        parts = [visit.exposures.get(name) for visit in trace.visits]
        for what in ("moving_s", "holding_s", "active_s"):
            reported = sum(getattr(part, what) for part in parts if part is not None)
            assert reported == pytest.approx(getattr(whole, what), abs=1e-6), (name, what)


def test_each_function_gets_one_block(outcome):
    example, _ = outcome
    source = example.read("two_arms.py").decode()
    assert source.count("@Function {") == 2
    assert source.index("name = wipe") < source.index("name = lift")


BOTH = """\
import sys

import moveit_commander

moveit_commander.roscpp_initialize(sys.argv)
arms = moveit_commander.MoveGroupCommander("both_arms")
hands = {}
for hand in ("left_gripper", "right_gripper"):
    pose = arms.get_current_pose(hand).pose
    pose.position.z += 0.1
    hands[hand] = pose
    arms.set_pose_target(pose, hand)


def raise_both():
    assert arms.go(wait=True)


def close_left():
    hand = moveit_commander.MoveGroupCommander("left_hand")
    hand.go([0.0, 0.0], wait=True)


raise_both()
for hand, wanted in hands.items():
    reached = arms.get_current_pose(hand).pose.position
    assert abs(reached.z - wanted.position.z) < 0.01, (hand, reached)
close_left()
"""


def test_a_group_of_both_arms_goes_to_a_pose_of_each_hand(tmp_path, example_in):
    example = example_in(tmp_path)
    example.write("both.py", BOTH)
    ran = example.run("trace", "both.py", "--robot", "baxter", "-o", "trace.json")
    assert ran.code == 0, ran.err
    trace = trace_json.loads(example.read("trace.json").decode(), "trace.json")
    raised = moved(trace, "raise_both")
    assert {name.split("_")[0] for name in raised} == {"left", "right"}
    assert set(moved(trace, "close_left")) == {"left_gripper"}
