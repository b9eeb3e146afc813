"""Which goals MoveIt queues, ends or refuses, and which trajectories it executes."""

import textwrap

import pytest

from tests.traced_run import quiet_end, run_traced
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

ROS1 = """\
import actionlib, rospy
from moveit_commander import MoveGroupCommander
from moveit_msgs.msg import (
    Constraints, ExecuteTrajectoryAction, ExecuteTrajectoryGoal, JointConstraint, MoveGroupAction,
    MoveGroupGoal)
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
rospy.init_node("controller")
arm, hand = MoveGroupCommander("panda_arm"), MoveGroupCommander("hand")

def client(name, kind):
    made = actionlib.SimpleActionClient(name, kind)
    made.wait_for_server()
    return made

def move_goal(turn):
    goal = MoveGroupGoal()
    goal.request.group_name = "panda_arm"
    goal.request.max_velocity_scaling_factor = 0.1
    goal.request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=value)
        for name, value in zip(JOINTS, [turn, *READY[1:]])])]
    return goal

def trajectory_goal(*points, names=JOINTS):
    goal = ExecuteTrajectoryGoal()
    goal.trajectory.joint_trajectory.joint_names = names
    goal.trajectory.joint_trajectory.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(seconds))
        for positions, seconds in points]
    return goal

def turned(turn):
    return [turn, *arm.get_current_joint_values()[1:]]

def swing(turn=0.8, seconds=3.0):
    here = arm.get_current_joint_values()
    return trajectory_goal((here, 0.0), (turned(turn), seconds))

move = client("/move_group", MoveGroupAction)
execute = client("/execute_trajectory", ExecuteTrajectoryAction)
arm.go(READY)
"""
ROS2 = """\
import rclpy
from moveit_msgs.action import ExecuteTrajectory, MoveGroup
from moveit_msgs.msg import Constraints, JointConstraint
from rclpy.action import ActionClient
from std_msgs.msg import String
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
START = [0.0, -0.7853981633974483, 0.0, -2.356194490192345, 0.0, 1.5707963267948966,
         0.7853981633974483]
rclpy.init()
node = rclpy.create_node("controller")
move = ActionClient(node, MoveGroup, "/move_action")
execute = ActionClient(node, ExecuteTrajectory, "/execute_trajectory")
events = node.create_publisher(String, "/trajectory_execution_event", 1)
move.wait_for_server()
execute.wait_for_server()

def move_goal(turn):
    goal = MoveGroup.Goal()
    goal.request.group_name = "panda_arm"
    goal.request.max_velocity_scaling_factor = 0.1
    goal.request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=value, tolerance_above=1e-3,
                        tolerance_below=1e-3, weight=1.0)
        for name, value in zip(JOINTS, [turn, *START[1:]])])]
    return goal

def trajectory_goal(*points, names=JOINTS):
    goal = ExecuteTrajectory.Goal()
    goal.trajectory.joint_trajectory.joint_names = names
    for positions, seconds in points:
        point = JointTrajectoryPoint(positions=positions, velocities=[0.0] * len(names))
        point.time_from_start.sec = seconds
        goal.trajectory.joint_trajectory.points.append(point)
    return goal

def swing(turn=1.2, seconds=3, begin=0.0):
    return trajectory_goal(([begin, *START[1:]], 0), ([turn, *START[1:]], seconds))

def closing():
    return trajectory_goal(([0.035], 0), ([0.01], 1), names=["panda_finger_joint1"])

def now():
    return node.get_clock().now().nanoseconds / 1e9

def wait(future, seconds=None):
    rclpy.spin_until_future_complete(node, future, timeout_sec=seconds)
    return future.result() if future.done() else None

def pause(seconds):
    wait(rclpy.task.Future(), seconds)

def begun(client, goal, seconds=1.0):
    handle = wait(client.send_goal_async(goal))
    result = handle.get_result_async()
    wait(result, seconds)
    return handle, result

def ended(result):
    answer = wait(result)
    return answer.status, answer.result.error_code.val
"""


@pytest.fixture
def ros1(tmp_path):
    return lambda program, distro="noetic": _ran(
        tmp_path, Interfaces(), ROS1 + textwrap.dedent(program), distro
    )


@pytest.fixture
def ros2(tmp_path):
    return lambda program, distro: _ran(
        tmp_path, Interfaces2(), ROS2 + textwrap.dedent(program), distro
    )


def _ran(tmp_path, interfaces, program, distro):
    script = tmp_path / "program.py"
    script.write_text(program)
    return quiet_end(*run_traced(script, interfaces, duration_s=60.0, distro=distro))


