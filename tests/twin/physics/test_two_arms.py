"""A robot of two arms: each plans, moves, grasps and is watched for itself, and both together."""

import dataclasses

import numpy as np
import pytest

from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.motion import JointTrajectory, LinkTarget, PlanningError, Pose
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.simulation.twin import Twin

FLAT = (0.0, 0.0, 0.0)
NOWHERE = Scene("nowhere", "nothing", FLAT, FLAT, (), (), (), "nowhere.yaml")
ARMS = ("left_arm", "right_arm")


@pytest.fixture(scope="module")
def baxter() -> Robot:
    return load_robot("baxter")


def shifted(robot: Robot, group: str, by: float) -> dict[str, float]:
    return {name: robot.initial_state[name] + by for name in robot.groups[group].joints}


def run(twin: Twin, seconds: float) -> None:
    end = twin.time_ns + round(seconds * 1e9)
    while twin.time_ns < end:
        twin.advance(end)


def straight(twin: Twin, target: dict[str, float], seconds: float) -> JointTrajectory:
    state = twin.joint_state()
    here = dict(zip(state.names, state.position, strict=True))
    rows = np.array([[here[name] for name in target], list(target.values())])
    return JointTrajectory(tuple(target), np.array([0.0, seconds]), rows, np.zeros_like(rows))


def test_both_arms_are_the_joints_of_each(baxter: Robot):
    both = baxter.groups["both_arms"].joints
    assert set(both) == {joint for arm in ARMS for joint in baxter.groups[arm].joints}
    assert len(both) == 14
    assert [gripper.name for gripper in baxter.grippers] == ["left_gripper", "right_gripper"]


def test_one_search_brings_both_hands_to_poses_of_their_own(baxter: Robot):
    kinematics = Kinematics(baxter)
    generator = np.random.default_rng(4)
    hands = {arm: baxter.groups[arm].tip_link or "" for arm in ARMS}
    reached = 0
    for _ in range(10):
        joints = {}
        for name in baxter.groups["both_arms"].joints:
            joint = baxter.joint(name)
            joints[name] = float(generator.uniform(joint.lower, joint.upper))
        targets = [LinkTarget(link, kinematics.forward(joints, link)) for link in hands.values()]
        try:
            found = kinematics.inverse_all("both_arms", targets)
        except PlanningError:
            continue
        for target in targets:
            there = kinematics.forward(found, target.link)
            assert np.linalg.norm(np.subtract(there.position, target.pose.position)) < 1e-4
        reached += 1
    assert reached >= 9


def test_a_hand_out_of_reach_names_both_hands_and_poses(baxter: Robot):
    kinematics = Kinematics(baxter)
    near = LinkTarget("left_gripper", kinematics.forward({}, "left_gripper"))
    far = LinkTarget("right_gripper", Pose((5.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0)))
    with pytest.raises(PlanningError, match=r"'left_gripper' to .* and 'right_gripper' to \(5.000"):
        kinematics.inverse_all("both_arms", [near, far], restarts=1)


def test_an_arm_that_would_hit_the_other_is_reported(baxter: Robot):
    inwards = {**baxter.initial_state, "left_s0": -1.3}
    twin = Twin.build(dataclasses.replace(baxter, initial_state=inwards), NOWHERE)
    with pytest.raises(PlanningError, match=r"'left_.*'right_|'right_.*'left_") as caught:
        twin.plan_joints("right_arm", {"right_s0": 1.3})
    assert caught.value.failure == "collision"
    assert twin.plan_joints("right_arm", {"right_s0": 0.3}).duration_s > 0.0
    twin.close()


def test_arms_that_move_at_once_end_each_in_its_own_time(baxter: Robot):
    twin = Twin.build(baxter, NOWHERE)
    goals = {
        "left_arm": shifted(baxter, "left_arm", 0.2),
        "right_arm": shifted(baxter, "right_arm", -0.1),
    }
    left = twin.follow(straight(twin, goals["left_arm"], 1.0))
    run(twin, 0.3)
    right = twin.follow(straight(twin, goals["right_arm"], 2.0))
    while "active" in (left.outcome, right.outcome):
        twin.advance(10**13)
    assert (left.outcome, right.outcome) == ("succeeded", "succeeded")
    assert (left.ended_ns or 0) < (right.ended_ns or 0)
    state = twin.joint_state()
    here = dict(zip(state.names, state.position, strict=True))
    for goal in goals.values():
        assert {name: here[name] for name in goal} == pytest.approx(goal, abs=0.005)
    twin.close()


def test_a_new_motion_of_one_arm_preempts_nothing_of_the_other(baxter: Robot):
    twin = Twin.build(baxter, NOWHERE)
    left = twin.follow(straight(twin, shifted(baxter, "left_arm", 0.2), 2.0))
    right = twin.follow(straight(twin, shifted(baxter, "right_arm", 0.2), 2.0))
    run(twin, 0.5)
    again = twin.follow(straight(twin, shifted(baxter, "left_arm", -0.1), 1.0))
    assert (left.outcome, right.outcome) == ("preempted", "active")
    while "active" in (again.outcome, right.outcome):
        twin.advance(10**13)
    assert (again.outcome, right.outcome) == ("succeeded", "succeeded")
    twin.close()


def test_each_gripper_is_moved_and_watched_for_itself(baxter: Robot, tmp_path):
    twin = Twin.build(baxter, NOWHERE, samples=SampleWriter(tmp_path))
    motion = twin.move_gripper("left_hand", 0.0)
    while motion.outcome == "active":
        twin.advance(10**13)
    twin.close()
    activity = element_activity(read_samples(tmp_path), baxter)
    assert activity["left_gripper"].moving.any()
    assert not activity["right_gripper"].moving.any()
    arms = [joint.name for joint in baxter.arm_joints]
    assert not any(activity[name].moving.any() for name in arms)
