"""What moveit_commander's compiled binding refuses, and with what; what it takes all the same."""

import pytest

START = """\
import rospy
arm, hand = MoveGroupCommander("panda_arm"), MoveGroupCommander("hand")
robot = moveit_commander.RobotCommander()
state = robot.get_current_state()
pose = arm.get_current_pose()
POSE = [0.4, 0.0, 0.5, 3.14, 0.0, 0.0]
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
arm.set_joint_value_target(READY)
path = arm.plan()[1]

def caught(call):
    try:
        call()
    except Exception as error:
        return f"{type(error).__module__}.{type(error).__name__}: {error}"
    return ""
"""
NOT_A_NUMBER = "of type double from this Python object of type str"
NO_SUCH = "moveit_commander.exception.MoveItCommanderException"


REFUSED = [
    # Messages travel as bytes; those of another type are too short, or are none.
    ("arm.retime_trajectory(pose.pose, path, 0.2, 0.2)", "builtins.RuntimeError: Buffer"),
    ("arm.retime_trajectory(state, path.joint_trajectory)", "builtins.RuntimeError: Buffer"),
    ("arm.retime_trajectory(state, (True, path))", "AttributeError: 'tuple' object has no"),
    ("arm.retime_trajectory(None, path)", "AttributeError: 'NoneType' object has no"),
    ("arm.retime_trajectory(path, path)", "builtins.RuntimeError: Buffer Overrun"),
    ("arm.retime_trajectory(READY, path)", "AttributeError: 'list' object has no"),
    ("arm.retime_trajectory(moveit_msgs.msg.RobotState(), path)", "DeserializationError"),
    ("arm.retime_trajectory(state, path, '0.2')", "Boost.Python.ArgumentError: Python"),
    ("arm.set_start_state(pose)", "builtins.RuntimeError: Buffer Overrun"),
    ("arm.set_start_state(READY)", "AttributeError: 'list' object has no"),
    ("arm.enforce_bounds(pose.pose)", "builtins.RuntimeError: Buffer Overrun"),
    ("arm.execute((path, 1.0))", "AttributeError: 'tuple' object has no attribute 'header'"),
    ("arm.execute(None)", "AttributeError: 'NoneType' object has no attribute 'header'"),
    ("arm.execute(pose)", "AttributeError: 'PoseStamped' object has no attribute 'joint"),
    # Poses are lists, and nothing else.
    ("arm.set_pose_target(tuple(POSE))", "Boost.Python.ArgumentError: Python argument"),
    ("arm.set_pose_target(arm.get_current_state())", "Boost.Python.ArgumentError"),
    ("arm.set_pose_target(POSE[:5])", f"{NO_SUCH}: Unable to set target pose"),
    ("arm.set_pose_target(['a', *POSE[1:]])", NOT_A_NUMBER),
    ("hand.set_pose_target(POSE)", f"{NO_SUCH}: There is no end effector to set the pose"),
    ("arm.set_pose_targets([pose])", "TypeError: Expecting an object of type list; got an"),
    ("arm.set_pose_targets([POSE[:5]])", f"{NO_SUCH}: Unable to set target poses"),
    ("arm.set_position_target(pose)", "TypeError: 'PoseStamped' object is not subscriptable"),
    ("arm.set_rpy_target([0, 0])", f"{NO_SUCH}: Expected [roll, pitch, yaw]"),
    ("arm.compute_cartesian_path([pose], 0.01)", "'PoseStamped' object has no attribute"),
    ("arm.compute_cartesian_path([POSE], 0.01)", "'list' object has no attribute 'position'"),
    ("arm.compute_cartesian_path([pose.pose], '0.01')", "Boost.Python.ArgumentError"),
    # Joint values: as many as variables, and numbers.
    ("arm.go(READY[:6])", f"{NO_SUCH}: Error setting joint target. Is the target within"),
    ("arm.go([*READY, 0.0])", f"{NO_SUCH}: Error setting joint target"),
    ("hand.go([0.02])", f"{NO_SUCH}: Error setting joint target"),
    ("arm.go('ready')", f"{NO_SUCH}: Joint value expected when joint name specified"),
    ("arm.plan('ready')", "builtins.KeyError: 'ready'"),
    ("arm.go(['0.0', *READY[1:]])", NOT_A_NUMBER),
    ("arm.go({'panda_joint1': '0.1'})", NOT_A_NUMBER),
    ("arm.go({'joint_1': 0.1})", f"{NO_SUCH}: Error setting joint target"),
    ("arm.set_joint_value_target('panda_joint1', '0.1')", "Boost.Python.ArgumentError"),
    ("arm.set_joint_value_target(3.0)", f"{NO_SUCH}: Unsupported argument of type"),
    ("arm.set_joint_value_target(state)", f"{NO_SUCH}: Unsupported argument of type"),
    ("arm.go(state)", f"{NO_SUCH}: Unsupported argument of type <class"),
    ("arm.plan(path)", f"{NO_SUCH}: Unsupported argument of type"),
    ("arm.set_joint_value_target(pose.pose.position)", f"{NO_SUCH}: Unsupported argument"),
    ("arm.set_joint_value_target(state.joint_state, 0.1)", f"{NO_SUCH}: Too many arguments"),
    ("arm.set_joint_value_target(pose, 0.1)", f"{NO_SUCH}: Unexpected type"),
    ("arm.remember_joint_values('there', tuple(READY))", "Boost.Python.ArgumentError"),
    ("arm.remember_joint_values('there', ['0.1'] * 7)", NOT_A_NUMBER),
    ("arm.set_named_target(READY)", "set_named_target(MoveGroupInterface, list)"),
    ("arm.set_named_target('Ready')", f"{NO_SUCH}: Unable to set target Ready. Is the"),
    # Links and objects.
    ("arm.set_end_effector_link(None)", "Boost.Python.ArgumentError"),
    ("arm.set_pose_target(POSE, None)", "builtins.TypeError: object of type 'NoneType'"),
    ("arm.get_current_pose(7)", "builtins.TypeError: object of type 'int' has no len()"),
    ("arm.attach_object('box', 'panda_hand', ('panda_hand',))", "Boost.Python.ArgumentError"),
    ("arm.detach_object(None)", "detach_object(MoveGroupInterface, NoneType)"),
    # Settings.
    ("arm.set_workspace(['a'] * 6)", "Boost.Python.ArgumentError"),
    ("arm.set_path_constraints('upright')", f"{NO_SUCH}: Unable to set path constraints up"),
    ("arm.set_path_constraints(pose)", "Boost.Python.ArgumentError"),
    ("arm.set_trajectory_constraints(pose)", "builtins.TypeError: can only concatenate str"),
    ("arm.set_goal_tolerance('0.01')", "set_goal_tolerance(MoveGroupInterface, str)"),
    ("arm.set_goal_joint_tolerance([0.01])", "Boost.Python.ArgumentError"),
    ("arm.set_planning_time('5')", "set_planning_time(MoveGroupInterface {lvalue}, double)"),
    ("arm.set_num_planning_attempts(10.0)", "{lvalue}, unsigned int)"),
    ("arm.set_num_planning_attempts(-1)", "builtins.OverflowError"),
    ("arm.set_planner_id(None)", "{lvalue}, std::string)"),
    ("arm.allow_replanning('yes')", "{lvalue}, bool)"),
    ("arm.set_max_velocity_scaling_factor(0.0)", f"{NO_SUCH}: Expected value in the range"),
    ("arm.set_max_velocity_scaling_factor(1.5)", f"{NO_SUCH}: Expected value in the range"),
    ("arm.set_max_acceleration_scaling_factor(100)", f"{NO_SUCH}: Expected value in the"),
    ("arm.set_max_velocity_scaling_factor('0.5')", "builtins.TypeError: '>' not supported"),
]


