"""The twin's action servers, as programs use them."""

import pytest

PREAMBLE = """\
import actionlib, rospy
from actionlib_msgs.msg import GoalStatus
from control_msgs.msg import (
    FollowJointTrajectoryAction, FollowJointTrajectoryGoal, GripperCommandAction,
    GripperCommandGoal, JointTolerance)
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]

def goal_to(positions, seconds=2.0, joints=JOINTS):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = joints
    goal.trajectory.points.append(
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(seconds)))
    return goal

def measured():
    state = rospy.wait_for_message("/joint_states", JointState)
    return dict(zip(state.name, state.position))

rospy.init_node("controller")
arm = actionlib.SimpleActionClient("/whatever/follow_joint_trajectory", FollowJointTrajectoryAction)
hand = actionlib.SimpleActionClient("gripper", GripperCommandAction)
"""


@pytest.fixture
def ran(run_on_twin):
    return lambda program, **options: run_on_twin(PREAMBLE + program, **options)


def test_a_trajectory_is_followed_under_any_action_name(ran):
    result = ran("""
arm.wait_for_server()
feedback = []
began = rospy.get_time()
arm.send_goal(goal_to(READY), feedback_cb=feedback.append)
reached = arm.wait_for_result(rospy.Duration(10))
lasted = rospy.get_time() - began
state, code = arm.get_state(), arm.get_result().error_code
here = measured()
""")
    assert (result["reached"], result["state"], result["code"]) == (True, 3, 0)
    assert 2.0 <= result["lasted"] < 2.6
    assert result["here"]["panda_joint4"] == pytest.approx(-2.356, abs=0.005)
    seen = result["feedback"]
    assert 35 < len(seen) < 55
    assert seen[10].joint_names[0] == "panda_joint1"
    assert abs(seen[20].error.positions[3]) < 0.02
    assert abs(seen[20].desired.velocities[3]) > 0.05
    (command,) = result.recording.commands
    assert command.elements == tuple(f"panda_joint{i}" for i in range(1, 8))
    assert command.end == "arrived"


@pytest.mark.parametrize(
    ("made", "meant"),
    [
        (
            "actionlib.SimpleActionClient('/left/panda_arm_controler/follow_joint_trajectory', "
            "FollowJointTrajectoryAction)",
            "/left/panda_arm_controller/follow_joint_trajectory",
        ),
        (
            "actionlib.SimpleActionClient('panda_hand_controller/griper_cmd', GripperCommandAction)",
            "/panda_hand_controller/gripper_cmd",
        ),
        (
            "rospy.Publisher('/panda_arm_contoller/command', JointTrajectory, queue_size=1)",
            "/panda_arm_controller/command",
        ),
        (
            "actionlib.SimpleActionClient('exexute_trajectory', ExecuteTrajectoryAction)",
            "/execute_trajectory",
        ),
        # A robot's own name is nobody's mistake, nor is one that is no slip.
        (
            "actionlib.SimpleActionClient('/panda_arm_controller/follow_joint_trajectory', "
            "FollowJointTrajectoryAction)",
            None,
        ),
        (
            "actionlib.SimpleActionClient('/uanda_arm_controller/follow_joint_trajectory', "
            "FollowJointTrajectoryAction)",
            None,
        ),
        ("rospy.Publisher('/right_arm_controller/command', JointTrajectory, queue_size=1)", None),
    ],
)
def test_a_name_that_is_likely_misspelt_is_reported(ran, made, meant):
    result = ran(f"from moveit_msgs.msg import ExecuteTrajectoryAction\nmade = {made}")
    found = [finding for finding in result.recording.findings if finding.kind == "name_assumed"]
    assert [f"is likely a mistake for {meant}: " in finding.message for finding in found] == (
        [] if meant is None else [True]
    )


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("goal", "code", "expected"),
    [
        ("goal_to(READY, joints=['elbow'] + JOINTS[1:])", -2, "has no joint 'elbow'"),
        ("goal_to(READY[:6])", -1, "6 positions for 7 joints"),
        ("FollowJointTrajectoryGoal()", -2, "has no joints"),
        ("late()", -1, "comes 2.000 s before the present"),
        ("falling()", -1, "do not rise"),
    ],
)
def test_a_goal_that_no_controller_follows_is_rejected_with_its_code(ran, goal, code, expected):
    result = ran(f"""
def late():
    goal = goal_to(READY)
    rospy.sleep(5.0)
    goal.trajectory.header.stamp = rospy.Time.now() - rospy.Duration(4.0)
    return goal

def falling():
    goal = goal_to(READY)
    goal.trajectory.points.append(goal.trajectory.points[0])
    return goal

state = arm.send_goal_and_wait({goal})
code = arm.get_result().error_code
""")
    assert (result["state"], result["code"]) == (5, code)
    assert any(expected in message for message in result.findings)
    assert result.recording.commands == ()


