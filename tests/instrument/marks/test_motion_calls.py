"""Which calls at given places command motion."""

import pytest

from tracerisk.instrument.marks.call_log import Calls
from tracerisk.instrument.motion_calls import Commanding, calls_at, missed_calls

SOURCE = """\
class Node:
    def move(self):
        self.joints.publish(message())
        self.client.send(goal).add_done_callback(self.done)
        self.close(True)
        reach()
        self.arms[0].reach()
"""


def test_calls_are_reported_as_they_are_written_and_by_their_last_name_where_that_is_rare():
    assert calls_at(SOURCE.encode(), {(3, 9)}) == {"self.joints.publish"}
    assert calls_at(SOURCE.encode(), {(4, 9)}) == {"self.client.send", "send"}
    assert calls_at(SOURCE.encode(), {(5, 9), (6, 9)}) == {"self.close", "close", "reach"}


def test_what_is_no_plain_name_or_no_call_says_nothing():
    assert calls_at(SOURCE.encode(), {(7, 9), (1, 1)}) == frozenset()
    assert calls_at(b"def (", {(1, 1)}) == frozenset()


GRIP = """\
import robot
def grip(width):
    if width >= 0:
        robot.command(width)
"""


@pytest.fixture
def missed(run):
    """Return what runs a controller and returns its missed calls: line, call, executed or not."""

    def of_source(source: str) -> list[tuple[int, str, bool]]:
        ran = run(source)
        frames = [frame for command in ran.commands for frame in command.stack]
        commanding = Commanding(
            frozenset(place for frame in frames for place in frame.places),
            frozenset(frame.function for frame in frames),
        )
        calls = Calls.of(ran.tracer.executed_calls())
        found = missed_calls(ran.path.read_bytes(), "controller.py", commanding, calls)
        return [(call.line, call.written, call.was_executed) for call in found]

    return of_source


def test_a_call_whose_function_turned_back_was_in_vain(missed):
    assert missed(GRIP + "grip(1)\ngrip(-1)\n") == [(6, "grip", True)]


def test_a_call_that_was_not_executed_is_missed_where_the_same_one_commanded(missed):
    source = GRIP + "grip(1)\nif not grip:\n    grip(2)\n    robot.command(3)\n"
    assert missed(source) == [(7, "grip", False), (8, "robot.command", False)]


BACK = "grip(-1)"
IN_VAIN = {
    "plain": f"grip(1)\n{BACK}\n",
    "by a function of its own": f"def close():\n    {BACK}\ngrip(1)\nclose()\n",
    "by one function for both": "def way(width):\n    grip(width)\nway(1)\nway(-1)\n",
    "by a lambda": f"grip(1)\n(lambda: {BACK})()\n",
    "by a partial": "from functools import partial\ngrip(1)\npartial(grip, -1)()\n",
    "by a generator": f"def work():\n    {BACK}\n    yield\ngrip(1)\nfor _ in work(): pass\n",
    "by a nested function": f"def main():\n    def back():\n        {BACK}\n    grip(1)\n    back()\nmain()\n",
    "by a context manager": (
        "from contextlib import contextmanager\n@contextmanager\ndef held():\n"
        f"    grip(1)\n    yield\n    {BACK}\nwith held(): pass\n"
    ),
    "by a coroutine": f"import asyncio\nasync def main():\n    grip(1)\n    {BACK}\nasyncio.run(main())\n",
    "never iterated": "def two():\n    grip(1)\n    yield\nlist(two())\ntwo()\n",
    "never awaited": (
        "import asyncio\nasync def reach():\n    grip(1)\nasync def main():\n"
        "    await reach()\n    reach().close\nasyncio.run(main())\n"
    ),
}


@pytest.mark.filterwarnings("ignore:coroutine")
@pytest.mark.parametrize("way", IN_VAIN)
def test_a_call_in_vain_is_missed_however_it_is_written(missed, way):
    found = missed(GRIP + IN_VAIN[way])
    assert [was_executed for *_, was_executed in found] == [True]


