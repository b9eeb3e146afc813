"""What the hooks report of a client library; here of one that is false, and as small as can be."""

import asyncio
import inspect
import sys
import threading
import time
from types import ModuleType, SimpleNamespace

import pytest

from tracerisk.instrument.tracer import Tracer
from tracerisk.ros.live.ros2 import hooks

SOURCE = """\
def reach(publisher, message):
    publisher.publish(message)


def nap(seconds):
    time.sleep(seconds)
"""


class Qos(SimpleNamespace):
    """A profile: reliability and durability."""


class Handle:
    """An end of a topic."""

    def __init__(self, msg_type, topic, qos_profile):
        self.msg_type, self.topic, self.qos_profile = msg_type, topic, qos_profile
        self.topic_name, self.sent = topic, []

    def publish(self, msg):
        if not isinstance(msg, self.msg_type):
            raise TypeError("another type")
        self.sent.append(msg)


class Node:
    """A node that makes ends, and resolves a name as its own."""

    def get_fully_qualified_name(self):
        return "/cell"

    def resolve_service_name(self, name):
        return name if name.startswith("/") else f"/{name}"

    def create_publisher(self, msg_type, topic, qos_profile):
        return Handle(msg_type, topic, qos_profile)

    def create_subscription(self, msg_type, topic, callback, qos_profile):
        return Handle(msg_type, topic, qos_profile)

    def destroy_publisher(self, publisher):
        return True

    def destroy_subscription(self, subscription):
        return True

    def create_client(self, srv_type, srv_name):
        return Client(srv_type)

    def create_service(self, srv_type, srv_name, callback):
        return object()


class Client:
    """A client of a service."""

    def __init__(self, srv_type):
        self.srv_type = srv_type

    def call_async(self, request):
        return "future"


class ActionClient:
    """A client of an action."""

    def __init__(self, node, action_type, action_name):
        self._action_type = action_type

    def send_goal_async(self, goal, feedback_callback=None, goal_uuid=None):
        return "future"


class ActionServer:
    """A server of an action."""

    def __init__(self, node, action_type, action_name, execute_callback):
        pass

    async def _execute_goal(self, execute_callback, goal_handle):
        return execute_callback(goal_handle)


class Context:
    """A context that keeps what it was given."""

    def init(self, args=None, *, initialize_logging=True, domain_id=None):
        self.given = args, domain_id


class Future:
    """A future that calls those who wait for it."""

    def __init__(self, executor):
        self.executor, self.callbacks = executor, []

    def add_done_callback(self, callback):
        self.callbacks.append(callback)

    def _schedule_or_invoke_done_callbacks(self):
        for callback in self.callbacks:
            self.executor.create_task(callback, self)


class Task:
    """A task of an executor, of a function or a coroutine."""

    def __init__(self, handler, args=()):
        self._handler = handler(*args) if inspect.iscoroutinefunction(handler) else handler
        self.args, self.is_done = args, False

    def __call__(self):
        if inspect.iscoroutine(self._handler):
            try:
                self._handler.send(None)
            except StopIteration:
                self.is_done = True
            return
        self._handler(*self.args)
        self.is_done = True

    def done(self):
        return self.is_done

    def executing(self):
        return False


class Executor:
    """An executor that makes tasks."""

    def _make_handler(self, entity, node, take):
        return Task(take)

    def create_task(self, callback, *args):
        self.task = Task(callback, args)
        return self.task

    def spin(self):
        pass


class Timer:
    """A timer."""


class Service:
    """A service."""


class TimeSource:
    """What gives clocks their time."""

    def attach_clock(self, clock):
        clock._set_ros_time_is_active(False)

    def clock_callback(self, message):
        raise AssertionError("time comes over the link")


class RosClock:
    """A clock."""

    def __init__(self):
        self.is_active, self.now = False, None

    def _set_ros_time_is_active(self, enabled):
        self.is_active = enabled

    def set_ros_time_override(self, time_point):
        self.now = time_point.nanoseconds


class String:
    """A message."""


class Turn:
    """A service, or an action."""


String.__module__, Turn.__module__ = "std_msgs.msg._string", "cell_msgs.srv._turn"
QOS = SimpleNamespace(
    ReliabilityPolicy=SimpleNamespace(BEST_EFFORT=2, RELIABLE=1),
    DurabilityPolicy=SimpleNamespace(TRANSIENT_LOCAL=1, VOLATILE=2),
)
KEPT, LOST = Qos(reliability=1, durability=1), Qos(reliability=2, durability=2)


