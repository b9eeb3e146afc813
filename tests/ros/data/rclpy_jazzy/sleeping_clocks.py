import threading
import time
import rclpy
from rclpy.clock import Clock, ClockType
from rclpy.duration import Duration
from rclpy.time import Time

rclpy.init()
node = rclpy.create_node("n")
clock = node.get_clock()
begin = time.monotonic()
print(clock.sleep_for(Duration(seconds=0.2)), time.monotonic() - begin >= 0.19)
print(clock.sleep_until(clock.now() - Duration(seconds=1)), clock.sleep_until(clock.now() + Duration(seconds=0.1)))
steady = Clock(clock_type=ClockType.STEADY_TIME)
print(steady.sleep_for(Duration(seconds=0.1)))
try:
    clock.sleep_until(steady.now())
except Exception as error:
    print(type(error).__name__, error)
try:
    clock.sleep_for(0.1)
except Exception as error:
    print(type(error).__name__)
threading.Timer(0.3, rclpy.shutdown).start()
begin = time.monotonic()
print(clock.sleep_for(Duration(seconds=20)), time.monotonic() - begin < 10)
try:
    clock.sleep_for(Duration(seconds=1))
except Exception as error:
    print(type(error).__name__, error)
