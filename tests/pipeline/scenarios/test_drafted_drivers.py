"""A controller of messages of its own, whose driver nobody has described, runs on a drafted one."""

import pytest

PACKAGE = "<package format='3'><name>{}</name>{}</package>\n"
MOVE = """\
float32[] pose
float32 speed
---
int16 ret
string message
"""
CONTROLLER = """\
import rospy
from acme_msgs.srv import Move, MoveRequest

rospy.init_node("cell")
rospy.wait_for_service("/acme/joint_move")
by_joints = rospy.ServiceProxy("/acme/joint_move", Move)
straight = rospy.ServiceProxy("/acme/linear_move", Move)


def turn():
    if by_joints(MoveRequest(pose=JOINTS, speed=1)).ret != 1:
        raise SystemExit(1)


def lower():
    if straight(MoveRequest(pose=[PLACE, 3.14, 0.0, 0.0], speed=50)).ret != 1:
        raise SystemExit(1)


turn()
lower()
"""
TOPIC = """\
import rospy
from acme_msgs.msg import JointCommand

rospy.init_node("cell")
command = rospy.Publisher("/acme/joint_command", JointCommand, queue_size=1)


def send(first):
    command.publish(JointCommand([first, -45, 60, 0, 30, 0]))
    rospy.sleep(3.0)


rospy.sleep(0.5)
send(30)
send(-30)
"""
MODEL = """\
import rospy
from sensor_msgs.msg import JointState

rospy.init_node("cell")
model = rospy.Publisher("/joint_states", JointState, queue_size=1)
NAMES = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint"]


def show(first):
    for step in range(1, 21):
        now = [first * step / 20, -1.57 + 0.01 * step, 0.01 * step, -1.57]
        model.publish(JointState(name=NAMES, position=now))
        rospy.sleep(0.1)


rospy.sleep(0.5)
show(0.4)
"""


@pytest.fixture
def cell(example):
    example.write("src/acme_msgs/package.xml", PACKAGE.format("acme_msgs", ""))
    example.write("src/acme_msgs/srv/Move.srv", MOVE)
    example.write("src/acme_msgs/msg/JointCommand.msg", "float32[6] angles  # deg\n")
    example.write("src/cell/package.xml", PACKAGE.format("cell", "<depend>acme_msgs</depend>"))
    return example


def written(joints: str, place: str) -> str:
    return CONTROLLER.replace("JOINTS", joints).replace("PLACE", place)


@pytest.mark.parametrize(
    ("joints", "place", "units"),
    [
        # Units that are SI are guessed in `tests/ros/drafts/test_drafted_driver.py`.
        pytest.param(
            "[0.2, 1.2, -1.4, 1.3, 1.5, 0.0]",
            "0.35, -0.1, 0.3",
            ("rad", "m and rad"),
            marks=pytest.mark.slow,
        ),
        # The scenario below has the same.
        pytest.param(
            "[10, 70, -80, 75, 85, 0]",
            "350, -100, 300",
            ("deg", "mm and rad"),
            marks=pytest.mark.slow,
        ),
    ],
    ids=["SI", "deg and mm"],
)
def test_services_move_the_arm_and_the_run_is_partial(cell, joints, place, units):
    cell.write("src/cell/cell.py", written(joints, place))
    outcome = cell.run("trace", "src/cell/cell.py", "--json")
    assert outcome.code == 0, outcome.err
    found = outcome.json
    assert found["verdict"]["kind"] == "partial"
    assumed = {
        each["object"]: each["words"]
        for each in found["verdict"]["reasons"]
        if each["code"] == "input-assumed"
    }
    assert set(assumed) == {"acme/joint_move", "acme/linear_move"}
    assert f"`pose` are the joints in {units[0]}" in assumed["acme/joint_move"]
    assert f"`pose` is a pose of the tool in {units[1]}" in assumed["acme/linear_move"]
    assert "nobody has confirmed it" in assumed["acme/linear_move"]
    moved = {each["ref"]["name"] for each in found["trace"]["functions"]}
    assert moved == {"turn", "lower"}