def test_a_start_in_the_future_is_waited_for(ran):
    result = ran("""
goal = goal_to(READY, 2.0)
goal.trajectory.header.stamp = rospy.Time.now() + rospy.Duration(3.0)
began = rospy.get_time()
arm.send_goal_and_wait(goal)
lasted = rospy.get_time() - began
""")
    assert result["lasted"] == pytest.approx(5.2, abs=0.5)


def test_a_path_tolerance_is_watched(ran):
    result = ran("""
goal = goal_to(READY, 0.3)
goal.path_tolerance.append(JointTolerance(name="panda_joint4", position=0.0002))
state = arm.send_goal_and_wait(goal)
result = arm.get_result()
""")
    assert (result["state"], result["result"].error_code) == (4, -4)
    assert "panda_joint4" in result["result"].error_string


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("tolerance", "code", "most"),
    [
        ("goal.goal_time_tolerance = rospy.Duration(0.05)", -5, 0.2),
        ("goal.goal_time_tolerance = rospy.Duration(5.0)", 0, 2.0),
        ("goal.goal_time_tolerance = rospy.Duration(-1)", -5, 0.2),
        ("pass", -5, 0.2),
    ],
)
def test_a_goal_must_be_reached_within_its_time(ran, tolerance, code, most):
    # Without a time the goal is to be reached when the trajectory ends, and a negative one takes
    # the time away: ros_controllers, joint_trajectory_controller/tolerances.h.
    result = ran(f"""
goal = goal_to([0.3] + READY[1:], 0.05)
goal.goal_tolerance.append(JointTolerance(name="panda_joint1", position=0.01))
{tolerance}
began = rospy.get_time()
arm.send_goal_and_wait(goal)
lasted = rospy.get_time() - began
result = arm.get_result()
""")
    assert result["result"].error_code == code
    assert 0.05 < result["lasted"] < most
    if code:
        assert "from its goal" in result["result"].error_string
        assert any("from its goal" in message for message in result.findings)


def test_a_new_goal_preempts_and_a_cancelled_one_stops(ran):
    result = ran("""
other = actionlib.SimpleActionClient("/whatever/follow_joint_trajectory",
                                     FollowJointTrajectoryAction)
arm.send_goal(goal_to(READY, 5.0))
rospy.sleep(1.0)
other.send_goal(goal_to([0.3] + READY[1:], 5.0))
arm.wait_for_result()
first = arm.get_state()
rospy.sleep(1.0)
other.cancel_goal()
other.wait_for_result()
second = other.get_state()
rospy.sleep(0.5)
stopped = measured()["panda_joint1"]
rospy.sleep(1.0)
still = measured()["panda_joint1"]
""")
    assert (result["first"], result["second"]) == (2, 2)
    assert abs(result["stopped"] - result["still"]) < 1e-3
    assert [command.end for command in result.recording.commands] == ["replaced", "cancelled"]
    first, second = result.recording.commands
    assert (first.replaced_by, second.replaced_by) == (second.id, None)
    # One second of five, on a straight way: points without velocities.
    assert first.way_done == pytest.approx(0.2, abs=0.02)


def test_a_gripper_opens_and_stalls_on_nothing(ran):
    result = ran("""
hand.wait_for_server()
goal = GripperCommandGoal()
goal.command.position, goal.command.max_effort = 0.03, 10.0
state = hand.send_goal_and_wait(goal)
opened = hand.get_result()
goal.command.position = 0.2
hand.send_goal_and_wait(goal)
widest = hand.get_result()
""")
    assert result["state"] == 3
    assert result["opened"].position == pytest.approx(0.03, abs=0.001)
    assert (result["opened"].reached_goal, result["opened"].stalled) == (True, False)
    assert result["widest"].position == pytest.approx(0.04, abs=0.001)
    assert [each.elements for each in result.recording.commands] == [("panda_hand",)] * 2


