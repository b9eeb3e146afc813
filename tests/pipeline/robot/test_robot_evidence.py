"""What speaks for a robot has points, and the one for which most speaks is taken."""

from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.robot.choice import RobotChoice, choose_robot
from tracerisk.pipeline.robot.evidence import Evidence, is_decided, ranked, shown
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

UR = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
    "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]  # fmt: skip
PANDA = [f"panda_joint{number}" for number in range(1, 8)]
SIX = [f"joint{number}" for number in range(1, 7)]


def written(top: Path, files: dict[str, str]) -> Path:
    """Write a project, and return the first of its files: the controller."""
    (top / ".git").mkdir(parents=True)
    for name, text in files.items():
        path = top / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return top / next(iter(files))


def chosen(top: Path, **files: str) -> RobotChoice:
    named = {name.replace("__", "/").replace("_DOT_", "."): text for name, text in files.items()}
    return choose_robot(api.load_controller(written(top, named)), Settings())


def of_source(top: Path, source: str) -> RobotChoice:
    return chosen(top, go_DOT_py=source)


def points(robot: str, value: float) -> Evidence:
    return Evidence(robot, "it speaks", "a.py", 1, value)


def test_the_sum_decides_and_ties_and_little_evidence_are_told_apart():
    assert ranked([points("a", 30), points("b", 20), points("b", 20)]).best == "b"
    assert ranked([points("a", 30), points("a", -40), points("b", 25)]).best == "b"
    tie = ranked([points("a", 40), points("b", 40)], preferred=["b"])
    assert (tie.best, tie.rivals, tie.is_sure) == ("b", ("a",), False)
    weak = ranked([points("a", 10)])
    assert (weak.best, weak.is_sure) == ("a", False)
    assert ranked([points("a", 10), points("b", 10)]).best == ""
    assert ranked([points("a", 1)]).best == ""
    assert ranked([]).best == ""


def test_a_clear_lead_needs_no_weaker_evidence():
    assert is_decided([points("a", 60), points("b", 30)])
    assert not is_decided([points("a", 60), points("b", 31)])
    assert not is_decided([points("a", 19)])
    assert not is_decided([])


def test_what_is_shown_says_where_it_is_and_leaves_out_robots_of_which_nothing_is_said():
    found = shown([points("a", 30), points("b", -50), points("a", -5)])
    assert [str(one) for one in found] == [
        "+30.0 for a: it speaks (a.py:1)",
        "-5.0 for a: it speaks (a.py:1)",
    ]


@pytest.mark.parametrize(
    "source",
    [
        'names = ["panda_arm", "hand"]\n',
        'name = "panda_joint1"\n',
        'topic = "/panda_arm_controller/follow_joint_trajectory"\n',
        'stem = "panda_joint"\n',
        'text = "moving panda_link8 up"\n',
        'arm = "franka"\n',
        'parts = ["panda_", "joint1", "joint2", "joint3"]\n',
    ],
)
def test_the_panda_is_known_by_its_names(tmp_path, source):
    choice = of_source(tmp_path, source)
    assert (choice.robot.name, choice.robot.doubt) == ("panda", "")


@pytest.mark.parametrize(
    "source",
    [
        "pass\n",
        'names = ["gripper", "hand"]\n',
        'names = ["joint", "expanda_arms"]\n',
        'names = ["base", "manipulator", "tool0"]\n',
        'names = ["right_arm", "left_arm"]\n',
        'name = "elbow_joint"\n',
        'names = ["fetch the cup", "fetch"]\n',
        f"joints = {SIX}\n",
        'joints = ["arm_lift", "arm_turn"]\nname = "ur10e"\n',
    ],
)
def test_names_that_any_robot_could_have_say_none(tmp_path, source):
    choice = of_source(tmp_path, source)
    assert choice.robot.name == "generic"
    assert "name it with --robot" in choice.robot.chosen_by


@pytest.mark.parametrize("name", ["ur5e", "package://ur5e/meshes", "my-UR5e", "UR 5e"])
def test_an_exact_name_decides_between_arms_of_the_same_joints(tmp_path, name):
    choice = of_source(tmp_path, f"JOINTS = {UR}\nname = {name!r}\n")
    assert (choice.robot.name, choice.robot.doubt) == ("ur5e", "")
    assert "ur5e is named in its source (go.py)" in choice.robot.chosen_by


