"""Runs that use packages of overlays and of the installed ROS."""

import json
import os
from pathlib import Path

import pytest

from tests.installed_ros import MANIFEST, Prefix, write
from tests.pipeline.robot.test_described_robots import CHAIN, XACRO
from tracerisk.ros.messages.ros1 import Interfaces

ADD = """\
import threading
import rclpy
from ament_index_python.packages import get_package_prefix, get_package_share_directory
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from example_numbers.srv import AddTwoInts

rclpy.init()
node = rclpy.create_node("go")
group = ReentrantCallbackGroup()

def add(request, response):
    response.sum = request.a + request.b
    return response

node.create_service(AddTwoInts, "add", add, callback_group=group)
client = node.create_client(AddTwoInts, "add", callback_group=group)
executor = MultiThreadedExecutor()
executor.add_node(node)
threading.Thread(target=executor.spin, daemon=True).start()
client.wait_for_service()
print("sum", client.call(AddTwoInts.Request(a=2, b=3)).sum)
print("share", get_package_share_directory("example_numbers"))
print("prefix", get_package_prefix("example_numbers"))
"""
COMPILED = "class AddTwoInts:\n    class Request: pass\n    class Response: pass\n"


@pytest.fixture
def overlay(tmp_path_factory):
    return Prefix(tmp_path_factory.mktemp("under") / "overlay")


def sourced(prefix, *sites):
    """The variables of a shell that has sourced a prefix of ROS 2."""
    found = {"AMENT_PREFIX_PATH": str(prefix.path), "CMAKE_PREFIX_PATH": str(prefix.path)}
    return {**found, "PYTHONPATH": os.pathsep.join(sites)} if sites else found


@pytest.mark.slow
def test_messages_come_from_texts_whatever_a_sourced_shell_has_compiled(example, overlay):
    overlay.install("example_numbers", {"srv/AddTwoInts.srv": "int64 a\nint64 b\n---\nint64 sum\n"})
    site = overlay.python(
        {
            "example_numbers/__init__.py": "",
            "example_numbers/srv/__init__.py": COMPILED,
            "rclpy/__init__.py": "raise ImportError('compiled for another Python')\n",
            "yaml/__init__.py": "raise ImportError('of another Python')\n",
        }
    )
    example.write("add.py", ADD)
    done = example.run("trace", "add.py", environment=sourced(overlay, site))
    share = overlay.path / "share/example_numbers"
    assert f"sum 5\nshare {share}\nprefix {overlay.path}\n" in done.out + done.err
    assert "internal" not in done.out + done.err


LIBRARY = """\
import rclpy
from grip_library import width
from grip_library.messages import made
from robot_parts import Part
from robot_parts.msg import Size

rclpy.init()
print("width", width(), made(), Part.name, Size(width=0.5))
try:
    import grip_library._native
except ModuleNotFoundError as error:
    print("refused", error)
try:
    import compiled_alone
except ImportError as error:
    print("no", type(error).__name__)
"""


def test_python_libraries_of_a_prefix_run_on_the_stand_ins_and_nothing_compiled(example, overlay):
    overlay.install("robot_parts", {"msg/Size.msg": "float64 width\n"})
    overlay.install("grip_library")
    overlay.python(
        {
            "grip_library/__init__.py": "from rclpy.node import Node\ndef width(): return 0.08\n",
            "grip_library/messages.py": "from std_msgs.msg import String\n"
            "def made(): return String(data='ok').data\n",
            "grip_library/_native.cpython-310-x86_64-linux-gnu.so": "\x7fELF",
            "compiled_alone.so": "\x7fELF",
            "robot_parts/__init__.py": "from robot_parts.part import Part\n",
            "robot_parts/part.py": "class Part: name = 'finger'\n",
            "robot_parts/msg/__init__.py": "raise ImportError('compiled')\n",
        },
        "lib/python3.8/site-packages",
    )
    example.write("grip.py", LIBRARY)
    done = example.run("trace", "grip.py", "--json", environment=sourced(overlay))
    assert "width 0.08 ok finger robot_parts.msg.Size(width=0.5)" in done.out + done.err
    assert (
        "refused No module named 'grip_library._native' that can be run here" in done.out + done.err
    )
    assert "no ModuleNotFoundError" in done.out + done.err
    inputs = done.json["trace"]["inputs"]
    assert any(each.endswith("grip_library/messages.py") for each in inputs)
    assert any(each.endswith("share/robot_parts/msg/Size.msg") for each in inputs)
    assert not any("std_msgs" in each for each in inputs)