@pytest.fixture
def hooked(monkeypatch, tmp_path):
    """The false library, hooked; what it reports; the functions of a controller."""
    for owner, name in (
        *((threading.Thread, "start"), (threading, "excepthook"), (time, "sleep")),
        *((Handle, "publish"), (Client, "call_async"), (Context, "init"), (Task, "__call__")),
        *((Executor, "_make_handler"), (Executor, "create_task"), (Executor, "spin")),
        *((ActionClient, "__init__"), (ActionClient, "send_goal_async")),
        *((ActionServer, "__init__"), (ActionServer, "_execute_goal")),
        *((Future, "add_done_callback"), (Future, "_schedule_or_invoke_done_callbacks")),
        *((TimeSource, "attach_clock"), (TimeSource, "clock_callback")),
        (RosClock, "_set_ros_time_is_active"),
        *((Node, name) for name in vars(Node) if name.startswith(("create", "destroy"))),
    ):
        monkeypatch.setattr(owner, name, getattr(owner, name))
    library = SimpleNamespace(rclpy_logging_rcutils_log=lambda *given: None)
    made_time = lambda nanoseconds=0, clock_type=None: SimpleNamespace(nanoseconds=nanoseconds)  # noqa: E731
    for name, content in {
        "rclpy": {"__file__": str(tmp_path / "rclpy/__init__.py"), "spin": lambda node: None},
        "rclpy.node": {"Node": Node},
        "rclpy.publisher": {"Publisher": Handle},
        "rclpy.client": {"Client": Client},
        "rclpy.action": {},
        "rclpy.action.client": {"ActionClient": ActionClient},
        "rclpy.action.server": {"ActionServer": ActionServer},
        "rclpy.context": {"Context": Context},
        "rclpy.executors": {"Executor": Executor},
        "rclpy.task": {"Task": Task, "Future": Future},
        "rclpy.timer": {"Timer": Timer},
        "rclpy.service": {"Service": Service},
        "rclpy.time": {"Time": made_time},
        "rclpy.time_source": {"TimeSource": TimeSource},
        "rclpy.clock": {"ROSClock": RosClock, "ClockType": SimpleNamespace(ROS_TIME=1)},
        "rclpy.qos": vars(QOS),
        "rclpy.serialization": {"serialize_message": lambda message: repr(message).encode()},
        "rclpy.impl": {},
        "rclpy.impl.implementation_singleton": {"rclpy_implementation": library},
    }.items():
        module = ModuleType(name)
        vars(module).update(content)
        monkeypatch.setitem(sys.modules, name, module)
    tracer = Tracer(lambda function, line: None)
    file = str(tmp_path / "cell.py")
    tracer.add_file(file, "cell.py")
    reported = []
    set_time = hooks.install(
        tracer, lambda header, body=b"": reported.append((header, body)), "/limits.yaml", 42
    )
    names = {"time": time}
    exec(compile(SOURCE, file, "exec"), names)
    return SimpleNamespace(
        reported=reported, set_time=set_time, tracer=tracer, library=library, **names
    )


def of_kind(hooked, *kinds):
    return [header for header, _ in hooked.reported if header["is"] in kinds]


def test_the_ends_of_topics_are_reported_once_with_their_quality(hooked):
    node = Node()
    one = node.create_publisher(String, "/words", KEPT)
    two = node.create_publisher(String, topic="/words", qos_profile=KEPT)
    node.create_publisher(String, "/rosout", KEPT)
    node.create_subscription(String, "/words", print, LOST)
    node.destroy_publisher(one)
    assert of_kind(hooked, "no_publisher") == []
    node.destroy_publisher(two)
    known = {"name": "/words", "caller": "/cell", "type": "std_msgs/String"}
    assert [header for header, _ in hooked.reported] == [
        {"is": "publisher", **known, "quality": {"reliable": True, "latch": True}},
        {"is": "subscriber", **known, "takes_latched": False},
        {"is": "no_publisher", "name": "/words", "caller": "/cell"},
    ]


