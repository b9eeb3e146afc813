"""Every shipped robot stands, moves, reaches and grasps."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tracerisk.errors import RobotError
from tracerisk.hardware.binding import bind
from tracerisk.hardware.shipped import shipped_hardware
from tracerisk.twin import robot as robot_module
from tracerisk.twin.kinematics import Kinematics
from tracerisk.twin.motion import JointTrajectory, PlanningError
from tracerisk.twin.robot import Gripper, Robot, load_robot, robot_names
from tracerisk.twin.scene import Fixture, GraspableObject, Scene, load_scene
from tracerisk.twin.shapes import Shape
from tracerisk.twin.twin import Twin

# After the twin, which says that no window is needed.
import mujoco  # isort: skip

NAMES = robot_names()
QUICK = ("ur5e", "wx250")
# Fingers on linkages or hinges: they open and close, but do not hold a ball between pads.
HINGED = {"gen3", "so100", "xarm6", "xarm7"}
FLAT = (0.0, 0.0, 0.0)
NOWHERE = Scene("nowhere", "nothing", FLAT, FLAT, (), (), (), "nowhere.yaml")


def some(names: tuple[str, ...]) -> list[object]:
    """All of them, those that are not among the quick ones marked slow."""
    return [
        pytest.param(name, marks=() if name in QUICK else (pytest.mark.slow,)) for name in names
    ]


def with_gripper() -> tuple[str, ...]:
    return tuple(name for name in NAMES if name not in HINGED and load_robot(name).grippers)


def arm_groups(robot: Robot) -> list[str]:
    """The groups that have a tip and no finger."""
    held = {name for gripper in robot.grippers for name in gripper.joints}
    return [name for name, g in robot.groups.items() if g.tip_link and not held & set(g.joints)]


def settle(twin: Twin, seconds: float) -> None:
    end = twin.time_ns + round(seconds * 1e9)
    while twin.time_ns < end:
        twin.advance(end)


def straight_to(twin: Twin, target: dict[str, float], seconds: float) -> None:
    state = twin.joint_state()
    here = dict(zip(state.names, state.position, strict=True))
    names = tuple(target)
    rows = np.array([[here[name] for name in names], [target[name] for name in names]])
    rest = np.zeros_like(rows)
    motion = twin.follow(JointTrajectory(names, np.array([0.0, seconds]), rows, rest))
    while motion.outcome == "active":
        twin.advance(10**13)
    assert motion.outcome == "succeeded", motion.message


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


@pytest.mark.parametrize("name", some(NAMES))
def test_it_stands_still_at_its_named_states(name: str):
    robot = load_robot(name)
    for group, states in robot.named_states.items():
        for state, positions in states.items():
            if not set(positions) <= {joint.name for joint in robot.arm_joints}:
                continue
            twin = Twin.build(robot, NOWHERE)
            straight_to(twin, dict(positions), 6.0)
            settle(twin, 0.5)
            measured = twin.joint_state()
            for joint, value, speed in zip(
                measured.names, measured.position, measured.velocity, strict=True
            ):
                if joint in positions:
                    assert value == pytest.approx(positions[joint], abs=0.005), (group, state)
                assert abs(speed) < 0.01 * robot.joint(joint).velocity_limit, (state, joint)
            for joint, torque in zip(measured.names, measured.effort, strict=True):
                assert abs(torque) <= robot.joint(joint).torque_limit
            twin.close()


@pytest.mark.parametrize("name", some(NAMES))
def test_inverse_kinematics_reach_what_the_arm_reaches(name: str):
    robot = load_robot(name)
    kinematics = Kinematics(robot)
    generator = np.random.default_rng(1)
    group = arm_groups(robot)[0]
    tip = robot.groups[group].tip_link
    assert tip is not None
    reached = 0
    for _ in range(100):
        joints = {
            joint: float(generator.uniform(robot.joint(joint).lower, robot.joint(joint).upper))
            for joint in robot.groups[group].joints
        }
        try:
            found = kinematics.inverse(group, kinematics.forward(joints, tip))
        except PlanningError:
            continue
        reached += all(
            robot.joint(joint).lower <= value <= robot.joint(joint).upper
            for joint, value in found.items()
        )
    assert reached >= 95


@pytest.mark.parametrize("name", some(with_gripper()))
def test_its_gripper_lifts_a_light_ball(name: str):
    robot = load_robot(name)
    gripper = robot.grippers[0]
    closed, opened, radius = finger_ends(robot, gripper)
    low, high, between, _ = ready_to_lift(robot, gripper, opened)
    ball = GraspableObject("ball", between, FLAT, 0.025, 0.5, (Shape("sphere", (radius,)),))
    pole = Fixture(
        "pole", (between[0], between[1], between[2] - radius - 0.03), FLAT,
        (Shape("cylinder", (0.003, 0.03)),),
    )  # fmt: skip
    scene = Scene("ball", "a ball", FLAT, FLAT, (pole,), (ball,), (), "ball.yaml")
    fingers = {joint: gripper.sign(joint) * opened for joint in gripper.joints}
    twin = Twin.build(standing_at(robot, {**low, **fingers}), scene)
    settle(twin, 0.1)
    motion = twin.move_gripper(gripper.name, closed)
    while motion.outcome == "active":
        twin.advance(10**13)
    assert motion.stalled, motion.message
    at_first = twin.object_pose("ball").position
    straight_to(twin, high, 3.0)
    settle(twin, 0.5)
    assert twin.object_pose("ball").position[2] > at_first[2] + 0.02
    twin.close()


def standing_at(robot: Robot, positions: dict[str, float]) -> Robot:
    return dataclasses.replace(robot, initial_state={**robot.initial_state, **positions})


def pad_middle(robot: Robot, kinematics: Kinematics, at: dict[str, float]) -> np.ndarray:
    return np.mean(pad_places(robot, kinematics, at), axis=0)


def pad_places(robot: Robot, kinematics: Kinematics, at: dict[str, float]) -> list[np.ndarray]:
    """The middles of the pads in the frame of the base."""
    found = []
    links = {link.name: link for link in robot.links}
    for link in robot.grippers[0].pads:
        pose = kinematics.forward(at, link)
        x, y, z, w = pose.orientation
        pad = next(shape for shape in links[link].shapes if shape.pad)
        turned = np.zeros(3)
        mujoco.mju_rotVecQuat(turned, np.array(pad.xyz), np.array([w, x, y, z]))
        found.append(np.array(pose.position) + turned)
    return found


def finger_ends(robot: Robot, gripper: Gripper) -> tuple[float, float, float]:
    """The closed position, one that is open by about 40 mm, and the radius of a ball to take."""
    kinematics = Kinematics(robot)

    def gap(value: float) -> float:
        at = {joint: gripper.sign(joint) * value for joint in gripper.joints}
        places = pad_places(robot, kinematics, at)
        return float(np.linalg.norm(places[0] - places[1]))

    values = np.linspace(gripper.least, gripper.opening, 40)
    gaps = [gap(float(value)) for value in values]
    closed = float(values[int(np.argmin(gaps))])
    wide = [value for value, width in zip(values, gaps, strict=True) if width >= 0.036]
    opened = min(wide, key=lambda value: abs(value - closed), default=values[int(np.argmax(gaps))])
    return closed, float(opened), min(0.012, (gap(float(opened)) - 0.012) / 2)


def ready_to_lift(
    robot: Robot, gripper: Gripper, opened: float
) -> tuple[dict[str, float], dict[str, float], tuple[float, float, float], float]:
    """Two places of the arm, the second higher, with the pads side by side in the first."""
    kinematics = Kinematics(robot)
    generator = np.random.default_rng(3)
    fingers = {joint: gripper.sign(joint) * opened for joint in gripper.joints}
    joints = robot.groups[arm_groups(robot)[0]].joints
    limits = [robot.joint(joint) for joint in joints]
    wrist = next(a.child for a in robot.attachments if a.name == joints[-1])
    best = None
    for _ in range(1500):
        low = {one.name: float(generator.uniform(one.lower, one.upper)) for one in limits}
        places = pad_places(robot, kinematics, {**low, **fingers})
        across = places[1] - places[0]
        tilt = abs(across[2]) / float(np.linalg.norm(across))
        hand = np.array(kinematics.forward({**low, **fingers}, wrist).position)
        down = hand - np.mean(places, axis=0)
        score = tilt - down[2] / float(np.linalg.norm(down))
        if best is None or score < best[0]:
            best = (score, low, np.mean(places, axis=0))
    assert best is not None
    score, low, middle = best
    for size in (0.15, 0.3, 0.6):
        for _ in range(200):
            high = {
                one.name: float(
                    np.clip(low[one.name] + generator.uniform(-size, size), one.lower, one.upper)
                )
                for one in limits
            }
            risen = pad_middle(robot, kinematics, {**high, **fingers})[2] - middle[2]
            if 0.03 < risen < 0.12:
                return low, high, tuple(float(v) for v in middle), score  # type: ignore[return-value]
    raise AssertionError("no way up was found")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(HINGED))
def test_hinged_fingers_open_and_close(name: str):
    robot = load_robot(name)
    gripper = robot.grippers[0]
    twin = Twin.build(robot, NOWHERE)
    span = gripper.opening - gripper.least
    for share in (0.7, 0.2):
        target = gripper.least + share * span
        motion = twin.move_gripper(gripper.name, target)
        while motion.outcome == "active":
            twin.advance(10**13)
        state = twin.joint_state()
        reached = gripper.position(dict(zip(state.names, state.position, strict=True)))
        assert reached == pytest.approx(target, abs=0.02 * span)
    twin.close()


def test_a_sign_that_is_none_is_told(tmp_path):
    text = (Path(robot_module.__file__).parent / "robots" / "wx250.yaml").read_text(
        encoding="utf-8"
    )
    path = tmp_path / "arm.yaml"
    path.write_text(text.replace("signs: [1, -1]", "signs: [1, 2]"), encoding="utf-8")
    with pytest.raises(RobotError, match="each is 1 or -1"):
        load_robot(path)
