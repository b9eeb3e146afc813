"""What a controller sends before anybody is connected is lost, named, and the run goes on."""

import textwrap

import pytest

from tests.slow import slow_but
from tracerisk import api
from tracerisk.config import Settings

ARM = """\
import moveit_commander
import rospy
from geometry_msgs.msg import PoseStamped
from moveit_msgs.msg import CollisionObject, PlanningScene
from std_msgs.msg import Float64MultiArray
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]
NAME = "/position_joint_trajectory_controller/command"


def trajectory(turn):
    made = JointTrajectory(joint_names=JOINTS)
    positions = [turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8]
    made.points = [JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(1.0))]
    return made


rospy.init_node("arm")
"""
ARM2 = """\
import time

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]
NAME = "/panda_arm_controller/joint_trajectory"


def trajectory(turn):
    made = JointTrajectory(joint_names=JOINTS)
    point = JointTrajectoryPoint(positions=[turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8])
    point.time_from_start.sec = 1
    made.points = [point]
    return made


rclpy.init()
node = rclpy.create_node("arm")
"""
COMMAND = "/position_joint_trajectory_controller/command"
LOST = [
    (
        "ROS 1, at once",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        publisher.publish(trajectory(0.4))  # here
        rospy.sleep(2.0)
        """,
        COMMAND,
    ),
    (
        "ROS 2, at once",
        ARM2,
        """
        publisher = node.create_publisher(JointTrajectory, NAME, 1)
        publisher.publish(trajectory(0.4))  # here
        time.sleep(2.0)
        """,
        "/panda_arm_controller/joint_trajectory",
    ),
    (
        "ROS 2, a goal",
        ARM2,
        """
        name = "/panda_arm_controller/follow_joint_trajectory"
        client = ActionClient(node, FollowJointTrajectory, name)
        goal = FollowJointTrajectory.Goal(trajectory=trajectory(0.4))
        future = client.send_goal_async(goal)  # here
        rclpy.spin_until_future_complete(node, future, timeout_sec=2.0)
        """,
        "/panda_arm_controller/follow_joint_trajectory",
    ),
    (
        "ROS 1, after other publishers and a commander",
        ARM,
        """
        arm = moveit_commander.MoveGroupCommander("panda_arm")
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        others = [rospy.Publisher(f"/other{n}", JointTrajectory, queue_size=1) for n in range(5)]
        publisher.publish(trajectory(0.4))  # here
        rospy.sleep(2.0)
        """,
        COMMAND,
    ),
    (
        "only the first of two",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        for turn in (0.4, -0.4):
            publisher.publish(trajectory(turn))  # here
            rospy.sleep(3.0)
        """,
        COMMAND,
    ),
    (
        "a latched one, and the program ends",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1, latch=True)
        publisher.publish(trajectory(0.4))  # here
        """,
        COMMAND,
    ),
    (
        "an obstacle",
        ARM,
        """
        arm = moveit_commander.MoveGroupCommander("panda_arm")
        scene = moveit_commander.PlanningSceneInterface(synchronous=False)
        pose = PoseStamped()
        pose.header.frame_id, pose.pose.orientation.w = "panda_link0", 1.0
        pose.pose.position.x = 0.6
        scene.add_box("wall", pose, size=(0.1, 0.1, 0.1))  # here
        rospy.sleep(1.0)
        assert scene.get_known_object_names() == []
        arm.go([0.2, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=True)
        """,
        "/collision_object",
    ),
]
SOUND = [
    (
        "ROS 1, waits for the connection",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        while not publisher.get_num_connections():
            rospy.sleep(0.05)
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 1, sleeps half a second",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        rospy.sleep(0.5)
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 1, latches",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1, latch=True)
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 1, a commander takes its time",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        scene = moveit_commander.PlanningSceneInterface(synchronous=False)
        arm = moveit_commander.MoveGroupCommander("panda_arm")
        pose = PoseStamped()
        pose.header.frame_id, pose.pose.orientation.w = "panda_link0", 1.0
        pose.pose.position.z = 2.0
        scene.add_box("lamp", pose, size=(0.1, 0.1, 0.1))
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        assert scene.get_known_object_names() == ["lamp"]
        """,
    ),
    (
        "ROS 1, the robot is loaded",
        ARM,
        """
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        robot = moveit_commander.RobotCommander()
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 1, a plan is made",
        ARM,
        """
        arm = moveit_commander.MoveGroupCommander("panda_arm")
        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        assert arm.plan([0.2, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785])[0]
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 1, another server is waited for",
        ARM,
        """
        import actionlib
        from control_msgs.msg import FollowJointTrajectoryAction

        publisher = rospy.Publisher(NAME, JointTrajectory, queue_size=1)
        name = "/position_joint_trajectory_controller/follow_joint_trajectory"
        actionlib.SimpleActionClient(name, FollowJointTrajectoryAction).wait_for_server()
        publisher.publish(trajectory(0.4))
        rospy.sleep(2.0)
        """,
    ),
    (
        "ROS 2, clients are made and their packages imported",
        ARM2,
        """
        publisher = node.create_publisher(JointTrajectory, NAME, 1)
        from moveit_msgs.srv import GetPositionIK
        from std_srvs.srv import Trigger

        solver = node.create_client(GetPositionIK, "/compute_ik")
        ActionClient(node, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
        publisher.publish(trajectory(0.4))
        time.sleep(2.0)
        """,
    ),
    (
        "ROS 1, a stream",
        ARM,
        """
        name = "/joint_group_position_controller/command"
        publisher = rospy.Publisher(name, Float64MultiArray, queue_size=1)
        rate = rospy.Rate(50)
        for step in range(100):
            angle = 0.002 * step
            publisher.publish(Float64MultiArray(data=[angle, -0.56, 0.0, -2.6, 0.0, 2.0, 0.785]))
            rate.sleep()
        """,
    ),
    (
        "ROS 2, waits for the connection",
        ARM2,
        """
        publisher = node.create_publisher(JointTrajectory, NAME, 1)
        while not publisher.get_subscription_count():
            time.sleep(0.05)
        publisher.publish(trajectory(0.4))
        time.sleep(2.0)
        """,
    ),
    (
        "ROS 2, in a timer",
        ARM2,
        """
        publisher = node.create_publisher(JointTrajectory, NAME, 1)
        timer = node.create_timer(0.5, lambda: (publisher.publish(trajectory(0.4)), timer.cancel()))
        end = time.time() + 3.0
        while time.time() < end:
            rclpy.spin_once(node, timeout_sec=0.1)
        """,
    ),
]


