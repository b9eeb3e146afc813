"""An empty world, for a scene of its own."""

from __future__ import annotations


class World:
    """The objects of a scene before there are any."""
