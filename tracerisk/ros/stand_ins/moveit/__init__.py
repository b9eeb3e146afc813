"""Stand-in for MoveItPy, the Python library of MoveIt 2, on the twin."""

from .core import (
    World,
    collision_detection,
    controller_manager,
    kinematic_constraints,
    planning_interface,
    planning_scene,
    robot_model,
    robot_state,
    robot_trajectory,
)
from .planning import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    MoveItPy,
    MultiPipelinePlanRequestParameters,
    PlanningComponent,
    PlanningSceneMonitor,
    PlanRequestParameters,
    TrajectoryExecutionManager,
)
from .utils import get_launch_params_filepaths

__all__ = [
    "LockedPlanningSceneContextManagerRO",
    "LockedPlanningSceneContextManagerRW",
    "MoveItPy",
    "MultiPipelinePlanRequestParameters",
    "PlanRequestParameters",
    "PlanningComponent",
    "PlanningSceneMonitor",
    "TrajectoryExecutionManager",
    "World",
    "collision_detection",
    "controller_manager",
    "get_launch_params_filepaths",
    "kinematic_constraints",
    "planning_interface",
    "planning_scene",
    "robot_model",
    "robot_state",
    "robot_trajectory",
]