def trace_of(folder, head, body):
    path = folder / "arm.py"
    path.write_text(head + textwrap.dedent(body))
    (folder / "pyproject.toml").touch()
    trace = api.trace_controller(api.load_controller(path), Settings(robot="panda"))
    return path.read_text().splitlines(), trace


@pytest.mark.parametrize(("title", "head", "body", "name"), slow_but(LOST[:3], LOST))
def test_what_was_lost_is_a_reason_with_its_line(tmp_path, title, head, body, name):
    lines, trace = trace_of(tmp_path, head, body)
    assert trace.verdict.kind == "faulted"
    (reason,) = (reason for reason in trace.verdict.reasons if reason.code == "sent-early")
    assert "reached nobody" in reason.words
    assert reason.object == name
    assert lines[reason.location.line - 1].endswith("# here")
    assert trace.end.cause == "ended"


@pytest.mark.parametrize(
    ("title", "head", "body"), slow_but([SOUND[i] for i in (0, 3, 7, 8)], SOUND)
)
def test_who_waits_latches_or_streams_loses_nothing(tmp_path, title, head, body):
    _, trace = trace_of(tmp_path, head, body)
    assert [reason.words for reason in trace.verdict.open_reasons] == []
    assert trace.commands


NUDGE = """\
import baxter_interface
import rospy

JOINTS = [f"right_{joint}" for joint in ("s0", "s1", "e0", "e1", "w0", "w1", "w2")]
NEUTRAL = dict(zip(JOINTS, [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0]))
BENCH = {**NEUTRAL, "right_s0": 0.9}

rospy.init_node("nudge")
limb = baxter_interface.Limb("right")
"""


def test_a_blocking_motion_to_where_the_arm_begins_is_not_over_before_the_connection(tmp_path):
    """Where a real arm stands before nobody knows: it would have had to go there."""
    (tmp_path / "pyproject.toml").touch()
    path = tmp_path / "nudge.py"
    path.write_text(
        f"{NUDGE}limb.move_to_joint_positions(NEUTRAL)\n"
        "limb.move_to_joint_positions(BENCH, timeout=0.0)\nrospy.sleep(1.0)\n"
        "assert 0.004 < limb.joint_angle('right_s0') < 0.03\n"
    )
    trace = api.trace_controller(api.load_controller(path), Settings(robot="baxter"))
    assert [reason.words for reason in trace.verdict.open_reasons] == []


def test_a_nudge_of_a_new_limb_reaches_nobody(tmp_path):
    (tmp_path / "pyproject.toml").touch()
    path = tmp_path / "nudge.py"
    path.write_text(f"{NUDGE}limb.move_to_joint_positions(BENCH, timeout=0.0)\nrospy.sleep(1.0)\n")
    trace = api.trace_controller(api.load_controller(path), Settings(robot="baxter"))
    assert [reason.code for reason in trace.verdict.reasons] == ["sent-early", "no-command"]


def test_a_library_whose_import_makes_all_its_clients_is_connected_by_the_first_call(tmp_path):
    (tmp_path / "pyproject.toml").touch()
    path = tmp_path / "moves.py"
    path.write_text(
        'import rclpy\nimport DR_init\n\nDR_init.__dsr__id, DR_init.__dsr__model = "d", "m0609"\n'
        'rclpy.init()\nDR_init.__dsr__node = rclpy.create_node("moves", namespace="d")\n'
        "from DSR_ROBOT2 import movej, set_velj\n\n"
        "set_velj(30)\nassert movej([0, 0, 90, 0, 90, 10], vel=30, acc=60) == 0\n"
    )
    trace = api.trace_controller(api.load_controller(path), Settings(robot="m0609"))
    assert "sent-early" not in {reason.code for reason in trace.verdict.reasons}
    assert [command.end for command in trace.commands] == ["arrived"]


def test_what_a_maker_s_library_sends_when_it_is_made_is_the_author_s_no_fault(tmp_path):
    script = tmp_path / "arms.py"
    script.write_text(
        "import baxter_interface, rospy\n"
        "rospy.init_node('arms')\n"
        "for side in ('left', 'right'):\n"
        "    baxter_interface.Gripper(side).close()\n"
        "baxter_interface.Limb('left').move_to_neutral()\n"
    )
    trace = api.trace_controller(api.load_controller(script), Settings())
    assert trace.verdict.reasons == ()
