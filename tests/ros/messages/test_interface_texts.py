"""The definitions that are shipped: each is served, as its source has it.

`data/known_fields.csv` holds fields as the public files have them, read apart from the archive.
"""

import csv
import gzip
import io
import re
from importlib import import_module
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.errors import InputError
from tracerisk.ros.distributions.in_run import DistroRules
from tracerisk.ros.imports.finder import StandInFinder
from tracerisk.ros.messages import interface_texts
from tracerisk.ros.messages.interface_texts import shipped_packages, shipped_texts
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.time.rostime import Duration, Time

ROOT = Path(__file__).parents[3]
DISTROS = ("noetic", "humble", "jazzy")


def interfaces_of(distro):
    return Interfaces() if distro == "noetic" else Interfaces2(rules=DistroRules(distro))


def rows():
    page = (ROOT / "docs" / "interfaces.md").read_text(encoding="utf-8")
    return [
        [cell.strip(" `") for cell in line.strip("|").split("|")]
        for line in page.splitlines()
        if line.startswith("| `")
    ]


def known_fields():
    with (ROOT / "tests/ros/data/known_fields.csv").open(encoding="utf-8", newline="") as stream:
        of: dict[tuple[str, str], list[dict[str, str]]] = {}
        for row in csv.DictReader(stream):
            of.setdefault((row["distribution"], row["interface"]), []).append(row)
    return of


def test_each_package_has_a_row_with_its_source_and_version():
    for column, distro in enumerate(DISTROS, 3):
        assert {row[0] for row in rows() if row[column]} == shipped_packages(distro)
    for _, repository, folder, *versions, licence in rows():
        assert re.fullmatch(r"[\w.-]+/[\w.-]+", repository)
        assert folder
        assert any(versions)
        assert licence
        assert all(re.fullmatch(r"[\d.]+ [0-9a-f]{10}|", version) for version in versions)


def test_a_wheel_has_the_archive_compressed(tmp_path, monkeypatch):
    packed = gzip.compress(interface_texts._ARCHIVE.read_bytes())
    assert len(packed) < 150_000
    (tmp_path / "interfaces.txt.gz").write_bytes(packed)
    monkeypatch.setattr(interface_texts, "_ARCHIVE", tmp_path / "interfaces.txt")
    assert interface_texts._sections.__wrapped__() == interface_texts._sections()


@pytest.mark.parametrize("distro", DISTROS)
def test_definitions_have_no_comments(distro):
    for package in shipped_packages(distro):
        for definitions in shipped_texts(distro, package).values():
            for definition in definitions:
                for line in definition.text.splitlines():
                    assert "#" not in line or line.startswith("string "), (definition, line)


@pytest.mark.parametrize("distro", slow_but(("noetic", "jazzy"), DISTROS))
def test_each_interface_is_imported_made_sent_and_received(distro):
    interfaces = interfaces_of(distro)
    count = 0
    with StandInFinder(interfaces) as finder:
        for package in shipped_packages(distro) & finder.provides.keys():
            for kind in interfaces.kinds:
                names = interfaces.module_names(package, kind)
                module = import_module(f"{package}.{kind}") if names else None
                for name in names:
                    made = getattr(module, name)
                    if hasattr(made, "__slots__"):
                        # What was sent once has the precision of its fields.
                        sent = received(made())
                        assert received(sent) == sent, f"{package}/{name}"
                        count += 1
    assert count > 2000


def received(message):
    """Return what a message is after it was sent."""
    if hasattr(message, "get_fields_and_field_types"):
        from rclpy.serialization import deserialize_message, serialize_message

        return deserialize_message(serialize_message(message), type(message))
    buffer = io.BytesIO()
    message.serialize(buffer)
    return type(message)().deserialize(buffer.getvalue())


@pytest.mark.parametrize(("distro", "interface"), known_fields(), ids=lambda words: words)
def test_fields_are_those_of_the_public_definition(distro, interface):
    package, kind, name = interface.split("/")
    for row in known_fields()[distro, interface]:
        mark = "" if distro == "noetic" or not row["part"] else "_"
        of_action = distro == "noetic" and kind == "action"
        made = interfaces_of(distro).interface(
            package, "msg" if of_action else kind, f"{name}{mark}{row['part']}"
        )
        fields = {
            field.name: field
            for field in getattr(made, "_ros_fields", made.__dict__.get("_fields"))
        }
        base, is_array, _ = row["type"].partition("[")
        base = "std_msgs/Header" if base == "Header" else base.partition("<")[0]
        found = fields[row["field"]]
        assert found.base.removeprefix(f"{package}/") == base.removeprefix(f"{package}/"), row
        assert (found.is_array if distro == "noetic" else found.arrangement != "scalar") == bool(
            is_array
        ), row


def test_a_class_follows_the_distribution():
    def fields(distro, kind, name):
        return (
            interfaces_of(distro)
            .interface("controller_manager_msgs", kind, name)
            ._fields_and_field_types
        )

    older = {"start_controllers", "stop_controllers", "start_asap"}
    assert older <= fields("humble", "srv", "SwitchController_Request").keys()
    assert not older & fields("jazzy", "srv", "SwitchController_Request").keys()
    assert "message" in fields("jazzy", "srv", "SwitchController_Response")
    assert "message" not in fields("humble", "srv", "SwitchController_Response")
    assert "update_rate" in fields("jazzy", "msg", "ControllerState")
    assert "update_rate" not in fields("humble", "msg", "ControllerState")


