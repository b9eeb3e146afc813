"""Of several robots that fit a controller, the one that its project names is taken."""

from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.config import Settings
from tracerisk.pipeline.robot.choice import choose_robot, driven_robot

ARM = 'JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"]\n'
GROUP = 'arm = MoveGroupCommander("manipulator")\n'
DEPENDING = "<package><name>cell</name><exec_depend>{}</exec_depend></package>\n"
MANIFEST = "<package><name>{}</name></package>\n"


def project(top: Path, script: str, **files: str) -> Path:
    """A package with a controller and further files, in a repository."""
    package = top / "repo" / "cell"
    (package / "scripts").mkdir(parents=True)
    (top / "repo" / ".git").mkdir()
    (package / "package.xml").write_text(files.pop("manifest", MANIFEST.format("cell")))
    for name, text in files.items():
        path = package.parent / name.replace("__", "/").replace("_DOT_", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    (package / "scripts" / "pick.py").write_text(script)
    return package / "scripts" / "pick.py"


def chosen_by(script: Path) -> tuple[str, str]:
    robot = choose_robot(api.load_controller(script), Settings()).robot
    return robot.name, robot.chosen_by.partition("; ")[2] or robot.chosen_by


@pytest.mark.parametrize(
    ("script", "files", "robot", "expected"),
    [
        (ARM + "ur3e_home = 0\n", {}, "ur3e", "its source (pick.py)"),
        (ARM + "# of the UR10\n", {}, "ur10", "its comments or docstrings (pick.py)"),
        ('"""Moves a UR-5e."""\n' + ARM, {}, "ur5e", "its comments or docstrings (pick.py)"),
        (ARM, {"manifest": MANIFEST.format("ur5_cell")}, "ur5",
         "the package's manifest (cell/package.xml)"),
        (ARM, {"cell__launch__cell_DOT_launch": '<arg name="type" default="ur3"/>'}, "ur3",
         "a launch file (cell/launch/cell.launch)"),
        (ARM, {"cell__config__a_DOT_yaml": "ur_type: ur10e"}, "ur10e",
         "a parameter file (cell/config/a.yaml)"),
        (ARM, {"README_DOT_md": "# A cell with a UR10e"}, "ur10e", "a readme (README.md)"),
        (GROUP, {"manifest": DEPENDING.format("ur5_moveit_config")}, "ur5",
         "what its package depends on (package.xml)"),
        (ARM + "# not the UR3\n", {"cell__ur5_DOT_yaml": "ur5"}, "ur3", "its comments or docstrings (pick.py)"),
    ],
)  # fmt: skip
def test_the_heaviest_evidence_decides_and_is_reported(tmp_path, script, files, robot, expected):
    assert chosen_by(project(tmp_path, script, **files)) == (
        robot,
        f"{robot} is named in {expected}",
    )


@pytest.mark.parametrize("needs", ["ur5_msgs", "ur5_moveit_config</depend><depend>ur10_support"])
def test_what_a_package_depends_on_says_nothing_where_it_is_no_robot_or_two(tmp_path, needs):
    script = project(tmp_path, GROUP, manifest=DEPENDING.format(needs).replace("exec_", ""))
    assert choose_robot(api.load_controller(script), Settings()).robot.name == "generic"


def test_folders_of_the_project_count_and_those_around_it_do_not(tmp_path):
    script = project(tmp_path / "ur10", ARM)
    found = choose_robot(api.load_controller(script), Settings()).robot
    assert "would fit as well" in found.doubt
    script.parents[2].rename(tmp_path / "ur5e_demo")
    moved = tmp_path / "ur5e_demo" / "cell" / "scripts" / "pick.py"
    assert chosen_by(moved) == ("ur5e", "ur5e is named in its folder's name (ur5e_demo)")


def test_files_of_another_checkout_beside_it_are_no_evidence(tmp_path):
    own, other = tmp_path / "own", tmp_path / "other"
    for folder in (own, other):
        folder.mkdir()
        (folder / "package.xml").write_text(MANIFEST.format(folder.name))
    (other / "README.md").write_text("UR5e\n")
    (own / "pick.py").write_text(ARM)
    found = choose_robot(api.load_controller(own / "pick.py"), Settings()).robot
    assert found.name == "ur5e"
    assert found.doubt.startswith("ur10, ur10e, ur16e, ur20, ur3, ur30 would fit as well")


def test_a_script_that_lies_about_is_not_reported_by_the_folder_it_lies_in(tmp_path):
    (tmp_path / "ur5e").mkdir()
    (tmp_path / "ur5e" / "pick.py").write_text('GROUP = "manipulator"\n')
    assert chosen_by(tmp_path / "ur5e" / "pick.py")[0] == "generic"


def test_a_controller_of_a_gripper_alone_gets_the_generic_arm(tmp_path):
    name, reported = chosen_by(project(tmp_path, 'NAMES = ["gripper", "gripper_controller"]\n'))
    assert name == "generic"
    assert "--robot" in reported


@pytest.mark.parametrize(
    ("files", "robot"),
    [
        ({"README_DOT_md": "A cell with an OpenMANIPULATOR."}, "open_manipulator_x"),
        ({"README_DOT_md": "UR5 and Panda."}, "generic"),
        ({"README_DOT_md": "An arm."}, "generic"),
    ],
)
def test_what_a_readme_alone_speaks_of_is_assumed_and_not_a_generic_arm(tmp_path, files, robot):
    script = project(tmp_path, GROUP, **files)
    found = choose_robot(api.load_controller(script), Settings()).robot
    assert found.name == robot
    if robot != "generic":
        said = f"{robot} is named in a readme (README.md)"
        assert found.doubt == f"all that speaks for it is that {said}"


@pytest.mark.parametrize(
    ("script", "assumes"),
    [
        ('arm = MoveGroupCommander("arm")\n', False),
        ("from pymoveit2.robots import panda\n", True),
        ('from pymoveit2.robots import panda\nGROUP = "panda_arm"\n', False),
    ],
)
def test_a_robot_of_the_settings_assumes_the_groups_that_only_pymoveit2_names(
    tmp_path, script, assumes
):
    (tmp_path / "pick.py").write_text(script)
    controller = api.load_controller(tmp_path / "pick.py")
    robot = choose_robot(controller, Settings(robot="panda")).robot
    assert robot.assumes_names is assumes


COUNTING = (
    "# OpenManipulator\nNAMES = ['joint1', 'joint2', 'joint3', 'joint4', 'joint5', 'joint6']\n"
)
ELSEWHERE = {
    "more joints": COUNTING + "GROUP = 'open_manipulator'\n",
    "another model": "topic = '/open_manipulator_p/goal_joint_space_path'\n",
    "another arm of its maker": (
        "# mechArm 270\nfrom mycobot_communication.msg import MycobotSetAngles\n"
    ),
    "the one with two arms": "model = 'tiago_dual'\n",
    "the one with two arms by its title": "# For TIAGo++.\nname = 'tiago'\n",
    "the one with two arms by its parts": "name = 'tiago'\ngroup = 'arm_right_torso'\n",
}


@pytest.mark.parametrize("script", ELSEWHERE.values(), ids=ELSEWHERE)
def test_an_arm_that_is_not_shipped_is_no_shipped_one(tmp_path, script):
    robot, words = chosen_by(project(tmp_path, script))
    assert (robot, "name it with --robot" in words) == ("generic", True)


@pytest.mark.parametrize("source", ["'arm_torso'", "'arm_right'", "'tiago_dualshock'"])
def test_what_the_tiago_with_one_arm_may_name_is_not_the_one_with_two(tmp_path, source):
    assert chosen_by(project(tmp_path, f"name = 'tiago'\nother = {source}\n"))[0] == "tiago"


@pytest.mark.parametrize("name", ["myArm", "my_arm", "myarm_2", "swarm_myarmy"])
def test_what_a_program_calls_its_arm_is_no_other_model(tmp_path, name):
    source = f"from mycobot_communication.msg import MycobotSetAngles\n{name} = 'mycobot_280'\n"
    assert chosen_by(project(tmp_path, source))[0] == "mycobot_280"


@pytest.mark.parametrize("arm", ["myArm 300 Pi", "myarm_m750", "MyArm-C650", "mech_arm_270"])
def test_another_arm_of_the_maker_is_named_in_many_ways(tmp_path, arm):
    source = f"# {arm}\nfrom mycobot_communication.msg import MycobotSetAngles\n"
    robot, words = chosen_by(project(tmp_path, source))
    assert (robot, "name it with --robot" in words) == ("generic", True)


@pytest.mark.parametrize(
    "script",
    [
        "GROUP = 'open_manipulator'\np = Pose()\n",
        "move('open_manipulator', y)\n",
        "# Moves an OpenManipulator.\n# P is its pose.\n",
    ],
)
def test_a_letter_behind_the_name_of_an_arm_is_no_other_model(tmp_path, script):
    assert chosen_by(project(tmp_path, script))[0] == "open_manipulator_x"


@pytest.mark.parametrize("name", ["OpenManipulator P", "OpenMANIPULATOR-P", "open_manipulator_p"])
def test_a_letter_that_belongs_to_the_name_of_an_arm_is_another_model(tmp_path, name):
    assert chosen_by(project(tmp_path, f"# {name}\n"))[0] == "generic"


def test_the_arm_itself_stays_what_its_source_names(tmp_path):
    script = COUNTING.replace(", 'joint5', 'joint6'", "") + "GROUP = 'open_manipulator'\n"
    assert chosen_by(project(tmp_path, script))[0] == "open_manipulator_x"


UR_JOINTS = [
    *("shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint"),
    *("wrist_1_joint", "wrist_2_joint", "wrist_3_joint"),
]


def maker(top: Path, folder: str, *models: str) -> Path:
    """A maker's package with a description and an SRDF for each of its arms of the same joints."""
    links = "".join(f'<link name="l{number}"/>' for number in range(7))
    joints = "".join(
        f'<joint name="{name}" type="revolute"><parent link="l{number}"/>'
        f'<child link="l{number + 1}"/><axis xyz="0 0 1"/><origin xyz="0 0 LEN"/>'
        '<limit lower="-2" upper="2" velocity="1" effort="9"/></joint>'
        for number, name in enumerate(UR_JOINTS)
    )
    for number, model in enumerate(models):
        package = top / f"{model}_moveit_config"
        (package / "config").mkdir(parents=True)
        (package / "package.xml").write_text(f"<package><name>{package.name}</name></package>")
        (package / "config" / f"{model}.srdf").write_text(
            f'<robot name="{model}"><group name="manipulator">'
            '<chain base_link="l0" tip_link="l6"/></group></robot>'
        )
        (package / "config" / f"{model}.urdf").write_text(
            f'<robot name="{model}">{links}{joints.replace("LEN", f"0.{number + 1}")}</robot>'
        )
    script = top / folder / "go.py"
    script.parent.mkdir()
    (top / ".git").mkdir()
    script.write_text(f"import rospy\nJOINTS, GROUP = {UR_JOINTS!r}, 'manipulator'\n")
    return script


@pytest.mark.parametrize(
    ("folder", "robot", "is_sure"),
    [("qx5_demo", "qx5", True), ("qx3_demo", "qx3", True), ("demo", "qx10", False)],
)
def test_of_a_makers_arms_with_the_same_joints_the_folder_says_one(
    tmp_path, folder, robot, is_sure
):
    script = maker(tmp_path, folder, "qx10", "qx3", "qx5")
    chosen = driven_robot(api.load_controller(script), Settings())
    assert chosen.name == robot
    assert bool(chosen.doubt) != is_sure
    if not is_sure:
        assert "qx5_moveit_config" in chosen.doubt


def test_the_model_that_the_source_names_outweighs_a_part_of_another(tmp_path):
    script = maker(tmp_path, "demo", "qx10", "qx5")
    srdf = tmp_path / "qx10_moveit_config" / "config" / "qx10.srdf"
    grip = '<group name="grip"><joint name="wrist_3_joint"/></group></robot>'
    srdf.write_text(srdf.read_text().replace("</robot>", grip))
    script.write_text("import rospy\nrobot, groups = 'qx5', ['manipulator', 'grip']\n")
    assert driven_robot(api.load_controller(script), Settings()).name == "qx5"


def test_a_description_of_another_shipped_arm_is_not_the_one_of_the_folder(tmp_path):
    described = tmp_path / "mycobot_description"
    for model in ("320", "600"):
        (described / f"{model}_urdf").mkdir(parents=True)
        joints = "".join(
            f'<joint name="joint{number + 1}" type="revolute"><parent link="l{number}"/>'
            f'<child link="l{number + 1}"/><axis xyz="0 0 1"/><origin xyz="0 0 0.1"/>'
            '<limit lower="-2" upper="2" velocity="1" effort="9"/></joint>'
            for number in range(6)
        )
        links = "".join(f'<link name="l{number}"/>' for number in range(6))
        text = f'<robot name="mycobot{model}">{links}<link name="l6"/>{joints}</robot>'
        (described / f"{model}_urdf" / "mycobot.urdf").write_text(text)
    (described / "package.xml").write_text("<package><name>mycobot_description</name></package>")
    (tmp_path / ".git").mkdir()
    script = tmp_path / "mycobot_280" / "go.py"
    script.parent.mkdir()
    script.write_text("import rospy\ntopic, part = 'mycobot/angles_goal', 'l6'\n")
    assert driven_robot(api.load_controller(script), Settings()).name == "mycobot_280"
