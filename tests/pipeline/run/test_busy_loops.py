"""A loop that publishes without a wait advances as its publisher would."""

import pytest

HEAD = """\
import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

rospy.init_node("busy")
topic = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=10)
JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


def message(first, seconds):
    point = JointTrajectoryPoint(
        positions=[first, -0.785, 0, -2.356, 0, 1.571, 0.785],
        time_from_start=rospy.Duration(seconds),
    )
    return JointTrajectory(joint_names=JOINTS, points=[point])


"""


@pytest.fixture
def trace(example):
    def trace(body: str, *arguments: str):
        example.write("busy.py", HEAD + body)
        outcome = example.run("trace", "busy.py", "--robot", "panda", "--json", *arguments)
        return outcome.json["trace"], outcome

    return trace


def test_a_loop_that_publishes_without_a_wait_reaches_the_end_of_its_duration(trace):
    data, outcome = trace(
        "n = 0\nwhile not rospy.is_shutdown():\n    n += 1\n"
        "    topic.publish(message(0.0005 * n, 1.0))\n",
        *("--duration", "3", "--cpu-limit", "20"),
    )
    assert data["end"]["cause"] == "duration", outcome.err
    assert data["end"]["simulated_s"] == pytest.approx(3.0)


def test_a_busy_loop_that_never_looks_at_the_clock_moves_it(trace):
    data, outcome = trace(
        "while True:\n    topic.publish(message(0.3, 1.0))\n",
        *("--duration", "3", "--cpu-limit", "20"),
    )
    assert data["end"]["cause"] == "duration", outcome.err


# That the standstill ends the run, the goal below shows, which is sent again and again.
@pytest.mark.parametrize(
    ("seconds", "cause"), [("5", "duration"), pytest.param("600", "idle", marks=pytest.mark.slow)]
)
def test_what_a_loop_sends_again_once_it_was_carried_out_is_no_fault(trace, seconds, cause):
    data, _ = trace(
        "same = message(0.3, 1.0)\nsame.header.stamp = rospy.Time.now()\n"
        "while not rospy.is_shutdown():\n    topic.publish(same)\n",
        *("--duration", seconds),
    )
    assert data["end"]["cause"] == cause
    assert not [each for each in data["findings"] if each["kind"] == "command_ignored"]


def test_what_was_late_from_the_start_is_reported_once(trace):
    data, _ = trace(
        "late = message(0.5, 1.0)\nlate.header.stamp = rospy.Time.now()\nrospy.sleep(3)\n"
        "topic.publish(message(0.1, 1.0))\nrospy.sleep(3)\n"
        "for n in range(80):\n    topic.publish(late)\n"
    )
    found = [each for each in data["findings"] if each["kind"] == "command_ignored"]
    assert len(found) == 1
    assert "comes 5.000 s before the present" in found[0]["message"]


@pytest.mark.slow
def test_messages_that_follow_a_wait_or_are_few_take_no_time(trace):
    data, _ = trace(
        "topic.publish(message(0.1, 1.0))\nrospy.sleep(2)\nbegan = rospy.get_time()\n"
        "for n in range(40):\n    topic.publish(message(0.1 + n * 1e-3, 1.0))\n"
        "for n in range(100):\n    topic.publish(message(0.2, 1.0))\n    rospy.sleep(0.002)\n"
        "lasted = rospy.get_time() - began\nassert lasted < 0.25, lasted\nrospy.sleep(2)\n"
    )
    assert data["end"]["cause"] == "ended"


@pytest.mark.slow
def test_a_goal_that_is_sent_again_and_again_is_reached_once(trace):
    data, outcome = trace(
        "while not rospy.is_shutdown():\n    same = message(0.3, 1.0)\n"
        "    same.header.stamp = rospy.Time.now()\n    topic.publish(same)\n"
    )
    assert data["end"]["cause"] == "idle", outcome.err
    assert data["end"]["simulated_s"] < 20.0


LISTENS = """\
from sensor_msgs.msg import JointState

received = None


def receive(state):
    global received
    received = state


rospy.Subscriber("/joint_states", JointState, receive)
"""


@pytest.mark.parametrize(
    "wait",
    [
        "while received is None:\n    pass\n",
        "while True:\n    if received:\n        break\n",
        "while True:\n    if received:\n        received.header.seq = 0\n        break\n",
        "n = 0\nwhile not received:\n    n += 1\n",
    ],
)
def test_a_loop_that_waits_for_a_callback_goes_on_once_it_came(trace, wait):
    data, outcome = trace(f"{LISTENS}{wait}topic.publish(message(0.3, 1.0))\nrospy.sleep(2)\n")
    assert data["end"]["cause"] == "ended", outcome.err
    assert data["end"]["simulated_s"] == pytest.approx(2.0, abs=0.2)
