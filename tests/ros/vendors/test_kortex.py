"""The driver of a Kinova Gen3 on the twin; units and events as kortex_driver documents them."""

import math

import pytest

HEAD = """
import rospy
from kortex_driver.srv import *
from kortex_driver.msg import *
rospy.init_node('mover')
def service(name, kind, space='base'):
    rospy.wait_for_service('/my_gen3/' + space + '/' + name)
    return rospy.ServiceProxy('/my_gen3/' + space + '/' + name, kind)
events = []
def hear(message):
    events.append((message.action_event, message.handle.identifier))
rospy.Subscriber('/my_gen3/action_topic', ActionNotification, hear)
service('activate_publishing_of_action_topic', OnNotificationActionTopic)()
execute = service('execute_action', ExecuteAction)
read = service('read_action', ReadAction)
def finish(count):
    while len([e for e in events if e[0] in (1, 2)]) < count:
        rospy.sleep(0.01)
def refused(call, *arguments):
    try:
        call(*arguments)
    except rospy.ServiceException as error:
        return str(error)
    return ''
"""


def test_the_home_action_is_read_and_played_and_reported_by_its_function(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
def go_home():
    home = read(ReadActionRequest(input=ActionHandle(identifier=2))).output
    execute(ExecuteActionRequest(input=home))
    finish(1)
    return home
before = rospy.get_time()
home = go_home()
took = rospy.get_time() - before
measured = service('get_measured_joint_angles', GetMeasuredJointAngles)().output
missing = refused(read, ReadActionRequest(input=ActionHandle(identifier=77)))
""",
    )
    assert ran["home"].name == "Home"
    assert ran["events"] == [(4, 2), (1, 2)]
    assert ran["took"] > 1.0
    angles = [math.degrees(each) % 360 for each in (0, 0.26, 3.14, -2.27, 0, 0.96, 1.57)]
    reached = [each.value for each in ran["measured"].joint_angles]
    off = [(a - b + 180) % 360 - 180 for a, b in zip(angles, reached, strict=True)]
    assert off == pytest.approx([0.0] * 7, abs=1.0)
    assert ran.commands == ["kortex_action"]
    assert ran.owners == ["go_home"]
    assert "there is no action 77" in ran["missing"]


@pytest.mark.slow
def test_angles_are_degrees_and_a_duration_too_short_is_not_valid(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
validate = service('validate_waypoint_list', ValidateWaypointList)
def waypoints(duration, angles=(20, 30, 340, 40, 0, 10, 5)):
    angular = AngularWaypoint(angles=list(angles), duration=duration)
    waypoint = Waypoint()
    waypoint.oneof_type_of_waypoint.angular_waypoint.append(angular)
    return WaypointList(waypoints=[waypoint])
def errors(asked):
    return validate(asked).output.trajectory_error_report.trajectory_error_elements
short = errors(waypoints(0.1))
fine = errors(waypoints(10.0))
few = errors(waypoints(10.0, (1, 2, 3)))
past = errors(waypoints(10.0, (0, 170, 0, 0, 0, 0, 0)))
action = Action()
action.oneof_action_parameters.execute_waypoint_list.append(waypoints(4.0))
before = rospy.get_time()
execute(ExecuteActionRequest(input=action))
finish(1)
took = rospy.get_time() - before
action.oneof_action_parameters.execute_waypoint_list[0] = waypoints(0.1, (0,) * 7)
execute(ExecuteActionRequest(input=action))
finish(2)
""",
    )
    assert [each.error_type for each in ran["short"]] == [3]
    assert ran["fine"] == []
    assert [each.error_type for each in ran["few"]] == [2]
    assert 11 in [each.error_type for each in ran["past"]]
    assert ran["took"] == pytest.approx(4.0, abs=0.6)
    assert ran.position("joint_3") == pytest.approx(math.radians(-20), abs=0.02)
    assert [event for event, _ in ran["events"]] == [4, 1, 4, 2]
    assert any("a duration of 0.1 s; the arm takes" in each for each in ran.findings)


def test_poses_are_metres_and_degrees_and_one_out_of_reach_aborts(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
home = read(ReadActionRequest(input=ActionHandle(identifier=2))).output
execute(ExecuteActionRequest(input=home))
finish(1)
feedback = rospy.wait_for_message('/my_gen3/base_feedback', BaseCyclic_Feedback)
base = feedback.base
def to(x, y, z):
    pose = ConstrainedPose()
    pose.target_pose = Pose(x, y, z, base.tool_pose_theta_x, base.tool_pose_theta_y,
                            base.tool_pose_theta_z)
    pose.constraint.oneof_type.speed.append(CartesianSpeed(translation=0.05, orientation=30))
    action = Action()
    action.oneof_action_parameters.reach_pose.append(pose)
    execute(ExecuteActionRequest(input=action))
begun = rospy.get_time()
to(base.tool_pose_x, base.tool_pose_y, base.tool_pose_z - 0.1)
finish(2)
took = rospy.get_time() - begun
there = service('get_measured_cartesian_pose', GetMeasuredCartesianPose)().output
to(3.0, 0.0, 0.2)
finish(3)
""",
    )
    assert [event for event, _ in ran["events"]] == [4, 1, 4, 1, 4, 2]
    assert ran["there"].z == pytest.approx(ran["base"].tool_pose_z - 0.1, abs=0.005)
    assert ran["took"] > 1.9
    assert any("of the line to (3.000, 0.000, 0.200) m" in each for each in ran.findings)


def test_the_gripper_takes_shares_and_what_is_not_simulated_fails(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
gripper = service('send_gripper_command', SendGripperCommand)
def grip(mode, value):
    command = GripperCommand(mode=mode)
    command.gripper.finger.append(Finger(0, value))
    return gripper(command)
grip(GripperMode.GRIPPER_POSITION, 1.0)
rospy.sleep(4.0)
closed = service('get_measured_gripper_movement', GetMeasuredGripperMovement)().output.finger[0].value
grip(GripperMode.GRIPPER_SPEED, 0.1)
rospy.sleep(4.0)
opened = service('get_measured_gripper_movement', GetMeasuredGripperMovement)().output.finger[0].value
force = refused(grip, GripperMode.GRIPPER_FORCE, 0.5)
paused = refused(service('pause_action', PauseAction))
wrench = Action(name='push')
wrench.oneof_action_parameters.send_wrench_command.append(WrenchCommand())
pushed = refused(execute, ExecuteActionRequest(input=wrench))
empty = refused(execute, ExecuteActionRequest(input=Action(name='empty')))
""",
    )
    assert ran["closed"] == pytest.approx(1.0, abs=0.1)
    assert ran["opened"] == pytest.approx(0.0, abs=0.1)
    assert "gripper mode 1 is not simulated" in ran["force"]
    assert "service pause_action is not simulated" in ran["paused"]
    assert "send_wrench_command are not simulated" in ran["pushed"]
    assert "'empty' has 0 kinds of parameters" in ran["empty"]
    assert len([each for each in ran.findings if "not simulated" in each]) == 3


