"""Cameras as sensor_msgs/CameraInfo describes them, alone and as a pair.

Pixels are rectified: a point in the frame of the camera is seen where `P` projects it, with the
centre, focal lengths and baseline that are in `P`; binning and the region of interest scale and
shift these. Source: sensor_msgs/CameraInfo; ros-perception/vision_opencv
image_geometry/image_geometry/cameramodels.py.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

Pixel = Sequence[float]
Point = Sequence[float]


class PinholeCameraModel:
    """One camera; its matrices are those of numpy, None before the first message."""

    def __init__(self) -> None:
        self.K: Any = None
        self.D: Any = None
        self.R: Any = None
        self.P: Any = None
        self.full_K: Any = None
        self.full_P: Any = None
        self.width: Any = None
        self.height: Any = None
        self.resolution: Any = None
        self.binning_x: Any = None
        self.binning_y: Any = None
        self.raw_roi: Any = None
        self.tf_frame: Any = None
        self.stamp: Any = None

    def fromCameraInfo(self, msg: Any) -> None:
        """Take what a sensor_msgs/CameraInfo says, of ROS 1 or of ROS 2."""
        intrinsic, distortion = _field(msg, "k"), _field(msg, "d")
        self.full_K = _matrix(intrinsic, (3, 3))
        self.full_P = _matrix(_field(msg, "p"), (3, 4))
        self.R = _matrix(_field(msg, "r"), (3, 3))
        self.D = _matrix(distortion, (len(distortion), 1)) if len(distortion) else None
        self.width, self.height = msg.width, msg.height
        self.resolution = (msg.width, msg.height)
        self.binning_x, self.binning_y = max(1, msg.binning_x), max(1, msg.binning_y)
        self.raw_roi = copy.copy(msg.roi)
        region = self.raw_roi
        if not (region.x_offset or region.y_offset or region.width or region.height):
            region.width, region.height = msg.width, msg.height
        self.tf_frame, self.stamp = msg.header.frame_id, msg.header.stamp
        self.K, self.P = self._seen(self.full_K), self._seen(self.full_P)

    def _seen(self, full: Any) -> Any:
        """Return a matrix of the full picture as one of its region, in binned pixels."""
        made = full.copy()
        for row, offset, binning in (
            (0, self.raw_roi.x_offset, self.binning_x),
            (1, self.raw_roi.y_offset, self.binning_y),
        ):
            made[row, row] /= binning
            made[row, 2] = (made[row, 2] - offset) / binning
        return made

    def rectifyImage(self, raw: Any, rectified: Any) -> None:
        """Write a picture without its distortion into `rectified`."""
        import cv2

        size = (self.width, self.height)
        maps = cv2.initUndistortRectifyMap(self.K, self.D, self.R, self.P, size, cv2.CV_32FC1)
        cv2.remap(raw, *maps, cv2.INTER_CUBIC, rectified)

    def rectifyPoint(self, uv_raw: Pixel) -> Any:
        """Return where a pixel of the raw picture is in the rectified one."""
        import cv2

        given = np.array([[[float(uv_raw[0]), float(uv_raw[1])]]])
        return cv2.undistortPoints(given, self.K, self.D, R=self.R, P=self.P)[0, 0]

    def project3dToPixel(self, point: Point) -> tuple[float, float]:
        """Return the pixel that sees a point; not a number for one beside the camera."""
        across, down, depth = (
            float(row @ np.array([*point[:3], 1.0])) for row in np.asarray(self.P)
        )
        return (across / depth, down / depth) if depth else (math.nan, math.nan)

    def projectPixelTo3dRay(self, uv: Pixel) -> tuple[float, float, float]:
        """Return the direction of length 1 in which a pixel looks."""
        across, down = (uv[0] - self.cx()) / self.fx(), (uv[1] - self.cy()) / self.fy()
        length = math.sqrt(across * across + down * down + 1.0)
        return across / length, down / length, 1.0 / length

    def getDeltaU(self, deltaX: float, Z: float) -> float:
        """Return how many pixels a length across spans at a depth."""
        return self.fx() * deltaX / Z if Z else math.inf

    def getDeltaV(self, deltaY: float, Z: float) -> float:
        """Return how many pixels a length down spans at a depth."""
        return self.fy() * deltaY / Z if Z else math.inf

    def getDeltaX(self, deltaU: float, Z: float) -> float:
        """Return the length that pixels across span at a depth."""
        return Z * deltaU / self.fx()

    def getDeltaY(self, deltaV: float, Z: float) -> float:
        """Return the length that pixels down span at a depth."""
        return Z * deltaV / self.fy()

    def fullResolution(self) -> Any:
        """Return width and height of the full picture."""
        return self.resolution

    def intrinsicMatrix(self) -> Any:
        """Return the matrix of the raw picture."""
        return self.K

    def distortionCoeffs(self) -> Any:
        """Return the distortion, None for none."""
        return self.D

    def rotationMatrix(self) -> Any:
        """Return the turn that rectifies."""
        return self.R

    def projectionMatrix(self) -> Any:
        """Return the matrix that projects points."""
        return self.P

    def fullIntrinsicMatrix(self) -> Any:
        """Return the matrix of the full raw picture."""
        return self.full_K

    def fullProjectionMatrix(self) -> Any:
        """Return the matrix that projects points into the full picture."""
        return self.full_P

    def cx(self) -> float:
        """Return the centre across [pixel]."""
        return float(self.P[0, 2])

    def cy(self) -> float:
        """Return the centre down [pixel]."""
        return float(self.P[1, 2])

    def fx(self) -> float:
        """Return the focal length across [pixel]."""
        return float(self.P[0, 0])

    def fy(self) -> float:
        """Return the focal length down [pixel]."""
        return float(self.P[1, 1])

    def Tx(self) -> float:
        """Return the baseline across, times the focal length."""
        return float(self.P[0, 3])

    def Ty(self) -> float:
        """Return the baseline down, times the focal length."""
        return float(self.P[1, 3])

    def tfFrame(self) -> Any:
        """Return the frame of the camera."""
        return self.tf_frame


class StereoCameraModel:
    """Two cameras side by side; the baseline is in the matrix of the right one."""

    def __init__(self) -> None:
        self.left = PinholeCameraModel()
        self.right = PinholeCameraModel()
        self.Q: Any = None

    def fromCameraInfo(self, left_msg: Any, right_msg: Any) -> None:
        """Take what the messages of both cameras say."""
        self.left.fromCameraInfo(left_msg)
        self.right.fromCameraInfo(right_msg)
        right = self.right
        self.Q = np.array(
            [
                [1.0, 0.0, 0.0, -right.cx()],
                [0.0, 1.0, 0.0, -right.cy()],
                [0.0, 0.0, 0.0, right.fx()],
                [0.0, 0.0, -right.fx() / right.Tx(), 0.0],
            ]
        )

    def tfFrame(self) -> Any:
        """Return the frame of the points: that of the left camera."""
        return self.left.tfFrame()

    def project3dToPixel(self, point: Point) -> tuple[tuple[float, float], tuple[float, float]]:
        """Return the pixels of both cameras that see a point."""
        return self.left.project3dToPixel(point), self.right.project3dToPixel(point)

    def projectPixelTo3d(self, left_uv: Pixel, disparity: float) -> tuple[float, float, float]:
        """Return the point that a pixel of the left camera sees with a disparity [pixel]."""
        given = np.array([left_uv[0], left_uv[1], disparity, 1.0])
        x, y, z, scale = map(float, self.Q @ given)
        return (x / scale, y / scale, z / scale) if scale else (0.0, 0.0, 0.0)

    def getZ(self, disparity: float) -> float:
        """Return the depth of a point that is seen with a disparity [pixel]."""
        return -self.right.Tx() / disparity if disparity else math.inf

    def getDisparity(self, Z: float) -> float:
        """Return the disparity with which a point at a depth is seen [pixel]."""
        return -self.right.Tx() / Z if Z else math.inf


def _field(message: Any, name: str) -> Any:
    """Return a field that ROS 1 writes with a capital letter."""
    return getattr(message, name) if hasattr(message, name) else getattr(message, name.upper())


def _matrix(values: Sequence[float], shape: tuple[int, int]) -> Any:
    return np.asmatrix(np.array(values, dtype=float).reshape(shape))
