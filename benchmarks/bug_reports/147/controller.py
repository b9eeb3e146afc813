#!/usr/bin/env python3
"""A ViperX 300 S shakes a bottle with a few quick, small moves, and then puts it aside slowly."""
from interbotix_common_modules.common_robot.robot import robot_shutdown, robot_startup
from interbotix_xs_modules.xs_robot.arm import InterbotixManipulatorXS

#        waist, shoulder, elbow, forearm roll, wrist angle, wrist rotate
HOME = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
SHAKE = 0.2         # [rad] of the wrist
SHAKES = 3
QUICK = 0.4         # [s]
SLOW = 4.0          # [s]
ASIDE = [1.8, 0.0, 0.0, 0.0, 0.0, 0.0]


class Shaker:
    def __init__(self):
        self.bot = InterbotixManipulatorXS(
            robot_model="vx300s", group_name="arm", gripper_name="gripper")

    def log(self, text):
        self.bot.core.get_node().loginfo(text)

    def take(self):
        self.bot.arm.go_to_home_pose(moving_time=3.0)
        self.bot.gripper.release()
        self.bot.gripper.grasp()
        self.log("the bottle is in the gripper")

    def shake(self):
        for number in range(SHAKES):
            for angle in (SHAKE, 0.0):
                wrist = list(HOME)
                wrist[4] = angle
                done = self.bot.arm.set_joint_positions(
                    wrist, moving_time=QUICK, accel_time=0.1)
                self.log(f"shake {number + 1} to {angle:.1f}: {done}")

    def waist(self):
        state = self.bot.core.joint_states
        return dict(zip(state.name, state.position))["waist"]

    def put_aside(self):
        """Slowly, for the bottle is open: 1.8 rad in 4 s."""
        done = self.bot.arm.set_joint_positions(ASIDE, moving_time=SLOW, accel_time=0.5)
        self.log(f"aside: {done}, waist at {self.waist():.2f} rad")
        self.bot.gripper.release()
        self.log("the bottle is let go")

    def rest(self):
        self.bot.arm.go_to_home_pose(moving_time=3.0)
        self.bot.arm.go_to_sleep_pose(moving_time=3.0)


def main():
    shaker = Shaker()
    robot_startup()
    shaker.take()
    shaker.shake()
    shaker.put_aside()
    shaker.rest()
    robot_shutdown()
    print("done")


if __name__ == "__main__":
    main()
