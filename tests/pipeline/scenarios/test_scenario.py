"""Scenarios end to end: what lacks is told, and pasting what is told makes the run go on."""

import json
import re
from pathlib import Path

import pytest
from ruamel.yaml import YAML

ROS1 = """\
import sys
import actionlib, moveit_commander, rospy, tf2_ros
from geometry_msgs.msg import PoseStamped
from move_base_msgs.msg import MoveBaseAction, MoveBaseGoal
from std_srvs.srv import Trigger

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("picker")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)

def turn(angle):
    joints = arm.get_current_joint_values()
    joints[0] += angle
    arm.go(joints, wait=True)

def main():
    angle = rospy.get_param("~angle") + 0.05
    buffer = tf2_ros.Buffer()
    listener = tf2_ros.TransformListener(buffer)
    buffer.lookup_transform("world", "marker", rospy.Time(0), rospy.Duration(2.0))
    rospy.wait_for_service("detect")
    detect = rospy.ServiceProxy("detect", Trigger)
    detect()
    drive = actionlib.SimpleActionClient("move_base", MoveBaseAction)
    drive.wait_for_server()
    drive.send_goal_and_wait(MoveBaseGoal())
    rospy.wait_for_message("/object", PoseStamped)
    count = int(input("How often? "))
    for _ in range(count):
        turn(angle)

main()
"""

ROS2 = """\
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, PointHead
from geometry_msgs.msg import PoseStamped
from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

NAMES = [f"panda_joint{i}" for i in range(1, 8)]

class Picker(Node):
    def __init__(self):
        super().__init__("picker")
        self.declare_parameter("angle", Parameter.Type.DOUBLE)
        self.angle = self.get_parameter("angle").value + 0.05
        self.pose = None
        self.create_subscription(PoseStamped, "/object", self.on_pose, 10)
        self.detect = self.create_client(Trigger, "/detect")
        self.arm = ActionClient(self, FollowJointTrajectory, "/arm/follow_joint_trajectory")
        self.look = ActionClient(self, PointHead, "/look")

    def on_pose(self, message):
        self.pose = message

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def turn(self):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = NAMES
        point = JointTrajectoryPoint(time_from_start=Duration(sec=1))
        point.positions = [self.angle, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
        goal.trajectory.points.append(point)
        handle = self.wait(self.arm.send_goal_async(goal))
        self.wait(handle.get_result_async())

    def run(self):
        while not self.detect.wait_for_service(timeout_sec=1.0):
            self.get_logger().info("waiting for the detector")
        self.wait(self.detect.call_async(Trigger.Request()))
        self.look.wait_for_server()
        handle = self.wait(self.look.send_goal_async(PointHead.Goal()))
        self.wait(handle.get_result_async())
        while self.pose is None:
            rclpy.spin_once(self, timeout_sec=0.1)
        if input("Go? [y/n] ") == "y":
            self.turn()

rclpy.init()
Picker().run()
"""


def paste(example, lines: str) -> list[str]:
    """Put the lines that an error suggests into the scenario; return the sections they are in."""
    yaml = YAML(typ="safe", pure=True)
    path = example.folder / "s.yaml"
    known = yaml.load(path.read_text()) if path.exists() else {}
    given = yaml.load(lines)
    for section, content in given.items():
        if isinstance(content, dict):
            known.setdefault(section, {}).update(content)
        else:
            known.setdefault(section, []).extend(content)
    example.write("s.yaml", json.dumps(known))
    return sorted(given)


def pasted_until_it_runs(example, *, most: int = 10):
    """Run, paste what is suggested, and run again; return what was lacking, and the last outcome."""
    lacked, errors = [], []
    example.write("s.yaml", "{}")
    for _ in range(most):
        outcome = example.run("run", "c.py", "--json", "--check", "--scenario", "s.yaml")
        if outcome.code != 4:
            return lacked, errors, outcome
        error = outcome.json["error"]
        assert error["scenario"], error["message"]
        assert error["scenario"] in outcome.err
        errors.append(error)
        lacked.append(paste(example, error["scenario"]))
    raise AssertionError(errors[-1]["message"])


def lines_of(source: str, *parts: str) -> list[int]:
    lines = source.splitlines()
    return [next(i for i, line in enumerate(lines, 1) if part in line) for part in parts]


