"""Poses that were read in one frame and given as of another: which are told of, and which not."""

from pathlib import Path

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.common.traced.findings import NOTES
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

COMMANDER = """\
import copy
import rospy, tf2_ros, tf2_geometry_msgs, moveit_commander
from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.srv import GetPositionFK, GetPositionFKRequest
rospy.init_node("press")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.go([0.0, -0.7, 0.05, -2.2, 0.1, 1.6, 0.8], wait=True)
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
rospy.sleep(1.0)
def stamped(pose, frame):
    made = PoseStamped(pose=pose)
    made.header.frame_id = frame
    return made
def looked_up(target, source):
    found = buffer.lookup_transform(target, source, rospy.Time(0)).transform
    pose = Pose(orientation=found.rotation)
    pose.position.x, pose.position.y, pose.position.z = (
        found.translation.x, found.translation.y, found.translation.z)
    return pose
def forward():
    serve = rospy.ServiceProxy("/compute_fk", GetPositionFK)
    request = GetPositionFKRequest(fk_link_names=["panda_link8"])
    request.robot_state = arm.get_current_state()
    return serve(request).pose_stamped[0].pose
def as_list(pose):
    p, q = pose.position, pose.orientation
    return [p.x, p.y, p.z, q.x, q.y, q.z, q.w]
def lowered(pose, by=0.1):
    pose.position.z -= by
    return pose
here = lambda: arm.get_current_pose().pose
"""
LINE = len(COMMANDER.splitlines()) + 1
WRONG = {
    "a bare pose in the reference frame": (
        'arm.set_pose_reference_frame("panda_link1")\narm.set_pose_target(lowered(here()))'
    ),
    "a list in the reference frame": (
        'arm.set_pose_reference_frame("panda_link1")\narm.set_pose_target(as_list(here()))'
    ),
    "a header": 'pose = here()\narm.set_pose_target(stamped(pose, "panda_link2"))',
    "a copy": (
        "pose = copy.deepcopy(here())\npose.position.x += 0.05\n"
        'arm.set_pose_target(stamped(pose, "panda_link2"))'
    ),
    "a lookup": (
        'pose = looked_up("panda_link0", "panda_link8")\n'
        'arm.set_pose_target(stamped(pose, "panda_link1"))'
    ),
    "forward kinematics": 'arm.set_pose_target(stamped(lowered(forward()), "panda_link1"))',
    "a path": (
        'arm.set_pose_reference_frame("panda_link1")\n'
        "arm.compute_cartesian_path([lowered(here(), 0.05)], 0.01)"
    ),
}
RIGHT = {
    "in the same frame": "arm.set_pose_target(lowered(here()))",
    "in a frame at the same place": 'arm.set_pose_target(stamped(here(), "world"))',
    "transformed": (
        'pose = stamped(lowered(here()), "panda_link0")\n'
        'arm.set_pose_target(buffer.transform(pose, "panda_link1"))'
    ),
    "the way between the frames was taken off": (
        'pose = lowered(here(), 0.333)\narm.set_pose_target(stamped(pose, "panda_link1"))'
    ),
    "read in that frame": (
        'here()\npose = looked_up("panda_link1", "panda_link8")\n'
        'arm.set_pose_target(stamped(lowered(pose), "panda_link1"))'
    ),
    "typed, with the turn of now": (
        "pose = here()\npose.position.x, pose.position.y, pose.position.z = 0.4, 0.1, 0.2\n"
        'arm.set_pose_target(stamped(pose, "panda_link1"))'
    ),
    "typed": (
        "pose = Pose()\npose.orientation.x = 1.0\npose.position.x = 0.4\n"
        'arm.set_pose_target(stamped(pose, "panda_link1"))'
    ),
    "of another turn": (
        "pose = here()\npose.orientation = Pose().orientation\npose.orientation.x = 1.0\n"
        'arm.set_pose_target(stamped(pose, "panda_link1"))'
    ),
}
MOVE_GROUP = """\
import rclpy, tf2_ros
from rclpy.action import ActionClient
from geometry_msgs.msg import Pose
from shape_msgs.msg import SolidPrimitive
from moveit_msgs.action import MoveGroup
from moveit_msgs.msg import Constraints, OrientationConstraint, PositionConstraint
rclpy.init()
node = rclpy.create_node("press")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer, node, spin_thread=True)
import time
time.sleep(2.0)
found = buffer.lookup_transform("panda_link0", "panda_link8", rclpy.time.Time()).transform
place, turn = PositionConstraint(), OrientationConstraint()
for one in (place, turn):
    one.header.frame_id, one.link_name, one.weight = "FRAME", "panda_link8", 1.0
pose = Pose()
pose.position.x, pose.position.y = found.translation.x, found.translation.y
pose.position.z = found.translation.z - 0.1
pose.orientation.w = 1.0
place.constraint_region.primitives = [
    SolidPrimitive(type=SolidPrimitive.SPHERE, dimensions=[0.001])]
place.constraint_region.primitive_poses = [pose]
turn.orientation = found.rotation
turn.absolute_x_axis_tolerance = turn.absolute_y_axis_tolerance = 0.01
turn.absolute_z_axis_tolerance = 0.01
goal = MoveGroup.Goal()
goal.request.group_name = "panda_arm"
goal.request.goal_constraints = [
    Constraints(position_constraints=[place], orientation_constraints=[turn])]
client = ActionClient(node, MoveGroup, "/move_action")
client.wait_for_server()
sent = client.send_goal_async(goal)
while not sent.done():
    time.sleep(0.05)
result = sent.result().get_result_async()
while not result.done():
    time.sleep(0.05)
"""


