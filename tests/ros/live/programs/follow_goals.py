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


def reach(client):
    client.send_goal(goal_to(turned(0.4), 1.5))
    print("> waited", client.wait_for_result(), client.get_state())
    print("> result", client.get_result().error_code)


def back(client):
    state = client.send_goal_and_wait(goal_to(HOME, 1.0))
    print("> state", state, client.get_goal_status_text())


def main():
    rospy.init_node("follow_goals")
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    print("> server", client.wait_for_server())
    reach(client)
    rospy.sleep(0.5)
    back(client)


if __name__ == "__main__":
    main()
