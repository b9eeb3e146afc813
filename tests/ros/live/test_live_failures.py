"""What fails within real rospy is in the trace of a live run, as it is on the stand-ins."""

import re

import pytest

from tracerisk import api

PROGRAM = """\
import threading

import actionlib
import rospy
from actionlib.msg import TestAction, TestGoal, TestResult
from actionlib_msgs.msg import GoalStatusArray
from control_msgs.msg import FollowJointTrajectoryAction
from std_msgs.msg import String
from std_srvs.srv import Trigger

ACTION = "/panda_arm_controller/follow_joint_trajectory"


def heard(message):
    raise ValueError("cannot read " + message.data)


def handle(request):
    raise KeyError("no part")


def turn(goal):
    raise IndexError("no turn")


def work():
    raise RuntimeError("no work")


def main():
    rospy.init_node("odd")
    # As roscpp's clients do: the status is listened to before there is a client.
    rospy.Subscriber(ACTION + "/status", GoalStatusArray, callback=lambda message: None)
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    print("> server", client.wait_for_server(rospy.Duration(5.0)))
    server = actionlib.SimpleActionServer("/turn", TestAction, execute_cb=turn, auto_start=False)
    server.start()
    asker = actionlib.SimpleActionClient("/turn", TestAction)
    asker.wait_for_server(rospy.Duration(5.0))
    asker.send_goal(TestGoal(1))
    asker.wait_for_result(rospy.Duration(5.0))
    rospy.Subscriber("/parts", String, heard)
    publisher = rospy.Publisher("/parts", String, queue_size=1, latch=True)
    publisher.publish(String("part"))
    rospy.Service("/give", Trigger, handler=handle)
    try:
        rospy.ServiceProxy("/give", Trigger)()
    except rospy.ServiceException:
        print("> refused")
    thread = threading.Thread(target=work, name="worker")
    thread.start()
    thread.join()
    for number in range(3):
        rospy.logerr("lost %d parts", number)
    try:
        publisher.publish(3.0, 4.0)
    except Exception as error:
        print("> caught", type(error).__name__)
    rospy.sleep(0.5)
    rospy.signal_shutdown("done")


if __name__ == "__main__":
    main()
"""
CODES = {"callback-raised": 3, "thread-raised": 1, "error-logged": 1, "call-raised": 1}


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    folder = tmp_path_factory.mktemp("failing")
    (folder / "pyproject.toml").touch()
    (folder / "odd.py").write_text(PROGRAM)
    return folder / "odd.py"


def traced(script, live_speed):
    controller = api.load_controller(script)
    settings = api.load_settings(controller, {"robot": "panda", "draft": False})
    return api.trace_controller(controller, settings, live_speed=live_speed)


def reasons(trace):
    return sorted(
        (reason.code, reason.message, reason.location and reason.location.line)
        for reason in trace.verdict.reasons
        if reason.code in CODES
    )


@pytest.mark.slow
def test_what_fails_is_said_as_on_the_stand_ins(real_ros, script, capfd):
    del real_ros
    live = traced(script, 1.0)
    printed = "".join(capfd.readouterr())
    twin = traced(script, None)
    also_printed = "".join(capfd.readouterr())
    lines = re.findall(r"^> .*$", printed, re.MULTILINE)
    assert lines == re.findall(r"^> .*$", also_printed, re.MULTILINE)
    assert lines[0] == "> server True"
    assert reasons(live) == reasons(twin)
    codes = [code for code, *_ in reasons(live)]
    assert {code: codes.count(code) for code in codes} == CODES
    assert live.verdict.kind == twin.verdict.kind == "faulted"
