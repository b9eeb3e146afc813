"""What a controller's rospy is made to report: which functions are active at each message and call.

Nothing is changed of what is sent or when: each hook calls what was there. A message's or request's
bytes are known by their digest to whoever receives them.
"""

from __future__ import annotations

import hashlib
import importlib
import io
import sys
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.tracer import Frame, Tracer

_CLOCK_S = 10.0
_LOOK_S = 0.005

Report = Callable[[dict[str, Any]], None]
"""Passes a header on to the twin's side."""


def digest(body: bytes) -> str:
    """Return what stands for the bytes of a message."""
    return hashlib.blake2b(body, digest_size=16).hexdigest()


def frames_data(stack: tuple[Frame, ...]) -> list[list[Any]]:
    """Return a stack as JSON data; `frames_of` reads it."""
    return [
        [
            *(frame.function.file, frame.function.name, frame.line, frame.activation),
            *(list(frame.site), frame.root, frame.instance),
        ]
        for frame in stack
    ]


def _sent(body: bytes, stack: tuple[Frame, ...]) -> dict[str, Any]:
    thread = threading.get_ident()
    return {"is": "sent", "digest": digest(body), "stack": frames_data(stack), "thread": thread}


def install(tracer: Tracer, report: Report, private: Mapping[str, Any]) -> None:
    """Hook rospy and threads, so that `report` is called with each message before it is sent.

    `private` are parameters that the node finds under its own name, where it has none of the name.
    """
    _threads_inherit(tracer)
    _report_publishers(tracer, report)
    _report_calls(tracer, report)
    _callbacks_are_roots(tracer)
    _report_spins(report)
    _nodes_begin_with_the_clock(private)


def _threads_inherit(tracer: Tracer) -> None:
    real = threading.Thread.start

    @hide
    def start(self: threading.Thread) -> None:
        captured = tracer.capture()
        run = self.run

        @hide
        def traced() -> None:
            with tracer.resume(captured):
                run()

        if captured.frames:
            self.run = traced  # type: ignore[method-assign]
        real(self)

    threading.Thread.start = start  # type: ignore[method-assign]


def _report_publishers(tracer: Tracer, report: Report) -> None:
    topics: Any = importlib.import_module("rospy.topics")
    kind = topics._PublisherImpl
    real_publish, real_serialize = kind.publish, topics.serialize_message
    sending = threading.local()

    @hide
    def publish(self: Any, message: Any, connection_override: Any = None) -> Any:
        if self.resolved_name == "/rosout":
            return real_publish(self, message, connection_override)
        if connection_override is None:
            # What is latched goes out again when somebody connects, on a thread of rospy.
            self.tracerisk_stack = tracer.stack()
        sending.stack = getattr(self, "tracerisk_stack", None) or tracer.stack()
        try:
            return real_publish(self, message, connection_override)
        finally:
            sending.stack = None

    @hide
    def serialize_message(buffer: io.BytesIO, sequence: int, message: Any) -> None:
        start = buffer.tell()
        real_serialize(buffer, sequence, message)
        stack = getattr(sending, "stack", None)
        if stack is not None:
            report(_sent(buffer.getvalue()[start + 4 :], stack))

    kind.publish, topics.serialize_message = publish, serialize_message


def _report_calls(tracer: Tracer, report: Report) -> None:
    services: Any = importlib.import_module("rospy.impl.tcpros_service")
    msg: Any = importlib.import_module("rospy.msg")
    kind = services.ServiceProxy
    real_init, real_call = kind.__init__, kind.call

    @hide
    def init(self: Any, name: str, service_class: Any, *args: Any, **kwargs: Any) -> None:
        real_init(self, name, service_class, *args, **kwargs)
        report({"is": "service_client", "name": self.resolved_name, "type": service_class._type})

    @hide
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        request = msg.args_kwds_to_message(self.request_class, args, kwargs)
        buffer = io.BytesIO()
        try:
            request.serialize(buffer)
        except Exception:  # noqa: BLE001 - rospy's own call says what is wrong with it
            return real_call(self, request)
        report(_sent(buffer.getvalue(), tracer.stack()))
        return real_call(self, request)

    kind.__init__, kind.call = init, call


