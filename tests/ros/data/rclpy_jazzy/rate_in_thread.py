import threading
import time
import rclpy

rclpy.init()
node = rclpy.create_node("n")
thread = threading.Thread(target=rclpy.spin, args=(node,), daemon=True)
thread.start()
rate = node.create_rate(10)
begin = time.monotonic()
for _ in range(5):
    rate.sleep()
took = time.monotonic() - begin
print(0.35 < took < 1.5, len(list(node.timers)))
print(node.destroy_rate(rate), len(list(node.timers)))
try:
    rate.sleep()
except Exception as error:
    print(type(error).__name__, error)
other = node.create_rate(2.0, clock=rclpy.clock.Clock())
waiting = []


def wait():
    try:
        while True:
            other.sleep()
            waiting.append(1)
    except Exception as error:
        waiting.append(type(error).__name__)


waiter = threading.Thread(target=wait)
waiter.start()
time.sleep(0.7)
rclpy.shutdown()
waiter.join(3.0)
thread.join(3.0)
print(waiting[0], waiting[-1], thread.is_alive())
clock = rclpy.clock.Clock()
try:
    print(clock.sleep_for(rclpy.duration.Duration(seconds=0.1)))
except Exception as error:
    print(type(error).__name__, error)
