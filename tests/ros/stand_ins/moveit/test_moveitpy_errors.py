"""What MoveItPy refuses, in the real library's words, with what is allowed."""

import pytest

from tests.slow import slow_but

REFUSED = [
    (
        'arm.set_goal_state(configuration_name="ready", robot_state=state)',
        "ValueError: Cannot specify both configuration name and robot state",
    ),
    (
        "arm.set_goal_state(pose_stamped_msg=PoseStamped(), motion_plan_constraints=[Constraints()])",
        "ValueError: Cannot specify both pose goal and motion plan constraints",
    ),
    (
        "arm.set_goal_state(pose_stamped_msg=PoseStamped())",
        "ValueError: Must specify both message and corresponding link",
    ),
    ("arm.set_goal_state()", "ValueError: Must specify at least one argument"),
    ("arm.set_start_state()", "ValueError: Must specify at least one argument"),
    (
        'arm.set_start_state("ready", state)',
        "ValueError: Cannot specify both configuration name and robot state",
    ),
    (
        "arm.set_goal_state(robot_state=3)",
        "TypeError: incompatible function arguments: robot_state takes RobotState, not int",
    ),
    (
        "arm.plan(PlanRequestParameters(panda, ''), MultiPipelinePlanRequestParameters(panda, []))",
        "ValueError: Cannot specify both single and multi plan parameters",
    ),
    (
        "arm.plan(planning_scene=monitor.read_only().__enter__())",
        "ValueError: Cannot specify planning scene without specifying plan parameters",
    ),
    ("arm.plan(stopping_criterion_callback=print)", "TypeError: stopping_criterion_callback"),
    (
        'panda.get_planning_component("panda_leg")',
        "RuntimeError: Could not find joint model group 'panda_leg'. Groups of robot 'panda': "
        "did you mean 'panda_arm'? allowed: ",
    ),
    ("panda.execute()", "TypeError: execute(): incompatible function arguments"),
    ("panda.execute(3, controllers=[])", "the trajectory is of type int"),
    ('panda.execute(None, controllers="arm")', "controllers is a list of names"),
    (
        'state.joint_positions = {"elbow": 1.0}',
        "RuntimeError: Variable 'elbow' is not known to model 'panda'; allowed: ",
    ),
    (
        'state.set_joint_group_positions("panda_arm", [0.0])',
        "ValueError: group 'panda_arm' has 7 variables",
    ),
    (
        'state.set_joint_group_positions("leg", [0.0])',
        "RuntimeError: Group 'leg' not found in model 'panda'; allowed: ",
    ),
    ('state.get_pose("elbow")', "RuntimeError: Invalid link: 'elbow' is none of the model"),
    ('state.update(type="some")', "ValueError: Invalid category"),
    ('state.get_jacobian("panda_arm", "panda_link0", [0, 0, 0])', "Unable to compute Jacobian"),
    ("RobotState(3)", "TypeError: RobotState takes a RobotModel, not int"),
    ("request.distance = True; scene.check_collision(request, result)", "is not provided"),
    ("request.speed = 1", "AttributeError: 'CollisionRequest' object has no attribute 'speed'"),
    ("scene.process_octomap(None)", "NotImplementedError: PlanningScene.process_octomap"),
    ("scene.is_state_colliding()", "TypeError: is_state_colliding(): incompatible function"),
    ("scene.find_grasps", "'PlanningScene' object has no attribute 'find_grasps'"),
    ("constraints.construct_link_constraint('a', 'b')", "ValueError: No link cartesian or"),
    ("constraints.construct_link_constraint('a', 'b', [0, 0, 0])", "bad optional access"),
    ("constraints.construct_constraints_from_node(None, '')", "TypeError: construct_constraints"),
    ("constraints.construct_joint_constraint(1, 2)", "TypeError: construct_joint_constraint()"),
    ("moveit.core.robot_model.RobotModel('a.urdf', 'a.srdf')", "a.urdf cannot be read as a model"),
    ("moveit.core.planning_interface.MotionPlanResponse()", "TypeError: moveit.core.planning_"),
    ("moveit.planning.MotionPlanner", "moveit.planning has no 'MotionPlanner' in tracerisk's"),
    (
        "parameters = PlanRequestParameters(panda, ''); parameters.speed = 1",
        "has no attribute 'spe",
    ),
    ("manager.push(3)", "TypeError: push(): incompatible function arguments"),
]


def test_each_refusal_says_why(run):
    program = """
import moveit.core.robot_model, moveit.planning
from moveit.core import kinematic_constraints as constraints
from moveit.core.collision_detection import CollisionRequest, CollisionResult
state = RobotState(panda.get_robot_model())
manager = panda.get_trajectory_execution_manager()
request, result = CollisionRequest(), CollisionResult()
scene = copy.copy(monitor.read_only().__enter__())
monitor._lock.release(alone=False)
said = {}
def attempt(statement):
    try:
        exec(statement, globals())
    except Exception as error:
        said[statement] = f"{type(error).__name__}: {error}"
"""
    program += "".join(f"attempt({statement!r})\n" for statement, _ in REFUSED)
    said = run(program)["said"]
    wrong = {
        statement: said.get(statement)
        for statement, words in REFUSED
        if words not in said.get(statement, "")
    }
    assert wrong == {}


