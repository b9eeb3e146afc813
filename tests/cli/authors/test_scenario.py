"""`tracerisk scenario`: what it lists, and that what it writes runs as it stands."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import pytest

from tracerisk.cli.authors.scenario import grasp_width_m
from tracerisk.common.traced.findings import Finding
from tracerisk.errors import Location
from tracerisk.pipeline.scenarios.entries import merged

HEAD = """\
import sys
import actionlib, moveit_commander, rospy, tf2_ros
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import String
from std_srvs.srv import Trigger, TriggerResponse

rospy.init_node("picker")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
arm.set_max_acceleration_scaling_factor(1.0)


def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] += angle
    arm.go(joints, wait=True)
"""
ALL = (
    HEAD
    + """

def reach(pose):
    arm.set_pose_target(pose)
    if not arm.go(wait=True):
        rospy.logerr("out of reach")


def main():
    angle = rospy.get_param("~angle") * 0.2
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    buffer.lookup_transform("world", "marker", rospy.Time(0), rospy.Duration(2.0))
    rospy.wait_for_service("detect")
    if not rospy.ServiceProxy("detect", Trigger)().success:
        return
    reach(rospy.wait_for_message("/object", PoseStamped))
    if input("Side? ") == "left":
        turn(angle)


main()
"""
)


SENDER = """\
import rospy
from geometry_msgs.msg import PoseStamped

pub = rospy.Publisher("/part", PoseStamped, queue_size=1)
part = PoseStamped()
part.pose.position.z = 0.3
pub.publish(part)
"""


def reasons(outcome) -> list[tuple[str, str]]:
    return [(each["code"], each["object"]) for each in outcome.json["verdict"]["reasons"]]


def test_what_is_written_runs_as_it_stands_and_is_partial_until_the_marks_are_gone(example):
    example.write("c.py", ALL)
    outcome = example.run("scenario", "c.py", "--write")
    assert outcome.code == 0, outcome.err
    assert (
        "messages on /object (geometry_msgs/PoseStamped), c.py:33: a pose that panda" in outcome.out
    )
    assert "an answer to 'Side?', c.py:34: as the code compares the answer" in outcome.out
    assert b"RiskAnnotation" not in example.read("c.py")
    given = ("run", "c.py", "--json", "--check", "--scenario", "c.scenario.yaml")
    ran = example.run(*given)
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    assert reasons(ran) == [
        ("input-assumed", name) for name in ("~angle", "/object", "/detect", "marker", "answers[1]")
    ]
    place = ran.json["verdict"]["reasons"][1]["location"]
    assert (place["file"], place["line"]) == ("c.scenario.yaml", 4)
    text = example.read("c.scenario.yaml").decode()
    example.write(
        "c.scenario.yaml",
        "".join(f"{line.partition('  # assumed')[0]}\n" for line in text.splitlines()),
    )
    assert example.run(*given).json["verdict"]["kind"] == "complete"


def test_the_same_file_twice_and_a_file_that_lacks_nothing_stays_as_it_is(example):
    example.write("c.py", HEAD + "turn(rospy.wait_for_message('/a', String) and 0.1)\n")
    texts = []
    for name in ("one.yaml", "two.yaml", "one.yaml"):
        assert example.run("scenario", "c.py", "--write", "-o", name).code == 0
        texts.append(example.read(name))
    assert texts[0] == texts[1] == texts[2]
    assert b"- topic: /a  # assumed" in texts[0]


BASE = """\
# The cell of line 4.

answers: ["left"]   # as the operator does
publish:
    # of the camera
    -   {topic: /seen, type: std_msgs/String, message: part}

