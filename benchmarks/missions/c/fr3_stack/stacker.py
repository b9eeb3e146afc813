#!/usr/bin/env python3
"""Stack two cubes on the plinth as the recipe says; everything runs from one 25 Hz timer (FR3, ROS 2)."""
import pathlib
from enum import Enum, auto

import rclpy
import yaml
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionClient
from rclpy.node import Node
from std_msgs.msg import Float32, Int32, Int32MultiArray
from std_srvs.srv import SetBool
from trajectory_msgs.msg import JointTrajectoryPoint


class Phase(Enum):
    NEXT = auto()
    SENT = auto()
    RUNNING = auto()
    CALLING = auto()
    DONE = auto()
    FAULT = auto()


class Stacker(Node):
    JOINTS = ["fr3_joint%d" % n for n in range(1, 8)]

    def __init__(self, recipe):
        super().__init__("stacker")
        self.recipe = recipe
        self.pc = 0
        self.phase = Phase.NEXT
        self.pending = None
        self.layers = 0
        self.arm = ActionClient(self, FollowJointTrajectory, "fr3_arm_controller/follow_joint_trajectory")
        self.hand = ActionClient(self, GripperCommand, "fr3_gripper/gripper_action")
        self.pallet = self.create_client(SetBool, "/pallet/clamp")
        self.layer_pub = self.create_publisher(Int32MultiArray, "/stack/layer", 10)
        self.press_pub = self.create_publisher(Float32, "/press/force", 10)
        self.done_pub = self.create_publisher(Int32, "/stack/done", 10)
        self.verbs = {
            "move": self.do_move,
            "fingers": self.do_fingers,
            "report": self.do_report,
            "press": self.do_press,
            "release_pallet": self.do_release,
        }
        for client in (self.arm, self.hand):
            client.wait_for_server()
        self.pallet.wait_for_service()
        self.pending = self.pallet.call_async(SetBool.Request(data=True))
        self.phase = Phase.CALLING
        self.create_timer(0.04, self.tick)

    # one state each tick
    def tick(self):
        if self.phase is Phase.NEXT:
            if self.pc == len(self.recipe["cycle"]):
                self.done_pub.publish(Int32(data=self.layers))
                self.phase = Phase.DONE
                return
            verb, *rest = self.recipe["cycle"][self.pc]
            self.pc += 1
            self.verbs[verb](*rest)
        elif self.phase is Phase.SENT and self.pending.done():
            handle = self.pending.result()
            if not handle.accepted:
                self.fault("goal refused at step %d" % self.pc)
                return
            self.pending = handle.get_result_async()
            self.phase = Phase.RUNNING
        elif self.phase is Phase.RUNNING and self.pending.done():
            self.phase = Phase.NEXT
        elif self.phase is Phase.CALLING and self.pending.done():
            if self.pending.result().success:
                self.phase = Phase.NEXT
            else:
                self.fault("pallet clamp")

    def fault(self, text):
        self.get_logger().error(text)
        self.phase = Phase.FAULT

    def do_move(self, name, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = self.JOINTS
        point = JointTrajectoryPoint(positions=self.recipe["poses"][name], velocities=[0.0] * 7)
        point.time_from_start = Duration(sec=int(seconds), nanosec=round(seconds % 1 * 1e9))
        goal.trajectory.points = [point]
        self.pending = self.arm.send_goal_async(goal)
        self.phase = Phase.SENT

    def do_fingers(self, name):
        goal = GripperCommand.Goal()
        goal.command.position = self.recipe["fingers"][name]
        goal.command.max_effort = 15.0
        self.pending = self.hand.send_goal_async(goal)
        self.phase = Phase.SENT

    def do_report(self, layer, height_mm):
        self.layers += 1
        self.layer_pub.publish(Int32MultiArray(data=[layer, height_mm]))

    def do_press(self, newton):
        self.press_pub.publish(Float32(data=float(newton)))

    def do_release(self):
        self.pending = self.pallet.call_async(SetBool.Request(data=False))
        self.phase = Phase.CALLING


def main():
    rclpy.init()
    path = pathlib.Path(__file__).with_name("recipe.yaml")
    node = Stacker(yaml.safe_load(path.read_text()))
    while rclpy.ok() and node.phase not in (Phase.DONE, Phase.FAULT):
        rclpy.spin_once(node, timeout_sec=0.5)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
