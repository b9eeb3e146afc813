"""What a client can set and ask, and what it is refused."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tracerisk.twin.robots.robot import load_robot

ARM = [f"panda_joint{number}" for number in range(1, 8)]
READY = [0.0, -math.pi / 4, 0.0, -3 * math.pi / 4, 0.0, math.pi / 2, math.pi / 4]


def refused(run, call: str, kind: str = "MoveItCommanderException") -> str:
    """Return the text of the error that a call raises."""
    ran = run(
        f"""
        robot = moveit_commander.RobotCommander()
        arm, hand = MoveGroupCommander("panda_arm"), MoveGroupCommander("hand")
        text = None
        try:
            {call}
        except {kind} as error:
            text = str(error)
        """
    )
    assert ran["text"] is not None
    return ran["text"]


def test_an_unknown_group_lists_the_groups(run):
    text = refused(run, "MoveGroupCommander('arm')", "RuntimeError")
    assert text.startswith("Group 'arm' was not found.")
    assert "hand, panda_arm, panda_arm_hand" in text


REFUSED = [
    ("arm.set_named_target('redy')", "Unable to set target redy. Is the target within bounds?"),
    ("arm.set_named_target('redy')", "did you mean 'ready'? allowed: extended, ready"),
    ("arm.go([9.0] * 7)", "9 for joint 'panda_joint1' is outside [-2.8973, 2.8973] (degrees?)"),
    ("arm.go([0.0] * 6)", "6 values given, group 'panda_arm' has 7 joints"),
    ("arm.set_joint_value_target({'elbow': 0})", "joint 'elbow' is not part of group"),
    ("arm.set_joint_value_target('panda_joint1')", "Joint value expected when joint name"),
    ("arm.set_joint_value_target([0] * 7, 3)", "Too many arguments specified"),
    ("arm.set_joint_value_target(3)", "Unsupported argument of type <class 'int'>"),
    ("arm.set_max_velocity_scaling_factor(1.5)", "Expected value in the range from 0 to 1"),
    ("arm.set_max_acceleration_scaling_factor(0)", "Expected value in the range from 0 to 1"),
    ("arm.limit_max_cartesian_link_speed(0)", "Expected speed value to be greater than 0"),
    ("arm.set_workspace([1, 2])", "Expected 0, 4 or 6 values"),
    ("arm.set_rpy_target([1, 2])", "Expected [roll, pitch, yaw]"),
    ("arm.set_orientation_target([1, 2, 3])", "Expected [qx, qy, qz, qw]"),
    ("arm.set_pose_target([1, 2])", "expected to consist of either 6 or 7 values"),
    ("arm.shift_pose_target(6, 1)", "An axis value between 0 and 5 expected"),
    ("arm.set_path_constraints('up')", "Unable to set path constraints up"),
    ("arm.set_end_effector_link('tool')", "Unable to set end effector link 'tool'"),
    ("hand.set_pose_target([0] * 6)", "There is no end effector to set the pose for"),
    ("hand.get_current_pose()", "There is no end effector to get the pose of"),
    ("arm.get_current_pose('tool')", "There is no link 'tool'"),
    ("robot.get_group('arm')", "There is no group named arm"),
    ("robot.get_joint('elbow')", "There is no joint named elbow"),
    ("robot.get_link('tool')", "There is no link named tool"),
    ("robot.get_joint_names('arm')", "There is no group named arm"),
    ("arm.place('cup', 3)", "Parameter location must be a Pose"),
    ("moveit_commander.conversions.list_to_pose([1])", "Expected either 6 or 7 elements"),
]


REFUSALS = """\
robot = moveit_commander.RobotCommander()
arm, hand = MoveGroupCommander("panda_arm"), MoveGroupCommander("hand")

def outcome_of(call):
    try:
        call()
    except MoveItCommanderException as error:
        return str(error)
