"""Programs of moveit_commander, end to end on the twin."""

import math

import pytest

from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

ARM = [f"panda_joint{number}" for number in range(1, 8)]
FAST = """\
arm = MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)
"""


def at(pose) -> tuple[float, float, float]:
    return (pose.position.x, pose.position.y, pose.position.z)


def test_a_named_target_is_reached_and_is_one_command(run, panda):
    ran = run(
        FAST
        + """
arm.set_named_target("ready")
done = arm.go(wait=True)
values = arm.get_current_joint_values()
"""
    )
    assert ran["done"] is True
    ready = panda.named_states["panda_arm"]["ready"]
    assert ran["values"] == pytest.approx([ready[name] for name in ARM], abs=0.005)
    (command,) = ran.recording.commands
    assert command.elements == tuple(ARM)
    assert command.end == "arrived"
    assert command.issue_ns < command.end_ns
    assert command.stack[-1].function.name == "<module>"


def test_planning_moves_nothing_and_is_no_command(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready")
before = arm.get_current_joint_values()
result = arm.plan()
success, trajectory, seconds, error = result
after = arm.get_current_joint_values()
"""
    )
    assert ran["success"] is True
    assert ran["error"].val == 1
    assert ran["before"] == pytest.approx(ran["after"], abs=1e-4)
    assert ran.recording.commands == ()
    joint_trajectory = ran["trajectory"].joint_trajectory
    assert joint_trajectory.joint_names == ARM
    assert joint_trajectory.header.frame_id == "panda_link0"
    times = [point.time_from_start.to_sec() for point in joint_trajectory.points]
    assert times[0] == 0.0
    assert times == sorted(set(times))
    assert all(len(point.accelerations) == 7 for point in joint_trajectory.points)


def test_a_plan_is_executed_once(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready")
trajectory = arm.plan()[1]
first = arm.execute(trajectory, wait=True)
second = arm.execute(trajectory, wait=True)
"""
    )
    assert (ran["first"], ran["second"]) == (True, False)
    assert len(ran.recording.commands) == 1
    (finding,) = ran.recording.findings
    assert finding.kind == "execution_failure"
    assert "it starts with joint 'panda_joint" in finding.message
    assert (finding.location.file, finding.location.line) == ("program.py", 11)


def test_a_motion_that_is_aborted_is_reported_at_the_line_that_asked_for_it(run):
    ran = run(
        FAST
        + """
import rospy
rospy.init_node("presses")
arm.set_max_velocity_scaling_factor(0.5)
arm.go([0.0, 1.6, 0.0, -1.0, 0.0, 2.0, 0.8], wait=False)  # through the table
rospy.sleep(1.0)
rospy.sleep(20.0)
"""
    )
    finding = next(each for each in ran.recording.findings if each.kind == "execution_failure")
    assert "presses on 'table'" in finding.message
    (command,) = ran.recording.commands
    asked = command.stack[-1].site[0]
    assert (finding.location.file, finding.location.line) == ("program.py", asked)


def test_the_result_of_plan_serves_programs_that_expect_the_trajectory_alone(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready")
plan = arm.plan()
points = len(plan.joint_trajectory.points)
done = arm.execute(plan)
"""
    )
    assert ran["points"] > 2
    assert ran["done"] is True


def test_a_pose_is_reached(run):
    ran = run(
        FAST
        + """
arm.go([0, -0.785, 0, -2.356, 0, 1.571, 0.785])
target = arm.get_current_pose().pose
target.position.z -= 0.15
done = arm.go(target)
reached = arm.get_current_pose()
"""
    )
    assert ran["done"] is True
    assert at(ran["reached"].pose) == pytest.approx(at(ran["target"]), abs=0.002)
    assert ran["reached"].header.frame_id == "panda_link0"


def test_a_pose_in_the_hands_own_frame_moves_along_the_hand(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
before = arm.get_current_pose().pose
target = geometry_msgs.msg.PoseStamped()
target.header.frame_id = "panda_link8"
target.pose.position.z = 0.1
target.pose.orientation.w = 1.0
arm.set_pose_target(target)
done = arm.go()
after = arm.get_current_pose().pose
"""
    )
    assert ran["done"] is True
    x, y, z = at(ran["before"])
    assert at(ran["after"]) == pytest.approx((x, y, z - 0.1), abs=0.002)


