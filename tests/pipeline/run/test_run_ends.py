"""When a run without an end of its own is over."""

import pytest

from tests.slow import slow_but

HEAD = """\
import sys
import moveit_commander, rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("quick")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)

def there():
    arm.go([0.2, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)

def back():
    arm.go([0.1, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)

"""


@pytest.fixture
def run(example):
    def run(body: str, *arguments: str, code: int = 0):
        example.write("c.py", HEAD + body)
        outcome = example.run("run", "c.py", "--json", *arguments)
        assert outcome.code == code, outcome.err
        return outcome.json

    return run


WORK = "there()\nback()\n"


@pytest.fixture(scope="module")
def ended(tmp_path_factory, example_in):
    """A run that ends once its work is done."""
    example = example_in(tmp_path_factory.mktemp("ended"))
    example.write("c.py", HEAD + WORK)
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    return outcome.json


def risk(data) -> float:
    return data["assessment"]["mission"]["failure_probability"]


def follows(data) -> dict:
    return {
        state["name"]: {step["target"]: step["weight"] for step in state["next"]}
        for state in data["model"]["states"]
    }


def test_a_cycle_that_came_three_times_ends_an_endless_loop_as_a_declared_mission(run):
    data = run("there()\nwhile not rospy.is_shutdown():\n    back()\n    there()\n")
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 7
    assert follows(data) == {"there": {"back": "10/11", "done": "1/11"}, "back": {"there": "1"}}
    assert any("10 cycles (mission_cycles)" in line for line in data["assumptions"])


def test_a_state_machine_is_seen_over_several_iterations_and_their_number_is_a_setting(run):
    body = "n = 0\nwhile True:\n    (there if n % 2 else back)()\n    n += 1\n"
    data = run(body, "--mission-cycles", "4")
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 6
    assert follows(data)["there"] == {"back": "3/4", "done": "1/4"}


def test_timers_that_repeat_end_a_spin(run):
    data = run(
        "def tick(event):\n    there()\n    back()\nrospy.Timer(rospy.Duration(5), tick)\nrospy.spin()\n"
    )
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 6


POSES = """\
arm.set_max_acceleration_scaling_factor(1.0)
POSES = [0.1, 0.3, 0.5, 0.3]

def go_to(angle):
    arm.go([angle, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)

"""


def test_poses_in_turn_from_one_place_are_one_cycle_as_when_written_out(run):
    in_turn = run(
        POSES + "n = 0\nwhile True:\n    go_to(POSES[n % 4])\n    n += 1\n", "--mission-cycles", "5"
    )
    written_out = run(
        POSES + "while True:\n" + "".join(f"    go_to(POSES[{i}])\n" for i in range(4)),
        "--mission-cycles",
        "5",
    )
    assert len(in_turn["trace"]["visits"]) == len(written_out["trace"]["visits"]) == 12
    assert risk(in_turn) == pytest.approx(risk(written_out), rel=0.01)


def test_a_joint_that_goes_on_by_equal_steps_makes_no_cycle(run):
    """As fingers that close until a force is felt: such a ramp has an end."""
    data = run("""\
angle = 0.1
while not rospy.is_shutdown():
    if angle < 0.25:
        angle += 0.02
        arm.go([angle, -0.785, 0, -2.356, 0, 1.571, 0.785], wait=True)
    rospy.sleep(0.5)
""")
    assert data["trace"]["end"]["cause"] == "idle"
    assert len(data["trace"]["commands"]) == 8


@pytest.mark.slow
def test_poses_that_never_come_again_end_after_sixty_as_ten_cycles(run):
    body = "import random\nwhile True:\n    go_to(random.uniform(-1, 1))\n    arm.stop()\n"
    data = run(POSES + body)
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 60
    assert follows(data) == {"go_to": {"go_to": "9/10", "done": "1/10"}}