def _callbacks_are_roots(tracer: Tracer) -> None:
    topics: Any = importlib.import_module("rospy.topics")
    services: Any = importlib.import_module("rospy.impl.tcpros_service")
    timers: Any = importlib.import_module("rospy.timer")
    real_invoke = topics._SubscriberImpl._invoke_callback
    real_timer, real_service = timers.Timer.__init__, services.ServiceImpl.__init__

    @hide
    def invoke(self: Any, message: Any, callback: Any, arguments: Any) -> None:
        with tracer.root("callback"):
            real_invoke(self, message, callback, arguments)

    @hide
    def timer(self: Any, period: Any, callback: Any, *args: Any, **kwargs: Any) -> None:
        real_timer(self, period, _rooted(tracer, "timer", callback), *args, **kwargs)

    @hide
    def service(self: Any, name: str, kind: Any, handler: Any, *args: Any, **kwargs: Any) -> None:
        real_service(self, name, kind, _rooted(tracer, "service", handler), *args, **kwargs)

    topics._SubscriberImpl._invoke_callback = invoke
    timers.Timer.__init__, services.ServiceImpl.__init__ = timer, service
    if importlib.util.find_spec("actionlib") is not None:
        _actions_are_roots(tracer)


def _actions_are_roots(tracer: Tracer) -> None:
    clients: Any = importlib.import_module("actionlib.action_client")
    servers: Any = importlib.import_module("actionlib.simple_action_server")
    real_send = clients.GoalManager.init_goal
    real_server = servers.SimpleActionServer.__init__

    @hide
    def init_goal(self: Any, goal: Any, transition_cb: Any = None, feedback_cb: Any = None) -> Any:
        return real_send(
            self,
            goal,
            _rooted(tracer, "done_callback", transition_cb),
            _rooted(tracer, "done_callback", feedback_cb),
        )

    @hide
    def server(self: Any, name: str, spec: Any, execute_cb: Any = None, *more: Any) -> None:
        real_server(self, name, spec, _rooted(tracer, "callback", execute_cb), *more)

    clients.GoalManager.init_goal = init_goal
    servers.SimpleActionServer.__init__ = server


def _rooted(tracer: Tracer, kind: Any, callback: Any) -> Any:
    """Return `callback` such that it is called by no function of the controller."""
    if callback is None:
        return None

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        with tracer.root(kind):
            return callback(*args, **kwargs)

    return called


def _nodes_begin_with_the_clock(private: Mapping[str, Any]) -> None:
    """Make `init_node` wait for the first time of the clock: before, it is 0."""
    rospy: Any = importlib.import_module("rospy")
    client: Any = importlib.import_module("rospy.client")
    real = client.init_node

    @hide
    def init_node(*args: Any, **kwargs: Any) -> None:
        real(*args, **kwargs)
        until = time.monotonic() + _CLOCK_S
        while rospy.get_rostime().is_zero() and time.monotonic() < until:
            time.sleep(_LOOK_S)
        for name, value in private.items():
            if not rospy.has_param(f"~{name}"):
                rospy.set_param(f"~{name}", value)

    _replace(real, init_node, "init_node")


def _replace(real: Any, ours: Any, name: str) -> None:
    """Put `ours` in the place of a function wherever a module has imported it."""
    for module in list(sys.modules.values()):
        if getattr(module, name, None) is real:
            setattr(module, name, ours)


def _report_spins(report: Report) -> None:
    client: Any = importlib.import_module("rospy.client")
    real = client.spin

    @hide
    def spin() -> None:
        is_main = threading.current_thread() is threading.main_thread()
        if is_main:
            report({"is": "spins"})
        real()

    _replace(real, spin, "spin")