frames: []
"""


@pytest.mark.parametrize("newline", [pytest.param("\n", marks=pytest.mark.slow), "\r\n"])
def test_what_is_there_is_kept_and_what_lacks_is_added(example, newline):
    example.write(
        "c.py",
        HEAD + "rospy.wait_for_message('/seen', String)\n"
        "rospy.wait_for_message('/more', String)\nrospy.wait_for_service('/ready')\n"
        "rospy.ServiceProxy('/ready', Trigger)()\nprint(input('Side? '))\nturn(0.1)\n",
    )
    example.write("cell.yaml", BASE.replace("\n", newline))
    outcome = example.run(
        "scenario", "c.py", "--scenario", "cell.yaml", "--write", "-o", "cell.yaml"
    )
    assert outcome.code == 0, outcome.err
    text = example.read("cell.yaml").decode()
    kept = BASE.replace("\n", newline).split(f"{newline}frames")[0].rstrip()
    assert text.startswith(kept)
    assert f"{newline}    - topic: /more  # assumed" in text
    assert "services:" in text
    assert text.count("/seen") == 1
    again = example.run("run", "c.py", "--check", "--json", "--scenario", "cell.yaml")
    assert [name for _, name in reasons(again)] == ["/more", "/ready"]


@pytest.mark.slow
def test_what_makes_the_run_worse_is_left_out(example):
    example.write(
        "c.py",
        HEAD + "def on_call(request):\n    turn(0.1)\n    return TriggerResponse(True, '')\n"
        "def on_bad(request):\n    rospy.logerr('never do this')\n    raise RuntimeError('no')\n"
        "turn(0.05)\nrospy.Service('/bad', Trigger, on_bad)\n"
        "rospy.Service('/good', Trigger, on_call)\nrospy.spin()\n",
    )
    outcome = example.run("scenario", "c.py", "--write", "--json")
    assert outcome.code == 0, outcome.err
    assert [each["name"] for each in outcome.json["given"]] == ["/good"]
    assert outcome.json["verdict"]["kind"] == "partial"
    assert b"/bad" not in example.read("c.scenario.yaml")


def test_values_of_the_repository_come_first_unless_they_do_not_fit(example):
    example.write("c.py", HEAD + "rospy.wait_for_message('/a', String)\n"
                  "rospy.wait_for_message('/b', String)\nturn(0.1)\n")  # fmt: skip
    example.write(
        "README.md",
        "rostopic pub /a std_msgs/String \"data: 'of the readme'\"\n"
        'rostopic pub /b std_msgs/String "words: 3"\n',
    )
    outcome = example.run("scenario", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    found = {
        each["name"]: (each["value"]["message"], each["words"]) for each in outcome.json["given"]
    }
    assert found["/a"] == ({"data": "of the readme"}, "as in README.md:1")
    assert found["/b"] == ({"data": ""}, "a value of its type")
    assert not (example.folder / "c.scenario.yaml").exists()


@pytest.mark.slow
@pytest.mark.parametrize("is_written", [False, True])  # the height, by another program
def test_another_pose_is_tried_where_a_motion_fails_at_the_first(example, is_written):
    if is_written:
        example.write("sender.py", SENDER)
    source = HEAD + (
        "pose = rospy.wait_for_message('/part', PoseStamped)\n"
        "arm.set_pose_target(pose)\n%s\nif not arm.go(wait=True):\n    rospy.logerr('lost')\n"
    )
    example.write("c.py", source % "")
    first = example.run("scenario", "c.py", "--json").json
    (place,) = (each["value"]["message"]["pose"]["position"] for each in first["given"])
    beyond = f"if abs(pose.pose.position.x - {place['x']}) < 1e-6:\n    arm.set_position_target([9, 9, 9])"
    example.write("c.py", source % beyond)
    outcome = example.run("scenario", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["verdict"]["kind"] == "partial"
    other = next(
        each["value"]["message"]["pose"]["position"]
        for each in outcome.json["given"]
        if each["name"] == "/part"
    )
    assert other["x"] != place["x"]


@pytest.mark.slow
def test_a_pose_is_moved_until_what_the_code_makes_of_it_is_reached(example):
    example.write(
        "c.py",
        HEAD + "turn(0.1)\npose = rospy.wait_for_message('/part', PoseStamped)\n"
        "for above in (0.1, 0.85):\n    pose.pose.position.z += above\n"
        "    arm.set_pose_target(pose)\n    if not arm.go(wait=True):\n"
        "        rospy.logerr('lost')\n        break\n    pose.pose.position.z -= above\n",
    )
    outcome = example.run("scenario", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["verdict"]["kind"] == "partial"
    (found,) = (each["value"]["message"]["pose"]["position"] for each in outcome.json["given"])
    assert found["z"] < 0.19


@pytest.mark.slow
def test_arguments_that_argparse_demands(example):
    example.write(
        "c.py",
        HEAD + "import argparse\nparser = argparse.ArgumentParser()\n"
        "parser.add_argument('side', choices=['left', 'right'])\n"
        "parser.add_argument('--turns', type=int, required=True)\n"
        "given = parser.parse_args()\nfor _ in range(given.turns):\n    turn(0.1)\n",
    )
    outcome = example.run("scenario", "c.py", "--write")
    assert outcome.code == 0, outcome.err
    assert "arguments left --turns 1: what argparse demands" in outcome.out
    given = ("run", "c.py", "--check", "--json", "--scenario", "c.scenario.yaml")
    assert reasons(example.run(*given)) == [
        ("input-assumed", f"arguments[{number}]") for number in (1, 2, 3)
    ]
    # Those of the command line take their place.
    two = example.run(*given, "--", "right", "--turns", "2").json["trace"]
    assert len(two["visits"]) == 2


@pytest.mark.slow
def test_one_of_several_robots_that_fit(example):
    example.write(
        "c.py",
        "import rclpy\nfrom trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint\n"
        "NAMES = ['shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',\n"
        "         'wrist_2_joint', 'wrist_3_joint']\n"
        "rclpy.init()\nnode = rclpy.create_node('n')\n"
        "pub = node.create_publisher(JointTrajectory, '/arm_controller/joint_trajectory', 1)\n"
        "def move():\n    point = JointTrajectoryPoint(positions=[0.1] * 6)\n"
        "    point.time_from_start.sec = 1\n"
        "    pub.publish(JointTrajectory(joint_names=NAMES, points=[point]))\n"
        "move()\nrclpy.spin_once(node, timeout_sec=3.0)\n",
    )
    ran = example.run("run", "c.py", "--check", "--no-draft", "--json")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    (reason,) = [each for each in ran.json["verdict"]["reasons"] if each["code"] == "robot-assumed"]
    assert "ur10, ur10e, ur16e, ur20, ur3, ur30 would fit as well" in reason["words"]
    assert ran.json["trace"]["robot"] == "ur5e"
    # A scenario that names it makes it no assumption.
    example.write("c.scenario.yaml", "robot: ur10\n")
    other = example.run("trace", "c.py", "--json", "--scenario", "c.scenario.yaml")
    assert other.json["trace"]["robot"] == "ur10"
    assert "robot-assumed" not in {each["code"] for each in other.json["verdict"]["reasons"]}


@pytest.mark.slow
def test_calls_that_wait_come_one_after_the_other(example):
    example.write(
        "c.py",
        HEAD + "def answer(request):\n    turn(0.2)\n    return TriggerResponse(True, '')\n"
        "for name in ('/one', '/two'):\n    rospy.Service(name, Trigger, answer)\nrospy.spin()\n",
    )
    entry = "  - {service: %s, type: std_srvs/Trigger, wait: true}\n"
    example.write("s.yaml", "calls:\n" + entry % "/two" + entry % "/one")
    trace = example.run("trace", "c.py", "--json", "--scenario", "s.yaml").json["trace"]
    one, two = (each for each in trace["visits"] if each["function"]["name"] == "turn")
    # The motion takes half a second, and the robot has rested for another half then.
    assert two["start_s"] >= one["start_s"] + 0.9
    example.write(
        "s.yaml", "calls:\n  - {service: /one, type: std_srvs/Trigger, wait: true, at: 1}\n"
    )
    bad = example.run("trace", "c.py", "--scenario", "s.yaml")
    assert bad.code == 2
    assert "s.yaml:2:" in bad.err
    assert "keep one of at and wait" in bad.err


def test_what_nothing_helps_is_reported_with_what_was_found(example):
    example.write("c.py", HEAD + "import pymycobot\n")
    outcome = example.run("scenario", "c.py", "--write")
    assert outcome.code == 2
    assert "No module named 'pymycobot'" in outcome.err
    assert outcome.err.count("tracerisk:") == 1


@pytest.mark.slow
def test_a_limit_of_the_machine_ends_the_search(example):
    example.write(
        "c.py", HEAD + "rospy.wait_for_message('/a', String)\nfor _ in iter(int, 1): pass\n"
    )
    outcome = example.run("scenario", "c.py", "--write", "--json", "--stall-limit", "3")
    assert outcome.code == 4
    assert outcome.json["end"]["cause"] == "wall_limit"
    assert [each["name"] for each in outcome.json["given"]] == ["/a"]


def test_a_search_that_takes_too_long_gives_the_best_so_far(example):
    example.write("c.py", ALL)
    # Less than the first of its runs takes.
    outcome = example.run("scenario", "c.py", "--write", "--search-limit", "0.01")
    assert outcome.code == 4
    assert "tracerisk: the search was ended after 0.01 s (--search-limit)" in outcome.err
    assert b"# assumed" in example.read("c.scenario.yaml")


@pytest.mark.slow
def test_the_exit_code_of_a_search_cut_short_is_that_of_a_run_with_its_scenario(example):
    example.write("c.py", HEAD + "rospy.wait_for_message('/a', String)\nturn(0.1)\n")
    outcome = example.run("scenario", "c.py", "--write", "--search-limit", "0.01", "--json")
    assert outcome.json["cut"] == "the search was ended after 0.01 s (--search-limit)"
    assert (outcome.code, outcome.json["verdict"]["kind"]) == (0, "partial")
    ran = example.run("run", "c.py", "--check", "--json", "--scenario", "c.scenario.yaml")
    assert ran.json["verdict"]["kind"] == "partial"


@pytest.mark.slow
def test_a_search_is_not_ended_by_the_time_that_a_busy_machine_takes(example, monkeypatch):
    from tracerisk import api
    from tracerisk.config import Settings
    from tracerisk.pipeline.scenarios import rounds

    source = HEAD + "rospy.wait_for_message('/a', String)\nturn(0.1)\n"
    controller = api.load_controller(example.write("c.py", source))
    clock = itertools.count(step=200.0)
    monkeypatch.setattr(rounds, "time", SimpleNamespace(monotonic=lambda: next(clock)))
    found = rounds.draft_scenario(
        controller,
        Settings(wall_limit_s=1e6),
        None,
        own_s=100.0,
    )
    assert not found.cut
    assert found.trace is not None
    assert found.trace.is_usable


@pytest.mark.slow
def test_an_interrupt_gives_the_best_so_far(example, monkeypatch):
    from tracerisk import api
    from tracerisk.config import Settings
    from tracerisk.pipeline.scenarios import rounds

    controller = api.load_controller(example.write("c.py", ALL))
    runs = []

    def interrupted(*given, **options):
        runs.append(given[1].scenario)
        if len(runs) == 2:
            raise KeyboardInterrupt
        return rounds_trace(*given, **options)

    rounds_trace = rounds.trace_attempts
    monkeypatch.setattr(rounds, "trace_attempts", interrupted)
    found = rounds.draft_scenario(controller, Settings(), None)
    assert found.cut == "the search was interrupted"
    # No run with it has ended, and how another ended says nothing of it.
    assert found.trace is None
    assert [draft.key for draft in found.given][:1] == ["~angle"]
    assert "~angle: 0.1  # assumed" in found.text


def test_a_turn_that_is_written_in_part_is_no_mixture():
    drafted = {"orientation": {"x": 0.1, "y": 0.7, "z": 0.1, "w": 0.7}, "position": {"x": 1.0}}
    written = {"orientation": {"w": 1.0}, "position": {"y": 2.0}}
    assert merged(drafted, written) == {
        "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
        "position": {"x": 1.0, "y": 2.0},
    }


def test_the_source_alone_is_listed_without_a_run(example):
    example.write("c.py", ALL)
    outcome = example.run("scenario", "c.py", "--no-run")
    assert outcome.code == 0
    assert outcome.out == (
        "Asked for in the source:\n"
        "  parameter ~angle, c.py:26\n"
        "  frame marker, c.py:29\n"
        "  service detect (std_srvs/Trigger), c.py:30\n"
        "  messages on /object (geometry_msgs/PoseStamped), c.py:33\n"
        "  an answer to 'Side? ', c.py:34\n"
    )
    data = example.run("scenario", "c.py", "--no-run", "--json").json
    assert data["source"][0] == {
        "kind": "parameter", "name": "~angle", "type": "", "file": "c.py", "line": 26
    }  # fmt: skip


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("--no-run", "--write"), "--no-run writes nothing"),
        (("-o", "x.yaml"), "--output says where --write writes"),
        (
            ("--write", "--scenario", "s.yaml"),
            "c.scenario.yaml: is there already and would be lost",
        ),
        (
            ("--write", "--scenario", "bad.yaml", "-o", "n.yaml"),
            "bad.yaml:1:1: unknown key 'publsh'",
        ),
        (("--write", "-o", "gone/n.yaml", "--scenario", "s.yaml"), "gone/n.yaml: "),
    ],
)
def test_what_is_not_allowed_loses_nothing(example, quick, options, expected):
    example.write("c.py", quick())
    example.write("c.scenario.yaml", "answers: [kept]\n")
    example.write("s.yaml", "answers: [other]\n")
    example.write("bad.yaml", "publsh: []\n")
    before = example.files()
    outcome = example.run("scenario", "c.py", *options)
    assert outcome.code == 2, outcome.out
    assert expected in outcome.err
    assert example.files() == before


@pytest.fixture
def lifter(example):
    """A controller of a robot of which the workspace has the SRDF alone."""
    example.write(
        "config/lifter.srdf",
        '<robot name="lifter"><group name="lift"><joint name="mast"/><joint name="boom"/>'
        '<joint name="jib"/></group></robot>',
    )
    example.write("package.xml", "<package><name>lifter</name></package>")
    example.write(
        "c.py",
        "import moveit_commander, rospy\nrospy.init_node('n')\n"
        "arm = moveit_commander.MoveGroupCommander('lift')\n"
        "def move():\n    arm.go([0.1, 0.2, 0.3], wait=True)\nmove()\n",
    )
    return example


def test_a_stand_in_for_a_robot_of_which_the_workspace_has_the_srdf_alone(lifter):
    ran = lifter.run("run", "c.py", "--check", "--no-draft", "--json")
    assert ran.json["verdict"]["kind"] == "partial", ran.err
    (reason,) = [each for each in ran.json["verdict"]["reasons"] if each["code"] == "robot-assumed"]
    assert "a stand-in for the robot of the workspace, which cannot be read" in reason["words"]
    assert {"mast", "boom", "jib"} <= set(ran.json["trace"]["active"])


@pytest.mark.slow
def test_a_topic_for_want_of_which_it_fails(example):
    example.write(
        "c.py",
        HEAD + "state = []\nrospy.Subscriber('/cell/config', String, state.append)\n"
        "end = rospy.get_time() + 5.0\n"
        "while not state:\n"
        "    if rospy.get_time() > end:\n        raise OSError('no configuration')\n"
        "    rospy.sleep(0.1)\n"
        "turn(0.2)\n",
    )
    outcome = example.run("scenario", "c.py", "--write", "--json")
    assert outcome.code == 0, outcome.err
    assert [each["name"] for each in outcome.json["given"]] == ["/cell/config"]
    ran = example.run("run", "c.py", "--check", "--json", "--scenario", "c.scenario.yaml")
    assert ran.json["verdict"]["kind"] == "partial"


@pytest.mark.slow
def test_a_proposed_object_is_as_wide_as_the_grasp_takes():
    place = Location("c.py", 7)
    empty = Finding("nothing_to_grasp", "hand closed on nothing", 1.0, place)
    words = "the fingers stopped at 0.0000 m; default_grasp_epsilon allows 0.0190 to 0.0290 m"
    aborted = Finding("execution_failure", words, 2.0, place)
    assert grasp_width_m([empty, aborted], empty) == pytest.approx(0.024)
    elsewhere = replace(aborted, location=Location("c.py", 9))
    assert grasp_width_m([empty, elsewhere], empty) == 0.04


def test_what_a_node_beside_gives_in_vain_is_drafted(example):
    example.write(
        "finder.py",
        "import rospy\nfrom std_srvs.srv import Trigger\n"
        "def find(request):\n    raise RuntimeError('no camera')\n"
        "if __name__ == '__main__':\n    rospy.init_node('finder')\n"
        "    rospy.Service('find', Trigger, find)\n    rospy.spin()\n",
    )
    example.write(
        "c.py",
        HEAD + "\nrospy.wait_for_service('find')\n"
        "if rospy.ServiceProxy('find', Trigger)().success:\n    turn(0.3)\n",
    )
    outcome = example.run("scenario", "c.py", "--write")
    assert outcome.code == 0, outcome.err
    assert b"name: /find" in example.read("c.scenario.yaml")


@pytest.mark.slow
def test_another_name_for_the_base_is_drafted_where_a_plan_is_in_it(example):
    example.write(
        "c.py",
        HEAD
        + """
