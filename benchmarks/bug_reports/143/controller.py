#!/usr/bin/env python3
"""Baxter's right arm is nudged towards a pose without waiting, to see that it is free, and then goes there."""
import baxter_interface
import rospy

JOINTS = ["right_s0", "right_s1", "right_e0", "right_e1", "right_w0", "right_w1", "right_w2"]
BEGIN = dict(zip(JOINTS, [0.0, -0.55, 0.0, 0.75, 0.0, 1.26, 0.0]))
BENCH = dict(zip(JOINTS, [0.9, -0.45, 0.0, 0.95, 0.0, 1.1, 0.0]))
NUDGE = 0.10        # more than this part of the way is no nudge


class Arm:
    def __init__(self, side):
        baxter_interface.RobotEnable().enable()
        self.limb = baxter_interface.Limb(side)
        self.limb.set_joint_position_speed(0.4)

    def off(self, pose):
        now = self.limb.joint_angles()
        return max(abs(now[name] - pose[name]) for name in pose)

    def go(self, pose):
        self.limb.move_to_joint_positions(pose)
        off = self.off(pose)
        if off > 0.02:
            raise RuntimeError("the arm is %.3f rad off" % off)
        return off

    def nudge(self, pose):
        """One filtered command towards the pose, no waiting; how much of the way it was."""
        before = self.limb.joint_angles()
        start = rospy.get_time()
        self.limb.move_to_joint_positions(pose, timeout=0.0)
        took = rospy.get_time() - start
        rospy.sleep(1.0)
        after = self.limb.joint_angles()
        name = "right_s0"
        share = (after[name] - before[name]) / (pose[name] - before[name])
        rospy.loginfo("nudged in %.2f s, %.1f %% of the way", took, 100.0 * share)
        return share


def main():
    rospy.init_node("nudge_and_go")
    arm = Arm("right")
    arm.go(BEGIN)
    rospy.loginfo("at the beginning")

    share = arm.nudge(BENCH)
    if share > NUDGE:
        raise RuntimeError("the arm went further than a nudge")
    if share <= 0.0:
        raise RuntimeError("the arm did not move at all")

    off = arm.go(BENCH)
    rospy.loginfo("at the bench, %.3f rad off", off)
    arm.go(BEGIN)
    rospy.loginfo("done")


if __name__ == "__main__":
    main()
