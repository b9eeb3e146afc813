"""Set points on a topic, joint states that come back, and services of its own."""

import threading

import rclpy
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
OUT = [0.4, *HOME[1:]]


class Cell(Node):
    def __init__(self):
        super().__init__("cell")
        self.at = {}
        self.texts = []
        self.commands = self.create_publisher(
            JointTrajectory, "/panda_arm_controller/joint_trajectory", 10
        )
        self.create_subscription(JointState, "/joint_states", self.heard, 10)
        self.words = self.create_publisher(String, "~/words", 10)
        self.create_subscription(String, "~/words", lambda text: self.texts.append(text.data), 10)
        self.create_service(SetBool, "~/switch", self.switch)
        self.client = self.create_client(SetBool, "~/switch")

    def heard(self, message):
        self.at = dict(zip(message.name, message.position, strict=True))

    def switch(self, request, response):
        response.success, response.message = request.data, "on" if request.data else "off"
        return response

    def wait(self, seconds):
        clock = self.get_clock()
        clock.sleep_for(rclpy.duration.Duration(seconds=seconds))

    def swing(self, positions):
        message = JointTrajectory(joint_names=JOINTS)
        point = JointTrajectoryPoint(positions=positions)
        point.time_from_start.sec = 1
        message.points.append(point)
        self.commands.publish(message)
        self.wait(1.5)

    def reach(self):
        self.swing(OUT)
        print("> reached", round(self.at["panda_joint1"], 2))

    def back(self):
        self.swing(HOME)
        print("> back", abs(round(self.at["panda_joint1"], 2)))


def main():
    rclpy.init()
    cell = Cell()
    executor = MultiThreadedExecutor(4)
    executor.add_node(cell)
    threading.Thread(target=executor.spin, daemon=True).start()
    print("> service", cell.client.wait_for_service(timeout_sec=10.0))
    print("> switched", cell.client.call(SetBool.Request(data=True)).message)
    while cell.commands.get_subscription_count() == 0 or not cell.at:
        cell.wait(0.05)
    cell.words.publish(String(data="hello"))
    cell.reach()
    cell.back()
    print("> texts", cell.texts)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