arm.set_pose_reference_frame("base_link")
arm.set_pose_target([0.4, 0.1, 0.5, 1.0, 0.0, 0.0, 0.0])
arm.go(wait=True)
turn(0.2)
""",
    )
    outcome = example.run("scenario", "c.py", "--write")
    assert outcome.code == 0, outcome.err
    text = example.read("c.scenario.yaml").decode()
    assert "frame: base_link  # assumed: the base of panda" in text
    given = ("run", "c.py", "--json", "--check", "--scenario", "c.scenario.yaml")
    assert example.run(*given).json["verdict"]["kind"] == "partial"


GRIP = """\
import moveit_commander
import rospy

rospy.init_node("grip")
arm = moveit_commander.MoveGroupCommander("panda_arm")
hand = moveit_commander.MoveGroupCommander("panda_hand")
hand.go([0.04, 0.04], wait=True)
arm.go([0.0, 0.4, 0.0, -1.8, 0.0, 2.2, 0.78], wait=True)
hand.go([0.0, 0.0], wait=True)
"""


def test_where_a_grip_finds_nothing_an_object_is_proposed_that_is_then_held(example):
    example.write("grip.py", GRIP)
    outcome = example.run("scenario", "grip.py")
    assert outcome.code == 0, outcome.err
    title, place, entry = outcome.out.splitlines()
    assert title.startswith("Closed on nothing; an entry of `objects` each")
    assert place == "  panda_hand, grip.py:9: at (0.646, 0.000, 0.223) m"
    example.write("cell.yaml", f"objects:\n{entry}\n")
    ran = example.run("run", "grip.py", "--scenario", "cell.yaml", "--check")
    assert "1 object moved: part is held in panda_hand" in ran.err
    assert "objects part of the scenario is assumed: its size" in ran.out
