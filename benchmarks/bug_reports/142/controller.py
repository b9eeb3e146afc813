#!/usr/bin/env python3
"""Baxter's left arm carries a cup from the tray to the dispenser; a move that takes too long is an error."""
import baxter_interface
import rospy

JOINTS = ["left_s0", "left_s1", "left_e0", "left_e1", "left_w0", "left_w1", "left_w2"]
TRAY = dict(zip(JOINTS, [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0]))
DISPENSER = dict(zip(JOINTS, [-1.1, -0.35, 0.0, 1.15, 0.0, 0.9, 0.0]))
PATIENCE = 1.0      # [s] for a move at the pace of the line
SPEED = 0.6


class Carrier:
    def __init__(self):
        baxter_interface.RobotEnable().enable()
        self.limb = baxter_interface.Limb("left")
        self.limb.set_joint_position_speed(SPEED)
        self.gripper = baxter_interface.Gripper("left")
        self.late = 0

    def off(self, pose):
        """By how much the worst joint is off."""
        now = self.limb.joint_angles()
        return max(abs(now[name] - pose[name]) for name in pose)

    def go(self, name, pose, patience=15.0):
        """Raises OSError if the arm is not there in time."""
        self.limb.move_to_joint_positions(pose, timeout=patience)
        rospy.loginfo("%s: %.3f rad off", name, self.off(pose))

    def carry(self):
        self.go("tray", TRAY)
        self.gripper.close(block=True)
        try:
            self.go("dispenser", DISPENSER, PATIENCE)
        except OSError as error:
            self.late += 1
            rospy.logwarn("late, once more without a limit: %s", error)
            self.go("dispenser", DISPENSER)
        self.gripper.open(block=True)
        rospy.loginfo("the cup is under the dispenser")

    def retreat(self):
        self.go("tray", TRAY)
        if self.off(TRAY) > 0.05:
            rospy.logwarn("the arm does not rest at the tray")


def main():
    rospy.init_node("cup_carrier")
    carrier = Carrier()
    if not carrier.gripper.calibrated():
        carrier.gripper.calibrate()
    carrier.gripper.open(block=True)
    carrier.carry()
    carrier.retreat()
    rospy.loginfo("carried, late moves: %d", carrier.late)


if __name__ == "__main__":
    main()
