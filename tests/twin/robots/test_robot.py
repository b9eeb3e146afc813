from pathlib import Path

import pytest

from tracerisk.errors import RobotError
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.robots.robot_parts import Scaling

ROBOTS = Path(__file__).parents[3] / "tracerisk" / "twin" / "robots" / "shipped"


def changed(tmp_path: Path, old: str, new: str) -> Path:
    text = (ROBOTS / "panda.yaml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "arm.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    return path


def line_of(path: Path, text: str) -> int:
    lines = path.read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(lines, 1) if text in line)


def test_the_panda_is_shipped():
    assert "panda" in robot_names()


def test_elements_are_seven_joints_and_one_gripper_then_links_and_sensors(panda: Robot):
    assert [(element.name, element.kind) for element in panda.elements] == [
        *((f"panda_joint{i}", "joint") for i in range(1, 8)),
        ("panda_hand", "gripper"),
        *((f"panda_link{i}", "contact") for i in range(8)),
        *((f"panda_{name}", "contact") for name in ("hand/contact", "leftfinger", "rightfinger")),
        *((f"panda_joint{i}/encoder", "sensor") for i in range(1, 8)),
        *((f"panda_joint{i}/torque", "sensor") for i in range(1, 8)),
    ]
    assert [e.part for e in panda.elements if e.name == "panda_hand/contact"] == ["panda_hand"]


def test_rated_figures_are_those_of_the_data_sheet(panda: Robot):
    arm = panda.arm_joints
    assert [joint.torque_limit for joint in arm] == [87.0] * 4 + [12.0] * 3
    assert [joint.velocity_limit for joint in arm] == [2.175] * 4 + [2.61] * 3


def test_a_copy_of_the_file_gives_the_same_robot(panda: Robot, tmp_path: Path):
    path = changed(tmp_path, "name: panda\n", "name: panda\n")
    copy = load_robot(path)
    assert (copy.joints, copy.links, copy.groups) == (panda.joints, panda.links, panda.groups)


def test_an_unknown_robot_is_named_with_those_there_are():
    with pytest.raises(RobotError, match=r"unknown robot 'pand'; did you mean 'panda'\?"):
        load_robot("pand")


def test_an_unknown_group_lists_those_there_are(panda: Robot):
    with pytest.raises(RobotError, match=r"no planning group 'arm'.*panda_arm"):
        panda.group("arm")


def test_a_gripper_is_found_by_its_group(panda: Robot):
    assert panda.gripper("hand") is panda.gripper("panda_hand")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("base_link: panda_link0", "base_link: panda_link9", "unknown name 'panda_link9'"),
        ("torque: 87.0", "torque: 0.0", "0 is not allowed"),
        ("torque: 87.0", "torque: -1.0", "-1 is outside"),
        ("torque: 87.0", "tork: 87.0", "unknown key 'tork'"),
        ("torque: 87.0", "torque: 87.0, plan_velocity: 9.0", "9 is above the rated 2.175"),
        ("torque: 87.0", "torque: 87.0, plan_acceleration: 4", "4 is above the rated 3.75"),
        ("lower: -2.8973", "lower: 3.0", "is not above the lower limit"),
        ("open: {panda_finger_joint1: 0.035", "open: {panda_finger_joint1: 0.5", "0.5 is outside"),
        ("parent: panda_link7", "parent: panda_hand", "is its own ancestor"),
        ("child: panda_link2", "child: panda_link1", "more than one parent"),
        ("servo: wrist", "servo: wirst", "did you mean 'wrist'"),
        ("servo: wrist", "servo: finger", "'panda_joint5' has stiffness 0 and cannot move it"),
        ("kind: capsule", "kind: cone", "unknown shape 'cone'"),
        ("type: follow_joint_trajectory", "type: follow", "unknown type 'follow'"),
    ],
)
def test_a_mistake_is_reported_with_file_and_line(tmp_path: Path, old: str, new: str, message: str):
    path = changed(tmp_path, old, new)
    with pytest.raises(RobotError, match=message) as caught:
        load_robot(path)
    assert caught.value.location is not None
    assert caught.value.location.file == str(path)
    assert caught.value.location.line is not None


def test_the_line_of_a_mistake_is_right(tmp_path: Path):
    path = changed(tmp_path, "torque: 87.0", "torque: -1.0")
    with pytest.raises(RobotError) as caught:
        load_robot(path)
    assert caught.value.location is not None
    assert caught.value.location.line == line_of(path, "torque: -1.0")


def test_plans_take_a_tenth_of_the_rated_figures_unless_the_file_says_otherwise(tmp_path: Path):
    said = changed(tmp_path, "default_scaling: {velocity: 0.1", "default_scaling: {velocity: 0.3")
    assert load_robot(said).default_scaling == Scaling(0.3, 0.1)
    silent = changed(tmp_path, "default_scaling: {velocity: 0.1, acceleration: 0.1}\n", "")
    assert load_robot(silent).default_scaling == Scaling(0.1, 0.1)


def test_no_shipped_robot_plans_at_its_rated_speed_unasked():
    for path in sorted(ROBOTS.glob("*.yaml")):
        # Some makers' configurations do say 1; then the robot's file does.
        says_so = "\ndefault_scaling: {velocity: 1.0" in path.read_text(encoding="utf-8")
        assert load_robot(path).default_scaling.velocity < 1.0 or says_so, path.name
