"""Planning and execution: MoveItPy and what it hands out."""

from ._moveit_py import MoveItPy
from ._parameters import MultiPipelinePlanRequestParameters, PlanRequestParameters
from ._planning_component import PlanningComponent
from ._scene_monitor import (
    LockedPlanningSceneContextManagerRO,
    LockedPlanningSceneContextManagerRW,
    PlanningSceneMonitor,
)
from ._trajectory_execution_manager import TrajectoryExecutionManager

__all__ = [
    "LockedPlanningSceneContextManagerRO",
    "LockedPlanningSceneContextManagerRW",
    "MoveItPy",
    "MultiPipelinePlanRequestParameters",
    "PlanRequestParameters",
    "PlanningComponent",
    "PlanningSceneMonitor",
    "TrajectoryExecutionManager",
]
