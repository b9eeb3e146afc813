"""What a controller's rclpy is made to report: ends, functions at each message, and failures.

There is no master to ask, so each end is reported when it is made. Time comes over the link and not
by messages: the clocks of nodes follow it whether anything spins or not, as on a robot.
"""

from __future__ import annotations

import importlib
import inspect
import sys
import threading
import time
import weakref
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.live.hooks import (
    Failures,
    Report,
    sent,
    sleeps_take_simulated_time,
    threads_inherit,
    watched,
)
from tracerisk.ros.live.ros2.clocks import Clocks

_ERROR, _FATAL = 40, 50
_SEND_GOAL = "/_action/send_goal"
_PAUSE_S = 0.0005
"""How long a task pauses that awaits something: rclpy asks it again without a pause [s]."""
_OF_LIBRARY = frozenset({"/rosout", "/parameter_events"})


def install(
    tracer: Tracer, report: Report, parameter_file: str | None, domain: int
) -> Callable[[int], None]:
    """Hook rclpy and threads, so that `report` is called with each message before it is sent.

    Nodes find the parameters of the file, and all are in the one domain. Return what sets the time
    of ROS [ns].
    """
    threads_inherit(tracer)
    _contexts_are_of_the_run(parameter_file, domain)
    _report_topics(tracer, report)
    _report_services(tracer, report)
    _report_actions(tracer, report)
    _callbacks_are_roots(tracer)
    failures = _Failures(tracer, report)
    failures.watch()
    _report_spins(report)
    clocks = Clocks()
    sleeps_take_simulated_time(tracer, clocks.wait)
    return clocks.set


def _type_name(kind: Any) -> str:
    """Return `sensor_msgs/JointState` for the class of that message, service or action."""
    return f"{kind.__module__.partition('.')[0]}/{kind.__name__}"


def _after(owner: Any, method: str, then: Callable[..., None]) -> None:
    """Call `then` with the result, and with the arguments by name, after each call of a method."""
    real = getattr(owner, method)
    signature = inspect.signature(real)

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        made = real(*args, **kwargs)
        bound = signature.bind(*args, **kwargs)
        then(made, bound.arguments)
        return made

    setattr(owner, method, called)


def _before(owner: Any, method: str, first: Callable[[dict[str, Any]], None]) -> None:
    """Call `first` with the arguments by name before each call of a method that fits."""
    real = getattr(owner, method)
    signature = inspect.signature(real)

    @hide
    def called(*args: Any, **kwargs: Any) -> Any:
        try:
            bound = signature.bind(*args, **kwargs)
        except TypeError:
            return real(*args, **kwargs)  # says what is wrong with the call
        first(bound.arguments)
        return real(*args, **kwargs)

    setattr(owner, method, called)


def _bytes(message: Any) -> bytes | None:
    """Return the bytes that a message is sent as; None where the library will refuse it."""
    if isinstance(message, bytes):
        return message
    serialization: Any = importlib.import_module("rclpy.serialization")
    try:
        return bytes(serialization.serialize_message(message))
    except Exception:  # noqa: BLE001 - rclpy's own call says what is wrong with it
        return None


def _contexts_are_of_the_run(parameter_file: str | None, domain: int) -> None:
    """Give each context the parameters of the run, and no other domain."""
    context: Any = importlib.import_module("rclpy.context")
    real = context.Context.init
    given = [] if parameter_file is None else ["--ros-args", "--params-file", parameter_file, "--"]

    @hide
    def init(
        self: Any, args: Any = None, *, initialize_logging: bool = True, domain_id: Any = None
    ) -> Any:
        words = [*given, *(sys.argv if args is None else args)]
        number = domain if domain_id is None or domain_id >= 0 else domain_id
        return real(self, words, initialize_logging=initialize_logging, domain_id=number)

    context.Context.init = init


