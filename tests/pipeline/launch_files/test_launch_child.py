"""ROS 2 launch files, read in their process: what they start and give (docs.ros.org, launch)."""

import os
import subprocess
import sys
import tempfile
from dataclasses import replace

import pytest

from tests.slow import slow_but
from tracerisk.common.limits import DEFAULT_LIMITS, Limit
from tracerisk.errors import LimitError
from tracerisk.pipeline.launch_files import child, process
from tracerisk.pipeline.launch_files.process import read_launch
from tracerisk.pipeline.workspace.project import Project

IMPORTS = """\
from launch import LaunchDescription
from launch.actions import *
from launch.conditions import IfCondition, UnlessCondition
from launch.event_handlers import OnProcessExit
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import *
from launch_ros.actions import *
from launch_ros.parameter_descriptions import ParameterFile, ParameterValue
from launch_ros.substitutions import FindPackageShare

def pick(**given):
    return Node(package="arm_task", executable="pick", **given)

"""


IN_ITS_PROCESS = {
    "test_values_have_the_types_that_launch_ros_gives_them",
    "test_a_file_that_does_more_than_describe_is_a_problem",
    "test_a_file_may_write_a_temporary_file_and_print",
    "test_a_file_that_includes_itself_comes_to_an_end",
    "test_memory_has_a_limit",
    "test_the_release_is_reported_whatever_the_host_has_sourced",
}
"""Tests of what surrounds the reading, and one of what is read; for the others it is forked."""


def forked(_module, *, request, folder, environment, **_):
    """Read as the process does, in a fork of this one, which has imported everything."""
    with tempfile.TemporaryFile() as given, tempfile.TemporaryFile() as out:
        given.write(request)
        given.seek(0)
        number = os.fork()
        if number == 0:
            code = 1
            try:
                os.chdir(folder)
                os.environ.update(environment)
                for source, descriptor in ((given, 0), (out, 1), (out, 2)):
                    os.dup2(source.fileno(), descriptor)
                sys.stdin, sys.stdout = os.fdopen(0), os.fdopen(1, "w")
                sys.stderr = open(os.devnull, "w")  # noqa: PTH123, SIM115
                code = child.main()
                sys.stdout.flush()
            finally:
                os._exit(code)
        _, status = os.waitpid(number, 0)
        out.seek(0)
        return subprocess.CompletedProcess([], status, out.read(), b"")


@pytest.fixture
def read(workspace, request, monkeypatch):
    if request.node.originalname not in IN_ITS_PROCESS:
        monkeypatch.setattr(process, "run_limited", forked)

    def read_file(name, text):
        path = workspace.write(f"launch/{name}", text)
        return read_launch(path, Project(workspace.package).workspace())

    return read_file


@pytest.fixture
def described(read):
    """Read the description that holds the given entities."""

    def read_entities(entities, before=""):
        body = f"{IMPORTS}{before}\ndef generate_launch_description():\n"
        return read("arm.launch.py", f"{body}    return LaunchDescription([{entities}])\n")

    return read_entities


def values(node):
    return {each.name: each.value for each in node.parameters}


def test_values_have_the_types_that_launch_ros_gives_them(described):
    (node,) = described(
        "DeclareLaunchArgument('speed', default_value='0.5'), DeclareLaunchArgument('n', default_value='7'),"
        "pick(parameters=[{'speed': LaunchConfiguration('speed'), 'text': '0.5', 'flag': True,"
        " 'list': [1, 2.5], 'joined': ['a', LaunchConfiguration('n')], 'names': ['1', 'b'],"
        " 'as_text': ParameterValue(LaunchConfiguration('n'), value_type=str),"
        " 'as_float': ParameterValue(LaunchConfiguration('n'), value_type=float),"
        " 'arm': {'joint': {'limit': 2}}}])"
    ).nodes
    assert values(node) == {
        "speed": 0.5,
        "text": "0.5",
        "flag": True,
        "list": [1.0, 2.5],
        "joined": "a7",
        "names": ["1", "b"],
        "as_text": "7",
        "as_float": 7.0,
        "arm.joint.limit": 2,
    }


