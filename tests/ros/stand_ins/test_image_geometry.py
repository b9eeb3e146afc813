"""What pixels of calibrated cameras see, by the mathematics of sensor_msgs/CameraInfo."""

import math

import pytest


def info(kind, focal=500.0, centre=(320.0, 240.0), baseline=0.0, **fields):
    """Return the message of a camera whose matrices have these figures [pixel, m]."""
    matrices = {
        "k": [focal, 0.0, centre[0], 0.0, focal, centre[1], 0.0, 0.0, 1.0],
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [focal, 0, centre[0], -focal * baseline, 0, focal, centre[1], 0, 0, 0, 1, 0],
    }
    message = kind(width=640, height=480)
    message.header.frame_id = "camera"
    for name, values in matrices.items():
        name = name if hasattr(message, name) else name.upper()
        setattr(message, name, [float(each) for each in values])
    for name, value in fields.items():
        setattr(message, name, value)
    return message


@pytest.fixture(params=["1", "2"])
def run_either(request, run_node, run_ros2):
    return run_node if request.param == "1" else run_ros2


def test_a_point_and_the_ray_of_its_pixel_agree(run_either):
    def main():
        from image_geometry import PinholeCameraModel
        from sensor_msgs.msg import CameraInfo

        camera = PinholeCameraModel()
        camera.fromCameraInfo(info(CameraInfo))
        point = (0.2, -0.1, 0.5)
        pixel = camera.project3dToPixel(point)
        ray = camera.projectPixelTo3dRay(pixel)
        at_depth = [each * point[2] / ray[2] for each in ray]
        beside = camera.project3dToPixel((1.0, 1.0, 0.0))
        return (
            pixel,
            at_depth,
            math.hypot(*ray),
            beside,
            camera.tfFrame(),
            camera.getDeltaX(50, 0.5),
        )

    pixel, at_depth, length, beside, frame, span = run_either(main)
    assert pixel == pytest.approx((520.0, 140.0))
    assert at_depth == pytest.approx([0.2, -0.1, 0.5])
    assert length == pytest.approx(1.0)
    assert all(map(math.isnan, beside))
    assert (frame, span) == ("camera", pytest.approx(0.05))


def test_binning_and_a_region_move_the_centre(run_either):
    def main():
        from image_geometry import PinholeCameraModel
        from sensor_msgs.msg import CameraInfo, RegionOfInterest

        region = RegionOfInterest(x_offset=100, y_offset=40, width=200, height=200)
        camera = PinholeCameraModel()
        camera.fromCameraInfo(info(CameraInfo, binning_x=2, binning_y=2, roi=region))
        whole = camera.fullProjectionMatrix()
        return (camera.fx(), camera.cx(), camera.cy()), whole[0, 2], camera.fullResolution()

    assert run_either(main) == ((250.0, 110.0, 100.0), 320.0, (640, 480))


def test_a_pair_finds_the_depth_of_a_point(run_either):
    def main():
        from image_geometry import StereoCameraModel
        from sensor_msgs.msg import CameraInfo

        pair = StereoCameraModel()
        pair.fromCameraInfo(info(CameraInfo), info(CameraInfo, baseline=0.1))
        point = (0.05, 0.02, 0.8)
        left, right = pair.project3dToPixel(point)
        disparity = left[0] - right[0]
        found = pair.projectPixelTo3d(left, disparity)
        return found, pair.getZ(disparity), pair.getDisparity(0.8) - disparity, pair.getZ(0)

    found, depth, difference, infinite = run_either(main)
    assert found == pytest.approx((0.05, 0.02, 0.8))
    assert depth == pytest.approx(0.8)
    assert difference == pytest.approx(0.0)
    assert infinite == math.inf
