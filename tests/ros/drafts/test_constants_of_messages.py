"""Constants of a message's class, with which the code compares a field, are drafted in turn."""

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

TASK = "uint8 GRASP=1\nuint8 DELIVER=2\nuint8 RESET=3\nuint8 command\ngeometry_msgs/Pose target\n"
HEAD = """\
from enum import IntEnum

class Kind(IntEnum):
    GRASP = 1
    DELIVER = 2
    RESET = 3

class Cell(Node):
    LIFT = 1
    def __init__(self):
        self.GRASP, self.DELIVER, self.RESET = 1, 2, 3
        self.steps = {Task.GRASP: self.close, Task.DELIVER: self.open, Task.RESET: self.open}
        self.create_subscription(Task, "/task", self.on_task, 10)
        self.create_service(Do, "/do", self.on_do)

"""
BODIES = {
    "of the class": """\
if msg.command == Task.GRASP:
    self.close()
elif msg.command == Task.DELIVER:
    self.open()
elif msg.command == Task.RESET:
    self.open()
""",
    "of the message": """\
command = msg.command
if command == msg.GRASP or command == msg.DELIVER:
    self.close()
elif command == msg.RESET:
    self.open()
""",
    "in a list": "if msg.command in (Task.GRASP, Task.DELIVER, Task.RESET):\n    self.close()\n",
    "in a table": "self.steps[msg.command]()\n",
    "asked of a table": "self.steps.get(msg.command, self.stop)()\n",
    "matched": """\
match msg.command:
    case Task.GRASP:
        self.close()
    case Task.DELIVER | Task.RESET:
        self.open()
""",
    "of the node": """\
if msg.command == self.GRASP:
    self.close()
elif msg.command in [self.DELIVER, self.RESET]:
    self.open()
""",
    "of an Enum": """\
if msg.command == Kind.GRASP.value:
    self.close()
elif Kind(msg.command) == Kind.DELIVER:
    self.open()
elif msg.command == Kind.RESET:
    self.open()
""",
}


def drafted(folder, robot, source, need, interfaces=Interfaces2):
    (folder / "cell" / "msg").mkdir(parents=True)
    (folder / "cell" / "srv").mkdir()
    (folder / "cell" / "msg" / "Task.msg").write_text(TASK)
    (folder / "cell" / "srv" / "Do.srv").write_text(f"{TASK}---\nbool ok\n")
    file = folder / "node.py"
    file.write_text(source)
    line = next(at for at, text in enumerate(source.splitlines(), 1) if f'"{need.name}"' in text)
    missed = Missed(need, 0, 0, Location(str(file), line))
    return drafts([missed], interfaces(workspace={"cell": folder / "cell"}), robot)


def source_of(name, body):
    return f"{HEAD}    def {name}:\n" + "".join(f"        {line}\n" for line in body.splitlines())


@pytest.mark.parametrize("kind", BODIES)
@pytest.mark.parametrize("interfaces", [Interfaces, Interfaces2])
def test_each_constant_is_a_message_in_turn(tmp_path, values, kind, interfaces):  # noqa: F811
    source = source_of("on_task(self, msg)", BODIES[kind])
    (draft,) = drafted(tmp_path, values, source, Need("topic", "/task", "cell/Task"), interfaces)
    assert [each["command"] for each in draft.value["messages"]] == [1, 2, 3]
    assert draft.value["count"] == 3


def test_each_constant_of_a_request_is_called_in_turn(tmp_path, values):  # noqa: F811
    body = "if request.command == Do.Request.DELIVER:\n    self.open()\n"
    body += "elif request.command == Do.Request.RESET:\n    self.close()\n"
    source = source_of("on_do(self, request, response)", body)
    found = drafted(tmp_path, values, source, Need("call", "/do", "cell/Do"))
    assert [each.value["request"]["command"] for each in found] == [2, 3]


def test_a_constant_that_no_message_knows_says_nothing(tmp_path, values):  # noqa: F811
    body = "if msg.command == Settings.SPEED:\n    self.open()\n"
    need = Need("topic", "/task", "cell/Task")
    (draft,) = drafted(tmp_path, values, source_of("on_task(self, msg)", body), need)
    assert "messages" not in draft.value
