"""move_group's actions and services on the graph, as programs call them."""

import pytest

PREAMBLE = """\
import actionlib, rospy
from geometry_msgs.msg import Pose, PoseStamped
from moveit_msgs.msg import (
    Constraints, ExecuteTrajectoryAction, ExecuteTrajectoryGoal, JointConstraint, MoveGroupAction,
    MoveGroupGoal, OrientationConstraint, PositionConstraint)
from moveit_msgs.srv import (
    GetCartesianPath, GetCartesianPathRequest, GetMotionPlan, GetPositionFK, GetPositionIK,
    GetPositionIKRequest)
from shape_msgs.msg import SolidPrimitive

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
rospy.init_node("controller")

def ready():
    goal = MoveGroupGoal()
    goal.request.group_name = "panda_arm"
    goal.request.goal_constraints = [Constraints(joint_constraints=[
        JointConstraint(joint_name=name, position=value) for name, value in zip(JOINTS, READY)])]
    return goal

def service(name, kind):
    rospy.wait_for_service(name)
    return rospy.ServiceProxy(name, kind)

def where():
    answer = service("/compute_fk", GetPositionFK)(fk_link_names=["panda_link8"])
    return answer.pose_stamped[0].pose

move = actionlib.SimpleActionClient("/move_group", MoveGroupAction)
move.wait_for_server()
"""


@pytest.fixture
def ran(run_on_twin):
    return lambda program, **options: run_on_twin(PREAMBLE + program, **options)


def test_a_goal_of_move_group_is_planned_and_executed(ran):
    result = ran("""
def go():
    return move.send_goal_and_wait(ready())

state = go()
code = move.get_result().error_code.val
points = len(move.get_result().planned_trajectory.joint_trajectory.points)
""")
    assert (result["state"], result["code"]) == (3, 1)
    assert result["points"] > 5
    assert result.owners == ["go"]
    assert [command.end for command in result.recording.commands] == ["arrived"]


def test_a_plan_alone_moves_nothing_and_its_trajectory_can_be_executed(ran):
    result = ran("""
goal = ready()
goal.planning_options.plan_only = True

def plan():
    move.send_goal_and_wait(goal)
    return move.get_result().planned_trajectory

def execute(trajectory):
    client = actionlib.SimpleActionClient("execute_trajectory", ExecuteTrajectoryAction)
    client.wait_for_server()
    return client.send_goal_and_wait(ExecuteTrajectoryGoal(trajectory=trajectory))

state = execute(plan())
""")
    assert result["state"] == 3
    assert result.owners == ["execute"]


def test_a_scaling_that_a_request_leaves_at_0_is_1(ran):
    result = ran("""
seconds = []
for factor in (0.0, 1.0, 0.1):
    goal = ready()
    goal.request.max_velocity_scaling_factor = factor
    goal.request.max_acceleration_scaling_factor = factor
    goal.planning_options.plan_only = True
    move.send_goal_and_wait(goal)
    points = move.get_result().planned_trajectory.joint_trajectory.points
    seconds.append(points[-1].time_from_start.to_sec())
""")
    unset, rated, tenth = result["seconds"]
    assert unset == rated < tenth


def test_a_pose_goal_is_reached_and_a_group_that_is_none_is_reported(ran):
    result = ran("""
move.send_goal_and_wait(ready())
target = where()
target.position.z -= 0.1
position = PositionConstraint(link_name="panda_link8")
position.header.frame_id = "panda_link0"
position.constraint_region.primitives = [SolidPrimitive(type=2, dimensions=[0.001])]
position.constraint_region.primitive_poses = [Pose(position=target.position)]
turn = OrientationConstraint(link_name="panda_link8", orientation=target.orientation)
turn.header.frame_id = "panda_link0"
turn.absolute_x_axis_tolerance = 0.01
goal = ready()
goal.request.goal_constraints = [
    Constraints(position_constraints=[position], orientation_constraints=[turn])]
state = move.send_goal_and_wait(goal)
reached = where()
goal.request.group_name = "left_arm"
refused = move.send_goal_and_wait(goal), move.get_result().error_code.val
""")
    assert result["state"] == 3
    assert result["reached"].position.z == pytest.approx(result["target"].position.z, abs=0.003)
    assert result["refused"] == (4, -15)
    assert any("left_arm" in message for message in result.findings)


def test_inverse_kinematics_gives_joints_or_says_that_there_are_none(ran):
    result = ran("""
request = GetPositionIKRequest()
request.ik_request.group_name = "panda_arm"
request.ik_request.pose_stamped.header.frame_id = "panda_link0"
request.ik_request.pose_stamped.pose = where()
solve = service("/panda/compute_ik", GetPositionIK)
found = solve(request)
request.ik_request.pose_stamped.pose.position.x = 5.0
far = solve(request).error_code.val
""")
    assert result["found"].error_code.val == 1
    assert len(result["found"].solution.joint_state.position) == 9
    assert result["far"] == -31


def test_a_cartesian_path_and_a_motion_plan_are_computed(ran):
    result = ran("""
move.send_goal_and_wait(ready())
request = GetCartesianPathRequest(group_name="panda_arm", max_step=0.01)
lower = where()
lower.position.z -= 0.05
request.waypoints = [lower]
path = service("/compute_cartesian_path", GetCartesianPath)(request)
fraction, code = path.fraction, path.error_code.val
plan = service("/plan_kinematic_path", GetMotionPlan)(ready().request).motion_plan_response
planned = plan.error_code.val, plan.trajectory.joint_trajectory.joint_names
""")
    assert (result["fraction"], result["code"]) == (1.0, 1)
    assert result["planned"] == (1, [f"panda_joint{i}" for i in range(1, 8)])


def test_a_cancelled_motion_ends_preempted(ran):
    result = ran("""
move.send_goal(ready())
rospy.sleep(0.2)
move.cancel_goal()
move.wait_for_result()
state = move.get_state()
""")
    assert result["state"] == 2
    assert [command.end for command in result.recording.commands] == ["cancelled"]


def test_stop_on_the_topic_of_events_fails_a_goal_of_move_group(ran):
    result = ran("""
from std_msgs.msg import String
events = rospy.Publisher("/trajectory_execution_event", String, queue_size=1)
goal = ready()
goal.request.goal_constraints[0].joint_constraints[0].position = 1.0
goal.request.max_velocity_scaling_factor = 0.1
move.send_goal(goal)
rospy.sleep(1.0)
events.publish(String(data="go on"))
rospy.sleep(0.5)
before = move.get_state()
events.publish(String(data="stop"))
move.wait_for_result()
state, code = move.get_state(), move.get_result().error_code.val
""")
    assert (result["before"], result["state"], result["code"]) == (1, 4, -4)
