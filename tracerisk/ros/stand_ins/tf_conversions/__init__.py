# ruff: noqa: F401 - what is imported here is what the module gives
"""Stand-in for tf_conversions: frames of PyKDL as messages, matrices and transforms of tf."""

from tracerisk.ros.imports.exported import exported as _exported

from . import posemath, transformations
from .posemath import fromCameraParams, fromMatrix, fromMsg, fromTf, toMatrix, toMsg, toTf

__all__ = _exported(globals(), "posemath", "transformations")
