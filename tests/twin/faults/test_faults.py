"""What each fault does to the physics, alone; and that it is the same each time."""

import dataclasses
import hashlib
from pathlib import Path

import numpy as np
import pytest

from tests.slow import slow_but
from tests.twin.robots.test_robots import (
    FLAT,
    GRIPPERS,
    NOWHERE,
    SOME,
    SOME_GRIPPERS,
    finger_ends,
    finish,
    measured,
    ready_to_lift,
    settle,
    standing_at,
    straight_to,
)
from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.hardware.model import fault_kind
from tracerisk.errors import InputError
from tracerisk.twin.faults.armed import ENCODER_NOISE, encoder_offset
from tracerisk.twin.faults.fault import (
    Fault,
    FaultMode,
    check_faults,
    fault_named,
    modes_of,
    parse_fault,
)
from tracerisk.twin.faults.sensing import FORCE_OFFSET_N, TORQUE_OFFSET
from tracerisk.twin.physics.motion import JointTrajectory, Pose
from tracerisk.twin.physics.scene import Fixture, GraspableObject, Scene, load_scene
from tracerisk.twin.physics.scene_body import SceneBody
from tracerisk.twin.recording.samples import SampleWriter, read_samples
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Drives, EncoderFault
from tracerisk.twin.robots.sensors import Sensor
from tracerisk.twin.simulation.twin import Twin

LEANING = {"panda": {}, "fetch": {}, "ur10e": {"shoulder_lift_joint": -0.8, "elbow_joint": 0.6}}
"""Robots in a posture in which their weight pulls at a joint."""
FALLS = {"panda": "panda_joint2", "fetch": "shoulder_lift_joint", "ur10e": "shoulder_lift_joint"}


def leaning(name: str, samples: SampleWriter | None = None) -> Twin:
    twin = Twin.build(standing_at(load_robot(name), LEANING[name]), NOWHERE, samples=samples)
    settle(twin, 0.2)
    return twin


def moved(twin: Twin, before: dict[str, float]) -> dict[str, float]:
    return {name: abs(value - before[name]) for name, value in measured(twin).items()}


def swing(twin: Twin, by: float = 0.3, seconds: float = 2.0) -> JointTrajectory:
    """All arm joints, towards the middle of their range."""
    here = measured(twin)
    joints = twin.robot.arm_joints
    way = [1.0 if here[one.name] < (one.lower + one.upper) / 2 else -1.0 for one in joints]
    first = np.array([here[one.name] for one in joints])
    scale = np.array([min(by, 0.4 * (one.upper - one.lower)) for one in joints])
    rows = np.array([first, first + scale * np.array(way)])
    names = tuple(one.name for one in joints)
    return JointTrajectory(names, np.array([0.0, seconds]), rows, np.zeros_like(rows))


@pytest.mark.parametrize("name", sorted(FALLS))
def test_a_dead_joint_falls(name: str):
    twin = leaning(name)
    before = measured(twin)
    twin.arm(Fault(FALLS[name], "dead", 0.5))
    settle(twin, 0.28)
    assert max(moved(twin, before).values()) < 1e-4, "not before its instant"
    settle(twin, 1.5)
    assert moved(twin, before)[FALLS[name]] > 0.3
    state = twin.joint_state()
    assert state.effort[state.names.index(FALLS[name])] == 0.0


@pytest.mark.parametrize("name", slow_but(["fetch"], sorted(FALLS)))
def test_a_jammed_joint_does_not_move_while_the_others_do(name: str):
    for joint in load_robot(name).arm_joints:
        twin = leaning(name)
        motion = twin.follow(swing(twin))
        twin.arm(Fault(joint.name, "jam", twin.time_ns * 1e-9 + 1.0))
        settle(twin, 1.002)
        before = measured(twin)
        settle(twin, 5.0)
        here = moved(twin, before)
        assert here[joint.name] < 1e-4
        assert sum(value > 0.01 for value in here.values()) >= len(twin.robot.arm_joints) - 1
        assert motion.outcome == "aborted"
        assert joint.name in motion.message