def test_a_message_is_reported_before_it_is_sent(hooked):
    publisher, message = Node().create_publisher(String, "/words", LOST), String()
    hooked.reach(publisher, message)
    assert publisher.sent == [message]
    (header,) = of_kind(hooked, "sent")
    described = {"kind": "message", "name": "/words", "type": "std_msgs/String"}
    assert {key: header[key] for key in described} == described
    assert hooked.reported[-1][1] == repr(message).encode()
    with pytest.raises(TypeError, match="another type"):
        publisher.publish(3.0)
    with pytest.raises(TypeError, match="missing"):
        publisher.publish()


def test_services_and_actions_are_reported_by_their_full_names(hooked):
    node = Node()
    client = node.create_client(Turn, "turn")
    node.create_service(Turn, "own", print)
    action = ActionClient(node, Turn, "swing")
    ActionServer(node, Turn, "serve", print)
    assert client.call_async("request") == action.send_goal_async("goal") == "future"
    assert [header for header, _ in hooked.reported if header["is"] != "sent"] == [
        {"is": "service_client", "name": "/turn", "type": "cell_msgs/Turn"},
        {"is": "serves", "name": "/own"},
        {"is": "action_client", "name": "/swing", "type": "cell_msgs/Turn", "caller": "/cell"},
        {"is": "acts", "name": "/serve"},
    ]
    assert [(header["kind"], header["name"]) for header in of_kind(hooked, "sent")] == [
        ("call", "/turn"),
        ("goal", "/swing"),
    ]


@pytest.mark.parametrize(("asked", "given"), [(None, 42), (0, 42), (7, 42), (-1, -1)])
def test_a_context_is_of_the_domain_of_the_run(hooked, asked, given):
    context = Context()
    context.init(["cell.py", "--left"], domain_id=asked)
    words = ["--ros-args", "--params-file", "/limits.yaml", "--", "cell.py", "--left"]
    assert context.given == (words, given)


def test_what_an_executor_runs_begins_a_stack(hooked):
    roots = []

    def note(*given):
        roots.append(hooked.tracer.stack()[0].root)

    executor = Executor()
    for entity in (Timer(), Service(), object()):
        executor._make_handler(entity, None, note)()
    future = Future(executor)
    future.add_done_callback(note)
    future._schedule_or_invoke_done_callbacks()
    executor.task()
    executor.create_task(note)()
    assert roots == ["timer", "service", "callback", "done_callback", "thread"]


def test_a_task_that_awaits_does_not_keep_the_processor_busy(hooked):
    async def waits():
        await asyncio.sleep(0)

    task = Executor().create_task(waits)
    began = time.monotonic()
    task()
    assert time.monotonic() - began >= hooks._PAUSE_S
    assert not task.done()
    task()
    assert task.done()


def test_clocks_follow_the_link_whether_they_use_simulated_time_or_not(hooked):
    hooked.set_time(5)
    source, clock = TimeSource(), RosClock()
    source.attach_clock(clock)
    assert clock.is_active
    clock._set_ros_time_is_active(False)
    assert clock.is_active
    hooked.set_time(7)
    assert clock.now == 7
    source.clock_callback("of the topic")
    assert clock.now == 7


def test_the_controllers_own_sleep_takes_time_of_the_twin(hooked):
    hooked.set_time(1_000)
    napping = threading.Thread(target=hooked.nap, args=(3600.0,))
    napping.start()
    hooked.set_time(1_000 + 3600 * 10**9 - 1)
    napping.join(0.2)
    assert napping.is_alive()
    hooked.set_time(1_000 + 3600 * 10**9)
    napping.join(10.0)
    assert not napping.is_alive()
    time.sleep(0.001)  # of a library: it takes wall time, and no twin need be there
    with pytest.raises(ValueError, match="non-negative"):
        hooked.nap(-1.0)


def test_an_error_of_a_callback_or_in_the_log_is_reported(hooked):
    def fails(handle):
        raise IndexError("no turn")

    with pytest.raises(IndexError):
        asyncio.run(ActionServer._execute_goal(object(), fails, "handle"))
    hooked.library.rclpy_logging_rcutils_log(40, "cell", "of a library", "place")
    assert [(header["kind"], header["message"]) for header in of_kind(hooked, "failed")] == [
        ("callback_failed", "the execute callback of an action server raised IndexError: no turn")
    ]


def test_a_spin_of_the_main_thread_is_reported_with_its_end(hooked):
    Executor().spin()
    sys.modules["rclpy"].spin("node")
    other = threading.Thread(target=Executor().spin)
    other.start()
    other.join()
    assert [header["is"] for header in of_kind(hooked, "spins", "spun")] == ["spins", "spun"] * 2