def test_an_interface_that_only_the_other_distribution_has_is_served():
    assert interfaces_of("humble").message("moveit_msgs/ServoStatus")()
    assert interfaces_of("jazzy").service("moveit_msgs/ChangeDriftDimensions")
    assert "service_msgs" in interfaces_of("humble").packages
    with pytest.raises(InputError, match="no message package 'service_msgs'"):
        interfaces_of("noetic").message("service_msgs/ServiceEventInfo")


@pytest.mark.parametrize("distro", DISTROS)
@pytest.mark.parametrize(
    ("package", "name", "near"),
    [
        ("geometry_msgs", "PoseStampd", "PoseStamped"),
        ("industrial_msgs", "RobotState", "RobotStatus"),
        ("moveit_msgs", "RobotTrajectry", "RobotTrajectory"),
    ],
)
def test_an_unknown_name_is_reported_with_the_nearest(distro, package, name, near):
    with pytest.raises(InputError, match=f"{package} has no message '{name}'; .*{near}"):
        interfaces_of(distro).message(f"{package}/{name}")
    with StandInFinder(interfaces_of(distro)), pytest.raises(ImportError, match=near):
        exec(f"from {package}.msg import {name}", {})


@pytest.mark.parametrize("distro", DISTROS)
def test_the_workspace_comes_before_what_is_shipped(distro, tmp_path):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Pose.msg").write_text("float64 reach\n")
    own = {"geometry_msgs": tmp_path}
    known = Interfaces(own) if distro == "noetic" else Interfaces2(own, rules=DistroRules(distro))
    assert known.message_names("geometry_msgs") == ("Pose",)
    assert known.message("geometry_msgs/Pose")().reach == 0.0


SAME = "# A pose\n\nHeader   header  # when\ngeometry_msgs/Pose pose\n"


@pytest.mark.parametrize(
    ("text", "is_used"),
    [
        (SAME, False),
        ("std_msgs/Header header\nPose pose\n", False),
        (f"{SAME}float64 reach\n", True),
        ("Header header\nPose[] pose\n", True),
        (f"{SAME}uint8 FREE=1\n", True),
    ],
)
@pytest.mark.parametrize("distro", DISTROS)
def test_an_installed_definition_counts_where_it_says_something_else(
    distro, tmp_path, text, is_used
):
    (tmp_path / "msg").mkdir()
    path = tmp_path / "msg" / "PoseStamped.msg"
    path.write_text(text)
    there, used = {"geometry_msgs": tmp_path}, []
    if distro == "noetic":
        known = Interfaces(installed=there, on_used=used.append)
    else:
        known = Interfaces2(rules=DistroRules(distro), installed=there, on_used=used.append)
    assert known.message("geometry_msgs/PoseStamped")().pose is not None
    assert used == ([path] if is_used else [])
    assert "Twist" in known.message_names("geometry_msgs")


@pytest.mark.parametrize(
    ("line", "value"),
    [
        ("uint8 modeIdle=3", 3),
        ("int32 SIZE_640x480 = -4  # pixels", -4),
        ("string ok=It's #1", "It's #1"),
        ("float32 Half=0.5", 0.5),
    ],
)
def test_constants_of_ros_1_have_small_letters(tmp_path, line, value):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Mode.msg").write_text(f"uint8 FIRST=1\n{line}\nuint8 mode\n")
    made = Interfaces({"arm_msgs": tmp_path}).message("arm_msgs/Mode")
    name = re.split(r"[\s=]+", line)[1]
    assert (made.FIRST, getattr(made, name), made().mode) == (1, value, 0)


@pytest.mark.parametrize("kind", ["time[]", "duration[]", "time[2]", "duration[2]"])
def test_arrays_of_times_are_received(tmp_path, kind):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Stamps.msg").write_text(f"{kind} stamps\n")
    made = Interfaces({"arm_msgs": tmp_path}).message("arm_msgs/Stamps")
    one = Time(3, 20) if kind.startswith("time") else Duration(-1, 5)
    assert received(made([one, one])).stamps == [one, one]


@pytest.mark.parametrize(
    ("default", "value"),
    [("SYSTEM", "SYSTEM"), (".", "."), ("base link", "base link"), ("'tool'", "tool")],
)
def test_a_default_text_of_ros_2_needs_no_quotes(tmp_path, default, value):
    (tmp_path / "msg").mkdir()
    (tmp_path / "msg" / "Report.msg").write_text(f"string<=20 kind {default}  # which\n")
    assert Interfaces2({"arm_msgs": tmp_path}).message("arm_msgs/Report")().kind == value


def test_fields_have_the_defaults_that_their_definition_gives():
    request = interfaces_of("humble").service("xarm_msgs/MoveJoint").Request()
    assert (request.wait, request.timeout, request.radius) == (False, -1.0, -1.0)


@pytest.mark.parametrize("line", ["---", "-----", "---  # the answer", "  --- "])
def test_a_line_that_begins_with_three_dashes_parts_a_definition(tmp_path, line):
    """xArm-Developer/xarm_ros xarm_msgs/srv/PlayTraj.srv has five."""
    service = tmp_path / "srv" / "PlayTraj.srv"
    service.parent.mkdir()
    service.write_text(f"string traj_file\n\n{line}\n\nint16 ret\nstring message")
    interfaces = Interfaces(workspace={"xarm_msgs": tmp_path})
    kind = interfaces.interface("xarm_msgs", "srv", "PlayTraj")
    assert kind._request_class().__slots__ == ["traj_file"]
    assert kind._response_class().__slots__ == ["ret", "message"]
