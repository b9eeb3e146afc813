"""The node that speaks for the twin in real ROS 2, under a Python that has rclpy.

Messages go through as bytes; of services and actions, real ROS makes objects, which are read back
as bytes. What the installed ROS has no class for is left out, and said.
"""

from __future__ import annotations

import importlib
import json
import os
import socket
import sys
import threading
import time
import traceback
from collections import Counter
from typing import Any

from tracerisk.ros.live.link import Link

NODE = "tracerisk_twin"
_CLOCK = "/clock"
_N_THREADS = 64
"""How many goals and calls can be under way at once."""
_DEPTH = 100
_POLL_S = 0.001
_CANCEL_S = 2.0
"""How long a goal that ends as cancelled waits for real ROS to have said that it is to be [s]."""


class _Answer:
    """What the twin's side answers; `came` is set then."""

    def __init__(self) -> None:
        self.came = threading.Event()
        self.header: dict[str, Any] = {}
        self.body = b""

    def fill(self, header: dict[str, Any], body: bytes) -> None:
        """Pass the answer to who waits for it."""
        self.header, self.body = header, body
        self.came.set()


class _Goal:
    """A goal of the controller: what the twin said of it, and the handle of real ROS."""

    def __init__(self, number: int, request: Any) -> None:
        self.number = number
        self.request = request
        self.accepted = _Answer()
        self.cancel = _Answer()
        self.over = _Answer()
        self.handle: Any = None
        self.is_executing = False


