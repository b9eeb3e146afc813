"""Stand-in for cv_bridge: images as messages and as numpy arrays."""

from .core import CvBridge, CvBridgeError

__all__ = ["CvBridge", "CvBridgeError"]
