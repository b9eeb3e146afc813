"""Calls that command: the verdict rests on those that were executed, however they are written."""

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


def test_the_same_motions_are_complete_however_they_are_called(example):
    """All ways in one program: what is said of a call names its line."""
    example.write("cell.py", CELL + "".join(SAME.values()))
    outcome = example.run("run", "cell.py", "--json")
    assert outcome.code == 0, outcome.err
    verdict = outcome.json["verdict"]
    assert (verdict["kind"], verdict["reasons"]) == ("complete", [])
    moved = [visit["function"]["name"] for visit in outcome.json["trace"]["visits"]]
    assert len(moved) >= 2 * len(SAME)


# Of each way, after a call that commands: the call that commands nothing, and what is said of it.
IN_VAIN = {
    "turned back": ("is_ready = False\ngo(-0.1)  # in vain\n", "go led to no command"),
    "turned back in a wrapper": (
        "def there(x):\n    go(x)\nthere(0.2)\nis_ready = False\nthere(-0.1)  # in vain\n",
        "there led to no command",
    ),
    "generator that nobody iterates": (
        "def work():\n    go(0.1)\n    yield\nlist(work())\nwork()  # in vain\n",
        "work led to no command",
    ),
    "branch": ("if not is_ready:\n    go(-0.1)  # in vain\n", "go never ran"),
    "branch in a lambda": (
        "step = lambda: go(0.2) if is_ready else go(-0.1)  # in vain\nstep()\n",
        "go never ran",
    ),
}


def test_a_call_that_commanded_nothing_is_reported_however_it_is_written(example):
    program = CELL + "".join(f"is_ready = True\ngo(0.1)\n{code}" for code, _ in IN_VAIN.values())
    example.write("cell.py", program)
    outcome = example.run("run", "cell.py", "--check", "--json")
    assert outcome.json["verdict"]["kind"] == "partial", outcome.err
    reported = {
        each["location"]["line"]: each["words"]
        .removeprefix("this call of ")
        .removesuffix(": what it would command is in no figure")
        .partition("; another ")[0]
        for each in outcome.json["verdict"]["reasons"]
    }
    marked = [n for n, line in enumerate(program.splitlines(), start=1) if "# in vain" in line]
    assert reported == dict(zip(marked, (words for _, words in IN_VAIN.values()), strict=True))
