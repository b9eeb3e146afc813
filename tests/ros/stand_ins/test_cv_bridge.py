"""Images to arrays and back; figures of grey are those of OpenCV's cvtColor."""

import numpy as np
import pytest


@pytest.fixture
def within(run_node):
    def run(check):
        def main():
            import cv_bridge
            from sensor_msgs.msg import Image

            return check(cv_bridge.CvBridge(), cv_bridge.CvBridgeError, Image)

        return run_node(main)

    return run


def test_an_array_survives_the_way_there_and_back(within):
    def check(bridge, error, image):
        for kind in ("uint8", "int8", "uint16", "int16", "int32", "float32", "float64"):
            for shape in ((4, 5), (4, 5, 3)):
                array = np.arange(np.prod(shape)).reshape(shape).astype(kind)
                message = bridge.cv2_to_imgmsg(array)
                back = bridge.imgmsg_to_cv2(message)
                assert back.dtype == kind
                assert np.array_equal(back, array)
                assert message.step * message.height == len(message.data)
        return message.encoding

    assert within(check) == "64FC3"


def test_rows_may_be_padded_and_bytes_swapped(within):
    def check(bridge, error, image):
        message = image(height=2, width=2, step=6, encoding="mono16", is_bigendian=1)
        message.data = bytes([0, 1, 0, 2, 9, 9, 1, 0, 2, 0, 9, 9])
        return bridge.imgmsg_to_cv2(message).tolist()

    assert within(check) == [[1, 2], [256, 512]]


def test_colours_change_their_order_depth_and_number(within):
    def check(bridge, error, image):
        pixel = np.array([[[200, 100, 50]]], np.uint8)
        message = bridge.cv2_to_imgmsg(pixel, "rgb8")
        names = ("rgb8", "bgr8", "rgba8", "mono8", "rgb16", "8UC3", "32FC3")
        return {name: np.squeeze(bridge.imgmsg_to_cv2(message, name)).tolist() for name in names}

    assert within(check) == {
        "rgb8": [200, 100, 50],
        "bgr8": [50, 100, 200],
        "rgba8": [200, 100, 50, 255],
        "mono8": 124,
        "rgb16": [200 * 257, 100 * 257, 50 * 257],
        "8UC3": [200, 100, 50],
        "32FC3": [200.0, 100.0, 50.0],
    }


def test_what_makes_no_sense_is_refused(within):
    def check(bridge, error, image):
        array = np.zeros((2, 2, 3), np.uint8)
        with pytest.raises(error, match="incompatible type 8UC3"):
            bridge.cv2_to_imgmsg(array, "mono8")
        with pytest.raises(error, match="Unrecognized image encoding"):
            bridge.cv2_to_imgmsg(array, "pink8")
        with pytest.raises(error, match="does not make sense"):
            bridge.imgmsg_to_cv2(bridge.cv2_to_imgmsg(array), "bgr8")
        bayer = bridge.cv2_to_imgmsg(array[..., 0], "bayer_rggb8")
        with pytest.raises(error, match="raw pattern"):
            bridge.imgmsg_to_cv2(bayer, "bgr8")
        with pytest.raises(TypeError, match="not a numpy array"):
            bridge.cv2_to_imgmsg([[1]])
        return bridge.encoding_to_cvtype2("bgr8"), bridge.encoding_to_dtype_with_channels("32FC1")

    assert within(check) == (16, ("float32", 1))
