"""Pull a peg out and set it back with a Panda (ROS 1, the actions of its gripper)."""

import sys

import actionlib
import moveit_commander
import rospy
from franka_gripper.msg import GraspAction, GraspEpsilon, GraspGoal, MoveAction, MoveGoal
from geometry_msgs.msg import Pose

PEG = (0.45, 0.15)
OVER, AT = 0.40, 0.1934  # of panda_link8


class PegPulling:
    def __init__(self):
        self.arm = moveit_commander.MoveGroupCommander("panda_arm")
        self.opener = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self.grasper = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        self.opener.wait_for_server()
        self.grasper.wait_for_server()

    def open(self):
        self.opener.send_goal(MoveGoal(width=0.07, speed=0.05))
        self.opener.wait_for_result()

    def grasp(self):
        goal = GraspGoal(width=0.03, speed=0.05, force=20.0)
        goal.epsilon = GraspEpsilon(inner=0.005, outer=0.005)
        self.grasper.send_goal(goal)
        self.grasper.wait_for_result()
        return self.grasper.get_result().success

    def reach(self, height):
        pose = Pose()
        pose.position.x = PEG[0]
        pose.position.y = PEG[1]
        pose.position.z = height
        pose.orientation.x = 0.9238795
        pose.orientation.y = -0.3826834
        self.arm.set_pose_target(pose)
        if not self.arm.go(wait=True):
            raise RuntimeError("not reached")

    def pull(self):
        self.open()
        self.reach(OVER)
        self.reach(AT)
        if not self.grasp():
            rospy.logwarn("there is no peg")
            return False
        self.reach(OVER)
        return True

    def set_back(self):
        self.reach(AT + 0.002)
        self.open()
        self.reach(OVER)


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("peg_pulling")
    node = PegPulling()
    if node.pull():
        node.set_back()
    node.arm.set_named_target("ready")
    node.arm.go(wait=True)


if __name__ == "__main__":
    main()