def ends(ran):
    return [command.end for command in ran.recording.commands]


# Goals of MoveIt 2


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_a_second_goal_of_execute_trajectory_waits_for_the_first(ros2, distro):
    ran = ros2(
        """
        _, swung = begun(execute, swing())
        opened = wait(wait(execute.send_goal_async(closing())).get_result_async())
        was_done = swung.done()
        answers = ended(swung), (opened.status, opened.result.error_code.val)
        """,
        distro,
    )
    assert ran["answers"] == ((4, 1), (4, 1))
    assert ran["was_done"]
    assert ends(ran) == ["arrived", "arrived"]
    first, second = ran.recording.commands
    assert second.issue_ns >= first.end_ns


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_a_waiting_goal_of_execute_trajectory_is_not_answered_and_may_start_too_far_away(
    ros2, distro
):
    ran = ros2(
        """
        _, swung = begun(execute, swing(turn=1.2))
        second = execute.send_goal_async(swing(turn=-1.0, begin=0.0))
        was_answered = wait(second, 0.5) is not None
        answer = ended(wait(second).get_result_async())
        """,
        distro,
    )
    assert not ran["was_answered"]
    assert ran["answer"] == (6, -4)
    assert any("starts with joint 'panda_joint1' at 0.0000" in text for text in ran.findings)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_three_goals_of_execute_trajectory_are_executed_in_their_order(ros2, distro):
    ran = ros2(
        """
        sent = [execute.send_goal_async(swing(turn=to, seconds=1, begin=at))
                for at, to in ((0.0, 0.3), (0.3, 0.6), (0.6, 0.2))]
        answers = [ended(wait(one).get_result_async()) for one in sent]
        """,
        distro,
    )
    assert ran["answers"] == [(4, 1)] * 3
    assert [command.goal[0] for command in ran.recording.commands] == [0.3, 0.6, 0.2]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_a_goal_of_execute_trajectory_cannot_be_cancelled_and_the_run_says_so(ros2, distro):
    ran = ros2(
        """
        handle, swung = begun(execute, swing())
        before = now()
        answer = wait(handle.cancel_goal_async())
        waited, code, cancelled = now() - before, answer.return_code, len(answer.goals_canceling)
        result = ended(swung)
        """,
        distro,
    )
    assert (ran["code"], ran["cancelled"], ran["result"]) == (3, 0, (4, 1))
    assert ran["waited"] > 1.0
    assert ends(ran) == ["arrived"]
    assert [one.end for one in ran.recording.refused] == ["ignored"]
    assert any("stops nothing" in text for text in ran.findings)


def test_a_second_goal_of_move_action_waits_in_humble(ros2):
    ran = ros2(
        """
        _, first = begun(move, move_goal(0.3))
        second = move.send_goal_async(move_goal(-0.1))
        was_answered = wait(second, 0.3) is not None
        answers = ended(wait(second).get_result_async()), ended(first)
        """,
        "humble",
    )
    assert not ran["was_answered"]
    assert ran["answers"] == ((4, 1), (4, 1))
    assert ends(ran) == ["arrived", "arrived"]


def test_a_second_goal_of_move_action_fails_in_jazzy_and_the_first_goes_on(ros2):
    ran = ros2(
        """
        _, first = begun(move, move_goal(0.3))
        _, second = begun(move, move_goal(-0.1))
        answers = ended(second), ended(first)
        """,
        "jazzy",
    )
    assert ran["answers"] == ((6, -4), (4, 1))
    assert ends(ran) == ["arrived"]
    assert [one.end for one in ran.recording.refused] == ["refused"]


@pytest.mark.parametrize(("distro", "code", "status"), [("humble", 3, 4), ("jazzy", 0, 5)])
def test_a_goal_of_move_action_is_cancelled_in_jazzy_alone(ros2, distro, code, status):
    ran = ros2(
        """
        handle, result = begun(move, move_goal(0.4))
        answer = wait(handle.cancel_goal_async()).return_code
        status, error = ended(result)
        """,
        distro,
    )
    assert (ran["answer"], ran["status"]) == (code, status)
    assert ran["error"] == (1 if status == 4 else -7)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
