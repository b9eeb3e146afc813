"""rclpy: an executor in a thread beside the main program, and who takes a node from it.

Sources: ros2/rclpy (branches jazzy and rolling) `rclpy/{__init__,node,executors,timer,task}.py`:
a node is in one executor, whose place the one that is given it next takes (`Node.executor`);
`rclpy.spin_once` gives it to the global executor, and the pull request 1446 leaves it in an
executor that had it. The patterns are those of the examples of AndrejOrsula/pymoveit2.
"""

import pytest

from tracerisk.ros.time.scheduler import RunOver

SECOND = 1_000_000_000


def test_rates_of_the_main_thread_beat_while_a_thread_spins(run_ros2):
    def main():
        from threading import Thread

        import rclpy
        from rclpy.node import Node

        rclpy.init()
        node = Node("arm")
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        thread = Thread(target=executor.spin, daemon=True, args=())
        thread.start()
        began = node.get_clock().now().nanoseconds
        node.create_rate(1.0).sleep()
        node.create_rate(10.0).sleep()
        rate = node.create_rate(4.0)
        for _ in range(4):
            rate.sleep()
        took = node.get_clock().now().nanoseconds - began
        rclpy.shutdown()
        thread.join()
        return round(took / SECOND, 2), thread.is_alive()

    assert run_ros2(main) == (2.1, False)


def test_futures_are_polled_beside_an_executor_with_a_rate_and_completed_by_its_callbacks(run_ros2):
    def main():
        from threading import Thread

        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.node import Node
        from std_srvs.srv import Trigger

        rclpy.init()
        node = Node("arm")
        group = ReentrantCallbackGroup()
        node.create_service(Trigger, "go", lambda request, response: response, callback_group=group)
        client = node.create_client(Trigger, "go", callback_group=group)
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        Thread(target=executor.spin, daemon=True).start()
        rate, fast, executing, order = node.create_rate(10), node.create_rate(1000.0), [], []
        for step in ("first", "second"):
            future = client.call_async(Trigger.Request())
            while not future.done():
                rate.sleep()
            order.append((step, future.result().success))
            executing.append(1)
            client.call_async(Trigger.Request()).add_done_callback(lambda _: executing.pop())
            while executing:
                fast.sleep()
            order.append(client.call(Trigger.Request()).success)
        return order

    assert run_ros2(main) == [("first", False), False, ("second", False), False]


TAKEN = (
    r"MainThread waits for {what}, which nothing provides: nothing spins node /arm since the call "
    r"at test_rclpy_background\.py:\d+ took it from the MultiThreadedExecutor that a thread spins"
)


def test_a_rate_that_has_beaten_hangs_once_spin_once_has_taken_its_node(run_ros2):
    """The reader learns which line took the node, and from what."""

    def main():
        from threading import Thread

        import rclpy
        from rclpy.node import Node

        rclpy.init()
        node = Node("arm")
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        Thread(target=executor.spin, daemon=True).start()
        rate = node.create_rate(10)
        rate.sleep()
        rclpy.spin_once(node, timeout_sec=1.0)
        assert node not in executor.get_nodes()
        rate.sleep()
        rate.sleep()

    with pytest.raises(RunOver, match=TAKEN.format(what="the timer of a rate")) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_call_hangs_once_a_callback_has_spun_its_node_itself(run_ros2):
    """The response comes to the same node, which nothing spins any more."""

    def main():
        from threading import Thread

        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.node import Node
        from std_srvs.srv import Trigger

        rclpy.init()
        node = Node("arm")
        group = ReentrantCallbackGroup()
        inner = node.create_client(Trigger, "inner", callback_group=group)
        node.create_service(Trigger, "inner", lambda request, response: response)

        def serve(request, response):
            future = inner.call_async(Trigger.Request())
            rclpy.spin_until_future_complete(node, future)
            response.success = True
            return response

        node.create_service(Trigger, "outer", serve, callback_group=group)
        client = node.create_client(Trigger, "outer", callback_group=group)
        executor = rclpy.executors.MultiThreadedExecutor(4)
        executor.add_node(node)
        Thread(target=executor.spin, daemon=True).start()
        client.call(Trigger.Request())

    with pytest.raises(RunOver, match=TAKEN.format(what="the response of service /outer.*")):
        run_ros2(main)


