import rclpy
import threading
import time
from rclpy.node import Node
from std_msgs.msg import Int32


class Streamer(Node):
    """Streams set-points at a rate from a thread, and the main thread spins."""

    def __init__(self):
        super().__init__("streamer")
        self.publisher = self.create_publisher(Int32, "set_point", 10)
        self.got = []
        self.create_subscription(Int32, "set_point", lambda message: self.got.append(message.data), 10)
        self.ended = threading.Event()
        self.took = None

    def run(self):
        rate = self.create_rate(10)
        began = time.monotonic()
        for number in range(8):
            self.publisher.publish(Int32(data=number))
            rate.sleep()
        self.took = time.monotonic() - began
        print("destroyed", self.destroy_rate(rate))
        try:
            rate.sleep()
        except Exception as error:
            print(type(error).__name__, error)
        self.ended.set()


rclpy.init()
node = Streamer()
thread = threading.Thread(target=node.run)
thread.start()
while not node.ended.is_set():
    rclpy.spin_once(node, timeout_sec=0.05)
thread.join()
for _ in range(9):
    rclpy.spin_once(node, timeout_sec=0.05)
print(node.got, 0.65 < node.took < 1.6)

rate = node.create_rate(5, node.get_clock())
late = []


def sleeper():
    try:
        while rclpy.ok():
            rate.sleep()
            late.append("slept")
    except rclpy.exceptions.ROSInterruptException as error:
        late.append(f"{type(error).__name__} {error}")
    except Exception as error:
        late.append(f"{type(error).__name__} {error}")


thread = threading.Thread(target=sleeper)
thread.start()
spinning = threading.Thread(target=rclpy.spin, args=(node,), daemon=True)
spinning.start()
time.sleep(1.3)
rclpy.shutdown()
thread.join(3.0)
spinning.join(3.0)
print(thread.is_alive(), spinning.is_alive(), late.count("slept") in (4, 5, 6, 7, 8), [line for line in late if line != "slept"])
try:
    rclpy.init()
    other = rclpy.create_node("other")
    other.create_rate(0)
except Exception as error:
    print(type(error).__name__, error)
for frequency in (-1.0, "10"):
    try:
        other.create_rate(frequency)
        print("made", frequency)
    except Exception as error:
        print(type(error).__name__, error)
clock = other.get_clock()
before = time.monotonic()
print(clock.sleep_for(rclpy.duration.Duration(seconds=0.3)), 0.28 < time.monotonic() - before < 1.0)
print(clock.sleep_until(clock.now()), clock.sleep_until(clock.now() + rclpy.duration.Duration(seconds=0.2)))
try:
    clock.sleep_until(rclpy.time.Time())
except Exception as error:
    print(type(error).__name__, error)
rclpy.shutdown()
