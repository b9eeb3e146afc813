import importlib
import importlib.util
import subprocess
import sys
import types
from collections import Counter

import pytest

from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.imports.installed_libraries import InstalledLibraries
from tracerisk.ros.imports.vendor_libraries import distributions
from tracerisk.ros.messages.ros1 import Interfaces


@pytest.fixture
def finder():
    with StandInFinder() as installed:
        yield installed


def test_message_packages_are_imported_as_if_installed(finder):
    from geometry_msgs.msg import Pose
    from moveit_msgs.srv import GetPositionIK, GetPositionIKRequest

    assert Pose()._type == "geometry_msgs/Pose"
    assert GetPositionIK._request_class is GetPositionIKRequest


def test_generated_modules_can_be_imported_too(finder):
    from geometry_msgs.msg import Pose
    from geometry_msgs.msg._Pose import Pose as SamePose

    assert SamePose is Pose
    assert Pose.__module__ == "geometry_msgs.msg._Pose"


def test_a_star_import_brings_every_message(finder):
    names: dict[str, object] = {}
    exec("from control_msgs.msg import *", names)
    assert {"FollowJointTrajectoryAction", "FollowJointTrajectoryGoal", "JointJog"} <= set(names)


def test_a_star_import_asks_for_a_class_twice_at_most():
    asked: Counter[str] = Counter()

    class Counting(Interfaces):
        def interface(self, package, kind, name):
            asked[name] += 1
            return super().interface(package, kind, name)

    with StandInFinder(Counting()):
        exec("from control_msgs.msg import *", {})
    # For the names of the modules that it brings, and for its own.
    assert max(asked.values()) == 2


def test_dir_lists_the_messages_without_making_them(finder):
    import moveit_msgs.msg

    assert "PlanningScene" in dir(moveit_msgs.msg)
    assert "PlanningScene" not in vars(moveit_msgs.msg)


def test_genpy_is_served_with_the_classes_that_messages_use(finder):
    import genpy
    from std_msgs.msg import Header

    assert type(Header().stamp) is genpy.Time
    assert isinstance(Header(), genpy.Message)
    from genpy.message import get_message_class, get_service_class

    assert get_message_class("std_msgs/Header") is Header
    assert get_message_class("Header") is Header
    assert get_message_class("time") is genpy.Time
    assert get_message_class("foo_msgs/Foo") is None
    assert get_service_class("std_srvs/Empty")._type == "std_srvs/Empty"


@pytest.mark.parametrize(
    ("statement", "kind"),
    [
        ("import genpy; genpy.Tine", AttributeError),
        ("from genpy import Tine", ImportError),
        ("from genpy.rostime import Tine", ImportError),
    ],
)
def test_a_name_that_a_library_lacks_is_reported_with_the_nearest(finder, statement, kind):
    with pytest.raises(
        kind, match=r"genpy(\.rostime)? has no 'Tine' in tracerisk's stand-in for it; nearest: Time"
    ):
        exec(statement, {})


@pytest.mark.parametrize(
    ("statement", "kind"),
    [
        ("import geometry_msgs.msg; geometry_msgs.msg.Posee", AttributeError),
        ("from geometry_msgs.msg import Posee", ImportError),
    ],
)
def test_a_message_that_a_package_lacks_is_reported_with_the_nearest(finder, statement, kind):
    with pytest.raises(kind, match=r"geometry_msgs\.msg has no 'Posee'.*nearest: Pose"):
        exec(statement, {})


def test_asking_whether_a_library_has_a_name_raises_nothing(finder):
    import genpy

    assert not hasattr(genpy, "nope")
    assert getattr(genpy, "nope", 3) == 3


def test_a_submodule_that_a_library_lacks_is_not_found(finder):
    with pytest.raises(ModuleNotFoundError, match="genpy has no 'nope'"):
        importlib.import_module("genpy.nope")


def test_an_unknown_ros_package_is_reported_with_what_to_do(finder):
    with pytest.raises(ModuleNotFoundError) as raised:
        importlib.import_module("geometri_msgs")
    assert raised.value.name == "geometri_msgs"
    assert "did you mean 'geometry_msgs'?" in str(raised.value)
    assert "neither found in the controller's workspace nor served by tracerisk" in str(
        raised.value
    )
    assert "put its definitions into the workspace" in str(raised.value)
    assert len(str(raised.value)) < 250


@pytest.mark.parametrize(
    ("name", "repository"),
    [
        ("intera_external_devices", "RethinkRobotics/intera_sdk"),
        ("niryo_robot_python_ros_wrapper", "NiryoRobotics/ned_ros"),
        ("arc_utilities", "UM-ARM-Lab/arc_utilities"),
        ("simulation_and_control", "VModugno/simulation_and_control"),
    ],
)
def test_a_missing_library_of_a_repository_alone_is_reported_with_that(finder, name, repository):
    with pytest.raises(ModuleNotFoundError, match=f"https://github.com/{repository}; clone it"):
        importlib.import_module(name)


def test_libraries_of_robots_name_their_distribution_on_the_package_index():
    assert distributions()["modern_robotics"] == "modern_robotics"