def test_a_pose_out_of_reach_is_a_failure_and_a_finding_at_the_callers_line(run):
    ran = run(
        FAST
        + """
pose = geometry_msgs.msg.Pose()
pose.position.x = 3.0
pose.orientation.w = 1.0
arm.set_pose_target(pose)
done = arm.go(wait=True)
success, trajectory, _, error = arm.plan()
"""
    )
    assert ran["done"] is False
    assert ran["success"] is False
    assert ran["error"].val == ran["moveit_msgs"].msg.MoveItErrorCodes.PLANNING_FAILED
    assert ran["trajectory"].joint_trajectory.points == []
    assert ran.recording.commands == ()
    first, second = ran.recording.findings
    assert (first.kind, first.location.line, second.location.line) == ("planning_failure", 12, 13)
    assert "planning for group 'panda_arm' failed" in first.message


def test_the_same_failure_at_the_same_line_is_reported_once(run):
    ran = run(
        FAST
        + """
pose = geometry_msgs.msg.Pose()
pose.position.x, pose.orientation.w = 3.0, 1.0
for _ in range(3):
    arm.go(pose)
"""
    )
    assert len(ran.recording.findings) == 1


def test_the_hand_is_the_gripper(run):
    ran = run(
        """
hand = MoveGroupCommander("hand")
done = hand.go([0.03, 0.03], wait=True)
values = hand.get_current_joint_values()
hand.set_named_target("close")
closed = hand.go()
"""
    )
    assert (ran["done"], ran["closed"]) == (True, True)
    assert ran["values"] == pytest.approx([0.03, 0.03], abs=0.001)
    assert [command.elements for command in ran.recording.commands] == [("panda_hand",)] * 2


def test_arm_and_hand_move_together_in_a_group_of_both(run):
    ran = run(
        """
both = MoveGroupCommander("panda_arm_hand")
both.set_max_velocity_scaling_factor(1.0)
both.set_max_acceleration_scaling_factor(1.0)
target = both.get_current_joint_values()
target[0], target[7], target[8] = 0.3, 0.02, 0.02
done = both.go(target)
values = both.get_current_joint_values()
"""
    )
    assert ran["done"] is True
    assert ran["values"] == pytest.approx(ran["target"], abs=0.005)
    assert ran.recording.commands[0].elements == (*ARM, "panda_hand")


def test_without_waiting_the_call_returns_at_once_and_the_command_stays_live(run):
    ran = run(
        FAST
        + """
import tracerisk.ros.graph.runtime
scheduler = tracerisk.ros.graph.runtime.current().scheduler
arm.set_named_target("ready")
asked = arm.go(wait=False)
returned_ns = scheduler.now_ns
scheduler.sleep(5_000_000_000)
"""
    )
    assert ran["asked"] is True
    (command,) = ran.recording.commands
    assert ran["returned_ns"] == command.issue_ns
    assert command.end == "arrived"
    assert 300_000_000 < command.end_ns - command.issue_ns < 4_000_000_000


def test_stop_preempts_what_moves(run):
    ran = run(
        FAST
        + """
import tracerisk.ros.graph.runtime
arm.set_named_target("ready")
arm.go(wait=False)
tracerisk.ros.graph.runtime.current().scheduler.sleep(200_000_000)
arm.stop()
"""
    )
    (command,) = ran.recording.commands
    assert command.end == "cancelled"
    assert command.end_ns == pytest.approx(command.issue_ns + 200_000_000, abs=5_000_000)


def test_a_new_motion_stops_the_one_before(run):
    ran = run(
        FAST
        + """
hand = MoveGroupCommander("hand")
hand.set_named_target("open")
arm.set_named_target("ready")
arm.go(wait=False)
done = hand.go(wait=True)
"""
    )
    arm, hand = ran.recording.commands
    assert (arm.end, hand.end) == ("replaced", "arrived")
    assert arm.replaced_by == hand.id
    assert arm.end_ns == hand.issue_ns


