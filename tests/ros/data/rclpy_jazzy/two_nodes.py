import rclpy
import threading
import time
from geometry_msgs.msg import PoseStamped
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import String


class Camera(Node):
    def __init__(self):
        super().__init__("camera", namespace="cell")
        self.publisher = self.create_publisher(PoseStamped, "pose", 10)
        self.timer = self.create_timer(0.1, self.see)
        self.count = 0

    def see(self):
        self.count += 1
        pose = PoseStamped()
        pose.header.stamp = self.get_clock().now().to_msg()
        pose.header.frame_id = f"seen_{self.count}"
        self.publisher.publish(pose)
        if self.count == 3:
            self.timer.cancel()


class Robot(Node):
    def __init__(self):
        super().__init__("robot", namespace="/cell")
        self.create_subscription(PoseStamped, "pose", self.move, 10)
        self.create_subscription(String, "/cell/stop", self.stop, 10)
        self.moved = []
        self.lock = threading.Lock()
        self.inside = self.most = 0

    def move(self, pose):
        with self.lock:
            self.inside += 1
            self.most = max(self.most, self.inside)
        time.sleep(0.3)
        self.moved.append(pose.header.frame_id)
        with self.lock:
            self.inside -= 1

    def stop(self, message):
        self.moved.append(message.data)


rclpy.init()
for kind in (MultiThreadedExecutor, SingleThreadedExecutor):
    executor = kind()
    camera, robot = Camera(), Robot()
    print([executor.add_node(node) for node in (camera, robot, camera)])
    print(camera.get_fully_qualified_name(), robot.get_fully_qualified_name(), camera.executor is executor)
    end = time.monotonic() + 2.5
    while time.monotonic() < end and len(robot.moved) < 3:
        executor.spin_once(timeout_sec=0.5)
    print(kind.__name__, robot.moved, "at once", robot.most)
    executor.remove_node(robot)
    print([node.get_name() for node in executor.get_nodes()], robot.executor is executor)
    executor.shutdown()
    camera.destroy_node()
    robot.destroy_node()
rclpy.shutdown()
