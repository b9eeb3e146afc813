"""Programs of MoveItPy, end to end on the twin."""

import pytest

ARM = tuple(f"panda_joint{number}" for number in range(1, 8))


def test_a_named_state_is_reached_and_is_one_command_of_the_function_that_executes(run):
    ran = run(
        """
def move():
    return go("ready")
status = move()
with monitor.read_only() as scene:
    reached = scene.current_state.get_joint_group_positions("panda_arm")
"""
    )
    assert bool(ran["status"]) is True
    assert ran["status"].status == "SUCCEEDED"
    assert list(ran["reached"]) == pytest.approx(ran["READY"], abs=0.005)
    (command,) = ran.recording.commands
    assert command.elements == ARM
    assert [frame.function.name for frame in command.stack] == ["<module>", "move", "go"]
    assert command.end == "arrived"
    assert command.issue_ns < command.end_ns


def test_planning_moves_nothing_and_is_no_command(run):
    ran = run(
        """
arm.set_goal_state(configuration_name="ready")
result = arm.plan()
trajectory = result.trajectory
message = trajectory.get_robot_trajectory_msg()
points = list(trajectory)
code = result.error_code.val
"""
    )
    assert bool(ran["result"]) is True
    assert ran["code"] == 1
    assert ran.recording.commands == ()
    message = ran["message"].joint_trajectory
    assert tuple(message.joint_names) == ARM
    assert message.header.frame_id == "panda_link0"
    times = [p.time_from_start.sec + p.time_from_start.nanosec / 1e9 for p in message.points]
    assert times == sorted(set(times))
    trajectory = ran["trajectory"]
    assert times[-1] == pytest.approx(trajectory.duration)
    assert trajectory.joint_model_group_name == "panda_arm"
    assert len(trajectory) == len(ran["points"]) == len(message.points)
    assert sum(duration for _, duration in ran["points"]) == pytest.approx(trajectory.duration)
    begin = ran["result"].start_state.joint_state
    assert dict(zip(begin.name, begin.position, strict=True))["panda_joint4"] == pytest.approx(-2.6)


def test_the_arm_begins_where_its_first_motion_was_planned_from(run):
    ran = run(
        """
arm.set_start_state(configuration_name="ready")
arm.set_goal_state(configuration_name="extended")
status = panda.execute(arm.plan().trajectory, controllers=[])
"""
    )
    assert bool(ran["status"]) is True
    (command,) = ran.recording.commands
    assert command.end == "arrived"
    (reported,) = ran.findings
    assert "the arm is assumed to begin where its first motion was planned from" in reported
    assert "panda_joint2 -0.7854" in reported


def test_a_plan_from_elsewhere_is_not_executed(run):
    ran = run(
        """
go("extended")
arm.set_start_state(configuration_name="ready")
arm.set_goal_state(configuration_name="extended")
plan = arm.plan()
status = panda.execute(plan.trajectory, controllers=[])
"""
    )
    assert bool(ran["plan"]) is True
    assert bool(ran["status"]) is False
    assert ran["status"].status == "ABORTED"
    assert len(ran.recording.commands) == 1
    assert "plan from the present state" in ran.findings[0]


def test_a_pose_is_reached(run):
    ran = run(
        """
go("ready")
goal = PoseStamped()
goal.header.frame_id = "panda_link0"
goal.pose.position.x, goal.pose.position.y, goal.pose.position.z = 0.28, -0.2, 0.5
goal.pose.orientation.w = 1.0
taken = arm.set_goal_state(pose_stamped_msg=goal, pose_link="panda_link8")
plan = arm.plan()
done = bool(panda.execute(plan.trajectory, controllers=[]))
with monitor.read_only() as scene:
    reached = scene.current_state.get_pose("panda_link8")
    matrix = scene.current_state.get_global_link_transform("panda_link8")
"""
    )
    assert (ran["taken"], ran["done"]) == (True, True)
    p = ran["reached"].position
    assert (p.x, p.y, p.z) == pytest.approx((0.28, -0.2, 0.5), abs=0.003)
    assert ran["matrix"][:3, 3].tolist() == pytest.approx([p.x, p.y, p.z])


def test_a_state_and_a_joint_constraint_are_goals(run):
    ran = run(
        """
from moveit.core.kinematic_constraints import construct_joint_constraint
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
arm.set_goal_state(robot_state=state)
panda.execute(arm.plan().trajectory, controllers=[])
first = monitor.read_only().__enter__().current_state.joint_positions["panda_joint4"]
"""
    )
    assert ran["first"] == pytest.approx(-2.3562, abs=0.005)
    ran = run(
        """
from moveit.core.kinematic_constraints import construct_joint_constraint
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
state.joint_positions = {"panda_joint1": 0.3}
group = panda.get_robot_model().get_joint_model_group("panda_arm")
constraint = construct_joint_constraint(robot_state=state, joint_model_group=group)
arm.set_goal_state(motion_plan_constraints=[constraint])
done = panda.execute(arm.plan().trajectory, controllers=[])
with monitor.read_only() as scene:
    second = scene.current_state.joint_positions["panda_joint1"]
"""
    )
    assert ran["constraint"].joint_constraints[0].tolerance_above == 0.01
    assert ran["second"] == pytest.approx(0.3, abs=0.005)


