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


class Watcher:
    def __init__(self):
        self.heard = 0
        self.names = None
        self.events = []

    def feedback(self, feedback):
        self.heard += 1
        self.names = feedback.joint_names

    def active(self):
        self.events.append("active")

    def done(self, state, result):
        self.events.append(f"done {state} {result.error_code}")


def move(client, watcher):
    client.send_goal(
        goal_to(turned(0.3), 1.0),
        done_cb=watcher.done,
        active_cb=watcher.active,
        feedback_cb=watcher.feedback,
    )
    client.wait_for_result()


def main():
    rospy.init_node("feedback")
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    client.wait_for_server()
    watcher = Watcher()
    move(client, watcher)
    print("> events", watcher.events)
    print("> names", watcher.names == JOINTS, watcher.heard > 10)


if __name__ == "__main__":
    main()
