"""Stand-in for tf_conversions: frames of PyKDL as messages, matrices and transforms of tf."""

from . import posemath, transformations
from .posemath import fromCameraParams, fromMatrix, fromMsg, fromTf, toMatrix, toMsg, toTf

__all__ = [
    "fromCameraParams",
    "fromMatrix",
    "fromMsg",
    "fromTf",
    "posemath",
    "toMatrix",
    "toMsg",
    "toTf",
    "transformations",
]
