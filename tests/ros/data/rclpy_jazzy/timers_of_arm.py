import rclpy
import time
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

NS = 1_000_000_000
rclpy.init()
node = rclpy.create_node("timers")
executor = SingleThreadedExecutor()
executor.add_node(node)


def spin(seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=max(0.0, end - time.monotonic()))


ticks = []
timer = node.create_timer(0.4, lambda: ticks.append("tick"))
print(timer.timer_period_ns, timer.is_ready(), timer.is_canceled(), 0 < timer.time_until_next_call() <= 0.4 * NS)
spin(1.0)
print(len(ticks))
timer.cancel()
print(timer.is_canceled(), timer.is_ready(), timer.time_until_next_call())
spin(0.6)
print(len(ticks))
timer.reset()
print(timer.is_canceled(), 0.3 * NS < timer.time_until_next_call() <= 0.4 * NS)
spin(0.2)
timer.reset()
spin(0.3)
print("put off by its reset", len(ticks))
spin(0.3)
print(len(ticks))
timer.timer_period_ns = 2 * NS
print(timer.timer_period_ns, timer.time_until_next_call() > 1.0 * NS)
timer.reset()
spin(0.7)
print(len(ticks), timer.time_until_next_call() < 1.5 * NS)
print(node.destroy_timer(timer), node.destroy_timer(timer), len(list(node.timers)))
try:
    timer.cancel()
    print("cancelled after its end")
except Exception as error:
    print(type(error).__name__, error)

once = []


def one_shot():
    once.append(1)
    shot.cancel()


shot = node.create_timer(0.1, one_shot)
spin(0.6)
print("once", once, shot.is_canceled())
shot.reset()
spin(0.5)
print("once more", once)

gone = []


def ends_itself():
    gone.append(1)
    node.destroy_timer(self_ended)


self_ended = node.create_timer(0.1, ends_itself)
spin(0.5)
print("ends itself", gone, self_ended in list(node.timers))

slow = []


def slowly():
    slow.append(time.monotonic())
    time.sleep(0.5)


late = node.create_timer(0.2, slowly)
spin(2.2)
late.cancel()
print("late ones are left out", 3 <= len(slow) <= 5)

held = node.create_timer(0.1, lambda: held_ticks.append(1), autostart=False)
held_ticks = []
spin(0.4)
print("not begun", held_ticks, held.is_canceled())
held.reset()
spin(0.35)
print("begun", len(held_ticks) >= 2)
node.destroy_timer(held)
quick = []
fast = node.create_timer(0.0, lambda: quick.append(1))
executor.spin_once(timeout_sec=0.2)
executor.spin_once(timeout_sec=0.2)
print("no period", len(quick))
node.destroy_timer(fast)
for wrong in (-1.0,):
    try:
        made = node.create_timer(wrong, lambda: None)
        print("made", wrong)
        node.destroy_timer(made)
    except Exception as error:
        print(type(error).__name__, str(error).split(", at ")[0])
steady = node.create_timer(0.1, lambda: steady_ticks.append(1), clock=Clock(clock_type=ClockType.STEADY_TIME), callback_group=ReentrantCallbackGroup())
steady_ticks = []
print(steady.clock.clock_type.name, timer.clock.clock_type.name, node.get_clock().clock_type.name)
spin(0.35)
print(len(steady_ticks) >= 2, steady.time_since_last_call() < 2 * NS)
executor.shutdown()
node.destroy_node()
print(steady_ticks and list(node.timers))
rclpy.shutdown()
