"""How commands end, in whole runs: what was replaced, left on, aborted or cut is a reason."""

import pytest

ARM2 = """\
import sys, time
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{n}" for n in range(1, 8)]
REST = [-0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
rclpy.init()
node = Node("mission")
arm = ActionClient(node, FollowJointTrajectory, "/arm/follow_joint_trajectory")
arm.wait_for_server()
topic = node.create_publisher(JointTrajectory, "/arm/joint_trajectory", 10)

def wait(seconds):
    end = node.get_clock().now().nanoseconds + seconds * 1e9
    while node.get_clock().now().nanoseconds < end:
        rclpy.spin_once(node, timeout_sec=0.02)

def way(turn, seconds=2.0):
    whole, rest = int(seconds), seconds - int(seconds)
    return JointTrajectory(joint_names=JOINTS, points=[JointTrajectoryPoint(
        positions=[turn, *REST],
        time_from_start=Duration(sec=whole, nanosec=int(rest * 1e9)))])

def send(turn):
    return arm.send_goal_async(FollowJointTrajectory.Goal(trajectory=way(turn)))

send(0.0)
wait(4.0)
"""
VELOCITY = """\
import rospy
from controller_manager_msgs.srv import SwitchController, SwitchControllerRequest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64, Float64MultiArray

rospy.init_node("jog")
group = rospy.Publisher("/joint_group_vel_controller/command", Float64MultiArray, queue_size=10)
rospy.ServiceProxy("/controller_manager/switch_controller", SwitchController)(
    SwitchControllerRequest(
        start_controllers=["joint_group_vel_controller"],
        stop_controllers=["scaled_pos_joint_traj_controller"], strictness=2))
rospy.sleep(0.5)

def jog(speed, times=10):
    for _ in range(times):
        group.publish(Float64MultiArray(data=[0.0, 0.0, 0.0, 0.0, 0.0, speed]))
        rospy.sleep(0.1)

"""
FRANKA = """\
import actionlib, moveit_commander, rospy
from franka_gripper.msg import GraspAction, GraspGoal, MoveAction, MoveGoal

rospy.init_node("grasp")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
move = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
grasp = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
move.wait_for_server()
grasp.wait_for_server()
move.send_goal_and_wait(MoveGoal(width=0.08, speed=0.1))
"""
AT_THE_CUBE = """\
pose = arm.get_current_pose().pose
turn = pose.orientation
turn.x, turn.y, turn.z, turn.w = 0.9238795, -0.3826834, 0.0, 0.0
for z in (0.2, 0.125):
    pose.position.x, pose.position.y, pose.position.z = 0.5, 0.0, z
    arm.set_pose_target(pose)
    arm.go(wait=True)
"""
CUBE = "objects:\n  - {name: cube, box: [0.04, 0.04, 0.04], xyz: [0.5, 0.0, 0.02], mass: 0.1}\n"


@pytest.fixture
def run(example):
    def run(program: str, *arguments: str, robot: str = "panda"):
        example.write("c.py", program)
        example.write("cell.yaml", CUBE)
        outcome = example.run("run", "c.py", "--robot", robot, "--json", *arguments)
        assert outcome.code in (0, 1), outcome.err
        return outcome.json["trace"]

    return run


def reasons(trace, *codes: str) -> list[tuple[str, str]]:
    """The code and the words of each reason that is about how a command ended."""
    found = [(each["code"], each["words"]) for each in trace["verdict"]["reasons"]]
    return [each for each in found if each[0].startswith("command-") or each[0] in codes]


def ends(trace) -> list[str]:
    return [each["end"] for each in trace["commands"]]


def line_of(program: str, text: str) -> int:
    return program.splitlines().index(text) + 1


# Replaced


def test_goals_that_are_sent_at_once_are_replaced_before_they_begin(run):
    trace = run(ARM2 + "for turn in (0.6, -0.6, 0.0):\n    send(turn)\nrclpy.spin(node)\n")
    assert ends(trace) == ["arrived", "replaced", "replaced", "arrived"]
    (found,) = reasons(trace)
    assert found[0] == "command-replaced"
    assert "had come 0 % of its way when it was replaced at once" in found[1]
    assert trace["verdict"]["kind"] == "partial"
    # The last one led to where the arm was: nothing of the mission is left.
    first, second, third = trace["commands"][1:]
    assert (first["replaced_by"], second["replaced_by"], third["replaced_by"]) == (2, 3, None)


