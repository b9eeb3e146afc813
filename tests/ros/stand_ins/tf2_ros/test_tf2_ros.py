"""tf and tf2 as programs use them, on the twin in virtual time."""

import math

import pytest

START = """\
import math, rospy, tf, tf2_ros, tf2_geometry_msgs, moveit_commander
from geometry_msgs.msg import PoseStamped, PointStamped, TransformStamped, Vector3Stamped
rospy.init_node("c")
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
latest = rospy.Time(0)

def transform(parent, child, x, stamp=None):
    t = TransformStamped()
    t.header.frame_id, t.child_frame_id = parent, child
    t.header.stamp = rospy.Time.now() if stamp is None else stamp
    t.transform.translation.x, t.transform.rotation.w = x, 1.0
    return t
"""


@pytest.fixture
def succeed(example):
    """Run a program and require that all its assertions hold."""

    def run(program: str) -> None:
        example.write("program.py", START + program)
        outcome = example.run("trace", "program.py", "--robot", "panda", "--json")
        # Some look-ups are meant to fail, which makes the run faulted.
        assert outcome.json["trace"]["end"]["cause"] == "ended", outcome.err

    return run


def test_the_frames_of_the_twin_are_where_its_kinematics_are(succeed):
    succeed("""
arm = moveit_commander.MoveGroupCommander("panda_arm")
joints = arm.get_current_joint_values(); joints[0] += 0.3; joints[3] += 0.2
arm.set_max_velocity_scaling_factor(1.0); arm.go(joints, wait=True); rospy.sleep(1.0)
found = buffer.lookup_transform("panda_link0", "panda_hand_tcp", latest, rospy.Duration(1))
pose = arm.get_current_pose("panda_hand_tcp").pose
t, p = found.transform.translation, pose.position
assert max(abs(t.x - p.x), abs(t.y - p.y), abs(t.z - p.z)) < 1e-6, (t, p)
r, q = found.transform.rotation, pose.orientation
assert abs(abs(r.x*q.x + r.y*q.y + r.z*q.z + r.w*q.w) - 1) < 1e-9
assert found.header.frame_id == "panda_link0" and found.child_frame_id == "panda_hand_tcp"
for link in moveit_commander.RobotCommander().get_link_names():
    assert buffer.can_transform("world", link, latest), link
assert repr(buffer.can_transform("world", "panda_hand_tcp", latest)) == "1"
assert repr(buffer.can_transform("world", "nowhere", latest)) == "0"
there = buffer.transform(arm.get_current_pose("panda_hand_tcp"), "panda_hand_tcp", rospy.Duration(1))
assert abs(there.pose.position.x) < 1e-3 and abs(there.pose.orientation.w) > 0.999
""")


def test_a_timeout_is_waited_for_in_virtual_time_and_not_beyond_the_answer(succeed):
    succeed("""
began = rospy.get_time()
try:
    buffer.lookup_transform("world", "nose", latest, rospy.Duration(2.5))
    raise SystemExit("found")
except tf2_ros.LookupException as error:
    assert "nose" in str(error)
lasted = rospy.get_time() - began
assert 2.5 <= lasted < 2.51, lasted
now = rospy.Time.now()
try:
    buffer.lookup_transform("world", "panda_hand", now + rospy.Duration(1))
    raise SystemExit("found")
except tf2_ros.ExtrapolationException as error:
    assert "into the future" in str(error)
buffer.lookup_transform("world", "panda_hand", now + rospy.Duration(1), rospy.Duration(5))
lasted = (rospy.Time.now() - now).to_sec()
assert 0.99 < lasted < 1.05, lasted
try:
    buffer.lookup_transform("world", "panda_hand", latest, 1.0)
    raise SystemExit("a number is not a Duration")
except TypeError as error:
    assert "Duration of rospy" in str(error)
""")


def test_a_busy_loop_for_a_frame_lets_time_pass_and_sees_the_frame_when_it_comes(succeed):
    succeed("""
began, looks = rospy.get_time(), 0
broadcaster = tf2_ros.TransformBroadcaster()
rospy.Timer(
    rospy.Duration(5.01),
    lambda _: broadcaster.sendTransform(transform("world", "nose", 0.1)),
    oneshot=True,
)
while not rospy.is_shutdown():
    try:
        buffer.lookup_transform("world", "nose", latest)
        break
    except tf2_ros.LookupException:
        looks += 1
assert 5.01 <= rospy.get_time() - began < 5.03, rospy.get_time() - began
assert looks < 1150, looks
""")


@pytest.mark.slow
def test_a_few_tries_without_a_wait_do_not_wait_for_a_frame_that_comes_later(succeed):
    succeed("""
broadcaster = tf2_ros.TransformBroadcaster()
rospy.Timer(
    rospy.Duration(2.0),
    lambda _: broadcaster.sendTransform(transform("world", "nose", 0.1)),
    oneshot=True,
)
began, looks = rospy.get_time(), 0
for _ in range(100):
    try:
        buffer.lookup_transform("world", "nose", latest)
    except tf2_ros.LookupException:
        looks += 1
assert looks == 100
assert rospy.get_time() - began < 0.5, rospy.get_time() - began
""")


