"""The rules of a described driver: what waits, what is dropped, what is refused, and its codes."""

import pytest

from tracerisk.errors import DriverError
from tracerisk.ros.vendors.description_reader import read_driver

MESSAGES = """
definitions:
  arm_msgs/srv/Go: |
    float64[] q
    float64 speed
    bool wait
    ---
    int32 code
    string message
    bool moving
    int32 queued
  arm_msgs/srv/Do: |
    int32 what
    ---
    int32 code
    string status
    int32 error
  arm_msgs/action/Reach: |
    float64[] q
    ---
    int32 code
    string message
    ---
    float64 first
  arm_msgs/msg/Rates: |
    float64[] rate
"""
HEAD = """
import rospy
from arm_msgs.srv import Do, DoRequest, Go
rospy.init_node('cell')
def go(q, speed=0.0, wait=True, name='/go'):
    return rospy.ServiceProxy(name, Go)(q, speed, wait)
def do(what):
    return rospy.ServiceProxy('/do', Do)(what)
A, B, HOME = [0.5] + [0.0] * 5, [1.0] + [0.0] * 5, [0.0] * 6
"""
GO = "move: {joints: q, speed: speed}, wait: wait, response: {code: $code, message: $message, moving: $moving, queued: $queued}"
CODES = "codes: {succeeded: 0, busy: 5, disabled: 6, in_error: 7, invalid_goal: 8, bad_request: 9, timeout: 10, preempted: 11, aborted: 12, failed: 99}"


def described(rule: str, more: str = "") -> str:
    return f"driver: arm\n{CODES}\nwhile_moving: {rule}\n{more}\nservices:\n  go: {{type: arm_msgs/Go, {GO}}}\n"


@pytest.mark.slow(but=2)
@pytest.mark.parametrize(
    ("rule", "second", "queued", "where"),
    [("replace", 0, 1, 1.0), ("queue", 0, 2, 1.0), ("reject", 5, 1, 0.5), ("wait", 0, 1, 1.0)],
)
def test_what_becomes_of_a_motion_during_another(run_on, rule, second, queued, where):
    ran = run_on(
        "ur5e",
        HEAD
        + """
first = go(A, 0.2, wait=False)
begun = rospy.get_time()
second = go(B, 0.2, wait=False)
took = rospy.get_time() - begun
rospy.sleep(25)
""",
        driver=described(rule) + MESSAGES,
    )
    assert (ran["first"].code, ran["first"].moving) == (0, True)
    assert (ran["second"].code, ran["second"].queued) == (second, queued)
    assert (ran["took"] > 1.5) == (rule == "wait")
    assert ran.position("shoulder_pan_joint") == pytest.approx(where, abs=0.01)


def test_speeds_of_joints_are_kept(run_on):
    ran = run_on(
        "ur5e",
        HEAD
        + """
go(HOME)
begun = rospy.get_time()
go(A, 0.1)
slow = rospy.get_time() - begun
begun = rospy.get_time()
go(HOME)
fast = rospy.get_time() - begun
""",
        driver=described("replace") + MESSAGES,
    )
    assert ran["slow"] == pytest.approx(5.0, abs=0.3)
    assert ran["fast"] < 1.5


@pytest.mark.parametrize(
    ("given", "code", "expected"),
    [
        ("[0.1] * 5", 8, "5 joint values for 6 joints"),
        ("[9.0] + [0.0] * 5", 8, "9.000 for 'shoulder_pan_joint' is outside"),
        ("[float('nan')] * 6", 9, "services.go.move.joints holds a number that is not finite"),
        ("[]", 8, "0 joint values for 6 joints"),
        ("[0.1] * 6 + [0.0]", 0, "succeeded"),
        ("[0.1] * 6 + [0.2]", 8, "7 joint values for 6 joints"),
    ],
)
def test_a_goal_that_the_arm_has_not_is_answered_and_reported(run_on, given, code, expected):
    ran = run_on("ur5e", f"{HEAD}\ndone = go({given})\n", driver=described("replace") + MESSAGES)
    assert (ran["done"].code, expected in ran["done"].message) == (code, True), ran["done"]
    assert any(expected in each for each in ran.findings) == (code != 0)