def test_files_name_the_nodes_whose_parameters_they_hold(described, workspace):
    workspace.write(
        "config/a.yaml",
        "pick:\n  ros__parameters: {speed: 1.5, arm: {joints: [a, b]}}\n"
        "/**:\n  ros__parameters: {all: $(var n)}\n",
    )
    reading = described(
        "DeclareLaunchArgument('n', default_value='7'),"
        "pick(name='pick', parameters=[ParameterFile(PathJoinSubstitution("
        "[FindPackageShare('arm_task'), 'config', 'a.yaml']), allow_substs=True)])"
    )
    (node,) = reading.nodes
    found = {(each.node, each.name): each.value for each in node.parameters}
    assert found == {
        ("/pick", "speed"): 1.5,
        ("/pick", "arm.joints"): ["a", "b"],
        ("/**", "all"): 7,
    }
    assert [path.name for path in reading.sources] == ["arm.launch.py", "a.yaml"]


def test_names_remaps_arguments_and_environment(described):
    (node,) = described(
        "SetEnvironmentVariable('SIDE', 'left'), SetRemap('a', 'b'), SetParameter('all', 1),"
        "pick(name='p', namespace='arm', remappings=[('c', 'd')], arguments=['--n', '2'],"
        " ros_arguments=['--log-level', 'warn'], additional_env={'N': '1'}, output='screen')"
    ).nodes
    assert (node.name, node.namespace) == ("p", "/arm")
    assert node.remaps == (("a", "b"), ("c", "d"))
    assert node.arguments == ("--n", "2")
    assert node.ros_arguments == ("--log-level", "warn")
    assert node.environment == (("N", "1"), ("SIDE", "left"))
    assert values(node) == {"all": 1}


def test_scopes_end_with_their_groups(described):
    inner, outer = described(
        "GroupAction([PushRosNamespace('left'), SetLaunchConfiguration('n', '1'),"
        " SetParameter('p', 1), pick(namespace='arm')]),"
        "pick(arguments=[LaunchConfiguration('n', default='none')])"
    ).nodes
    assert inner.namespace == "/left/arm"
    assert values(inner) == {"p": 1}
    assert outer.namespace == ""
    assert outer.arguments == ("none",)
    assert values(outer) == {}


def test_conditions_timers_functions_and_events(described):
    reading = described(
        "DeclareLaunchArgument('sim', default_value='true'),"
        "pick(name='a', condition=IfCondition(LaunchConfiguration('sim'))),"
        "pick(name='no', condition=UnlessCondition(LaunchConfiguration('sim'))),"
        "pick(name='b', condition=IfCondition(PythonExpression(['\"', LaunchConfiguration('sim'),"
        ' \'" == "true"\']))),'
        "TimerAction(period=5.0, actions=[pick(name='c')]), OpaqueFunction(function=made),"
        "first, RegisterEventHandler(OnProcessExit(target_action=first, on_exit=[pick(name='e')])),"
        "RegisterEventHandler(OnProcessExit(target_action=never, on_exit=[pick(name='no')]))",
        before="first, never = pick(name='first'), pick(name='never')\n"
        "def made(context, *args):\n"
        "    return [pick(name='d', arguments=[LaunchConfiguration('sim').perform(context)])]\n",
    )
    assert [node.name for node in reading.nodes] == ["a", "b", "c", "d", "first", "e"]
    assert reading.nodes[3].arguments == ("true",)
    assert reading.problems == ()