@pytest.mark.slow
def test_pasting_what_is_reported_gives_a_controller_of_ros_1_all_it_waits_for(example):
    """Slow: five runs, though it asks for six things one after another."""
    example.write("c.py", ROS1)
    lacked, errors, outcome = pasted_until_it_runs(example)
    assert outcome.code == 1, outcome.err  # --check: blocks would be written
    # What the source asks for by name is told with the first thing that is lacking.
    assert lacked == [["actions", "parameters", "publish", "services"], ["frames"], ["answers"]]
    assert [error["line"] for error in errors] == lines_of(ROS1, "get_param", "lookup_tr", "input")
    assert "service /detect (std_srvs/Trigger)" in errors[0]["message"]
    assert "action server /move_base (move_base_msgs/MoveBase)" in errors[0]["message"]
    assert "messages on /object (geometry_msgs/PoseStamped)" in errors[0]["message"]
    again = example.run("run", "c.py", "--json", "--check", "--scenario", "s.yaml")
    assert again.code == 1, again.err
    assert again.out == outcome.out


@pytest.mark.slow
def test_pasting_what_is_reported_gives_a_controller_of_ros_2_all_it_waits_for(example):
    """Slow: four runs."""
    example.write("c.py", ROS2)
    lacked, errors, outcome = pasted_until_it_runs(example)
    assert outcome.code == 1, outcome.err
    assert lacked == [["actions", "parameters", "publish", "services"], ["answers"]]
    detect, look, pose = lines_of(ROS2, "Trigger, ", "PointHead, ", "PoseStamped, ")
    assert errors[0]["message"].endswith(
        "; nor does anything provide messages on /object (geometry_msgs/PoseStamped), asked for at "
        f"c.py:{pose}; service /detect (std_srvs/Trigger), asked for at c.py:{detect}; action "
        f"server /look (control_msgs/PointHead), asked for at c.py:{look}"
    )
    again = example.run("run", "c.py", "--json", "--check", "--scenario", "s.yaml")
    assert again.code == 1, again.err
    assert again.out == outcome.out


DOCS = Path(__file__).parents[3] / "docs" / "scenario.md"


def block(language: str) -> str:
    (found,) = re.findall(
        rf"^```{language}\n(.*?)^```$", DOCS.read_text(), re.MULTILINE | re.DOTALL
    )
    return found


def test_the_documents_example_runs_to_its_end(example):
    """Slow for the two motions that it shows: about 4 s."""
    example.write("pick.py", block("python"))
    example.write("cell.yaml", block("yaml"))
    outcome = example.run("trace", "pick.py", "--json", "--scenario", "cell.yaml")
    assert outcome.code == 0, outcome.err
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == "ended"
    assert [visit["function"]["name"] for visit in trace["visits"]] == ["pick", "pick"]
    assert trace["visits"][0]["start_s"] == pytest.approx(4.75, abs=0.05)
    assert trace["end"]["simulated_s"] > 5.0


def test_the_documents_message_is_what_a_run_without_a_scenario_says(example):
    example.write("pick.py", block("python"))
    outcome = example.run("run", "pick.py", "--no-draft")
    assert outcome.code == 4
    message, advice = outcome.err.splitlines()[0], outcome.err[outcome.err.index("These lines") :]
    assert f"{message}\n...\n{advice.rstrip()}\n```" in DOCS.read_text()


LISTENER = """\
import moveit_commander, rospy
from std_msgs.msg import Float64

rospy.init_node("listener")
arm = moveit_commander.MoveGroupCommander("panda_arm")

class Listener:
    def __init__(self):
        self.angle = None
        rospy.Subscriber("angle", Float64, self.on_angle)

    def on_angle(self, message):
        self.angle = message.data

    def turn(self):
        joints = arm.get_current_joint_values()
        joints[0] += self.angle
        arm.go(joints, wait=True)

listener = Listener()
"""
POLL = "while listener.angle is None:\n    rospy.sleep(0.1)\nlistener.turn()\n"


def test_a_topic_on_which_nobody_publishes_is_reported_when_a_node_only_spins(example):
    example.write("c.py", LISTENER + "rospy.spin()\n")
    outcome = example.run("run", "c.py", "--json", "--no-draft")
    assert outcome.code == 4
    error = outcome.json["error"]
    assert error["message"].startswith(
        "nothing was commanded, and nothing provides messages on /angle (std_msgs/Float64), "
        "asked for at c.py:10"
    )
    assert error["line"] == 10
    assert error["scenario"] == (
        "publish:\n  - topic: /angle  # assumed: a value of its type\n"
        "    type: std_msgs/Float64\n    after: 1.0\n    message: {data: 0.1}\n"
    )
    assert outcome.json["trace"]["end"]["cause"] == "no_motion"


