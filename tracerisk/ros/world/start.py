"""Where the robot begins in a world."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from types import MappingProxyType

from tracerisk.common.worlds.world import World
from tracerisk.twin.robots.gripper_ends import gripper_ends
from tracerisk.twin.robots.robot import Robot


def started_in(world: World, robot: Robot, given: Collection[str]) -> Robot:
    """Return the robot as it begins in a world; joints that are `given` stay where they are."""
    if not world.decides_start:
        return robot
    moved = dict(robot.initial_state)
    if world.gripper is not None:
        for gripper in robot.grippers:
            position = gripper_ends(robot, gripper).position(world.gripper)
            moved |= {name: gripper.sign(name) * position for name in gripper.joints}
    within = (-world.start_off_rad, world.start_off_rad)
    for joint in robot.arm_joints if world.start_off_rad else ():
        place = moved[joint.name] + world.drawn(within, joint.name)
        if joint.type != "continuous":
            place = min(max(place, joint.lower), joint.upper)
        moved[joint.name] = place
    kept = {name: robot.initial_state[name] for name in given if name in moved}
    return replace(robot, initial_state=MappingProxyType({**moved, **kept}))