def test_a_node_that_is_given_back_is_spun_again(run_ros2):
    def main():
        from threading import Thread

        import rclpy
        from rclpy.node import Node

        rclpy.init()
        node = Node("arm")
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        Thread(target=executor.spin, daemon=True).start()
        rate = node.create_rate(10)
        rclpy.spin_once(node, timeout_sec=1.0)
        executor.add_node(node)
        rate.sleep()
        rate.sleep()
        return node in executor.get_nodes()

    assert run_ros2(main)


@pytest.mark.parametrize("distro", ["humble", "jazzy"])
def test_spin_once_takes_out_the_node_that_it_added_and_on_humble_any(run_ros2, distro):
    def main():
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        rclpy.init()
        node, executor, seen = Node("arm"), SingleThreadedExecutor(), []
        node.create_timer(0.1, lambda: seen.append(1))
        rclpy.spin_once(node, executor=executor)
        before = executor.get_nodes()
        executor.add_node(node)
        rclpy.spin_once(node, executor=executor)
        return before, executor.get_nodes(), len(seen)

    before, after, n_seen = run_ros2(main, distro=distro)
    assert (before, len(after), n_seen) == ([], 1 if distro == "jazzy" else 0, 2)


@pytest.mark.parametrize("n_threads", [2, 4])
def test_a_rate_in_a_timers_callback_beats_in_another_thread_of_the_pool(run_ros2, n_threads):
    def main():
        import rclpy
        from rclpy.executors import MultiThreadedExecutor
        from rclpy.node import Node

        rclpy.init()
        node = Node("arm")
        rate, seen = node.create_rate(10), []

        def beat():
            timer.cancel()
            for _ in range(3):
                rate.sleep()
                seen.append(1)
            rclpy.shutdown()

        timer = node.create_timer(0.1, beat)
        executor = MultiThreadedExecutor(n_threads)
        executor.add_node(node)
        executor.spin()
        return len(seen)

    assert run_ros2(main) == 3


@pytest.mark.parametrize(
    ("name", "arguments"), [("SingleThreadedExecutor", ()), ("MultiThreadedExecutor", (2,))]
)
def test_a_rate_in_callbacks_that_take_all_threads_is_a_deadlock_that_says_so(
    run_ros2, name, arguments
):
    def main():
        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.node import Node

        rclpy.init()
        node = Node("arm")
        executor = getattr(rclpy.executors, name)(*arguments)
        rate, group = node.create_rate(1), ReentrantCallbackGroup()
        node.create_timer(0.1, rate.sleep, group)
        node.create_timer(0.1, rate.sleep, group)
        executor.add_node(node)
        executor.spin()

    with pytest.raises(RunOver, match=f"no thread of the {name} that spins node /arm is free"):
        run_ros2(main)


def test_a_coroutine_of_a_node_that_has_left_is_not_resumed(run_ros2):
    def main():
        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node

        rclpy.init()
        node, other = Node("arm"), Node("other")
        executor, gate, seen = SingleThreadedExecutor(), rclpy.Future(), []

        async def beat():
            timer.cancel()
            await gate
            seen.append("resumed")

        timer = node.create_timer(0.1, beat)
        executor.add_node(node)
        executor.add_node(other)
        executor.spin_once(timeout_sec=1.0)
        executor.remove_node(node)
        gate.set_result(None)
        executor.spin_once(timeout_sec=0.5)
        left = list(seen)
        executor.add_node(node)
        executor.spin_once(timeout_sec=0.5)
        return left, seen

    assert run_ros2(main) == ([], ["resumed"])


