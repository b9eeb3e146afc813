"""Every shipped robot stands, moves, reaches and grasps."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.slow import slow_but
from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.shipped import shipped_hardware
from tracerisk.errors import RobotError
from tracerisk.twin.motion.clearance import Clearance
from tracerisk.twin.motion.execution import Motion
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.physics.motion import JointTrajectory, PlanningError, Pose
from tracerisk.twin.physics.scene import Fixture, GraspableObject, Scene, load_scene
from tracerisk.twin.recording.activity import element_activity
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots import robot as robot_module
from tracerisk.twin.robots.index import shipped_names
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Gripper, Scaling
from tracerisk.twin.simulation.twin import Twin

# After the twin, which says that no window is needed.
import mujoco  # isort: skip

NAMES = robot_names()
SOME = ("panda", "baxter", "fetch", "gen3", "j2n6s300", "px100", "so100", "ur5e")
"""Arms of four to seven joints, one with two arms, and with and without every kind of gripper."""
GRIPPERS = [(each.name, i) for each in shipped_names() for i in range(len(each.grippers))]
SOME_GRIPPERS = [("panda", 0), ("gen3", 0), ("j2n6s300", 0), ("so100", 0)]
"""Grippers that slide, and that turn on four hinges, with three fingers and with one."""
FLAT = (0.0, 0.0, 0.0)
NOWHERE = Scene("nowhere", "nothing", FLAT, FLAT, (), (), (), "nowhere.yaml")
GRAVITY = 9.81
GRASPED = 0.5  # what a pad feels that holds something, at least [N]
THINNEST = 0.004  # what is taken is at least this thick, by half [m]


def arm_groups(robot: Robot) -> list[str]:
    """The groups that have a tip and no finger."""
    held = {name for gripper in robot.grippers for name in gripper.joints}
    return [name for name, g in robot.groups.items() if g.tip_link and not held & set(g.joints)]


def carriers(robot: Robot, link: str) -> list[str]:
    """The joints that carry a link, from the base on."""
    hung = {each.child: each for each in robot.attachments}
    found: list[str] = []
    while link in hung:
        found.insert(0, hung[link].name)
        link = hung[link].parent
    return found


def arm_of(robot: Robot, gripper: Gripper) -> str:
    """The group of the arm that carries a gripper; of several, that with the fewest joints."""
    carrying = set(carriers(robot, gripper.pads[0]))
    fitting = [name for name in arm_groups(robot) if set(robot.groups[name].joints) <= carrying]
    return min(fitting, key=lambda name: len(robot.groups[name].joints))


def settle(twin: Twin, seconds: float) -> None:
    end = twin.time_ns + round(seconds * 1e9)
    while twin.time_ns < end:
        twin.advance(end)


def measured(twin: Twin) -> dict[str, float]:
    state = twin.joint_state()
    return dict(zip(state.names, state.position, strict=True))


def straight_to(twin: Twin, target: Mapping[str, float]) -> None:
    """Go there as fast as the joints are rated for, and never faster or further than that."""
    here = measured(twin)
    names = tuple(target)
    rows = np.array([[here[name] for name in names], [target[name] for name in names]])
    path = JointTrajectory(names, np.array([0.0, 1.0]), rows, np.zeros_like(rows))
    motion = twin.follow(twin.retime(path, scaling=Scaling(1.0, 1.0)))
    limits = [twin.robot.joint(name) for name in twin.joint_state().names]
    fingers = {name for gripper in twin.robot.grippers for name in gripper.joints}
    while motion.outcome == "active":
        twin.advance(twin.time_ns + 20_000_000)
        state = twin.joint_state()
        for joint, value, speed in zip(limits, state.position, state.velocity, strict=True):
            if joint.name not in fingers:
                assert joint.lower - 0.01 <= value <= joint.upper + 0.01, joint.name
                assert abs(speed) <= 1.05 * joint.velocity_limit, joint.name
    assert motion.outcome == "succeeded", motion.message


def finish(twin: Twin, motion: Motion) -> Motion:
    while motion.outcome == "active":
        twin.advance(10**13)
    return motion


def gravity_torques(robot: Robot, at: Mapping[str, float]) -> dict[str, float]:
    """The torque of each arm joint that carries the links: the slope of their potential energy."""
    kinematics = Kinematics(robot)

    def energy(positions: Mapping[str, float]) -> float:
        poses = kinematics.forward_all(positions)
        total = 0.0
        for link in robot.links:
            pose = poses[link.name]
            height = pose.position[2] + turned(pose, link.centre_of_mass)[2]
            total += link.mass * GRAVITY * height
        return total

    step = 1e-4
    return {
        joint.name: (
            energy({**at, joint.name: at[joint.name] + step})
            - energy({**at, joint.name: at[joint.name] - step})
        )
        / (2 * step)
        for joint in robot.arm_joints
    }


def turned(pose: Pose, vector: Sequence[float]) -> np.ndarray:
    x, y, z, w = pose.orientation
    found = np.zeros(3)
    mujoco.mju_rotVecQuat(found, np.array(vector), np.array([w, x, y, z]))
    return found


@pytest.mark.parametrize("name", NAMES)
def test_it_builds_and_its_data_are_whole(name: str):
    robot = load_robot(name)
    assert robot.name == name
    assert "/" in robot.source
    assert load_scene(robot.default_scene or "")
    Kinematics(robot).forward({}, robot.link_names[-1])
    for controller in robot.controllers:
        assert controller.joints
    for joint in robot.joints:
        assert 0.0 < joint.velocity_limit < 20.0
        assert 0.0 < joint.torque_limit < 3000.0


@pytest.mark.parametrize("name", NAMES)
def test_its_hardware_fits_and_says_what_is_assumed(name: str):
    robot = load_robot(name)
    hardware = shipped_hardware(name)
    bound = {each.component.name: each for each in bind(hardware, robot.elements)}
    assert bound["electric_motor"].quantity == len(robot.arm_joints)
    assert (name == "panda") == (not (hardware.source or "").startswith("assumed"))


@pytest.mark.parametrize("name", slow_but(SOME, NAMES))
def test_it_stands_still_at_its_named_states(name: str):
    robot = load_robot(name)
    fingers = {joint for gripper in robot.grippers for joint in gripper.joints}
    for group, states in robot.named_states.items():
        for state, positions in states.items():
            arm = {joint: value for joint, value in positions.items() if joint not in fingers}
            twin = Twin.build(robot, NOWHERE)
            if arm:
                straight_to(twin, arm)
            for gripper in robot.grippers:
                if positions.keys() & set(gripper.joints):
                    wanted = gripper.position(positions)
                    motion = finish(twin, twin.move_gripper(gripper.name, wanted))
                    assert motion.outcome == "succeeded", (state, motion.message)
                    assert not motion.stalled, (state, motion.message)
                    slides = robot.joint(gripper.joints[0]).type == "prismatic"
                    near = 0.0005 if slides else 0.01  # half a millimetre, at the pads of hinges
                    assert gripper.position(measured(twin)) == pytest.approx(wanted, abs=near)
            settle(twin, 1.0)
            before = measured(twin)
            settle(twin, 1.0)
            for joint, value in measured(twin).items():
                assert value == pytest.approx(before[joint], abs=1e-4), (group, state, joint)
                if joint in arm:
                    assert value == pytest.approx(arm[joint], abs=0.005), (group, state, joint)
            check_torques(robot, twin)
            twin.close()


def check_torques(robot: Robot, twin: Twin) -> None:
    """The motors give what the weight of the links asks for, and have some torque left."""
    state = twin.joint_state()
    torque = dict(zip(state.names, state.effort, strict=True))
    for joint, needed in gravity_torques(robot, measured(twin)).items():
        limit = robot.joint(joint).torque_limit
        assert torque[joint] == pytest.approx(needed, rel=0.02, abs=0.01 * limit), joint
        assert abs(needed) < 0.9 * limit, joint


@pytest.mark.parametrize("count", [10, pytest.param(100, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", slow_but(SOME, NAMES))
def test_inverse_kinematics_reach_what_the_arm_reaches(name: str, count: int):
    robot = load_robot(name)
    kinematics = Kinematics(robot)
    generator = np.random.default_rng(1)
    for group in arm_groups(robot):
        tip = robot.groups[group].tip_link
        assert tip is not None
        limits = [robot.joint(joint) for joint in robot.groups[group].joints]
        reached = 0
        for _ in range(count):
            joints = {one.name: float(generator.uniform(one.lower, one.upper)) for one in limits}
            pose = kinematics.forward(joints, tip)
            try:
                found = kinematics.inverse(group, pose)
            except PlanningError:
                continue
            there = kinematics.forward(found, tip)
            assert there.position == pytest.approx(pose.position, abs=1e-3)
            assert abs(np.dot(there.orientation, pose.orientation)) > 1.0 - 1e-5
            reached += all(
                one.type == "continuous" or one.lower <= found[one.name] <= one.upper
                for one in limits
            )
        assert reached >= 0.95 * count, group


@pytest.mark.parametrize(("name", "index"), slow_but(SOME_GRIPPERS, GRIPPERS))
def test_its_gripper_picks_a_light_object_up(name: str, index: int, tmp_path: Path):
    robot = load_robot(name)
    gripper = robot.grippers[index]
    closed, opened, half = finger_ends(robot, gripper)
    low, high, middle, sides = ready_to_lift(robot, gripper, opened)
    # Two pads take a ball; more take a bar that lies before all of them.
    ball = len(gripper.pads) == 2
    shape = Shape("sphere", (half,)) if ball else Shape("box", (half, 0.035, 0.012))
    height = half if ball else 0.012
    thing = GraspableObject("thing", middle, (0.0, 0.0, sides), 0.025, 0.5, (shape,))
    pole = Fixture(
        "pole", (middle[0], middle[1], middle[2] - height - 0.03), FLAT,
        (Shape("cylinder", (0.003, 0.03)),),
    )  # fmt: skip
    scene = Scene("pick", "something on a pole", FLAT, FLAT, (pole,), (thing,), (), "pick.yaml")
    fingers = {joint: gripper.sign(joint) * opened for joint in gripper.joints}
    writer = SampleWriter(tmp_path)
    twin = Twin.build(standing_at(robot, {**low, **fingers}), scene, samples=writer)
    settle(twin, 0.1)
    motion = finish(twin, twin.move_gripper(gripper.name, closed))
    assert motion.stalled, motion.message
    slides = robot.joint(gripper.joints[0]).type == "prismatic"
    assert (" rad" in motion.message) != slides
    at_first = np.array(twin.object_pose("thing").position)
    beside = at_first - pad_middle(robot, gripper, measured(twin))
    straight_to(twin, high)
    settle(twin, 1.0)
    held = np.array(twin.object_pose("thing").position)
    assert held[2] > at_first[2] + 0.02
    slipped = np.linalg.norm(held - pad_middle(robot, gripper, measured(twin)))
    assert slipped == pytest.approx(np.linalg.norm(beside), abs=0.006)
    settle(twin, 1.0)
    later = np.array(twin.object_pose("thing").position)
    # Fingers on hinges stand at an angle to one another, and hold as long all the same.
    assert later == pytest.approx(held, abs=1e-3 if slides else 3e-4)
    twin.close()
    samples = read_samples(tmp_path)
    columns = [samples.header.pads.index(pad) for pad in gripper.pads]
    in_hand = samples.pad_force[-round(1.0 / samples.step_s) :, columns]
    assert in_hand.min() > GRASPED, "every pad holds it, all the time"
    grasping = element_activity(samples, robot)[gripper.name].grasping
    assert np.count_nonzero(np.diff(grasping)) == 1, "one grasp, which lasts to the end"
    assert grasping[-1]


def standing_at(robot: Robot, positions: dict[str, float]) -> Robot:
    return dataclasses.replace(robot, initial_state={**robot.initial_state, **positions})


def pad_middle(robot: Robot, gripper: Gripper, at: Mapping[str, float]) -> np.ndarray:
    """The place between the first pad and those that face it."""
    first, *others = pad_places(Kinematics(robot), robot, gripper, at)
    return (first + np.mean(others, axis=0)) / 2


def pad_places(
    kinematics: Kinematics, robot: Robot, gripper: Gripper, at: Mapping[str, float]
) -> list[np.ndarray]:
    """The middles of the pads in the frame of the base."""
    links = {link.name: link for link in robot.links}
    found = []
    for link in gripper.pads:
        pad = next(shape for shape in links[link].shapes if shape.pad)
        pose = kinematics.forward(at, link)
        found.append(np.array(pose.position) + turned(pose, pad.xyz))
    return found


def finger_ends(robot: Robot, gripper: Gripper) -> tuple[float, float, float]:
    """The closed position, one that is open, and half the thickness of what to take."""
    kinematics = Kinematics(robot)
    enough = 0.036 if len(gripper.pads) == 2 else 0.06

    def gap(value: float) -> float:
        at = {joint: gripper.sign(joint) * value for joint in gripper.joints}
        first, *others = pad_places(kinematics, robot, gripper, at)
        return float(np.linalg.norm(first - np.mean(others, axis=0)))

    values = np.linspace(gripper.least, gripper.opening, 40)
    gaps = [gap(float(value)) for value in values]
    closed = float(values[int(np.argmin(gaps))])
    wide = [value for value, width in zip(values, gaps, strict=True) if width >= enough]
    opened = min(wide, key=lambda value: abs(value - closed), default=values[int(np.argmax(gaps))])
    half = min(0.012, (gap(float(opened)) - 0.012) / 2)
    assert half >= THINNEST
    return closed, float(opened), half


def ready_to_lift(
    robot: Robot, gripper: Gripper, opened: float
) -> tuple[dict[str, float], dict[str, float], tuple[float, float, float], float]:
    """Two places of the arm, the second higher; where the pads are in the first, and their yaw.

    In the first the pads are side by side and the hand is above them.
    """
    kinematics, clearance = Kinematics(robot), Clearance(robot)
    generator = np.random.default_rng(3)
    fingers = {joint: gripper.sign(joint) * opened for joint in gripper.joints}
    joints = robot.groups[arm_of(robot, gripper)].joints
    limits = [robot.joint(joint) for joint in joints]
    wrist = next(a.child for a in robot.attachments if a.name == joints[-1])
    best = None
    for _ in range(1500):
        low = {one.name: float(generator.uniform(one.lower, one.upper)) for one in limits}
        at = {**low, **fingers}
        first, *others = pad_places(kinematics, robot, gripper, at)
        across = np.mean(others, axis=0) - first
        if np.hypot(*(first + across / 2)[:2]) < 0.12:
            continue  # there the object would stand in the arm
        down = np.array(kinematics.forward(at, wrist).position) - first - across / 2
        score = abs(across[2]) / np.linalg.norm(across) - down[2] / np.linalg.norm(down)
        if len(others) > 1:
            along = others[1] - others[0]
            score += abs(along[2]) / np.linalg.norm(along)
        if (best is None or score < best[0]) and clearance.collision(at) is None:
            best = (score, low, first + across / 2, math.atan2(across[1], across[0]))
    assert best is not None
    _, low, middle, sides = best
    for size in (0.15, 0.3, 0.6):
        for _ in range(200):
            high = {
                one.name: float(
                    np.clip(low[one.name] + generator.uniform(-size, size), one.lower, one.upper)
                )
                for one in limits
            }
            places = pad_places(kinematics, robot, gripper, {**high, **fingers})
            if 0.03 < np.mean(places, axis=0)[2] - middle[2] < 0.12:
                x, y, z = (float(value) for value in middle)
                return low, high, (x, y, z), sides
    raise AssertionError("no way up was found")


def test_a_sign_that_is_none_is_reported(tmp_path):
    text = (Path(robot_module.__file__).parent / "shipped" / "wx250.yaml").read_text(
        encoding="utf-8"
    )
    path = tmp_path / "arm.yaml"
    path.write_text(text.replace("signs: [1, -1]", "signs: [1, 2]"), encoding="utf-8")
    with pytest.raises(RobotError, match="each is 1 or -1"):
        load_robot(path)


@pytest.mark.parametrize("name", robot_names())
def test_states_of_one_group_are_different_places(name: str):
    for states in load_robot(name).named_states.values():
        hands = [dict(states[state]) for state in ("open", "close") if state in states]
        assert len(hands) < 2 or hands[0] != hands[1]
