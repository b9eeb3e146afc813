"""What fails in a node, and what its libraries do with it."""

import threading

import rclpy
from example_interfaces.action import Fibonacci
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import SingleThreadedExecutor
from std_msgs.msg import String


def turn(handle):
    raise IndexError("no turn")


def work():
    raise RuntimeError("no work")


def main():
    rclpy.init()
    node = rclpy.create_node("odd")
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    group = ReentrantCallbackGroup()
    server = ActionServer(node, Fibonacci, "turn", turn, callback_group=group)
    client = ActionClient(node, Fibonacci, "turn", callback_group=group)
    while not client.server_is_ready():
        executor.spin_once(timeout_sec=0.1)
    sent = client.send_goal_async(Fibonacci.Goal(order=3))
    executor.spin_until_future_complete(sent)
    result = sent.result().get_result_async()
    executor.spin_until_future_complete(result)
    print("> status", result.result().status)
    thread = threading.Thread(target=work, name="worker")
    thread.start()
    thread.join()
    for number in range(3):
        node.get_logger().error(f"lost {number} parts")
    publisher = node.create_publisher(String, "/parts", 1)
    try:
        publisher.publish(3.0)
    except TypeError as error:
        print("> caught", type(error).__name__)
    server.destroy()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