"""


@pytest.fixture(scope="module")
def texts(outcomes_of):
    """The text of what each call raises, all in one run."""
    return outcomes_of(REFUSALS, [call for call, _ in REFUSED])


@pytest.mark.parametrize(("call", "text"), REFUSED)
def test_what_is_refused_and_how_it_is_reported(texts, call, text):
    assert text in texts[call]


def test_an_unknown_part_of_the_robot_names_what_there_is(run):
    text = refused(run, "robot.panda_arn", "AttributeError")
    assert "no attribute 'panda_arn'" in text
    assert "did you mean 'panda_arm'?" in text


def test_a_target_that_is_refused_is_taken_over_all_the_same(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        try:
            arm.set_joint_value_target([9.0] * 7)
        except MoveItCommanderException:
            pass
        target = arm.get_joint_value_target()
        success, _, _, error = arm.plan()
        """
    )
    assert ran["target"] == [9.0] * 7
    assert (ran["success"], ran["error"].val) == (False, -16)


@pytest.mark.parametrize(
    "target",
    [
        "[0.1, -0.7, 0, -2.3, 0, 1.5, 0.7]",
        "(0.1, -0.7, 0, -2.3, 0, 1.5, 0.7)",
        "dict(zip(arm.get_joints(), [0.1, -0.7, 0, -2.3, 0, 1.5, 0.7]))",
        "sensor_msgs.msg.JointState(name=arm.get_active_joints(), position=[0.1, -0.7, 0, -2.3, 0, 1.5, 0.7])",
    ],
)
def test_joint_targets_come_in_many_forms(run, target):
    ran = run(
        f"""
        arm = MoveGroupCommander("panda_arm")
        arm.set_joint_value_target({target})
        target = arm.get_joint_value_target()
        points = arm.plan({target})[1].joint_trajectory.points
        """
    )
    assert ran["target"] == [0.1, -0.7, 0.0, -2.3, 0.0, 1.5, 0.7]
    assert ran["points"][-1].positions == pytest.approx(ran["target"])


def test_one_joint_can_be_set_among_the_others(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        arm.set_named_target("ready")
        arm.set_joint_value_target("panda_joint1", 0.5)
        target = arm.get_joint_value_target()
        """
    )
    assert ran["target"] == pytest.approx([0.5, *READY[1:]])


def test_joint_positions_can_be_looked_for_by_pose(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        arm.set_named_target("ready")
        arm.set_max_velocity_scaling_factor(1.0)
        arm.go()
        pose = arm.get_current_pose()
        pose.pose.position.z -= 0.1
        arm.set_joint_value_target(pose, True)
        arm.set_joint_value_target(pose.pose, "panda_link8")
        done = arm.go()
        height = arm.get_current_pose().pose.position.z
        """
    )
    assert ran["done"] is True
    assert ran["height"] == pytest.approx(ran["pose"].pose.position.z, abs=0.002)


def test_joint_positions_for_a_pose_out_of_reach_are_refused_and_reported(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        pose = geometry_msgs.msg.Pose()
        pose.position.x = 5.0
        try:
            arm.set_joint_value_target(pose)
        except MoveItCommanderException as error:
            text = str(error)
        """
    )
    assert "Error setting joint target. Is the IK solver functional?" in ran["text"]
    assert "inverse kinematics of group 'panda_arm' failed" in ran.findings[0]


def test_named_and_remembered_targets(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        names = arm.get_named_targets()
        ready = arm.get_named_target_values("ready")
        unknown = arm.get_named_target_values("nope")
        arm.remember_joint_values("mine", [0.1] * 3 + [-1.0] + [0.1] * 3)
        with_mine = arm.get_named_targets()
        arm.set_named_target("mine")
        target = arm.get_joint_value_target()
        plan = arm.plan("mine")
        remembered = arm.get_remembered_joint_values()
        arm.forget_joint_values("mine")
        after = arm.get_remembered_joint_values()
        """
    )
    assert {"ready", "extended", "transport"} <= set(ran["names"])
    assert list(ran["ready"].values()) == pytest.approx(READY)
    assert ran["unknown"] == {}
    assert ran["with_mine"][0] == "mine"
    assert ran["target"] == [0.1] * 3 + [-1.0] + [0.1] * 3
    assert ran["plan"][0] is True
    assert ran["remembered"] == {"mine": [0.1] * 3 + [-1.0] + [0.1] * 3}
    assert ran["after"] == {}


