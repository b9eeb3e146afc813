import rospy
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
HOME = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]


class Streamer:
    def __init__(self):
        self.topic = rospy.Publisher("/arm_controller/command", JointTrajectory, queue_size=10)
        while self.topic.get_num_connections() == 0:
            rospy.sleep(0.05)

    def send(self, angle, seconds):
        message = JointTrajectory(joint_names=JOINTS)
        message.header.stamp = rospy.Time(0)
        point = JointTrajectoryPoint(positions=[angle, *HOME[1:]])
        point.time_from_start = rospy.Duration(seconds)
        message.points = [point]
        self.topic.publish(message)


def swing(streamer):
    streamer.send(0.3, 1.0)
    rospy.sleep(1.5)


def ramp(streamer):
    rate = rospy.Rate(20)
    for step in range(20):
        streamer.send(0.3 - 0.015 * step, 0.05)
        rate.sleep()


def main():
    rospy.init_node("set_points")
    streamer = Streamer()
    swing(streamer)
    ramp(streamer)
    rospy.sleep(0.5)
    print("> connections", streamer.topic.get_num_connections())


if __name__ == "__main__":
    main()
