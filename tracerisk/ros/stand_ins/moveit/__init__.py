"""Stand-in for MoveItPy, the Python library of MoveIt 2, on the twin."""

from . import core as _core
from . import planning as _planning
from .core import *  # noqa: F403 - each name of it
from .planning import *  # noqa: F403 - each name of it
from .utils import get_launch_params_filepaths

__all__ = [*_core.__all__, *_planning.__all__, "get_launch_params_filepaths"]
