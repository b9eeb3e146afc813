#!/usr/bin/env python3
import collections
import math

import rospy
from interbotix_xs_modules.arm import InterbotixManipulatorXS
from std_msgs.msg import String
from std_srvs.srv import Trigger

"""
Sort the cubes of a belt by colour, WidowX 250 S.

The eye looks at the cube in front and publishes its colour; what it does not know goes to the bin "other".
"""

BELT_X = [0.20, 0.28, 0.36]
GRIP_Z = 0.028
LIFT = 0.09
PITCH = math.pi / 2 - 0.1


class ColourSorter(InterbotixManipulatorXS):

    def __init__(self):
        InterbotixManipulatorXS.__init__(self, robot_model="wx250s", group_name="arm", gripper_name="gripper",
                                         moving_time=1.2, accel_time=0.3, gripper_pressure=0.6)
        self.bins = rospy.get_param("/sorter/bins")
        self.count = collections.Counter()
        self.tally = rospy.Publisher("/sorter/tally", String, queue_size=10)
        self.advance = rospy.ServiceProxy("/belt/advance", Trigger)

    def look(self):
        """Colour of the cube in front, from the eye."""
        return rospy.wait_for_message("/eye/colour", String, timeout=5.0).data

    def bin_of(self, colour):
        if colour not in self.bins:
            rospy.logwarn("unknown colour %s" % colour)
            colour = "other"
        return self.bins[colour]

    def hover(self, x, y, time=None):
        self.arm.set_ee_pose_components(x=x, y=y, z=GRIP_Z + LIFT, pitch=PITCH, moving_time=time)

    def lower(self):
        self.arm.set_ee_cartesian_trajectory(z=-LIFT, moving_time=1.2)

    def raise_(self):
        self.arm.set_ee_cartesian_trajectory(z=LIFT, moving_time=1.2)

    def take(self, x, y=0.0):
        self.gripper.open()
        self.hover(x, y)
        self.lower()
        self.gripper.close()
        self.raise_()

    def drop(self, x, y):
        self.hover(x, y, time=1.6)
        self.lower()
        self.gripper.open()
        self.raise_()

    def sort_next(self, x):
        colour = self.look()
        place = self.bin_of(colour)
        self.take(x)
        self.drop(*place)
        self.count[colour] += 1
        self.tally.publish(String("%s=%d" % (colour, self.count[colour])))

    def shift(self):
        self.arm.go_to_home_pose(moving_time=1.5)
        for i, x in enumerate(BELT_X):
            self.sort_next(x)
            if i + 1 < len(BELT_X):
                self.advance()
        self.arm.go_to_sleep_pose(moving_time=2.0)
        return sum(self.count.values())


if __name__ == "__main__":
    sorter = ColourSorter()
    total = sorter.shift()
    rospy.loginfo("%d cubes: %s", total, dict(sorter.count))