def test_slower_scaling_takes_longer(run):
    ran = run(
        """
arm = MoveGroupCommander("panda_arm")
arm.set_named_target("ready")
seconds = []
for scaling in (1.0, 0.5, 0.25):
    arm.set_max_velocity_scaling_factor(scaling)
    arm.set_max_acceleration_scaling_factor(scaling)
    seconds.append(arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec())
"""
    )
    fast, half, quarter = ran["seconds"]
    assert fast < half < quarter


def test_without_a_setting_plans_take_a_tenth_or_what_the_parameters_say(run):
    ran = run(
        """
import rospy
rospy.init_node("planner")
def seconds(arm):
    arm.set_named_target("ready")
    return arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec()

unasked = seconds(MoveGroupCommander("panda_arm"))
tenth = MoveGroupCommander("panda_arm")
tenth.set_max_velocity_scaling_factor(0.1)
tenth.set_max_acceleration_scaling_factor(0.1)
tenth = seconds(tenth)
for kind in ("velocity", "acceleration"):
    rospy.set_param("robot_description_planning/default_%s_scaling_factor" % kind, 0.5)
said = seconds(MoveGroupCommander("panda_arm"))
half = MoveGroupCommander("panda_arm", robot_description="other")
half.set_max_velocity_scaling_factor(0.5)
half.set_max_acceleration_scaling_factor(0.5)
half = seconds(half)
"""
    )
    assert ran["unasked"] == ran["tenth"]
    assert ran["said"] == ran["half"] < ran["tenth"]


def test_a_cartesian_path_is_straight_and_says_how_much_of_it(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
start = arm.get_current_pose().pose
down, aside = copy.deepcopy(start), None
down.position.z -= 0.1
aside = copy.deepcopy(down)
aside.position.y += 0.1
path, fraction = arm.compute_cartesian_path([down, aside], 0.01, 0.0)
path_noetic, fraction_noetic = arm.compute_cartesian_path([down, aside], 0.01, True)
path_plain, fraction_plain = arm.compute_cartesian_path([down, aside], 0.01)
done = arm.execute(path, wait=True)
end = arm.get_current_pose().pose
far = copy.deepcopy(end)
far.position.x += 2.0
short_path, short_fraction = arm.compute_cartesian_path([far], 0.01, 0.0)
"""
    )
    assert (ran["fraction"], ran["done"]) == (1.0, True)
    assert ran["fraction_noetic"] == ran["fraction_plain"] == 1.0
    path, noetic = (ran[name].joint_trajectory.points for name in ("path", "path_noetic"))
    assert len(path) == len(noetic)
    assert path[-1].positions == pytest.approx(noetic[-1].positions, abs=1e-3)
    assert at(ran["end"]) == pytest.approx(at(ran["aside"]), abs=0.002)
    assert 0.0 < ran["short_fraction"] < 0.5


def test_retiming_slows_a_path_and_keeps_it(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
robot = moveit_commander.RobotCommander()
down = arm.get_current_pose().pose
down.position.z -= 0.1
path, _ = arm.compute_cartesian_path([down], 0.01)
slow = arm.retime_trajectory(robot.get_current_state(), path, 0.1, 0.1)
"""
    )
    path, slow = ran["path"].joint_trajectory.points, ran["slow"].joint_trajectory.points
    assert slow[-1].time_from_start.to_sec() > 2 * path[-1].time_from_start.to_sec()
    assert slow[-1].positions == pytest.approx(path[-1].positions)


