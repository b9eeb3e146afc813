"""The Franka hand, as this cell uses it."""
import actionlib
import rospy
from franka_gripper.msg import GraspAction, GraspEpsilon, GraspGoal, MoveAction, MoveGoal

VIAL = 0.024  # diameter [m]


class Hand(object):
    OPEN = 0.06
    TIMEOUT = rospy.Duration(5.0)

    def __init__(self):
        self._move = actionlib.SimpleActionClient("/franka_gripper/move", MoveAction)
        self._grasp = actionlib.SimpleActionClient("/franka_gripper/grasp", GraspAction)
        self._move.wait_for_server()
        self._grasp.wait_for_server()

    def open(self):
        self._move.send_goal_and_wait(MoveGoal(width=self.OPEN, speed=0.1), self.TIMEOUT)

    def grasp(self, width=VIAL):
        goal = GraspGoal(width=width, speed=0.05, force=20.0)
        goal.epsilon = GraspEpsilon(inner=0.005, outer=0.005)
        self._grasp.send_goal(goal)
        if not self._grasp.wait_for_result(self.TIMEOUT):
            self._grasp.cancel_goal()
            return False
        return self._grasp.get_result().success
