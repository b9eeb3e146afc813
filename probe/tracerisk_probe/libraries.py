"""The calls of ROS's libraries that command a robot, and the callbacks that they make.

A hook changes a class of a module when that module was imported. It is changed once; what the
controller passes in and gets back stays the same.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
from typing import Any, Callable, Sequence

from tracerisk_probe import stacks
from tracerisk_probe.recording import Within, command, ended, output

_OWN_TOPICS = frozenset({"/tracerisk/commands", "/rosout", "/parameter_events"})
# What an action's own topics carry: the goal is recorded when it is sent.
_OF_ACTIONS = ("actionlib_msgs/", "action_msgs/")
_ANSWERS = ("ActionResult", "ActionFeedback")
_ROS1_ENDS = {3: "succeeded", 2: "preempted", 8: "preempted"}
_ROS2_ENDS = {4: "succeeded", 5: "preempted"}
_Change = Callable[[Callable[..., Any]], Callable[..., Any]]


def _is_command(name: str, type_: str) -> bool:
    return not (name in _OWN_TOPICS or type_.startswith(_OF_ACTIONS) or type_.endswith(_ANSWERS))


def _change(owner: Any, name: str, change: _Change) -> None:
    original = getattr(owner, name, None)
    if original is None or hasattr(original, "_tracerisk_probe"):
        return
    changed = functools.wraps(original)(change(original))
    changed._tracerisk_probe = True  # type: ignore[attr-defined]
    setattr(owner, name, changed)


def _roots(**kinds: str) -> _Change:
    """Return the change of a call by which callbacks among its arguments run as roots."""

    def change(original: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(original)

        def call(*args: Any, **kwargs: Any) -> Any:
            try:
                bound = signature.bind(*args, **kwargs)
            except TypeError:
                return original(*args, **kwargs)  # which says what is wrong
            for name, kind in kinds.items():
                if name in bound.arguments:
                    bound.arguments[name] = stacks.called_by_root(bound.arguments[name], kind)
            return original(*bound.args, **bound.kwargs)

        return call

    return change


def joints_of(message: Any) -> Sequence[str]:
    """Return the joints that a trajectory, or a goal with one, names."""
    trajectory = getattr(message, "trajectory", message)
    trajectory = getattr(trajectory, "joint_trajectory", trajectory)
    names = getattr(trajectory, "joint_names", ())
    return [str(each) for each in names] if isinstance(names, (list, tuple)) else ()


def type_name(kind: Any) -> str:
    """Return the ROS name of a message, service or action class."""
    stated = getattr(kind, "_type", None)
    if isinstance(stated, str):
        return stated[: -len("Action")] if stated.endswith("Action") else stated
    module = getattr(kind, "__module__", "").split(".")
    return "/".join([*module[:2], getattr(kind, "__name__", "")])


# --- ROS 1


def _rospy_publish(original: Callable[..., Any]) -> Callable[..., Any]:
    def publish(self: Any, *args: Any, **kwargs: Any) -> Any:
        kind = type_name(self.data_class)
        if _is_command(self.resolved_name, kind):
            first = args[0] if args else None
            command("topic", self.resolved_name, kind, joints_of(first))
        return original(self, *args, **kwargs)

    return publish


def _rospy_call(original: Callable[..., Any]) -> Callable[..., Any]:
    def call(self: Any, *args: Any, **kwargs: Any) -> Any:
        number = command("service", self.resolved_name, type_name(self.service_class))
        try:
            with Within():
                result = original(self, *args, **kwargs)
        except BaseException:
            ended(number, "aborted")
            raise
        ended(number, "succeeded")
        return result

    return call


def _actionlib_send(original: Callable[..., Any]) -> Callable[..., Any]:
    def send_goal(self: Any, goal: Any, transition_cb: Any = None, feedback_cb: Any = None) -> Any:
        topic = self.pub_goal.resolved_name
        name = topic[: -len("/goal")] if topic.endswith("/goal") else topic
        number = command("action", name, type_name(self.ActionSpec), joints_of(goal))

        def watched(handle: Any) -> None:
            if handle.get_comm_state() == _DONE and not reported:
                reported.append(True)
                ended(number, _ROS1_ENDS.get(handle.get_terminal_state(), "aborted"))
            if transition_cb:
                transition_cb(handle)

        reported: list[bool] = []
        with Within():
            return original(self, goal, watched, feedback_cb)

    return send_goal


_DONE = 7  # actionlib.CommState.DONE


def _moveit(method: str) -> _Change:
    def change(original: Callable[..., Any]) -> Callable[..., Any]:
        signature = inspect.signature(original)

        def call(self: Any, *args: Any, **kwargs: Any) -> Any:
            try:
                name = str(self.get_name())
            except Exception:  # noqa: BLE001 -- a name is not worth a mission
                name = ""
            joints: Sequence[str] = ()
            with contextlib.suppress(Exception):
                joints = [str(each) for each in self.get_active_joints()]
            number = command("method", name, f"{type(self).__name__}.{method}", joints)
            try:
                waits = signature.bind(self, *args, **kwargs).arguments.get("wait", True)
            except TypeError:
                waits = True
            try:
                with Within():
                    result = original(self, *args, **kwargs)
            except BaseException:
                ended(number, "aborted")
                raise
            if waits:
                ended(number, "succeeded" if _is_success(result) else "aborted")
            return result

        return call

    return change


def _is_success(result: Any) -> bool:
    # `pick` and `place` answer with the code of MoveIt, 1 for success.
    return bool(result) if isinstance(result, bool) or result is None else result == 1


def _rospy_topics(module: Any) -> None:
    _change(module.Publisher, "publish", _rospy_publish)
    _change(module.Subscriber, "__init__", _roots(callback="callback"))


def _rospy_services(module: Any) -> None:
    _change(module.ServiceProxy, "call", _rospy_call)
    _change(module.Service, "__init__", _roots(handler="service"))


def _rospy_timer(module: Any) -> None:
    _change(module.Timer, "__init__", _roots(callback="timer"))


def _rospy_core(module: Any) -> None:
    # Publishers close in it.
    _change(module, "signal_shutdown", _flush_before)


def _actionlib_client(module: Any) -> None:
    _change(module.ActionClient, "send_goal", _actionlib_send)


def _actionlib_simple(module: Any) -> None:
    kinds = {"done_cb": "done_callback", "active_cb": "callback", "feedback_cb": "callback"}
    _change(module.SimpleActionClient, "send_goal", _roots(**kinds))


def _actionlib_server(module: Any) -> None:
    _change(module.SimpleActionServer, "__init__", _roots(execute_cb="callback"))


def _moveit_commander(module: Any) -> None:
    for name in ("go", "execute", "pick", "place"):
        _change(module.MoveGroupCommander, name, _moveit(name))


def _flush_before(original: Callable[..., Any]) -> Callable[..., Any]:
    def call(*args: Any, **kwargs: Any) -> Any:
        found = output()
        if found is not None:
            found.flush()
            if found.topic is not None:
                found.topic.close()
        return original(*args, **kwargs)

    return call


# --- ROS 2


def _rclpy_publish(original: Callable[..., Any]) -> Callable[..., Any]:
    def publish(self: Any, msg: Any) -> Any:
        try:
            name = str(self.topic_name)
        except Exception:  # noqa: BLE001 -- it was destroyed, as the call itself will say
            return original(self, msg)
        kind = type_name(self.msg_type)
        if _is_command(name, kind):
            command("topic", name, kind, joints_of(msg))
        return original(self, msg)

    return publish


def _rclpy_call(original: Callable[..., Any]) -> Callable[..., Any]:
    def call_async(self: Any, request: Any) -> Any:
        name = getattr(self, "service_name", None) or getattr(self, "srv_name", "")
        number = command("service", str(name), type_name(self.srv_type))
        with Within():
            future = original(self, request)
        if number:
            future.add_done_callback(
                lambda done: ended(number, "aborted" if done.exception() else "succeeded")
            )
        return future

    return call_async


def _rclpy_send(original: Callable[..., Any]) -> Callable[..., Any]:
    def send_goal_async(self: Any, goal: Any, *args: Any, **kwargs: Any) -> Any:
        name = str(getattr(self, "_action_name", ""))
        if not name.startswith("/"):
            with contextlib.suppress(Exception):
                name = f"{self._node.get_namespace().rstrip('/')}/{name}"
        number = command("action", name, type_name(self._action_type), joints_of(goal))
        with Within():
            future = original(self, goal, *args, **kwargs)

        def answered(done: Any) -> None:
            handle = None if done.cancelled() or done.exception() else done.result()
            if handle is None or not handle.accepted:
                ended(number, "aborted")
            else:
                handle._tracerisk_probe = number

        if number:
            future.add_done_callback(answered)
        return future

    return send_goal_async


def _rclpy_result(original: Callable[..., Any]) -> Callable[..., Any]:
    def get_result_async(self: Any) -> Any:
        with Within():
            future = original(self)
        number = getattr(self, "_tracerisk_probe", 0)
        if number:
            self._tracerisk_probe = 0

            def notify(done: Any) -> None:
                answer = None if done.cancelled() or done.exception() else done.result()
                ended(number, _ROS2_ENDS.get(getattr(answer, "status", 6), "aborted"))

            future.add_done_callback(notify)
        return future

    return get_result_async


def _rclpy_publisher(module: Any) -> None:
    _change(module.Publisher, "publish", _rclpy_publish)


def _rclpy_client(module: Any) -> None:
    _change(module.Client, "call_async", _rclpy_call)


def _rclpy_action(module: Any) -> None:
    _change(module.ActionClient, "send_goal_async", _rclpy_send)
    _change(module.ClientGoalHandle, "get_result_async", _rclpy_result)


def _rclpy_node(module: Any) -> None:
    _change(module.Node, "create_subscription", _roots(callback="callback"))
    _change(module.Node, "create_timer", _roots(callback="timer"))
    _change(module.Node, "create_service", _roots(callback="service"))


def _rclpy_server(module: Any) -> None:
    kinds = {"execute_callback": "callback", "goal_callback": "callback"}
    _change(module.ActionServer, "__init__", _roots(**kinds))


def _rclpy_task(module: Any) -> None:
    _change(module.Future, "add_done_callback", _roots(callback="done_callback"))


def _rclpy(module: Any) -> None:
    _change(module, "shutdown", _flush_before)


# --- Python's own


def _futures(module: Any) -> None:
    _change(module.Future, "add_done_callback", _roots(fn="done_callback"))


def _pools(module: Any) -> None:
    _change(module.ThreadPoolExecutor, "submit", _submit)


def _submit(original: Callable[..., Any]) -> Callable[..., Any]:
    def submit(self: Any, fn: Any, *args: Any, **kwargs: Any) -> Any:
        frames = stacks.frames_of_links()

        @functools.wraps(fn)
        def run(*args: Any, **kwargs: Any) -> Any:
            with stacks.inherit(frames):
                return fn(*args, **kwargs)

        return original(self, run, *args, **kwargs)

    return submit


def _threads(module: Any) -> None:
    _change(module.Thread, "start", _start)


def _start(original: Callable[..., Any]) -> Callable[..., Any]:
    def start(self: Any) -> Any:
        frames, run = stacks.frames_of_links(), self.run

        def run_inheriting() -> None:
            del self.run  # which would keep the thread alive
            with stacks.inherit(frames):
                run()

        if not self._started.is_set():
            self.run = run_inheriting
        return original(self)

    return start


HOOKS: dict[str, Callable[[Any], None]] = {
    "rospy.core": _rospy_core,
    "rospy.topics": _rospy_topics,
    "rospy.impl.tcpros_service": _rospy_services,
    "rospy.timer": _rospy_timer,
    "actionlib.action_client": _actionlib_client,
    "actionlib.simple_action_client": _actionlib_simple,
    "actionlib.simple_action_server": _actionlib_server,
    "moveit_commander.move_group": _moveit_commander,
    "rclpy": _rclpy,
    "rclpy.publisher": _rclpy_publisher,
    "rclpy.client": _rclpy_client,
    "rclpy.action.client": _rclpy_action,
    "rclpy.action.server": _rclpy_server,
    "rclpy.node": _rclpy_node,
    "rclpy.task": _rclpy_task,
    "concurrent.futures._base": _futures,
    "concurrent.futures.thread": _pools,
    "threading": _threads,
}
"""What is changed of which module."""
