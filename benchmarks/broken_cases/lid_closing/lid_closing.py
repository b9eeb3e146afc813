"""Press lids onto two boxes with a Panda (ROS 2, MoveItPy)."""

import rclpy
from geometry_msgs.msg import PoseStamped
from moveit.planning import MoveItPy
from rclpy.logging import get_logger

BOXES = {"first": (0.45, 0.2), "second": (0.45, -0.2)}
OVER, ON = 0.5, 0.35


class LidClosing:
    def __init__(self):
        self.moveit = MoveItPy(node_name="lid_closing")
        self.arm = self.moveit.get_planning_component("panda_arm")
        self.hand = self.moveit.get_planning_component("hand")
        self.log = get_logger("lid_closing")

    def press(self, name):
        x, y = BOXES[name]
        self.reach(x, y, OVER)
        self.reach(x, y, ON)
        self.reach(x, y, OVER)

    def reach(self, x, y, z):
        goal = PoseStamped()
        goal.header.frame_id = "panda_link0"
        goal.pose.position.x = x
        goal.pose.position.y = y
        goal.pose.position.z = z
        goal.pose.orientation.x = 0.9238795
        goal.pose.orientation.y = -0.3826834
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(pose_stamped_msg=goal, pose_link="panda_link8")
        self.follow(self.arm)

    def follow(self, component):
        planned = component.plan()
        if not planned:
            self.log.error("no plan")
            return
        self.moveit.execute(planned.trajectory, controllers=[])

    def fist(self):
        self.hand.set_start_state_to_current_state()
        self.hand.set_goal_state(configuration_name="close")
        self.follow(self.hand)

    def park(self):
        self.arm.set_start_state_to_current_state()
        self.arm.set_goal_state(configuration_name="ready")
        self.follow(self.arm)


def main():
    rclpy.init()
    closing = LidClosing()
    closing.fist()
    for name in BOXES:
        closing.press(name)
    closing.park()


if __name__ == "__main__":
    main()
