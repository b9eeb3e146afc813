"""Maker Faire demo: a WidowX 250 S sorts toy bricks by colour.

pip-free, one file, ROS 2 + interbotix_xs_modules. The colour sensor sits under the show position.
"""
from math import pi

from interbotix_common_modules.common_robot.robot import robot_shutdown, robot_startup
from interbotix_xs_modules.xs_robot.arm import InterbotixManipulatorXS
from std_msgs.msg import ColorRGBA, Int32
from std_srvs.srv import Trigger

BRICKS = [(0.28, -0.10), (0.28, 0.00), (0.28, 0.10)]
SHOW = dict(x=0.24, y=0.0, z=0.22)
BINS = {
    "red": [(0.10, 0.28), (0.18, 0.28)],
    "blue": [(0.10, -0.28), (0.18, -0.28)],
}
GRAB_Z = 0.032
HOVER_Z = 0.12
DOWN = pi / 2


class Eye:
    """The newest reading of the colour sensor."""

    def __init__(self, node):
        self.reading = None
        node.create_subscription(ColorRGBA, "/colour_sensor/colour", self._on_colour, 10)

    def _on_colour(self, msg):
        self.reading = (msg.r, msg.g, msg.b)

    @property
    def colour(self):
        r, g, b = self.reading
        return "red" if r > b else "blue"


def hop(arm, x, y, z, t=1.2):
    arm.set_ee_pose_components(x=x, y=y, z=z, pitch=DOWN, moving_time=t, accel_time=0.4)


def grab(bot, x, y):
    bot.gripper.release()
    hop(bot.arm, x, y, HOVER_Z)
    hop(bot.arm, x, y, GRAB_Z, t=0.9)
    bot.gripper.grasp()
    hop(bot.arm, x, y, HOVER_Z, t=0.9)


def drop(bot, x, y):
    hop(bot.arm, x, y, HOVER_Z, t=1.6)
    hop(bot.arm, x, y, GRAB_Z + 0.002, t=0.9)
    bot.gripper.release()
    hop(bot.arm, x, y, HOVER_Z, t=0.9)


def main():
    bot = InterbotixManipulatorXS(robot_model="wx250s", group_name="arm", gripper_name="gripper",
                                  gripper_pressure=0.8)
    node = bot.core.robot_node
    eye = Eye(node)
    flash = node.create_client(Trigger, "/lamp/flash")
    score = node.create_publisher(Int32, "/scoreboard/red", 10)
    robot_startup()

    used = {name: 0 for name in BINS}
    bot.arm.go_to_home_pose(moving_time=1.5, accel_time=0.5)
    for x, y in BRICKS:
        grab(bot, x, y)
        hop(bot.arm, **SHOW)
        node.wait_until_future_complete(flash.call_async(Trigger.Request()))
        colour = eye.colour
        slot = BINS[colour][used[colour]]
        used[colour] += 1
        drop(bot, *slot)
        if colour == "red":
            score.publish(Int32(data=used["red"]))
    bot.arm.go_to_home_pose(moving_time=1.5, accel_time=0.5)
    bot.arm.go_to_sleep_pose(moving_time=1.5, accel_time=0.5)
    robot_shutdown()


if __name__ == "__main__":
    main()