@pytest.mark.parametrize(
    ("first", "second"),
    [("execute, swing()", "move, move_goal(0.2)"), ("move, move_goal(0.4)", "execute, closing()")],
)
def test_the_other_action_of_moveit_2_is_refused_while_one_executes(ros2, distro, first, second):
    ran = ros2(
        f"""
        _, one = begun({first})
        _, other = begun({second})
        answers = ended(other), ended(one)
        """,
        distro,
    )
    assert ran["answers"] == ((6, -4), (4, 1))
    assert ends(ran) == ["arrived"]
    assert [each.end for each in ran.recording.refused] == ["refused"]
    assert any("executes one trajectory at a time" in text for text in ran.findings)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
@pytest.mark.parametrize(("goal", "code"), [("execute, swing()", -7), ("move, move_goal(0.4)", -4)])
def test_the_event_stop_aborts_the_goals_of_moveit_2(ros2, distro, goal, code):
    ran = ros2(
        f"""
        _, result = begun({goal})
        events.publish(String(data="stop"))
        answer = ended(result)
        """,
        distro,
    )
    assert ran["answer"] == (6, code)
    assert ends(ran) == ["cancelled"]


# Goals of MoveIt 1


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("client", "first", "second"),
    [
        ("move", "move_goal(0.5)", "move_goal(-0.3)"),
        ("execute", "swing(0.8)", "swing(-0.8)"),
    ],
)
def test_a_new_goal_of_the_same_action_of_moveit_1_ends_the_one_before(ros1, client, first, second):
    ran = ros1(
        f"""
        other = client({client}.action_client.ns, {client}.action_client.ActionSpec)
        other.send_goal({first})
        rospy.sleep(1.0)
        {client}.send_goal_and_wait({second})
        other.wait_for_result()
        before = other.get_state(), other.get_result().error_code.val
        after = {client}.get_state(), {client}.get_result().error_code.val
        """
    )
    assert (ran["before"], ran["after"]) == ((2, -7), (3, 1))
    assert ends(ran)[-2:] == ["replaced", "arrived"]


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("execute.send_goal(swing())", "hand.go([0.02, 0.02])"),
        ("arm.go([0.6, *READY[1:]], wait=False)", "execute.send_goal_and_wait(swing()) == 3"),
        ("arm.execute(swing().trajectory, wait=False)", "arm.go(READY)"),
        ("arm.go([0.6, *READY[1:]], wait=False)", "arm.execute(swing().trajectory)"),
    ],
)
def test_the_other_action_of_moveit_1_is_refused_while_one_executes(ros1, first, second):
    ran = ros1(
        f"""
        arm.set_max_velocity_scaling_factor(0.1)
        {first}
        rospy.sleep(0.5)
        done = {second}
        rospy.sleep(10.0)
        """
    )
    assert ran["done"] is False
    assert ends(ran)[-1] == "arrived"
    assert [each.end for each in ran.recording.refused] == ["refused"]
    assert any("executes one trajectory at a time" in text for text in ran.findings)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    "asked",
    [
        "hand.plan([0.02, 0.02])",
        "hand.set_random_target(); arm.plan()",
        "move.send_goal_and_wait(plan_only())",
        "move.send_goal_and_wait(MoveGroupGoal())",
    ],
)
def test_a_plan_ends_the_motion_of_go_and_the_run_says_so(ros1, asked):
    ran = ros1(
        f"""
        arm.set_max_velocity_scaling_factor(0.1)
        def plan_only():
            goal = move_goal(0.2)
            goal.planning_options.plan_only = True
            return goal

        arm.go([0.6, *READY[1:]], wait=False)
        rospy.sleep(0.5)
        {asked}
        rospy.sleep(5.0)
        """
    )
    assert ends(ran)[-1] == "aborted"
    assert any("a new goal of move_action ended it" in text for text in ran.findings)


def test_a_plan_does_not_end_what_execute_began(ros1):
    ran = ros1(
        """
        arm.execute(swing().trajectory, wait=False)
        rospy.sleep(0.5)
        hand.plan([0.02, 0.02])
        rospy.sleep(5.0)
        """
    )
    assert ends(ran)[-1] == "arrived"


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("client", "goal", "answer"),
    [("move", "move_goal(0.5)", (4, -4)), ("execute", "swing()", (2, -7))],
)
def test_stop_fails_a_goal_of_move_group_and_preempts_one_of_execute_trajectory(
    ros1, client, goal, answer
):
    ran = ros1(
        f"""
        {client}.send_goal({goal})
        rospy.sleep(0.5)
        arm.stop()
        {client}.wait_for_result()
        answer = {client}.get_state(), {client}.get_result().error_code.val
        """
    )
    assert ran["answer"] == answer
    assert ends(ran)[-1] == "cancelled"


