"""Mark the point that a detector shows in tf, with a six-axis arm (ROS 2, tf)."""

import rclpy
from builtin_interfaces.msg import Duration
from control_msgs.action import FollowJointTrajectory
from moveit_msgs.srv import GetPositionIK
from rclpy.action import ActionClient
from rclpy.node import Node
from tf2_ros import Buffer, TransformException, TransformListener
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["axis_1", "axis_2", "axis_3", "axis_4", "axis_5", "axis_6"]
HOME = [0.0, 0.2, 1.2, 1.2, 0.0, 0.2]


class Marking(Node):
    def __init__(self):
        super().__init__("marking")
        self.buffer = Buffer()
        self.listener = TransformListener(self.buffer, self)
        self.solver = self.create_client(GetPositionIK, "/compute_ik")
        self.arm = ActionClient(
            self, FollowJointTrajectory, "/arm_controller/follow_joint_trajectory"
        )
        self.solver.wait_for_service()
        self.arm.wait_for_server()

    def find(self):
        for _ in range(20):
            rclpy.spin_once(self, timeout_sec=0.1)
            if self.buffer.can_transform("base", "spot", rclpy.time.Time()):
                break
        try:
            return self.buffer.lookup_transform("base", "spot", rclpy.time.Time()).transform
        except TransformException as error:
            self.get_logger().error(f"no spot: {error}")
            return None

    def solve(self, spot, above):
        request = GetPositionIK.Request()
        request.ik_request.group_name = "arm"
        request.ik_request.ik_link_name = "tip"
        request.ik_request.pose_stamped.header.frame_id = "base"
        pose = request.ik_request.pose_stamped.pose
        pose.position.x = spot.translation.x
        pose.position.y = spot.translation.y
        pose.position.z = spot.translation.z + above
        pose.orientation = spot.rotation
        answer = self.solver.call_async(request)
        rclpy.spin_until_future_complete(self, answer)
        if answer.result().error_code.val != 1:
            self.get_logger().warning("out of reach")
            return None
        state = answer.result().solution.joint_state
        result = dict(zip(state.name, state.position, strict=True))
        return [result[name] for name in JOINTS]

    def drive(self, posture, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = JOINTS
        point = JointTrajectoryPoint(positions=posture)
        point.time_from_start = Duration(sec=seconds)
        goal.trajectory.points = [point]
        sent = self.arm.send_goal_async(goal)
        rclpy.spin_until_future_complete(self, sent)
        if not sent.result().accepted:
            return False
        done = sent.result().get_result_async()
        rclpy.spin_until_future_complete(self, done)
        return done.result().result.error_code == 0

    def mark(self):
        spot = self.find()
        if spot is None:
            return False
        for above in (0.08, 0.01, 0.08):
            posture = self.solve(spot, above)
            if posture is None:
                return False
            if not self.drive(posture, 2):
                return False
        return True


def main():
    rclpy.init()
    node = Marking()
    node.drive(HOME, 2)
    if node.mark():
        node.get_logger().info("marked")
    node.drive(HOME, 2)
    rclpy.shutdown()


if __name__ == "__main__":
    main()
