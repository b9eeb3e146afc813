"""A LoCoBot's gripper."""

from .._parts import TopicGripper as LoCoBotGripper

__all__ = ["LoCoBotGripper"]
