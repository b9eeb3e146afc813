"""rclpy: what spins runs, and what can never come is told.

Sources: ros2/rclpy (branch jazzy) `rclpy/{__init__,executors,task,callback_groups,timer}.py`, and
its `test/test_{executor,callback_group,task,timer}.py`.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000


def test_callbacks_run_only_while_something_spins(run_ros2):
    def main():
        import time

        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        node = rclpy.create_node("arm")
        seen = []
        node.create_subscription(String, "t", lambda message: seen.append(message.data), 10)
        publisher = node.create_publisher(String, "t", 10)
        for text in "abc":
            publisher.publish(String(data=text))
        time.sleep(1.0)
        before = list(seen)
        rclpy.spin_once(node)
        after_one = list(seen)
        rclpy.spin_once(node, timeout_sec=0.1)
        rclpy.spin_once(node, timeout_sec=0.1)
        rclpy.spin_once(node, timeout_sec=0.1)
        return before, after_one, seen

    assert run_ros2(main) == ([], ["a"], ["a", "b", "c"])


def test_a_queue_keeps_as_many_messages_as_its_depth(run_ros2):
    def main():
        import rclpy
        from std_msgs.msg import Int32

        rclpy.init()
        node = rclpy.create_node("arm")
        seen = []
        node.create_subscription(Int32, "t", lambda message: seen.append(message.data), 2)
        publisher = node.create_publisher(Int32, "t", 10)
        for number in range(5):
            publisher.publish(Int32(data=number))
        for _ in range(5):
            rclpy.spin_once(node, timeout_sec=0.0)
        return seen

    assert run_ros2(main) == [3, 4]


def test_timers_beat_in_simulated_time_and_leave_out_what_they_missed(run_ros2):
    def main():
        import time

        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        start = node.get_clock().now().nanoseconds
        seen = []

        def beat():
            seen.append(round((node.get_clock().now().nanoseconds - start) / 1e9, 1))
            if len(seen) == 2:
                time.sleep(1.2)
            if len(seen) == 4:
                rclpy.shutdown()

        node.create_timer(0.5, beat)
        rclpy.spin(node)
        return seen

    assert run_ros2(main) == [0.5, 1.0, 2.2, 2.5]


def test_a_nested_spin_for_a_response_of_the_same_group_is_a_deadlock(run_ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_service(Trigger, "go", lambda request, response: response)
        client = node.create_client(Trigger, "go")

        def beat():
            rclpy.spin_until_future_complete(node, client.call_async(Trigger.Request()))

        node.create_timer(0.1, beat)
        rclpy.spin(node)

    with pytest.raises(RunOver, match=r"the response of service /go \(std_srvs/Trigger\)") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"
    assert [name.split(".")[-1] for _, name in over.value.stack][-1] == "beat"


def test_a_nested_spin_works_in_a_reentrant_group(run_ros2):
    def main():
        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        group = ReentrantCallbackGroup()

        def answer(request, response):
            response.message = "done"
            return response

        node.create_service(Trigger, "go", answer, callback_group=group)
        client = node.create_client(Trigger, "go", callback_group=group)
        seen = []

        def beat():
            timer.cancel()
            future = client.call_async(Trigger.Request())
            rclpy.spin_until_future_complete(node, future)
            seen.append(future.result().message)
            rclpy.shutdown()

        timer = node.create_timer(0.1, beat, group)
        rclpy.spin(node)
        return seen

    assert run_ros2(main) == ["done"]


def test_a_service_that_nobody_serves_is_a_deadlock_that_names_it(run_ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        client = node.create_client(Trigger, "go")
        assert client.wait_for_service(timeout_sec=1.0) is False
        assert client.service_is_ready() is False
        client.wait_for_service()

    with pytest.raises(RunOver, match=r"service /go \(std_srvs/Trigger\)") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_call_that_waits_in_a_callback_of_a_single_thread_is_a_deadlock(run_ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_service(Trigger, "go", lambda request, response: response)
        client = node.create_client(Trigger, "go")
        node.create_timer(0.1, lambda: client.call(Trigger.Request()))
        rclpy.spin(node)

    with pytest.raises(RunOver) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_call_in_a_callback_works_with_threads_and_groups_of_their_own(run_ros2):
    def main():
        import rclpy
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup
        from rclpy.executors import MultiThreadedExecutor
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        groups = [MutuallyExclusiveCallbackGroup() for _ in range(3)]
        node.create_service(
            Trigger, "go", lambda request, response: response, callback_group=groups[0]
        )
        client = node.create_client(Trigger, "go", callback_group=groups[1])
        seen = []

        def beat():
            seen.append(client.call(Trigger.Request()).success)
            rclpy.shutdown()

        node.create_timer(0.1, beat, groups[2])
        executor = MultiThreadedExecutor()
        executor.add_node(node)
        executor.spin()
        return seen

    assert run_ros2(main) == [False]


@pytest.mark.parametrize(("group", "expected"), [("exclusive", 1), ("reentrant", 2)])
def test_groups_exclude_as_they_say(run_ros2, group, expected):
    def main():
        import time

        import rclpy
        from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
        from rclpy.executors import MultiThreadedExecutor

        rclpy.init()
        node = rclpy.create_node("arm")
        kind = MutuallyExclusiveCallbackGroup if group == "exclusive" else ReentrantCallbackGroup
        shared = kind()
        running, most, ended = [], [], []

        def beat():
            running.append(1)
            most.append(len(running))
            time.sleep(0.25)
            running.pop()
            ended.append(1)
            if len(ended) == 4:
                rclpy.shutdown()

        node.create_timer(0.2, beat, shared)
        node.create_timer(0.2, beat, shared)
        executor = MultiThreadedExecutor(num_threads=2)
        executor.add_node(node)
        executor.spin()
        return max(most)

    assert run_ros2(main) == expected


@pytest.mark.parametrize("executor", ["SingleThreadedExecutor", "MultiThreadedExecutor"])
@pytest.mark.parametrize("callback", ["function", "coroutine"])
def test_a_callback_that_exits_ends_the_spin_of_its_executor(run_ros2, executor, callback):
    def main():
        import rclpy
        import rclpy.executors

        rclpy.init()
        node = rclpy.create_node("arm")
        beats = []

        def beat():
            beats.append(1)
            if len(beats) == 2:
                raise SystemExit("done")

        async def beat_later():
            beat()

        node.create_timer(0.1, beat if callback == "function" else beat_later)
        spinning = getattr(rclpy.executors, executor)()
        spinning.add_node(node)
        try:
            spinning.spin()
        except SystemExit as end:
            return end.code, len(beats)

    assert run_ros2(main) == ("done", 2)


def test_coroutines_await_responses_and_futures(run_ros2):
    def main():
        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from std_srvs.srv import SetBool

        rclpy.init()
        node = rclpy.create_node("arm")
        group = ReentrantCallbackGroup()
        order = []

        def answer(request, response):
            order.append("served")
            response.success = request.data
            return response

        node.create_service(SetBool, "go", answer, callback_group=group)
        client = node.create_client(SetBool, "go", callback_group=group)

        async def beat():
            timer.cancel()
            order.append("begun")
            response = await client.call_async(SetBool.Request(data=True))
            order.append(response.success)
            gate.set_result("open")

        async def later():
            order.append(await gate)
            return 7

        gate = rclpy.Future()
        timer = node.create_timer(0.1, beat, group)
        rclpy.get_global_executor().add_node(node)
        task = rclpy.get_global_executor().create_task(later)
        task.add_done_callback(lambda done: order.append(done.result()))
        rclpy.spin_until_future_complete(node, task)
        for _ in range(9):
            rclpy.spin_once(node, timeout_sec=0.0)
        return order

    assert run_ros2(main) == ["begun", "served", True, "open", 7]


def test_an_exclusive_group_stays_busy_while_its_callback_awaits(run_ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        client = node.create_client(Trigger, "go")
        other = rclpy.create_node("other")
        other.create_service(Trigger, "go", lambda request, response: response)

        async def beat():
            await client.call_async(Trigger.Request())

        node.create_timer(0.1, beat)
        executor = rclpy.get_global_executor()
        executor.add_node(other)
        executor.add_node(node)
        future = executor.create_task(lambda: None)
        executor.spin_until_future_complete(future)
        seen = []
        node.create_timer(0.2, lambda: seen.append(1))
        rclpy.spin_once(node, timeout_sec=2.0)
        rclpy.spin_once(node, timeout_sec=2.0)
        return seen

    assert run_ros2(main) == []


def test_an_exception_in_a_callback_leaves_spin(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")

        def beat():
            raise ValueError("lost")

        node.create_timer(0.1, beat)
        with pytest.raises(ValueError, match="lost"):
            rclpy.spin(node)

    run_ros2(main)


def test_a_node_that_only_listens_ends_quietly(run_ros2):
    def main():
        import rclpy
        from std_msgs.msg import String

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_subscription(String, "t", print, 10)
        rclpy.spin(node)

    with pytest.raises(RunOver) as over:
        run_ros2(main)
    assert over.value.cause == "quiescent"


def test_spin_for_a_future_gives_up_after_its_timeout(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        start = node.get_clock().now()
        future = rclpy.Future()
        rclpy.spin_until_future_complete(node, future, timeout_sec=2.0)
        took = node.get_clock().now() - start
        return future.done(), took.nanoseconds

    done, took = run_ros2(main)
    assert (done, took // SECOND) == (False, 2)


def test_a_background_executor_serves_a_rate_and_a_call(run_ros2):
    def main():
        import threading

        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_service(Trigger, "go", lambda request, response: response)
        client = node.create_client(Trigger, "go")
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        threading.Thread(target=executor.spin, daemon=True).start()
        rate = node.create_rate(10)
        start = node.get_clock().now().nanoseconds
        for _ in range(5):
            rate.sleep()
        took = node.get_clock().now().nanoseconds - start
        return round(took / SECOND, 1), client.call(Trigger.Request()).success

    assert run_ros2(main) == (0.5, False)


def test_a_rate_that_nothing_beats_is_a_deadlock(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        rclpy.create_node("arm").create_rate(10).sleep()

    with pytest.raises(RunOver, match="the timer of a rate") as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_loop_that_asks_ok_comes_to_its_end(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_timer(0.5, rclpy.shutdown)
        while rclpy.ok():
            rclpy.spin_once(node, timeout_sec=0.1)
        with pytest.raises(RuntimeError):
            rclpy.shutdown()
        rclpy.try_shutdown()
        return node.get_clock().now().nanoseconds

    assert run_ros2(main) > 0


def test_a_guard_condition_runs_once_for_its_triggers(run_ros2):
    def main():
        import rclpy

        rclpy.init()
        node = rclpy.create_node("arm")
        seen = []
        guard = node.create_guard_condition(lambda: seen.append(1))
        guard.trigger()
        guard.trigger()
        for _ in range(3):
            rclpy.spin_once(node, timeout_sec=0.0)
        return seen

    assert run_ros2(main) == [1]


def test_two_runs_are_the_same(run_ros2):
    def main():
        import time

        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.executors import MultiThreadedExecutor

        rclpy.init()
        node = rclpy.create_node("arm")
        group = ReentrantCallbackGroup()
        seen = []

        def beat(name, seconds):
            seen.append((name, node.get_clock().now().nanoseconds))
            time.sleep(seconds)
            if len(seen) > 40:
                rclpy.try_shutdown()

        node.create_timer(0.01, lambda: beat("a", 0.013), group)
        node.create_timer(0.015, lambda: beat("b", 0.02), group)
        executor = MultiThreadedExecutor(num_threads=3)
        executor.add_node(node)
        executor.spin()
        return seen

    assert run_ros2(main) == run_ros2(main)


def test_a_task_of_asyncio_awaits_a_future_beside_its_own_spinning(run_ros2):
    """Until ROS 2 Jazzy, `Future.__await__` yields nothing, so that asyncio can await it."""

    def main():
        import asyncio

        import rclpy
        from std_srvs.srv import SetBool

        rclpy.init()
        node, other = rclpy.create_node("cell"), rclpy.create_node("gripper")

        def answer(request, response):
            response.success = request.data
            return response

        other.create_service(SetBool, "suction", answer)
        client = node.create_client(SetBool, "suction")

        async def spin():
            while rclpy.ok():
                rclpy.spin_once(other, timeout_sec=0)
                rclpy.spin_once(node, timeout_sec=0)
                await asyncio.sleep(0.005)

        async def work():
            spinning = asyncio.ensure_future(spin())
            response = await client.call_async(SetBool.Request(data=True))
            spinning.cancel()
            return response.success

        return asyncio.run(work())

    assert run_ros2(main) is True


def test_humble_takes_no_timeout_of_a_call(run_ros2):
    def main():
        import rclpy
        from std_srvs.srv import Trigger

        rclpy.init()
        client = rclpy.create_node("arm").create_client(Trigger, "absent")
        for given in ({"timeout_sec": 0.1}, {"timeout_sec": None}):
            with pytest.raises(TypeError, match="unexpected keyword argument"):
                client.call(Trigger.Request(), **given)

    run_ros2(main, distro="humble")


@pytest.mark.parametrize(("distro", "turns"), [("humble", 3), ("jazzy", 5)])
def test_a_call_leaves_fewer_tasks_behind_on_humble(run_ros2, distro, turns):
    def main():
        import rclpy
        from std_msgs.msg import Int32
        from std_srvs.srv import Trigger

        rclpy.init()
        node = rclpy.create_node("arm")
        node.create_service(Trigger, "s", lambda request, response: response)
        client, seen = node.create_client(Trigger, "s"), []
        node.create_subscription(Int32, "x", seen.append, 10)
        publisher = node.create_publisher(Int32, "x", 10)
        rclpy.spin_until_future_complete(node, client.call_async(Trigger.Request()))
        publisher.publish(Int32())
        used = 0
        while not seen:
            rclpy.spin_once(node, timeout_sec=0.1)
            used += 1
        return used

    assert run_ros2(main, distro=distro) == turns


def test_tasks_left_by_a_wait_take_no_time_of_a_loop_that_reads_the_clock(run_ros2):
    def main():
        import time

        import rclpy
        from rclpy.task import Future
        from std_msgs.msg import Int32

        rclpy.init()
        node, seen = rclpy.create_node("arm"), []
        done = Future(executor=rclpy.get_global_executor())
        node.create_subscription(Int32, "x", lambda message: seen.append(time.monotonic()), 10)
        publisher = node.create_publisher(Int32, "x", 10)
        turns = iter(range(300))
        beat = node.create_timer(0.001, lambda: next(turns, None) is None and done.set_result(True))
        rclpy.spin_until_future_complete(node, done)
        beat.cancel()
        publisher.publish(Int32())
        begun_s = time.monotonic()
        while not seen and time.monotonic() < begun_s + 1.0:
            rclpy.spin_once(node, timeout_sec=0.1)
        return seen[0] - begun_s

    assert run_ros2(main, distro="jazzy") < 0.02
