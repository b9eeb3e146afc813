"""What the twin's node does with the frames of a link; here with a false rclpy."""

import socket
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType, SimpleNamespace

import pytest

from tracerisk.ros.live.link import Link
from tracerisk.ros.live.ros2.relay import Relay

QOS = {
    "QoSProfile": SimpleNamespace,
    "ReliabilityPolicy": SimpleNamespace(BEST_EFFORT="best effort", RELIABLE="reliable"),
    "DurabilityPolicy": SimpleNamespace(TRANSIENT_LOCAL="kept", VOLATILE="lost"),
}
TURN = "cell_msgs/Turn"
WAIT_S = 30.0
MADE = []
"""The servers of actions that were made."""


class Text:
    """A message, a part of a service, or of an action: its bytes."""

    def __init__(self, body=b""):
        self.body = body


class Turn:
    """A service, and an action."""

    Request = Response = Goal = Result = Feedback = Text


class Publisher:
    """Keeps what it publishes."""

    def __init__(self):
        self.sent, self.n_heard = [], 0

    def publish(self, body):
        self.sent.append(body)

    def get_subscription_count(self):
        return self.n_heard


class Node:
    """A node that keeps its ends."""

    def __init__(self):
        self.publishers, self.subscriptions, self.services, self.errors = {}, {}, {}, []

    def create_publisher(self, kind, topic, profile, callback_group):
        end = self.publishers[topic] = Publisher()
        end.kind, end.profile = kind, profile
        return end

    def create_subscription(self, kind, topic, callback, profile, raw, callback_group):
        assert raw
        self.subscriptions[topic] = callback, profile
        return callback

    def create_service(self, kind, name, handle, callback_group):
        self.services[name] = handle
        return name

    def destroy_service(self, name):
        del self.services[name]


class Handle:
    """The handle of a goal of real ROS."""

    def __init__(self, server, request):
        self.request, self._action_server = request, SimpleNamespace(action_type=Turn)
        self.fed_back, self.steps, self.is_cancel_requested = [], [], False
        self.server, self.result = server, None

    def execute(self):
        self.steps.append("execute")
        self.running = threading.Thread(target=self._run)
        self.running.start()

    def _run(self):
        self.result = self.server.execute(self)

    def publish_feedback(self, message):
        self.fed_back.append(message.body)

    def succeed(self):
        self.steps.append("succeed")

    def abort(self):
        self.steps.append("abort")

    def canceled(self):
        self.steps.append("canceled")


class ActionServer:
    """A server of actions that keeps its callbacks."""

    def __init__(
        self, node, kind, name, execute, *, callback_group, goal_callback,
        handle_accepted_callback, cancel_callback,
    ):  # fmt: skip
        self.name, self.execute = name, execute
        self.goal, self.accepted, self.cancel = (
            goal_callback,
            handle_accepted_callback,
            cancel_callback,
        )
        self.is_destroyed = False
        MADE.append(self)

    def destroy(self):
        self.is_destroyed = True


@pytest.fixture
def twin(monkeypatch):
    """The twin's side of a link to a relay that runs, with the node of the relay."""
    text = {"String": Text}
    answers = {"ACCEPT": "accept", "REJECT": "reject"}
    for name, content in {
        "rclpy": {},
        "rclpy.qos": QOS,
        "rclpy.action": {
            "ActionServer": ActionServer,
            "GoalResponse": SimpleNamespace(**answers),
            "CancelResponse": SimpleNamespace(**answers),
        },
        "rclpy.serialization": {
            "serialize_message": lambda message: message.body,
            "deserialize_message": lambda body, kind: kind(body),
        },
        "rclpy.callback_groups": {
            "ReentrantCallbackGroup": object,
            "MutuallyExclusiveCallbackGroup": object,
        },
        "rclpy.type_support": {"check_for_type_support": lambda kind: None},
        "std_msgs": {},
        "std_msgs.msg": text,
        "rosgraph_msgs": {},
        "rosgraph_msgs.msg": {"Clock": Text},
        "cell_msgs": {},
        "cell_msgs.srv": {"Turn": Turn},
        "cell_msgs.action": {"Turn": Turn},
    }.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    MADE.clear()
    ours, theirs = socket.socketpair()
    ours.settimeout(WAIT_S)
    link, node = Link(ours), Node()
    relay = Relay(Link(theirs), node)
    running = threading.Thread(target=relay.run)
    running.start()
    with ThreadPoolExecutor() as threads:
        yield SimpleNamespace(link=link, node=node, threads=threads, stop=link.close)
        link.close()
        running.join(WAIT_S)
    assert not running.is_alive()


def settled(twin):
    """Wait until the relay has done all that it was asked: it answers in turn."""
    twin.link.send({"do": "advertise", "topic": "/end", "type": "lost_msgs/End", "latch": False})
    assert twin.link.receive()[0]["is"] == "lacks"


def test_bytes_are_published_with_the_quality_that_is_asked_for(twin):
    for topic, latch in (("/words", False), ("/kept", True)):
        asked = {"do": "advertise", "topic": topic, "type": "std_msgs/String", "latch": latch}
        twin.link.send(asked)
        twin.link.send({"do": "publish", "topic": topic}, b"hello")
    twin.link.send({"do": "publish", "topic": "/nobody"}, b"hello")
    settled(twin)
    assert [end.sent for end in twin.node.publishers.values()] == [[b"hello"], [b"hello"]]
    assert [vars(end.profile) for end in twin.node.publishers.values()] == [
        {"depth": 100, "reliability": "reliable", "durability": "lost"},
        {"depth": 1, "reliability": "reliable", "durability": "kept"},
    ]