@pytest.mark.parametrize("name", slow_but(SOME, robot_names()))
def test_an_arm_without_power_stays_on_its_brakes(name: str):
    twin = Twin.build(load_robot(name), NOWHERE)
    settle(twin, 0.2)
    before = measured(twin)
    twin.arm(Fault("power", "lost_with_brakes", 0.3))
    settle(twin, 3.0)
    arm = [joint.name for joint in twin.robot.arm_joints]
    assert max(moved(twin, before)[joint] for joint in arm) < 1e-4


@pytest.mark.parametrize("name", sorted(FALLS))
def test_an_arm_without_power_and_without_brakes_falls(name: str):
    twin = leaning(name)
    before = measured(twin)
    twin.arm(Fault("power", "lost_without_brakes", 0.3))
    settle(twin, 2.0)
    assert moved(twin, before)[FALLS[name]] > 0.3
    assert set(twin.joint_state().effort) == {0.0}


@pytest.mark.parametrize("name", sorted(FALLS))
def test_an_encoder_with_an_offset_shifts_reading_and_joint(name: str, tmp_path: Path):
    joint = load_robot(name).joint(FALLS[name])
    offset = encoder_offset(joint.type)
    with SampleWriter(tmp_path) as writer:
        twin = leaning(name, writer)
        before = measured(twin)[joint.name]
        twin.arm(Fault(f"{joint.name}/encoder", "offset", 0.2))
        settle(twin, 3.0)
        reported = measured(twin)[joint.name]
        twin.close()
    samples = read_samples(tmp_path)
    true = samples.position[-1, samples.header.joints.index(joint.name)]
    # The last sample is one step older than what is measured; all stands still by now.
    assert reported - true == pytest.approx(offset, abs=1e-9)
    assert reported == pytest.approx(before, abs=1e-3), "the servo regulates what the encoder reads"


@pytest.mark.parametrize("name", slow_but(SOME, robot_names()))
def test_every_encoder_of_every_robot_reads_exactly_its_offset_too_much(name: str):
    robot = load_robot(name)
    twin, sound = Twin.build(robot, NOWHERE), Twin.build(robot, NOWHERE)
    for sensor in robot.sensors:
        if sensor.kind == "encoder":
            twin.arm(Fault(sensor.name, "offset", 0.0))
    # A fault begins with its step, and this one moves the joints only by the next.
    settle(twin, 0.002)
    settle(sound, 0.002)
    for joint in robot.arm_joints:
        if joint.name not in robot.without_encoder:
            shift = measured(twin)[joint.name] - measured(sound)[joint.name]
            assert shift == pytest.approx(encoder_offset(joint.type), abs=0.01), joint.name


@pytest.mark.parametrize("mode", ["frozen", "absent"])
@pytest.mark.parametrize("name", sorted(FALLS))
def test_a_frozen_encoder_says_the_same_while_its_joint_moves(
    name: str, mode: FaultMode, tmp_path: Path
):
    joint = FALLS[name]
    with SampleWriter(tmp_path) as writer:
        robot = with_drives(standing_at(load_robot(name), LEANING[name]), "runs_away")
        twin = Twin.build(robot, NOWHERE, samples=writer)
        settle(twin, 0.2)
        twin.arm(Fault(f"{joint}/encoder", mode, 0.2))
        twin.follow(swing(twin))
        reported = set()
        for _ in range(20):
            settle(twin, 0.1)
            reported.add(measured(twin)[joint])
        assert len(reported) == 1
        assert twin.joint_state().absent == ({joint} if mode == "absent" else set())
        twin.close()
    samples = read_samples(tmp_path)
    true = samples.position[:, samples.header.joints.index(joint)]
    assert np.ptp(true) > 0.2, "the recording holds the truth"


