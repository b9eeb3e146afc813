"""What the ROS 1 version got from moveit_commander, on top of rclpy.

Kept small on purpose: go(joints), follow(poses), where().
"""
import rclpy
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import Pose
from moveit_msgs.action import ExecuteTrajectory
from moveit_msgs.srv import GetCartesianPath, GetPositionFK
from rclpy.action import ActionClient
from rclpy.duration import Duration
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectoryPoint


class LegacyArm:
    JOINTS = ["joint_1", "joint_2", "joint_3", "joint_4", "joint_5", "joint_6"]
    TIP = "link_6"

    def __init__(self, node, group="manipulator", controller="dsr_moveit_controller"):
        self.node = node
        self.group = group
        self._fjt = ActionClient(node, FollowJointTrajectory,
                                 "/" + controller + "/follow_joint_trajectory")
        self._exec = ActionClient(node, ExecuteTrajectory, "/execute_trajectory")
        self._line = node.create_client(GetCartesianPath, "/compute_cartesian_path")
        self._fk = node.create_client(GetPositionFK, "/compute_fk")
        self._state = None
        node.create_subscription(JointState, "/joint_states", self._on_state, 10)
        self._fjt.wait_for_server()
        self._exec.wait_for_server()

    def _on_state(self, msg):
        self._state = msg

    def _wait(self, future):
        rclpy.spin_until_future_complete(self.node, future)
        return future.result()

    def _act(self, client, goal):
        handle = self._wait(client.send_goal_async(goal))
        if not handle.accepted:
            return None
        return self._wait(handle.get_result_async()).result

    def go(self, joints, seconds):
        goal = FollowJointTrajectory.Goal()
        goal.trajectory.joint_names = self.JOINTS
        goal.trajectory.points.append(JointTrajectoryPoint(
            positions=list(joints), velocities=[0.0] * 6,
            time_from_start=Duration(seconds=seconds).to_msg()))
        result = self._act(self._fjt, goal)
        return result is not None and result.error_code == 0

    def where(self):
        """Pose of the tip, from the newest joint state."""
        self._state = None
        while self._state is None:
            rclpy.spin_once(self.node, timeout_sec=0.1)
        request = GetPositionFK.Request()
        request.fk_link_names = [self.TIP]
        request.robot_state.joint_state = self._state
        return self._wait(self._fk.call_async(request)).pose_stamped[0].pose

    def follow(self, poses, slow=1.0):
        """Along straight lines; slow stretches the time."""
        request = GetCartesianPath.Request()
        request.group_name = self.group
        request.link_name = self.TIP
        request.waypoints = list(poses)
        request.max_step = 0.01
        answer = self._wait(self._line.call_async(request))
        if answer.fraction < 0.999:
            raise RuntimeError("path reachable to %.0f %% only" % (100 * answer.fraction))
        trajectory = answer.solution
        for point in trajectory.joint_trajectory.points:
            t = (point.time_from_start.sec + point.time_from_start.nanosec * 1e-9) * slow
            point.time_from_start = Duration(seconds=t).to_msg()
            point.velocities = [v / slow for v in point.velocities]
            point.accelerations = [a / slow ** 2 for a in point.accelerations]
        goal = ExecuteTrajectory.Goal(trajectory=trajectory)
        result = self._act(self._exec, goal)
        return result is not None and result.error_code.val == 1


def shifted(pose, dx=0.0, dy=0.0, dz=0.0):
    moved = Pose()
    moved.position.x = pose.position.x + dx
    moved.position.y = pose.position.y + dy
    moved.position.z = pose.position.z + dz
    moved.orientation = pose.orientation
    return moved
