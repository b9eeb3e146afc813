"""Where packages of both ROS have one name, the controller's own ROS decides which is taken."""

from pathlib import Path

import pytest

from tracerisk.config import Settings
from tracerisk.pipeline.workspace.controller import Controller, load_controller
from tracerisk.pipeline.workspace.package_folders import ros_of_package
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import workspace_of

CATKIN = "<buildtool_depend>catkin</buildtool_depend>"
AMENT = "<export><build_type>ament_python</build_type></export>"
IMPORTS = {CATKIN: "import rospy\n", AMENT: "import rclpy\n"}


def package(folder: Path, tool: str, name: str = "", *needs: str) -> Path:
    folder.mkdir(parents=True)
    depends = "".join(f"<depend>{need}</depend>" for need in needs)
    (folder / "package.xml").write_text(
        f"<package><name>{name or folder.name}</name>{depends}{tool}</package>\n"
    )
    return folder


def controller(folder: Path, tool: str, *needs: str) -> Controller:
    package(folder, tool, "", *needs)
    script = folder / "pick.py"
    script.write_text(IMPORTS[tool])
    return load_controller(script)


@pytest.mark.parametrize(
    ("manifest", "ros"),
    [
        (CATKIN, 1),
        (AMENT, 2),
        ("<buildtool_depend>ament_cmake</buildtool_depend>", 2),
        ("<buildtool_depend>cmake</buildtool_depend>", None),
        ("", None),
        (CATKIN + AMENT, None),
        (f"<!-- {CATKIN} -->{AMENT}", 2),
        (
            '<buildtool_depend condition="$ROS_VERSION == 1">catkin</buildtool_depend>'
            '<buildtool_depend condition="$ROS_VERSION == 2">ament_cmake</buildtool_depend>',
            None,
        ),
        ("<buildtool_depend>catkin</buildtool_depend><depend>ament_index_python</depend>", 1),
    ],
)
def test_the_build_tool_of_a_manifest_says_for_which_ros_a_package_is(tmp_path, manifest, ros):
    assert ros_of_package(package(tmp_path / "arm", manifest)) == ros


@pytest.mark.parametrize(("tool", "other"), [(AMENT, CATKIN), (CATKIN, AMENT)])
@pytest.mark.parametrize("places", [("a_repo", "b_repo"), ("b_repo", "a_repo")])
def test_of_two_checkouts_in_one_src_the_controllers_ros_is_taken(tmp_path, tool, other, places):
    sources = tmp_path / "ws" / "src"
    own = sources / "own_repo" / "pick"
    controller(own, tool, "arm_msgs")
    fitting, foreign = (sources / place / "arm_msgs" for place in places)
    package(fitting, tool)
    package(foreign, other)
    for repository in (own.parent, fitting.parent, foreign.parent):
        (repository / ".git").mkdir()
    assert Project(own).workspace().packages == {"arm_msgs": fitting, "pick": own}


@pytest.mark.parametrize(("tool", "other"), [(AMENT, CATKIN), (CATKIN, AMENT)])
def test_in_one_repository_the_farther_package_of_its_ros_is_taken(tmp_path, tool, other):
    """Some repositories have a folder for each ROS."""
    own = controller(tmp_path / "repo" / "demos" / "pick", tool)
    package(tmp_path / "repo" / "demos" / "arm_description", other)
    far = package(tmp_path / "repo" / "drivers" / "more" / "arm_description", tool)
    (tmp_path / "repo" / ".git").mkdir()
    assert workspace_of(own, Settings()).packages["arm_description"] == far


def test_a_package_beside_the_repository_goes_before_its_own_one_of_the_other_ros(tmp_path):
    sources = tmp_path / "ws" / "src"
    own = controller(sources / "own_repo" / "pick", AMENT, "arm_bringup")
    package(sources / "own_repo" / "arm_bringup", CATKIN)
    fitting = package(sources / "arm_repo" / "arm_bringup", AMENT)
    (sources / "own_repo" / ".git").mkdir()
    assert workspace_of(own, Settings()).packages["arm_bringup"] == fitting


def test_without_one_of_its_own_ros_the_other_package_is_taken(tmp_path):
    own = controller(tmp_path / "repo" / "pick", AMENT)
    only = package(tmp_path / "repo" / "arm_description", CATKIN)
    (tmp_path / "repo" / ".git").mkdir()
    assert workspace_of(own, Settings()).packages["arm_description"] == only


def test_what_its_script_imports_says_of_which_ros_a_controller_without_manifest_is(tmp_path):
    script = tmp_path / "repo" / "tools" / "pick.py"
    script.parent.mkdir(parents=True)
    (tmp_path / "repo" / ".git").mkdir()
    script.write_text("import rclpy\n")
    package(tmp_path / "repo" / "src" / "a" / "arm_description", CATKIN)
    fitting = package(tmp_path / "repo" / "src" / "b" / "arm_description", AMENT)
    found = workspace_of(load_controller(script), Settings()).packages
    assert found == {"arm_description": fitting}


def test_shipped_messages_go_before_a_package_of_the_other_ros(tmp_path):
    """`xarm_msgs` of ROS 1 and of ROS 2 share a name, and not one service."""
    sources = tmp_path / "ws" / "src"
    own = controller(sources / "own_repo" / "pick", AMENT, "xarm_msgs")
    package(sources / "xarm_ros" / "xarm_msgs", CATKIN)
    for repository in ("own_repo", "xarm_ros"):
        (sources / repository / ".git").mkdir()
    assert list(workspace_of(own, Settings()).packages) == ["pick"]


def test_an_installed_package_goes_before_one_of_the_other_ros(tmp_path):
    own = controller(tmp_path / "repo" / "pick", AMENT)
    package(tmp_path / "repo" / "arm_moveit", CATKIN)
    (tmp_path / "repo" / ".git").mkdir()
    prefix = tmp_path / "prefix"
    there = package(prefix / "share" / "arm_moveit", AMENT)
    index = prefix / "share" / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    (index / "arm_moveit").touch()
    found = workspace_of(own, Settings(ros_prefixes=(str(prefix),)))
    assert found.findable["arm_moveit"] == there