def test_a_faulty_torque_sensor_changes_the_effort_alone():
    twin = leaning("panda")
    state = twin.joint_state()
    at = state.names.index("panda_joint2")
    for mode, expected in (
        ("offset", state.effort[at] + TORQUE_OFFSET * 87.0),
        ("frozen", state.effort[at]),
        ("absent", 0.0),
    ):
        twin = leaning("panda")
        twin.arm(Fault("panda_joint2/torque", mode, 0.2))
        settle(twin, 0.1)
        assert twin.joint_state().effort[at] == pytest.approx(expected, abs=1e-3)
        assert twin.joint_state().position == pytest.approx(state.position, abs=1e-4)


def test_a_faulty_wrist_sensor_changes_what_it_says_alone():
    wrist = Sensor("wrench", "wrist", "panda_hand")
    robot = dataclasses.replace(load_robot("panda"), own_sensors=(wrist,))
    reported = {}
    for mode in ("offset", "frozen", "absent"):
        twin = Twin.build(robot, NOWHERE)
        twin.arm(Fault(wrist.name, mode, 0.2))
        twin.follow(swing(twin))
        settle(twin, 1.0)
        reported[mode] = (twin.wrench(wrist), twin.load_on(wrist.part))
    offset, true = reported["offset"]
    assert offset is not None
    assert offset.force == (*true.force[:2], true.force[2] + FORCE_OFFSET_N)
    frozen, true = reported["frozen"]
    assert frozen is not None
    assert frozen != true
    assert reported["absent"][0] is None


def test_a_frozen_control_unit_keeps_to_its_last_command():
    for name in FALLS:
        twin = leaning(name)
        motion = twin.follow(swing(twin))
        twin.arm(Fault("control", "frozen", 1.2))
        settle(twin, 1.5)
        before = measured(twin)
        settle(twin, 2.5)
        assert max(moved(twin, before).values()) < 5e-3
        assert motion.outcome == "aborted"


def picked(name: str, index: int) -> tuple[Twin, float, tuple[float, float]]:
    """A twin that holds a thing, the height of the thing, and the gripper closed and wide open."""
    robot = load_robot(name)
    gripper = robot.grippers[index]
    closed, opened, half = finger_ends(robot, gripper)
    low, high, middle, sides = ready_to_lift(robot, gripper, opened)
    ball = len(gripper.pads) == 2
    shape = Shape("sphere", (half,)) if ball else Shape("box", (half, 0.035, 0.012))
    height = half if ball else 0.012
    thing = GraspableObject("thing", middle, (0.0, 0.0, sides), 0.025, 0.5, (shape,))
    foot = (middle[0], middle[1], middle[2] - height - 0.03)
    pole = Fixture("pole", foot, FLAT, (Shape("cylinder", (0.003, 0.03)),))
    scene = Scene("pick", "something on a pole", FLAT, FLAT, (pole,), (thing,), (), "pick.yaml")
    fingers = {joint: gripper.sign(joint) * opened for joint in gripper.joints}
    twin = Twin.build(standing_at(robot, {**low, **fingers}), scene)
    settle(twin, 0.1)
    assert finish(twin, twin.move_gripper(gripper.name, closed)).stalled
    straight_to(twin, high)
    settle(twin, 0.5)
    wide = max((gripper.least, gripper.opening), key=lambda end: abs(end - closed))
    return twin, twin.object_pose("thing").position[2], (closed, wide)


@pytest.mark.parametrize(("name", "index"), slow_but(SOME_GRIPPERS, GRIPPERS))
def test_a_gripper_that_is_stuck_holds_and_one_without_force_drops(name: str, index: int):
    twin, height, (closed, wide) = picked(name, index)
    gripper = twin.robot.grippers[index]
    now_s = twin.time_ns * 1e-9
    stuck = Fault(gripper.name, "stuck", now_s)
    twin.arm(stuck)
    settle(twin, 0.01)
    before = measured(twin)
    twin.move_gripper(gripper.name, wide)
    settle(twin, 1.0)
    assert max(moved(twin, before)[joint] for joint in gripper.joints) < 1e-4
    assert twin.object_pose("thing").position[2] == pytest.approx(height, abs=3e-3)
    twin.move_gripper(gripper.name, closed)
    settle(twin, 1.0)
    twin.clear(stuck)
    settle(twin, 0.2)
    assert twin.object_pose("thing").position[2] == pytest.approx(height, abs=5e-3)
    twin.arm(Fault(gripper.name, "no_force", now_s))
    settle(twin, 2.0)
    assert twin.object_pose("thing").position[2] < height - 0.1, "past its instant: at once"
    assert twin.live_faults == (Fault(gripper.name, "no_force", now_s),)


