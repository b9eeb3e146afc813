"""The robot of a controller's own workspace, and the generic arm where there is none."""

import ast
import re
from dataclasses import replace

import pytest

from tests.twin.urdf import test_urdf as texts
from tracerisk import api
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.shipped import hardware_of
from tracerisk.config import Settings
from tracerisk.errors import RobotError
from tracerisk.pipeline.robot.choice import choose_robot
from tracerisk.twin.physics.builder import compile_model
from tracerisk.twin.robots.assumed_names import with_assumed_names
from tracerisk.twin.robots.generic import generic_arm, names_asked
from tracerisk.twin.robots.known_arms import completed_as_ours
from tracerisk.twin.robots.prefix import with_prefix
from tracerisk.twin.robots.robot import load_robot
from tracerisk.twin.robots.robot_parts import Scaling
from tracerisk.twin.urdf.moveit_package import changed_as_beside
from tracerisk.twin.urdf.urdf import read_urdf
from tracerisk.twin.urdf.xacro_files import expand_xacro

CONTROLLER = 'group = "limb"\nstate = "ready"\n'


def workspace(tmp_path, source=CONTROLLER):
    (tmp_path / ".git").mkdir()
    for package in ("moves", "tiny_description"):
        (tmp_path / package).mkdir()
        (tmp_path / package / "package.xml").write_text(
            f"<package><name>{package}</name></package>"
        )
    script = tmp_path / "moves" / "pick.py"
    script.write_text(source)
    return tmp_path / "tiny_description", script


def chosen(script):
    return choose_robot(api.load_controller(script), Settings())


def test_the_robot_beside_the_controller_is_taken_and_reported(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    choice = chosen(script)
    robot = choice.robot
    assert robot.name == "tiny"
    assert [path.name for path in choice.files] == ["tiny.srdf", "tiny.urdf"]
    assert "tiny.srdf with tiny.urdf in the workspace" in robot.chosen_by
    assert "limb" in robot.chosen_by
    assert not robot.assumes_names


def test_plans_take_the_default_scaling_of_the_joint_limits_beside_the_srdf(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    assert chosen(script).robot.default_scaling == Scaling(0.1, 0.1)
    limits = folder / "joint_limits.yaml"
    limits.write_text("default_velocity_scaling_factor: 0.4\njoint_limits: {}\n")
    choice = chosen(script)
    assert choice.robot.default_scaling == Scaling(0.4, 0.1)
    assert limits in choice.files


LIMITS = """\
joint_limits:
  shoulder: {has_velocity_limits: true, max_velocity: 0.7,
             has_acceleration_limits: true, max_acceleration: 3.5}
  elbow: {has_velocity_limits: true, max_velocity: 99, has_acceleration_limits: false,
          max_acceleration: 0}
  third: {max_velocity: 1}
"""


@pytest.mark.parametrize("folder", [".", "config"])
def test_plans_keep_the_limits_of_joints_that_stand_beside_the_srdf(tmp_path, folder):
    top, script = workspace(tmp_path)
    (top / "tiny.urdf").write_text(texts.RATED)
    (top / "srdf").mkdir()
    (top / "srdf" / "tiny.srdf").write_text(texts.SRDF)
    rated = chosen(script).robot
    path = top / ("srdf" if folder == "." else folder) / "joint_limits.yaml"
    path.parent.mkdir(exist_ok=True)
    path.write_text(LIMITS)
    choice = chosen(script)
    shoulder, elbow = choice.robot.joint("shoulder"), choice.robot.joint("elbow")
    assert (shoulder.planned_velocity, shoulder.planned_acceleration) == (0.7, 3.5)
    assert shoulder.velocity_limit == rated.joint("shoulder").velocity_limit, "no plan rates it"
    assert elbow.planned_velocity == rated.joint("elbow").velocity_limit, "not above the rated"
    assert elbow.planned_acceleration == 1.0, "MoveIt's own where there is no limit"
    assert path in choice.files


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "joint_limits:\n  elbow: {max_velocity: fast}\n",
            r"yaml:2:11: joint_limits\.elbow\.max_velocity: expected a number",
        ),
        ("joint_limits:\n  elbow: {max_velocity: -1}\n", r"yaml:2.*outside \[0"),
        ("joint_limits:\n  elbow: {has_velocity_limits: 1}\n", r"yaml:2.*expected true or false"),
        ("joint_limits:\n  elbow: [1]\n", r"yaml:2.*expected a mapping"),
        ("joint_limits: []\n", r"yaml:1.*expected a mapping"),
        (
            "joint_limits:\n  elbow: {has_velocity_limits: true, max_velocity: 0}\n",
            r"yaml:2.*0 is not allowed; give a positive number, or has_velocity_limits: false",
        ),
        ("\t- :\n", r"joint_limits\.yaml:1"),
    ],
)
def test_limits_that_are_none_are_reported_and_not_taken(tmp_path, text, expected):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    srdf = folder / "tiny.srdf"
    srdf.write_text(texts.SRDF)
    rated = chosen(script).robot
    srdf.with_name("joint_limits.yaml").write_text(text)
    choice = chosen(script)
    assert choice.robot == rated
    assert any(re.search(expected, each) for each in choice.skipped), choice.skipped