CUT = (
    ARM2
    + "send(0.8)\nwait(1.0)\nsend(-0.8)\nwait(4.0)\n"
    + "def left():\n    topic.publish(way(0.7))\n\n"
    + "def right():\n    topic.publish(way(-0.7))\n\n"
    + "left()\nwait(0.5)\nright()\nwait(4.0)\n"
)


def test_a_goal_that_another_line_cuts_and_a_message_that_another_overtakes_are_replaced(run):
    trace = run(CUT)
    assert ends(trace) == ["arrived", "replaced", "arrived", "replaced", "arrived"]
    goal, message = (each for each in trace["verdict"]["reasons"] if "replaced" in each["code"])
    assert [goal["code"], message["code"]] == ["command-replaced"] * 2
    assert (goal["function"], message["function"]) == ("send", "left")
    assert trace["commands"][1]["way_done"] == pytest.approx(0.5, abs=0.1)
    # Both goals are of `send`: the lines of its calls tell them apart.
    assert goal["by"]["line"] == trace_line(trace, CUT, "send(-0.8)")


def trace_line(trace, program: str, text: str) -> int:
    """The line of a text once the block is above it, by the shift of the command's own line."""
    issued = "    return arm.send_goal_async(FollowJointTrajectory.Goal(trajectory=way(turn)))"
    return line_of(program, text) + trace["commands"][0]["line"] - line_of(program, issued)


def test_a_motion_of_moveit_is_stopped_by_that_of_another_group(run):
    trace = run(FRANKA + "arm.go([0.9, 0, 0, -2.0, 0, 1.571, 0.785], wait=False)\n"
                "rospy.sleep(0.3)\nhand = moveit_commander.MoveGroupCommander('panda_hand')\n"
                "hand.go([0.01, 0.01], wait=True)\n")  # fmt: skip
    assert ends(trace) == ["arrived", "replaced", "arrived"]
    assert [code for code, _ in reasons(trace)] == ["command-replaced"]


# Each part with its commands' ends. No goal of a part is sent again in another, which would be
# another reason to excuse that it was cut.
EXCUSED = {
    "a loop that tracks something leads on from goal to goal": (
        "for step in range(12):\n    topic.publish(way(0.05 * step, 1.0))\n    wait(0.1)\nwait(3.0)\n",
        [*["replaced"] * 11, "arrived"],
    ),
    "so do goals of an action": (
        "for step in range(8):\n    send(0.08 * step)\n    wait(0.3)\nwait(4.0)\n",
        [*["replaced"] * 7, "arrived"],
    ),
    "who publishes a message three times is to be heard": (
        "for _ in range(3):\n    topic.publish(way(-0.2))\nwait(4.0)\n",
        ["replaced", "replaced", "arrived"],
    ),
    "it had practically arrived": (
        "send(0.7)\nwait(1.95)\nsend(-0.3)\nwait(4.0)\n",
        ["replaced", "arrived"],
    ),
    "the controller stopped it": (
        "goal = send(0.9)\nrclpy.spin_until_future_complete(node, goal)\nwait(0.5)\n"
        "goal.result().cancel_goal_async()\nwait(2.0)\nsend(-0.4)\nwait(4.0)\n",
        ["cancelled", "arrived"],
    ),
    "what was left was less than a cell can tell": (
        "send(-0.43)\nwait(1.5)\nsend(-0.1)\nwait(4.0)\n",
        ["replaced", "arrived"],
    ),
    "what was cut was sent again": (
        "send(1.1)\nwait(0.5)\nsend(-0.5)\nwait(4.0)\nsend(1.1)\nwait(4.0)\n",
        ["replaced", "arrived", "arrived"],
    ),
    "a stream of set points is one command to where it led in the end": (
        "for step in range(50):\n    topic.publish(way(1.1 - 0.01 * step, 0.1))\n    wait(0.02)\n"
        "wait(2.0)\n",
        ["arrived"],
    ),
}


