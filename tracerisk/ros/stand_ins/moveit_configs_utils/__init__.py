"""Stand-in for moveit_configs_utils: the parameters of a robot's MoveIt package."""

from .moveit_configs_builder import MoveItConfigs, MoveItConfigsBuilder

__all__ = ["MoveItConfigs", "MoveItConfigsBuilder"]
