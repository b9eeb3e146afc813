#!/usr/bin/env python3
"""A UR5e polishes between two corners: each leg is planned first, then looked at, then driven."""
import sys

import moveit_commander
import rospy

HOME = {"shoulder_pan_joint": 0.0, "shoulder_lift_joint": -1.57, "elbow_joint": 1.57,
        "wrist_1_joint": -1.57, "wrist_2_joint": -1.57, "wrist_3_joint": 0.0}
CORNERS = [
    ("left", {"shoulder_pan_joint": 0.5, "shoulder_lift_joint": -1.3}),
    ("right", {"shoulder_pan_joint": -0.5, "shoulder_lift_joint": -1.3}),
    ("left", {"shoulder_pan_joint": 0.5, "shoulder_lift_joint": -1.3}),
]
LONGEST = 20.0      # [s], a leg that takes longer is not driven


class Polisher:
    def __init__(self):
        self.robot = moveit_commander.RobotCommander()
        self.arm = moveit_commander.MoveGroupCommander("manipulator")
        self.arm.set_max_velocity_scaling_factor(0.4)
        self.arm.set_max_acceleration_scaling_factor(0.4)
        self.driven = 0

    def go_home(self):
        self.arm.set_joint_value_target(HOME)
        if not self.arm.go(wait=True):
            raise RuntimeError("home was not reached")
        self.arm.stop()
        # the legs are to begin at home, whatever the planner thinks of the last state
        self.arm.set_start_state(self.robot.get_current_state())

    def leg(self, name, change):
        """Plan to a corner; the trajectory and how long it takes."""
        target = dict(HOME)
        target.update(change)
        self.arm.set_joint_value_target(target)
        result, trajectory, seconds, code = self.arm.plan()
        if not result:
            raise RuntimeError("no way to %s: code %d" % (name, code.val))
        points = trajectory.joint_trajectory.points
        length = points[-1].time_from_start.to_sec()
        rospy.loginfo("leg to %s: %d points, %.1f s, planned in %.2f s",
                      name, len(points), length, seconds)
        return trajectory, length

    def drive(self, name, trajectory):
        done = self.arm.execute(trajectory, wait=True)
        self.arm.stop()
        rospy.loginfo("leg to %s driven: %s", name, done)
        if not done:
            raise RuntimeError("the leg to %s was not driven" % name)
        self.driven += 1


def main():
    moveit_commander.roscpp_initialize(sys.argv)
    rospy.init_node("polish_corners")
    polisher = Polisher()
    polisher.go_home()
    for name, change in CORNERS:
        trajectory, length = polisher.leg(name, change)
        if length > LONGEST:
            rospy.logwarn("the leg to %s is too long, left out", name)
            continue
        polisher.drive(name, trajectory)
    rospy.loginfo("polished, %d legs", polisher.driven)


if __name__ == "__main__":
    main()