WORKING = {
    "generator": "def work():\n    for x in (1, 2):\n        grip(x)\n        yield\nfor _ in work(): pass\n",
    "delegating generator": "def a():\n    grip(1)\n    yield\ndef b():\n    yield from a()\nlist(b())\n",
    "generator made early": "def a():\n    grip(1)\n    yield\nmade = a()\ngrip(2)\nnext(made)\n",
    "context manager": (
        "from contextlib import contextmanager\n@contextmanager\ndef held():\n"
        "    grip(1)\n    yield\n    grip(0)\nwith held():\n    grip(2)\n"
    ),
    "context manager of a class": (
        "class Held:\n    def __enter__(self): grip(1)\n    def __exit__(self, *_): grip(0)\n"
        "with Held():\n    grip(2)\n"
    ),
    "list of lambdas": "for step in [lambda: grip(1), lambda: grip(2)]: step()\ngrip(3)\n",
    "lambda by name": "step = lambda width: grip(width)\nstep(1)\ngrip(2)\n",
    "lambda in a lambda": "step = lambda: (lambda: grip(1))()\nstep()\ngrip(2)\n",
    "partial": "from functools import partial\nstep = partial(grip, 1)\nstep()\ngrip(2)\n",
    "map": "list(map(grip, [1, 2]))\ngrip(3)\n",
    "nested function": "def main():\n    def step(): grip(1)\n    step()\n    grip(2)\nmain()\n",
    "exec": "exec('grip(1)')\nexec('x = 1')\ngrip(2)\n",
    "function made by exec": "made = {'grip': grip}\nexec('def f(): grip(1)', made)\nexec('f()', made)\n",
    "except that was not needed": "try:\n    grip(1)\nexcept ValueError:\n    grip(0)\n",
    "except that was needed": "try:\n    grip('x')\nexcept TypeError:\n    grip(0)\n",
    "what only a script runs": "grip(1)\nif __name__ == 'other':\n    grip(2)\n",
    "comprehension": "[grip(x) for x in (1, 2)]\ngrip(3)\n",
    "coroutine": "import asyncio\nasync def main():\n    grip(1)\nasyncio.run(main())\ngrip(2)\n",
    "task": (
        "import asyncio\nasync def reach():\n    grip(1)\nasync def main():\n"
        "    await asyncio.gather(reach(), asyncio.create_task(reach()))\n    await reach()\n"
        "asyncio.run(main())\n"
    ),
    "thread": "import threading\nt = threading.Thread(target=lambda: grip(1))\nt.start()\nt.join()\ngrip(2)\n",
    "retrying decorator": (
        "def retried(f):\n    def call(*given):\n        try:\n            return f(*given)\n"
        "        except ValueError:\n            grip(0)\n    return call\n"
        "@retried\ndef pick():\n    grip(1)\n@retried\ndef look(): robot.show(1)\npick()\nlook()\n"
    ),
    "one call for all services": (
        "def call(name, **given):\n    client(name, given)\n"
        "def client(name, given):\n    if name == 'move': robot.command(1)\n    else: robot.show(name)\n"
        "grip(1)\ncall('mode')\ncall('state')\ncall('move')\nif not robot:\n    call('clear')\n"
    ),
    "one step for all kinds": (
        "def step(kind):\n    if kind == 'move': grip(1)\n    elif kind == 'wait': robot.show(1)\n"
        "step('wait')\nstep('move')\nstep('wait')\n"
    ),
    "call over several lines": "grip(1)\n(robot\n    .command(1))\n(robot\n .command(2))\n",
    "stateful steps": (
        "class Cell:\n    busy = False\n    def tick(self):\n        if self.busy: return\n"
        "        grip(1)\n        self.busy = True\ncell = Cell()\nfor _ in range(3): cell.tick()\n"
    ),
}


@pytest.mark.parametrize("way", WORKING)
def test_what_works_misses_nothing_however_it_is_written(missed, way):
    assert missed(GRIP + WORKING[way]) == []


def test_a_source_that_is_no_python_misses_nothing():
    commanding = Commanding(frozenset(), frozenset())
    calls = Calls(frozenset(), (), frozenset(), frozenset())
    assert missed_calls(b"def (", "controller.py", commanding, calls) == ()


def test_what_commands_by_what_it_is_given_is_no_motion_call_by_its_name():
    assert calls_at(b"exec('arm.go()')\narm.exec()\n", {(1, 1), (2, 1)}) == {"arm.exec", "exec"}
    assert calls_at(b"exec('arm.go()')\n", {(1, 1)}) == frozenset()


@pytest.mark.parametrize("call", ["move()", "getattr(robot, 'com' + 'mand')(1)", "exec(text)"])
def test_a_call_that_was_not_executed_is_missed_where_nobody_can_read_what_it_commands(
    missed, call
):
    source = f"{GRIP}grip(1)\nmove = robot.command\nif not grip:\n    {call}\n"
    assert [(line, executed) for line, _, executed in missed(source)] == [(8, False)]