def test_a_missing_library_that_needs_hardware_is_reported_so(finder):
    with pytest.raises(ModuleNotFoundError) as raised:
        importlib.import_module("pymycobot")
    assert str(raised.value) == (
        "No module named 'pymycobot': it speaks to the robot on a serial port, past ROS, and "
        "tracerisk simulates robots behind ROS only; command the arm through its ROS driver"
    )


def test_a_vendors_stand_in_gives_way_to_an_installed_library(finder, tmp_path, monkeypatch):
    package = tmp_path / "interbotix_xs_modules"
    package.mkdir()
    (package / "__init__.py").write_text("REAL = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    real = importlib.import_module("interbotix_xs_modules")
    assert real.REAL
    with pytest.raises(ModuleNotFoundError, match=r"^No module named 'interbotix_xs_modules.arm'$"):
        importlib.import_module("interbotix_xs_modules.arm")
    del sys.modules["interbotix_xs_modules"]


def test_a_copy_in_a_prefix_goes_before_the_release_of_the_package_index(tmp_path):
    package = tmp_path / "pymoveit2"
    package.mkdir()
    (package / "__init__.py").write_text("")
    spec = InstalledLibraries([tmp_path]).find_spec("pymoveit2")
    assert spec is not None
    assert spec.origin == str(package / "__init__.py")


def test_other_unknown_modules_are_left_to_python(finder):
    with pytest.raises(ModuleNotFoundError, match=r"^No module named 'frobnicate'$"):
        importlib.import_module("frobnicate")


def test_a_ros_like_module_of_the_controllers_own_is_found_first(finder, tmp_path, monkeypatch):
    (tmp_path / "my_robot_msgs.py").write_text("MINE = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    assert importlib.import_module("my_robot_msgs").MINE
    del sys.modules["my_robot_msgs"]


def test_stand_ins_win_over_installed_modules_and_give_them_back(tmp_path, monkeypatch):
    (tmp_path / "std_msgs").mkdir()
    (tmp_path / "std_msgs" / "__init__.py").write_text("REAL = True\n")
    monkeypatch.syspath_prepend(tmp_path)
    real = importlib.import_module("std_msgs")
    with StandInFinder():
        assert not hasattr(importlib.import_module("std_msgs"), "REAL")
        assert importlib.import_module("std_msgs.msg").String().data == ""
    assert sys.modules["std_msgs"] is real
    assert "std_msgs.msg" not in sys.modules
    del sys.modules["std_msgs"]


def test_leaving_takes_everything_out_again():
    before = set(sys.modules)
    path = list(sys.meta_path)
    with StandInFinder():
        importlib.import_module("moveit_msgs.msg")
        importlib.import_module("genpy")
    assert sys.meta_path == path
    served = {"moveit_msgs", "moveit_msgs.msg", "genpy", "genpy.message"}
    assert not served & (set(sys.modules) - before)


def test_two_finders_in_turn_serve_the_same_names():
    for _ in range(2):
        with StandInFinder():
            assert importlib.import_module("std_msgs.msg").Int32(3).data == 3


def test_the_table_says_libraries_from_interfaces():
    table = StandInFinder().provides
    assert table["genpy"] == "library"
    assert table["moveit_commander"] == "library"
    assert table["geometry_msgs"] == "interfaces"
    assert list(table) == sorted(table)


def test_every_library_in_the_table_can_be_found():
    with StandInFinder() as finder:
        for name in finder.provides:
            assert importlib.util.find_spec(name) is not None


def test_packages_used_for_their_code_are_not_served_by_their_messages_alone():
    finder = StandInFinder()
    assert "bond" in finder.interfaces.packages
    assert "bond" not in finder.provides
    assert finder.provides["dynamic_reconfigure"] == "library and interfaces"


def test_messages_of_the_workspace_are_served(tmp_path):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Grip.msg").write_text("uint8 CLOSE=1\nuint8 command\n")
    with StandInFinder(Interfaces({"my_msgs": tmp_path})):
        grip = importlib.import_module("my_msgs.msg").Grip
        assert grip(grip.CLOSE).command == 1


def test_tracebacks_and_reprs_show_the_librarys_name(finder):
    genpy = importlib.import_module("genpy")
    assert isinstance(genpy, types.ModuleType)
    assert genpy.__name__ == "genpy"


def test_installing_brings_no_simulator():
    code = (
        "import sys; from tracerisk.ros.imports.finder import StandInFinder; StandInFinder().install();"
        "import geometry_msgs.msg; geometry_msgs.msg.Pose();"
        "sys.exit(bool({'mujoco', 'dm_control', 'libcst', 'numpy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_modules_of_a_message_package_are_there_when_they_are_read(finder):
    import trajectory_msgs

    assert trajectory_msgs.msg.JointTrajectory.__name__ == "JointTrajectory"
    with pytest.raises(AttributeError, match="trajectory_msgs has no 'srv'"):
        trajectory_msgs.srv  # noqa: B018


def test_modules_of_a_library_are_there_when_they_are_read(finder):
    import tf2_ros

    assert tf2_ros.buffer.Buffer is tf2_ros.Buffer
    import rospy

    assert not hasattr(rospy, "node")


def test_a_controller_that_starts_the_probe_runs_as_without_it(finder):
    probe = importlib.import_module("tracerisk_probe")
    assert "stand_ins" in probe.__file__
    assert probe.start(out="commands.jsonl", publish=False) is None
    assert probe.watch(len, "len") is len