@pytest.mark.parametrize(
    ("name", "index"),
    slow_but(
        [("panda", 0), ("gen3", 0)], [("panda", 0), ("gen3", 0), ("baxter", 1), ("j2n6s300", 0)]
    ),
)
def test_a_gripper_that_opens_drops_what_it_holds_whatever_it_is_reported(name: str, index: int):
    twin, height, (_, wide) = picked(name, index)
    gripper = twin.robot.grippers[index]
    twin.arm(Fault(gripper.name, "opens", twin.time_ns * 1e-9))
    settle(twin, 2.0)
    assert gripper.position(measured(twin)) == pytest.approx(
        wide, abs=0.05 * (gripper.opening - gripper.least)
    )
    assert twin.object_pose("thing").position[2] < height - 0.1


def test_a_fault_stays_when_the_controller_declares_a_body():
    twin = leaning("panda")
    twin.arm(Fault("panda_joint1", "jam", 0.2))
    settle(twin, 0.01)
    before = measured(twin)
    pose = Pose((0.8, 0.5, 0.2), (0.0, 0.0, 0.0, 1.0))
    twin.declare([SceneBody("box", pose, (Shape("box", (0.05, 0.05, 0.05)),))])
    twin.follow(swing(twin))
    settle(twin, 1.0)
    assert moved(twin, before)["panda_joint1"] < 1e-4
    twin.clear(Fault("panda_joint1", "jam", 0.2))
    twin.follow(swing(twin))
    settle(twin, 3.0)
    assert moved(twin, before)["panda_joint1"] > 0.2


def bytes_of(folder: Path, faults: tuple[Fault, ...], *, cleared: bool = False) -> str:
    folder.mkdir()
    with SampleWriter(folder) as writer:
        twin = Twin.build(load_robot("panda"), load_scene("empty"), samples=writer)
        for fault in faults:
            twin.arm(fault)
        if cleared:
            fault = Fault("panda_joint4", "dead", 0.777)
            twin.arm(fault)
            twin.clear(fault)
        twin.follow(swing(twin))
        settle(twin, 3.0)
        twin.close()
    found = hashlib.sha256()
    for each in sorted(folder.iterdir()):
        found.update(each.read_bytes())
    return found.hexdigest()


def test_the_same_fault_gives_the_same_bytes_and_a_cleared_one_those_of_none(tmp_path: Path):
    faults = (Fault("panda_joint4", "dead", 0.777), Fault("panda_hand", "opens", 1.5))
    one, two = (bytes_of(tmp_path / name, faults) for name in ("one", "two"))
    assert one == two
    none = bytes_of(tmp_path / "none", ())
    assert none != one
    assert bytes_of(tmp_path / "cleared", (), cleared=True) == none
    assert bytes_of(tmp_path / "later", (Fault("power", "lost_with_brakes", 9.0),)) == none


def encoder_of(name: str) -> tuple[str, str]:
    joint = FALLS[name]
    return joint, f"{joint}/encoder"


def with_drives(robot: Robot, kind: EncoderFault, error: float = 0.1) -> Robot:
    return dataclasses.replace(robot, drives=Drives(kind, error, "a test"))