@pytest.mark.parametrize(
    ("name", "among"),
    [("", {"ur3", "ur5e", "ur20"}), ("ur5x sur5", {"ur3"}), ("ur3 or ur5", {"ur3", "ur5"})],
)
def test_arms_for_which_as_much_speaks_are_an_open_assumption(tmp_path, name, among):
    choice = of_source(tmp_path, f"JOINTS = {UR}\nname = {name!r}\n")
    assert "would fit as well; name it with --robot" in choice.robot.doubt
    rivals = choice.robot.doubt.partition(" would")[0].split(", ")
    assert among <= {choice.robot.name, *rivals}


@pytest.mark.parametrize(
    "named",
    [
        'rospy.init_node("ur5_joint_motion_node")',
        'rospy.init_node(name="ur5_joint_motion_node")',
        'node = rclpy.create_node("ur5_joint_motion_node")',
        "class Mover(Node):\n    def __init__(self):\n"
        '        super().__init__("ur5_joint_motion_node")',
    ],
    ids=["init_node", "by keyword", "create_node", "a class"],
)
def test_the_name_of_a_node_is_no_joint_that_arms_lack(tmp_path, named):
    source = f"from utils import JOINTS\n{named}\n"
    choice = chosen(tmp_path, go_DOT_py=source, utils_DOT_py=f"JOINTS = {UR}\n")
    assert choice.robot.name == "ur5"
    assert not choice.robot.doubt


def test_what_lies_about_decides_where_as_much_speaks_for_two(tmp_path):
    source = f'JOINTS = {UR}\nname = "ur3 or ur5"\n'
    choice = chosen(tmp_path, go_DOT_py=source, README_DOT_md="for the UR5\n")
    assert choice.robot.name == "ur5"


def test_joints_speak_louder_than_a_name(tmp_path):
    assert of_source(tmp_path, 'names = ["panda_joint1", "ur5e"]\n').robot.name == "panda"


def test_the_robot_without_further_joints_is_meant_by_a_whole_list(tmp_path):
    listed = 'joints = ["waist", "shoulder", "elbow", "wrist_angle"]\n'
    assert of_source(tmp_path / "a", listed).robot.name == "px100"
    assert of_source(tmp_path / "b", f'{listed}name = "wx250s"\n').robot.name == "wx250s"


def test_numbered_joints_need_a_name(tmp_path):
    own = of_source(tmp_path / "a", f'joints = {SIX}\nname = "xArm6"\n').robot
    assert (own.name, own.doubt) == ("xarm6", "")
    said = chosen(tmp_path / "b", go_DOT_py=f"joints = {SIX}\n", README_DOT_md="the xArm 6\n").robot
    assert said.name == "xarm6"
    assert "all that speaks for it is that " in said.doubt


def test_a_robot_of_which_only_the_name_is_named_assumes_the_groups_it_lacks(tmp_path):
    robot = of_source(tmp_path / "a", 'group = "manipulator"\nname = "UR10e"\n').robot
    assert robot.name == "ur10e"
    bare = of_source(tmp_path / "b", "import baxter_interface\n").robot
    assert (bare.name, bare.assumes_names) == ("baxter", True)
    assert not of_source(
        tmp_path / "c", 'names = ["panda_joint1", "panda_arm"]\n'
    ).robot.assumes_names


@pytest.mark.parametrize(
    ("calls", "is_assumed"),
    [
        ('arm.set_named_target("pickup_one")\narm.set_named_target("pickup_two")\n', True),
        ('arm.set_goal_state("pick")\narm.set_start_state(configuration_name="place")\n', True),
        ('arm.set_named_target("ready")\narm.set_named_target("pickup_two")\n', False),
        ('arm.set_named_target("raedy")\n', False),
        ('arm.set_named_target("up")\narm.set_named_target("down")\nhand.set_named_target("open")\n', True),
        ('arm.set_named_target("up")\nhand.set_named_target("open")\n', False),
        ('arm.remember_joint_values("a")\narm.set_named_target("a")\narm.set_named_target("b")\n', False),
        ('arm.set_goal_state("pick", pose_link="place")\n', False),
    ],
)  # fmt: skip
def test_states_of_which_a_robot_has_none_are_those_of_another_configuration(
    tmp_path, calls, is_assumed
):
    robot = of_source(tmp_path, f'names = ["panda_joint1", "panda_arm"]\n{calls}').robot
    assert (robot.name, robot.assumes_names) == ("panda", is_assumed)


ARM = 'arm = MoveGroupCommander("{}")\n'