@pytest.mark.parametrize(
    ("distro", "answers"),
    [("humble", (False, ["begun"], True)), ("jazzy", (True, ["begun"], True))],
)
def test_who_shuts_a_busy_executor_down_waits_for_it_on_humble(run_ros2, distro, answers):
    def main():
        import time
        from threading import Thread

        import rclpy
        from rclpy.node import Node

        rclpy.init()
        node, seen = Node("arm"), []

        def beat():
            seen.append("begun")
            time.sleep(1.0)
            seen.append("ended")

        node.create_timer(0.5, beat)
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        thread = Thread(target=executor.spin, daemon=True)
        thread.start()
        time.sleep(0.7)
        in_time = executor.shutdown(timeout_sec=0.2)
        after_timeout = list(seen)
        again = executor.shutdown()
        return in_time, after_timeout, again, seen

    *found, seen = run_ros2(main, distro=distro)
    assert tuple(found) == answers
    assert ("ended" in seen) == (distro == "humble")


def test_the_other_nodes_go_on_when_one_is_destroyed(run_ros2):
    def main():
        from threading import Thread

        import rclpy
        from rclpy.node import Node

        rclpy.init()
        node, other, seen = Node("arm"), Node("other"), []
        node.create_timer(0.1, lambda: seen.append("arm"))
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        executor.add_node(other)
        Thread(target=executor.spin, daemon=True).start()
        rate = other.create_rate(2.0)
        rate.sleep()
        node.destroy_node()
        n_seen = len(seen)
        rate.sleep()
        return n_seen > 2, len(seen) == n_seen

    assert run_ros2(main) == (True, True)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize(
    ("first", "why"),
    [
        ("spins", r" since the call at test_rclpy_background\.py:\d+ took it from the Multi"),
        ("never", "$"),
    ],
)
def test_a_loop_that_polls_a_future_which_nothing_completes_is_a_deadlock(run_ros2, first, why):
    def main():
        import time
        from threading import Thread

        import rclpy
        from rclpy.node import Node
        from std_srvs.srv import Trigger

        rclpy.init()
        node = Node("arm")
        node.create_service(Trigger, "go", lambda request, response: response)
        other = Node("other")
        client = other.create_client(Trigger, "go")
        executor = rclpy.executors.MultiThreadedExecutor(2)
        executor.add_node(node)
        if first == "spins":
            executor.add_node(other)
        Thread(target=executor.spin, daemon=True).start()
        if first == "spins":
            rclpy.spin_once(other, timeout_sec=0.1)
        future = client.call_async(Trigger.Request())
        while not future.done():
            time.sleep(0.1)

    text = r"MainThread has asked for 60 s whether the response of service /go .* is there: "
    with pytest.raises(RunOver, match=text + "nothing spins node /other" + why) as over:
        run_ros2(main)
    assert over.value.cause == "deadlock"


def test_a_loop_that_polls_while_a_callback_is_slow_is_none(run_ros2):
    def main():
        import time
        from threading import Thread

        import rclpy
        from rclpy.executors import SingleThreadedExecutor
        from rclpy.node import Node
        from std_srvs.srv import Trigger

        rclpy.init()
        node = Node("arm")
        other = Node("other")

        def serve(request, response):
            time.sleep(0.1)
            return response

        def work():
            timer.cancel()
            time.sleep(100.0)

        node.create_service(Trigger, "go", serve)
        timer = other.create_timer(0.05, work)
        client = other.create_client(Trigger, "go")
        for each in (node, other):
            executor = SingleThreadedExecutor()
            executor.add_node(each)
            Thread(target=executor.spin, daemon=True).start()
        future = client.call_async(Trigger.Request())
        while not future.done():
            time.sleep(0.1)
        return time.monotonic() > 100.0

    assert run_ros2(main)