@pytest.fixture(scope="module")
def excused(tmp_path_factory, example_in):
    """One run in which command after command is cut or stopped with an excuse."""
    example = example_in(tmp_path_factory.mktemp("excused"))
    example.write("c.py", ARM2 + "".join(body for body, _ in EXCUSED.values()))
    outcome = example.run("run", "c.py", "--robot", "panda", "--json")
    assert outcome.code == 0, outcome.err
    return outcome.json["trace"]


@pytest.mark.slow
def test_what_leads_on_was_there_or_was_stopped_is_no_reason(excused):
    assert reasons(excused) == []
    left = ends(excused)[1:]
    for part, (_, own) in EXCUSED.items():
        assert left[: len(own)] == own, part
        del left[: len(own)]
    assert left == []


def test_the_speed_of_a_generic_arm_says_nothing_of_what_it_did_not_reach(run):
    """What is cut after a second is excused; what is replaced at once was never on its way."""
    trace = run(
        ARM2 + "send(0.8)\nwait(1.0)\nsend(-0.8)\nwait(4.0)\nsend(0.6)\nwait(0.0)\nsend(-0.6)\n"
        "wait(4.0)\n",
        *("--robot", "generic"),
    )
    (reason,) = (
        each for each in trace["verdict"]["reasons"] if each["code"].startswith("command-")
    )
    assert reason["code"] == "command-replaced"
    assert ends(trace) == ["arrived", "replaced", "arrived", "replaced", "arrived"]
    assert reason["time_s"] == trace["commands"][3]["issue_s"]


# Left on


def test_a_velocity_that_nobody_takes_back_is_left_on_to_the_limit(run):
    trace = run(VELOCITY + "jog(0.3)\n", robot="ur5e")
    assert ends(trace) == ["left_on"]
    ((code, words),) = reasons(trace)
    assert code == "command-left-on"
    assert "joint 'wrist_3_joint' (0.3 rad/s) was left on" in words
    assert "until its limit" in words
    assert trace["verdict"]["kind"] == "faulted"


@pytest.mark.slow
def test_a_velocity_that_is_on_when_the_controller_waits_for_ever_is_left_on(run):
    trace = run(VELOCITY + "jog(-0.1, 3)\nrospy.spin()\n", "--duration", "20", robot="ur5e")
    assert ends(trace) == ["left_on"]
    ((code, words),) = reasons(trace)
    assert code == "command-left-on"
    assert "up to the end of the run" in words


@pytest.mark.slow
def test_a_single_message_of_one_joints_velocity_is_left_on(run):
    trace = run(
        VELOCITY + "one = rospy.Publisher('/wrist_1_joint_velocity_controller/command', Float64, "
        "queue_size=1)\nrospy.sleep(0.5)\none.publish(1.0)\nrospy.sleep(3.0)\n",
        robot="ur5e",
    )
    assert ends(trace) == ["left_on"]
    ((_, words),) = reasons(trace)
    assert "'wrist_1_joint' (1 rad/s)" in words


def test_a_velocity_that_is_taken_back_is_no_reason(run):
    # Another velocity is no miss of the first: neither has a goal.
    trace = run(
        VELOCITY + "jog(0.3)\njog(0.0, 1)\nrospy.sleep(0.5)\n"
        "jog(0.3)\nrospy.sleep(0.5)\njog(-0.3, 5)\njog(0.0, 1)\n",
        robot="ur5e",
    )
    assert ends(trace) == ["cancelled", "replaced", "cancelled"]
    assert reasons(trace) == []


def test_a_loop_of_velocities_that_the_duration_cuts_was_not_left_on(run):
    trace = run(
        VELOCITY + "while not rospy.is_shutdown():\n    jog(0.2)\n    jog(-0.2)\n",
        "--duration",
        "4.5",
        robot="ur5e",
    )
    assert ends(trace)[-1] == "cut_by_end"
    assert reasons(trace) == []


# Aborted


