import threading, time
import rclpy
from rclpy.action import ActionClient
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from std_msgs.msg import Int32
from control_msgs.action import GripperCommand


def spun_twice(kind, has_client):
    rclpy.init()
    node = rclpy.create_node("n")
    node.create_subscription(Int32, "/t", lambda message: None, 10)
    publisher = node.create_publisher(Int32, "/t", 10)
    client = ActionClient(node, GripperCommand, "/g") if has_client else None
    executor = kind()
    executor.add_node(node)
    errors = []

    def spin():
        try:
            executor.spin()
        except Exception as error:
            errors.append(f"{type(error).__name__} {str(error).split(', at')[0]}")

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    for number in range(200):
        if errors:
            break
        publisher.publish(Int32(data=number))
        try:
            executor.spin_once(timeout_sec=0.02)
        except Exception as error:
            errors.append(f"{type(error).__name__} {str(error).split(', at')[0]}")
    time.sleep(0.1)
    print(kind.__name__, "with a client" if has_client else "without", errors or "goes on", flush=True)
    rclpy.shutdown()
    thread.join(2.0)


spun_twice(SingleThreadedExecutor, False)
spun_twice(SingleThreadedExecutor, True)
spun_twice(MultiThreadedExecutor, False)
spun_twice(MultiThreadedExecutor, True)
