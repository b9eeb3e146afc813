import rclpy, time
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
rclpy.init()
for kind in (SingleThreadedExecutor, lambda: MultiThreadedExecutor(2)):
    node = rclpy.create_node("n")
    executor = kind()
    executor.add_node(node)
    calls = []
    def tick():
        calls.append(1)
        raise RuntimeError("boom")
    timer = node.create_timer(0.1, tick)
    turns = 0
    try:
        for _ in range(5):
            executor.spin_once(timeout_sec=0.3)
            turns += 1
            time.sleep(0.02)
        print("none", len(calls))
    except RuntimeError as error:
        print(type(executor).__name__, error, "turns", turns, "calls", len(calls))
    timer.cancel()
    executor.shutdown()
node = rclpy.create_node("once")
executor = MultiThreadedExecutor(2)
executor.add_node(node)
def once():
    timer.cancel()
    time.sleep(0.1)
    raise RuntimeError("once")
timer = node.create_timer(0.1, once)
try:
    for _ in range(4):
        executor.spin_once(timeout_sec=0.2)
    print("no other work: the error is not seen")
    node.create_guard_condition(lambda: None).trigger()
    executor.spin_once(timeout_sec=0.2)
    print("still not")
except RuntimeError as error:
    print("seen with the next work:", error)
