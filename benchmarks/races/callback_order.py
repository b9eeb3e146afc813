"""Believes that the mode of the cell comes before the part: both are sent at the same time.

Source: introlab/rtabmap_ros issue 1205, ros2/rclcpp issue 2532.
"""

import rospy
from std_msgs.msg import Float64, String
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

JOINTS = [f"panda_joint{number}" for number in range(1, 8)]


class Cell:
    def __init__(self):
        self.mode = "idle"
        self.todo = []
        self.publisher = rospy.Publisher(
            "/position_joint_trajectory_controller/command", JointTrajectory, queue_size=1
        )
        rospy.Subscriber("/mode", String, self.on_mode)
        rospy.Subscriber("/part", Float64, self.on_part)

    def on_mode(self, message):
        self.mode = message.data

    def on_part(self, message):
        if self.mode == "work":
            self.todo.append(message.data)

    def move(self, turn):
        command = JointTrajectory(joint_names=JOINTS)
        positions = [turn, -0.8, 0.0, -2.3, 0.0, 1.6, 0.8]
        command.points = [
            JointTrajectoryPoint(positions=positions, time_from_start=rospy.Duration(3.0))
        ]
        self.publisher.publish(command)
        rospy.sleep(4.0)


def main():
    rospy.init_node("callback_order")
    cell = Cell()
    rospy.sleep(4.0)
    for turn in (0.3, *cell.todo):
        cell.move(turn)


if __name__ == "__main__":
    main()