TAKEN = [
    "arm.retime_trajectory(state, path, 1, True)",
    "arm.retime_trajectory(moveit_msgs.msg.RobotState(is_diff=True), path, 0.2)",
    "arm.execute(path.joint_trajectory)",
    "arm.set_pose_target([0, 0, 1, 0, 0, 0])",
    "arm.set_pose_targets([pose.pose, POSE, POSE[:5]])",
    "arm.set_position_target((0.4, 0.0, 0.5, 9.0))",
    "arm.compute_cartesian_path((pose.pose,), 1)",
    "arm.compute_cartesian_path([pose.pose], 0.01, 0.0)",
    "arm.compute_cartesian_path([pose.pose], 0.01, True)",
    "arm.go(tuple(READY))",
    "hand.go([0.02, 0.02])",
    "arm.set_joint_value_target('panda_joint1', [0.1])",
    "arm.set_planning_time(-1)",
    "arm.set_goal_tolerance(1)",
    "arm.allow_replanning(None)",
]


@pytest.fixture(scope="module")
def errors(outcomes_of):
    """What each call raises, all in one run; the ones that are taken come last."""
    calls = [*(call for call, _ in REFUSED), *TAKEN]
    return outcomes_of(f"{START}\noutcome_of = caught\n", calls)


@pytest.mark.parametrize(("call", "error"), REFUSED)
def test_the_binding_refuses(errors, call, error):
    assert error in errors[call]