@pytest.mark.parametrize(
    ("asks", "is_assumed"),
    [
        (ARM.format("manipulator"), True),
        ('goal.request.group_name = "r2_arm"\n', True),
        ('PLANNING_GROUP = "manipulator"\n', True),
        ('arm = MoveIt2(node=self, group_name="manipulator")\n', True),
        (ARM.format("panda_arm") + ARM.format("franka_gripper"), True),
        # Two arms, and a hand beside the robot's own.
        (ARM.format("panda_arm") + ARM.format("manipulator"), False),
        (ARM.format("panda_arm") + ARM.format("hand") + ARM.format("gripper"), False),
        (ARM.format("panda_arm"), False),
        ("arm.go(wait=True)\n", False),
    ],
)
def test_a_group_of_another_name_means_the_only_one_of_its_kind(tmp_path, asks, is_assumed):
    robot = of_source(tmp_path, f'names = ["panda_joint1", "panda_arm"]\n{asks}').robot
    assert (robot.name, robot.assumes_names) == ("panda", is_assumed)


def test_a_prefix_before_all_joints_of_an_arm_is_before_its_links_too(tmp_path):
    joints = [f"left_{name}" for name in UR]
    robot = of_source(tmp_path, f'joints = {joints}\ntip = "left_tool0"\nname = "ur5e"\n').robot
    assert [joint.name for joint in robot.arm_joints] == joints
    assert robot.groups["manipulator"].tip_link == "left_tool0"
    assert robot.chosen_by.endswith("its links and joints have the prefix 'left_'")
    pose = Kinematics(robot).forward({}, "left_tool0")
    assert pose == Kinematics(load_robot("ur5e")).forward({}, "tool0")


def test_joints_with_two_prefixes_are_of_two_arms_which_no_robot_has(tmp_path):
    both = [f"{side}_{name}" for side in ("left", "right") for name in UR]
    assert of_source(tmp_path, f"joints = {both}\n").robot.name == "generic"


TABLE = f"JOINTS = {PANDA}\nBASE = 'panda_link0'\n"
PACKAGE = "<package><name>{}</name></package>\n"


@pytest.mark.parametrize(
    ("files", "robot"),
    [
        # A library of another package has tables of arms.
        (
            {
                "src__weld__go_DOT_py": f"import armkit\nJOINTS = {UR}\nname = 'ur5e'\n",
                "src__weld__package_DOT_xml": PACKAGE.format("weld"),
                "src__armkit__package_DOT_xml": PACKAGE.format("armkit"),
                "src__armkit__armkit____init___DOT_py": "from . import tables\n",
                "src__armkit__armkit__tables_DOT_py": TABLE,
            },
            "ur5e",
        ),
        # Of the tables of a library the controller imports one by its name.
        (
            {
                "go_DOT_py": "from kit.arms import ur10e\n",
                "kit____init___DOT_py": "",
                "kit__arms____init___DOT_py": "from . import panda, ur10e\n",
                "kit__arms__ur10e_DOT_py": f"NAMES = {UR}\n",
                "kit__arms__panda_DOT_py": TABLE,
            },
            "ur10e",
        ),
        # A name that is imported says more than strings.
        (
            {
                "go_DOT_py": "from arms import ur3e\nhelp = 'as on the ur5'\n",
                "arms____init___DOT_py": "",
                "arms__ur3e_DOT_py": f"NAMES = {UR}\n",
            },
            "ur3e",
        ),
        # A module of its own package says more than a library.
        (
            {
                "src__weld__go_DOT_py": "import armkit\nfrom names import JOINTS\n",
                "src__weld__names_DOT_py": f"JOINTS = {UR}  # ur5e\nname = 'ur5e'\n",
                "src__weld__package_DOT_xml": PACKAGE.format("weld"),
                "src__armkit__package_DOT_xml": PACKAGE.format("armkit"),
                "src__armkit__armkit____init___DOT_py": TABLE,
            },
            "ur5e",
        ),
    ],
    ids=["tables", "imported table", "imported name", "own module"],
)
def test_what_the_controller_names_itself_comes_before_what_its_libraries_name(
    tmp_path, files, robot
):
    choice = chosen(tmp_path, **files)
    assert (choice.robot.name, choice.robot.doubt) == (robot, "")


LINK = '<link name="{}"><inertial><mass value="1"/></inertial></link>'
JOINT = (
    '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/>'
    '<origin xyz="0 0 0.2"/><axis xyz="0 1 0"/>'
    '<limit lower="-1" upper="1" effort="20" velocity="2"/></joint>'
)


def urdf(name: str, *joints: str) -> str:
    links = ["root", *(f"{joint}_link" for joint in joints)]
    hung = (JOINT.format(one, links[at], f"{one}_link") for at, one in enumerate(joints))
    return f'<robot name="{name}">{"".join(map(LINK.format, links))}{"".join(hung)}</robot>'


