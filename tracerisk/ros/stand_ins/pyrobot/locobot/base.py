"""A LoCoBot's base."""

from .._parts import Base as LoCoBotBase

__all__ = ["LoCoBotBase"]