@pytest.mark.parametrize("mode", ["frozen", "absent"])
@pytest.mark.parametrize("kind", ["stops", "runs_away"])
def test_a_drive_stops_the_arm_or_runs_away_when_its_encoder_fails(
    kind: EncoderFault, mode: FaultMode
):
    joint, encoder = encoder_of("panda")
    twin = Twin.build(with_drives(load_robot("panda"), kind), NOWHERE)
    settle(twin, 0.2)
    others = [one.name for one in twin.robot.arm_joints if one.name != joint]
    way = swing(twin)
    twin.arm(Fault(encoder, mode, 0.7))
    twin.follow(way)
    settle(twin, 3.0)
    now = dict(zip([one.name for one in twin.robot.joints], twin.posture(), strict=True))
    goal = dict(zip(way.joints, way.position[-1], strict=True))
    off = abs(now[joint] - goal[joint])
    if kind == "runs_away":
        assert off > 0.1, "no reading says that it is there: it goes on"
        assert all(abs(now[name] - goal[name]) < 0.02 for name in others)
        return
    stopped = {name: abs(now[name] - goal[name]) for name in (*others, joint)}
    assert min(stopped.values()) > 0.05, "the whole arm stops"
    before = twin.posture().copy()
    settle(twin, 1.0)
    assert np.abs(twin.posture() - before).max() < 1e-3


def test_the_following_error_decides_when_a_drive_stops():
    joint, encoder = encoder_of("panda")
    moved = {}
    for error in (0.02, 0.2):
        twin = Twin.build(with_drives(load_robot("panda"), "stops", error), NOWHERE)
        settle(twin, 0.2)
        at = [one.name for one in twin.robot.joints].index(joint)
        first = twin.posture()[at]
        twin.arm(Fault(encoder, "frozen", 0.2))
        twin.follow(swing(twin))
        settle(twin, 3.0)
        moved[error] = abs(twin.posture()[at] - first)
    assert 0.0 < moved[0.02] < moved[0.2]


def test_an_arm_that_stands_still_does_not_show_that_an_encoder_is_frozen():
    _, encoder = encoder_of("panda")
    twin = Twin.build(with_drives(load_robot("panda"), "stops"), NOWHERE)
    settle(twin, 0.2)
    before = twin.posture().copy()
    twin.arm(Fault(encoder, "frozen", 0.3))
    settle(twin, 1.0)
    assert np.abs(twin.posture() - before).max() < 5e-3


def test_a_noisy_encoder_shakes_its_joint_and_reads_the_same_noise_again(tmp_path: Path):
    joint, encoder = encoder_of("panda")
    taken = []
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        with SampleWriter(tmp_path / folder) as writer:
            twin = leaning("panda", writer)
            twin.arm(Fault(encoder, "noisy", 0.3))
            settle(twin, 0.2)
            readings = []
            for _ in range(200):
                settle(twin, 0.01)
                readings.append(measured(twin)[joint])
            twin.close()
        samples = read_samples(tmp_path / folder)
        taken.append((readings, samples.position.tobytes()))
        true = samples.position[300:, samples.header.joints.index(joint)]
        assert 1e-4 < np.std(true) < 0.05, "the servo follows what it reads"
        assert 0.5 * ENCODER_NOISE < np.std(readings) < 2.0 * ENCODER_NOISE
    assert taken[0] == taken[1]


def test_a_fault_that_passes_leaves_the_unit_sound():
    joint = FALLS["panda"]
    twin = leaning("panda")
    before = measured(twin)[joint]
    twin.arm(Fault(joint, "dead", 0.3, 0.1))
    settle(twin, 0.18)
    sagged = abs(measured(twin)[joint] - before)
    assert twin.live_faults
    settle(twin, 2.0)
    assert not twin.live_faults
    assert sagged > 0.002
    assert abs(measured(twin)[joint] - before) < 0.1 * sagged, "its servo brings it back"


def test_a_link_that_is_lost_for_a_while_hears_nothing_until_it_is_back():
    twin = leaning("panda")
    twin.arm(Fault("control", "link_lost", 0.5, 3.0))
    motion = twin.follow(swing(twin))
    settle(twin, 0.5)
    said = twin.joint_state()
    assert said.absent == frozenset(said.names)
    true = twin.posture().copy()
    settle(twin, 2.0)
    assert motion.outcome == "active", "nobody hears whether it has arrived"
    assert np.abs(twin.posture() - true).max() < 5e-3, "the arm keeps to what it heard last"
    assert twin.joint_state().position == said.position
    settle(twin, 2.0)
    assert motion.outcome != "active"
    assert not twin.joint_state().absent