def test_what_a_program_broadcasts_is_found_again(succeed):
    succeed("""
tf2_ros.StaticTransformBroadcaster().sendTransform(transform("panda_hand", "camera", 0.1))
moving = tf2_ros.TransformBroadcaster()
rospy.sleep(0.5)
for x in (1.0, 2.0):
    moving.sendTransform(transform("camera", "part", x)); rospy.sleep(0.1)
found = buffer.lookup_transform("panda_hand", "part", latest)
assert abs(found.transform.translation.x - 2.1) < 1e-9, found
middle = found.header.stamp - rospy.Duration(0.05)
assert abs(buffer.lookup_transform("camera", "part", middle).transform.translation.x - 1.5) < 0.02
point = PointStamped(); point.header.frame_id = "part"; point.point.y = 1.0
moved = buffer.transform(point, "panda_hand")
assert abs(moved.point.x - 2.1) < 1e-9 and moved.point.y == 1.0 and moved.header.frame_id == "panda_hand"
vector = Vector3Stamped(); vector.header.frame_id = "part"; vector.vector.z = 1.0
assert buffer.transform(vector, "panda_hand").vector.x == 0.0
try:
    buffer.transform(found, "world"); raise SystemExit("transformed")
except tf2_ros.TypeException as error:
    assert "not loaded or supported" in str(error)
""")


def test_tf_of_ros_1_answers_in_lists(succeed):
    succeed("""
old = tf.TransformListener()
broadcaster = tf.TransformBroadcaster()
rospy.sleep(0.5)
broadcaster.sendTransform((0, 0, 1), tf.transformations.quaternion_from_euler(0, 0, math.pi / 2), rospy.Time.now(), "/tool", "panda_link0")
old.waitForTransform("/panda_link0", "/tool", latest, rospy.Duration(4))
place, turn = old.lookupTransform("/panda_link0", "/tool", latest)
assert place == [0.0, 0.0, 1.0] and abs(turn[3] - math.sqrt(0.5)) < 1e-9
assert old.canTransform("world", "tool", latest) and old.frameExists("tool")
pose = PoseStamped(); pose.header.frame_id = "tool"; pose.pose.position.x = 1.0; pose.pose.orientation.w = 1.0
moved = old.transformPose("world", pose).pose
assert abs(moved.position.y - 1.0) < 1e-9 and abs(moved.position.z - 1.0) < 1e-9
try:
    old.waitForTransform("world", "nose", latest, rospy.Duration(0.5)); raise SystemExit("found")
except tf.Exception as error:
    assert "nose" in str(error)
while True:
    try:
        old.lookupTransform("world", "panda_hand", rospy.Time.now()); break
    except (tf.LookupException, tf.ConnectivityException, tf.ExtrapolationException):
        continue
""")


def test_a_twist_is_that_of_the_motion(succeed):
    succeed("""
still = tf.TransformerROS()
for i in range(11):
    t = transform("base", "wheel", 0.5 * i * 0.1, rospy.Time(1 + 0.1 * i))
    t.transform.rotation.z, t.transform.rotation.w = math.sin(0.1 * i), math.cos(0.1 * i)
    still.setTransform(t)
linear, angular = still.lookupTwist("wheel", "base", rospy.Time(1.5), rospy.Duration(0.4))
assert abs(linear[0] - 0.5) < 1e-6 and abs(angular[2] - 2.0) < 1e-6, (linear, angular)
try:
    still.waitForTransform("base", "wheel", latest, rospy.Duration(1)); raise SystemExit("waited")
except tf.Exception as error:
    assert "dedicated thread" in str(error)
""")


def test_a_buffer_is_asked_by_an_action_too(succeed):
    succeed("""
import actionlib, tf2_msgs.msg
def answer(goal):
    result = tf2_msgs.msg.LookupTransformResult()
    if goal.source_frame == "nose":
        result.error.error, result.error.error_string = result.error.LOOKUP_ERROR, "no nose"
    result.transform.child_frame_id = goal.source_frame
    server.set_succeeded(result)
server = actionlib.SimpleActionServer("buffer", tf2_msgs.msg.LookupTransformAction, answer, False)
server.start()
client = tf2_ros.BufferClient("buffer")
assert client.wait_for_server(rospy.Duration(2))
assert client.lookup_transform("world", "hand", latest).child_frame_id == "hand"
assert not client.can_transform("world", "nose", latest)
rospy.signal_shutdown("the server would keep the process alive")
""")


def test_quaternions_of_ros_2_are_tuples():
    from tracerisk.ros.stand_ins import tf_transformations as ros2

    half = math.sqrt(0.5)
    assert ros2.quaternion_from_euler(0, 0, math.pi / 2) == pytest.approx((0, 0, half, half))
    assert isinstance(ros2.quaternion_multiply((0, 0, 0, 1), (1, 0, 0, 0)), tuple)
    turned = ros2.quaternion_from_matrix(ros2.euler_matrix(3.0, 0.1, -2.0))
    assert turned[3] >= 0.0
    assert ros2.euler_from_quaternion(turned) == pytest.approx((3.0, 0.1, -2.0))