# What is executed


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["humble", "jazzy"])
@pytest.mark.parametrize(
    ("points", "answer"),
    [
        ("([0.005, *START[1:]], 0), ([0.5, *START[1:]], 2)", (4, 1)),
        ("([0.02, *START[1:]], 0), ([0.5, *START[1:]], 2)", (6, -4)),
        ("([0.5, *START[1:]], 2),", (6, -4)),
        ("([0.5, *START[1:]], 0),", (6, -4)),
        ("([0.3, *START[1:]], 1), ([0.5, *START[1:]], 2)", (6, -4)),
        ("(START[:6], 0), ([0.5, *START[1:]], 2)", (6, -4)),
        ("", (4, 1)),
    ],
)
def test_a_trajectory_of_moveit_2_must_start_where_the_robot_is(ros2, distro, points, answer):
    ran = ros2(
        f"""
        first = ended(wait(execute.send_goal_async(
            trajectory_goal((START, 0), ([0.0, *START[1:]], 1)))).get_result_async())
        answer = ended(wait(execute.send_goal_async(trajectory_goal({points})))
                       .get_result_async())
        """,
        distro,
    )
    assert (ran["first"], ran["answer"]) == ((4, 1), answer)
    if points == "":
        assert [each.end for each in ran.recording.refused] == ["ignored"]


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("points", "answer"),
    [
        ("(turned(0.005), 0.0), (turned(0.5), 2.0)", (3, 1)),
        ("(turned(0.02), 0.0), (turned(0.5), 2.0)", (4, -4)),
        ("(turned(0.5), 2.0)", (4, -4)),
        ("(turned(0.0)[:6], 0.0), (turned(0.5), 2.0)", (4, -4)),
    ],
)
def test_a_trajectory_of_moveit_1_must_start_where_the_robot_is(ros1, points, answer):
    ran = ros1(
        f"""
        arm.go([0.0, *READY[1:]])
        execute.send_goal_and_wait(trajectory_goal({points}))
        answer = execute.get_state(), execute.get_result().error_code.val
        """
    )
    assert ran["answer"] == answer


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("points", ["", "(turned(0.5), 0.0)"])
@pytest.mark.parametrize(
    "ask",
    ["execute.send_goal_and_wait(goal) == 3", "arm.execute(goal.trajectory)"],
)
def test_an_empty_trajectory_or_one_of_no_duration_succeeds_and_moves_nothing(ros1, points, ask):
    ran = ros1(
        f"""
        goal = trajectory_goal({points})
        before = arm.get_current_joint_values()
        done = {ask}
        moved = max(abs(a - b) for a, b in zip(before, arm.get_current_joint_values()))
        """
    )
    assert ran["done"] is True
    assert ran["moved"] < 1e-4
    assert [each.end for each in ran.recording.refused] == ["ignored"]


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("parameters", "answer"),
    [
        ({}, (3, 1)),
        ({"allowed_execution_duration_scaling": 0.2, "allowed_goal_duration_margin": 0.1}, (4, -6)),
        # Each beside the other's default.
        ({"allowed_execution_duration_scaling": 0.2}, (4, -6)),
        ({"allowed_goal_duration_margin": -1.0}, (4, -6)),
        (
            {"allowed_execution_duration_scaling": 0.2, "execution_duration_monitoring": False},
            (3, 1),
        ),
    ],
)
def test_a_motion_that_takes_too_long_is_stopped_as_timed_out(ros1, parameters, answer):
    ran = ros1(
        f"""
        for name, value in {parameters}.items():
            rospy.set_param("/move_group/trajectory_execution/" + name, value)
        move.send_goal_and_wait(move_goal(0.4))
        answer = move.get_state(), move.get_result().error_code.val
        """
    )
    assert ran["answer"] == answer
    assert ends(ran)[-1] == ("arrived" if answer[1] == 1 else "aborted")
    assert any("the longest that it allows" in text for text in ran.findings) == (answer[1] == -6)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("parameters", "is_executed"),
    [
        ({}, False),
        ({"allowed_start_tolerance": 0.1}, True),
        ({"allowed_start_tolerance": 0.0}, True),
        ({"joints_allowed_start_tolerance": {"panda_joint1": 0.1}}, True),
        ({"joints_allowed_start_tolerance": {"panda_joint1": 0.0}}, True),
        ({"joints_allowed_start_tolerance": {"panda_joint1": -1.0}}, False),
        ({"joints_allowed_start_tolerance": {"panda_joint2": 0.1}}, False),
        (
            {
                "allowed_start_tolerance": 0.0,
                "joints_allowed_start_tolerance": {"panda_joint1": 0.01},
            },
            False,
        ),
    ],
)
def test_the_start_tolerance_is_move_groups_or_that_of_the_joint(ros1, parameters, is_executed):
    ran = ros1(
        f"""
        for name, value in {parameters}.items():
            rospy.set_param("/move_group/trajectory_execution/" + name, value)
        done = arm.execute(trajectory_goal((turned(0.05), 0.0), (turned(0.5), 2.0)).trajectory)
        """
    )
    assert ran["done"] is is_executed


