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


def start_and_cancel(client):
    client.send_goal(goal_to(turned(1.0), 2.0))
    print("> in time", client.wait_for_result(rospy.Duration(0.8)))
    client.cancel_goal()
    print("> ended", client.wait_for_result(rospy.Duration(5.0)), client.get_state())


def give_up(client):
    state = client.send_goal_and_wait(
        goal_to(HOME, 3.0), execute_timeout=rospy.Duration(0.5), preempt_timeout=rospy.Duration(2.0)
    )
    print("> state", state)


def main():
    rospy.init_node("preempt")
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    client.wait_for_server()
    start_and_cancel(client)
    give_up(client)
    client.cancel_all_goals()
    print("> last", client.get_state())


if __name__ == "__main__":
    main()
