#!/usr/bin/env python3
"""A Panda takes a part of unknown width out of a holder: it closes the hand as far as it goes, and lifts."""
import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
AT_PART = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
LIFTED = [0.0, -0.9, 0.0, -2.3, 0.0, 1.4, 0.785]
CLOSED = 0.0        # [m] of each finger
FORCE = 20.0        # [N]


class Taker(Node):
    def __init__(self):
        super().__init__("part_taker")
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory")
        self.hand = ActionClient(
            self, GripperCommand, "/panda_hand_controller/gripper_cmd")

    def run(self, client, goal):
        client.wait_for_server()
        sent = client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            raise RuntimeError("the goal was rejected")
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result()

    def move(self, name, positions):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=Duration(sec=3))]
        answer = self.run(self.arm, goal)
        self.get_logger().info(f"{name}: error code {answer.result.error_code}")

    def close(self):
        """True if the hand holds something: it closed as told."""
        goal = GripperCommand.Goal()
        goal.command.position = CLOSED
        goal.command.max_effort = FORCE
        answer = self.run(self.hand, goal)
        self.get_logger().info(
            f"hand: status {answer.status}, at {answer.result.position:.3f} m, "
            f"stalled {answer.result.stalled}, goal reached {answer.result.reached_goal}")
        return answer.status == GoalStatus.STATUS_SUCCEEDED


def main():
    rclpy.init()
    node = Taker()
    node.move("at the part", AT_PART)
    if not node.close():
        raise RuntimeError("the hand did not take the part")
    node.move("lifted", LIFTED)
    node.get_logger().info("the part is out of its holder")
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
