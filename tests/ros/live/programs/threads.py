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


import queue
import threading


class Worker(threading.Thread):
    def __init__(self, client, orders, done):
        super().__init__()
        self.client = client
        self.orders = orders
        self.finished = done

    def run(self):
        while True:
            angle = self.orders.get()
            if angle is None:
                return
            self.carry_out(angle)

    def carry_out(self, angle):
        self.client.send_goal_and_wait(goal_to(turned(angle), 0.8))
        self.finished.append((angle, self.client.get_state()))


def main():
    rospy.init_node("threads")
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    client.wait_for_server()
    orders, done = queue.Queue(), []
    worker = Worker(client, orders, done)
    worker.start()
    for angle in (0.2, 0.0, None):
        orders.put(angle)
    worker.join()
    print("> done", done)


if __name__ == "__main__":
    main()