def test_a_clock_that_nobody_hears_is_not_published(twin):
    asked = {"do": "advertise", "topic": "/clock", "type": "rosgraph_msgs/Clock", "latch": True}
    twin.link.send(asked)
    twin.link.send({"do": "publish", "topic": "/clock"}, b"1")
    settled(twin)
    clock = twin.node.publishers["/clock"]
    clock.n_heard = 1
    twin.link.send({"do": "publish", "topic": "/clock"}, b"2")
    settled(twin)
    assert clock.sent == [b"2"]


def test_what_comes_is_passed_on_but_not_what_the_twin_itself_published(twin):
    asked = {"topic": "/words", "type": "std_msgs/String"}
    twin.link.send({"do": "advertise", **asked, "latch": False})
    twin.link.send({"do": "subscribe", **asked, "reliable": False, "latch": False})
    twin.link.send({"do": "publish", "topic": "/words"}, b"ours")
    settled(twin)
    heard, profile = twin.node.subscriptions["/words"]
    assert profile.reliability == "best effort"
    heard(b"ours", {"publication_sequence_number": 1})
    heard(b"theirs", {"publication_sequence_number": 3, "source_timestamp": 8})
    heard(b"theirs", {"source_timestamp": 0})  # a middleware that says neither
    header = {"is": "message", "topic": "/words", "caller": ""}
    assert twin.link.receive() == ({**header, "sequence": 2, "at_ns": 8}, b"theirs")
    assert twin.link.receive() == ({**header, "at_ns": None}, b"theirs")


def test_a_call_is_answered_by_the_twin(twin):
    twin.link.send({"do": "serve", "name": "/turn", "type": TURN})
    settled(twin)
    calling = twin.threads.submit(twin.node.services["/turn"], Text(b"left"), Text())
    header, body = twin.link.receive()
    assert ({**header, "number": 0}, body) == (
        {"is": "call", "name": "/turn", "number": 0},
        b"left",
    )
    twin.link.send({"do": "answer", "number": header["number"], "ok": True}, b"done")
    assert calling.result(WAIT_S).body == b"done"
    twin.link.send({"do": "close", "name": "/turn"})
    settled(twin)
    assert twin.node.services == {}


def goal_of(twin):
    """Serve an action, and send it a goal; return its server, what asks, and its number."""
    twin.link.send({"do": "act", "name": "/turn", "type": TURN})
    settled(twin)
    (server,) = MADE
    request = Text(b"left")
    asking = twin.threads.submit(server.goal, request)
    header, body = twin.link.receive()
    assert (header["is"], header["name"], body) == ("goal", "/turn", b"left")
    return server, request, asking, header["number"]


def test_a_goal_runs_to_its_end(twin):
    server, request, asking, number = goal_of(twin)
    twin.link.send({"do": "goal_answer", "number": number, "ok": True})
    assert asking.result(WAIT_S) == "accept"
    twin.link.send({"do": "state", "number": number, "state": "ACTIVE"})
    settled(twin)
    handle = Handle(server, request)
    server.accepted(handle)
    twin.link.send({"do": "feedback", "number": number}, b"half")
    twin.link.send({"do": "state", "number": number, "state": "SUCCEEDED"}, b"there")
    handle.running.join(WAIT_S)
    assert handle.steps == ["execute", "succeed"]
    assert (handle.fed_back, handle.result.body) == ([b"half"], b"there")
    twin.link.send({"do": "close", "name": "/turn"})
    settled(twin)
    assert server.is_destroyed


def test_a_goal_that_the_twin_refuses_is_rejected(twin):
    _, _, asking, number = goal_of(twin)
    twin.link.send({"do": "goal_answer", "number": number, "ok": False})
    assert asking.result(WAIT_S) == "reject"


@pytest.mark.parametrize(
    ("is_granted", "last", "step"),
    [(True, "PREEMPTED", "canceled"), (False, "ABORTED", "abort")],
)
def test_a_cancel_is_the_twins_to_grant(twin, is_granted, last, step):
    server, request, asking, number = goal_of(twin)
    twin.link.send({"do": "goal_answer", "number": number, "ok": True})
    assert asking.result(WAIT_S) == "accept"
    handle = Handle(server, request)
    server.accepted(handle)
    twin.link.send({"do": "state", "number": number, "state": "ACTIVE"})
    cancelling = twin.threads.submit(server.cancel, handle)
    assert twin.link.receive()[0] == {"is": "cancel", "name": "/turn", "number": number}
    twin.link.send({"do": "cancel_answer", "number": number, "ok": is_granted})
    twin.link.send({"do": "state", "number": number, "state": last}, b"")
    assert cancelling.result(WAIT_S) == ("accept" if is_granted else "reject")
    # Real ROS says that a goal is to be cancelled after the callback, and before its end.
    handle.is_cancel_requested = is_granted
    handle.running.join(WAIT_S)
    assert handle.steps == ["execute", step]


def test_a_type_that_the_installed_ros_lacks_is_said_with_what_to_do(twin):
    twin.link.send({"do": "act", "name": "/far", "type": "far_msgs/Go"})
    header, _ = twin.link.receive()
    assert header["name"] == "/far"
    assert header["message"] == (
        "the installed ROS 2 has no far_msgs/action/Go; install ros-$ROS_DISTRO-far-msgs, or build "
        "far_msgs and source its workspace"
    )
    twin.link.send({"do": "serve", "name": "/near", "type": "cell_msgs/Fly"})
    assert "has no cell_msgs/srv/Fly" in twin.link.receive()[0]["message"]