@pytest.mark.parametrize("text", ["", "joint_limits:\n", "joint_limits: {}\r\n", "# nothing\n"])
def test_a_file_without_limits_changes_nothing(tmp_path, text):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    rated = chosen(script)
    (folder / "joint_limits.yaml").write_text(text)
    assert chosen(script).robot == rated.robot


@pytest.mark.parametrize(
    ("solver", "is_free"),
    [
        ("{position_only_ik: true}", True),
        ("{kinematics_solver: tiny_limb/IKFastKinematicsPlugin}", True),
        ("{kinematics_solver: kdl_kinematics_plugin/KDLKinematicsPlugin}", False),
        ("", False),
    ],
)
def test_groups_whose_solver_is_for_positions_turn_freely(tmp_path, solver, is_free):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    path = folder / "kinematics.yaml"
    path.write_text(f"limb: {solver}\n")
    choice = chosen(script)
    assert choice.robot.group("limb").turns_freely is is_free
    assert (path in choice.files) is is_free


@pytest.mark.parametrize(
    ("name", "content", "begins"),
    [
        ("initial_positions.yaml", "initial_positions:\n  {0}: 0.3\n  elbow: 1.0\n", 0.3),
        ("initial_positions.yaml", "initial_positions:\n  {0}: 99.0\n", "upper"),
        ("fake_controllers.yaml", "initial:\n- group: limb\n  pose: {1}\n", "state"),
        ("fake_controllers.yaml", "initial:\n- group: limb\n  pose: nowhere\n", None),
    ],
)
def test_joints_begin_where_the_simulated_controllers_of_the_workspace_do(
    tmp_path, name, content, begins
):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    before = chosen(script).robot
    joint, states = before.groups["limb"].joints[0], before.named_states["limb"]
    state = next(iter(states))
    path = folder / name
    path.write_text(content.format(joint, state))
    choice = chosen(script)
    wanted = {
        "upper": before.joint(joint).upper,
        "state": states[state].get(joint),
        None: before.initial_state[joint],
    }.get(begins, begins)
    assert choice.robot.initial_state[joint] == wanted


@pytest.mark.parametrize(("value", "begins"), [("0.25", 0.25), ("inf", 0.0), ("x", 0.0)])
def test_joints_begin_where_the_hardware_of_ros2_control_does(value, begins):
    plain = texts.robot()
    joint = plain.joints[0].name
    hardware = f"""<ros2_control name="h" type="system"><joint name="{joint}">
      <state_interface name="position"><param name="initial_value">{value}</param>
      </state_interface><state_interface name="velocity"><param name="initial_value">9</param>
      </state_interface></joint></ros2_control></robot>"""
    made = read_urdf(texts.RATED.replace("</robot>", hardware), "tiny.urdf")
    assert made.initial_state[joint] == begins


