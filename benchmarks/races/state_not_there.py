"""Uses the joint state that a callback keeps before the first one has arrived.

Source: moveit/moveit issue 1540, ycheng517/lerobot-ros issue 1.
"""

import rospy
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


class Nudge:
    def __init__(self):
        self.here = dict.fromkeys(JOINTS, 0.0)
        self.publisher = rospy.Publisher(
            "/position_joint_trajectory_controller/command",
            JointTrajectory,
            queue_size=1,
            latch=True,
        )
        rospy.Subscriber("/joint_states", JointState, self.on_state)
        rospy.sleep(0.1)

    def on_state(self, message):
        self.here.update(zip(message.name, message.position, strict=True))

    def turn(self, angle):
        command = JointTrajectory(joint_names=JOINTS)
        goal = [self.here[name] for name in JOINTS]
        goal[0] += angle
        goal[3] = min(goal[3], -0.2)
        command.points = [JointTrajectoryPoint(positions=goal, time_from_start=rospy.Duration(4.0))]
        self.publisher.publish(command)
        rospy.sleep(5.0)


def main():
    rospy.init_node("state_not_there")
    Nudge().turn(0.5)


if __name__ == "__main__":
    main()
