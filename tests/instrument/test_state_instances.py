"""Which frames of a stack enter a state, and what its instance is called."""

import pytest

BASE = """
import robot
import threading

class EventState:
    pass

class Pick(EventState):
    def __init__(self, name=None):
        if name is not None:
            self._name = name

    def execute(self):
        self.approach()

    def approach(self):
        robot.command("pick")
"""


def entered(ran) -> list[list[tuple[str, str]]]:
    return [
        [(str(f.function.name), f.instance) for f in each.stack if f.instance is not None]
        for each in ran.commands
    ]


MACHINES = {
    "its own name": ("Pick('tray').execute()", "tray"),
    "no name": ("Pick().execute()", ""),
    "a key of its machine": (
        "class Machine:\n"
        "    def __init__(self):\n"
        "        self.held = {'TRAY': Pick('not this')}\n"
        "    def execute(self):\n"
        "        for state in self.held.values():\n"
        "            state.execute()\n"
        "Machine().execute()",
        "TRAY",
    ),
    "a key of a description": (
        "class Machine:\n"
        "    def __init__(self):\n"
        "        self.held = {'TRAY': {'state': Pick(), 'next': None}}\n"
        "    def run(self):\n"
        "        self.held['TRAY']['state'].execute()\n"
        "Machine().run()",
        "TRAY",
    ),
    "in a thread of its own": (
        "class Threaded(Pick):\n"
        "    def execute(self):\n"
        "        thread = threading.Thread(target=self.approach)\n"
        "        self.approach()\n"
        "Threaded('tray').execute()",
        "tray",
    ),
}


@pytest.mark.parametrize("machine", MACHINES)
def test_only_the_method_that_the_machine_calls_enters_the_state(run, machine):
    program, label = MACHINES[machine]
    (names,) = entered(run(BASE + program))
    assert [instance for _, instance in names] == [label]
    assert names[0][0].endswith(".execute")


def test_a_state_within_a_state_is_entered_anew(run):
    ran = run(
        BASE
        + "class Outer(EventState):\n"
        + "    def __init__(self):\n"
        + "        self.inner = {'IN': Pick()}\n"
        + "        self.name = 'out'\n"
        + "    def execute(self):\n"
        + "        self.inner['IN'].execute()\n"
        + "Outer().execute()"
    )
    assert entered(ran) == [[("Outer.execute", "out"), ("Pick.execute", "IN")]]


def test_other_objects_enter_no_state(run):
    ran = run(
        BASE
        + "class ArmState:\n"
        + "    name = 'left'\n"
        + "    def move(self):\n"
        + "        robot.command('move')\n"
        + "class Named(dict):\n"
        + "    def move(self):\n"
        + "        robot.command('move')\n"
        + "ArmState().move()\nNamed(name='x').move()\n"
    )
    assert entered(ran) == [[], []]


def test_an_object_that_answers_everything_harms_nothing(run):
    ran = run(
        BASE
        + "class Odd(EventState):\n"
        + "    def __getattr__(self, name):\n"
        + "        raise RuntimeError(name)\n"
        + "    def execute(self):\n"
        + "        robot.command('odd')\n"
        + "class Slots(EventState):\n"
        + "    __slots__ = ()\n"
        + "    def execute(self):\n"
        + "        robot.command('slots')\n"
        + "class Caller:\n"
        + "    def __getattribute__(self, name):\n"
        + "        if name == '__dict__':\n"
        + "            raise RuntimeError(name)\n"
        + "        return object.__getattribute__(self, name)\n"
        + "    def call(self, state):\n"
        + "        state.execute()\n"
        + "Caller().call(Odd())\nCaller().call(Slots())\n"
    )
    assert [each[-1][1] for each in entered(ran)] == ["", ""]