def test_a_second_pickup_ends_the_first_which_is_preempted(ros1):
    ran = ros1(
        """
        from geometry_msgs.msg import PoseStamped
        from moveit_commander import PlanningSceneInterface
        from moveit_msgs.msg import Grasp, PickupAction, PickupGoal
        place = PoseStamped()
        place.header.frame_id = "panda_link0"
        place.pose.position.x, place.pose.position.z = 0.45, 0.5
        place.pose.orientation.w = 1.0
        PlanningSceneInterface().add_box("box", place, (0.02, 0.02, 0.02))
        grasp = Grasp(grasp_pose=arm.get_current_pose())
        grasp.grasp_pose.pose.position.z -= 0.2
        goal = PickupGoal(target_name="box", group_name="panda_arm", possible_grasps=[grasp])
        first, second = client("/pickup", PickupAction), client("/pickup", PickupAction)
        first.send_goal(goal)
        rospy.sleep(0.3)
        second.send_goal(goal)
        second.wait_for_result()
        first.wait_for_result()
        answers = first.get_state(), first.get_result().error_code.val, second.get_state()
        """
    )
    assert ran["answers"][:2] == (2, -7)
    assert any("a new goal of pickup ended it" in text for text in ran.findings)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["noetic", "humble"])
def test_a_plan_is_no_trajectory_where_the_controller_is_known_to_be_for_noetic(ros1, distro):
    ran = ros1(
        """
        try:
            raised = ""
            arm.execute(arm.plan([0.2, *READY[1:]]))
        except AttributeError as error:
            raised = str(error)
        """,
        distro=distro,
    )
    expected = "'tuple' object has no attribute 'serialize'" if distro == "noetic" else ""
    assert ran["raised"] == expected


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("distro", ["noetic", "humble"])
def test_a_plan_is_shown_as_a_trajectory_unless_the_controller_is_known_to_be_for_noetic(
    ros1, distro
):
    ran = ros1(
        """
        from moveit_msgs.msg import DisplayTrajectory
        shown = []
        rospy.Subscriber("/move_group/display_planned_path", DisplayTrajectory, shown.append)
        screen = rospy.Publisher(
            "/move_group/display_planned_path", DisplayTrajectory, queue_size=1, latch=True)
        display = DisplayTrajectory()
        display.trajectory.append(arm.plan([0.2, *READY[1:]]))
        try:
            raised = ""
            screen.publish(display)
        except rospy.exceptions.ROSSerializationException as error:
            raised = str(error)
        rospy.sleep(0.5)
        ends = [one.trajectory[0].joint_trajectory.points[-1].positions[0] for one in shown]
        """,
        distro=distro,
    )
    if distro == "noetic":
        assert "field trajectory[] must be of type [moveit_msgs/RobotTrajectory]" in ran["raised"]
        assert ran["ends"] == []
    else:
        assert ran["raised"] == ""
        assert ran["ends"] == pytest.approx([0.2])
        assert any("use plan()[1]" in text for text in ran.findings)


def test_a_cartesian_path_of_jazzy_has_the_speed_of_its_request(ros2):
    ran = ros2(
        """
        from moveit_msgs.srv import GetCartesianPath, GetPositionFK
        def ask(kind, name, **fields):
            client = node.create_client(kind, name)
            client.wait_for_service()
            return wait(client.call_async(kind.Request(**fields)))
        def seconds(factor):
            path = ask(
                GetCartesianPath, "/compute_cartesian_path", group_name="panda_arm", max_step=0.01,
                waypoints=[there], max_velocity_scaling_factor=factor)
            last = path.solution.joint_trajectory.points[-1].time_from_start
            return last.sec + last.nanosec / 1e9
        there = ask(GetPositionFK, "/compute_fk", fk_link_names=["panda_link8"]).pose_stamped[0].pose
        there.position.z -= 0.3
        ratio = seconds(0.1) / seconds(1.0)
        """,
        "jazzy",
    )
    assert ran["ratio"] > 2.0