def test_a_file_of_solvers_that_is_none_is_reported_and_not_taken(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    (folder / "tiny.srdf").write_text(texts.SRDF)
    (folder / "kinematics.yaml").write_text("\t- :\n")
    choice = chosen(script)
    assert not choice.robot.group("limb").turns_freely
    assert any("kinematics.yaml:1" in each for each in choice.skipped), choice.skipped


def test_an_arm_is_completed_as_the_shipped_one_whose_lengths_come_nearest():
    for name in ("ur3", "ur3e", "ur5", "ur5e", "ur10", "ur10e"):
        known = load_robot(name)
        plain = replace(
            known,
            name="cell",
            joints=tuple(replace(joint, acceleration_limit=0.5) for joint in known.joints),
        )
        assert [joint.acceleration_limit for joint in completed_as_ours(plain).joints] == [
            joint.acceleration_limit for joint in known.joints
        ]
        turned = completed_as_ours(with_prefix(plain, "left_"))
        assert turned.joints[0].name == "left_shoulder_pan_joint"
        assert turned.joints[0].acceleration_limit == known.joints[0].acceleration_limit


def test_a_scaling_factor_that_is_none_is_reported_and_not_taken(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "tiny.urdf").write_text(texts.RATED)
    srdf = folder / "tiny.srdf"
    srdf.write_text(texts.SRDF)
    (folder / "joint_limits.yaml").write_text("a: 1\ndefault_velocity_scaling_factor: 0.0\n")
    with pytest.raises(RobotError, match="above 0, at most 1") as caught:
        changed_as_beside(texts.robot(), srdf, "joint_limits.yaml", shown="tiny/tiny.srdf")
    assert str(caught.value.location).startswith("tiny/joint_limits.yaml:2")
    assert chosen(script).robot.default_scaling == Scaling(0.1, 0.1)


def test_of_two_robots_the_one_that_the_controller_names_is_taken(tmp_path):
    folder, script = workspace(tmp_path, 'group = "other_limb"\n')
    (folder / "a.urdf").write_text(texts.RATED)
    (folder / "a.srdf").write_text(texts.SRDF)
    (folder / "b.urdf").write_text(texts.RATED.replace('"tiny"', '"other"'))
    (folder / "b.srdf").write_text(
        texts.SRDF.replace('"tiny"', '"other"').replace('"limb"', '"other_limb"')
    )
    assert chosen(script).robot.name == "other"


def _two_robots_of_one_group(folder):
    """Two robots of which a controller of `limb` names as much; the second has a state more."""
    for name, state in (("a", "ready"), ("b", "aside")):
        srdf = texts.SRDF.replace('"tiny"', f'"{name}"')
        (folder / f"{name}.urdf").write_text(texts.RATED.replace('"tiny"', f'"{name}"'))
        (folder / f"{name}.srdf").write_text(
            re.sub(r'(<group_state name=)"ready"', rf'\1"{state}"', srdf)
        )


def test_of_two_robots_of_one_group_the_one_whose_state_is_named_is_taken(tmp_path):
    folder, script = workspace(tmp_path, 'group = "limb"\nstate = "aside"\n')
    _two_robots_of_one_group(folder)
    assert chosen(script).robot.name == "b"


def test_of_two_robots_the_one_by_whose_part_of_a_name_the_controller_asks_is_taken(tmp_path):
    source = 'import rospy, variants\ngroup = "limb"\nif version() == "b2":\n    pass\n'
    folder, script = workspace(tmp_path, source)
    for name in ("tiny_a", "tiny_b2"):
        (folder / f"{name}.urdf").write_text(texts.RATED.replace('"tiny"', f'"{name}"'))
        for copied in (name, f"{name}_copy"):
            (folder / f"{copied}.srdf").write_text(texts.SRDF.replace('"tiny"', f'"{name}"'))
    # A library of its own speaks of every variant, and a launch file describes the other one.
    (script.parent / "launch").mkdir()
    (script.parent / "launch" / "demo.launch").write_text(
        '<launch><param name="robot_description" textfile="$(find tiny_description)/tiny_a.urdf"/>'
        "</launch>"
    )
    (script.parent / "variants.py").write_text('variants = ["a", "b2"]\n')
    assert chosen(script).robot.name == "tiny_b2"


def test_of_two_robots_the_one_of_a_launch_file_beside_the_controller_is_taken(tmp_path):
    folder, script = workspace(tmp_path, 'import rospy\ngroup = "limb"\n')
    _two_robots_of_one_group(folder)
    launch = folder / "launch"
    launch.mkdir()
    (launch / "planning_context.launch").write_text(
        '<launch><param name="robot_description" textfile="$(find tiny_description)/b.urdf"/>'
        '<param name="robot_description_semantic" textfile="$(find tiny_description)/b.srdf"/>'
        "</launch>"
    )
    (launch / "other.launch").write_text(
        '<launch><param name="robot_description" textfile="$(find tiny_description)/a.urdf"/>'
        '<param name="robot_description_semantic" textfile="$(find tiny_description)/a.srdf"/>'
        "</launch>"
    )
    (script.parent / "launch").mkdir()
    (script.parent / "launch" / "demo.launch").write_text(
        '<launch><include file="$(find tiny_description)/launch/planning_context.launch"/></launch>'
    )
    assert chosen(script).robot.name == "b"


@pytest.mark.parametrize("has_groups", [True, False])
def test_the_only_robot_is_not_that_of_another_packages_tests(tmp_path, has_groups):
    folder, script = workspace(tmp_path, "pass\n")
    (folder / "test").mkdir()
    (folder / "test" / "tiny.urdf").write_text(texts.RATED)
    if has_groups:
        (folder / "test" / "tiny.srdf").write_text(texts.SRDF)
    assert chosen(script).robot.name == "generic"
    # A script of these tests drives it, and so does one that names it.
    (folder / "test" / "pick.py").write_text("pass\n")
    assert chosen(folder / "test" / "pick.py").robot.name == "tiny"
    script.write_text('joint = "shoulder"\n')
    assert chosen(script).robot.name == "tiny"


def test_xacro_finds_the_packages_of_the_workspace(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "parts.xacro").write_text(texts.RATED)
    (folder / "tiny.urdf.xacro").write_text(
        '<robot name="tiny" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="$(find tiny_description)/parts.xacro"/></robot>'
    )
    text = expand_xacro(folder / "tiny.urdf.xacro", {"tiny_description": folder})
    assert b'name="shoulder"' in text
    (folder / "tiny.srdf").write_text(texts.SRDF)
    read = ["tiny.srdf", "tiny.urdf.xacro", "parts.xacro"]
    assert [path.name for path in chosen(script).files] == read
    (folder / "parts.xacro").rename(folder / "parts.txt")
    assert "tiny.urdf.xacro: xacro cannot expand it" in chosen(script).robot.chosen_by


def test_a_broken_file_of_the_only_robot_is_reported_with_its_reason(tmp_path):
    folder, script = workspace(tmp_path)
    (folder / "tiny.srdf").write_text("<robot")
    robot = chosen(script).robot
    assert robot.name == "generic"
    assert "cannot be read (tiny.srdf: is not XML" in robot.chosen_by
    assert "or name the robot with --robot" in robot.chosen_by
    generic = choose_robot(api.load_controller(script), Settings(robot="generic"))
    assert generic.robot.name == "generic"


PREFIXED = """\
<robot name="crane" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="side" default="left"/>
  <xacro:property name="side" value="$(arg side)"/>
  <link name="base"/>
  <xacro:macro name="segment" params="number parent">
    <link name="crane_${side}_link${number}"/>
    <joint name="crane_${side}_joint${number}" type="revolute">
      <parent link="${parent}"/><child link="crane_${side}_link${number}"/>
      <origin xyz="0 0 0.3"/><axis xyz="0 1 0"/>
      <limit lower="-2" upper="2" effort="50" velocity="2"/>
    </joint>
  </xacro:macro>
  <xacro:segment number="1" parent="base"/>
  <xacro:segment number="2" parent="crane_${side}_link1"/>
  <xacro:segment number="3" parent="crane_${side}_link2"/>
</robot>
"""
NEEDS = "<package><name>moves</name><exec_depend>tiny_description</exec_depend></package>"


def joints_of(side):
    return [f"crane_{side}_joint{number}" for number in (1, 2, 3)]


def crane(tmp_path, source):
    """A workspace whose macros build the names of the robot's joints, and a decoy beside it."""
    folder, script = workspace(tmp_path, source)
    (folder / "crane.urdf.xacro").write_text(PREFIXED)
    other = tmp_path / "other_description"
    other.mkdir()
    (other / "package.xml").write_text("<package><name>other_description</name></package>")
    (other / "other.urdf").write_text(texts.RATED.replace('"tiny"', '"other"'))
    return folder, script


@pytest.mark.parametrize(
    "source",
    [
        f"joint_names = {joints_of('left')}\n",
        'names = [f"crane_left_joint{i}" for i in range(1, 4)]\n',
    ],
)
def test_joints_are_those_of_the_expanded_xacro_of_a_package_that_is_needed(tmp_path, source):
    _, script = crane(tmp_path, source)
    script.with_name("package.xml").write_text(NEEDS)
    choice = chosen(script)
    assert [joint.name for joint in choice.robot.arm_joints] == joints_of("left")
    assert choice.robot.name == "crane"
    assert "crane.urdf.xacro in the workspace (names crane_left_joint1" in choice.robot.chosen_by


def test_a_launch_file_names_the_package_and_the_arguments_of_its_xacro(tmp_path):
    _, script = crane(tmp_path, f"joint_names = {joints_of('right')}\n")
    (script.parent / "launch").mkdir()
    (script.parent / "launch" / "cell.launch").write_text(
        '<launch><param name="robot_description" command="$(find xacro)/xacro '
        '$(find tiny_description)/crane.urdf.xacro side:=right"/></launch>\n'
    )
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == joints_of("right")


def test_an_expanded_robot_whose_joints_are_not_named_is_not_taken(tmp_path):
    _, script = crane(tmp_path, 'joint_names = ["hip", "knee", "ankle"]\n')
    script.with_name("package.xml").write_text(NEEDS)
    assert chosen(script).robot.name == "generic"


def test_of_two_copies_of_a_package_the_nearest_is_taken(tmp_path):
    folder, script = crane(tmp_path, f"joint_names = {joints_of('left')}\n")
    script.with_name("package.xml").write_text(NEEDS)
    near = script.parent.parent / "near"
    for place in (near, near / "sub"):
        place.mkdir()
    script = script.rename(near / "sub" / "pick.py")
    (near / "sub" / "package.xml").write_text(NEEDS)
    copy = near / "tiny_description"
    copy.mkdir()
    (copy / "package.xml").write_text((folder / "package.xml").read_text())
    (copy / "crane.urdf.xacro").write_text(PREFIXED.replace('effort="50"', 'effort="70"'))
    robot = chosen(script).robot
    assert {joint.torque_limit for joint in robot.arm_joints} == {70.0}


def test_a_xacro_that_is_needed_and_cannot_be_expanded_is_openly_replaced(tmp_path):
    folder, script = crane(tmp_path, f"joint_names = {joints_of('left')}\n")
    script.with_name("package.xml").write_text(NEEDS)
    (folder / "crane.urdf.xacro").write_text(PREFIXED.replace('number="1"', 'nummer="1"'))
    robot = chosen(script).robot
    assert "crane.urdf.xacro: xacro cannot expand it" in robot.chosen_by
    assert [joint.name for joint in robot.arm_joints] == joints_of("left")


def test_a_named_state_in_a_sentence_says_nothing_about_the_robot(tmp_path):
    folder, script = workspace(
        tmp_path, 'group = MoveGroupCommander("limb")\nprint("ready to start")\n'
    )
    own, other = script.parent, folder
    (own / "small.urdf").write_text(texts.RATED.replace('name="tiny"', 'name="small"'))
    srdf = texts.SRDF.replace('name="tiny"', 'name="small"')
    (own / "small.srdf").write_text(srdf.replace('name="ready"', 'name="rest"'))
    (other / "tiny.urdf").write_text(texts.RATED)
    (other / "tiny.srdf").write_text(texts.SRDF)
    assert chosen(script).robot.name == "small", "the nearer one"
    script.write_text(script.read_text() + 'group.set_named_target("ready")\n')
    assert chosen(script).robot.name == "tiny"


def test_a_robot_without_groups_of_its_own_assumes_those_asked_for(tmp_path):
    folder, script = workspace(tmp_path, 'joints = ["shoulder", "elbow"]\n')
    (folder / "tiny.urdf").write_text(texts.RATED)
    robot = chosen(script).robot
    assert (robot.name, robot.assumes_names, robot.approximate) == ("tiny", True, True)


def test_an_unknown_robot_is_the_generic_arm_with_the_joints_named(tmp_path):
    _, script = workspace(tmp_path, 'joint_names = ["hip", "knee", "ankle"]\n')
    robot = chosen(script).robot
    assert [joint.name for joint in robot.arm_joints] == ["hip", "knee", "ankle"]
    assert robot.approximate
    assert "--robot" in robot.chosen_by
    compile_model(robot)


@pytest.mark.parametrize(
    ("program", "count"),
    [
        ("arm.go([0.1] + rest)", 6),
        ("arm.go([0.0, -0.5, 0.0, -1.0, 0.0, 1.5, 0.0], wait=True)\nhand.go([0.04, 0.04])", 7),
        ("point = JointTrajectoryPoint(positions=[0.1, 0.2, 0.3, 0.4])", 4),
        ("point.positions = (0.1, 0.2, 0.3, 0.4, 0.5)", 5),
        ("goal = arm.get_current_joint_values()\ngoal[7] = 0\narm.go(goal)", 8),
        ("goal = arm.get_current_joint_values()\ngoal[0] = 0\narm.go(goal)", 6),
        ("names = ['a_joint', 'b_joint', 'c_joint']\narm.go([0.1, 0.2, 0.3, 0.4])", 3),
        ("arm.go([0.0] * 7)", 7),
        ("point.positions = 5 * [0.0]", 5),
        ("arm.go([math.radians(10), -a, 2 * b, angles[3]])", 4),
        ("positions = ['home', 'up', 'pick']", 6),
        ("positions = [[0.1] * 6, [0.2] * 6, [0.3] * 6]", 6),
        ("positions = [Pose(), Pose(), Pose()]", 6),
    ],
)
def test_the_generic_arm_has_as_many_joints_as_the_program_gives_positions_of(program, count):
    assert len(generic_arm(names_asked(ast.parse(program))).arm_joints) == count


def test_the_generic_arm_says_each_name_that_it_assumes_once():
    reported = []
    robot = with_assumed_names(generic_arm(names_asked(None)), reported.append)
    assert robot.group("manipulator").joints == robot.groups["arm"].joints
    assert robot.group("left_hand").joints == robot.groups["gripper"].joints
    first = dict(robot.named_states["manipulator"]["over_the_table"])
    assert first == dict(robot.named_states["manipulator"]["over_the_table"])
    assert first != dict(robot.named_states["manipulator"]["behind"])
    assert len(reported) == 4
    assert "over_the_table" in reported[2]


def test_a_robot_of_a_file_says_that_an_srdf_would_name_its_groups():
    reported = []
    tiny = texts.robot()
    parts = {name: group for name, group in tiny.groups.items() if name != "all"}
    tiny = replace(tiny, assumes_names=True, groups=parts)
    known = with_assumed_names(tiny, reported.append)
    assert dict(known.named_states["left_arm"]["ready"]) == dict(tiny.named_states["limb"]["ready"])
    assert reported == [
        "unknown planning group 'left_arm'; using group limb of tiny; an SRDF beside its file would define it"
    ]


def test_a_robot_that_is_known_assumes_no_name():
    tiny = texts.robot()
    assert with_assumed_names(tiny, lambda _: None) is tiny
    with pytest.raises(RobotError, match="no planning group 'lim'; did you mean 'limb'"):
        tiny.group("lim")


def test_generic_hardware_fits_a_robot_with_and_without_a_gripper():
    tiny = texts.robot()
    names = [bound.component.name for bound in bind(hardware_of("tiny"), tiny.elements)]
    assert "gripper" in names
    bare = [element for element in tiny.elements if element.kind == "joint"]
    bound = bind(hardware_of("tiny"), bare)
    assert [one.component.name for one in bound if one.elements] == ["electric_motor"]
    assert bound[-1].quantity == 2


def test_a_controller_of_an_unknown_robot_runs(tmp_path):
    _, script = workspace(
        tmp_path,
        "import moveit_commander\n\n"
        "def reach(group):\n"
        '    group.set_named_target("up_there")\n'
        "    group.go(wait=True)\n\n"
        'reach(moveit_commander.MoveGroupCommander("some_arm"))\n',
    )
    controller = api.load_controller(script)
    trace = api.trace_controller(controller, Settings())
    assert [function.ref.name for function in trace.functions] == ["reach"]
    messages = [finding.message for finding in trace.findings]
    assert any("unknown planning group 'some_arm'" in message for message in messages)
    assert any("'up_there'" in message for message in messages)
    assert any("approximate" in line for line in trace.assumptions)
    assert any("hardware: all figures are assumed" in line for line in trace.assumptions)


@pytest.mark.parametrize(("stretch", "is_ours"), [(1.0, True), (2.0, False)])
def test_joints_of_common_names_make_no_robot_one_of_ours(stretch, is_ours):
    xarm = load_robot("xarm6")
    assert {joint.name for joint in xarm.arm_joints} == {f"joint{i}" for i in range(1, 7)}
    other = replace(
        xarm,
        attachments=tuple(
            replace(each, xyz=tuple(stretch * x for x in each.xyz)) for each in xarm.attachments
        ),
        joints=tuple(replace(joint, torque_limit=1.0) for joint in xarm.joints),
        approximate=True,
    )
    kept = [joint.torque_limit == 1.0 for joint in completed_as_ours(other).arm_joints]
    assert kept == [not is_ours] * 6


UR_SRDF = """\
<robot name="{name}">
  <group name="lifter">
    <joint name="shoulder_pan_joint"/><joint name="shoulder_lift_joint"/><joint name="elbow_joint"/>
    <joint name="wrist_1_joint"/><joint name="wrist_2_joint"/><joint name="wrist_3_joint"/>
  </group>
</robot>
"""


def test_of_known_robots_with_the_joints_of_an_srdf_the_one_that_it_names_gives_the_arm(tmp_path):
    folder, script = workspace(tmp_path, 'group = "lifter"\n')
    (folder / "cell.srdf").write_text(UR_SRDF.format(name="ur5_robot"))
    choice = chosen(script)
    assert choice.robot.name == "ur5"
    assert "lifter" in choice.robot.groups


def test_an_srdf_that_fits_several_known_robots_and_names_none_is_an_open_assumption(tmp_path):
    folder, script = workspace(tmp_path, 'group = "lifter"\n')
    (folder / "cell.srdf").write_text(UR_SRDF.format(name="cell"))
    robot = chosen(script).robot
    assert robot.name == "ur5e"
    assert "lifter" in robot.groups
    assert robot.doubt.startswith("cell.srdf has the joints of ur10, ur10e, ur16e, ur20, ur3, ur30")
