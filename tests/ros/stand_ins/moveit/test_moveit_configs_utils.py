"""The parameters that MoveItConfigsBuilder and ParameterBuilder gather from a package."""

import pytest

URDF = '<robot name="panda" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="tool" default="hand"/><link name="$(arg tool)"/></robot>'


@pytest.fixture
def package(tmp_path):
    config = tmp_path / "panda_moveit_config" / "config"
    config.mkdir(parents=True)
    (config / "panda.urdf.xacro").write_text(URDF)
    (config / "panda.srdf").write_text("<robot name='panda'/>")
    (config / "kinematics.yaml").write_text("panda_arm: {kinematics_solver_timeout: 0.05}\n")
    (config / "joint_limits.yaml").write_text("default_velocity_scaling_factor: 0.1\n")
    (config / "moveit_controllers.yaml").write_text(
        "controller_names: [old]\ncontroller_names: [arm]\n"
    )
    (config / "other_controllers.yaml").write_text("{}\n")
    (config / "moveit_cpp.yaml").write_text(
        "plan_request_params: {planning_pipeline: ompl, max_velocity_scaling_factor: 0.25}\n"
    )
    (config / "pilz_cartesian_limits.yaml").write_text("cartesian_limits: {max_trans_vel: 1.0}\n")
    return config.parent


def test_a_package_is_gathered_and_its_parameters_are_the_nodes(run, package):
    ran = run(
        """
from moveit_configs_utils import MoveItConfigsBuilder
configs = (
    MoveItConfigsBuilder(robot_name="panda", package_name="panda_moveit_config")
    .robot_description(mappings={"tool": "gripper"})
    .trajectory_execution(file_path="config/moveit_controllers.yaml")
    .planning_pipelines(pipelines=["ompl"])
    .moveit_cpp(file_path="config/moveit_cpp.yaml")
    .to_moveit_configs()
)
values = configs.to_dict()
robot = MoveItPy(node_name="planner", config_dict=values)
speed = PlanRequestParameters(robot, "").max_velocity_scaling_factor
""",
        {"panda_moveit_config": package},
    )
    values = ran["values"]
    assert 'link name="gripper"' in values["robot_description"]
    assert values["robot_description_semantic"] == "<robot name='panda'/>"
    assert values["robot_description_kinematics"]["panda_arm"]["kinematics_solver_timeout"] == 0.05
    assert values["robot_description_planning"] == {"default_velocity_scaling_factor": 0.1}
    assert values["controller_names"] == ["arm"]
    assert values["moveit_manage_controllers"] is True
    assert values["ompl"] == {"planning_plugins": ["ompl_interface/OMPLPlanner"]}
    assert ran["configs"].package_path == package
    assert ran["speed"] == 0.25
    assert ran.findings == []


def test_usual_files_are_taken_and_pilz_adds_its_limits(run, package):
    ran = run(
        """
from moveit_configs_utils import MoveItConfigsBuilder
values = MoveItConfigsBuilder("panda").moveit_cpp().parameter("mine", 3).to_dict()
alone = MoveItConfigsBuilder("panda").yaml("config/kinematics.yaml", "ik").to_dict(include_moveit_configs=False)
""",
        {"panda_moveit_config": package},
    )
    values = ran["values"]
    assert values["mine"] == 3
    assert values["controller_names"] == ["arm"]
    assert values["robot_description_planning"]["cartesian_limits"] == {"max_trans_vel": 1.0}
    assert values["default_planning_pipeline"] == "ompl"
    assert values["publish_planning_scene"] is True
    assert ran["alone"] == {"ik": {"panda_arm": {"kinematics_solver_timeout": 0.05}}}


def test_a_package_that_is_not_there_is_a_finding_and_the_run_goes_on(run):
    ran = run(
        """
from moveit_configs_utils import MoveItConfigsBuilder
configs = MoveItConfigsBuilder("panda", package_name="moveit_resources_panda_moveit_config")
values = configs.robot_description("config/panda.urdf.xacro").to_moveit_configs().to_dict()
robot = MoveItPy(node_name="planner", config_dict=values)
arm = robot.get_planning_component("panda_arm")
arm.set_goal_state("ready")
status = robot.execute(arm.plan().trajectory, [])
"""
    )
    assert bool(ran["status"])
    (finding,) = ran.findings
    assert "package 'moveit_resources_panda_moveit_config' is not in the workspace" in finding
    assert "robot_description" not in ran["values"]