def test_included_files_of_every_kind_get_their_arguments(described, workspace):
    workspace.write(
        "launch/in.launch.xml",
        '<launch><arg name="n" default="0"/><node pkg="arm_task" exec="pick" name="x$(var n)"/>'
        "</launch>",
    )
    workspace.write(
        "launch/in.launch.yaml",
        "launch:\n- arg: {name: n, default: '0'}\n"
        "- node: {pkg: arm_task, exec: pick, name: y$(var n), param: [{name: p, value: 2}]}\n",
    )
    reading = described(
        "*[IncludeLaunchDescription(PythonLaunchDescriptionSource([ThisLaunchFileDir(),"
        " '/in.launch.' + kind]), launch_arguments={'n': '3'}.items()) for kind in ('xml', 'yaml')]"
    )
    assert [node.name for node in reading.nodes] == ["x3", "y3"]
    assert values(reading.nodes[1]) == {"p": 2}


def test_xml_has_all_that_python_has(read):
    reading = read(
        "arm.launch.xml",
        """\
<launch>
  <arg name="speed" default="0.5"/>
  <let name="side" value="left_$(var speed)"/>
  <group if="$(equals $(var speed) 0.50)">
    <push-ros-namespace namespace="ns"/>
    <set_remap from="a" to="b"/>
    <node pkg="arm_task" exec="pick" name="pick" args="--side $(var side)" ros_args="--log-level warn">
      <param name="speed" value="$(var speed)"/>
      <param name="text" value="$(var speed)" type="str"/>
      <param name="joints" value="a, b" value-sep=","/>
      <param name="arm"><param name="n" value="$(eval '1 + 1')"/></param>
      <remap from="c" to="d"/>
      <env name="SIDE" value="left"/>
    </node>
  </group>
  <node pkg="arm_task" exec="pick" name="no" unless="$(not false)"/>
  <executable cmd="ros2 run arm_task pick --n 1"/>
  <bad/>
</launch>
""",
    )
    node, command = reading.nodes
    assert node.namespace == "/ns"
    assert node.arguments == ("--side", "left_0.5")
    assert node.ros_arguments == ("--log-level", "warn")
    assert values(node) == {"speed": 0.5, "text": "0.5", "joints": ["a", "b"], "arm.n": 2}
    assert node.remaps == (("a", "b"), ("c", "d"))
    assert node.environment == (("SIDE", "left"),)
    assert command.command == ("ros2", "run", "arm_task", "pick", "--n", "1")
    assert any("<bad> is not read" in each for each in reading.problems)


MOVEIT = """
from ament_index_python.packages import get_package_share_directory
from moveit_configs_utils import MoveItConfigsBuilder
from moveit_configs_utils.launches import generate_demo_launch
moveit = (
    MoveItConfigsBuilder("panda", package_name={package!r})
    .robot_description(mappings={{"side": LaunchConfiguration("side")}})
    .planning_pipelines(pipelines=["ompl"])
    .moveit_cpp(file_path=get_package_share_directory({package!r}) + "/config/moveit_cpp.yaml")
    .to_moveit_configs()
)
rviz = str(moveit.package_path / "config/moveit.rviz")
"""


def test_the_parameters_of_moveit_come_from_its_package(described, workspace):
    config = workspace.package / "config"
    workspace.write(
        "config/moveit_cpp.yaml", "ompl_rrtc: {plan_request_params: {planning_attempts: 2}}"
    )
    workspace.write("config/panda.urdf.xacro", "<robot name='panda'/>")
    workspace.write("config/panda.srdf", "<robot name='panda'/>")
    workspace.write("config/joint_limits.yaml", "default_velocity_scaling_factor: 0.3")
    for name in ("kinematics", "moveit_controllers"):
        workspace.write(f"config/{name}.yaml", "{}")
    reading = described(
        "pick(parameters=[moveit.to_dict()])", before=MOVEIT.format(package="arm_task")
    )
    (node,) = reading.nodes
    found = values(node)
    assert found["ompl_rrtc.plan_request_params.planning_attempts"] == 2
    assert found["robot_description_planning.default_velocity_scaling_factor"] == 0.3
    assert found["robot_description_semantic"] == "<robot name='panda'/>"
    assert found["ompl.planning_plugins"] == ["ompl_interface/OMPLPlanner"]
    assert dict(node.left_out) == {"robot_description": "the output of xacro is not here"}
    assert {config / "moveit_cpp.yaml", config / "joint_limits.yaml"} <= set(reading.sources)