def test_an_error_stays_until_it_is_cleared_and_states_are_reported(run_on):
    do = """
  do:
    type: arm_msgs/Do
    response: {code: $code, status: $status, error: $error}
    cases:
      - {when: {what: 1}, clear: true}
      - {when: {what: 2}, set: {enabled: {value: true}}}
      - {when: {what: 3}, set: {enabled: {value: false}}}
      - {when: {what: 4, $mode: [1, fast]}, refuse: not in this mode}
      - {when: {what: 5}, set: {mode: {value: fast}}}
"""
    ran = run_on(
        "ur5e",
        HEAD
        + """
steps = [do(0), go([9.0] * 6), do(5), go(A), do(2), go(A), do(1), go(A), do(2), go(A), do(3), go(A),
         do(2), do(4)]
codes = [each.code for each in steps]
states = [each.status for each in steps if hasattr(each, 'status')]
errors = [each.error for each in steps if hasattr(each, 'error')]
""",
        driver=described(
            "replace", "errors: {invalid_goal: 21}\nerror_disables: true\nstate: {mode: slow}"
        )
        + do
        + MESSAGES,
    )
    assert ran["codes"] == [9, 8, 0, 7, 0, 7, 0, 0, 0, 0, 0, 6, 0, 99]
    assert ran["errors"] == [0, 21, 21, 0, 0, 0, 0, 0]
    assert ran["states"] == [
        "idle",
        "disabled",
        "error",
        "idle",
        "idle",
        "disabled",
        "idle",
        "idle",
    ]
    assert any("what 0 is not simulated; allowed: 1, 2, 3, 4, 5" in each for each in ran.findings)
    assert any("do: not in this mode" in each for each in ran.findings)


def test_a_call_waits_no_longer_than_its_timeout(run_on):
    ran = run_on(
        "ur5e",
        HEAD + "done = go(B, 0.1)\nat = rospy.get_time()\n",
        driver=described("replace").replace("wait: wait,", "wait: wait, timeout: {value: 1.5},")
        + MESSAGES,
    )
    assert ran["done"].code == 10
    assert "takes longer than 1.5 s" in ran["done"].message


def test_a_goal_can_be_cancelled_replaced_and_followed_by_feedback(run_on):
    ran = run_on(
        "ur5e",
        """
import actionlib, rospy
from arm_msgs.msg import ReachAction, ReachGoal
rospy.init_node('cell')
told = []
def send(name, turn):
    client = actionlib.SimpleActionClient(name, ReachAction)
    client.wait_for_server()
    client.send_goal(ReachGoal([turn] + [0.0] * 5), feedback_cb=lambda each: told.append(each.first))
    return client
first = send('/left/reach', 2.0)
rospy.sleep(0.5)
first.cancel_goal()
first.wait_for_result()
cancelled = first.get_state(), first.get_result().code
old, new = send('/left/reach', 1.0), None
rospy.sleep(0.3)
new = send('/right/reach', -0.5)
new.wait_for_result()
old.wait_for_result()
replaced, reached = (old.get_state(), old.get_result().code), new.get_state()
bad = send('/left/reach', 9.0)
bad.wait_for_result()
refused = bad.get_state(), bad.get_result().code
""",
        driver=f"driver: arm\n{CODES}\nactions:\n  reach:\n    type: arm_msgs/Reach\n"
        "    move: {joints: q, speed: 1.0}\n    rate: 20\n    feedback: {first: '$joints[0]'}\n"
        "    result: {code: $code, message: $message}\n" + MESSAGES,
    )
    assert ran["cancelled"] == (2, 11)
    assert (ran["replaced"], ran["reached"]) == ((2, 11), 3)
    assert ran["refused"] == (4, 8)
    assert len(ran["told"]) > 10
    assert ran.position("shoulder_pan_joint") == pytest.approx(-0.5, abs=0.01)