def test_what_is_lacking_is_reported_when_the_controller_takes_down_its_node_at_its_end(example):
    example.write(
        "listen.py",
        "import rclpy\nfrom std_msgs.msg import String\n\nrclpy.init()\n"
        'node = rclpy.create_node("listener")\n'
        'parts = node.create_subscription(String, "/part", print, 1)\n'
        "try:\n    rclpy.spin(node)\n"
        "finally:\n    node.destroy_subscription(parts)\n    node.destroy_node()\n"
        "    rclpy.shutdown()\n",
    )
    outcome = example.run("trace", "listen.py", "--robot", "panda", "--no-draft")
    assert outcome.code == 4
    assert "nothing provides messages on /part (std_msgs/String), asked for at" in outcome.err
    assert "- topic: /part" in outcome.err


def test_a_loop_that_only_waits_stops_after_a_minute(example):
    example.write("c.py", LISTENER + POLL)
    outcome = example.run("run", "c.py", "--json", "--no-draft")
    assert outcome.code == 4
    data = outcome.json
    assert data["error"]["message"].startswith("MainThread has only waited for 60 s")
    assert "messages on /angle (std_msgs/Float64), asked for at c.py:10" in data["error"]["message"]
    assert data["error"]["line"] == LISTENER.count("\n") + 2
    assert 60.0 <= data["trace"]["end"]["simulated_s"] < 62.0