def test_after_clearing_there_is_no_goal(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        arm.set_pose_target([0.4, 0.0, 0.4, math.pi, 0.0, 0.0])
        arm.clear_pose_targets()
        done = arm.go()
        """
    )
    assert ran["done"] is False
    assert "no goal is set" in ran.findings[0]


def test_the_first_of_several_poses_that_can_be_reached_is_taken(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        arm.set_pose_targets([[4.0, 0, 0, 0, 0, 0], [0.4, 0.0, 0.4, math.pi, 0.0, 0.0]])
        success = arm.plan()[0]
        """
    )
    assert ran["success"] is True
    assert ran.findings == []


def test_an_unknown_frame_is_a_failure_that_lists_the_links(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        arm.set_pose_reference_frame("table")
        arm.set_pose_target([0.4, 0.0, 0.4, 0, 0, 0])
        success, _, _, error = arm.plan()
        """
    )
    assert (ran["success"], ran["error"].val) == (False, -21)
    assert "unknown frame 'table'; allowed: panda_hand" in ran.findings[0]


@pytest.mark.parametrize("frame", ["base_link", "/base_link", "base_footprint", "base"])
def test_the_base_of_another_description_is_the_base_of_a_shipped_robot(run, frame):
    ran = run(
        f"""
        arm = MoveGroupCommander("panda_arm")
        arm.set_pose_reference_frame("{frame}")
        arm.set_pose_target([0.4, 0.0, 0.4, math.pi, 0, 0])
        success = arm.go()
        """
    )
    assert ran["success"] is True
    assert [finding.kind for finding in ran.recording.findings] == ["one_robot"]
    assert "is taken for the base of robot 'panda'" in ran.findings[0]


def test_an_object_stands_in_the_base_of_another_description(run):
    ran = run(
        """
        scene = moveit_commander.PlanningSceneInterface(synchronous=True)
        box = geometry_msgs.msg.PoseStamped()
        box.header.frame_id, box.pose.position.x, box.pose.orientation.w = "base_link", 0.7, 1.0
        scene.add_box("box", box, (0.1, 0.1, 0.1))
        found = scene.get_object_poses(["box"])["box"].position.x
        """
    )
    assert ran["found"] == 0.7
    assert [finding.kind for finding in ran.recording.findings] == ["one_robot"]


@pytest.mark.parametrize("file", ["config/panda.urdf", "robots/mine.yaml"])
def test_the_description_of_the_author_has_its_base_by_its_own_name_alone(file):
    shipped = load_robot("panda")
    assert shipped.is_described is False
    assert replace(shipped, file=file).is_described is True


def test_a_zero_quaternion_is_no_turn(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        pose = geometry_msgs.msg.Pose()
        pose.position.x, pose.position.z = 0.4, 0.6
        arm.set_pose_target(pose)
        orientation = arm.construct_motion_plan_request().goal_constraints[0].orientation_constraints
        """
    )
    assert ran["orientation"][0].orientation.w == 1.0


def test_names_and_frames(run):
    ran = run(
        """
        robot = moveit_commander.RobotCommander()
        arm, hand = MoveGroupCommander("panda_arm"), MoveGroupCommander("hand")
        """
    )
    arm, hand, robot = ran["arm"], ran["hand"], ran["robot"]
    assert (arm.get_name(), arm.get_planning_frame()) == ("panda_arm", "panda_link0")
    assert (arm.get_end_effector_link(), hand.get_end_effector_link()) == ("panda_link8", "")
    assert (arm.has_end_effector_link(), hand.has_end_effector_link()) == (True, False)
    assert (arm.get_active_joints(), arm.get_joints()) == (ARM, [*ARM, "panda_joint8"])
    assert (arm.get_variable_count(), hand.get_variable_count()) == (7, 2)
    assert robot.get_group_names() == sorted(robot.get_group_names())
    assert robot.get_link_names("panda_arm") == [f"panda_link{n}" for n in range(1, 9)]
    assert robot.get_link_names("hand") == ["panda_leftfinger", "panda_rightfinger"]
    assert (robot.get_planning_frame(), robot.get_root_link()) == ("panda_link0", "panda_link0")
    assert (robot.has_group("hand"), robot.has_group("arm")) == (True, False)
    assert robot.get_default_owner_group("panda_finger_joint1") == "hand"
    assert "panda_joint8" in robot.get_joint_names()
    assert "panda_joint8" not in robot.get_active_joint_names()