def test_velocities_of_a_topic_end_without_another(run_on):
    ran = run_on(
        "ur5e",
        """
import rospy
from arm_msgs.msg import Rates
rospy.init_node('cell')
publisher = rospy.Publisher('/rates', Rates, queue_size=1)
def jog():
    for _ in range(100):
        publisher.publish(Rates([0.5, 0, 0, 0, 0, 0]))
        rospy.sleep(0.02)
jog()
rospy.sleep(2.0)
""",
        driver="driver: arm\nsubscribed_topics:\n  rates:\n    type: arm_msgs/Rates\n"
        "    velocity: {joints: rate, duration: 0.1}\n" + MESSAGES,
    )
    assert ran.position("shoulder_pan_joint") == pytest.approx(1.05, abs=0.06)
    assert ran.owners == ["jog"]


@pytest.mark.parametrize("group", ["group: {side}_arm, ", ""])
def test_one_of_two_arms_is_meant_by_its_group_or_by_the_side_in_a_name(run_on, group):
    services = "".join(
        f"  {side}/go: {{type: arm_msgs/Go, {group.format(side=side)}{GO}}}\n"
        for side in ("right", "left")
    )
    ran = run_on(
        "baxter",
        HEAD
        + """
done = go([0.3] + [0.0] * 6, name='/cell/right/go')
""",
        driver=f"driver: arm\n{CODES}\nservices:\n{services}" + MESSAGES,
    )
    assert ran["done"].code == 0, ran["done"]
    assert ran.position("right_s0") == pytest.approx(0.3, abs=0.02)
    assert ran.position("left_s0") != pytest.approx(0.3, abs=0.02)


MODES = """
driver: arm
codes: {succeeded: 0, disabled: 6}
state: {mode: 0}
remedies: {disabled: "call /do with 1"}
trajectories: {needs: {mode: 0}}
services:
  go:
    type: arm_msgs/Go
    cases:
      - {when: {$mode: 0}, move: {joints: q, speed: speed}, wait: wait, response: &code {code: $code}}
      - {when: {$mode: 1}, stream: true, move: {joints: q}, response: *code}
      - {ignore: "mode $mode moves nothing", response: *code}
  do: {type: arm_msgs/Do, set: {mode: what, enabled: {value: true}}}
  off: {type: arm_msgs/Do, set: {enabled: {value: false}}}
  reach: {type: arm_msgs/Go, set_tool: {pose: q}}
"""


@pytest.mark.parametrize(
    ("steps", "code", "commands", "words"),
    [
        ("", 0, 1, ""),
        ("do(1)", 0, 1, ""),
        ("do(2)", 0, 0, "go moved nothing: mode 2 moves nothing"),
        ("rospy.ServiceProxy('/off', Do)(0)", 6, 0, "is not enabled; call /do with 1"),
    ],
)
def test_a_mode_says_what_a_call_does(run_on, steps, code, commands, words):
    ran = run_on(
        "ur5e", HEAD + f"{steps}\ncode = go(A).code\nrospy.sleep(3.0)\n", driver=MODES + MESSAGES
    )
    assert (ran["code"], len(ran.recording.commands)) == (code, commands)
    assert [each for each in ran.findings if words in each] == ran.findings[: bool(words)]
    assert bool(ran.findings) == bool(words)


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("on_error: {speed: 1}", r"on_error\.speed: is not in 'state'; .*mode"),
        ("remedies: {aborted: wait}", "unknown key 'aborted'.*disabled"),
        ("trajectories: {needs: {state: 1}}", r"state: is not in 'state'"),
        ("services: {off: {type: arm_msgs/Do, stream: true}}", "stands without 'move'"),
    ],
)
def test_what_a_description_says_of_modes_is_checked(tmp_path, lines, message):
    path = tmp_path / "arm.driver.yaml"
    served = "" if "services" in lines else "services: {off: {type: arm_msgs/Do, stop: true}}\n"
    path.write_text(f"driver: arm\nstate: {{mode: 0}}\n{lines}\n{served}{MESSAGES}")
    with pytest.raises(DriverError, match=message):
        read_driver(path)
