"""A LoCoBot's camera."""

from .._parts import Camera as LoCoBotCamera

__all__ = ["LoCoBotCamera"]
