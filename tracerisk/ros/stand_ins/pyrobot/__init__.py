"""Stand-in for pyrobot (ROS 1): LoCoBot, Sawyer and UR5 behind one interface.

The library's own nodes plan and solve; here MoveIt's stand-in does both for the twin's arm. The
joints are the twin's, in the order of the library's. A base stands still, and a camera sees
nothing.
"""

from .core import Robot

__all__ = ["Robot"]