@pytest.mark.parametrize("call", TAKEN)
def test_the_binding_takes(errors, call):
    assert errors[call] == ""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    "turn",
    ["[0.0, 0.0, 0.0, 0.0]", "[0.0, 1.4, 0.0, 1.4]", "[0.7, 0.0, 0.7, 0.0]"],
)
@pytest.mark.parametrize("way", ["set_pose_target([0.4, 0.1, 0.5, *turn])", "go(stated)"])
def test_an_orientation_that_is_no_unit_quaternion_is_taken_for_none(run, turn, way):
    ran = run(
        f"""{START}
arm.set_max_velocity_scaling_factor(1.0)
turn = {turn}
stated = moveit_commander.conversions.list_to_pose([0.4, 0.1, 0.5, *turn])
with_it = caught(lambda: arm.{way})
request = arm.construct_motion_plan_request()
q = request.goal_constraints[0].orientation_constraints[0].orientation
found = q.x, q.y, q.z, q.w
"""
    )
    assert ran["with_it"] == ""
    assert ran["found"] == (0.0, 0.0, 0.0, 1.0)


def test_an_orientation_within_a_thousandth_of_unit_length_is_kept(run):
    ran = run(
        f"""{START}
arm.set_pose_target([0.4, 0.1, 0.5, 0.7071, 0.0, 0.7071, 0.0])
q = arm.construct_motion_plan_request().goal_constraints[0].orientation_constraints[0].orientation
found = q.x, q.z
"""
    )
    assert ran["found"] == pytest.approx((0.7071, 0.7071), abs=1e-3)


@pytest.mark.parametrize("use", ["arm.execute(plan)", "plan.joint_trajectory"])
def test_a_plan_read_as_before_noetic_is_taken_and_reported(run, use):
    ran = run(f"{START}\narm.set_joint_value_target(READY)\nplan = arm.plan()\n{use}\n")
    assert [each.kind for each in ran.recording.findings] == ["distro_assumed"]
    assert "use plan()[1]" in ran.findings[0]


_OLDER_PATHS = (
    "arm.compute_cartesian_path([pose.pose], 0.01, 0.0)",
    "arm.compute_cartesian_path([pose.pose], 0.01, 0.0, True)",
    "arm.compute_cartesian_path([pose.pose], 0.01, jump_threshold=0.0)",
    "arm.compute_cartesian_path([pose.pose], 0.01, 0.0, avoid_collisions=False)",
    "arm.compute_cartesian_path([pose.pose], 0.01, 0.0, True, moveit_msgs.msg.Constraints())",
)


