#!/usr/bin/env python3
"""A ViperX 300 S swings to the side and closes its gripper during the same two seconds.

Neither command waits; the program waits itself, once for both.
"""
import sys
import time

from interbotix_common_modules.common_robot.robot import robot_shutdown, robot_startup
from interbotix_xs_modules.xs_robot.arm import InterbotixManipulatorXS

SECONDS = 2.0
#        waist, shoulder, elbow, forearm roll, wrist angle, wrist rotate
HOME = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
SIDE = [0.8, -0.2, 0.2, 0.0, 0.3, 0.0]
NEAR = 0.05         # [rad]


class Swing:
    def __init__(self):
        self.bot = InterbotixManipulatorXS(
            robot_model="vx300s", group_name="arm", gripper_name="gripper")

    def log(self, text):
        self.bot.core.get_node().loginfo(text)

    def prepare(self):
        self.bot.arm.go_to_home_pose(moving_time=3.0)
        self.bot.gripper.release(delay=1.5)
        self.log(f"open: fingers at {self.bot.gripper.get_finger_position():.3f} m")

    def both(self, positions):
        """Move the arm and close the gripper at the same time; the time that it took."""
        begin = time.time()
        accepted = self.bot.arm.set_joint_positions(
            positions, moving_time=SECONDS, accel_time=0.3, blocking=False)
        self.bot.gripper.grasp(delay=0.0)
        sent = time.time() - begin
        if not accepted:
            raise RuntimeError("the arm does not go there")
        self.log(f"both commands sent after {sent:.2f} s")
        time.sleep(SECONDS + 0.5 - sent)
        return time.time() - begin

    def off(self, positions):
        names = self.bot.arm.group_info.joint_names
        state = self.bot.core.joint_states
        where = dict(zip(state.name, state.position))
        return max(abs(where[name] - p) for name, p in zip(names, positions))


def main():
    swing = Swing()
    robot_startup()
    swing.prepare()
    took = swing.both(SIDE)
    off = swing.off(SIDE)
    fingers = swing.bot.gripper.get_finger_position()
    swing.log(f"after {took:.1f} s: arm {off:.3f} rad off, fingers at {fingers:.3f} m")
    swing.bot.arm.go_to_home_pose(moving_time=3.0)
    swing.bot.gripper.release(delay=1.0)
    swing.bot.arm.go_to_sleep_pose(moving_time=3.0)
    robot_shutdown()
    if off > NEAR:
        sys.exit("the arm was not at the side in time")
    print("both moved at once")


if __name__ == "__main__":
    main()
