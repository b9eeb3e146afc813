# ruff: noqa: F401 - all names of the library, also for `import *`
"""Stand-in for PyKDL: vectors, frames, chains of joints and their solvers."""

from ._chain import Chain, Joint, Segment, Tree
from ._frames import Frame, FrameVel, Rotation, addDelta, diff, dot
from ._joints import *  # noqa: F403 - each name of it
from ._solvers import *  # noqa: F403 - each name of it
from ._values import Twist, Vector, Wrench
