"""Bring the arm onto a scale whenever the scale is ready (ROS 1, services)."""

import moveit_commander
import rospy
from std_srvs.srv import SetBool, Trigger

POSTURES = {
    "beside": [0.6, 0.2, 1.0, 0.9, 0.0, 0.1],
    "on": [0.6, 0.45, 1.05, 0.7, 0.0, 0.1],
    "home": [0.0, 0.0, 1.0, 0.6, 0.0, 0.0],
}


class Weighing:
    def __init__(self):
        rospy.wait_for_service("/scale/tare")
        self.tare = rospy.ServiceProxy("/scale/tare", Trigger)
        self.lock = rospy.ServiceProxy("/scale/lock", SetBool)
        self.arm = moveit_commander.MoveGroupCommander("arm")

    def go(self, name):
        self.arm.set_joint_value_target(POSTURES[name])
        if not self.arm.go(wait=True):
            raise RuntimeError("could not go " + name)

    def weigh(self):
        answer = self.tare()
        if not answer.success:
            rospy.logwarn("the scale is not ready: %s", answer.message)
            return False
        self.go("beside")
        self.lock(True)
        self.go("on")
        rospy.sleep(1.0)
        self.go("beside")
        self.lock(False)
        return True


def main():
    rospy.init_node("weighing")
    weighing = Weighing()
    weighing.go("home")
    if weighing.weigh():
        rospy.loginfo("weighed")
    weighing.go("home")


if __name__ == "__main__":
    main()