def test_a_parameter_builder_reads_the_files_of_a_package(described, workspace):
    workspace.write("config/servo.yaml", "scale: {linear: 0.2}")
    reading = described(
        "pick(parameters=[{'moveit_servo': servo}, absent, {'speed': 1}])",
        before="""
from launch_param_builder import ParameterBuilder
servo = ParameterBuilder("arm_task").yaml("config/servo.yaml").to_dict()
absent = ParameterBuilder("not_here").yaml("config/servo.yaml").to_dict()
""",
    )
    (node,) = reading.nodes
    assert values(node) == {"moveit_servo.scale.linear": 0.2, "speed": 1}
    assert set(dict(node.left_out).values()) == {"package 'not_here' is not here"}
    assert workspace.package / "config/servo.yaml" in reading.sources


def test_moveit_without_its_package_leaves_only_itself_out(described):
    (node,) = described(
        "pick(parameters=[moveit.to_dict(), {'speed': 1}])",
        before=MOVEIT.format(package="not_here"),
    ).nodes
    found = values(node)
    assert (found["speed"], found["default_planning_pipeline"]) == (1, "ompl")
    assert set(dict(node.left_out).values()) == {"package 'not_here' is not here"}


def test_classes_of_libraries_that_are_not_here_can_be_derived_from(described):
    (node,) = described(
        "arguments.add_to(1), pick(parameters=[{'speed': 1, 'side': arguments.side}])",
        before="from dataclasses import dataclass\n"
        "from launch_pal.arg_utils import LaunchArgumentsBase, TiagoArgs\n"
        "@dataclass(frozen=True)\n"
        "class Arguments(LaunchArgumentsBase):\n"
        "    side: object = TiagoArgs.side\n"
        "arguments = Arguments()\n",
    ).nodes
    assert values(node) == {"speed": 1}
    assert dict(node.left_out) == {"side": "launch_pal.arg_utils.TiagoArgs is not here"}


def test_a_package_is_found_without_a_context_too(described, workspace):
    (node,) = described(
        "pick(arguments=[FindPackageShare('arm_task').find('arm_task') + '/config'])"
    ).nodes
    assert node.arguments == (f"{workspace.package}/config",)


def test_names_are_found_where_the_library_has_them(described):
    reading = described(
        "pick(name=PathJoinSubstitution(['a']))",
        before="from launch import LaunchIntrospector, LaunchService\n"
        "from launch.actions.timer_action import TimerAction\n"
        "from launch.event_handler import EventHandler\n"
        "from launch.events.process import ProcessExited\n"
        "from launch.launch_context import LaunchContext\n"
        "from launch.launch_description_entity import LaunchDescriptionEntity\n"
        "from launch.some_substitutions_type import SomeSubstitutionsType\n"
        "from launch.substitutions.path_join_substitution import PathJoinSubstitution\n"
        "from launch.utilities import perform_substitutions\n"
        "from launch_ros.actions.node import Node as RosNode\n"
        "from launch_ros.events.lifecycle import ChangeState\n"
        "from launch_ros.event_handlers import OnStateTransition\n"
        "from launch_ros.descriptions import ComposableNode\n"
        "from launch_xml.launch_description_sources import XMLLaunchDescriptionSource\n"
        "import launch, launch_ros\n"
        "assert launch.actions.TimerAction is TimerAction and RosNode is Node\n"
        "LaunchService().include_launch_description(LaunchDescription([]))\n",
    )
    assert reading.problems == ()
    assert [node.name for node in reading.nodes] == ["a"]


