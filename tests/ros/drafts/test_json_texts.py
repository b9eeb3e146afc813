"""Drafted texts of JSON hold the keys that a callback looks up, with values that it knows."""

import json

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.errors import Location
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros2 import Interfaces2

HEAD = """\
class Cell(Node):
    def __init__(self):
        self.create_subscription(String, "/order", self.on_order, 10)
        self.orders = []

    def on_order(self, msg):
"""
QUEUED = """\
        order = json.loads(msg.data)
        self.orders.append(order)

    def work(self):
        order = self.orders.pop(0)
        for number, task in enumerate(order.get("tasks", [])):
            size = task.get("size", "small")
            self.serve(2 if size == "large" else 1)
"""
COMMANDS = """\
        try:
            command = json.loads(msg.data)
        except ValueError:
            return
        if "action" not in command:
            return
        if command["action"] == "pick":
            self.pick(float(command["height"]))
        elif command["action"] == "place":
            self.place()
"""
HANDED_ON = """\
        self.handle(json.loads(msg.data))

    def handle(self, data):
        target = data["target"]
        self.go(target["x"], target["y"], target["z"])
        self.arm.go(data["joints"])
"""
PLAIN = """\
        if msg.data == "go":
            self.pick()
"""


@pytest.fixture
def drafted(tmp_path, values):  # noqa: F811
    def made(body):
        file = tmp_path / "node.py"
        file.write_text(HEAD + body)
        missed = Missed(Need("topic", "/order", "std_msgs/String"), 0, 0, Location(str(file), 3))
        (draft,) = drafts([missed], Interfaces2(workspace={}), values)
        return draft

    return made


def test_what_is_queued_has_what_is_read_later(drafted):
    draft = drafted(QUEUED)
    sent = json.loads(draft.value["message"]["data"])
    assert sent == {"tasks": [{"size": "large"}]}
    assert draft.words == "JSON with what the code looks up"


def test_each_word_that_the_code_knows_for_a_key_comes_in_turn(drafted):
    sent = [json.loads(message["data"]) for message in drafted(COMMANDS).value["messages"]]
    assert sent == [{"action": "pick", "height": 0.1}, {"action": "place", "height": 0.1}]


def test_what_another_function_looks_up_is_within_reach(drafted, values):  # noqa: F811
    sent = json.loads(drafted(HANDED_ON).value["message"]["data"])
    assert [sent["target"][axis] for axis in "xyz"] == pytest.approx(values.pose.position)
    assert sent["joints"] == pytest.approx(values.posture)


def test_a_plain_text_is_no_json(drafted):
    assert drafted(PLAIN).value["message"] == {"data": "go"}


ODD = {
    "a constant of another file": """\
        order = json.loads(msg.data)
        if order["kind"] == Mode.FAST:
            self.go()
""",
    "kept within itself": """\
        order = json.loads(msg.data)
        history = order.get("history", [])
        history.append(order)
""",
    "the message itself": """\
        if msg:
            self.go(json.loads(msg.data)["speed"])
        else:
            self.stop()
""",
    "a length without end": """\
        order = json.loads(msg.data)
        if len(order["joints"]) > 1e999:
            return
        self.go(order["joints"])
""",
}


@pytest.mark.parametrize("what", ODD)
def test_odd_code_breaks_no_draft(drafted, what):
    json.loads(drafted(ODD[what]).value["message"]["data"])