ROS_1 = """\
#!/usr/bin/env python3
import roslib
import rospkg
import rospy
from arm_msgs.msg import Grip, MoveResult
from arm_tools import opened

rospy.init_node("go")
print("path", rospkg.RosPack().get_path("arm_msgs"), roslib.packages.get_pkg_dir("arm_tools"))
print("grip", Grip(0.02).width, MoveResult(True).done, opened())
print("needs", rospkg.RosPack().get_depends("arm_tools"), rospy.get_param("~speed"))
print("height", rospy.get_param("/arm/height"))
"""
LAUNCH_1 = """\
<launch>
  <include file="$(find arm_tools)/launch/speed.launch"/>
  <node pkg="pick" type="go.py" name="go"><param name="speed" value="$(arg speed)"/></node>
</launch>
"""


def test_ros_1_finds_packages_messages_and_launch_files_of_a_devel_space(example, tmp_path_factory):
    under = tmp_path_factory.mktemp("under")
    sources = under / "src"
    write(
        sources,
        {
            "arm_tools/package.xml": MANIFEST.format(
                name="arm_tools", needs="<depend>arm_msgs</depend>"
            ),
            "arm_tools/setup.py": "",
            "arm_tools/src/arm_tools/__init__.py": "import rospy\ndef opened(): return 'opened'\n",
            "arm_tools/launch/speed.launch": "<launch/>",
            "arm_tools/config/arm.yaml": "arm:\n  height: 0.4\n",
            "arm_msgs/package.xml": MANIFEST.format(name="arm_msgs", needs=""),
            "arm_msgs/msg/Grip.msg": "float64 width\n",
            "arm_msgs/action/Move.action": "float64 to\n---\nbool done\n---\n",
        },
    )
    devel = Prefix(under / "devel", ros=1)
    (devel.path / ".catkin").write_text(str(sources))
    site = devel.python(
        {"arm_tools/__init__.py": "raise ImportError('relay')\n", "arm_msgs/__init__.py": ""},
        "lib/python3/dist-packages",
    )
    launch = LAUNCH_1.replace("<include", '<arg name="speed" default="0.25"/>\n  <include', 1)
    write(
        example.folder / "ws/src/pick",
        {
            "package.xml": MANIFEST.format(name="pick", needs="<depend>arm_tools</depend>"),
            "go.py": ROS_1,
            "launch/go.launch": launch,
        },
    )
    variables = {
        "CMAKE_PREFIX_PATH": str(devel.path),
        "ROS_PACKAGE_PATH": str(sources),
        "PYTHONPATH": site,
    }
    done = example.run("trace", "ws/src/pick/go.py", environment=variables)
    assert f"path {sources / 'arm_msgs'} {sources / 'arm_tools'}\n" in done.out + done.err
    assert "grip 0.02 True opened\nneeds ['arm_msgs'] 0.25\nheight 0.4\n" in done.out + done.err


def described(prefix, package="feeder_description"):
    """Install the macros of an arm, its description, and a MoveIt package with its groups."""
    joints = "".join(
        f'<link name="link{n}"><inertial><mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" '
        f'izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="feeder_j{n}" type="revolute"><parent link="link{n - 1}"/>'
        f'<child link="link{n}"/><origin xyz="{" ".join(map(str, xyz))}" '
        f'rpy="{" ".join(map(str, rpy))}"/><axis xyz="{" ".join(map(str, axis))}"/>'
        '<limit lower="-2.5" upper="2.5" effort="40" velocity="2"/></joint>'
        for n, (xyz, rpy, axis) in enumerate(CHAIN, 1)
    )
    prefix.install(
        "feeder_macros",
        {
            "urdf/parts.xacro": f'<robot {XACRO}><xacro:macro name="arm">{joints}</xacro:macro></robot>'
        },
    )
    prefix.install(
        package,
        {
            "urdf/feeder.urdf.xacro": f'<robot {XACRO} name="feeder">'
            '<xacro:include filename="$(find feeder_macros)/urdf/parts.xacro"/>'
            '<link name="link0"/><xacro:arm/></robot>'
        },
        needs=("feeder_macros",),
    )
    prefix.install(
        "feeder_moveit_config",
        {
            "config/feeder.srdf": '<robot name="feeder"><group name="feeder_arm">'
            '<chain base_link="link0" tip_link="link7"/></group>'
            '<group_state name="up" group="feeder_arm"><joint name="feeder_j2" value="0.4"/>'
            "</group_state></robot>",
            "config/kinematics.yaml": "feeder_arm:\n  kinematics_solver: kdl\n",
            "config/joint_limits.yaml": "default_velocity_scaling_factor: 0.5\n",
        },
        needs=(package,),
    )