def test_a_pose_out_of_reach_is_a_failure_and_a_finding(run):
    ran = run(
        """
goal = PoseStamped()
goal.header.frame_id = "panda_link0"
goal.pose.position.x, goal.pose.orientation.w = 3.0, 1.0
arm.set_goal_state(pose_stamped_msg=goal, pose_link="panda_link8")
plan = arm.plan()
code = plan.error_code.val
status = panda.execute(plan.trajectory, controllers=[])
"""
    )
    assert bool(ran["plan"]) is False
    assert ran["code"] == -1
    assert ran["plan"].trajectory is None
    assert ran["status"].status == "ABORTED"
    assert "planning for group 'panda_arm' failed" in ran.findings[0]


def test_without_a_goal_nothing_is_planned(run):
    ran = run("code = arm.plan().error_code.val\n")
    assert ran["code"] == -16
    assert ran.findings == [
        "planning for group 'panda_arm' failed: no goal is set; call set_goal_state"
    ]


def test_without_blocking_the_motion_goes_on(run):
    ran = run(
        """
arm.set_goal_state(configuration_name="ready")
plan = arm.plan()
status = panda.execute("panda_arm", plan.trajectory, blocking=False)
at_once = status.status
time.sleep(0.2)
manager = panda.get_trajectory_execution_manager()
running = manager.get_last_execution_status().status
after = manager.wait_for_execution()
"""
    )
    assert (ran["at_once"], ran["running"], ran["after"].status) == (
        "RUNNING",
        "RUNNING",
        "SUCCEEDED",
    )
    (command,) = ran.recording.commands
    assert command.stack[-1].function.name == "<module>"
    assert (command.end_ns - command.issue_ns) / 1e9 == pytest.approx(
        ran["plan"].trajectory.duration, abs=0.3
    )


def test_pushed_trajectories_are_executed_in_order_and_the_callback_is_a_root(run):
    ran = run(
        """
order = []
def done(status):
    order.append(status.status)
    go("extended")
def part(number):
    order.append(number)
manager = panda.get_trajactory_execution_manager()
arm.set_goal_state(configuration_name="ready")
plan = arm.plan()
pushed = manager.push(plan.trajectory.get_robot_trajectory_msg(), "arm_controller")
manager.execute(done, part)
order.append("went on")
time.sleep(30)
"""
    )
    assert ran["pushed"] is True
    assert ran["order"] == ["went on", 0, "SUCCEEDED"]
    first, second = ran.recording.commands
    assert first.stack[-1].function.name == "<module>"
    assert [frame.function.name for frame in second.stack] == ["done", "go"]


def test_stopping_preempts(run):
    ran = run(
        """
arm.set_goal_state(configuration_name="ready")
manager = panda.get_trajectory_execution_manager()
manager.push(arm.plan().trajectory.get_robot_trajectory_msg())
manager.execute(lambda status: None)
time.sleep(0.1)
manager.process_event("stop")
status = manager.wait_for_execution()
manager.process_event("leap")
"""
    )
    assert ran["status"].status == "PREEMPTED"


def test_the_start_tolerance_is_the_managers(run):
    ran = run(
        """
arm.set_start_state(configuration_name="ready")
arm.set_goal_state(configuration_name="extended")
plan = arm.plan()
manager = panda.get_trajectory_execution_manager()
manager.set_allowed_start_tolerance(0.0)
status = panda.execute(plan.trajectory, controllers=[])
"""
    )
    assert ran["manager"].allowed_start_tolerance() == 0.0
    assert len(ran.recording.commands) == 1


def test_the_hand_is_the_gripper(run):
    ran = run(
        """
hand = panda.get_planning_component("hand")
hand.set_start_state_to_current_state()
hand.set_goal_state(configuration_name="open")
status = panda.execute(hand.plan().trajectory, controllers=["hand_controller"])
"""
    )
    assert bool(ran["status"])
    assert ran.recording.commands[0].elements == ("panda_hand",)


def test_speeds_are_those_of_the_parameters(run):
    ran = run(
        """
robot = MoveItPy(node_name="slow", config_dict={
    "slowly": {"plan_request_params": {"max_velocity_scaling_factor": 0.1,
                                       "max_acceleration_scaling_factor": 0.1,
                                       "planner_id": "RRTConnect", "planning_attempts": 3}}})
arm.set_goal_state(configuration_name="ready")
fast = arm.plan()
slowly = PlanRequestParameters(robot, "slowly")
slow = arm.plan(single_plan_parameters=slowly)
slowly.max_velocity_scaling_factor = 0.05
slower = arm.plan(single_plan_parameters=slowly)
several = MultiPipelinePlanRequestParameters(robot, ["slowly", "chomp"])
best = arm.plan(multi_plan_parameters=several)
chosen = arm.plan(multi_plan_parameters=several,
                  solution_selection_function=lambda all: max(all, key=lambda one: one.trajectory.duration))
"""
    )
    assert ran["slowly"].planning_attempts == 3
    assert ran["slow"].planner_id == "RRTConnect"
    fast, slow, slower = (ran[name].trajectory.duration for name in ("fast", "slow", "slower"))
    assert fast < slow < slower
    assert bool(ran["best"])
    assert ran["chosen"].trajectory.duration == pytest.approx(slow)


