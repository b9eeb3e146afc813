import threading
import time
import rclpy
from rclpy.callback_groups import CallbackGroup, MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor

rclpy.init()


def most_at_once(make, n_timers):
    node = rclpy.create_node("n" + str(n_timers))
    group, running, most, lock = make(), [], [0], threading.Lock()

    def work():
        with lock:
            running.append(1)
            most[0] = max(most[0], len(running))
        time.sleep(0.3)
        with lock:
            running.pop()

    for _ in range(n_timers):
        node.create_timer(0.1, work, callback_group=group() if isinstance(group, type) else group)
    executor = MultiThreadedExecutor(num_threads=6)
    executor.add_node(node)
    end = time.monotonic() + 2.0
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)
    executor.shutdown()
    node.destroy_node()
    return most[0]


print("one group", most_at_once(MutuallyExclusiveCallbackGroup, 3))
print("its own each", most_at_once(lambda: MutuallyExclusiveCallbackGroup, 3) > 1)
print("reentrant", most_at_once(ReentrantCallbackGroup, 2) > 1)
node = rclpy.create_node("told")
group = MutuallyExclusiveCallbackGroup()
timer = node.create_timer(1.0, print, group)
print(group.has_entity(timer), node.default_callback_group.has_entity(timer), type(node.default_callback_group).__name__)
print(timer.callback_group is group, isinstance(group, CallbackGroup), group.can_execute(timer))
print(group.beginning_execution(timer), group.can_execute(timer), group.ending_execution(timer))
try:
    CallbackGroup()
except Exception as error:
    print(type(error).__name__)
