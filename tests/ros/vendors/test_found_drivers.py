"""Where descriptions come from, and what is told of bad ones."""

import json
import textwrap
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.cli import main
from tracerisk.config import Settings
from tracerisk.errors import DriverError
from tracerisk.pipeline.workspace.driver_files import check_driver, driver_files
from tracerisk.pipeline.workspace.project import Project
from tracerisk.ros.vendors.description_reader import read_driver

SRV = "float64[] q\nbool fast\n---\nbool success\nstring message\n"
DRIVER = """\
driver: arm
services:
  go: {type: arm_msgs/Go, move: {joints: q}}
"""
PROGRAM = """\
import rospy
from arm_msgs.srv import Go
rospy.init_node("cell")
rospy.wait_for_service("/go", timeout=5.0)

def go():
    done = rospy.ServiceProxy("/go", Go)([0.5, 0, 0, 0, 0, 0], True)
    assert done.success, done

go()
"""
WITHIN = (
    f"definitions:\n  arm_msgs/srv/Go: |\n{textwrap.indent(SRV, '    ')}"
    "  arm_msgs/srv/Look: |\n    ---\n    float64 q\n"
)


@pytest.fixture
def cell(example):
    example.write("pyproject.toml", "[tool.tracerisk]\nrobot = 'ur5e'\n")
    example.write("cell.py", PROGRAM)
    return example


def assert_runs(outcome):
    assert outcome.code == 0, outcome.err
    assert "1 go (line 6, 1 visit)" in outcome.out


def test_a_file_beside_the_controller_with_its_messages_in_it(cell):
    cell.write("arm.driver.yaml", DRIVER + WITHIN)
    assert_runs(cell.run("trace", "cell.py"))


@pytest.mark.slow
def test_an_option_or_a_setting_names_a_file_of_any_name(cell):
    cell.write("elsewhere/arm.yaml", DRIVER + WITHIN)
    assert cell.run("trace", "cell.py").code == 2
    assert_runs(cell.run("trace", "cell.py", "--driver", "elsewhere/arm.yaml"))
    cell.write(
        "pyproject.toml", '[tool.tracerisk]\nrobot = "ur5e"\ndrivers = ["elsewhere/arm.yaml"]\n'
    )
    assert_runs(cell.run("trace", "cell.py"))


def test_an_installed_package_brings_descriptions_by_its_entry_point(cell, monkeypatch, capsys):
    cell.write("site/arm_tracerisk/arm.driver.yaml", DRIVER + WITHIN)
    cell.write("site/arm_tracerisk/__init__.py", "")
    cell.write(
        "site/arm-1.0.dist-info/METADATA", "Metadata-Version: 2.1\nName: arm\nVersion: 1.0\n"
    )
    points = "[tracerisk.drivers]\narm = arm_tracerisk\n"
    cell.write("site/arm-1.0.dist-info/entry_points.txt", points)
    path = {"PYTHONPATH": str(cell.folder / "site")}
    # Found by its entry point alone: the workspace has it out of reach.
    (cell.folder / "work").mkdir()
    for name in ("cell.py", "pyproject.toml"):
        (cell.folder / name).rename(cell.folder / "work" / name)
    assert_runs(cell.run("trace", "work/cell.py", environment=path))
    monkeypatch.syspath_prepend(cell.folder / "site")
    assert main(["drivers", "list", "--json"]) == 0
    listed = json.loads(capsys.readouterr().out)["drivers"]
    assert ("arm", "installed") in [(each["name"], each["origin"]) for each in listed]
    cell.write("site/arm-1.0.dist-info/entry_points.txt", points.replace("= arm", "= amr"))
    # What is installed is looked for once for each list of places.
    monkeypatch.syspath_prepend(cell.folder)
    assert main(["drivers", "list"]) == 2
    expected = "entry point 'arm' of tracerisk.drivers names 'amr_tracerisk'"
    assert expected in " ".join(capsys.readouterr().err.split())


def test_a_user_s_description_goes_before_the_shipped_one(cell):
    cell.write(
        "mine.driver.yaml",
        "driver: mine\nservices:\n  set_io: {type: ur_msgs/SetIO, refuse: the relay is broken}\n",
    )
    cell.write(
        "cell.py",
        "import rospy\nfrom ur_msgs.srv import SetIO\nrospy.init_node('io')\n"
        "rospy.wait_for_service('/box/set_io')\n"
        "assert not rospy.ServiceProxy('/box/set_io', SetIO)().success\n",
    )
    ran = cell.run("trace", "cell.py")
    assert "set_io: the relay is broken" in ran.out + ran.err


def test_a_changed_description_makes_a_run_stale(cell):
    cell.write("arm.driver.yaml", DRIVER + WITHIN)
    ran = cell.run("run", "cell.py")
    assert ran.code == 0, ran.err
    assert cell.run("check", "cell.py").code == 0
    cell.write("arm.driver.yaml", DRIVER.replace("joints: q", "joints: q, speed: 0.1") + WITHIN)
    checked = cell.run("check", "cell.py")
    assert checked.code == 1
    assert "arm.driver.yaml" in checked.out


