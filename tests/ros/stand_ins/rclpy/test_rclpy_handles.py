"""rclpy: handles, what a program adds to executors, and executors of its own.

Sources: ros2/rclpy (branch rolling, commit ba72a017)
`rclpy/rclpy/{executors,node,task,waitable}.py`, `rclpy/src/rclpy/destroyable.cpp`.
"""

import pytest


def test_a_handle_is_good_until_its_thing_is_destroyed(run_ros2):
    def main():
        import rclpy
        from rclpy.exceptions import InvalidHandle
        from std_msgs.msg import Empty
        from std_srvs.srv import Trigger

        context = rclpy.Context()
        rclpy.init(context=context)
        node = rclpy.create_node("arm", context=context)
        things = [
            node.create_publisher(Empty, "t", 1),
            node.create_subscription(Empty, "t", print, 1),
            node.create_client(Trigger, "s"),
            node.create_service(Trigger, "s", lambda request, response: response),
            node.create_timer(1.0, print),
            node.create_guard_condition(print),
        ]
        for thing in things:
            with thing.handle:
                pass
            thing.destroy()
            with pytest.raises(InvalidHandle), thing.handle:
                pass
        with pytest.raises(AttributeError):
            node.handle = None
        node.destroy_node()
        context.destroy()
        for thing in (node, context):
            with pytest.raises(InvalidHandle), thing.handle:
                pass

    run_ros2(main)


def test_an_executor_runs_the_waitables_that_a_program_adds(run_ros2):
    def main():
        import rclpy
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.waitable import NumberOfEntities, Waitable

        class Box(Waitable):
            def __init__(self):
                super().__init__(ReentrantCallbackGroup())
                self.waiting, self.done = [1, 2], []

            def is_ready(self, wait_set):
                return bool(self.waiting)

            def take_data(self):
                return self.waiting.pop(0)

            async def execute(self, taken_data):
                self.done.append(taken_data)

            def get_num_entities(self):
                return NumberOfEntities(1, num_timers=2)

            def add_to_wait_set(self, wait_set):
                self.done.append("added")

        rclpy.init()
        node = rclpy.create_node("arm")
        box = Box()
        node.add_waitable(box)
        for _ in range(3):
            rclpy.spin_once(node, timeout_sec=0.1)
        both = box.get_num_entities() + box.get_num_entities()
        return box.done, both.num_subscriptions, both.num_timers

    assert run_ros2(main) == (["added", 1, 2], 2, 4)


def test_an_executor_of_the_program_takes_work_and_tasks(run_ros2):
    def main():
        import rclpy
        from rclpy.executors import (
            ConditionReachedException,
            Executor,
            ShutdownException,
            TimeoutException,
        )
        from rclpy.task import Future

        class Counting(Executor):
            def __init__(self):
                super().__init__()
                self.ran = []

            def spin_once(self, timeout_sec=None):
                task, entity, node = self.wait_for_ready_callbacks(timeout_sec=timeout_sec)
                task()
                self.ran.append((type(entity).__name__, node.get_name()))

        rclpy.init()
        node, executor = rclpy.create_node("arm"), Counting()
        node.executor = executor
        node.create_timer(0.1, lambda: None)
        executor.spin_once()
        with pytest.raises(TimeoutException):
            executor.wait_for_ready_callbacks(timeout_sec=0.01)
        with pytest.raises(ConditionReachedException):
            executor.wait_for_ready_callbacks(condition=lambda: True)
        executor.shutdown()
        with pytest.raises(ShutdownException):
            executor.wait_for_ready_callbacks()

        class Bare:
            def __init__(self):
                self.tasks = []

            def create_task(self, callback, *arguments):
                self.tasks.append((callback, arguments))

        bare = Bare()
        future = Future(executor=bare)
        future.add_done_callback(print)
        future.set_result(1)
        return executor.ran, [arguments == (future,) for _, arguments in bare.tasks]

    assert run_ros2(main) == ([("Timer", "arm")], [True])