def test_what_cannot_be_gathered_is_refused(run, package):
    (package / "config" / "broken.yaml").write_text("- 1\n")
    (package / "config" / "moveit_controllers.yaml").rename(
        package / "config" / "a_controllers.yaml"
    )
    ran = run(
        """
from moveit_configs_utils import MoveItConfigsBuilder
said = []
for attempt in (
    lambda one: one.joint_limits("config/none.yaml"),
    lambda one: one.joint_limits("config/broken.yaml"),
    lambda one: one.trajectory_execution(),
    lambda one: one.planning_pipelines("lin", ["ompl"]),
    lambda one: one.planning_pipelines("lin", ["lin"]),
):
    try:
        attempt(MoveItConfigsBuilder("panda"))
    except Exception as error:
        said.append(f"{type(error).__name__}: {error}")
""",
        {"panda_moveit_config": package},
    )
    missing, broken, several, default, unknown = ran["said"]
    assert missing.startswith("ParameterBuilderFileNotFoundError: File ")
    assert "holds no mapping" in broken
    assert "Unable to guess which parameter file to load" in several
    assert "`lin` doesn't name any of the input pipelines `ompl`" in default
    assert "planning pipeline 'lin' has no file" in unknown


def test_a_xacro_file_that_cannot_be_expanded_is_a_finding(run, package):
    (package / "config" / "panda.urdf.xacro").write_text(
        URDF.replace("</robot>", "<xacro:none/></robot>")
    )
    ran = run(
        """
from moveit_configs_utils import MoveItConfigsBuilder
configs = MoveItConfigsBuilder("panda").robot_description().to_moveit_configs()
""",
        {"panda_moveit_config": package},
    )
    assert ran["configs"].robot_description == {}
    assert "panda.urdf.xacro cannot be expanded" in ran.findings[0]


@pytest.mark.slow
def test_parameters_of_a_package_are_gathered_file_by_file(run, package):
    ran = run(
        """
from launch_param_builder import ParameterBuilder, load_xacro, load_yaml
values = (
    ParameterBuilder("panda_moveit_config")
    .yaml("config/kinematics.yaml", parameter_namespace="ik")
    .yaml("config/joint_limits.yaml")
    .xacro_parameter("robot_description", "config/panda.urdf.xacro", {"tool": "gripper"})
    .file_parameter("semantic", "config/panda.srdf")
    .parameter("rate", 10)
    .to_dict()
)
from ament_index_python.packages import get_package_share_directory
share = get_package_share_directory("panda_moveit_config")
limits = load_yaml(share + "/config/joint_limits.yaml")
text = load_xacro(share + "/config/panda.urdf.xacro", mappings={"tool": "claw"})
try:
    ParameterBuilder("panda_moveit_config").yaml("config/none.yaml")
except FileNotFoundError as error:
    said = str(error)
absent = ParameterBuilder("another_package").yaml("config/none.yaml").to_dict()
both = ParameterBuilder("panda_moveit_config")
for name in ("kinematics", "joint_limits"):
    both.yaml(f"config/{name}.yaml", "planning")
both = both.to_dict()
""",
        {"panda_moveit_config": package},
    )
    values = ran["values"]
    assert values["ik"]["panda_arm"]["kinematics_solver_timeout"] == 0.05
    assert values["default_velocity_scaling_factor"] == 0.1
    assert 'link name="gripper"' in values["robot_description"]
    assert values["semantic"] == "<robot name='panda'/>"
    assert values["rate"] == 10
    assert ran["limits"] == {"default_velocity_scaling_factor": 0.1}
    assert 'link name="claw"' in ran["text"]
    assert "config/none.yaml doesn't exist" in ran["said"]
    assert ran["absent"] == {}
    assert {*ran["both"]["planning"]} == {"panda_arm", "default_velocity_scaling_factor"}
    (finding,) = ran.findings
    assert "package 'another_package' is not in the workspace" in finding
