"""C++ headers that a machine lacks are made from our texts, with the sums of the public ones."""

import re
from pathlib import Path

import pytest

from tests.ros.live.messages.test_modules import PUBLIC
from tracerisk.errors import DependencyError, InputError
from tracerisk.pipeline.run.live.headers import headers_for
from tracerisk.ros.live.messages.headers import include_folders, make_headers
from tracerisk.ros.messages.ros1 import Interfaces

SOURCE = b"""
#include <ros/ros.h>
#include <control_msgs/FollowJointTrajectoryAction.h>
  #  include "control_msgs/QueryTrajectoryState.h"
#include <geometry_msgs/Pose.h>
#include <cell_msgs/Unknown.h>
"""


def sum_of(header: Path) -> str:
    first, second = re.findall(r"static_value[12] = 0x(\w{16})ULL", header.read_text())[:2]
    return first + second


def test_headers_are_made_with_their_parts_and_the_public_sums(real_ros, tmp_path):
    del real_ros
    present = tmp_path / "present"
    for package in ("std_msgs", "geometry_msgs", "actionlib_msgs"):
        (present / package).mkdir(parents=True)
    out = tmp_path / "made"
    try:
        packages = make_headers(Interfaces(), [SOURCE], out, [present])
    except DependencyError as error:
        pytest.skip(str(error))
    assert packages == ("control_msgs", "trajectory_msgs")
    assert sorted(path.name for path in out.iterdir()) == ["control_msgs", "trajectory_msgs"]
    made = out / "control_msgs"
    action = made / "FollowJointTrajectoryAction.h"
    assert sum_of(action) == PUBLIC["FollowJointTrajectoryAction"]
    assert "#include <control_msgs/FollowJointTrajectoryActionGoal.h>" in action.read_text()
    assert (made / "FollowJointTrajectoryActionGoal.h").is_file()
    assert (out / "trajectory_msgs" / "JointTrajectoryPoint.h").is_file()
    service = (made / "QueryTrajectoryState.h").read_text()
    assert PUBLIC["QueryTrajectoryState"] in service


@pytest.mark.slow
def test_interfaces_of_moveit_come_with_the_messages_that_they_need(real_ros, tmp_path):
    del real_ros
    source, out = (
        b"#include <moveit/move_group_interface/move_group_interface.h>\n",
        tmp_path / "made",
    )
    (tmp_path / "moveit").mkdir()
    assert make_headers(Interfaces(), [source], out, [tmp_path]) == ()
    (tmp_path / "moveit").rmdir()
    try:
        packages = make_headers(Interfaces(), [source], out, [Path("/usr/include")])
    except DependencyError as error:
        pytest.skip(str(error))
    assert {"moveit", "moveit_msgs"} <= set(packages)
    assert (out / "moveit" / "planning_scene_interface" / "planning_scene_interface.h").is_file()
    assert (out / "moveit_msgs" / "MoveGroupAction.h").is_file()


def test_for_ros2_interfaces_of_moveit_are_all_that_is_made(tmp_path):
    name = "moveit/move_group_interface/move_group_interface.hpp"
    source = f"#include <rclcpp/rclcpp.hpp>\n#include <{name}>\n".encode()
    out, prefix = tmp_path / "made", tmp_path / "ros" / "include"
    assert make_headers(Interfaces(), [source], out, [prefix], ros=2) == ("moveit",)
    assert sorted(path.name for path in out.iterdir()) == ["moveit", "moveit_visual_tools"]
    of_ros = (out / "moveit/of_ros/of_ros.h").read_text()
    assert "#include <rclcpp/rclcpp.hpp>" in of_ros
    assert (out / name).read_text() == f"#include <{name.removesuffix('pp')}>\n"
    # As MoveIt 2 is installed: each package has a folder of its own.
    (prefix / "moveit_ros_planning_interface/moveit/move_group_interface").mkdir(parents=True)
    assert make_headers(Interfaces(), [source], tmp_path / "none", [prefix], ros=2) == ()
    assert not (tmp_path / "none").exists()


def test_the_version_of_ros_is_that_of_the_sources(tmp_path):
    (tmp_path / "pick.cpp").write_bytes(
        b"#include <rclcpp/rclcpp.hpp>\n#include <moveit/robot_state/robot_state.h>\n"
    )
    assert headers_for([tmp_path / "pick.cpp"], tmp_path / "out") == ("moveit",)
    assert "rclcpp" in (tmp_path / "out/moveit/of_ros/of_ros.h").read_text()


def test_what_headers_of_the_sources_include_is_made_too(tmp_path):
    name = "#include <moveit/move_group_interface/move_group_interface.hpp>\n"
    for file, text in {
        "cell/package.xml": "<package><name>cell</name></package>",
        "cell/src/pick.cpp": '#include <rclcpp/rclcpp.hpp>\n#include "cell/arm.hpp"\n',
        "cell/include/cell/arm.hpp": name,
    }.items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(text)
    assert headers_for([tmp_path / "cell/src/pick.cpp"], tmp_path / "out") == ("moveit",)


def test_nothing_is_made_where_nothing_is_missing(tmp_path):
    present = tmp_path / "present"
    (present / "control_msgs").mkdir(parents=True)
    (present / "geometry_msgs").mkdir(parents=True)
    assert make_headers(Interfaces(), [SOURCE], tmp_path / "made", [present]) == ()
    assert not (tmp_path / "made").exists()


def test_headers_are_looked_for_where_compilers_and_builds_have_them():
    folders = include_folders(
        {"CPATH": "/a:/b", "CMAKE_PREFIX_PATH": "/ws/devel:/opt/ros/noetic", "HOME": "/c"}
    )
    listed = [str(folder) for folder in folders]
    assert listed[:4] == ["/a", "/b", "/ws/devel/include", "/opt/ros/noetic/include"]
    of_ros2 = include_folders({"AMENT_PREFIX_PATH": "/ws/install/cell:/opt/ros/jazzy"})
    assert of_ros2[:2] == (Path("/ws/install/cell/include"), Path("/opt/ros/jazzy/include"))
    assert "/usr/include" in listed


def test_what_is_no_source_is_refused(tmp_path):
    (tmp_path / "pick.py").touch()
    with pytest.raises(InputError, match="neither a C or C\\+\\+ source nor a folder with any"):
        headers_for([tmp_path / "pick.py"], tmp_path / "made")
    with pytest.raises(InputError, match="neither a C or C\\+\\+ source nor a folder with any"):
        headers_for([tmp_path], tmp_path / "made")


def test_a_folder_called_like_a_header_is_none_and_a_file_no_place_for_headers(tmp_path):
    (tmp_path / "pick.h").mkdir()
    with pytest.raises(InputError, match="is neither a C or C"):
        headers_for([tmp_path], tmp_path / "out")
    (tmp_path / "pick.cpp").write_bytes(b"int main() {}\n")
    assert headers_for([tmp_path], tmp_path / "out") == ()
    with pytest.raises(InputError, match="is no folder; name one for the headers"):
        headers_for([tmp_path], tmp_path / "pick.cpp")
