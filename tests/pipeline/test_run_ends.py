"""When a run without an end of its own is over."""

from __future__ import annotations

import pytest

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


def test_the_number_of_cycles_is_a_setting(run):
    data = run("while True:\n    back()\n    there()\n", "--mission-cycles", "4")
    assert follows(data)["there"] == {"back": "3/4", "done": "1/4"}


def test_a_state_machine_is_seen_over_several_iterations(run):
    data = run("n = 0\nwhile True:\n    (there if n % 2 else back)()\n    n += 1\n")
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 6


def test_timers_that_repeat_end_a_spin(run):
    data = run(
        "def tick(event):\n    there()\n    back()\nrospy.Timer(rospy.Duration(5), tick)\nrospy.spin()\n"
    )
    assert data["trace"]["end"]["cause"] == "cycles"
    assert len(data["trace"]["visits"]) == 6


def test_a_loop_with_an_end_of_its_own_is_not_cut(run):
    body = (
        "n = 0\nwhile True:\n    there()\n    back()\n    n += 1\n    if n == 5:\n        break\n"
    )
    data = run(body)
    assert data["trace"]["end"]["cause"] == "ended"
    assert len(data["trace"]["visits"]) == 10


WORK = "there()\nback()\n"
IDLE = "rate = rospy.Rate(10)\nwhile not rospy.is_shutdown():\n    rate.sleep()\n"


@pytest.mark.parametrize(
    "end",
    [
        "rospy.spin()\n",
        IDLE,
        "import time\nwhile True:\n    time.sleep(1.0)\n",
        "rospy.Subscriber('/joint_states', rospy.AnyMsg, lambda m: None)\nrospy.spin()\n",
        "rospy.Timer(rospy.Duration(1.0), lambda e: None)\nrospy.spin()\n",
    ],
)
def test_idling_after_the_work_is_no_risk(run, end):
    returned = run(WORK)
    idled = run(WORK + end)
    assert idled["trace"]["end"]["cause"] in ("idle", "quiescent")
    assert risk(idled) == pytest.approx(risk(returned), rel=0.01)


def test_a_pause_within_a_mission_is_not_cut(run):
    pause = "t = rospy.get_time() + 30\nwhile rospy.get_time() < t:\n    rospy.sleep(0.1)\n"
    data = run(WORK + pause + "there()\n" + IDLE)
    assert len(data["trace"]["visits"]) == 3
    assert 30.0 < data["trace"]["end"]["simulated_s"] < 40.0


def test_a_loop_in_which_nothing_moves_fails_early(run):
    data = run(IDLE, code=4)
    assert data["trace"]["end"]["cause"] == "no_motion"
    assert data["trace"]["end"]["simulated_s"] < 61.0
