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


def main():
    rospy.init_node("replaced_goal")
    client = actionlib.ActionClient(ACTION, FollowJointTrajectoryAction)
    client.wait_for_server()
    changes = []

    def changed(name):
        return lambda handle: changes.append((name, handle.get_comm_state()))

    first = client.send_goal(goal_to(turned(0.8), 2.0), changed("first"))
    rospy.sleep(0.6)
    second = client.send_goal(goal_to(HOME, 1.02), changed("second"))
    while second.get_comm_state() != actionlib.CommState.DONE:
        rospy.sleep(0.05)
    print("> first", first.get_terminal_state(), "second", second.get_terminal_state())
    print("> order", [c for c in changes if c[1] == actionlib.CommState.DONE])


if __name__ == "__main__":
    main()
