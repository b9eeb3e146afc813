#!/usr/bin/env python3
"""Jogs the tool of a UR10e upwards by MoveIt Servo (ROS 2 Humble, UR driver)."""
import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from controller_manager_msgs.srv import SwitchController
from geometry_msgs.msg import TwistStamped
from rclpy.action import ActionClient
from rclpy.node import Node
from std_srvs.srv import Trigger
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
BENT = [0.0, -1.3, 1.7, -1.97, -1.57, 0.0]


class Jog(Node):
    def __init__(self):
        super().__init__("ur10e_jog")
        self.arm = ActionClient(
            self, FollowJointTrajectory,
            "/scaled_joint_trajectory_controller/follow_joint_trajectory")
        self.switch = self.create_client(
            SwitchController, "/controller_manager/switch_controller")
        self.start = self.create_client(Trigger, "/servo_node/start_servo")
        self.twist = self.create_publisher(TwistStamped, "/servo_node/delta_twist_cmds", 10)
        self.left = 150

    def wait(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()

    def bend(self):
        self.arm.wait_for_server()
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=BENT, time_from_start=Duration(sec=5)))
        handle = self.wait(self.arm.send_goal_async(goal))
        self.wait(handle.get_result_async())

    def prepare(self):
        self.switch.wait_for_service()
        request = SwitchController.Request(strictness=SwitchController.Request.STRICT)
        request.activate_controllers = ["forward_position_controller"]
        request.deactivate_controllers = ["scaled_joint_trajectory_controller"]
        if not self.wait(self.switch.call_async(request)).ok:
            raise RuntimeError("not switched")
        self.start.wait_for_service()
        if not self.wait(self.start.call_async(Trigger.Request())).success:
            raise RuntimeError("servo was not started")

    def jog(self):
        self.timer = self.create_timer(0.02, self.on_timer)
        while rclpy.ok() and self.left > 0:
            rclpy.spin_once(self)
        self.get_logger().info("jogged")

    def on_timer(self):
        self.left -= 1
        message = TwistStamped()
        message.header.stamp = self.get_clock().now().to_msg()
        message.header.frame_id = "base_link"
        message.twist.linear.z = 0.2 if self.left > 10 else 0.0
        self.twist.publish(message)


def main():
    rclpy.init()
    node = Jog()
    node.bend()
    node.prepare()
    node.jog()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
