"""A timer sends goals, whose callbacks go on: feedback, response, result, and a cancel."""

import rclpy
from control_msgs.action import FollowJointTrajectory
from rclpy.action import ActionClient
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


class Steps(Node):
    def __init__(self):
        super().__init__("steps")
        self.limit = self.declare_parameter("limit", 2).value
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/panda_arm_controller/follow_joint_trajectory"
        )
        self.done = False
        self.n_sent = self.n_fed_back = self.n_cancelled = 0
        self.arm.wait_for_server()
        self.timer = self.create_timer(0.5, self.begin)

    def begin(self):
        self.timer.cancel()
        self.send(0.3)

    def send(self, angle, seconds=1):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint(positions=[angle, *HOME[1:]])
        point.time_from_start.sec = seconds
        goal.trajectory.points.append(point)
        self.n_sent += 1
        self.arm.send_goal_async(goal, feedback_callback=self.fed_back).add_done_callback(
            self.answered
        )

    def fed_back(self, message):
        self.n_fed_back += 1
        assert list(message.feedback.joint_names) == JOINTS

    def answered(self, future):
        handle = future.result()
        print("> accepted", handle.accepted)
        handle.get_result_async().add_done_callback(self.finished)
        if self.n_sent > self.limit:
            self.stop = self.create_timer(0.5, lambda: self.cancel(handle))

    def cancel(self, handle):
        self.stop.cancel()
        handle.cancel_goal_async().add_done_callback(self.cancelled)

    def cancelled(self, future):
        # It comes with the result, before it or after.
        self.n_cancelled = len(future.result().goals_canceling)

    def finished(self, future):
        print("> status", future.result().status)
        if self.n_sent < self.limit:
            self.send(0.0)
        elif self.n_sent == self.limit:
            self.send(0.4, seconds=3)
        else:
            self.done = True


def main():
    rclpy.init()
    node = Steps()
    while not node.done or (node.n_sent > node.limit and not node.n_cancelled):
        rclpy.spin_once(node)
    print("> sent", node.n_sent, node.n_fed_back > 10, node.n_cancelled)
    node.destroy_node()
    rclpy.shutdown()


if __name__ == "__main__":
    main()