def test_what_is_not_here_leaves_only_itself_out(described):
    (node, other) = described(
        "pick(parameters=[moveit.to_dict(), {'robot_description': Command(['xacro ', 'a.xacro']),"
        " 'speed': 1, 'share': FindPackageShare('not_here')}]),"
        "pick(arguments=[FindPackageShare('not_here')]), pick(name='other')",
        before="from arm_configs import ConfigsBuilder\n"
        "moveit = ConfigsBuilder('panda').planning_pipelines().to_moveit_configs()\n",
    ).nodes
    assert values(node) == {"speed": 1}
    assert dict(node.left_out) == {
        "*": "arm_configs.ConfigsBuilder is not here",
        "robot_description": "the output of xacro is not here",
        "share": "package 'not_here' is not here",
    }
    assert other.name == "other"


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        # As the next one.
        pytest.param(
            "import launch.nothing_such",
            "No module named 'launch.nothing_such'",
            marks=pytest.mark.slow,
        ),
        ("from launch.actions import Teleport", "Teleport"),
        ("open('/etc/hostname', 'a')", "may not write /etc/hostname"),
        # Refused where the others are.
        pytest.param(
            "import os; os.system('true')", "may not do os.system", marks=pytest.mark.slow
        ),
        pytest.param(
            "import subprocess; subprocess.run(['true'])",
            "may not do subprocess.Popen",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "import os; os.remove('/tmp/no_such_file_at_all')",
            "may not do os.remove",
            marks=pytest.mark.slow,
        ),
        ("import socket; socket.create_connection(('127.0.0.1', 9))", "may not do socket.connect"),
        pytest.param("raise KeyError('x')", "KeyError", marks=pytest.mark.slow),
        ("raise SystemExit(3)", "3"),
    ],
)
def test_a_file_that_does_more_than_describe_is_a_problem(described, line, expected):
    reading = described("pick()", before=line)
    assert reading.nodes == ()
    assert any(expected in each for each in reading.problems), reading.problems


def test_a_file_may_write_a_temporary_file_and_print(described):
    before = (
        "import tempfile\nwith tempfile.NamedTemporaryFile('w', suffix='.yaml', delete=False) as f:\n"
        "    f.write('/**: {ros__parameters: {speed: 1}}')\nprint('hello')\n"
    )
    (node,) = described("pick(parameters=[f.name])", before=before).nodes
    assert values(node) == {"speed": 1}


def test_an_argument_without_a_default_is_reported(described):
    reading = described(
        "DeclareLaunchArgument('arm'), pick(arguments=[LaunchConfiguration('arm')]),"
        "DeclareLaunchArgument('m', default_value='x', choices=['a', 'b'])"
    )
    assert reading.nodes == ()
    problems = "\n".join(reading.problems)
    assert "Required launch argument 'arm' was not provided" in problems
    assert "launch configuration 'arm' does not exist" in problems
    assert "argument 'm' is 'x'; its choices: a, b" in problems


def test_a_file_that_includes_itself_comes_to_an_end(described):
    reading = described("IncludeLaunchDescription(ThisLaunchFile())")
    assert any("includes itself" in each for each in reading.problems)


def test_memory_has_a_limit(read):
    with pytest.raises(LimitError, match=r"big\.launch\.py: .* more than 2048 MB of memory"):
        read("big.launch.py", "x = bytearray(3 * 1024**3)\ndef generate_launch_description(): 1\n")


# One that computes, `test_under_load.py` shows too.
@pytest.mark.parametrize(
    "body",
    slow_but(
        ["import time; time.sleep(1000)"], ["while True: pass", "import time; time.sleep(1000)"]
    ),
)
def test_a_file_that_does_not_end_is_no_file_that_starts_nothing(body, workspace):
    path = workspace.write("launch/endless.launch.py", f"{body}\n")
    limits = replace(DEFAULT_LIMITS, own=Limit("stall_limit_s", 0.3))
    with pytest.raises(LimitError, match=r"endless\.launch\.py: reading .* --stall-limit"):
        read_launch(path, Project(workspace.package).workspace(), limits)


def test_the_release_is_reported_whatever_the_host_has_sourced(described, monkeypatch):
    monkeypatch.setenv("ROS_DISTRO", "foxy")
    reading = described("pick(name=os.environ['ROS_DISTRO'])", before="import os\n")
    assert [node.name for node in reading.nodes] == ["jazzy"]
