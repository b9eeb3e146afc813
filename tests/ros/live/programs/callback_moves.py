import threading

import actionlib
import rospy
from control_msgs.msg import FollowJointTrajectoryAction, FollowJointTrajectoryGoal
from trajectory_msgs.msg import JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]
ACTION = "/arm_controller/follow_joint_trajectory"


def goal_to(positions, seconds):
    goal = FollowJointTrajectoryGoal()
    goal.trajectory.joint_names = JOINTS
    goal.trajectory.points = [
        JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(seconds))
    ]
    return goal


def turned(angle):
    return [angle, *HOME[1:]]


from sensor_msgs.msg import JointState
from std_msgs.msg import Float64


class Node:
    def __init__(self):
        self.client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
        self.client.wait_for_server()
        self.state = None
        self.home = threading.Event()
        rospy.Subscriber("/joint_states", JointState, self.look)
        rospy.Subscriber("/wanted", Float64, self.go)

    def look(self, message):
        self.state = message

    def go(self, message):
        self.client.send_goal_and_wait(goal_to(turned(message.data), 1.0))
        where = dict(zip(self.state.name, self.state.position))
        print("> at", round(where["panda_joint1"], 2) + 0.0, self.client.get_state())
        if message.data == 0.0:
            self.home.set()


def main():
    rospy.init_node("callback_moves")
    node = Node()
    publisher = rospy.Publisher("/wanted", Float64, queue_size=10)
    rospy.sleep(0.5)
    publisher.publish(0.3)
    publisher.publish(0.0)
    node.home.wait()
    print("> over")


if __name__ == "__main__":
    main()
