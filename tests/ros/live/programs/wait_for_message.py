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


def look():
    state = rospy.wait_for_message("/joint_states", JointState, timeout=5.0)
    return dict(zip(state.name, state.position))


def move(client, angle):
    client.send_goal_and_wait(goal_to(turned(angle), 1.0))


def main():
    rospy.init_node("wait_for_message")
    client = actionlib.SimpleActionClient(ACTION, FollowJointTrajectoryAction)
    client.wait_for_server()
    before = look()
    print("> joints", sorted(before)[:3], len(before))
    move(client, 0.25)
    print("> turned", round(look()["panda_joint1"], 2))
    try:
        rospy.wait_for_message("/nobody", JointState, timeout=0.5)
    except rospy.ROSException as error:
        print("> timeout", error)


if __name__ == "__main__":
    main()