@pytest.mark.parametrize(
    ("call", "error"),
    list(
        zip(
            _OLDER_PATHS,
            (
                "(MoveGroupInterface, list, float, float)\ndid not match C++ signature",
                "unknown constraint type <class 'bool'>",
                "unexpected keyword argument 'jump_threshold'",
                "multiple values for argument 'avoid_collisions'",
                "from 0 to 2 positional arguments but 3 were given",
            ),
            strict=True,
        )
    ),
)
def test_a_path_with_a_jump_threshold_raises_where_the_workspace_has_a_later_moveit(
    run, call, error
):
    ran = run(f"{START}\nerror = caught(lambda: {call})\n", is_known=True, moveit="1.1.15")
    assert error in ran["error"]


@pytest.mark.slow(but=4)
@pytest.mark.parametrize(
    "call",
    [
        *_OLDER_PATHS,
        "arm.compute_cartesian_path([pose.pose], 0.01, 0, True)",
        "arm.compute_cartesian_path([pose.pose], 0.01, 0, path_constraints=None, "
        "avoid_collisions=True)",
        "arm.compute_cartesian_path(waypoints=[pose.pose], eef_step=0.01, jump_threshold=0.0, "
        "avoid_collisions=True, path_constraints=None)",
    ],
)
@pytest.mark.parametrize("moveit", ["", "1.1.14"])
def test_a_path_with_a_jump_threshold_is_taken_and_reported_where_nothing_names_the_release(
    run, call, moveit
):
    ran = run(f"{START}\nerror = caught(lambda: {call})\n", is_known=True, moveit=moveit)
    assert ran["error"] == ""
    reported = [] if moveit else ["distro_assumed"]
    assert [each.kind for each in ran.recording.findings] == reported
    for finding in ran.recording.findings:
        assert "moveit_release in [tool.tracerisk] names the release" in finding.message


@pytest.mark.parametrize(
    ("call", "moveit", "error", "findings"),
    [
        ("arm.execute(plan_msg=path)", "", "", ["distro_assumed"]),
        ("arm.execute(plan_msg=path, wait=True)", "1.1.11", "", []),
        ("arm.execute(plan_msg=path)", "1.1.12", "keyword argument 'plan_msg'", []),
        ("arm.execute(trajectory=path, wait=True)", "", "", []),
        ("arm.execute()", "", "missing 1 required positional argument: 'trajectory'", []),
    ],
)
def test_a_plan_is_executed_by_either_name_of_its_release(run, call, moveit, error, findings):
    ran = run(f"{START}\nerror = caught(lambda: {call})\n", is_known=True, moveit=moveit)
    assert error in ran["error"]
    assert bool(error) == bool(ran["error"])
    assert [finding.kind for finding in ran.recording.findings] == findings


@pytest.mark.parametrize("given", ["", ", False", ", True, moveit_msgs.msg.Constraints()"])
def test_a_path_by_the_present_arguments_is_taken_without_a_word(run, given):
    ran = run(f"{START}\npath, fraction = arm.compute_cartesian_path([pose.pose], 0.01{given})\n")
    assert (ran["fraction"], ran.findings) == (1.0, [])


def test_a_value_of_a_joint_that_follows_another_leads_nowhere(run):
    ran = run(
        f"""{START}
hand.go([0.01, 0.01])
hand.set_joint_value_target("panda_finger_joint2", 0.03)
alone = hand.get_joint_value_target()
hand.set_joint_value_target([0.02, 0.035])
both, active, values = hand.get_joint_value_target(), hand.get_active_joints(), hand.get_current_joint_values()
"""
    )
    assert ran["alone"] == [0.01, 0.01]
    assert ran["both"] == [0.02, 0.02]
    assert ran["active"] == ["panda_finger_joint1"]
    assert len(ran["values"]) == 2
