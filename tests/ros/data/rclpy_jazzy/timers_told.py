import time
import rclpy
from rclpy.clock import Clock, ClockType

rclpy.init()
node = rclpy.create_node("n")
calls = []
timer = node.create_timer(0.2, lambda: calls.append("t"))
print(timer.timer_period_ns, timer.is_canceled(), timer.is_ready(), timer.time_until_next_call() <= 200_000_000)
timer.cancel()
print(timer.is_canceled(), timer.is_ready(), timer.time_until_next_call())
rclpy.spin_once(node, timeout_sec=0.3)
print(calls)
timer.reset()
print(timer.is_canceled())
rclpy.spin_once(node, timeout_sec=1.0)
print(calls, timer.time_since_last_call() >= 0)
timer.timer_period_ns = 50_000_000
print(timer.timer_period_ns)
rclpy.spin_once(node, timeout_sec=1.0)
print(calls)
time.sleep(0.33)
rclpy.spin_once(node, timeout_sec=1.0)
rclpy.spin_once(node, timeout_sec=0.0)
print(calls)
steady = node.create_timer(0.1, lambda: calls.append("s"), clock=Clock(clock_type=ClockType.STEADY_TIME))
print(int(steady.clock.clock_type), timer.clock is node.get_clock(), len(list(node.timers)))
print(node.destroy_timer(steady), node.destroy_timer(steady), len(list(node.timers)))
late = node.create_timer(0.1, lambda: calls.append("late"), autostart=False)
print(late.is_canceled())
once = None


def fire():
    calls.append("once")
    once.cancel()


once = node.create_timer(0.05, fire)
timer.cancel()
for _ in range(4):
    rclpy.spin_once(node, timeout_sec=0.1)
print(calls.count("once"), "late" in calls)
for period in (0, -1.0, "a", None, float("nan")):
    try:
        made = node.create_timer(period, print)
        print(period, made.timer_period_ns)
        made.cancel()
    except Exception as error:
        print(period, type(error).__name__)
timer.destroy()
try:
    timer.reset()
except Exception as error:
    print(type(error).__name__)
