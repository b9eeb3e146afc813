"""Stand-in for image_geometry: what a pixel of a calibrated camera sees."""

from .cameramodels import PinholeCameraModel, StereoCameraModel

__all__ = ["PinholeCameraModel", "StereoCameraModel"]