class Relay:
    """Does what the frames of a link ask, and sends it what comes from real ROS."""

    def __init__(self, link: Link, node: Any) -> None:
        self._link, self._node = link, node
        self._rclpy: Any = importlib.import_module("rclpy")
        self._qos: Any = importlib.import_module("rclpy.qos")
        self._action: Any = importlib.import_module("rclpy.action")
        self._wire: Any = importlib.import_module("rclpy.serialization")
        self._groups: Any = importlib.import_module("rclpy.callback_groups")
        self._group = self._groups.ReentrantCallbackGroup()
        self._publishers: dict[str, Any] = {}
        self._subscriptions: dict[str, Any] = {}
        self._echoes: dict[str, Counter[bytes]] = {}
        self._servers: dict[str, Any] = {}
        self._goals: dict[int, _Goal] = {}
        self._answers: dict[int, _Answer] = {}
        self._number = 0
        self._lock = threading.Lock()

    def run(self) -> None:
        """Serve until the other end is gone."""
        while (frame := self._link.receive()) is not None:
            header, body = frame
            getattr(self, f"_{header['do']}")(header, body)

    # Topics

    def _advertise(self, header: dict[str, Any], body: bytes) -> None:
        del body
        topic, kind = header["topic"], self._class(header["topic"], "msg", header["type"])
        if kind is None or topic in self._publishers:
            return
        profile = self._profile(reliable=True, latch=header["latch"])
        self._publishers[topic] = self._node.create_publisher(
            kind, topic, profile, callback_group=self._group
        )

    def _publish(self, header: dict[str, Any], body: bytes) -> None:
        topic = header["topic"]
        if topic in self._subscriptions:
            self._echoes.setdefault(topic, Counter())[body] += 1
        # A clock that nobody reads ticks five hundred times a second.
        end = self._publishers.get(topic)
        if end is not None and (topic != _CLOCK or end.get_subscription_count()):
            end.publish(body)

    def _subscribe(self, header: dict[str, Any], body: bytes) -> None:
        del body
        topic = header["topic"]
        if topic in self._subscriptions or header["type"] is None:
            return
        kind = self._class(topic, "msg", header["type"])
        if kind is None:
            return
        profile = self._profile(reliable=header["reliable"], latch=header["latch"], depth=_DEPTH)
        self._subscriptions[topic] = self._node.create_subscription(
            kind, topic, lambda data, about: self._received(topic, bytes(data), about), profile,
            raw=True,
            # Messages of a topic come one after the other.
            callback_group=self._groups.MutuallyExclusiveCallbackGroup(),
        )  # fmt: skip

    def _received(self, topic: str, body: bytes, about: dict[str, Any]) -> None:
        echoes = self._echoes.get(topic)
        if echoes is not None and echoes[body] > 0:
            echoes[body] -= 1
            return
        number = about.get("publication_sequence_number")
        # Fast DDS numbers the messages of each publisher from 1 on; not every middleware does.
        counted = {} if number is None else {"sequence": number - 1}
        sent = {"topic": topic, "caller": "", "at_ns": about.get("source_timestamp") or None}
        self._link.send({"is": "message", **sent, **counted}, body)

    def _profile(self, *, reliable: bool, latch: bool, depth: int | None = None) -> Any:
        qos = self._qos
        return qos.QoSProfile(
            depth=depth or (1 if latch else _DEPTH),
            reliability=qos.ReliabilityPolicy.RELIABLE
            if reliable
            else qos.ReliabilityPolicy.BEST_EFFORT,
            durability=qos.DurabilityPolicy.TRANSIENT_LOCAL
            if latch
            else qos.DurabilityPolicy.VOLATILE,
        )

    # Services

    def _serve(self, header: dict[str, Any], body: bytes) -> None:
        del body
        name, kind = header["name"], self._class(header["name"], "srv", header["type"])
        if kind is None or name in self._servers:
            return

        def handle(request: Any, response: Any) -> Any:
            number, answer = self._asked()
            self._link.send({"is": "call", "name": name, "number": number}, self._bytes(request))
            answer.came.wait()
            if not answer.header["ok"]:
                # A server that fails gives no answer: who called waits on.
                self._node.get_logger().error(f"{name}: {answer.header['message']}")
                threading.Event().wait()
            return self._wire.deserialize_message(answer.body, type(response))

        server = self._node.create_service(kind, name, handle, callback_group=self._group)
        self._servers[name] = lambda: self._node.destroy_service(server)

    def _asked(self) -> tuple[int, _Answer]:
        with self._lock:
            self._number += 1
            answer = self._answers[self._number] = _Answer()
            return self._number, answer

    def _answer(self, header: dict[str, Any], body: bytes) -> None:
        self._answers.pop(header["number"]).fill(header, body)

    def _close(self, header: dict[str, Any], body: bytes) -> None:
        del body
        close = self._servers.pop(header["name"], None)
        if close is not None:
            close()

    # Actions

    def _act(self, header: dict[str, Any], body: bytes) -> None:
        del body
        name, kind = header["name"], self._class(header["name"], "action", header["type"])
        if kind is None or name in self._servers:
            return
        accepts, refuses = self._action.GoalResponse.ACCEPT, self._action.GoalResponse.REJECT
        cancels = self._action.CancelResponse

        def ask(request: Any) -> Any:
            with self._lock:
                self._number += 1
                goal = self._goals[self._number] = _Goal(self._number, request)
            asked = {"is": "goal", "name": name, "number": goal.number}
            self._link.send(asked, self._bytes(request))
            goal.accepted.came.wait()
            if goal.accepted.header["ok"]:
                return accepts
            self._goals.pop(goal.number)
            return refuses

        def begin(handle: Any) -> None:
            goal = self._of(handle)
            with self._lock:
                goal.handle = handle
                executes = goal.is_executing
            if executes:
                handle.execute()

        def cancel(handle: Any) -> Any:
            goal = self._of(handle)
            goal.cancel = _Answer()
            self._link.send({"is": "cancel", "name": name, "number": goal.number})
            goal.cancel.came.wait()
            return cancels.ACCEPT if goal.cancel.header["ok"] else cancels.REJECT

        def execute(handle: Any) -> Any:
            goal = self._of(handle)
            goal.over.came.wait()
            self._goals.pop(goal.number, None)
            _end(handle, goal.over.header["state"])
            return self._wire.deserialize_message(goal.over.body, kind.Result)

        server = self._action.ActionServer(
            self._node, kind, name, execute, callback_group=self._group,
            goal_callback=ask, handle_accepted_callback=begin, cancel_callback=cancel,
        )  # fmt: skip
        self._servers[name] = server.destroy

    def _of(self, handle: Any) -> _Goal:
        """Return the goal of a handle, which holds the request that came."""
        return next(goal for goal in list(self._goals.values()) if goal.request is handle.request)

    def _goal_answer(self, header: dict[str, Any], body: bytes) -> None:
        self._goals[header["number"]].accepted.fill(header, body)

    def _cancel_answer(self, header: dict[str, Any], body: bytes) -> None:
        self._goals[header["number"]].cancel.fill(header, body)

    def _state(self, header: dict[str, Any], body: bytes) -> None:
        goal = self._goals[header["number"]]
        is_over = header["state"] in _ENDS
        if is_over:
            goal.over.fill(header, body)
        if is_over or header["state"] == "ACTIVE":
            with self._lock:
                begins, goal.is_executing = not goal.is_executing, True
                handle = goal.handle
            if begins and handle is not None:
                handle.execute()

    def _feedback(self, header: dict[str, Any], body: bytes) -> None:
        goal = self._goals.get(header["number"])
        if goal is not None and goal.handle is not None and not goal.over.came.is_set():
            kind = goal.handle._action_server.action_type.Feedback
            goal.handle.publish_feedback(self._wire.deserialize_message(body, kind))

    def _bytes(self, message: Any) -> bytes:
        return bytes(self._wire.serialize_message(message))

    def _class(self, name: str, kind: str, type_name: str) -> Any:
        """Return a class by its type; None where the installed ROS lacks it, which is said."""
        package, short = type_name.split("/")
        try:
            support: Any = importlib.import_module("rclpy.type_support")
            found = getattr(importlib.import_module(f"{package}.{kind}"), short)
            check = support.check_for_type_support
            check(found)
        except (ImportError, AttributeError):
            there = f"{package}/{kind}/{short}"
            message = f"the installed ROS 2 has no {there}; install ros-$ROS_DISTRO-" + (
                f"{package.replace('_', '-')}, or build {package} and source its workspace"
            )
            self._link.send({"is": "lacks", "name": name, "message": message})
            return None
        return found