BIG = {
    "big_config__package_DOT_xml": PACKAGE.format("big_config"),
    "big_config__urdf__big_DOT_urdf": urdf("big", "axis_1", "axis_2", "axis_3"),
    "big_config__config__big_DOT_srdf": '<robot name="big"><group name="big">'
    '<chain base_link="root" tip_link="axis_3_link"/></group></robot>',
}


@pytest.mark.parametrize(
    ("source", "robot"),
    [
        ('joints = ["fore_joint", "hand_joint"]\n', "small"),
        ('joints = ["fore_joint", "wrist", "hand_joint"]\n', "small"),
        ('joints = ["axis_1", "axis_2", "axis_3"]\n', "big"),
        ('group = "big"\n', "big"),
    ],
)
def test_of_robots_of_the_workspace_the_one_with_the_joints_is_taken(tmp_path, source, robot):
    files = {
        "small__go_DOT_py": source,
        "small__package_DOT_xml": PACKAGE.format("small"),
        "small__urdf__small_DOT_urdf": urdf("small", "fore_joint", "hand_joint"),
        **BIG,
    }
    assert chosen(tmp_path, **files).robot.name == robot


@pytest.mark.parametrize("model", ["m0609", "a0509"])
def test_of_descriptions_with_the_same_joints_the_one_that_is_named_is_taken(tmp_path, model):
    named = [f"joint_{number}" for number in range(1, 4)]
    files = {
        "app__go_DOT_py": f'ROBOT_MODEL = "{model}"\njoints = {named}\n',
        "app__package_DOT_xml": PACKAGE.format("app"),
        "arms__package_DOT_xml": PACKAGE.format("arms"),
        "arms__urdf__a0509_DOT_urdf": urdf("a0509", *named),
        "arms__urdf__m0609_DOT_urdf": urdf("m0609", *named),
        "arms__urdf__m1013_DOT_urdf": urdf("m1013", *named),
    }
    choice = chosen(tmp_path, **files)
    assert choice.robot.name == model
    assert choice.robot.source.endswith(f"{model}.urdf")


@pytest.mark.parametrize(
    ("srdf", "doubt"),
    [("cell", True), ("long", False)],
    ids=["of neither by its name", "of the one that it names"],
)
def test_an_srdf_that_goes_with_several_arms_alike_makes_its_arm_an_assumption(
    tmp_path, srdf, doubt
):
    joints = ["axis_1", "axis_2", "axis_3"]
    group = BIG["big_config__config__big_DOT_srdf"].replace('"big"', f'"{srdf}"', 1)
    files = {
        "app__go_DOT_py": 'group = "big"\n',
        "app__package_DOT_xml": PACKAGE.format("app"),
        "arms__package_DOT_xml": PACKAGE.format("arms"),
        "arms__config__arm_DOT_srdf": group,
        "arms__urdf__long_DOT_urdf": urdf("long", *joints),
        "arms__urdf__short_DOT_urdf": urdf("short", *joints).replace("0 0 0.2", "0 0 0.1"),
        "arms__urdf__copy_DOT_urdf": urdf("copy", *joints),
    }
    robot = chosen(tmp_path, **files).robot
    assert robot.source.split(", ")[0].endswith("copy.urdf" if doubt else "long.urdf")
    assert ("short.urdf in the workspace would fit as well" in robot.doubt) == doubt
    assert "copy.urdf" not in robot.doubt, "the same arm"


def test_an_arm_in_the_place_of_one_that_cannot_be_read_is_an_assumption(tmp_path):
    joints = ["axis_1", "axis_2", "axis_3"]
    files = {
        "app__go_DOT_py": 'group = "big"\n',
        "app__package_DOT_xml": PACKAGE.format("app"),
        "arms__package_DOT_xml": PACKAGE.format("arms"),
        "arms__config__big_DOT_srdf": BIG["big_config__config__big_DOT_srdf"],
        "arms__urdf__other_DOT_urdf": urdf("other", *joints),
    }
    whole = urdf("big", *joints)
    broken = whole.replace("</robot>", JOINT.format("twice", "root", "axis_3_link") + "</robot>")
    for name, text, robot in (("whole", whole, "big"), ("broken", broken, "other")):
        choice = chosen(tmp_path / name, **files, arms__urdf__cell_DOT_urdf=text)
        assert choice.robot.name == robot
        said = "cell.urdf has the name of config/big.srdf and cannot be read"
        assert (said in choice.robot.doubt) == (robot == "other")


