"""Single motions, and the physics under them."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError
from tracerisk.twin.physics.scene import load_scene
from tracerisk.twin.robots.robot import Robot, load_robot
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.simulation.twin import Twin

import mujoco  # isort: skip

SECOND = 1_000_000_000
FOREVER = 10**12


@pytest.fixture
def free(panda: Robot) -> Twin:
    return Twin.build(panda, load_scene("empty"))


def go_to_state(twin: Twin, name: str):
    plan = twin.plan_joints(
        "panda_arm",
        twin.robot.named_states["panda_arm"][name],
        scaling=Scaling(0.5, 0.5),
    )
    motion = twin.follow(plan)
    while motion.outcome == "active":
        twin.advance(FOREVER)
    return motion


@pytest.mark.parametrize("state", ["ready", "extended", "transport"])
def test_the_arm_stands_still_at_its_named_states(free: Twin, state: str):
    assert go_to_state(free, state).outcome == "succeeded"
    free.advance(free.time_ns + SECOND)
    before = np.array(free.joint_state().position)
    free.advance(free.time_ns + 2 * SECOND)
    after = free.joint_state()
    assert np.abs(np.array(after.position) - before).max() < 1e-5
    wanted = free.robot.named_states["panda_arm"][state]
    for name, value in wanted.items():
        assert after.position[after.names.index(name)] == pytest.approx(value, abs=1e-3)


@pytest.mark.parametrize("state", ["ready", "extended"])
def test_the_holding_torque_is_the_torque_of_gravity(free: Twin, panda: Robot, state: str):
    go_to_state(free, state)
    free.advance(free.time_ns + 2 * SECOND)
    held = free.joint_state()
    model = compile_model(panda)
    data = mujoco.MjData(model)
    dofs = []
    for name, value in zip(held.names, held.position, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = value
        dofs.append(int(model.joint(name).dofadr[0]))
    mujoco.mj_inverse(model, data)
    gravity = data.qfrc_inverse[dofs]
    arm = len(panda.arm_joints)
    assert np.array(held.effort)[:arm] == pytest.approx(gravity[:arm], abs=0.02)
    # The joints carry the arm: this is no comparison of zeros.
    assert np.abs(gravity[:arm]).max() > 4.0


def test_a_motion_takes_as_long_as_its_trajectory(free: Twin):
    plan = free.plan_joints(
        "panda_arm",
        {"panda_joint1": 0.5},
        scaling=Scaling(0.2, 0.2),
    )
    motion = free.follow(plan)
    assert free.busy
    reached = free.advance(FOREVER)
    assert motion.outcome == "succeeded"
    assert not free.busy
    assert motion.ended_ns == reached == free.time_ns
    assert motion.ended_ns * 1e-9 == pytest.approx(plan.duration_s, abs=0.3)


def test_the_arm_keeps_to_its_trajectory(free: Twin):
    plan = free.plan_joints(
        "panda_arm",
        free.robot.named_states["panda_arm"]["ready"],
        scaling=Scaling(0.5, 0.5),
    )
    free.follow(plan)
    for at, wanted in list(zip(plan.time, plan.position, strict=True))[10:-10:10]:
        free.advance(round(at * 1e9))
        found = free.joint_state()
        measured = [found.position[found.names.index(name)] for name in plan.joints]
        slack = 0.01 + 0.003 * np.abs(plan.velocity).max()
        assert measured == pytest.approx(wanted, abs=slack)


def test_no_joint_is_driven_beyond_its_rated_speed_or_torque(free: Twin, panda: Robot):
    plan = free.plan_joints(
        "panda_arm",
        free.robot.named_states["panda_arm"]["extended"],
        scaling=Scaling(1.0, 1.0),
    )
    motion = free.follow(plan)
    while motion.outcome == "active":
        free.advance(free.time_ns + 10_000_000)
        state = free.joint_state()
        for joint in panda.arm_joints:
            i = state.names.index(joint.name)
            assert abs(state.velocity[i]) <= 1.05 * joint.velocity_limit
            assert abs(state.effort[i]) <= joint.torque_limit + 1e-9
    assert motion.outcome == "succeeded"


def test_a_new_motion_preempts_the_old(free: Twin):
    first = free.follow(free.plan_joints("panda_arm", {"panda_joint1": 1.0}))
    free.advance(SECOND)
    second = free.follow(free.plan_joints("panda_arm", {"panda_joint1": 0.0}))
    assert (first.outcome, first.ended_ns) == ("preempted", SECOND)
    while second.outcome == "active":
        free.advance(FOREVER)
    assert second.outcome == "succeeded"


def test_a_gripper_and_an_arm_move_at_the_same_time(free: Twin):
    arm = free.follow(free.plan_joints("panda_arm", {"panda_joint1": 0.3}))
    hand = free.move_gripper("panda_hand", 0.03)
    assert (arm.outcome, hand.outcome) == ("active", "active")
    free.advance(FOREVER)
    assert (arm.outcome, hand.outcome) == ("active", "succeeded")
    free.advance(FOREVER)
    assert arm.outcome == "succeeded"
    assert arm.elements == tuple(f"panda_joint{i}" for i in range(1, 8))
    assert hand.elements == ("panda_hand",)


def test_stop_brings_the_arm_to_rest_without_a_jerk(free: Twin, panda: Robot):
    motion = free.follow(
        free.plan_joints("panda_arm", {"panda_joint1": 2.0}, scaling=Scaling(0.5, 1.0))
    )
    free.advance(SECOND)
    speed = free.joint_state().velocity[0]
    assert speed > 0.5
    free.stop()
    assert motion.outcome == "preempted"
    assert not free.busy
    at = free.joint_state().position[0]
    free.advance(2 * SECOND)
    after = free.joint_state()
    assert abs(after.velocity[0]) < 1e-3
    rated = panda.joint("panda_joint1").acceleration_limit
    assert after.position[0] - at == pytest.approx(speed**2 / (2 * rated), rel=0.2)


def test_a_trajectory_that_begins_later_is_reached_from_where_the_arm_is(free: Twin):
    names = tuple(joint.name for joint in free.robot.arm_joints)
    goal = np.array([[0.4, -0.5, 0.0, -2.4, 0.0, 2.0, 0.8]])
    motion = free.follow(JointTrajectory(names, np.array([2.0]), goal, np.zeros((1, 7))))
    free.advance(SECOND)
    assert 0.1 < free.joint_state().position[0] < 0.3
    free.advance(FOREVER)
    assert motion.outcome == "succeeded"
    assert free.joint_state().position[0] == pytest.approx(0.4, abs=0.005)


BELOW_ITS_BASE = [0.0, 1.6, 0.0, -1.0, 0.0, 2.0, 0.8]


def moved(twin: Twin, goal: list[float]) -> Motion:
    """Return the motion of the whole arm to a goal [rad], when it has ended."""
    names = tuple(joint.name for joint in twin.robot.arm_joints)
    path = JointTrajectory(names, np.array([3.0]), np.array([goal]), np.zeros((1, 7)))
    motion = twin.follow(path)
    while motion.outcome == "active":
        twin.advance(FOREVER)
    return motion


def test_where_no_scene_is_asked_for_nothing_is_in_the_way_of_the_arm(free: Twin):
    assert free.scene.name == free.robot.default_scene
    assert moved(free, BELOW_ITS_BASE).outcome == "succeeded"


def test_an_arm_that_is_blocked_aborts_and_names_the_joint_and_what_is_in_the_way(panda: Robot):
    motion = moved(Twin.build(panda, load_scene("floor")), BELOW_ITS_BASE)
    assert motion.outcome == "aborted"
    assert "from its goal 1 s after the trajectory ended (tolerance 0.005)" in motion.message
    assert re.search(r"; 'panda_\w+' presses on 'floor'$", motion.message)
    assert motion.ended_ns is not None
    assert 3.9 < motion.ended_ns * 1e-9 < 4.2


def test_a_goal_past_a_limit_is_aborted_and_names_the_limit(free: Twin):
    motion = moved(free, [0.0, -0.7, 0.0, 0.1, 0.0, 1.5, 0.7])
    assert motion.outcome == "aborted"
    assert motion.message.endswith("; its goal is 0.1, past its limits [-3.0718, -0.0698]")


@pytest.mark.parametrize(
    ("time", "position", "message"),
    [
        ([0.0, 0.0], [[0.0], [1.0]], "must rise"),
        ([-1.0, 0.0], [[0.0], [1.0]], "must rise"),
        ([0.0, 1.0], [[0.0], [np.nan]], "not finite"),
        ([0.0, 1.0, 2.0], [[0.0], [1.0]], "3 points of 1 joints"),
        ([], np.zeros((0, 1)), "no points"),
        ([0.0, 1e9], [[0.0], [1.0]], r"lasts 1e\+09 s; at most 1800 s"),
    ],
)
def test_what_is_no_trajectory_is_refused(free: Twin, time, position, message: str):
    array = np.array(position)
    bad = JointTrajectory(("panda_joint1",), np.array(time), array, np.zeros_like(array))
    with pytest.raises(PlanningError, match=message) as caught:
        free.follow(bad)
    assert caught.value.failure == "bad_request"
    assert not free.busy


def test_unknown_joints_are_listed(free: Twin):
    with pytest.raises(RobotError, match="no joint 'elbow'; allowed: panda_finger_joint1"):
        free.stop(["elbow"])
    bad = JointTrajectory(("elbow",), np.array([0.0]), np.zeros((1, 1)), np.zeros((1, 1)))
    with pytest.raises(PlanningError, match="no joint 'elbow'"):
        free.follow(bad)


@pytest.mark.parametrize(
    ("position", "effort", "message"),
    [(0.05, None, r"outside \[0, 0.04\]"), (0.02, 0.0, "give more than 0")],
)
def test_what_a_gripper_cannot_do_is_refused(free: Twin, position, effort, message: str):
    with pytest.raises(PlanningError, match=message):
        free.move_gripper("panda_hand", position, max_effort=effort)


def test_fingers_move_alike_and_reach_their_goal(free: Twin):
    motion = free.move_gripper("hand", 0.03)
    free.advance(FOREVER)
    assert (motion.outcome, motion.stalled) == ("succeeded", False)
    fingers = free.joint_state().position[-2:]
    assert fingers == pytest.approx((0.03, 0.03), abs=5e-4)


def test_a_trajectory_of_the_fingers_moves_the_gripper(free: Twin):
    open_hand = free.robot.named_states["hand"]["open"]
    motion = free.follow(free.plan_joints("hand", open_hand))
    free.advance(FOREVER)
    assert (motion.outcome, motion.elements) == ("succeeded", ("panda_hand",))
    assert free.joint_state().position[-1] == pytest.approx(0.035, abs=5e-4)


def test_fingers_take_the_time_that_a_trajectory_gives_them(free: Twin):
    fingers = ("panda_finger_joint1", "panda_finger_joint2")
    motion = free.follow(
        JointTrajectory(fingers, np.array([3.0]), np.full((1, 2), 0.03), np.zeros((1, 2)))
    )
    assert free.advance(5_000_000_000) == pytest.approx(3e9, abs=2e8)
    assert motion.outcome == "succeeded"


def test_fingers_that_are_asked_to_go_too_fast_take_longer(free: Twin):
    fingers = ("panda_finger_joint1", "panda_finger_joint2")
    begin = free.joint_state().position[-1]
    goal = 0.035 if begin < 0.02 else 0.005
    least_s = abs(goal - begin) / free.robot.grippers[0].velocity_limit
    free.follow(JointTrajectory(fingers, np.array([0.01]), np.full((1, 2), goal), np.zeros((1, 2))))
    assert 1e9 * least_s < free.advance(5_000_000_000) < 3e9 * least_s
    assert free.joint_state().position[-1] == pytest.approx(goal, abs=1e-3)


def test_fingers_go_through_every_point_of_a_trajectory(free: Twin):
    fingers = ("panda_finger_joint1", "panda_finger_joint2")
    begin = free.joint_state().position[-1]
    away = begin + 0.02 if begin < 0.02 else begin - 0.02
    points = np.array([[away, away], [begin, begin]])
    motion = free.follow(JointTrajectory(fingers, np.array([2.0, 4.0]), points, np.zeros((2, 2))))
    free.advance(2_000_000_000)
    assert free.joint_state().position[-2:] == pytest.approx((away, away), abs=1e-3)
    assert free.advance(6_000_000_000) == pytest.approx(4e9, abs=2e8)
    assert motion.outcome == "succeeded"


def test_fingers_that_a_trajectory_sends_beyond_their_range_stop_at_its_end(free: Twin):
    fingers = free.robot.grippers[0].joints
    far = np.full((1, len(fingers)), -0.09)
    motion = free.follow(JointTrajectory(fingers, np.array([1.0]), far, np.zeros_like(far)))
    free.advance(FOREVER)
    assert motion.outcome == "succeeded"
    assert free.joint_state().position[-1] == pytest.approx(0.0, abs=5e-4)


def test_a_trajectory_moves_a_gripper_that_is_called_as_its_finger_is(panda: Robot):
    finger = panda.grippers[0].joints[0]
    named = replace(panda, grippers=(replace(panda.grippers[0], name=finger),))
    twin = Twin.build(named, load_scene("empty"))
    position = np.array([[0.01]])
    motion = twin.follow(JointTrajectory((finger,), np.array([0.5]), position, np.zeros((1, 1))))
    twin.advance(FOREVER)
    assert motion.outcome == "succeeded"
    state = dict(zip(twin.joint_state().names, twin.joint_state().position, strict=True))
    assert state[finger] == pytest.approx(0.01, abs=1e-3)


@pytest.mark.parametrize(("pressed", "measured"), [(-0.0005, 0.0), (-0.01, -0.01)])
def test_a_finger_that_is_pressed_on_its_stop_is_measured_there(panda: Robot, pressed, measured):
    finger = panda.grippers[0].joints[0]
    begin = {**panda.initial_state, finger: pressed}
    twin = Twin.build(replace(panda, initial_state=begin), load_scene("empty"))
    state = dict(zip(twin.joint_state().names, twin.joint_state().position, strict=True))
    assert state[finger] == pytest.approx(measured, abs=1e-9)


def test_planning_moves_nothing(free: Twin):
    before = free.joint_state()
    free.plan_joints("panda_arm", free.robot.named_states["panda_arm"]["ready"])
    free.inverse_kinematics("panda_arm", free.link_pose("panda_link8"))
    free.forward_kinematics({"panda_joint1": 1.0}, "panda_link8")
    assert free.joint_state() == before
    assert free.time_ns == 0


def test_time_stops_at_the_time_asked_for(free: Twin):
    assert free.advance(1) == free.step_ns
    assert free.advance(5 * free.step_ns) == 5 * free.step_ns
    assert free.advance(0) == 5 * free.step_ns


def test_a_simulation_that_blows_up_is_reported(free: Twin):
    free._simulation._data.qvel[0] = 1e12
    with pytest.raises(RobotError, match=r"became unstable at \d"):
        free.advance(SECOND)


def test_a_line_goes_on_where_the_range_of_a_joint_without_end_ends():
    """joint_1 of the Gen3 turns for ever; its positions are kept within a turn either way."""
    twin = Twin.build(load_robot("gen3"), load_scene("empty"))
    group, members = max(twin.robot.groups.items(), key=lambda each: len(each[1].joints))
    turning = twin.robot.joint(members.joints[0])
    assert turning.type == "continuous"
    bent = dict(
        zip(members.joints, [turning.upper - 0.05, 0.3, 3.14, -2.2, 0, 0.9, 1.57], strict=True)
    )
    here = twin.forward_kinematics(bent, members.tip_link)
    x, y, z = here.position
    goal = replace(here, position=(x, y - 0.1, z))
    path, fraction = twin.plan_cartesian(group, [goal], start=bent)
    assert fraction == 1.0
    assert np.abs(np.diff(path.position, axis=0)).max() < 0.1
    assert path.position[-1][0] > turning.upper
    end = dict(zip(path.joints, path.position[-1].tolist(), strict=True))
    assert (
        twin.plan_joints(group, {members.joints[1]: 0.2}, start=end).position[-1][0]
        == end[turning.name]
    )
