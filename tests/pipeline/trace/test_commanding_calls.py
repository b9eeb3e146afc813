"""Calls that command: the verdict rests on those that were executed, however they are written."""

import pytest

from tests.slow import slow_but

CELL = """\
import atexit, functools
from contextlib import contextmanager
import moveit_commander, rospy

rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.set_max_velocity_scaling_factor(1.0)
is_ready = True

def go(x):
    if is_ready:
        arm.go([x, -0.7, 0.0, -2.3, 0.0, 1.5, 0.7], wait=True)

"""

SAME = {
    "loop": "for x in (0.1, -0.1):\n    go(x)\n",
    "generator": (
        "def work():\n    for x in (0.1, -0.1):\n        go(x)\n        yield x\n"
        "for _ in work():\n    pass\n"
    ),
    "context manager": (
        "@contextmanager\ndef there():\n    go(0.1)\n    yield\n    go(-0.1)\n"
        "with there():\n    pass\n"
    ),
    "lambdas": "for step in [lambda: go(0.1), lambda: go(-0.1)]:\n    step()\n",
    "partial": "functools.partial(go, 0.1)()\ngo(-0.1)\n",
    "wrapper": "def step(f, *given):\n    return f(*given)\nstep(go, 0.1)\nstep(len, ())\nstep(go, -0.1)\n",
    "nested": "def main():\n    def there():\n        go(0.1)\n    there()\n    go(-0.1)\nmain()\n",
    "exec": "exec('go(0.1)')\nexec('x = -0.1')\ngo(x)\n",
    "at exit": "atexit.register(lambda: go(-0.1))\ngo(0.1)\n",
    "timer": (
        "go(0.1)\nrospy.Timer(rospy.Duration(0.1), lambda event: go(-0.1), oneshot=True)\n"
        "rospy.sleep(5.0)\n"
    ),
    "retry in a function": (
        "def back():\n    go(0.0)\ntry:\n    go(0.1)\nexcept ValueError:\n    back()\ngo(-0.1)\n"
    ),
    "retry": (
        "try:\n    go(0.1)\n    if not arm.go():\n        raise ValueError\n"
        "except ValueError:\n    go(0.0)\ngo(-0.1)\n"
    ),
}


@pytest.mark.parametrize("way", slow_but(("generator", "timer"), [*SAME]))
def test_the_same_motions_are_complete_however_they_are_called(example, way):
    example.write("cell.py", CELL + SAME[way])
    outcome = example.run("run", "cell.py")
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith("complete, "), outcome.out[:300]


IN_VAIN = {
    "turned back": ("go(0.1)\nis_ready = False\ngo(-0.1)\n", "go led to no command"),
    "turned back in a wrapper": (
        "def there(x):\n    go(x)\nthere(0.1)\nis_ready = False\nthere(-0.1)\n",
        "there led to no command",
    ),
    "generator that nobody iterates": (
        "def work():\n    go(0.1)\n    yield\nlist(work())\nwork()\n",
        "work led to no command",
    ),
    "branch": ("go(0.1)\nif not is_ready:\n    go(-0.1)\n", "go never ran"),
    "branch in a lambda": (
        "step = lambda: go(0.1) if is_ready else go(-0.1)\nstep()\n",
        "go never ran",
    ),
}


@pytest.mark.parametrize(
    "way", slow_but(("turned back", "generator that nobody iterates", "branch"), [*IN_VAIN])
)
def test_a_call_that_commanded_nothing_is_reported_however_it_is_written(example, way):
    source, words = IN_VAIN[way]
    example.write("cell.py", CELL + source)
    outcome = example.run("run", "cell.py")
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith(f"partial: this call of {words}; another "), outcome.out[:300]