# Which loops have an end of their own, `tests/instrument/marks/test_endless_loops.py` has.
@pytest.mark.slow
def test_a_loop_with_an_end_of_its_own_is_not_cut(run):
    body = (
        "n = 0\nwhile True:\n    there()\n    back()\n    n += 1\n    if n == 5:\n        break\n"
    )
    data = run(body)
    assert data["trace"]["end"]["cause"] == "ended"
    assert len(data["trace"]["visits"]) == 10


IDLE = "rate = rospy.Rate(2)\nwhile not rospy.is_shutdown():\n    rate.sleep()\n"


# That a spin in which nothing happens ends a run, `tests/ros/stand_ins/rospy/test_rospy_node.py` has.
@pytest.mark.parametrize(
    "end",
    [
        pytest.param("rospy.spin()\n", marks=pytest.mark.slow),
        IDLE,
        pytest.param("import time\nwhile True:\n    time.sleep(1.0)\n", marks=pytest.mark.slow),
        pytest.param(
            "rospy.Subscriber('/joint_states', rospy.AnyMsg, lambda m: None)\nrospy.spin()\n",
            marks=pytest.mark.slow,
        ),
        pytest.param(
            "rospy.Timer(rospy.Duration(1.0), lambda e: None)\nrospy.spin()\n",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_idling_after_the_work_is_no_risk(run, ended, end):
    idled = run(WORK + end)
    assert idled["trace"]["end"]["cause"] in ("idle", "quiescent")
    assert risk(idled) == pytest.approx(risk(ended), rel=0.01)


def test_a_pause_within_a_mission_is_not_cut(run):
    pause = "t = rospy.get_time() + 30\nwhile rospy.get_time() < t:\n    rospy.sleep(0.5)\n"
    data = run(WORK + pause + "there()\n" + IDLE)
    assert len(data["trace"]["visits"]) == 3
    assert 30.0 < data["trace"]["end"]["simulated_s"] < 40.0


def test_a_loop_in_which_nothing_moves_fails_early(run):
    data = run(IDLE, "--no-draft", code=4)
    assert data["trace"]["end"]["cause"] == "no_motion"
    assert data["trace"]["end"]["simulated_s"] < 61.0


ROS2_TIMER = """\
import rclpy
from builtin_interfaces.msg import Duration
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = ["panda_joint%d" % i for i in range(1, 8)]
STARTS = [[x, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785] for x in (0.2, 0.1)]

rclpy.init()
node = rclpy.create_node("quick")
publisher = node.create_publisher(JointTrajectory, "/panda_arm_controller/joint_trajectory", 10)
ticks = 0

def there():
    send(STARTS[0])

def back():
    send(STARTS[1])

def send(positions):
    point = JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=1))
    publisher.publish(JointTrajectory(joint_names=JOINTS, points=[point]))

def tick():
    global ticks
    ticks += 1
    if ticks < LAST:
        (there if ticks % 2 else back)()

node.create_timer(2.0, tick)
"""
ROS2_SPINS = {
    "rclpy.spin": "rclpy.spin(node)\n",
    "several threads": (
        "executor = rclpy.executors.MultiThreadedExecutor(2)\n"
        "executor.add_node(node)\nexecutor.spin()\n"
    ),
    "a loop": "while rclpy.ok():\n    rclpy.spin_once(node)\n",
}


# With `rclpy.spin`, the timer that only beats after the work is seen below, and a loop with a rate.
@pytest.mark.slow
@pytest.mark.parametrize("spin", slow_but(["several threads"], [*ROS2_SPINS]))
def test_timers_of_ros_2_that_repeat_end_a_spin_too(example, spin):
    program = "import rclpy.executors\n" + ROS2_TIMER.replace("LAST", "1000") + ROS2_SPINS[spin]
    example.write("c.py", program)
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "cycles"
    assert [state["name"] for state in outcome.json["model"]["states"]] == ["there", "back"]


def test_a_timer_of_ros_2_that_only_beats_after_the_work_is_idle(example):
    example.write("c.py", ROS2_TIMER.replace("LAST", "5") + "rclpy.spin(node)\n")
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "idle"
    assert outcome.json["trace"]["end"]["simulated_s"] < 80.0


BACKGROUND = """\
import threading, time
import rclpy.executors
executor = rclpy.executors.{kind}
executor.add_node(node)
thread = threading.Thread(target=executor.spin, daemon=True)
thread.start()
"""
LEFT_TO_CALLBACKS = {
    "join": "thread.join()\n",
    "sleep": "while rclpy.ok():\n    time.sleep(1.0)\n",
    "rate": "rate = node.create_rate(1)\nwhile rclpy.ok():\n    rate.sleep()\n",
}


@pytest.mark.parametrize(
    ("how", "kind"),
    [
        pytest.param("join", "SingleThreadedExecutor()", marks=pytest.mark.slow),
        pytest.param("join", "MultiThreadedExecutor(2)", marks=pytest.mark.slow),
        pytest.param("sleep", "MultiThreadedExecutor(2)", marks=pytest.mark.slow),
        ("rate", "SingleThreadedExecutor()"),
    ],
)
def test_callbacks_that_repeat_in_the_background_end_a_run(example, how, kind):
    program = ROS2_TIMER.replace("LAST", "1000") + BACKGROUND.format(kind=kind)
    example.write("c.py", program + LEFT_TO_CALLBACKS[how])
    outcome = example.run("run", "c.py", "--json")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "cycles"
    assert [state["name"] for state in outcome.json["model"]["states"]] == ["there", "back"]


# In ROS 2, the callbacks above repeat beside such a loop.
@pytest.mark.slow
def test_timers_that_repeat_beside_a_loop_that_only_sleeps_end_a_run(run):
    data = run(
        "def tick(event):\n    there()\n    back()\nrospy.Timer(rospy.Duration(5), tick)\n"
        "rate = rospy.Rate(10)\nwhile not rospy.is_shutdown():\n    rate.sleep()\n"
    )
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 6


def test_a_run_that_waits_for_its_last_motion_when_the_time_is_over_is_no_deadlock(example):
    motions = (
        "from control_msgs.action import FollowJointTrajectory\n"
        "from rclpy.action import ActionClient\n"
        "arm = ActionClient(node, FollowJointTrajectory, '/panda_arm_controller/follow')\n"
        "arm.wait_for_server()\n"
        "shift = 0.0\n"
        "while rclpy.ok():\n"
        "    shift += 0.01\n"
        "    goal = FollowJointTrajectory.Goal()\n"
        "    goal.trajectory.joint_names = JOINTS\n"
        "    point = JointTrajectoryPoint(time_from_start=Duration(sec=3))\n"
        "    point.positions = [shift, *STARTS[0][1:]]\n"
        "    goal.trajectory.points = [point]\n"
        "    sent = arm.send_goal_async(goal)\n"
        "    rclpy.spin_until_future_complete(node, sent)\n"
        "    result = sent.result().get_result_async()\n"
        "    rclpy.spin_until_future_complete(node, result)\n"
    )
    example.write("c.py", ROS2_TIMER.replace("node.create_timer(2.0, tick)\n", "") + motions)
    outcome = example.run("trace", "c.py", "--json", "--duration", "8")
    assert outcome.code == 0, outcome.err
    assert outcome.json["trace"]["end"]["cause"] == "duration"


# `sys.exit` ends as the last line does: by an exception or none, the interpreter returns.
@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("end", "code"),
    slow_but(
        [("", 0), ("import os\nos._exit(0)\n", 0)],
        [("", 0), ("sys.exit(0)\n", 0), ("import os\nos._exit(0)\n", 0)],
    ),
)
def test_a_motion_that_is_under_way_when_the_controller_ends_is_carried_out(run, ended, end, code):
    left = run(
        "arm.set_joint_value_target([0.2, -0.785, 0, -2.356, 0, 1.571, 0.785])\n"
        f"arm.go(wait=False)\n{end}",
        code=code,
    )["trace"]
    assert [visit["outcome"] for visit in left["visits"]] == ["succeeded"]
    awaited = ended["trace"]["visits"][0]["exposures"]["panda_joint1"]
    moved = [awaited["moving_s"], left["active"]["panda_joint1"]["moving_s"]]
    assert moved[0] > 0.3
    assert moved[1] == pytest.approx(moved[0], rel=0.01)


def test_a_motion_outlasts_a_controller_no_longer_than_the_run_may_last(run):
    data = run(
        "arm.set_max_velocity_scaling_factor(0.001)\n"
        "arm.set_joint_value_target([0.2, -0.785, 0, -2.356, 0, 1.571, 0.785])\n"
        "arm.go(wait=False)\n",
        "--duration",
        "5",
    )
    assert data["trace"]["end"]["simulated_s"] == pytest.approx(5.0, abs=0.1)
    assert data["trace"]["visits"][-1]["outcome"] == "unfinished"


STREAM = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rospy.init_node("stream")
topic = "/position_joint_trajectory_controller/command"
commands = rospy.Publisher(topic, JointTrajectory, queue_size=1)
names = [f"panda_joint{number}" for number in range(1, 8)]

def send(turn):
    point = JointTrajectoryPoint(time_from_start=rospy.Duration(5))
    point.positions = [turn, -0.785, 0, -2.356, 0, 1.571, 0.785]
    commands.publish(JointTrajectory(joint_names=names, points=[point]))

"""
RATE = "rate = rospy.Rate(1)\n"


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("body", "cause"),
    [
        # Two goals that are near each other are one, and more.
        pytest.param(
            f"{RATE}while not rospy.is_shutdown():\n    send(0.2)\n    rate.sleep()\n",
            "idle",
            marks=pytest.mark.slow,
        ),
        ("rospy.Timer(rospy.Duration(1), lambda _: send(0.2))\nrospy.spin()\n", "idle"),
        (f"{RATE}while True:\n    send(0.2)\n    send(0.21)\n    rate.sleep()\n", "idle"),
        (
            f"{RATE}n = 0\nwhile True:\n    send(0.2 * (n % 7))\n    n += 1\n    rate.sleep()\n",
            "duration",
        ),
        (
            "while True:\n    send(0.2)\n    rospy.sleep(6)\n    send(0)\n    rospy.sleep(6)\n",
            "cycles",
        ),
    ],
    ids=["one goal in a loop", "by a timer", "two near goals", "other goals", "goals that arrive"],
)
def test_the_same_goal_again_and_again_that_never_arrives_ends_a_run(example, body, cause):
    example.write("c.py", STREAM + body)
    outcome = example.run("trace", "c.py", "--robot", "panda", "--duration", "75", "--json")
    end = outcome.json["trace"]["end"]
    assert end["cause"] == cause, outcome.err
    if cause == "idle":
        assert "nothing but the same was commanded in 60 s" in end["message"]
        assert end["message"].endswith("each was replaced by the next one before its time was over")
        assert end["simulated_s"] < 70


# Without a pause, a call begins with each answer: a thousand in a second, which computes for long.
@pytest.mark.parametrize("pause", slow_but(["time.sleep(0.2)"], ["time.sleep(0.2)", ""]))
def test_a_service_that_is_called_again_and_again_for_the_same_ends_a_run(example, pause):
    example.write(
        "c.py",
        """\
import time
import rclpy
from open_manipulator_msgs.srv import SetJointPosition

def main():
    rclpy.init()
    node = rclpy.create_node("op")
    node.create_timer(1.0, lambda: None)
    path = node.create_client(SetJointPosition, "goal_joint_space_path")
    request = SetJointPosition.Request(path_time=5.0)
    request.joint_position.joint_name = [f"joint{number}" for number in range(1, 5)]
    request.joint_position.position = [0.1, 0.0, 0.0, 0.0]
    while rclpy.ok():
        rclpy.spin_once(node)
        path.call_async(request)
"""
        + f"        {pause}\n\nmain()\n",
    )
    outcome = example.run(
        "trace", "c.py", "--robot", "open_manipulator_x", "--duration", "90", "--json"
    )
    end = outcome.json["trace"]["end"]
    assert end["cause"] == "idle", outcome.err
    assert end["simulated_s"] < 70