def _report_topics(tracer: Tracer, report: Report) -> None:
    node: Any = importlib.import_module("rclpy.node")
    publisher: Any = importlib.import_module("rclpy.publisher")
    qos: Any = importlib.import_module("rclpy.qos")
    ends: Counter[tuple[str, str, str]] = Counter()

    def made(what: str, end: Any, of: Any, **more: Any) -> None:
        caller = of.get_fully_qualified_name()
        ends[what, end.topic_name, caller] += 1
        if ends[what, end.topic_name, caller] == 1:
            kind = _type_name(end.msg_type)
            report({"is": what, "name": end.topic_name, "caller": caller, "type": kind, **more})

    def publishes(end: Any, given: dict[str, Any]) -> None:
        profile = end.qos_profile
        is_reliable = profile.reliability != qos.ReliabilityPolicy.BEST_EFFORT
        quality = {"reliable": is_reliable, "latch": _is_kept(profile)}
        if end.topic_name not in _OF_LIBRARY:
            made("publisher", end, given["self"], quality=quality)

    def subscribes(end: Any, given: dict[str, Any]) -> None:
        made("subscriber", end, given["self"], takes_latched=_is_kept(end.qos_profile))

    def _is_kept(profile: Any) -> bool:
        return bool(profile.durability == qos.DurabilityPolicy.TRANSIENT_LOCAL)

    def leaves(what: str) -> Callable[[dict[str, Any]], None]:
        def leaving(given: dict[str, Any]) -> None:
            end = given[what]
            try:
                topic, caller = end.topic_name, given["self"].get_fully_qualified_name()
            except Exception:  # noqa: BLE001 - destroyed already; so it was reported
                return
            key = ("publisher" if what == "publisher" else "subscriber", topic, caller)
            ends[key] -= 1
            if ends[key] == 0:
                report({"is": f"no_{key[0]}", "name": topic, "caller": caller})

        return leaving

    def publishing(given: dict[str, Any]) -> None:
        end = given["self"]
        if end.topic in _OF_LIBRARY:
            return
        body = _bytes(given["msg"])
        if body is not None:
            kind = _type_name(end.msg_type)
            what = {"kind": "message", "name": end.topic_name, "type": kind}
            report(sent(tracer.stack(), **what), body)

    _after(node.Node, "create_publisher", publishes)
    _after(node.Node, "create_subscription", subscribes)
    _before(node.Node, "destroy_publisher", leaves("publisher"))
    _before(node.Node, "destroy_subscription", leaves("subscription"))
    _before(publisher.Publisher, "publish", publishing)


def _report_services(tracer: Tracer, report: Report) -> None:
    node: Any = importlib.import_module("rclpy.node")
    client: Any = importlib.import_module("rclpy.client")

    names: weakref.WeakKeyDictionary[Any, str] = weakref.WeakKeyDictionary()

    def asks(made: Any, given: dict[str, Any]) -> None:
        name = names[made] = given["self"].resolve_service_name(given["srv_name"])
        report({"is": "service_client", "name": name, "type": _type_name(given["srv_type"])})

    def serves(made: Any, given: dict[str, Any]) -> None:
        del made
        report({"is": "serves", "name": given["self"].resolve_service_name(given["srv_name"])})

    def calling(given: dict[str, Any]) -> None:
        body, end = _bytes(given["request"]), given["self"]
        if body is not None:
            what = {"kind": "call", "name": names[end], "type": _type_name(end.srv_type)}
            report(sent(tracer.stack(), **what), body)

    _after(node.Node, "create_client", asks)
    _after(node.Node, "create_service", serves)
    _before(client.Client, "call_async", calling)


def _report_actions(tracer: Tracer, report: Report) -> None:
    client: Any = importlib.import_module("rclpy.action.client")
    server: Any = importlib.import_module("rclpy.action.server")

    def name_of(given: dict[str, Any]) -> str:
        resolved: str = given["node"].resolve_service_name(given["action_name"] + _SEND_GOAL)
        return resolved.removesuffix(_SEND_GOAL)

    names: weakref.WeakKeyDictionary[Any, str] = weakref.WeakKeyDictionary()

    def asks(made: Any, given: dict[str, Any]) -> None:
        del made
        name = names[given["self"]] = name_of(given)
        caller = given["node"].get_fully_qualified_name()
        kind = _type_name(given["action_type"])
        report({"is": "action_client", "name": name, "type": kind, "caller": caller})

    def serves(made: Any, given: dict[str, Any]) -> None:
        del made
        report({"is": "acts", "name": name_of(given)})

    def sending(given: dict[str, Any]) -> None:
        body, end = _bytes(given["goal"]), given["self"]
        if body is not None:
            what = {"kind": "goal", "name": names[end], "type": _type_name(end._action_type)}
            report(sent(tracer.stack(), **what), body)

    _after(client.ActionClient, "__init__", asks)
    _after(server.ActionServer, "__init__", serves)
    _before(client.ActionClient, "send_goal_async", sending)


