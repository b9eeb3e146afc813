"""Contracts of rclpy: small programs whose outcome on the real library follows from its source.

Sources: ros2/rclpy (branch rolling, commit ba72a017) `rclpy/rclpy/{executors,timer,task,client}.py`;
each test names the lines' subject. More contracts stand beside the subject that they are about:
`spin_once`, groups, nested spins and coroutines in `test_rclpy_spin.py`, latched topics in
`test_rclpy_node.py` (rclpy) and `test_rospy_topics.py` (rospy), `Rate` of rospy and its drift in
`test_rospy_node.py`, `done_cb` before `wait_for_result` and preemption in `test_actionlib.py`, two
threads with `time.sleep` in `test_patches_threads.py`.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver


def test_what_is_ready_at_once_runs_timers_topics_guards_responses_requests(run_ros2):
    """executors.py, `_wait_for_ready_callbacks`: timers, subscriptions, guards, clients, services.

    The order is that of the kinds, whatever came first; within a kind that of creation.
    """

    def main():
        import time

        import rclpy
        from std_msgs.msg import Empty
        from std_srvs.srv import Trigger

        rclpy.init()
        node, other = rclpy.create_node("arm"), rclpy.create_node("other")
        order = []
        gate = node.create_guard_condition(lambda: order.append("guard"))

        def serve(request, response):
            order.append("service")
            return response

        node.create_service(Trigger, "mine", serve)
        other.create_service(Trigger, "yours", lambda request, response: response)
        client = node.create_client(Trigger, "yours")
        for name in ("first topic", "second topic"):
            node.create_subscription(
                Empty, name.replace(" ", "_"), lambda _, name=name: order.append(name), 10
            )
        node.create_timer(0.5, lambda: order.append("timer"))

        asking = other.create_client(Trigger, "mine").call_async(Trigger.Request())
        future = client.call_async(Trigger.Request())
        rclpy.spin_once(other, timeout_sec=0.1)
        gate.trigger()
        other.create_publisher(Empty, "second_topic", 10).publish(Empty())
        other.create_publisher(Empty, "first_topic", 10).publish(Empty())
        time.sleep(0.6)
        for _ in range(6):
            rclpy.spin_once(node, timeout_sec=0.0)
            if future.done() and "response" not in order:
                order.append("response")
        return order, asking.done()

    assert run_ros2(main) == (
        ["timer", "first topic", "second topic", "guard", "response", "service"],
        False,
    )


def test_a_rate_keeps_its_beat_and_a_beat_during_the_work_is_not_waited_for_again(run_ros2):
    """timer.py, `Rate`: the timer sets an event, the last sleeper that wakes clears it."""

    def main():
        import threading
        import time

        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
        rate, woken = node.create_rate(10), []
        start = node.get_clock().now().nanoseconds
        for work in (0.0, 0.04, 0.09, 0.25, 0.0, 0.0):
            time.sleep(work)
            rate.sleep()
            woken.append(round((node.get_clock().now().nanoseconds - start) / 1e9, 2))
        rclpy.shutdown()
        return woken

    # 0.25 s of work after 0.3 s: the beats of 0.4 and 0.5 have set the event once.
    assert run_ros2(main) == pytest.approx([0.1, 0.2, 0.3, 0.55, 0.6, 0.7], abs=0.011)


def test_a_timer_does_not_drift_with_the_work_of_its_callback(run_ros2):
    """rcl/timer.c, `rcl_timer_call`: the next call is the last one due plus the period."""

    def main():
        import time

        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        start = node.get_clock().now().nanoseconds
        begun = []

        def work():
            begun.append(round((node.get_clock().now().nanoseconds - start) / 1e9, 2))
            time.sleep(0.07)
            if len(begun) == 5:
                rclpy.shutdown()

        node.create_timer(0.1, work)
        rclpy.spin(node)
        return begun

    assert run_ros2(main) == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5], abs=0.005)


def test_done_callbacks_of_a_response_run_after_the_spin_that_completed_it(run_ros2):
    """task.py: with an executor, a future hands its callbacks over as tasks, it calls none itself."""

    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_service(Trigger, "go", lambda request, response: response)
        order = []
        future = node.create_client(Trigger, "go").call_async(Trigger.Request())
        future.add_done_callback(lambda done: order.append("callback"))
        rclpy.spin_until_future_complete(node, future)
        order.append("returned")
        # The newest come first: three by which the spin was to be woken.
        for _ in range(3):
            rclpy.spin_once(node, timeout_sec=0.0)
        order.append("thrice")
        rclpy.spin_once(node, timeout_sec=0.0)
        # Of a future that is done and has no executor, the callback is called at once.
        done = rclpy.Future()
        done.set_result(1)
        done.add_done_callback(lambda each: order.append("at once"))
        return order

    assert run_ros2(main) == ["returned", "thrice", "callback", "at once"]


def test_a_coroutine_may_await_a_future_that_a_thread_completes(run_ros2):
    """task.py, `Task.__call__`: a coroutine is resumed at each spin and yields while it awaits."""

    def main():
        import threading
        import time

        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        gate = rclpy.Future()
        seen = []

        def work():
            time.sleep(1.5)
            gate.set_result("open")

        async def wait():
            threading.Thread(target=work).start()
            seen.append(await gate)
            rclpy.shutdown()

        rclpy.get_global_executor().create_task(wait)
        node.create_timer(0.5, lambda: seen.append("beat"))
        rclpy.spin(node)
        return seen

    assert run_ros2(main) in (
        ["beat", "beat", "beat", "open"],
        ["beat", "beat", "open"],
    )


def test_asyncio_does_not_run_in_a_coroutine_of_rclpy(run_ros2):
    """Python documentation, asyncio: `sleep` needs a running event loop, and rclpy runs none."""

    def main():
        import asyncio

        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")

        async def beat():
            await asyncio.sleep(1.0)

        node.create_timer(0.1, beat)
        rclpy.spin(node)

    with pytest.raises(RuntimeError, match="no running event loop"):
        run_ros2(main)


def test_a_service_of_two_exclusive_nodes_that_call_each_other_is_a_deadlock(run_ros2):
    """client.py, `call`: it blocks its thread; "do not call this in a callback" of one thread."""

    def main():
        import rclpy
        from rclpy.executors import MultiThreadedExecutor
        from std_srvs.srv import Trigger

        rclpy.init()
        nodes = [rclpy.create_node(name) for name in ("left", "right")]
        clients = [
            node.create_client(Trigger, name) for node, name in zip(nodes, "ba", strict=True)
        ]

        def answer(client):
            def call(request, response):
                client.call(Trigger.Request())
                return response

            return call

        for node, name, client in zip(nodes, "ab", clients, strict=True):
            node.create_service(Trigger, name, answer(client))
        executor = MultiThreadedExecutor(num_threads=4)
        for node in nodes:
            executor.add_node(node)
        first = clients[0].call_async(Trigger.Request())
        executor.spin_until_future_complete(first)

    with pytest.raises(
        RunOver, match=r"the response of service /[ab] \(std_srvs/Trigger\)"
    ) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_nested_spin_names_the_line_that_waits(run_ros2):
    """executors.py, `spin_until_future_complete` within a callback of the same group hangs."""

    def main():
        import rclpy
        from control_msgs.action import FollowJointTrajectory
        from rclpy.action import ActionClient, ActionServer

        rclpy.init()
        node = rclpy.create_node("arm")

        def execute(handle):
            handle.succeed()
            return FollowJointTrajectory.Result()

        ActionServer(node, FollowJointTrajectory, "go", execute)
        client = ActionClient(node, FollowJointTrajectory, "go")

        def beat():
            sent = client.send_goal_async(FollowJointTrajectory.Goal())
            rclpy.spin_until_future_complete(node, sent)

        node.create_timer(0.1, beat)
        rclpy.spin(node)

    with pytest.raises(RunOver) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"
    assert "/go" in str(over.value)
    assert over.value.stack[-1][1].endswith("beat")
    assert over.value.location is not None


def test_spin_once_runs_one_callback_and_waits_no_longer_than_it_may(run_ros2):
    """executors.py, `spin_once`: one handler, or none after the timeout."""

    def main():
        import rclpy
        from std_msgs.msg import Empty

        rclpy.init()
        node = rclpy.create_node("arm")
        seen = []
        for name in "ab":
            node.create_subscription(Empty, name, lambda _, name=name: seen.append(name), 10)
        for name in "ba":
            node.create_publisher(Empty, name, 10).publish(Empty())
        rclpy.spin_once(node)
        one = list(seen)
        rclpy.spin_once(node)
        start = node.get_clock().now().nanoseconds
        rclpy.spin_once(node, timeout_sec=0.3)
        return one, seen, round((node.get_clock().now().nanoseconds - start) / 1e9, 2)

    assert run_ros2(main) == (["a"], ["a", "b"], 0.3)


@pytest.mark.parametrize(("distro", "waited_s"), [("humble", 0.5), ("jazzy", 0.0)])
def test_who_spins_for_a_cancelled_future_waits_on_in_humble(run_ros2, distro, waited_s):
    """task.py and executors.py of jazzy (7.1.5) and humble."""

    def main():
        import time

        import rclpy

        rclpy.init()
        node, future, late = rclpy.create_node("arm"), rclpy.Future(), []
        future.cancel()
        future.add_done_callback(late.append)
        before = time.monotonic()
        rclpy.spin_until_future_complete(node, future, timeout_sec=0.5)
        return time.monotonic() - before, late == [future], future.cancelled(), future.done()

    took_s, was_called, *states = run_ros2(main, distro=distro)
    assert took_s == pytest.approx(waited_s, abs=0.05)
    assert was_called == (distro == "jazzy")
    assert states == [True, False]


@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_an_execute_callback_without_a_result_fails_where_it_is_sent(run_ros2, distro):
    """rclpy/action/server.py, and rosidl_generator_py `_msg.py.em` of humble and jazzy."""

    def main():
        import rclpy
        from control_msgs.action import GripperCommand
        from rclpy.action import ActionClient, ActionServer

        rclpy.init()
        node = rclpy.create_node("arm")
        ActionServer(node, GripperCommand, "grip", lambda handle: handle.succeed())
        client = ActionClient(node, GripperCommand, "grip")
        client.wait_for_server()
        client.send_goal_async(GripperCommand.Goal())
        try:
            while True:
                rclpy.spin_once(node, timeout_sec=0.1)
        except (AssertionError, AttributeError) as error:
            return type(error).__name__, str(error)

    humble = "The 'result' field must be a sub message of type 'GripperCommand_Result'"
    expected = {
        "humble": ("AssertionError", humble),
        "jazzy": ("AttributeError", "'NoneType' object has no attribute 'position'"),
    }
    assert run_ros2(main, distro=distro) == expected[distro]


@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_a_callback_of_parameters_without_a_result_refuses_in_jazzy(run_ros2, distro):
    """node.py of jazzy (7.1.5) and humble."""

    def main():
        import rclpy
        from rclpy.parameter import Parameter

        rclpy.init()
        node = rclpy.create_node("arm")
        node.declare_parameter("speed", 0.5)
        node.add_on_set_parameters_callback(lambda parameters: None)
        try:
            answer = node.set_parameters([Parameter("speed", value=0.7)])[0]
        except AttributeError:
            return "AttributeError"
        return answer.successful, answer.reason, node.get_parameter("speed").value

    refused = (False, "Callback returned an invalid type", 0.5)
    assert run_ros2(main, distro=distro) == ("AttributeError" if distro == "humble" else refused)