def test_parts_of_the_robot_are_attributes(run):
    ran = run(
        """
        robot = moveit_commander.RobotCommander()
        group = robot.panda_arm
        same = robot.get_group("panda_arm")
        bounds = robot.panda_joint4.bounds()
        value = robot.panda_joint4.value()
        pose = robot.panda_link8.pose()
        """
    )
    assert ran["group"] is ran["same"]
    assert ran["bounds"] == [-3.0718, -0.0698]
    assert ran["value"] == pytest.approx(-2.6, abs=0.01)
    assert ran["pose"].header.frame_id == "panda_link0"


def test_settings_are_given_back(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        defaults = arm.get_goal_tolerance(), arm.get_planning_time()
        arm.set_goal_tolerance(0.01)
        arm.set_goal_orientation_tolerance(0.02)
        arm.set_planning_time(7.5)
        arm.set_planning_time(-1.0)
        arm.set_planner_id("RRTConnect")
        arm.set_planning_pipeline_id("ompl")
        arm.allow_replanning(True)
        arm.set_num_planning_attempts(4)
        arm.set_workspace([-1, -2, 1, 2])
        arm.set_max_velocity_scaling_factor(0.3)
        arm.set_named_target("ready")
        request = arm.construct_motion_plan_request()
        """
    )
    arm, request = ran["arm"], ran["request"]
    assert ran["defaults"] == ((1e-4, 1e-4, 1e-3), 5.0)
    assert arm.get_goal_tolerance() == (0.01, 0.01, 0.02)
    assert (arm.get_goal_joint_tolerance(), arm.get_goal_position_tolerance()) == (0.01, 0.01)
    assert arm.get_goal_orientation_tolerance() == 0.02
    assert (arm.get_planning_time(), arm.get_planner_id()) == (7.5, "RRTConnect")
    assert arm.get_planning_pipeline_id() == "ompl"
    assert request.group_name == "panda_arm"
    assert (request.num_planning_attempts, request.max_velocity_scaling_factor) == (4, 0.3)
    corner = request.workspace_parameters.min_corner
    assert (corner.x, corner.y, corner.z) == (-1, -2, 0.0)
    joints = request.goal_constraints[0].joint_constraints
    assert [joint.joint_name for joint in joints] == ARM
    assert [joint.position for joint in joints] == pytest.approx(READY)
    assert request.start_state.is_diff is True


def test_the_state_is_reported_as_a_message(run):
    ran = run(
        """
        robot = moveit_commander.RobotCommander()
        arm = MoveGroupCommander("panda_arm")
        state = robot.get_current_state()
        out = copy.deepcopy(state)
        out.joint_state.position[0] = 9.0
        bounded = arm.enforce_bounds(out)
        """
    )
    state = ran["state"].joint_state
    assert state.name[:7] == ARM
    assert len(state.position) == 9
    assert state.header.frame_id == "panda_link0"
    assert ran["bounded"].joint_state.position[0] == 2.8973


def test_the_jacobian_predicts_small_motions(run):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        values = list(arm.get_named_target_values("ready").values())
        jacobian = arm.get_jacobian_matrix(values)
        shifted = arm.get_jacobian_matrix(values, [0.0, 0.0, 0.1])
        """
    )
    assert ran["jacobian"].shape == (6, 7)
    # The first joint turns about z: the tip, 0.307 m out along x, moves along y.
    assert ran["jacobian"][:, 0] == pytest.approx([0, 0.30689, 0, 0, 0, 1], abs=1e-4)
    # The last joint turns about the tip's own axis, so a point on it stays where it is.
    assert np.abs(ran["shifted"][:3, 6]).max() < 1e-6