def test_speeds_go_on_until_they_are_zero_and_an_emergency_stop_lasts(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
speeds = service('send_joint_speeds_command', SendJointSpeedsCommand)
twist = service('send_twist_command', SendTwistCommand)
def turn(value):
    asked = Base_JointSpeeds()
    asked.joint_speeds = [JointSpeed(joint_identifier=0, value=value)]
    return speeds(asked)
turn(10.0)
rospy.sleep(2.0)
turn(0.0)
rospy.sleep(0.5)
angles = service('get_measured_joint_angles', GetMeasuredJointAngles)
turned = angles().output.joint_angles[0].value
service('apply_emergency_stop', ApplyEmergencyStop)()
state = service('get_arm_state', GetArmState)().output.active_state
stopped = refused(turn, 10.0)
service('clear_faults', Base_ClearFaults)()
execute(read(ReadActionRequest(input=ActionHandle(identifier=2))).output)
finish(1)
pose = service('get_measured_cartesian_pose', GetMeasuredCartesianPose)
before = pose().output
twist(TwistCommand(reference_frame=3, twist=Twist(linear_z=-0.05)))
rospy.sleep(2.0)
twist(TwistCommand(reference_frame=3))
after = pose().output
""",
    )
    assert ran["turned"] == pytest.approx(20.0, abs=2.0)
    assert ran["state"] == 4
    assert "clear_faults first" in ran["stopped"]
    assert ran["before"].z - ran["after"].z == pytest.approx(0.1, abs=0.02)
    assert ran.commands == ["kortex_velocity", "kortex_action", "kortex_velocity"]


@pytest.mark.slow
def test_cartesian_trajectories_are_an_action_with_turns_in_radians(run_on):
    ran = run_on(
        "gen3",
        HEAD
        + """
import actionlib, math
execute(read(ReadActionRequest(input=ActionHandle(identifier=2))).output)
finish(1)
here = service('get_measured_cartesian_pose', GetMeasuredCartesianPose)().output
turns = [math.radians(v) for v in (here.theta_x, here.theta_y, here.theta_z)]
client = actionlib.SimpleActionClient(
    '/my_gen3/cartesian_trajectory_controller/follow_cartesian_trajectory',
    kortex_driver.msg.FollowCartesianTrajectoryAction)
client.wait_for_server()
def follow(*places):
    goal = FollowCartesianTrajectoryGoal()
    for x, y, z in places:
        goal.trajectory.append(CartesianWaypoint(pose=Pose(x, y, z, *turns), reference_frame=3))
    client.send_goal(goal)
    client.wait_for_result()
    return client.get_state(), client.get_result()
moved = follow((here.x, here.y + 0.05, here.z), (here.x, here.y, here.z - 0.05))
far = follow((2.0, 0.0, 2.0))
parameters = [rospy.get_param('/my_gen3/degrees_of_freedom'), rospy.get_param('/is_gripper_present')]
model = service('get_product_configuration', GetProductConfiguration)().output
""",
    )
    assert ran["moved"][0] == 3
    assert ran["moved"][1].error_code == 0
    assert ran["far"][0] == 4
    assert ran["far"][1].error_code == -1
    assert ran["parameters"] == [7, True]
    assert (ran["model"].model, ran["model"].degree_of_freedom) == (1, 7)


def test_parameters_of_the_driver_are_not_there_for_other_controllers(run_on):
    ran = run_on(
        "gen3",
        """
import rospy
rospy.init_node('other')
found = rospy.has_param('/degrees_of_freedom')
""",
    )
    assert ran["found"] is False


@pytest.mark.slow
def test_actions_are_notified_of_once_a_program_has_asked_for_it(run_on):
    ran = run_on(
        "gen3",
        HEAD.replace(
            "service('activate_publishing_of_action_topic', On", "later = ('', On"
        ).replace("OnNotificationActionTopic)()", "OnNotificationActionTopic)")
        + """
home = read(ReadActionRequest(input=ActionHandle(identifier=2))).output
execute(ExecuteActionRequest(input=home))
rospy.sleep(20.0)
before = list(events)
service('activate_publishing_of_action_topic', OnNotificationActionTopic)()
execute(ExecuteActionRequest(input=home))
finish(1)
""",
    )
    assert ran["before"] == []
    assert (1, 2) in ran["events"]