def test_a_gripper_that_does_not_come_to_what_it_was_asked_for_is_a_fault(run):
    trace = run(
        # A grasp of the right width is none.
        FRANKA + AT_THE_CUBE + "goal = GraspGoal(width=0.04, speed=0.05, force=10.0)\n"
        "goal.epsilon.inner = goal.epsilon.outer = 0.005\ngrasp.send_goal_and_wait(goal)\n"
        "move.send_goal_and_wait(MoveGoal(width=0.08, speed=0.1))\n"
        "grasp.send_goal_and_wait(GraspGoal(width=0.0, speed=0.05, force=10.0))\n"
        "goal = GraspGoal(width=0.02, speed=0.05, force=0.0)\n"
        "goal.epsilon.inner = goal.epsilon.outer = 0.005\ngrasp.send_goal_and_wait(goal)\n"
        # A move is no grasp: it is to get there.
        "move.send_goal_and_wait(MoveGoal(width=0.01, speed=0.05))\n",
        "--scenario",
        "cell.yaml",
    )
    assert ends(trace) == [*["arrived"] * 5, *["aborted"] * 3]
    codes, words = zip(*reasons(trace), strict=True)
    assert codes == ("command-aborted",) * 3
    stopped = "the fingers stopped at a width of 0.0399 m; width and epsilon allow "
    assert f"{stopped}0.0000 to 0.0000 m" in words[0]
    assert f"{stopped}0.0150 to 0.0250 m" in words[1]
    assert "stalled at" in words[2]
    assert trace["verdict"]["kind"] == "faulted"


def test_a_path_that_is_left_ends_aborted_and_not_cancelled(run):
    trace = run(
        ARM2.replace("import rclpy\n", "import rclpy\nfrom control_msgs.msg import "
                     "JointTolerance\n", 1)
        + "goal = FollowJointTrajectory.Goal(trajectory=way(1.5, 0.3))\n"
        "goal.path_tolerance = [JointTolerance(name='panda_joint1', position=0.001)]\n"
        "arm.send_goal_async(goal)\nwait(3.0)\n"
    )  # fmt: skip
    assert ends(trace) == ["arrived", "aborted"]
    ((code, words),) = reasons(trace)
    assert code == "command-aborted"
    assert "off its path (tolerance 0.001)" in words


# Refused, ignored, cut


def test_each_refused_goal_of_a_line_is_a_command_and_a_stream_of_messages_is_one(run):
    body = (
        "bad = way(0.3)\nbad.joint_names = ['elbow', *JOINTS[1:]]\n"
        "for _ in range(3):\n"
        "    arm.send_goal_async(FollowJointTrajectory.Goal(trajectory=bad))\n    wait(0.5)\n"
        "for pause in (0.1, 0.1, 1.0, 0.1):\n    topic.publish(bad)\n    wait(pause)\n"
    )
    trace = run(ARM2 + body)
    assert ends(trace) == ["arrived", *["refused"] * 3, *["ignored"] * 2]
    assert [code for code, _ in reasons(trace)] == ["command-rejected", "command-ignored"]
    # They moved nothing: neither visits nor functions know of them.
    assert [each["elements"] for each in trace["commands"][1:]] == [[]] * 5
    (visit,) = trace["visits"]
    assert visit["function"]["name"] == "send"
    (plain,) = run(ARM2)["visits"]
    assert visit["exposures"].keys() == plain["exposures"].keys()


def test_a_motion_that_the_end_of_the_run_cuts_is_a_reason_if_the_controller_was_done(run):
    trace = run(ARM2 + "arm.send_goal_async(FollowJointTrajectory.Goal(trajectory=way(2.0, 9.0)))\n"
                "wait(0.2)\n", "--duration", "7")  # fmt: skip
    assert ends(trace) == ["arrived", "cut_by_end"]
    ((code, words),) = reasons(trace)
    assert code == "command-cut"
    assert "of its way when the run ended" in words


def test_a_motion_that_the_duration_cuts_amid_the_mission_is_none(run):
    trace = run(ARM2 + "send(1.0)\nwait(30.0)\n", "--duration", "5")
    assert ends(trace) == ["arrived", "cut_by_end"]
    assert reasons(trace) == []
