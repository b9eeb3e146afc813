"""Which part goes where."""

import rospy

from part_sorting.arm import Arm
from part_sorting.msg import Part


class Sorter:
    """Takes parts off the belt and drops each into the bin of its colour."""

    def __init__(self, robot_name, bins):
        self.arm = Arm(robot_name)
        self.bins = {Part.RED: bins["red"], Part.BLUE: bins["blue"]}
        self.sorted = rospy.Publisher("~sorted", Part, queue_size=10)

    def sort(self, part):
        self.take(part)
        self.drop(part)
        part.header.stamp = rospy.Time.now()
        self.sorted.publish(part)

    def take(self, part):
        """Take a part off the belt."""
        self.arm.open_hand()
        self.arm.carry_to(part.bearing)
        self.arm.reach_down(part.bearing)
        self.arm.close_hand()
        self.arm.carry_to(part.bearing, seconds=1.5)

    def drop(self, part):
        """Drop it into its bin."""
        self.arm.carry_to(self.bins[part.colour])
        self.arm.open_hand()

    def park(self):
        """Fold the arm in front of its base."""
        self.arm.close_hand()
        self.arm.carry_to(0.0)