def test_a_scenario_with_the_driver_is_written_and_confirmed_by_deleting_the_marks(cell):
    cell.write("src/cell/cell.py", written("[10, 70, -80, 75, 85, 0]", "350, -100, 300"))
    outcome = cell.run("scenario", "src/cell/cell.py", "--write", "-o", "cell.yaml")
    assert outcome.code == 0, outcome.err
    text = cell.read("cell.yaml").decode()
    assert "  - driver: acme/linear_move  # assumed: `pose` is a pose of the tool in mm" in text
    assert "`pose` are the joints in deg" in text
    with_it = ("trace", "src/cell/cell.py", "--robot", "ur5e", "--scenario", "cell.yaml", "--json")
    before = cell.run(*with_it).json
    assert before["verdict"]["kind"] == "partial"
    lines = [line.partition("  # assumed")[0] for line in text.splitlines()]
    cell.write("cell.yaml", "\n".join(lines) + "\n")
    after = cell.run(*with_it).json
    assert after["verdict"]["kind"] == "complete"
    assert after["trace"]["functions"] == before["trace"]["functions"]


def test_a_topic_that_nobody_receives_moves_the_arm(cell):
    cell.write("src/cell/cell.py", TOPIC)
    found = cell.run("trace", "src/cell/cell.py", "--json").json
    assert found["verdict"]["kind"] == "partial"
    assert [each["ref"]["name"] for each in found["trace"]["functions"]] == ["send"]
    assert len(found["trace"]["visits"]) == 2


def test_joint_states_move_the_arm_where_nothing_else_does(cell):
    cell.write("src/cell/cell.py", MODEL)
    found = cell.run("trace", "src/cell/cell.py", "--robot", "ur5e", "--json").json
    assert found["verdict"]["kind"] == "partial"
    (assumed,) = [each for each in found["verdict"]["reasons"] if each["code"] == "input-assumed"]
    assert assumed["object"] == "joint_states"
    assert [each["ref"]["name"] for each in found["trace"]["functions"]] == ["show"]
    assert not [each for each in found["trace"]["findings"] if "move nothing" in each["message"]]


def test_a_driver_in_a_scenario_is_read_as_its_file_is(cell):
    cell.write("src/cell/cell.py", written("[0.2, 1.2, -1.4, 1.3, 1.5, 0.0]", "0.35, -0.1, 0.3"))
    cell.write(
        "cell.yaml",
        "drivers:\n  - driver: acme\n    packages: [acme_msgs]\n    services:\n"
        "      acme/joint_move: {type: Move, move: {joints: poses}}\n",
    )
    outcome = cell.run("trace", "src/cell/cell.py", "--scenario", "cell.yaml", "--no-draft")
    assert outcome.code == 2
    assert "cell.yaml:5" in outcome.err
    assert "has no field 'poses'; did you mean 'pose'?" in outcome.err


def test_a_driver_of_the_workspace_goes_before_a_drafted_one(cell):
    cell.write("src/cell/cell.py", written("[0.2, 1.2, -1.4, 1.3, 1.5, 0.0]", "0.35, -0.1, 0.3"))
    cell.write(
        "src/cell/acme.driver.yaml",
        "driver: acme\npackages: [acme_msgs]\ncodes: {succeeded: 1, failed: 0}\nservices:\n"
        "  acme/joint_move:\n    {type: Move, move: {joints: pose}, response: {ret: $code}}\n"
        "  acme/linear_move:\n"
        "    {type: Move, move: {pose: pose, line: true}, response: {ret: $code}}\n",
    )
    found = cell.run("trace", "src/cell/cell.py", "--robot", "ur5e", "--json").json
    assert found["verdict"]["kind"] == "complete"