MOTOMAN = ["joint_1_s", "joint_2_l", "joint_3_u", "joint_4_r", "joint_5_b", "joint_6_t"]
"""As ros-industrial/motoman motoman_gp7_support/urdf/gp7_macro.xacro names them."""
MYCOBOT = [
    "joint2_to_joint1", "joint3_to_joint2", "joint4_to_joint3",
    "joint5_to_joint4", "joint6_to_joint5", "joint6output_to_joint6",
]  # fmt: skip
TMR = [
    "shoulder_1_joint", "shoulder_2_joint", "elbow_joint",
    "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]  # fmt: skip
"""As TechmanRobotInc/tmr_ros1 tm_description/urdf/tm5-900-nominal.urdf names them."""


@pytest.mark.parametrize(
    ("joints", "says", "robot", "is_sure"),
    [
        (MOTOMAN, "the GP7", "gp7", True),
        (MOTOMAN, "a Motoman GP8 beside the press", "gp8", True),
        (MOTOMAN, "yaskawa_hc10", "hc10", True),
        (MOTOMAN, "the arm", "gp7", False),
        (MYCOBOT, "mycobot_320_moveit", "mycobot_320", True),
        (MYCOBOT, "myCobot 280", "mycobot_280", True),
        (MYCOBOT, "the myCobot", "mycobot_280", False),
        (TMR, "the arm", "tm5_900_tmr", True),
        (["J1", "J2", "J3", "J4", "J5", "J6"], "the CRX-10iA", "crx10ia", True),
        (["joint_1", "joint_2", "joint_3"], "abb_irb120 on the table", "irb120", True),
        (["joint_1", "joint_2", "joint_3"], "the LR Mate 200iD", "lrmate200id", True),
        (["joint_1", "joint_2", "joint_3"], "our TM5-900", "tm5_900", True),
    ],
)
def test_arms_of_one_family_are_told_apart_by_what_names_the_model(
    tmp_path, joints, says, robot, is_sure
):
    source = f'MODEL = "{says}"\njoints = {joints}\n'
    found = of_source(tmp_path, source).robot
    assert found.name == robot
    assert bool(found.doubt) is not is_sure


WX = ["waist", "shoulder", "elbow", "wrist_angle", "wrist_rotate"]


@pytest.mark.parametrize(
    ("file", "text", "robot"),
    [
        (
            "README_DOT_md",
            "Start `roslaunch arm arm.launch robot_name:=wx200 use_sim:=true`.",
            "wx200",
        ),
        ("docs__start_DOT_rst", "    ros2 launch arm arm.launch.py robot_model:=rx150\n", "rx150"),
        ("Commands_DOT_md", "$ ros2 launch arm a.launch.py \\\n   robot_model:=wx250\n", "wx250"),
        ("readme", "rosrun arm go.py _model:=vx300", "vx300"),
        # The arms that it lists elsewhere are those that it could be.
        (
            "README_DOT_md",
            "For px150, rx200, vx250.\n\n    roslaunch arm arm.launch robot_name:=rx200\n",
            "rx200",
        ),
    ],
)
def test_the_command_of_a_readme_says_which_arm_of_a_family_it_is(tmp_path, file, text, robot):
    files = {"go_DOT_py": f"joints = {WX}\n", "package_DOT_xml": PACKAGE.format("arm")}
    choice = chosen(tmp_path, **files, **{file: text})
    assert choice.robot.name == robot
    assert not choice.robot.doubt
    assert "a command of a readme" in choice.robot.weighed or any(
        "a command of a readme" in each.words for each in choice.evidence
    )


@pytest.mark.parametrize(
    ("package", "joints", "robot", "is_sure"),
    [
        ("mycobot_320_moveit", MYCOBOT, "mycobot_320", True),
        ("mycobot_280_gripper_moveit", MYCOBOT, "mycobot_280", True),
        ("motoman_hc10_moveit_config", MOTOMAN, "hc10", True),
        ("gp8_config", MOTOMAN, "gp8", True),
        ("arm_moveit", MOTOMAN, "gp7", False),
    ],
)
def test_an_srdf_without_its_urdf_is_of_the_arm_that_its_package_names(
    tmp_path, package, joints, robot, is_sure
):
    parts = "".join(f'<joint name="{joint}"/>' for joint in joints)
    files = {
        "go_DOT_py": 'group = MoveGroupCommander("arm_group")\n',
        f"{package}__package_DOT_xml": PACKAGE.format(package),
        f"{package}__config__firefighter_DOT_srdf": (
            f'<robot name="firefighter"><group name="arm_group">{parts}</group></robot>'
        ),
    }
    found = chosen(tmp_path, **files).robot
    assert found.name == robot
    assert bool(found.doubt) is not is_sure


@pytest.mark.parametrize(
    ("source", "robot"),
    [
        ('bot = InterbotixLocobotXS("locobot_wx200", "mobile_wx200")\nf = "rover/arm"\n', "wx200"),
        ('bot = Manipulator("locobot_wx250s")\nframe = "rover/arm"\n', "wx250s"),
        ('class LocobotWx200Node:\n    frame = "rover/arm"\n', "wx200"),
        ('bot = Manipulator()\nframe = "rover/arm"\n', "px100"),
        ('bot = Manipulator("locobot_px100")\nframe = "rover/arm"\n', "px100"),
    ],
)
def test_a_description_of_another_robot_than_the_source_names_is_not_meant(tmp_path, source, robot):
    joints = ("waist", "shoulder", "elbow", "wrist_angle")
    parts = "".join(f'<joint name="{joint}"/>' for joint in joints)
    files = {
        "go_DOT_py": source,
        "rover_moveit__package_DOT_xml": PACKAGE.format("rover_moveit"),
        "rover_moveit__config__locobot_px100_DOT_srdf": (
            f'<robot name="rover"><group name="interbotix_arm">{parts}</group></robot>'
        ),
    }
    assert chosen(tmp_path, **files).robot.name.removeprefix("locobot_") == robot


@pytest.mark.parametrize(
    ("source", "doubt"),
    [
        ('arm = "ur10"\n', "grip.srdf is a gripper alone, which may be on an arm: ur10"),
        ('arm = "gen3"\n', "grip.srdf is a gripper alone, which may be on an arm: gen3"),
        ("", ""),
    ],
)
def test_a_gripper_alone_is_doubted_where_an_arm_is_named(tmp_path, source, doubt):
    lines = 'group = MoveGroupCommander("grip_hand")\njoint = "grip_left_finger_joint"\n'
    text = '<robot name="grip"><link name="base"/><link name="finger"/>{}</robot>'
    joint = (
        '<joint name="grip_left_finger_joint" type="prismatic"><parent link="base"/>'
        '<child link="finger"/><axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="9"'
        ' velocity="1"/></joint>'
    )
    group = '<group name="grip_hand"><joint name="grip_left_finger_joint"/></group>'
    files = {
        "go_DOT_py": lines + source,
        "package_DOT_xml": PACKAGE.format("grip"),
        "grip_DOT_urdf": text.format(joint),
        "grip_DOT_srdf": f'<robot name="grip">{group}</robot>',
    }
    robot = chosen(tmp_path, **files).robot
    assert (robot.name, robot.arm_joints) == ("grip", ())
    assert robot.doubt == doubt


@pytest.mark.parametrize(
    ("ends", "joints"),
    [
        (("base_link", "tool0"), UR),
        (("panda_link0", "panda_link8"), PANDA),
        (("stand", "flange"), SIX),
        (("left_base_link", "left_tool0"), [f"left_{joint}" for joint in UR]),
    ],
    ids=["ur", "panda", "nobody's", "prefixed"],
)
def test_a_gripper_alone_is_not_the_robot_of_an_srdf_that_has_an_arm(tmp_path, ends, joints):
    fingers = [f"finger_{number}" for number in range(9)]
    limit = '<axis xyz="0 1 0"/><limit lower="0" upper="0.04" effort="9" velocity="1"/>'
    parts = "".join(
        f'<link name="{name}"/><joint name="{name}_joint" type="prismatic"><parent link="palm"/>'
        f'<child link="{name}"/>{limit}</joint>'
        for name in fingers
    )
    hand = "".join(f'<link name="{name}"/>' for name in fingers)
    states = "".join(f'<joint name="{joint}" value="0.1"/>' for joint in joints)
    groups = (
        f'<group name="arm_group"><chain base_link="{ends[0]}" tip_link="{ends[1]}"/></group>'
        f'<group name="hand">{hand}</group>'
        f'<group_state name="home" group="arm_group">{states}</group_state>'
    )
    files = {
        "go_DOT_py": 'arm = MoveGroupCommander("arm_group")\n',
        "package_DOT_xml": PACKAGE.format("cell"),
        "hand_DOT_urdf": f'<robot name="hand"><link name="palm"/>{parts}</robot>',
        "cell_DOT_srdf": f'<robot name="cell">{groups}</robot>',
    }
    robot = chosen(tmp_path, **files).robot
    assert {*joints} <= {joint.name for joint in robot.arm_joints}
    assert "gripper alone" not in robot.doubt


@pytest.mark.parametrize(
    ("name", "joints", "renamed"),
    [
        ("mycobot_280", SIX, True),
        ("ur5e", SIX, True),
        ("panda", [f"joint_{number}" for number in range(7)], True),
        ("mycobot_280", SIX[:5], False),
        ("mycobot_280", SIX[::-1], False),
        ("ur5e", UR, False),
    ],
)
def test_joints_that_only_count_are_those_of_the_arm_that_is_named(tmp_path, name, joints, renamed):
    source = f'from arm_names import JOINTS\nROBOT = "{name}"\nTOPIC = "/{name}/commands"\n'
    robot = chosen(tmp_path, go_DOT_py=source, arm_names_DOT_py=f"JOINTS = {joints}\n").robot
    assert robot.name == name
    called = [joint.name for joint in robot.arm_joints]
    own = [joint.name for joint in load_robot(name).arm_joints]
    assert called == (joints if renamed else own)
    words = f"its joints are called {joints[0]} to {joints[-1]}, as the controller lists them"
    assert (words in robot.doubt) is renamed


COPY = (
    '<robot name="cell"><group name="arm"><chain base_link="root" tip_link="panda_joint7_link"/>'
    "</group></robot>"
)


@pytest.mark.parametrize(
    ("source", "module"),
    [
        ("from robots import panda\nmove(panda.joints, panda.GROUP)\n", "robots__panda"),
        ("import panda\nmove(panda.joints, panda.GROUP)\n", "panda"),
        ('from arms import joints, GROUP\nmove(joints, GROUP, "panda")\n', "arms"),
        ("class Panda:\n    from cell_of_the_panda import *\n", "cell_of_the_panda"),
    ],
)
def test_the_name_of_a_robot_is_as_much_a_description_s_of_its_joints(tmp_path, source, module):
    files = {
        "app__go_DOT_py": source,
        f"app__{module}_DOT_py": f'GROUP = "arm"\njoints = {PANDA}\n',
        "app__package_DOT_xml": PACKAGE.format("app"),
        "cell__package_DOT_xml": PACKAGE.format("cell"),
        "cell__urdf__cell_DOT_urdf": urdf("cell", *PANDA),
        "cell__config__cell_DOT_srdf": COPY,
        "rig__package_DOT_xml": PACKAGE.format("rig"),
        "rig__urdf__rig_DOT_urdf": urdf("rig", "slide", "tilt"),
    }
    choice = chosen(tmp_path, **files)
    assert (choice.robot.name, set(choice.robot.groups)) == ("cell", {"arm"})


@pytest.mark.parametrize(
    ("text", "is_taken"),
    [
        ('"""The default is in the joint_limits.yaml of the moveit_config package."""', False),
        ('log("no moveit_config was found")', False),
        ('help = "The moveit_config package, as <robot>_moveit_config"', False),
        ('package = "moveit_config"', True),
        ('file = "package://moveit_config/config/big.srdf"', True),
        ('run("roslaunch moveit_config demo.launch")', True),
    ],
)
def test_prose_does_not_name_a_package_that_lies_beside(tmp_path, text, is_taken):
    assert (beside(tmp_path, text, "moveit_config") == "big") is is_taken


@pytest.mark.parametrize(
    ("text", "is_taken"),
    [
        ('group = MoveGroupCommander("arm")', False),
        ('parameters = {"arm": 1.0}', False),
        ('wait_for("arm", "hand")', False),
        ('config = MoveItConfigsBuilder("arm").to_moveit_configs()', True),
        ('package = "arm_moveit_config"', True),
    ],
)
def test_a_word_alone_names_no_configuration_that_lies_beside(tmp_path, text, is_taken):
    assert (beside(tmp_path, text, "arm_moveit_config") == "big") is is_taken


def beside(tmp_path: Path, text: str, package: str) -> str:
    """Return the robot of a program, with one of the name `big` in a package of another project."""
    mine = written(
        tmp_path / "src/mine", {"go.py": f"{text}\n", "package.xml": PACKAGE.format("mine")}
    )
    for name, content in BIG.items():
        file = name.replace("__", "/").replace("_DOT_", ".").partition("/")[2]
        path = tmp_path / "src/other" / package / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content.replace("big_config", package))
    return choose_robot(api.load_controller(mine), Settings()).robot.name


