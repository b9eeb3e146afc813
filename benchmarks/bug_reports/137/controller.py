#!/usr/bin/env python3
"""Run jobs on a UR5e, each with the trajectory controller that it was taught with."""
import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from controller_manager_msgs.srv import SwitchController, SwitchControllerRequest
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = ["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
          "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"]
HOME = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0]
CONTROLLERS = ["scaled_pos_joint_traj_controller", "pos_joint_traj_controller"]
JOBS = [
    ("fetch", "pos_joint_traj_controller", 0.4),
    ("scan", "pos_joint_traj_controller", -0.4),
    ("home", "scaled_pos_joint_traj_controller", 0.0),
]


class Cell:
    def __init__(self):
        rospy.wait_for_service("/controller_manager/switch_controller")
        self.switch = rospy.ServiceProxy(
            "/controller_manager/switch_controller", SwitchController)

    def use(self, controller):
        """Start a controller, and stop all others that could command the arm."""
        request = SwitchControllerRequest()
        request.start_controllers = [controller]
        request.stop_controllers = [name for name in CONTROLLERS if name != controller]
        request.strictness = SwitchControllerRequest.STRICT
        answer = self.switch(request)
        rospy.loginfo("switched to %s: %s", controller, answer.ok)
        if not answer.ok:
            raise RuntimeError("the controllers were not switched to %s" % controller)

    def turn(self, controller, angle):
        client = actionlib.SimpleActionClient(
            "/%s/follow_joint_trajectory" % controller, FollowJointTrajectoryAction)
        if not client.wait_for_server(rospy.Duration(5.0)):
            raise RuntimeError("no action of %s" % controller)
        goal = FollowJointTrajectoryGoal()
        goal.trajectory.joint_names = JOINTS
        goal.trajectory.points = [JointTrajectoryPoint(
            positions=[angle] + HOME[1:], velocities=[0.0] * 6,
            time_from_start=rospy.Duration(3.0))]
        client.send_goal_and_wait(goal)
        return client.get_result().error_code


def main():
    rospy.init_node("ur5e_jobs")
    cell = Cell()
    for name, controller, angle in JOBS:
        cell.use(controller)
        code = cell.turn(controller, angle)
        rospy.loginfo("job %s: error code %d", name, code)
        if code != 0:
            raise RuntimeError("job %s failed" % name)
    rospy.loginfo("all jobs done")


if __name__ == "__main__":
    main()