def test_random_values_lie_within_the_limits_and_depend_on_the_seed_alone(run, panda):
    ran = run(
        """
        arm = MoveGroupCommander("panda_arm")
        draws = [arm.get_random_joint_values() for _ in range(50)]
        pose = arm.get_random_pose()
        """
    )
    for name, values in zip(ARM, zip(*ran["draws"], strict=True), strict=True):
        joint = panda.joint(name)
        assert all(joint.lower <= value <= joint.upper for value in values)
        assert len(set(values)) == 50
    generator = np.random.default_rng(0)
    limits = [(panda.joint(name).lower, panda.joint(name).upper) for name in ARM]
    drawn = [[generator.uniform(*each) for each in limits] for _ in range(50)]
    # Those in collision are passed over.
    assert any(ran["draws"][0] == pytest.approx(each) for each in drawn)


def test_conversions_there_and_back(run):
    ran = run(
        """
        from moveit_commander.conversions import *
        values = [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8]
        pose = pose_to_list(list_to_pose(values))
        transform = transform_to_list(list_to_transform(values))
        turned = pose_to_list(list_to_pose([0, 0, 0, 0, 0, math.pi / 2]))
        stamped = list_to_pose_stamped(values, "base")
        copied = geometry_msgs.msg.Pose()
        msg_from_string(copied, msg_to_string(stamped.pose))
        """
    )
    assert ran["pose"] == ran["transform"] == ran["values"]
    assert ran["turned"][3:] == pytest.approx([0, 0, math.sqrt(0.5), math.sqrt(0.5)])
    assert ran["stamped"].header.frame_id == "base"
    assert ran["copied"] == ran["stamped"].pose


def test_the_librarys_start_and_end(run):
    ran = run(
        """
        moveit_commander.roscpp_initialize(sys.argv)
        moveit_commander.roscpp_shutdown()
        exit = moveit_commander.os._exit
        text = ""
        try:
            moveit_commander.roscpp_initialize([3])
        except TypeError as error:
            text = str(error)
        """
    )
    assert "list of strings" in ran["text"]


def test_a_finger_of_a_generic_arm_goes_to_the_end_of_its_assumed_range(example):
    example.write(
        "c.py",
        "import rospy, moveit_commander\n"
        "rospy.init_node('c')\n"
        "hand = moveit_commander.MoveGroupCommander('rhand')\n"
        "hand.go([1.0], wait=True)\n",
    )
    ran = example.run("trace", "c.py", "--json")
    verdict = ran.json["verdict"]
    assert verdict["kind"] == "partial", ran.err
    assert any("instead of 1: its range is assumed" in said["words"] for said in verdict["reasons"])


@pytest.mark.parametrize(
    "place",
    [[3.4, -0.4, 0.6, 0.0, 0.6, -3.15], [2.7, -1.57, 1.46, 1.22, 1.64, -3.15]],
    ids=["beyond half a turn", "folded"],
)
def test_a_generic_arm_goes_where_the_lists_of_the_program_say(example, place):
    """Those of Universal Robots turn a whole turn; what is assumed is no fault of a program."""
    example.write(
        "c.py",
        "import rospy, moveit_commander\n"
        "rospy.init_node('c')\n"
        f"moveit_commander.MoveGroupCommander('manipulator').go({place}, wait=True)\n",
    )
    ran = example.run("trace", "c.py", "--json")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    assert {said["code"] for said in ran.json["verdict"]["reasons"]} == {"robot-assumed"}


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("value", ["nan", "inf"])
def test_a_finger_of_a_generic_arm_goes_to_no_end_for_what_is_no_number(example, value):
    example.write(
        "c.py",
        "import rospy, moveit_commander\n"
        "rospy.init_node('c')\n"
        "hand = moveit_commander.MoveGroupCommander('rhand')\n"
        f"hand.set_joint_value_target([float('{value}')])\n",
    )
    ran = example.run("trace", "c.py", "--json")
    assert ran.json["verdict"]["kind"] == "faulted", ran.err
    assert f"{value} for joint 'gripper_finger_joint' is outside" in ran.err