@pytest.mark.parametrize(
    ("folder", "needed", "is_taken"),
    [
        ("other", "big_description", True),
        ("other/more", "big_description", False),
        ("third", "big_description", False),
        ("other", "small_description", False),
    ],
)
def test_with_a_description_beside_comes_its_own_configuration(tmp_path, folder, needed, is_taken):
    mine = written(
        tmp_path / "src/mine",
        {
            "go.py": 'PACKAGE = "big_description"\narm = MoveGroupCommander("reach")\n',
            "package.xml": PACKAGE.format("mine"),
        },
    )
    manifest = PACKAGE.format("big_moveit_config")
    files = {
        "other/big_description/package.xml": PACKAGE.format("big_description"),
        "other/big_description/urdf/big.urdf": urdf("big", "swing", "lift"),
        f"{folder}/big_moveit_config/package.xml": manifest.replace(
            "</package>", f"<depend>{needed}</depend></package>"
        ),
        f"{folder}/big_moveit_config/config/big.srdf": (
            '<robot name="big"><group name="reach"><joint name="swing"/><joint name="lift"/>'
            "</group></robot>"
        ),
    }
    for name, content in files.items():
        path = tmp_path / "src" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    robot = choose_robot(api.load_controller(mine), Settings()).robot
    assert ("reach" in robot.groups) is is_taken