KINDS = {"other_frame", "other_link", "unlikely_turn", "unlikely_unit"}
TURNS = "from tf.transformations import euler_matrix, quaternion_from_euler\nimport PyKDL\n"


@pytest.fixture
def told(tmp_path: Path):
    def told(program: str):
        script = tmp_path / "press.py"
        script.write_text(program, encoding="utf-8")
        interfaces = Interfaces2() if "rclpy" in program else Interfaces()
        ran = quiet_end(
            *run_traced(script, interfaces, scene="empty", has_frames=True, duration_s=60.0)
        )
        return [each for each in ran.recording.findings if each.kind in KINDS]

    return told


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("what", WRONG)
def test_numbers_of_one_frame_given_as_of_another_are_told_of(told, what):
    (finding,) = told(COMMANDER + WRONG[what])
    assert finding.kind == "other_frame"
    assert "the planning frame" in finding.message or "frame 'panda_link0'" in finding.message
    assert f"as of frame '{finding.object}'" in finding.message
    assert finding.location.line >= LINE
    assert finding.kind in NOTES


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("what", RIGHT)
def test_numbers_that_belong_to_their_frame_are_not(told, what):
    assert not told(COMMANDER + RIGHT[what])


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(("frame", "number"), [("panda_link1", 1), ("panda_link0", 0)])
def test_constraints_of_a_goal_are_looked_at_too(told, frame, number):
    assert len(told(MOVE_GROUP.replace("FRAME", frame))) == number


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "steps",
    [
        'arm.set_pose_target(lowered(arm.get_current_pose("panda_hand_tcp").pose), "panda_link8")',
        'pose = looked_up("panda_link0", "panda_hand")\narm.set_pose_target(pose, "panda_hand_tcp")',
        'pose = looked_up("panda_link0", "panda_link8")\n'
        'pose.position.y += 0.1\narm.set_pose_target(stamped(pose, "world"), "panda_hand_tcp")',
    ],
)
def test_the_pose_of_another_link_of_the_same_body_is_told_of(told, steps):
    (finding,) = told(COMMANDER + steps)
    assert finding.kind == "other_link"
    assert "from it on the same body" in finding.message


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "steps",
    [
        'arm.set_pose_target(lowered(arm.get_current_pose("panda_hand_tcp").pose), '
        '"panda_hand_tcp")',
        # A link that the arm goes to, as to an object.
        'arm.set_pose_target(looked_up("panda_link0", "panda_link4"), "panda_link8")',
        # The way between the links is taken off.
        'pose = arm.get_current_pose("panda_hand_tcp").pose\npose.position.z += 0.1034 - 0.05\n'
        'arm.set_pose_target(pose, "panda_hand")',
        'here()\npose = arm.get_current_pose("panda_hand").pose\nhere()\n'
        'arm.set_pose_target(lowered(arm.get_current_pose("panda_link8").pose), "panda_link8")',
    ],
)
def test_the_pose_of_the_link_itself_is_not(told, steps):
    assert not told(COMMANDER + steps)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("steps", "words"),
    [
        (
            "p, q = here().position, here().orientation\n"
            "arm.set_pose_target([p.x, p.y, p.z, q.w, q.x, q.y, q.z])",
            "with w first",
        ),
        ("arm.set_pose_target(Pose(position=here().position))", "has length 0"),
        ("arm.set_pose_target([0.4, 0.1, 0.4, 1.0, 0.0, 0.0, 0.7])", "has length 1.22"),
    ],
)
def test_a_turn_that_is_none_is_told_of(told, steps, words):
    (finding,) = told(COMMANDER + steps)
    assert finding.kind == "unlikely_turn"
    assert words in finding.message


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "steps",
    [
        "arm.set_pose_target([0.4, 0.1, 0.4, 1.0, 0.0, 0.0, 0.0])",
        "arm.set_pose_target([0.4, 0.1, 0.4, 0.0, 1.0, 0.0, 0.0])",
        "arm.set_pose_target([0.4, 0.1, 0.4, 0.924, -0.383, 0.0, 0.0])",
        # Only the position is asked for.
        "arm.set_position_target([0.4, 0.1, 0.4])",
    ],
)
def test_a_whole_turn_is_not(told, steps):
    assert not told(COMMANDER + steps)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("steps", "name"),
    [
        ("quaternion_from_euler(180, 0, 45)", "quaternion_from_euler"),
        ("quaternion_from_euler(0.0, 90.0, 22.5)", "quaternion_from_euler"),
        ("euler_matrix(0, 0, -90)", "euler_matrix"),
        ("PyKDL.Rotation.RPY(180.0, 0.0, 0.0)", "Rotation.RPY"),
        ("arm.set_pose_target([0.4, 0.1, 0.4, 180, 0, 45])", "a pose of six numbers"),
        ("arm.set_rpy_target([180, 0, 90])", "set_rpy_target"),
    ],
)
def test_angles_in_degrees_are_told_of(told, steps, name):
    (finding,) = told(COMMANDER + TURNS + steps)
    assert (finding.kind, finding.object) == ("unlikely_unit", name)
    assert "(degrees?)" in finding.message


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "steps",
    [
        "quaternion_from_euler(3.14159, 0, -1.5708)",
        "quaternion_from_euler(3, 0, 1)",
        "quaternion_from_euler(0, 0, 7.123)",
        "arm.set_pose_target([0.4, 0.1, 0.4, 3.1416, 0, 0.785])",
    ],
)
def test_angles_in_radians_are_not(told, steps):
    assert not told(COMMANDER + TURNS + steps)