def test_every_unit_of_both_arms_can_fail():
    modes = modes_of(load_robot("baxter"))
    for side in ("left", "right"):
        assert modes[f"{side}_s1"] == ("dead", "jam")
        assert modes[f"{side}_gripper"] == ("no_force", "opens", "stuck")
        assert modes[f"{side}_s1/encoder"] == ("offset", "frozen", "absent", "noisy")
    assert modes["power"] == ("lost_with_brakes", "lost_without_brakes")
    assert modes["control"] == ("frozen", "link_lost")


@pytest.mark.parametrize("name", slow_but(SOME, robot_names()))
def test_every_fault_of_every_robot_can_begin(name: str):
    robot = load_robot(name)
    twin = Twin.build(robot, NOWHERE)
    for unit, modes in modes_of(robot).items():
        for mode in modes:
            fault = Fault(unit, mode, 0.0)
            twin.arm(fault)
            settle(twin, 0.01)
            assert twin.live_faults == (fault,)
            twin.clear(fault)
    settle(twin, 0.1)


def test_a_fault_that_passes_is_written_as_it_is_read():
    fault = parse_fault("panda_hand:opens@8,for=0.5")
    assert fault == Fault("panda_hand", "opens", 8.0, 0.5)
    assert parse_fault(str(fault)) == fault
    assert fault.words == "panda_hand opens at 8.000 s for 0.5 s"
    assert fault_named("panda_hand", fault_kind("opens", 0.5), 8.0) == fault
    assert fault_named("panda_hand", fault_kind("opens", None), 8.0) == Fault(
        "panda_hand", "opens", 8.0
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("panda_joint1", "expected UNIT:MODE@SECONDS"),
        ("panda_joint1:dead", "expected UNIT:MODE@SECONDS"),
        ("panda_joint1:broken@3", "unknown mode 'broken'; allowed: absent, dead, "),
        ("panda_joint1:dead@soon", "'soon' is not a time in seconds"),
        ("panda_joint1:dead@-1", "'-1' is not a time in seconds"),
        ("panda_joint1:dead@nan", "'nan' is not a time in seconds"),
        ("panda_joint1:dead@3,for=0", "'for=0' is not 'for=SECONDS'"),
        ("panda_joint1:dead@3,for=soon", "'for=soon' is not 'for=SECONDS'"),
        ("panda_joint1:dead@3,until=4", "'until=4' is not 'for=SECONDS'"),
    ],
)
def test_a_fault_that_cannot_be_read_says_what_is_expected(text: str, expected: str):
    with pytest.raises(InputError, match="fault") as found:
        parse_fault(text)
    assert expected in str(found.value)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("panda_joint9:dead@3", "no unit 'panda_joint9' that can fail; did you mean 'panda_joint"),
        ("panda_joint1:opens@3", "has no mode 'opens'; allowed: dead, jam"),
        ("panda_joint1:dead@40", "the run without a fault ends at 12.500 s"),
    ],
)
def test_a_fault_that_a_robot_cannot_have_lists_those_it_can(text: str, expected: str):
    with pytest.raises(InputError) as found:
        check_faults((parse_fault(text),), load_robot("panda"), before_s=12.5)
    assert expected in str(found.value)


def test_faults_come_in_the_order_of_their_instants_and_a_unit_fails_once():
    panda: Robot = load_robot("panda")
    late, early = parse_fault("panda_joint1:dead@3"), parse_fault("power:lost_with_brakes@0.5")
    assert check_faults((late, early), panda) == (early, late)
    assert (str(late), late.words) == ("panda_joint1:dead@3", "panda_joint1 dead at 3.000 s")
    with pytest.raises(InputError, match="'panda_joint1' fails twice"):
        check_faults((late, dataclasses.replace(late, mode="jam")), panda)