def test_a_plan_from_another_start_is_refused_when_the_arm_is_not_there(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
state = moveit_msgs.msg.RobotState()
state.joint_state.name = arm.get_active_joints()
state.joint_state.position = [0.5, -0.785, 0, -2.356, 0, 1.571, 0.785]
arm.set_start_state(state)
arm.set_named_target("ready")
success, trajectory, _, _ = arm.plan()
first = trajectory.joint_trajectory.points[0].positions[0]
done = arm.execute(trajectory)
arm.set_start_state_to_current_state()
after = arm.go()
"""
    )
    assert "more than 0.01 away" in ran.findings[0]
    assert (ran["success"], ran["first"], ran["done"], ran["after"]) == (True, 0.5, False, True)


def test_an_empty_plan_moves_nothing_and_is_answered_as_a_success(run):
    ran = run(FAST + "done = arm.execute(moveit_msgs.msg.RobotTrajectory())\n")
    assert ran["done"] is True
    (finding,) = ran.findings
    assert finding.startswith("an execution moves nothing: the trajectory is empty")


def test_the_speed_of_a_link_can_be_limited(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready")
free = arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec()
arm.limit_max_cartesian_link_speed(0.05)
slow = arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec()
arm.clear_max_cartesian_link_speed()
again = arm.plan()[1].joint_trajectory.points[-1].time_from_start.to_sec()
"""
    )
    assert ran["free"] == pytest.approx(ran["again"], abs=1e-3)
    assert ran["slow"] > 2 * ran["free"]


def test_a_plan_that_breaks_its_path_constraints_is_a_failure(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
keep = moveit_msgs.msg.JointConstraint(
    joint_name="panda_joint1", position=0.0, tolerance_above=0.1, tolerance_below=0.1)
arm.set_path_constraints(moveit_msgs.msg.Constraints(joint_constraints=[keep]))
target = arm.get_current_joint_values()
target[0] = 0.5
bad = arm.go(target)
target[0] = 0.05
good = arm.go(target)
arm.clear_path_constraints()
target[0] = 0.5
free = arm.go(target)
"""
    )
    assert (ran["bad"], ran["good"], ran["free"]) == (False, True, True)
    assert "joint 'panda_joint1' at" in ran.findings[0]


def test_an_orientation_constraint_keeps_the_hand_level(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
level = moveit_msgs.msg.OrientationConstraint(
    link_name="panda_link8", orientation=arm.get_current_pose().pose.orientation,
    absolute_x_axis_tolerance=0.1, absolute_y_axis_tolerance=0.1, absolute_z_axis_tolerance=4)
level.header.frame_id = "panda_link0"
arm.set_path_constraints(moveit_msgs.msg.Constraints(orientation_constraints=[level]))
target = arm.get_current_joint_values()
turned = list(target); turned[6] += 1.0
tilted = list(target); tilted[5] += 0.5
results = arm.go(turned), arm.go(tilted)
"""
    )
    assert ran["results"] == (True, False)
    assert "link 'panda_link8' is turned by" in ran.findings[0]


UPRIGHT = (
    FAST
    + """
arm.set_named_target("ready"); arm.go()
start = arm.get_current_joint_values()
upright = moveit_msgs.msg.OrientationConstraint(
    link_name="panda_link8", orientation=arm.get_current_pose().pose.orientation,
    absolute_x_axis_tolerance=WITHIN, absolute_y_axis_tolerance=WITHIN,
    absolute_z_axis_tolerance=4, weight=1.0)
upright.header.frame_id = "panda_link0"
goal = arm.get_current_pose().pose
goal.position.x, goal.position.y, goal.position.z = -0.1, 0.45, 0.65
arm.set_pose_target(goal)
free = arm.plan()[1].joint_trajectory
arm.set_path_constraints(moveit_msgs.msg.Constraints(orientation_constraints=[upright]))
arm.set_joint_value_target(list(free.points[-1].positions))
found, ruled = arm.plan()[:2]
straight = [point.positions for point in free.points]
level = [point.positions for point in ruled.joint_trajectory.points]
"""
)


def _greatest_tilt(positions):
    """Return how far panda_link8 leans from pointing down at most [rad]."""
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    rest = {joint.name: 0.0 for joint in robot.joints}
    names = [joint.name for joint in robot.arm_joints]
    turns = [
        kinematics.forward({**rest, **dict(zip(names, each, strict=True))}, "panda_link8")
        for each in positions
    ]
    # The z axis of the link, seen from the base: the last column of its rotation.
    down = [2 * (x * x + y * y) - 1 for x, y, z, w in (each.orientation for each in turns)]
    return max(math.acos(min(1.0, each)) for each in down)