@pytest.mark.slow
def test_a_loop_that_only_waits_goes_on_while_the_scenario_has_more_to_give(example):
    example.write("c.py", LISTENER + POLL)
    example.write(
        "s.yaml", "publish:\n  - {topic: /angle, type: std_msgs/Float64, at: 70, message: 0.1}\n"
    )
    example.write("pyproject.toml", '[tool.tracerisk]\nscenario = "s.yaml"\n')
    outcome = example.run("trace", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    (visit,) = outcome.json["trace"]["visits"]
    assert visit["start_s"] == pytest.approx(70.0, abs=0.2)


def test_objects_of_the_scenario_are_bodies_of_the_scene(example, quick):
    example.write("c.py", quick())
    example.write(
        "s.yaml",
        "objects:\n"
        "  - {name: can, cylinder: {radius: 0.03, height: 0.1}, xyz: [0, 0.5, 0.3], mass: 0.2}\n"
        "  - {name: shelf, box: [0.2, 0.2, 0.02], xyz: [0, 0.5, 0.2]}\n",
    )
    trace = example.run("trace", "c.py", "--json", "--scenario", "s.yaml").json["trace"]
    assert "can" in [each["name"] for each in trace["objects"]]
    assert "shelf" not in [each["name"] for each in trace["objects"]]


def test_a_mistake_in_a_scenario_is_bad_input(example, quick):
    example.write("c.py", quick())
    example.write("s.yaml", "servces: []\n")
    outcome = example.run("run", "c.py", "--scenario", "s.yaml")
    assert outcome.code == 2
    text = "tracerisk: s.yaml:1:1: unknown key 'servces'; did you mean 'services'?"
    assert outcome.err.startswith(text)


def test_what_the_scenario_holds_is_part_of_what_the_lock_keeps_of_a_run(example, quick):
    example.write("c.py", quick())
    example.write("pyproject.toml", '[tool.tracerisk]\nscenario = "s.yaml"\n')
    locks = []
    for text in ("answers: []\n", "answers: [unasked]\n"):
        example.write("s.yaml", text)
        assert example.run("run", "c.py", "--quiet").code == 0
        locks.append(example.read("tracerisk.lock"))
    assert locks[0] != locks[1]


def test_the_arm_is_the_controllers_and_a_scenario_moves_nothing(example):
    example.write("c.py", LISTENER + POLL)
    message = "{joint_names: [panda_joint1], points: [{positions: [0.5], time_from_start: 1}]}"
    kind = "trajectory_msgs/JointTrajectory"
    example.write(
        "s.yaml",
        f"publish:\n  - {{topic: /arm/command, type: {kind}, at: 1, message: {message}}}\n"
        "  - {topic: /angle, type: std_msgs/Float64, at: 4, message: 0.1}\n",
    )
    trace = example.run("trace", "c.py", "--json", "--scenario", "s.yaml").json["trace"]
    assert [visit["start_s"] for visit in trace["visits"]] == [pytest.approx(4.0, abs=0.2)]


def test_a_topic_on_which_nobody_publishes_is_a_finding_of_a_run_that_did_something(example):
    example.write("c.py", LISTENER + "listener.angle = 0.1\nlistener.turn()\nrospy.spin()\n")
    trace = example.run("trace", "c.py", "--json").json["trace"]
    assert trace["end"]["cause"] == "quiescent"
    (finding,) = [each for each in trace["findings"] if each["kind"] == "unprovided"]
    assert "nothing provides messages on /angle (std_msgs/Float64)" in finding["message"]
    assert (finding["location"]["file"], finding["location"]["line"]) == ("c.py", 10)


def test_a_long_sleep_is_no_loop_that_only_waits(example):
    body = "rospy.sleep(70.0)\nlistener.angle = 0.1\nlistener.turn()\n"
    example.write("c.py", LISTENER + body)
    outcome = example.run("trace", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["visits"][0]["start_s"] == pytest.approx(70.0, abs=0.1)


def test_a_question_that_is_asked_again_and_again_ends_the_run(example, quick):
    example.write("c.py", quick() + 'while not input("Which arm? ").istitle(): pass\n')
    outcome = example.run("run", "c.py", "--json", "--robot", "panda", "--no-draft")
    assert outcome.code == 4
    error = outcome.json["error"]
    assert "the answer to 'Which arm?' was asked for 200 times" in error["message"]
    assert error["scenario"] == "answers:\n  - '1'  # assumed: an answer to 'Which arm?'\n"


JOGGED = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rospy.init_node("jogged")
arm = rospy.Publisher("/panda_arm_controller/command", JointTrajectory, queue_size=1)
rospy.sleep(1.0)
while not rospy.is_shutdown():
    joints = [float(each) for each in input("joints: ").split()]
    if len(joints) != 7:
        continue
    point = JointTrajectoryPoint(positions=joints, time_from_start=rospy.Duration(2.0))
    names = [f"panda_joint{number}" for number in range(1, 8)]
    arm.publish(JointTrajectory(joint_names=names, points=[point]))
"""


def test_a_user_sees_a_motion_end_before_the_next_answer(example):
    example.write("c.py", JOGGED)
    trace = example.run("run", "c.py", "--json", "--check", "--no-draft").json["trace"]
    assert trace["end"]["cause"] == "idle"
    assert "was given each answer that its code knows" in trace["end"]["message"]
    assert [command["end"] for command in trace["commands"]] == ["arrived"]
    assert trace["end"]["simulated_s"] >= 2.0


CHOICES = """import moveit_commander, rospy
rospy.init_node("choices")
group = moveit_commander.MoveGroupCommander("panda_arm")
near = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
while (choice := input("h, s or q: ")) != "q":
    if choice == "h":
        group.go(near, wait=True)
    elif choice == "s":
        group.go([0.2, *near[1:]], wait=True)
    else:
        group.go([0.4, *near[1:]], wait=True)
"""


def test_a_menu_that_moves_on_enter_too_gets_what_its_code_compares(example):
    example.write("c.py", CHOICES)
    outcome = example.run("run", "c.py", "--json", "--check")
    assert outcome.json["trace"]["end"]["cause"] == "ended"
    assert len(outcome.json["trace"]["commands"]) == 2
    (reason,) = [
        each for each in outcome.json["verdict"]["reasons"] if each["code"] == "input-assumed"
    ]
    assert "'h', then 's', then 'q' is assumed" in reason["words"]


MENU = """\
rospy.init_node("menu")
group = moveit_commander.MoveGroupCommander("panda_arm")

def ask():
    while True:
        try:
            values = [float(each) for each in input("joints: ").split()]
        except ValueError:
            continue
        if len(values) != 7:
            print("seven, please")
            continue
        return values

while True:
    choice = input("What next? ")
    if choice == "move":
        group.go(ask(), wait=True)
    elif choice == "q":
        break
"""


def test_a_question_that_does_not_take_enter_gets_what_its_code_compares(example):
    example.write("c.py", "import moveit_commander, rospy\n" + MENU)
    outcome = example.run("run", "c.py", "--json", "--check")
    trace = outcome.json["trace"]
    assert trace["end"]["cause"] == "ended"
    assert len(trace["visits"]) == 1
    verdict = outcome.json["verdict"]
    assert verdict["kind"] == "partial"
    found = {(each["code"], each["object"]): each for each in verdict["reasons"]}
    for question in ("'What next?'", "'joints:'"):
        reason = found["input-assumed", question]
        assert f"nobody answers {question}: " in reason["words"]
        assert reason["location"]["file"] == "c.py"


PACED = """\
import itertools, moveit_commander, rospy
rospy.init_node("paced")
group = moveit_commander.MoveGroupCommander("panda_arm")
for turn in itertools.cycle((0.0, 0.1)):
    if input("Go on? ") == "n":
        break
    group.go([turn, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785], wait=True)
"""


def test_a_question_whose_enter_moves_the_arm_gets_no_other_answer(example):
    example.write("c.py", PACED)
    trace = example.run("trace", "c.py", "--json", "--duration", "8").json["trace"]
    assert len(trace["visits"]) > 0
    assert trace["end"]["cause"] != "ended"
    assert not [each for each in trace["findings"] if each["kind"] == "answer_assumed"]


def test_a_loop_that_waits_for_a_parameter_is_reported_of_it(example):
    example.write(
        "c.py",
        "import rospy\nrospy.init_node('n')\n"
        "while not rospy.has_param('/calibrated'):\n    rospy.sleep(0.5)\n",
    )
    options = ("--robot", "panda", "--no-draft", "--duration", "5")
    error = example.run("run", "c.py", "--json", *options).json["error"]
    assert "nothing provides parameter /calibrated, asked for at c.py:3" in error["message"]
    assert error["scenario"] == "parameters:\n  /calibrated: 1  # assumed: a guess\n"


@pytest.mark.slow
def test_parameters_come_from_the_settings_and_the_command_line(example):
    example.write(
        "c.py",
        LISTENER + "listener.angle = rospy.get_param('~angle')\n"
        "if rospy.get_param('/armed'):\n    listener.turn()\n",
    )
    example.write("armed.yaml", "armed: yes\n")
    example.write("ros2.yaml", "/**:\n  ros__parameters:\n    angle: 0.1\n")
    example.write("pyproject.toml", '[tool.tracerisk]\nparams = ["armed.yaml"]\n')
    given = ("--params", "armed.yaml", "--params", "ros2.yaml")
    assert "~angle" in example.run("trace", "c.py", "--no-draft").err
    outcome = example.run("trace", "c.py", "--json", *given)
    assert outcome.code == 0, outcome.err
    assert len(outcome.json["trace"]["visits"]) == 1
    assert example.run("trace", "c.py", "--params", "gone.yaml").code == 2


def test_what_nobody_made_use_of_is_a_finding(example):
    example.write("c.py", LISTENER + POLL)
    example.write(
        "s.yaml",
        "publish:\n"
        "  - {topic: /angle, type: std_msgs/Float64, message: 0.1}\n"
        "  - {topic: /angel, type: std_msgs/Float64, rate: 5}\n"
        "  - {topic: /angle, type: std_msgs/Float64, message: 0.2, at: 250, rate: 1}\n"
        "services:\n  - {name: /detect, type: std_srvs/Trigger}\n"
        "actions:\n  - {name: /drive, type: move_base_msgs/MoveBase}\n"
        "parameters:\n  /cell/speed: 0.5\n  ~depth: 0.1\n  gains: {p: 1.0}\n",
    )
    trace = example.run("trace", "c.py", "--json", "--scenario", "s.yaml").json["trace"]
    reported = {
        (each["message"], each["location"]["line"])
        for each in trace["findings"]
        if each["kind"] == "unused"
    }
    assert reported == {
        ("in the scenario, but nobody subscribed to topic /angel", 3),
        ("in the scenario, but the run ended before /angle was due, at 250 s", 4),
        ("in the scenario, but nobody called service /detect", 6),
        ("in the scenario, but nobody sent a goal to action server /drive", 8),
        ("in the scenario, but nobody asked for parameter /cell/speed", 10),
        ("in the scenario, but nobody asked for parameter ~depth", 11),
        ("in the scenario, but nobody asked for parameter gains", 12),
    }
    assert trace["verdict"]["kind"] == "partial"
    assert {each["code"] for each in trace["verdict"]["reasons"]} == {"unused-input"}


def test_what_the_controller_asks_for_by_another_spelling_is_named(example):
    source = "from std_srvs.srv import Trigger\n" + LISTENER
    client = "rospy.ServiceProxy('/detct', Trigger)\n"
    example.write("c.py", source.replace('"angle"', '"/part_angel"') + client + "listener.turn()\n")
    example.write(
        "s.yaml",
        "publish:\n  - {topic: /part_angle, type: std_msgs/Float64, rate: 5}\n"
        "services:\n  - {name: /detect, type: std_srvs/Trigger}\n",
    )
    trace = example.run("trace", "c.py", "--json", "--no-draft", "--scenario", "s.yaml").json[
        "trace"
    ]
    said = [found["message"] for found in trace["findings"] if found["kind"] == "unused"]
    assert any(
        "did you mean /part_angel? The controller asks for it in vain (c.py:" in t for t in said
    )
    assert any("did you mean /detct? The controller asks for it in vain (c.py:" in t for t in said)


def test_a_controller_that_waits_to_be_called_is_reported_how(example):
    body = "rospy.Service('/turn', Trigger, listener.on_call)\nrospy.spin()\n"
    source = LISTENER.replace(
        'rospy.Subscriber("angle", Float64, self.on_angle)', "self.angle = 0.1"
    )
    source = source.replace(
        "listener = ",
        "    def on_call(self, _):\n        self.turn()\n        return TriggerResponse(True, '')\n\nlistener = ",
    )
    example.write("c.py", "from std_srvs.srv import Trigger, TriggerResponse\n" + source + body)
    outcome = example.run("run", "c.py", "--json", "--no-draft")
    assert outcome.code == 4
    error = outcome.json["error"]
    assert "nothing provides calls of service /turn (std_srvs/Trigger)" in error["message"]
    assert error["scenario"] == (
        "calls:\n  - service: /turn  # assumed: one call, in its turn\n"
        "    type: std_srvs/Trigger\n    request: {}\n    wait: true\n"
    )
    example.write("s.yaml", error["scenario"])
    trace = example.run("trace", "c.py", "--json", "--scenario", "s.yaml").json["trace"]
    assert [each["function"]["name"] for each in trace["visits"]] == ["Listener.turn"]


ENDLESS_MENU = """\
rospy.init_node("menu")
group = moveit_commander.MoveGroupCommander("panda_arm")


def go():
    group.set_named_target("ready")
    group.go()


while True:
    if input("Which? ") == "go":
        go()
"""


def test_a_menu_without_an_end_that_has_moved_the_arm_is_over_with_its_answers(example):
    example.write("c.py", "import moveit_commander\nimport rospy\n\n" + ENDLESS_MENU)
    outcome = example.run("trace", "c.py", "--json", "--answer", "go", "--no-draft")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "idle"
    assert outcome.json["verdict"]["kind"] == "partial"
    reasons = {each["code"]: each["words"] for each in outcome.json["verdict"]["reasons"]}
    assert reasons == {
        "input-assumed": "nobody answers 'Which?': 'go' is assumed, as its code would take it; "
        "--answer gives another"
    }


NUMBERS = """\
while True:
    print("choose x:")
    x = float(input())
    print("choose y:")
    y = float(input())
    group.set_joint_value_target("panda_joint1", x + y)
    group.go()
"""


def test_questions_without_words_are_answered_each_and_are_over_with_their_answers(example):
    head = "import moveit_commander\nimport rospy\n\n" + ENDLESS_MENU.partition("def go")[0]
    example.write("c.py", head + NUMBERS)
    options = ("trace", "c.py", "--json", "--no-draft", "--answer", "0.1")
    outcome = example.run(*options, "--answer", "0.2")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "idle"
    reasons = {each["code"]: each["words"] for each in outcome.json["verdict"]["reasons"]}
    line = head.count("\n") + 3
    words = f"nothing provides an answer to a read of the standard input in line {line}"
    assert reasons["unmet-need"] == words
    # A question that nobody answers gets what its code takes.
    outcome = example.run(*options)
    assert outcome.code == 0, outcome.err
    found = [each for each in outcome.json["verdict"]["reasons"] if each["code"] == "input-assumed"]
    assert [each["object"] for each in found] == [
        f"a read of the standard input in line {line + 2}"
    ]