MOVE = """\
import sys
import moveit_commander, rospy

def up(arm):
    arm.set_named_target("up")
    arm.go(wait=True)

rospy.init_node("feed")
moveit_commander.roscpp_initialize(sys.argv)
up(moveit_commander.MoveGroupCommander("feeder_arm"))
"""


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("needs", ["feeder_moveit_config", "feeder_description"])
def test_the_robot_of_an_installed_package_is_taken_and_its_files_count(
    example, tmp_path_factory, needs
):
    opt = Prefix(tmp_path_factory.mktemp("opt") / "noetic", ros=1)
    described(opt)
    manifest = MANIFEST.format(name="feed", needs=f"<depend>{needs}</depend>")
    example.write("package.xml", manifest)
    source = MOVE
    if needs == "feeder_description":
        # No group without the SRDF: its joints are named.
        source = MOVE.replace(
            'arm.set_named_target("up")', 'arm.set_joint_value_target({"feeder_j2": 0.4})'
        ).replace('"feeder_arm"', '"manipulator"')
    example.write("feed.py", source)
    variables = {"CMAKE_PREFIX_PATH": str(opt.path), "ROS_PACKAGE_PATH": str(opt.path / "share")}
    done = example.run("run", "feed.py", "--json", "--trace", "trace.json", environment=variables)
    trace = json.loads(example.read("trace.json"))
    trace = trace.get("trace", trace)
    assert trace["robot"] == "feeder", done.err
    wanted = {"feeder.urdf.xacro", "parts.xacro"}
    assert wanted <= {Path(each).name for each in trace["inputs"]}
    assert any(
        f"; installed in {opt.path} (CMAKE_PREFIX_PATH)" in line for line in trace["assumptions"]
    )
    if needs != "feeder_moveit_config":
        return
    assert example.run("check", "feed.py", environment=variables).code == 0
    macros = opt.path / "share/feeder_macros/urdf/parts.xacro"
    macros.write_text(macros.read_text().replace('effort="40"', 'effort="41"'))
    stale = example.run("check", "feed.py", environment=variables)
    assert stale.code == 1
    assert "parts.xacro has changed" in stale.out
    # A machine that checks needs no ROS: what it does not have cannot be compared there.
    opt.path.rename(opt.path.with_name("elsewhere"))
    assert example.run("check", "feed.py").code == 0


def test_a_name_given_to_moveit_configs_builder_finds_the_installed_package(example, overlay):
    described(overlay)
    example.write(
        "feed.py",
        "import rclpy\n"
        "from moveit_configs_utils import MoveItConfigsBuilder\n"
        "rclpy.init()\n"
        'found = MoveItConfigsBuilder("feeder").to_dict()\n'
        'print("solver", found["robot_description_kinematics"]["feeder_arm"])\n'
        'print("srdf", "feeder_arm" in found["robot_description_semantic"])\n',
    )
    done = example.run("trace", "feed.py", environment=sourced(overlay))
    assert "solver {'kinematics_solver': 'kdl'}\nsrdf True\n" in done.out + done.err
    assert "feed.py on feeder in scene" in done.out + done.err