@pytest.mark.parametrize("within", [0.15, 0.05])
def test_a_way_that_keeps_the_hand_upright_is_found_where_the_straight_one_does_not(run, within):
    ran = run(UPRIGHT.replace("WITHIN", str(within)))
    assert _greatest_tilt(ran["straight"]) > within
    assert ran["found"]
    # Turned about both axes at once it may lean by the hypotenuse.
    assert 0.0 < _greatest_tilt(ran["level"]) < 1.45 * within
    assert not ran.findings


def test_a_cartesian_path_ends_where_its_constraints_do(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
here = arm.get_current_pose().pose
there = copy.deepcopy(here); there.position.z -= 0.2
keep = moveit_msgs.msg.JointConstraint(
    joint_name="panda_joint4", position=arm.get_current_joint_values()[3],
    tolerance_above=0.1, tolerance_below=0.1)
rule = moveit_msgs.msg.Constraints(joint_constraints=[keep])
path, fraction = arm.compute_cartesian_path([there], 0.01, True, rule)
whole = arm.compute_cartesian_path([there], 0.01, True)[1]
""".replace("copy.", "__import__('copy').")
    )
    assert ran["whole"] == 1.0
    assert 0.1 < ran["fraction"] < 0.95
    assert "a Cartesian path of group 'panda_arm' was cut" in ran.findings[0]


@pytest.mark.parametrize("link", ["panda_link8", "panda_hand_tcp"])
def test_the_link_that_a_pose_is_for_can_be_chosen(run, link):
    ran = run(
        FAST
        + f"""
arm.set_named_target("ready"); arm.go()
arm.set_end_effector_link("{link}")
target = arm.get_current_pose().pose
target.position.x += 0.05
done = arm.go(target)
reached = arm.get_current_pose().pose
"""
    )
    assert ran["done"] is True
    assert at(ran["reached"]) == pytest.approx(at(ran["target"]), abs=0.002)


def test_a_joint_of_the_robot_can_be_moved_alone(run):
    ran = run(
        """
robot = moveit_commander.RobotCommander()
robot.get_group("panda_arm").set_max_velocity_scaling_factor(1.0)
before = robot.get_current_variable_values()
done = robot.get_joint("panda_joint1").move(0.4)
after = robot.get_current_variable_values()
"""
    )
    assert ran["done"] is True
    assert ran["after"]["panda_joint1"] == pytest.approx(0.4, abs=0.005)
    others = [n for n in ARM if n != "panda_joint1"]
    assert [ran["after"][n] for n in others] == pytest.approx(
        [ran["before"][n] for n in others], abs=0.005
    )


def test_a_position_alone_is_reached_in_any_orientation(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
arm.set_position_target([0.4, 0.1, 0.5])
done = arm.go()
reached = arm.get_current_pose().pose
"""
    )
    assert ran["done"] is True
    assert at(ran["reached"]) == pytest.approx((0.4, 0.1, 0.5), abs=0.002)


def test_an_orientation_alone_is_reached_at_any_position(run):
    ran = run(
        FAST
        + """
arm.set_named_target("ready"); arm.go()
arm.set_rpy_target([math.pi, 0.0, 0.4])
done = arm.go()
rpy = arm.get_current_rpy()
"""
    )
    assert ran["done"] is True
    roll, pitch, yaw = ran["rpy"]
    assert (abs(roll), pitch, yaw) == pytest.approx((math.pi, 0.0, 0.4), abs=0.01)


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("axis", range(6))
def test_a_target_is_shifted_along_an_axis(run, axis):
    ran = run(
        FAST
        + f"""
arm.set_named_target("ready"); arm.go()
pose, rpy = arm.get_current_pose().pose, arm.get_current_rpy()
before = moveit_commander.conversions.pose_to_list(pose)[:3] + rpy
arm.shift_pose_target({axis}, 0.05)
done = arm.go()
pose, rpy = arm.get_current_pose().pose, arm.get_current_rpy()
after = moveit_commander.conversions.pose_to_list(pose)[:3] + rpy
"""
    )
    change = [after - before for after, before in zip(ran["after"], ran["before"], strict=True)]
    change = [math.remainder(value, 2 * math.pi) for value in change]
    expected = [0.05 if index == axis else 0.0 for index in range(6)]
    assert ran["done"] is True
    assert change == pytest.approx(expected, abs=0.004)