def test_an_unknown_named_state_is_refused_with_those_there_are(run):
    ran = run(
        """
goal = arm.set_goal_state(configuration_name="redy")
start = arm.set_start_state(configuration_name="redy")
values = arm.get_named_target_state_values("redy")
names = arm.named_target_states
"""
    )
    assert (ran["goal"], ran["start"], ran["values"]) == (False, False, {})
    assert ran["names"] == ["ready", "extended", "transport"]
    assert "did you mean 'ready'? allowed: extended, ready, transport" in ran.findings[0]


def test_a_node_reads_its_parameters_from_files_and_ends(run, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_text(
        "/**:\n  ros__parameters:\n    plan_request_params: {max_velocity_scaling_factor: 0.2}\n"
    )
    ran = run(
        f"""
from moveit.utils import create_params_file_from_dict, get_launch_params_filepaths
robot = MoveItPy(node_name="planner", name_space="left", launch_params_filepaths=["{file}"],
                 remappings={{"joint_states": "other"}})
speed = PlanRequestParameters(robot, "").max_velocity_scaling_factor
robot.shutdown()
robot.shutdown()
made = create_params_file_from_dict({{"a": {{"b": 1}}}}, "planner")
text = open(made).read()
found = get_launch_params_filepaths(["x", "--ros-args", "--params-file", "p.yaml"])
missing = get_launch_params_filepaths(["--params-file"])
"""
    )
    assert ran["speed"] == 0.2
    assert ran["text"] == "planner:\n  ros__parameters:\n    a:\n      b: 1\n"
    assert ran["found"] == ["p.yaml"]
    assert "Failed to parse params file paths" in ran["missing"][0]


def test_settings_of_the_component_and_the_manager_are_kept(run):
    ran = run(
        """
manager = panda.get_trajectory_execution_manager()
manager.enable_execution_duration_monitoring(False)
manager.set_allowed_execution_duration_scaling(2.0)
manager.set_allowed_goal_duration_margin(3.0)
manager.set_execution_velocity_scaling(0.5)
manager.set_wait_for_trajectory_completion(False)
settings = (manager.execution_duration_monitoring(), manager.allowed_execution_duration_scaling(),
            manager.allowed_goal_duration_margin(), manager.execution_velocity_scaling(),
            manager.wait_for_trajectory_completion())
active = (manager.ensure_active_controllers_for_group("panda_arm"), manager.ensure_active_controllers_for_group("leg"),
          manager.ensure_active_controllers_for_joints(["panda_joint1"]), manager.is_controller_active("arm_controller"))
arm.set_workspace(-1, -1, -1, 1, 1, 1)
arm.unset_workspace()
start = arm.get_start_state().joint_positions["panda_joint4"]
arm.set_start_state("ready")
ready = arm.get_start_state().joint_positions["panda_joint4"]
waited = monitor.wait_for_current_robot_state()
"""
    )
    assert ran["settings"] == (False, 2.0, 3.0, 0.5, False)
    assert ran["active"] == (True, False, True, True)
    assert ran["start"] == pytest.approx(-2.6, abs=0.005)
    assert ran["ready"] == pytest.approx(-2.3562, abs=1e-4)
    assert ran["waited"] is True


_OLDER_CALLS = (
    "panda.execute(path, blocking=True, controllers=[])",
    "panda.execute('panda_arm', path)",
    "panda.execute('panda_arm', path, blocking=True)",
    "panda.execute(path)",
    "panda.execute(path, True)",
)
_PLANNED = """
arm.set_goal_state(configuration_name="ready")
path = arm.plan().trajectory
error = ""
try:
    CALL
except TypeError as raised:
    error = str(raised)
"""


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("call", _OLDER_CALLS)
def test_older_arguments_of_execute_are_refused_in_jazzy(run, call):
    ran = run(_PLANNED.replace("CALL", call), distro="jazzy")
    assert ran["error"].startswith("execute(): incompatible function arguments. The following")
    assert "Invoked with: " in ran["error"]
    assert ran.recording.commands == ()


@pytest.mark.parametrize(
    "call",
    slow_but(_OLDER_CALLS[::2], [*_OLDER_CALLS, "panda.execute(path, controllers=[])"]),
)
def test_arguments_of_execute_of_every_build_are_taken_in_humble(run, call):
    ran = run(_PLANNED.replace("CALL", call), distro="humble")
    assert (ran["error"], ran.findings, len(ran.recording.commands)) == ("", [], 1)
