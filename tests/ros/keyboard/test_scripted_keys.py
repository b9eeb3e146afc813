"""Controllers that read single keys of a terminal."""

from itertools import pairwise

import pytest

from tracerisk.errors import Location
from tracerisk.instrument.source.literals.known_keys import known_keys

HEAD = """\
import os, select, sys, termios, tty
import moveit_commander, rospy

moveit_commander.roscpp_initialize(sys.argv)
rospy.init_node("keys")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)

def jog(delta):
    joints = arm.get_current_joint_values()
    joints[0] += delta
    arm.go(joints, wait=True)

"""
BLOCKING = """\
UP, DOWN = "\\x1b[A", "\\x1b[B"

def pressed():
    before = termios.tcgetattr(sys.stdin)
    tty.setcbreak(0)
    try:
        return os.read(sys.stdin.fileno(), 8).decode()
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, before)

while not rospy.is_shutdown():
    key = pressed()
    if key == UP:
        jog(0.1)
    elif key == DOWN:
        jog(-0.1)
"""
POLLED = """\
def pressed(timeout=0.05):
    tty.setraw(sys.stdin)
    ready, _, _ = select.select([sys.stdin], [], [], timeout)
    return sys.stdin.read(1) if ready else ""

bindings = {"a": 0.1, "z": -0.1}
while True:
    key = pressed()
    if key in bindings:
        jog(bindings[key])
    elif key in ("q", "\\x03"):
        break
"""


@pytest.fixture
def run(example):
    def run(body: str, *arguments: str):
        example.write("keys.py", HEAD + body)
        outcome = example.run("run", "keys.py", "--json", *arguments)
        assert outcome.code == 0, outcome.err
        return outcome.json["trace"]

    return run


def test_answers_are_keys_where_lines_are_off(run):
    trace = run(BLOCKING, "--answer", "\x1b[A", "--answer", "\x1b[A", "--answer", "\x1b[B")
    assert trace["verdict"]["kind"] == "complete"
    assert trace["end"]["message"].startswith("nothing can happen any more: MainThread waits for a")
    # Each is pressed a second after the one before was read.
    times = [each["start_s"] for each in trace["visits"]]
    assert len(times) == 3
    assert all(later - sooner >= 1.0 for sooner, later in pairwise([0.0, *times]))


def test_a_key_that_nobody_presses_lets_a_poll_go_on(run):
    trace = run(POLLED, "--answer", "a", "--answer", "q")
    assert trace["verdict"]["kind"] == "complete"
    assert trace["end"]["cause"] == "ended"
    assert len(trace["visits"]) == 1


# How a poll is given its keys is above, and which are drafted below.
@pytest.mark.parametrize(
    "body",
    [
        pytest.param(BLOCKING, id="blocking"),
        pytest.param(POLLED, id="polled", marks=pytest.mark.slow),
    ],
)
def test_the_keys_that_the_code_knows_are_drafted(run, body):
    trace = run(body)
    assert trace["verdict"]["kind"] == "partial"
    assert {each["code"] for each in trace["verdict"]["reasons"]} == {"input-assumed"}
    assert len(trace["visits"]) == 2


def test_known_keys_are_in_the_order_of_the_code_and_what_ends_it_comes_last(tmp_path):
    source = tmp_path / "keys.py"
    source.write_text(
        "if k == '\\x1b' or k == 'quit': pass\n"
        "elif k in 'wa': pass\n"
        "elif k in ['s', 'word']: pass\n"
        "moves = {'i': 1, 'k': -1}\n"
        "other = {'i': 1, 'speed': 2}\n"
        "match k:\n    case ' ': pass\n"
    )
    place = Location(str(source), 1)
    assert known_keys(place) == ("w", "a", "s", "i", "k", " ", "\x1b")
    assert known_keys(None) == ()