@pytest.mark.parametrize(("position", "is_reported"), [(-0.01, False), (0.08, False), (0.8, True)])
def test_a_position_of_another_gripper_is_reported(ran, position, is_reported):
    result = ran(f"""
hand.wait_for_server()
goal = GripperCommandGoal()
goal.command.position = {position}
hand.send_goal_and_wait(goal)
""")
    reported = [each for each in result.recording.findings if each.kind == "foreign_gripper"]
    assert len(reported) == is_reported
    for each in reported:
        assert "asked for 0.8, far past its range [0, 0.04], and went to 0.04" in each.message


def test_the_gripper_of_franka_moves_homes_and_misses_a_grasp(ran):
    result = ran("""
from franka_gripper.msg import (
    GraspAction, GraspGoal, HomingAction, HomingGoal, MoveAction, MoveGoal, StopAction, StopGoal)

def ask(name, kind, goal):
    client = actionlib.SimpleActionClient("/franka_gripper/" + name, kind)
    client.wait_for_server()
    return client.send_goal_and_wait(goal), client.get_result().success

told = [ask("homing", HomingAction, HomingGoal()),
        ask("move", MoveAction, MoveGoal(width=0.05, speed=0.1)),
        ask("stop", StopAction, StopGoal())]
grasp = GraspGoal(width=0.02, speed=0.1, force=10.0)
grasp.epsilon.inner = grasp.epsilon.outer = 0.005
told.append(ask("grasp", GraspAction, grasp))
""")
    assert result["told"] == [(3, True), (3, True), (3, True), (4, False)]


def test_the_controllers_own_server_stands_before_the_twins(ran):
    result = ran("""
class Relay:
    def __init__(self):
        self.server = actionlib.SimpleActionServer(
            "relay", FollowJointTrajectoryAction, self.execute, auto_start=False)
        self.server.start()

    def execute(self, goal):
        arm.send_goal_and_wait(goal)
        self.server.set_succeeded(arm.get_result())

relay = Relay()
client = actionlib.SimpleActionClient("relay", FollowJointTrajectoryAction)
client.wait_for_server()
state = client.send_goal_and_wait(goal_to(READY))
""")
    assert result["state"] == 3
    assert result.owners == ["Relay.execute"]


OWNERS = {
    "timer": """
def tick(event):
    arm.send_goal(goal_to(READY))

timer = rospy.Timer(rospy.Duration(1.0), tick, oneshot=True)
rospy.sleep(5.0)
""",
    "done": """
def second(state, result):
    arm.send_goal(goal_to([0.2] + READY[1:]))

def first():
    arm.send_goal(goal_to(READY), done_cb=second)

first()
rospy.sleep(8.0)
""",
    "thread": """
import threading

def work():
    arm.send_goal_and_wait(goal_to(READY))

def start():
    thread = threading.Thread(target=work)
    thread.start()
    thread.join()

start()
""",
    "service": """
from std_srvs.srv import Trigger, TriggerResponse

def handle(request):
    arm.send_goal(goal_to(READY))
    return TriggerResponse(True, "")

rospy.Service("go", Trigger, handle)

def ask():
    rospy.ServiceProxy("go", Trigger)()

ask()
rospy.sleep(4.0)
""",
    "topic": """
from std_msgs.msg import Empty

def hear(message):
    arm.send_goal(goal_to(READY))

rospy.Subscriber("go", Empty, hear)
publisher = rospy.Publisher("go", Empty, queue_size=1)
publisher.publish()
rospy.sleep(4.0)
""",
}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("how", "owners"),
    [
        ("timer", ["tick"]),
        ("done", ["first", "second"]),
        ("thread", ["work"]),
        ("service", ["handle"]),
        ("topic", ["hear"]),
    ],
)
def test_a_motion_is_owned_by_the_function_that_commanded_it(ran, how, owners):
    result = ran(OWNERS[how])
    assert result.owners == owners
    assert all(command.end == "arrived" for command in result.recording.commands)


@pytest.mark.parametrize(("effort", "is_reported"), [(0.002, True), (0.0, False), (40.0, False)])
def test_fingers_that_an_effort_cannot_move_are_reported(ran, effort, is_reported):
    result = ran(f"""
hand.wait_for_server()
goal = GripperCommandGoal()
goal.command.position, goal.command.max_effort = 0.005, {effort}
hand.send_goal_and_wait(goal)
here = measured()["panda_finger_joint1"]
""")
    limits = [
        finding.message
        for finding in result.recording.findings
        if finding.kind == "stopped_at_limit"
    ]
    assert bool(limits) is is_reported
    if is_reported:
        assert "touches nothing: max_effort 0.002 of the goal cannot move it" in limits[0]
    else:
        assert result["here"] == pytest.approx(0.005, abs=0.002)