LAUNCH_2 = """\
from arm_launch.parts import speed_of
from launch import LaunchDescription
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

def generate_launch_description():
    file = PathJoinSubstitution([FindPackageShare("arm_bringup"), "config", "go.yaml"])
    return LaunchDescription(
        [Node(package="pick", executable="go.py", parameters=[file, {"speed": speed_of("slow")}])]
    )
"""
GO = """\
import rclpy
from rclpy.node import Node

rclpy.init()
node = Node("go", automatically_declare_parameters_from_overrides=True)
for name in ("speed", "height"):
    if node.has_parameter(name):
        print("given", name, node.get_parameter(name).value)
"""


def test_launch_files_use_parameter_files_and_modules_of_installed_packages(example, overlay):
    overlay.install("arm_bringup", {"config/go.yaml": "go:\n  ros__parameters: {height: 0.3}\n"})
    overlay.install("arm_launch")
    overlay.python(
        {
            "arm_launch/__init__.py": "",
            "arm_launch/parts.py": "def speed_of(name): return {'slow': 0.1}[name]\n",
        }
    )
    write(
        example.folder,
        {
            "package.xml": MANIFEST.format(name="pick", needs=""),
            "go.py": GO,
            "launch/go.launch.py": LAUNCH_2,
        },
    )
    done = example.run("trace", "go.py", environment=sourced(overlay))
    assert "given speed 0.1\ngiven height 0.3\n" in done.out + done.err
    broken = overlay.path / "lib/python3.10/site-packages/arm_launch/parts.py"
    broken.write_text("import a_compiled_thing\nraise RuntimeError('needs the real one')\n")
    done = example.run("trace", "go.py", environment=sourced(overlay))
    assert "given height 0.3\n" in done.out + done.err
    assert "given speed" not in done.out + done.err


def test_doctor_lists_the_prefixes_and_what_names_each(example, overlay):
    overlay.install("arm_msgs")
    example.write("go.py", "import rclpy\n")
    example.write("pyproject.toml", '[tool.tracerisk]\nros_prefixes = ["under", "gone"]\n')
    under = Prefix(example.folder / "under")
    under.install("arm_description")
    under.install("arm_tools")
    variables = sourced(overlay)
    found = example.run("doctor", "go.py", "--json", environment=variables).json["found"]
    assert found["installed ROS"].startswith(
        f"{under.path} (the setting ros_prefixes): 2 packages; "
        f"{overlay.path} (AMENT_PREFIX_PATH): 1 package"
    )
    assert found["ros_prefixes that are not there"] == str(example.folder / "gone")
    without = example.run("doctor", "--json", environment=variables).json["found"]
    assert without["installed ROS"].startswith(f"{overlay.path} (AMENT_PREFIX_PATH): 1 package")


@pytest.mark.parametrize("has_action", [True, False])
def test_messages_that_ros_1_generated_of_an_action_are_read_where_it_is_not_there(
    overlay, has_action
):
    generated = (
        "# ====== DO NOT MODIFY! AUTOGENERATED FROM AN ACTION DEFINITION ======\nbool done\n"
    )
    share = overlay.install("arm_msgs", {"msg/MoveResult.msg": generated})
    if has_action:
        write(share, {"action/Move.action": "---\nbool done\n---\n"})
    used = []
    interfaces = Interfaces(installed={"arm_msgs": share}, on_used=used.append)
    assert interfaces.message("arm_msgs/MoveResult")(True).done
    assert [path.name for path in used] == ["Move.action" if has_action else "MoveResult.msg"]


def test_a_message_that_is_installed_goes_before_the_shipped_one(example, overlay):
    share = overlay.install("std_msgs", {"msg/Bool.msg": "bool data\nbool is_old\n"})
    (share / "msg/String.msg").write_text("# as it is shipped\nstring data   # a comment\n")
    os.mkfifo(share / "msg/Pipe.msg")
    example.write(
        "go.py",
        "import rclpy\n"
        "from std_msgs.msg import Bool, Header, String\n"
        "rclpy.init()\n"
        "print(Bool(is_old=True), String(data='a'), Header().frame_id == '')\n",
    )
    done = example.run("trace", "go.py", "--json", environment=sourced(overlay))
    assert "is_old=True" in done.out + done.err
    inputs = [Path(each).name for each in done.json["trace"]["inputs"]]
    assert inputs == ["Bool.msg"]
