"""What a controller's rospy is made to report: active functions at each message, and failures.

Nothing is changed of what is sent or when: each hook calls what was there. A message's or request's
bytes are known by their digest to whoever receives them.
"""

from __future__ import annotations

import hashlib
import importlib
import inspect
import io
import logging
import sys
import threading
import time
import traceback
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.marks.caught_exceptions import QUESTIONS, REFUSED, STAND_INS
from tracerisk.instrument.tracer import Frame, Tracer
from tracerisk.ros.graph.failures import CALLBACK_FAILED, ERROR_LOGGED, plain_line

_CLOCK_S = 10.0
_LOOK_S = 0.005
_LOGGING = frozenset({"logging", "rosgraph", "rospy", "tracerisk"})

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
    failures = _Failures(tracer, report)
    failures.watch()
    _callbacks_are_roots(tracer, failures)
    _report_spins(report)
    _nodes_begin_with_the_clock(private, failures)


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


class _Failures(logging.Handler):
    """Reports what fails in the controller's code and with which rospy goes on."""

    def __init__(self, tracer: Tracer, report: Report) -> None:
        super().__init__(logging.ERROR)
        self._tracer, self._report = tracer, report

    def watch(self) -> None:
        """Report threads that die, lines of the log that are errors, and calls refused in vain."""
        rospy: Any = importlib.import_module("rospy")
        folder = Path(rospy.__file__).parents[1]
        replaced = {path.name for path in Path(STAND_INS[0], "stand_ins").iterdir()} - QUESTIONS
        self._tracer.ros_libraries = tuple(f"{folder}/{name}/" for name in sorted(replaced))
        self._tracer.on_caught = lambda failure: self._tell(
            REFUSED, failure.words, failure.location, failure.call
        )
        real = threading.excepthook

        def notify(failure: threading.ExceptHookArgs) -> None:
            error, thread = failure.exc_value, failure.thread
            if error is not None and not isinstance(error, SystemExit) and self._counts(error):
                name = "" if thread is None else f" {thread.name}"
                words = f"thread{name} died of {_words(error)}, and the controller went on"
                self._tell("thread_failed", words, self._tracer.where_failed(error))
            real(failure)

        threading.excepthook = notify
        self.listen()

    def listen(self) -> None:
        """Take the lines that the controller logs; setting up a node removes who took them."""
        logging.getLogger("rosout").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Report a line of the log that the controller's own code wrote."""
        frame = sys._getframe(1)
        while frame.f_back is not None and _package(frame) in _LOGGING:
            frame = frame.f_back
        if not self._tracer.is_controllers(frame):
            return
        first = (record.getMessage().strip().splitlines() or [""])[0]
        severity = "FATAL" if record.levelno >= logging.CRITICAL else "ERROR"
        words = f"it logged {severity}: {first}"
        self._tell(ERROR_LOGGED, words, self._tracer.where(), plain_line(first))

    def of_callback(self, what: str, error: Exception) -> None:
        """Report that a callback raised an error with which the library goes on."""
        rospy: Any = importlib.import_module("rospy")
        # By a ServiceException a handler says no; the caller gets it.
        if self._counts(error) and not isinstance(error, rospy.ServiceException):
            words = f"{what} raised {type(error).__name__}: {error}"
            place = self._tracer.where_failed(error)
            self._tell(CALLBACK_FAILED, words, place, type(error).__name__)

    def _counts(self, error: BaseException) -> bool:
        rospy: Any = importlib.import_module("rospy")
        return not (rospy.is_shutdown() and isinstance(error, rospy.ROSException))

    def _tell(self, kind: str, message: str, place: Location | None, about: str = "") -> None:
        data = None if place is None else [place.file, place.line, place.column]
        self._report(
            {"is": "failed", "kind": kind, "message": message, "location": data, "object": about}
        )


def _package(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0]


def _words(error: BaseException) -> str:
    return " ".join("".join(traceback.format_exception_only(error)).split())


def _callbacks_are_roots(tracer: Tracer, failures: _Failures) -> None:
    topics: Any = importlib.import_module("rospy.topics")
    services: Any = importlib.import_module("rospy.impl.tcpros_service")
    timers: Any = importlib.import_module("rospy.timer")

    def rooted(owner: Any, method: str, kinds: Mapping[str, str], what: str) -> None:
        _callback_is_root(tracer, failures, owner, method, kinds, what)

    rooted(
        topics._SubscriberImpl,
        "_invoke_callback",
        {"cb": "callback"},
        "a callback of {0.resolved_name}",
    )
    # What a timer's callback raises ends the timer's thread.
    rooted(timers.Timer, "__init__", {"callback": "timer"}, "")
    rooted(
        services.ServiceImpl,
        "__init__",
        {"handler": "service"},
        "the handler of service {0.resolved_name}",
    )
    if importlib.util.find_spec("actionlib") is None:
        return
    clients: Any = importlib.import_module("actionlib.action_client")
    servers: Any = importlib.import_module("actionlib.simple_action_server")
    on_goal = dict.fromkeys(("transition_cb", "feedback_cb"), "done_callback")
    rooted(clients.GoalManager, "init_goal", on_goal, "a callback of an action")
    rooted(
        servers.SimpleActionServer,
        "__init__",
        {"execute_cb": "callback"},
        "the execute callback of an action server",
    )


def _callback_is_root(
    tracer: Tracer,
    failures: _Failures,
    owner: Any,
    method: str,
    parameters: Mapping[str, str],
    what: str,
) -> None:
    """Make the callbacks that a method takes start stacks of their own.

    `parameters` are those of the method that take one, with the kind of root, however passed.
    `what` names in a finding the callback that raised, of the object that fills `{0}`; empty: none.
    """
    real = getattr(owner, method)
    signature = inspect.signature(real)

    def failed(of: Any, error: Exception) -> None:
        failures.of_callback(what.format(of), error)

    @hide
    def taking(*args: Any, **kwargs: Any) -> Any:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:
            return real(*args, **kwargs)  # says what is wrong with the call
        for name, kind in parameters.items():
            if bound.arguments.get(name) is not None:
                callback = _rooted(tracer, kind, bound.arguments[name])
                if what:
                    callback = _watched(callback, lambda error: failed(args[0], error))
                bound.arguments[name] = callback
        return real(*bound.args, **bound.kwargs)

    setattr(owner, method, taking)


def _rooted(tracer: Tracer, kind: Any, callback: Any) -> Any:
    """Return `callback` such that it is called by no function of the controller."""

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        with tracer.root(kind):
            return callback(*args, **kwargs)

    return called


def _watched(callback: Any, failed: Callable[[Exception], None]) -> Any:
    """Return `callback` such that `failed` is called with what it raises."""

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            return callback(*args, **kwargs)
        except Exception as error:
            failed(error)
            raise

    return called


def _nodes_begin_with_the_clock(private: Mapping[str, Any], failures: _Failures) -> None:
    """Make `init_node` wait for the first time of the clock: before, it is 0."""
    rospy: Any = importlib.import_module("rospy")
    client: Any = importlib.import_module("rospy.client")
    real = client.init_node

    @hide
    def init_node(*args: Any, **kwargs: Any) -> None:
        real(*args, **kwargs)
        failures.listen()
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
