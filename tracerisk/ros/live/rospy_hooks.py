"""What a controller's rospy is made to report: active functions at each message, and failures."""

from __future__ import annotations

import importlib
import inspect
import io
import logging
import sys
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.live.hooks import (
    Failures,
    Report,
    digest,
    sent,
    sleeps_take_simulated_time,
    threads_inherit,
    watched,
)

_CLOCK_S = 10.0
_LOOK_S = 0.005
_SHUTDOWN_S = 0.5
"""How often a wait looks whether the node has shut down, as rospy's own do [s]."""


def install(tracer: Tracer, report: Report, private: Mapping[str, Any]) -> None:
    """Hook rospy and threads, so that `report` is called with each message before it is sent.

    `private` are parameters that the node finds under its own name, where it has none of the name.
    """
    threads_inherit(tracer)
    _report_publishers(tracer, report)
    _report_calls(tracer, report)
    failures = _Failures(tracer, report)
    failures.watch()
    _callbacks_are_roots(failures)
    _report_spins(report)
    _waits_take_simulated_time(tracer)
    _nodes_begin_with_the_clock(private, failures)


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
            # The bytes are known by their digest to whoever receives them.
            report(sent(stack, digest=digest(buffer.getvalue()[start + 4 :])))

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
        report(sent(tracer.stack(), digest=digest(buffer.getvalue())))
        return real_call(self, request)

    kind.__init__, kind.call = init, call


class _Failures(Failures, logging.Handler):
    """Reports what fails in the controller's code and with which rospy goes on."""

    between = ("logging", "rosgraph", "rospy", "tracerisk")

    def __init__(self, tracer: Tracer, report: Report) -> None:
        rospy: Any = importlib.import_module("rospy")
        Failures.__init__(self, tracer, report, Path(rospy.__file__).parents[1])
        logging.Handler.__init__(self, logging.ERROR)

    def watch(self) -> None:
        """Report threads that die, lines of the log that are errors, and calls refused in vain."""
        super().watch()
        self.listen()

    def listen(self) -> None:
        """Take the lines that the controller logs; setting up a node removes who took them."""
        logging.getLogger("rosout").addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        """Report a line of the log that the controller's own code wrote."""
        self.logged(record.getMessage(), is_fatal=record.levelno >= logging.CRITICAL)

    def of_callback(self, what: str, error: Exception) -> None:
        """Report that a callback raised an error with which rospy goes on."""
        rospy: Any = importlib.import_module("rospy")
        # By a ServiceException a handler says no; the caller gets it.
        if not isinstance(error, rospy.ServiceException):
            super().of_callback(what, error)

    def counts(self, error: BaseException) -> bool:
        """Return whether an error is one: rospy ends by exceptions too."""
        rospy: Any = importlib.import_module("rospy")
        return not (rospy.is_shutdown() and isinstance(error, rospy.ROSException))


def _callbacks_are_roots(failures: _Failures) -> None:
    topics: Any = importlib.import_module("rospy.topics")
    services: Any = importlib.import_module("rospy.impl.tcpros_service")
    timers: Any = importlib.import_module("rospy.timer")

    def rooted(owner: Any, method: str, kinds: Mapping[str, str], what: str) -> None:
        _callback_is_root(failures, owner, method, kinds, what)

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
    failures: Failures,
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
                callback = _rooted(failures.tracer, kind, bound.arguments[name])
                if what:
                    callback = watched(callback, lambda error: failed(args[0], error))
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


class _Clock:
    """Stands for the module `time` where rospy waits on the wall clock."""

    def __init__(self) -> None:
        self._rostime: Any = importlib.import_module("rospy.rostime")
        self._core: Any = importlib.import_module("rospy.core")
        self._sleep = time.sleep

    def time(self) -> float:
        """Return the simulated time [s]; that of the wall until the first has come."""
        return float(self._rostime.get_time()) if self._is_simulated() else time.time()

    def sleep(self, seconds: float) -> None:
        """Wait for some simulated time [s], and for what is left of it once the node shuts down."""
        if self._is_simulated():
            until = self.time() + seconds
            ticked = self._rostime.get_rostime_cond()
            with ticked:
                while self.time() < until and not self._core.is_shutdown():
                    ticked.wait(_SHUTDOWN_S)
            seconds = until - self.time()
        if seconds > 0.0:
            self._sleep(seconds)

    def _is_simulated(self) -> bool:
        rostime = self._rostime
        is_there = rostime.is_rostime_initialized() and not rostime.is_wallclock()
        return is_there and not rostime.get_rostime().is_zero()


def _waits_take_simulated_time(tracer: Tracer) -> None:
    """Make waits on the wall clock take time of the twin: a slow machine does not shorten them."""
    clock = _Clock()
    for name in ("rospy.client", "rospy.impl.tcpros_service"):
        importlib.import_module(name).time = clock  # type: ignore[attr-defined]
    rostime: Any = importlib.import_module("rospy.rostime")
    rostime.wallsleep = clock.sleep
    sleeps_take_simulated_time(tracer, clock.sleep)
