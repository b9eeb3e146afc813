#!/usr/bin/env python3
"""Feed raw parts from a tray into a milling machine with a Franka Research 3 (ROS 2).

The arm is driven through the FollowJointTrajectory action of its joint trajectory controller, the
hand through the GripperCommand action of the gripper node.
"""

import rclpy
from action_msgs.msg import GoalStatus
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory, GripperCommand
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"fr3_joint{i}" for i in range(1, 8)]

HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
ABOVE_TRAY = [0.62, -0.21, 0.0, -2.28, 0.0, 2.07, 1.41]
AT_TRAY = [0.62, 0.03, 0.0, -2.31, 0.0, 2.34, 1.41]
IN_FRONT_OF_MACHINE = [-0.71, 0.02, 0.0, -1.88, 0.0, 1.90, 0.08]
IN_CHUCK = [-0.71, 0.31, 0.0, -1.62, 0.0, 1.93, 0.08]

# Distance of one finger from the middle of the hand [m].
OPEN = 0.04
CLOSED = 0.0
GRIP_FORCE = 15.0


class MachineTending(Node):
    """Brings one part after the other from the tray to the chuck of the machine."""

    def __init__(self):
        super().__init__("machine_tending")
        self.parts = self.declare_parameter("parts", 2).value
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/fr3_arm_controller/follow_joint_trajectory"
        )
        self.gripper = ActionClient(self, GripperCommand, "/fr3_gripper/gripper_action")
        self.get_logger().info("waiting for the action servers")
        self.arm.wait_for_server()
        self.gripper.wait_for_server()

    def run(self):
        """Load every part, then park the arm."""
        self.go_home()
        for number in range(1, self.parts + 1):
            self.fetch_part()
            self.load_machine()
            self.get_logger().info(f"part {number} of {self.parts} is in the machine")
        self.go_home()

    def go_home(self):
        """Open the hand and go where the machine's door can close."""
        self.set_gripper(OPEN)
        self.follow([(HOME, 2.0)])

    def fetch_part(self):
        """Take a raw part out of the tray."""
        self.follow([(ABOVE_TRAY, 2.0), (AT_TRAY, 3.0)])
        self.set_gripper(CLOSED)
        self.follow([(ABOVE_TRAY, 1.0)])

    def load_machine(self):
        """Put the part into the chuck and leave the machine."""
        self.follow([(IN_FRONT_OF_MACHINE, 2.5), (IN_CHUCK, 3.5)])
        self.set_gripper(OPEN)
        self.follow([(IN_FRONT_OF_MACHINE, 1.0)])

    def follow(self, waypoints):
        """Follow waypoints, pairs of joint positions [rad] and the time to be there [s]."""
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        for positions, seconds in waypoints:
            point = JointTrajectoryPoint()
            point.positions = positions
            point.velocities = [0.0] * len(JOINTS)
            point.time_from_start = Duration(
                sec=int(seconds), nanosec=int((seconds - int(seconds)) * 1e9)
            )
            goal.trajectory.points.append(point)
        result = self.send(self.arm, goal)
        if result.error_code != FollowJointTrajectory.Result.SUCCESSFUL:
            raise RuntimeError(f"the arm did not follow its trajectory: {result.error_string}")

    def set_gripper(self, position):
        """Move the fingers; they may stop early on a part."""
        goal = GripperCommand.Goal()
        goal.command.position = position
        goal.command.max_effort = GRIP_FORCE
        result = self.send(self.gripper, goal)
        if not (result.reached_goal or result.stalled):
            raise RuntimeError(f"the fingers stand at {result.position:.3f} m")

    def send(self, client, goal):
        """Send a goal and wait for its result."""
        sent = client.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        handle = sent.result()
        if not handle.accepted:
            raise RuntimeError("the goal was rejected")
        finished = handle.get_result_async()
        rclpy.spin_until_future_complete(self, finished)
        response = finished.result()
        if response.status != GoalStatus.STATUS_SUCCEEDED:
            self.get_logger().warning(f"the goal ended with status {response.status}")
        return response.result


def main(args=None):
    rclpy.init(args=args)
    node = MachineTending()
    try:
        node.run()
    except KeyboardInterrupt:
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
