"""A LoCoBot's arm."""

from .._arm import Arm as LoCoBotArm

__all__ = ["LoCoBotArm"]