def _callbacks_are_roots(tracer: Tracer) -> None:
    """Make what an executor runs a root, or inherit: no function of the controller calls it."""
    executors: Any = importlib.import_module("rclpy.executors")
    tasks: Any = importlib.import_module("rclpy.task")
    kinds = {
        importlib.import_module("rclpy.timer").Timer: "timer",
        importlib.import_module("rclpy.service").Service: "service",
    }
    completing = threading.local()
    make, create, step = (
        executors.Executor._make_handler,
        executors.Executor.create_task,
        tasks.Task.__call__,
    )

    @hide
    def _make_handler(self: Any, entity: Any, *args: Any, **kwargs: Any) -> Any:
        task = make(self, entity, *args, **kwargs)
        kind = next((kind for of, kind in kinds.items() if isinstance(entity, of)), "callback")
        task.tracerisk_stack = lambda: tracer.root(kind)  # type: ignore[arg-type]
        return task

    @hide
    def create_task(self: Any, *args: Any, **kwargs: Any) -> Any:
        task = create(self, *args, **kwargs)
        captured = tracer.capture()
        task.tracerisk_stack = (
            (lambda: tracer.root("done_callback"))
            if getattr(completing, "is_now", False)
            else (lambda: tracer.resume(captured))
        )
        return task

    @hide
    def called(self: Any) -> None:
        with getattr(self, "tracerisk_stack", lambda: tracer.root("callback"))():
            step(self)
        if not self.done() and inspect.iscoroutine(self._handler) and not self.executing():
            time.sleep(_PAUSE_S)

    def completes(name: str) -> None:
        real = getattr(tasks.Future, name)

        @hide
        def completed(*args: Any) -> Any:
            completing.is_now = True
            try:
                return real(*args)
            finally:
                completing.is_now = False

        setattr(tasks.Future, name, completed)

    executors.Executor._make_handler = _make_handler
    executors.Executor.create_task = create_task
    tasks.Task.__call__ = called
    completes("_schedule_or_invoke_done_callbacks")
    completes("add_done_callback")


class _Failures(Failures):
    """Reports what fails in the controller's code and with which rclpy goes on."""

    between = ("tracerisk", "rclpy.impl.rcutils_logger", "rclpy.logging")

    def __init__(self, tracer: Tracer, report: Report) -> None:
        rclpy: Any = importlib.import_module("rclpy")
        super().__init__(tracer, report, Path(rclpy.__file__).parents[1])

    def watch(self) -> None:
        """Report threads that die, lines of the log that are errors, and calls refused in vain."""
        super().watch()
        single: Any = importlib.import_module("rclpy.impl.implementation_singleton")
        server: Any = importlib.import_module("rclpy.action.server")
        library = single.rclpy_implementation
        real_log, real_execute = (
            library.rclpy_logging_rcutils_log,
            server.ActionServer._execute_goal,
        )

        @hide
        def log(severity: Any, name: str, message: Any, *place: Any) -> Any:
            done = real_log(severity, name, message, *place)
            if severity >= _ERROR:
                self.logged(str(message), is_fatal=severity >= _FATAL)
            return done

        @hide
        async def _execute_goal(server: Any, execute_callback: Any, goal_handle: Any) -> Any:
            what = "the execute callback of an action server"
            callback = watched(execute_callback, lambda error: self.of_callback(what, error))
            return await real_execute(server, callback, goal_handle)

        library.rclpy_logging_rcutils_log = log
        server.ActionServer._execute_goal = _execute_goal


def _report_spins(report: Report) -> None:
    """Report when the main thread spins without an end of its own, and when it no longer does."""
    rclpy: Any = importlib.import_module("rclpy")
    executors: Any = importlib.import_module("rclpy.executors")

    def reported(real: Any) -> Any:
        @hide
        def spin(*args: Any, **kwargs: Any) -> None:
            is_main = threading.current_thread() is threading.main_thread()
            if is_main:
                report({"is": "spins"})
            try:
                real(*args, **kwargs)
            finally:
                if is_main:
                    report({"is": "spun"})

        return spin

    rclpy.spin = reported(rclpy.spin)
    executors.Executor.spin = reported(executors.Executor.spin)
