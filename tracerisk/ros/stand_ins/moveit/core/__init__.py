"""The core of MoveIt: models, states, scenes, trajectories."""

from . import (
    collision_detection,
    controller_manager,
    kinematic_constraints,
    planning_interface,
    planning_scene,
    robot_model,
    robot_state,
    robot_trajectory,
)
from ._world import World

__all__ = [
    "World",
    "collision_detection",
    "controller_manager",
    "kinematic_constraints",
    "planning_interface",
    "planning_scene",
    "robot_model",
    "robot_state",
    "robot_trajectory",
]