@pytest.mark.parametrize(
    "line",
    [
        "import intera_interface",
        "from intera_interface import Limb",
        "from intera_motion_interface import MotionTrajectory",
        "from intera_core_msgs.msg import JointCommand",
    ],
)
def test_the_sdk_of_one_arm_names_it(tmp_path, line):
    choice = of_source(tmp_path, f"{line}\n")
    assert (choice.robot.name, choice.robot.doubt) == ("sawyer", "")


@pytest.mark.parametrize(
    ("folder", "line", "is_taken"),
    [
        ("test", "", False),
        ("tests/data", "", False),
        ("config", "", True),
        ("test", 'ROBOT = "rr"', True),
    ],
)
def test_what_only_tests_of_another_project_describe_is_no_robot(tmp_path, folder, line, is_taken):
    mine = written(
        tmp_path / "src/mine",
        {
            "go.py": f'PACKAGE = "planner"\n{line}\narm = MoveGroupCommander("reach")\n',
            "package.xml": PACKAGE.format("mine"),
        },
    )
    group = '<group name="reach"><joint name="swing"/><joint name="lift"/></group>'
    files = {
        "package.xml": PACKAGE.format("planner"),
        "urdf/readme.txt": "",
        f"{folder}/rr.urdf": urdf("rr", "swing", "lift"),
        f"{folder}/rr.srdf": f'<robot name="rr">{group}</robot>',
    }
    for name, content in files.items():
        path = tmp_path / "src/other/planner" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    assert (choose_robot(api.load_controller(mine), Settings()).robot.name == "rr") is is_taken


