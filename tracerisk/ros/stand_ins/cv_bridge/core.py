"""Messages of images to numpy arrays and back."""

from __future__ import annotations

import sys
from array import array
from typing import Any

import numpy as np
from sensor_msgs.msg import CompressedImage, Image

from tracerisk.ros.messages.dialect import is_ros2

from ._encodings import DEPTHS, changed, layout

_NAMES = list(DEPTHS)


class CvBridgeError(TypeError):
    """An image cannot be converted."""


class CvBridge:
    """Converts images; arrays are (height, width) or (height, width, channels)."""

    def __init__(self) -> None:
        self.cvtype_to_name = {
            number + ((channels - 1) << 3): f"{name}C{channels}"
            for number, name in enumerate(_NAMES)
            for channels in (1, 2, 3, 4)
        }
        self.cvdepth_to_numpy_depth = dict(enumerate(DEPTHS.values()))
        self.numpy_type_to_cvtype = {kind: name for name, kind in DEPTHS.items()} | DEPTHS

    def dtype_with_channels_to_cvtype2(self, dtype: Any, n_channels: int) -> str:
        """Return the name of a type: `8UC3`."""
        return f"{self.numpy_type_to_cvtype[np.dtype(dtype).name]}C{n_channels}"

    def cvtype2_to_dtype_with_channels(self, cvtype: int) -> tuple[str, int]:
        """Return numpy type and channels of one of OpenCV's type numbers."""
        return self.cvdepth_to_numpy_depth[cvtype & 7], (cvtype >> 3) + 1

    def encoding_to_cvtype2(self, encoding: str) -> int:
        """Return OpenCV's type number of an encoding.

        Raises:
            CvBridgeError: there is no such encoding.
        """
        try:
            depth, channels = layout(encoding)
        except ValueError as error:
            raise CvBridgeError(str(error)) from error
        return _NAMES.index(depth) + ((channels - 1) << 3)

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return numpy type and channels of an encoding.

        Raises:
            CvBridgeError: there is no such encoding.
        """
        return self.cvtype2_to_dtype_with_channels(self.encoding_to_cvtype2(encoding))

    def imgmsg_to_cv2(self, img_msg: Any, desired_encoding: str = "passthrough") -> Any:
        """Return the array of an Image, in another encoding if asked for.

        Raises:
            CvBridgeError: there is no such encoding, or no way from the one to the other.
            TypeError: the message holds too little data.
        """
        name, channels = self.encoding_to_dtype_with_channels(img_msg.encoding)
        kind = np.dtype(name).newbyteorder(">" if img_msg.is_bigendian else "<")
        data = bytes(img_msg.data)
        # Rows may be longer than what they hold; the real one counts them in whole pixels too.
        columns = img_msg.step // kind.itemsize // channels
        shape: Any = (img_msg.height, columns, channels)[: 2 if channels == 1 else 3]
        pixel = kind.itemsize * channels
        strides = (img_msg.step, pixel, kind.itemsize)[: len(shape)]
        image: Any = np.ndarray(shape, kind, buffer=data, strides=strides)
        image = np.ascontiguousarray(image[:, : img_msg.width]).astype(name)
        if desired_encoding == "passthrough":
            return image
        return _changed(image, img_msg.encoding, desired_encoding)

    def cv2_to_imgmsg(self, cvim: Any, encoding: str = "passthrough", header: Any = None) -> Any:
        """Return the Image of an array.

        Raises:
            TypeError: it is not an array.
            CvBridgeError: the array's type is not that of the encoding.
        """
        if not isinstance(cvim, np.ndarray | np.generic):
            raise TypeError("Your input type is not a numpy array")
        cvim = np.asarray(cvim)
        channels = 1 if cvim.ndim < 3 else cvim.shape[2]
        kind = self.dtype_with_channels_to_cvtype2(cvim.dtype, channels)
        message = Image()
        message.height, message.width = cvim.shape[0], cvim.shape[1]
        if header is not None:
            message.header = header
        message.encoding = kind if encoding == "passthrough" else encoding
        if self.cvtype_to_name[self.encoding_to_cvtype2(message.encoding)] != kind:
            raise CvBridgeError(
                f"encoding specified as {encoding}, but image has incompatible type {kind}"
            )
        order = cvim.dtype.byteorder
        is_big = order == ">" or (order == "=" and sys.byteorder == "big")
        message.is_bigendian = type(message.is_bigendian)(is_big)
        message.data = _bytes(cvim.tobytes())
        message.step = len(message.data) // message.height
        return message

    def compressed_imgmsg_to_cv2(
        self, cmprs_img_msg: Any, desired_encoding: str = "passthrough"
    ) -> Any:
        """Return the array of a CompressedImage; OpenCV (`cv2`) must be installed.

        Raises:
            CvBridgeError: there is no such encoding, or no way to it from bgr8.
        """
        import cv2

        packed = np.frombuffer(bytes(cmprs_img_msg.data), dtype=np.uint8)
        image = cv2.imdecode(packed, cv2.IMREAD_UNCHANGED)
        if desired_encoding == "passthrough":
            return image
        return _changed(image, "bgr8", desired_encoding)

    def cv2_to_compressed_imgmsg(self, cvim: Any, dst_format: str = "jpg") -> Any:
        """Return the CompressedImage of an array; OpenCV (`cv2`) must be installed.

        Raises:
            TypeError: it is not an array.
        """
        import cv2

        if not isinstance(cvim, np.ndarray | np.generic):
            raise TypeError("Your input type is not a numpy array")
        message = CompressedImage()
        message.format = dst_format
        message.data = _bytes(cv2.imencode("." + dst_format, cvim)[1].tobytes())
        return message


def _changed(image: Any, begin: str, end: str) -> Any:
    try:
        return changed(image, begin, end)
    except ValueError as error:
        raise CvBridgeError(str(error)) from error


def _bytes(data: bytes) -> Any:
    # Of ROS 2 an array of numbers, of ROS 1 bytes.
    return array("B", data) if is_ros2(Image) else data