WRONG = {
    "a field that is not there": (
        ("joints: q", "joints: angles"),
        "arm.driver.yaml:3:34: services.go.move.joints: arm_msgs/GoRequest has no field 'angles'",
    ),
    "an answer that does not fit": (
        ("move: {joints: q}", "move: {joints: q}, response: {success: $succes}"),
        "arm.driver.yaml:3:57: services.go.response.success: '$succes' is not known; did you mean",
    ),
    "a text for a number": (
        ("}\n", "}\n  at: {type: arm_msgs/Look, response: {q: lost}}\n"),
        "arm.driver.yaml:4:40: services.at.response.q: 'lost' is not a number, and 'q' is float64",
    ),
    "a type that is not there": (
        ("arm_msgs/Go", "arm_msgs/Gone"),
        "arm.driver.yaml:3:7: services.go: arm_msgs has no service 'Gone'; did you mean 'Go'?",
    ),
    "a package that is not there": (
        ("arm_msgs/Go, ", "leg_msgs/Go, "),
        "arm.driver.yaml:3:7: services.go: no message package 'leg_msgs'",
    ),
    "two targets": (
        ("joints: q", "joints: q, pose: q"),
        "services.go.move.pose: stands beside 'joints'; one target is allowed",
    ),
    "no target": (("joints: q", "speed: q"), "services.go.move: it has no target; give one of:"),
    "an unknown unit": (
        ("joints: q", "joints: {field: q, unit: grad}"),
        "services.go.move.joints.unit: unknown unit 'grad'; did you mean 'rad'?",
    ),
    "a bad definition": (
        ("float64[] q", "float46[] q"),
        "services.go: field 'q' of arm_msgs/GoRequest: arm_msgs has no message 'float46'",
    ),
}


IN_RUNS = ("a text for a number", "a package that is not there")
"""Mistakes that are looked at in a whole run each time; the first is found in a run alone."""


@pytest.mark.parametrize("case", sorted(set(WRONG) - {IN_RUNS[0]}))
def test_a_mistake_is_found_with_its_place(example, case):
    (old, new), reported = WRONG[case]
    example.write("arm.driver.yaml", (DRIVER + WITHIN).replace(old, new, 1))
    with pytest.raises(DriverError) as caught:
        check_driver(example.folder / "arm.driver.yaml")
    assert reported in str(caught.value).replace("Go_Request", "GoRequest")


@pytest.mark.parametrize("case", slow_but(IN_RUNS, list(WRONG)))
def test_a_mistake_is_reported_with_its_place(cell, case):
    (old, new), reported = WRONG[case]
    text = DRIVER + WITHIN
    assert old in text
    cell.write("arm.driver.yaml", text.replace(old, new, 1))
    ran = cell.run("trace", "cell.py")
    assert ran.code == 2, ran.err
    assert reported in ran.err
    assert "Traceback" not in ran.err


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "expected a mapping at the top, found nothing"),
        ("driver: arm\n", "it serves nothing; describe some"),
        ("- a\n", "expected a mapping at the top, found a list"),
        ("driver: [\n", "is not valid YAML"),
        ("driver: arm\nservices: {go: {type: a}}\n", "'a' is not a type"),
        ("driver: arm\nservices: {go: {type: Go}}\n", "'Go' has no package"),
        ("driver: arm\nstate: {joints: 1}\nservices: {}\n", "is a name that answers have already"),
        ("driver: arm\nunits: {angle: grad}\nparameters: {}\n", "'grad' is not known"),
        ("driver: arm\ngripper: {closed: 1}\nparameters: {}\n", "is 1 as 'closed'"),
        ("driver: " + "x" * 17_000_000, "no larger file is read"),
        (
            "driver: arm\nactions: {go: {type: a/Go, timeout: 1}}\n",
            "the goal of an action ends with its motion",
        ),
        (
            "driver: arm\nsubscribed_topics: {go: {type: a/Go, wait: true}}\n",
            "a message on a topic gets no answer",
        ),
        (
            "driver: arm\nservices: {go: {type: a/Go, stop: true, cases: [{}]}}\n",
            "stands beside 'cases'",
        ),
        (
            "driver: arm\nservices: {go: {type: a/Go, set: {mode: x}}}\n",
            "is not in 'state'",
        ),
        ("driver: arm\ndefinitions: {a: b}\nparameters: {}\n", "is not an interface"),
    ],
)
def test_what_is_no_description_is_reported(tmp_path, text, expected):
    path = tmp_path / "arm.driver.yaml"
    path.write_text(text)
    with pytest.raises(DriverError, match=r"arm\.driver\.yaml:(\d+| cannot be read)") as caught:
        read_driver(path)
    assert expected in str(caught.value)


def test_lines_may_end_as_on_windows(tmp_path):
    path = tmp_path / "arm.driver.yaml"
    path.write_bytes(DRIVER.replace("\n", "\r\n").encode("utf-8-sig"))
    assert read_driver(path).interfaces[0].name == "go"


def test_a_frame_of_the_driver_is_where_its_link_is(cell):
    cell.write("arm.driver.yaml", DRIVER + WITHIN + "frames: {flange_of_arm: tool0, lost: tool9}\n")
    cell.write(
        "cell.py",
        PROGRAM
        + """
import tf2_ros
buffer = tf2_ros.Buffer()
listener = tf2_ros.TransformListener(buffer)
rospy.sleep(0.5)
names = [buffer.lookup_transform("base_link", name, rospy.Time(0)).transform.translation
         for name in ("flange_of_arm", "tool0")]
assert names[0] == names[1], names
assert not buffer.can_transform("base_link", "lost", rospy.Time(0))
""",
    )
    ran = cell.run("trace", "cell.py")
    assert "Traceback" not in ran.err, ran.err
    assert ran.code == 0


def test_a_checkout_of_tracerisk_brings_no_description_twice():
    assert driver_files(Project(Path(__file__).parents[3]), Settings()) == ()