_ENDS = {
    "SUCCEEDED": "succeed",
    "ABORTED": "abort",
    "LOST": "abort",
    "PREEMPTED": "canceled",
    "RECALLED": "canceled",
}
"""How a goal of real ROS ends, by the last state that the twin gives it."""


def _end(handle: Any, state: str) -> None:
    """End a goal. One that is cancelled and was not asked to be aborts: real ROS has no other."""
    how = _ENDS[state]
    if how == "canceled":
        until = time.monotonic() + _CANCEL_S
        while not handle.is_cancel_requested and time.monotonic() < until:
            time.sleep(_POLL_S)
        how = how if handle.is_cancel_requested else "abort"
    getattr(handle, how)()


def main() -> None:
    """Serve the descriptor that the command line gives in JSON, until its other end is gone."""
    link = Link(socket.socket(fileno=json.loads(sys.argv[1])["descriptor"]))
    rclpy: Any = importlib.import_module("rclpy")
    executors: Any = importlib.import_module("rclpy.executors")
    rclpy.init(args=[])
    node = rclpy.create_node(NODE, enable_rosout=False, start_parameter_services=False)
    executor = executors.MultiThreadedExecutor(_N_THREADS)
    executor.add_node(node)
    threading.Thread(target=_spun, args=(executor,), daemon=True).start()
    relay = Relay(link, node)
    link.send({"is": "ready", "uri": ""})
    try:
        relay.run()
    except BaseException:
        traceback.print_exc()
        raise
    finally:
        # Threads of the executor wait for answers that nobody gives any more.
        os._exit(0)


def _spun(executor: Any) -> None:
    try:
        executor.spin()
    except BaseException:  # noqa: BLE001 - the process ends with it
        traceback.print_exc()
        os._exit(1)


if __name__ == "__main__":
    main()
