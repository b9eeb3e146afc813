"""The sensors of a robot as data: what a file says, and what follows where it says nothing."""

from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk.common.traced.elements import Element
from tracerisk.errors import RobotError
from tracerisk.twin.robots.file import dump_robot, read_dumped_robot
from tracerisk.twin.robots.known_arms import completed_as_ours
from tracerisk.twin.robots.prefix import with_prefix
from tracerisk.twin.robots.robot import SHIPPED_ROBOTS, Robot, load_robot, robot_names
from tracerisk.twin.robots.sensors import Sensor

PX100 = (SHIPPED_ROBOTS / "px100.yaml").read_text(encoding="utf-8")


def robot_with(folder: Path, sensors: str) -> Robot:
    path = folder / "arm.yaml"
    path.write_text(f"{PX100}\nsensors:\n{sensors}", encoding="utf-8")
    return load_robot(path)


@pytest.mark.parametrize("name", robot_names())
def test_every_arm_joint_has_an_encoder_and_every_name_is_unique(name):
    robot = load_robot(name)
    encoders = [sensor.part for sensor in robot.sensors if sensor.kind == "encoder"]
    assert encoders == [joint.name for joint in robot.arm_joints]
    names = [element.name for element in robot.elements]
    assert len(set(names)) == len(names)
    links = set(robot.link_names)
    assert all(s.part in links for s in robot.sensors if s.kind in ("wrench", "camera"))
    assert all(s.link in links for s in robot.sensors if s.link is not None)


@pytest.mark.parametrize(
    ("name", "torque", "wrench", "cameras"),
    [
        ("panda", 7, 0, 0),
        ("iiwa14", 7, 0, 0),
        ("gen3", 7, 0, 0),
        ("baxter", 14, 0, 3),
        ("ur5", 0, 0, 0),
        ("ur5e", 0, 1, 0),
        ("fetch", 0, 0, 1),
        ("px100", 0, 0, 0),
    ],
)
def test_what_an_arm_has_beside_its_encoders(name, torque, wrench, cameras):
    kinds = [sensor.kind for sensor in load_robot(name).own_sensors]
    counts = tuple(kinds.count(kind) for kind in ("torque", "wrench", "camera"))
    assert counts == (torque, wrench, cameras)


def test_an_element_says_its_kind_and_where_it_is():
    elements = load_robot("ur5e").elements
    assert elements[-1] == Element("tcp_fts_sensor", "sensor", sensor="wrench", part="tool0")
    assert Element("elbow_joint/encoder", "sensor", "encoder", "elbow_joint") in elements


def test_a_file_may_say_which_joints_have_an_encoder(tmp_path):
    robot = robot_with(tmp_path, "  - {kind: encoder, joints: [waist, elbow]}\n")
    assert [sensor.name for sensor in robot.sensors] == ["waist/encoder", "elbow/encoder"]
    assert robot_with(tmp_path, "  - {kind: encoder, joints: []}\n").sensors == ()


def test_sensors_survive_the_way_into_the_process_of_the_run(tmp_path):
    robot = robot_with(
        tmp_path,
        "  - {kind: encoder, joints: [waist]}\n"
        '  - {kind: torque, joints: "*", link: px100/ee_gripper_link, topics: [F], source: own}\n',
    )
    dumped = tmp_path / "robot.json"
    dumped.write_text(dump_robot(robot), encoding="utf-8")
    assert read_dumped_robot(dumped) == robot


def test_a_description_of_a_shipped_arm_has_its_sensors():
    ours = load_robot("iiwa14")
    bare = replace(ours, own_sensors=())
    assert completed_as_ours(bare).own_sensors == ours.own_sensors
    own = (Sensor("wrench", "wrist", "lbr_link_ee"),)
    assert completed_as_ours(replace(bare, own_sensors=own)).own_sensors[0] == own[0]


def test_a_prefix_stands_before_sensors_in_joints():
    robot = with_prefix(load_robot("ur5e"), "left_")
    assert [s.name for s in robot.sensors][-2:] == ["left_wrist_3_joint/encoder", "tcp_fts_sensor"]
    assert robot.sensors[-1].part == "left_tool0"


@pytest.mark.parametrize(
    ("topics", "topic", "tells"),
    [
        (("wrench",), "/wrench", True),
        (("wrench",), "/left/force_torque_sensor_broadcaster/wrench", True),
        (("wrench",), "/wrench_filtered", False),
        (("cameras/head",), "/robot/cameras/head/image", True),
        (("cameras/head",), "/cameras/head_2/image", False),
        ((), "/wrench", False),
    ],
)
def test_which_topics_say_of_a_sensor(topics, topic, tells):
    assert Sensor("wrench", "s", "tool0", topics).reports(topic) is tells


@pytest.mark.parametrize(
    ("sensors", "expected"),
    [
        ("  - {kind: lidar, joints: []}\n", "unknown kind .lidar.; allowed: camera, encoder"),
        ("  - {kind: torque, joints: [nose], source: own}\n", "unknown joint 'nose'"),
        ('  - {kind: torque, joints: "*"}\n', "source"),
        ("  - {kind: camera, name: c, link: nose, topics: [c], source: own}\n", "unknown link"),
        (
            "  - {kind: camera, name: waist, link: px100/fingers_link, topics: [c], source: own}\n",
            "waist",
        ),
        ("  - {kind: encoder, joints: [waist], name: e}\n", "name"),
        ("  - {kind: torque, source: own}\n", "joints"),
    ],
)
def test_a_mistake_is_reported_with_its_line(tmp_path, sensors, expected):
    with pytest.raises(RobotError, match=expected) as caught:
        robot_with(tmp_path, sensors)
    location = caught.value.location
    assert location is not None
    assert location.line is not None
    assert location.line >= PX100.count("\n")


def test_two_sensors_of_one_name_are_refused(tmp_path):
    twice = '  - {kind: torque, joints: "*", source: own}\n' * 2
    with pytest.raises(RobotError, match="'waist/torque' is defined twice"):
        robot_with(tmp_path, twice)