def test_lin_goes_in_a_straight_line(run):
    ran = run(
        """
go("ready")
time.sleep(0.5)
goal = PoseStamped()
goal.header.frame_id = "panda_link0"
with monitor.read_only() as scene:
    goal.pose = scene.current_state.get_pose("panda_link8")
goal.pose.position.y += 0.2
lin = PlanRequestParameters(panda, "pilz_lin")
lin.planner_id = "LIN"
arm.set_goal_state(pose_stamped_msg=goal, pose_link="panda_link8")
plan = arm.plan(single_plan_parameters=lin)
heights = []
for state, _ in plan.trajectory:
    state.update()
    heights.append(state.get_pose("panda_link8").position.z)
lin.planner_id = "CIRC"
arc = arm.plan(single_plan_parameters=lin)
"""
    )
    assert max(ran["heights"]) - min(ran["heights"]) < 1e-3
    assert not ran["arc"]
    assert "the planner CIRC is not provided" in ran.findings[0]


def test_path_constraints_are_kept_or_the_plan_fails(run):
    ran = run(
        """
from moveit.core.kinematic_constraints import construct_joint_constraint
state = RobotState(panda.get_robot_model())
state.set_to_default_values("panda_arm", "ready")
group = panda.get_robot_model().get_joint_model_group("panda_arm")
arm.set_path_constraints(construct_joint_constraint(state, group, 0.01))
arm.set_goal_state(configuration_name="extended")
code = arm.plan().error_code.val
"""
    )
    assert ran["code"] == -1
    assert "the path constraints" in ran.findings[0]


def test_random_states_are_clear_of_collisions(run):
    ran = run(
        """
state = RobotState(panda.get_robot_model())
with panda.get_planning_scene_monitor().read_only() as scene:
    touching = []
    for _ in range(40):
        state.set_to_random_positions()
        state.update()
        touching.append(scene.is_state_colliding(robot_state=state, joint_model_group_name=""))
"""
    )
    assert ran["touching"] == [False] * 40


def test_the_same_program_gives_the_same_recording(run, tmp_path):
    program = """
state = RobotState(panda.get_robot_model())
state.set_to_random_positions()
drawn = state.joint_positions
go("ready")
"""
    one, two = run(program), run(program)
    assert one["drawn"] == two["drawn"]
    assert one.recording.commands == two.recording.commands


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("change", "status"),
    [
        ("pass", "SUCCEEDED"),
        ("manager.set_allowed_execution_duration_scaling(0.1)", "TIMED_OUT"),
        ("manager.enable_execution_duration_monitoring(False)", "SUCCEEDED"),
    ],
)
def test_the_manager_stops_what_takes_longer_than_it_allows(run, change, status):
    ran = run(
        f"""
manager = panda.get_trajectory_execution_manager()
manager.set_allowed_goal_duration_margin(0.05)
if {change == "manager.enable_execution_duration_monitoring(False)"}:
    manager.set_allowed_execution_duration_scaling(0.1)
if {change == "pass"}:
    manager.set_allowed_goal_duration_margin(0.5)
{change}
arm.set_start_state_to_current_state()
arm.set_goal_state(configuration_name="extended")
status = panda.execute(arm.plan().trajectory, controllers=[]).status
"""
    )
    assert ran["status"] == status


def test_the_node_has_the_parameters_of_the_execution_manager(run):
    ran = run(
        """
named = {"allowed_start_tolerance": 0.2, "allowed_goal_duration_margin": 2.0}
other = MoveItPy("other", config_dict={"trajectory_execution": named})
manager = other.get_trajectory_execution_manager()
found = manager.allowed_start_tolerance(), manager.allowed_goal_duration_margin()
"""
    )
    assert ran["found"] == (0.2, 2.0)


def test_only_the_first_of_the_pushed_trajectories_is_checked_for_its_start(run):
    ran = run(
        """
manager = panda.get_trajectory_execution_manager()
arm.set_start_state_to_current_state()
arm.set_goal_state(configuration_name="ready")
first = arm.plan().trajectory.get_robot_trajectory_msg()
arm.set_start_state(configuration_name="extended")
second = arm.plan().trajectory.get_robot_trajectory_msg()
manager.push(first)
manager.push(second)
status = manager.execute_and_wait().status
"""
    )
    assert ran["status"] == "SUCCEEDED"
    assert len(ran.recording.commands) == 2