def test_evidence_is_weighed_on_a_line_of_its_own_only_where_it_says_more(tmp_path):
    joints = [f"panda_joint{number}" for number in range(1, 8)]
    one = chosen(tmp_path, go_DOT_py=f"joints = {joints}\n").robot
    assert one.name == "panda"
    assert "panda_joint1" in one.chosen_by
    assert one.weighed == ""
    source = f'joints = {joints}\nname = "panda_arm_controller"\n'
    more = chosen(tmp_path / "more", go_DOT_py=source).robot.weighed
    assert more.startswith("panda has ")
    assert "points: also its source names parts of it: panda_arm_controller" in more
    assert "panda_joint1" not in more


ARM_AND_GRIPPER = "".join(
    f'<joint name="{joint}" type="revolute"><parent link="l{number}"/><child link="l{number + 1}"/>'
    '<axis xyz="0 0 1"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
    for number, joint in enumerate(("pan_1", "lift_1", "flex_1", "roll_1", "gripper"))
)


@pytest.mark.parametrize(
    ("source", "robot"),
    [
        ("from {} import panda as robot\n", "panda"),
        ("import {}.panda as robot\n", "panda"),
        ('from {} import panda as robot\nnames = ["pan_1", "lift_1", "flex_1", "roll_1"]\n', "soa"),
    ],
)
@pytest.mark.parametrize("package", ["moveit_of_it.robots", "its.robots"])
def test_a_module_of_robots_says_more_than_what_anybody_calls_a_part(
    tmp_path, package, source, robot
):
    links = "".join(f'<link name="l{number}"/>' for number in range(6))
    folder = package.replace(".", "__")
    files = {
        "go_DOT_py": f'"""Use the gripper."""\n{source.format(package)}GROUP = "gripper"\n',
        f"{folder}____init___DOT_py": "",
        f"{folder.removesuffix('__robots')}____init___DOT_py": "",
        f"{folder}__panda_DOT_py": f'GROUP = "gripper"\nJOINTS = {PANDA}\n',
        "soa__package_DOT_xml": PACKAGE.format("soa"),
        "soa__urdf__soa_DOT_urdf": f'<robot name="soa">{links}{ARM_AND_GRIPPER}</robot>',
        "soa__config__soa_DOT_srdf": (
            '<robot name="soa"><group name="arm"><chain base_link="l0" tip_link="l4"/></group>'
            '<group name="gripper"><joint name="gripper"/></group></robot>'
        ),
    }
    assert chosen(tmp_path, **files).robot.name == robot
