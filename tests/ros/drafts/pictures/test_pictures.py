"""Pictures that a scenario describes are drawn as it says."""

import sys
from types import ModuleType

import pytest

from tracerisk.errors import Location, ScenarioError
from tracerisk.ros.drafts.pictures import drafted_pictures
from tracerisk.ros.drafts.pictures.seen_in_pictures import takes_pixels
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2
from tracerisk.ros.scenario.file.scenario_reader import read_scenario
from tracerisk.ros.scenario.message import MessageTemplate
from tracerisk.twin.motion.kinematics import Kinematics
from tracerisk.twin.robots.robot import load_robot

ENTRY = "publish:\n  - topic: /image\n    type: sensor_msgs/Image\n    message: {}\n"


@pytest.fixture
def opencv(monkeypatch):
    """OpenCV, as far as markers are drawn with it."""
    aruco = ModuleType("cv2.aruco")
    aruco.DICT_4X4_50 = 0
    dictionary = ModuleType("dictionary")
    dictionary.bytesList = range(50)
    aruco.getPredefinedDictionary = lambda number: dictionary
    aruco.generateImageMarker = lambda words, number, side: [[number] * side] * side
    cv2 = ModuleType("cv2")
    cv2.aruco = aruco
    monkeypatch.setitem(sys.modules, "cv2", cv2)


@pytest.fixture(scope="module")
def values():
    robot = load_robot("panda")
    kinematics = Kinematics(robot)
    return UsableValues(robot, kinematics.forward, kinematics.inverse)


@pytest.fixture
def image(tmp_path):
    def made(message):
        path = tmp_path / "s.yaml"
        path.write_text(ENTRY.format(message))
        (written,) = read_scenario(path).published[0].messages
        return MessageTemplate(Interfaces().message("sensor_msgs/Image"), written).make(0)

    return made


def pixel(image, x, y):
    channels = image.step // image.width
    at = y * image.step + x * channels
    return tuple(image.data[at : at + channels])


def test_a_disc_of_a_colour_is_drawn_in_the_order_of_the_encoding(image):
    disc = "discs: [{color: [10, 20, 30], at: [3, 2], radius: 1}]"
    drawn = image(f"{{picture: {{size: [8, 6], fill: 99, {disc}}}}}")
    assert (drawn.width, drawn.height, drawn.encoding) == (8, 6, "bgr8")
    where = [(x, y) for x in range(8) for y in range(6) if pixel(drawn, x, y) == (30, 20, 10)]
    assert where == [(2, 2), (3, 1), (3, 2), (3, 3), (4, 2)]
    assert pixel(drawn, 0, 0) == (99, 99, 99)
    assert pixel(image(f"{{picture: {{encoding: mono8, {disc}}}}}"), 3, 2) == (20,)


def test_a_marker_has_a_white_border(image, opencv):
    marker = "{dictionary: DICT_4X4_50, id: 7, at: [10, 10], side: 12}"
    drawn = image(f"{{picture: {{size: [20, 20], encoding: mono8, markers: [{marker}]}}}}")
    row = [pixel(drawn, x, 10)[0] for x in range(20)]
    assert row == [128] * 2 + [255] * 2 + [7] * 12 + [255] * 2 + [128] * 2


def test_depths_are_those_of_the_fill(image):
    drawn = image("{picture: {size: [2, 1], encoding: 16UC1, fill: 500}}")
    assert (drawn.step, drawn.data) == (4, b"\xf4\x01\xf4\x01")


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        ("{picture: 3}", "expected a mapping, found '3'"),
        ("{picture: {sise: [2, 2]}}", "unknown key 'sise'"),
        ("{picture: {size: [2, 9999]}}", "from 0 to 4096"),
        ("{picture: {size: [0, 2]}}", "at least one pixel"),
        ("{picture: {encoding: jpeg}}", "'jpeg' cannot be drawn here; "),
        ("{picture: {fill: [1, 2, 300]}}", "each from 0 to 255"),
        ("{picture: {}, width: 3}", "the picture gives 'width'"),
        ("{picture: {encoding: 32FC1, discs: [{color: 3}]}}", "a picture of depths"),
        ("{picture: {markers: [{dictionary: DICT_4X5_50}]}}", "did you mean 'DICT_4X4_50'"),
        ("{picture: {markers: [{dictionary: DICT_4X4_50, id: 50}]}}", "the markers 0 to 49"),
        ("{picture: {markers: [{dictionary: DICT_4X4_50, at: [5, 5]}]}}", "do not fit"),
    ],
)
def test_what_cannot_be_drawn_is_refused_at_its_place(image, opencv, message, expected):
    with pytest.raises(ScenarioError) as error:
        image(message)
    assert expected in str(error.value)
    assert "s.yaml:4:" in str(error.value)


@pytest.mark.parametrize("interfaces", [Interfaces, Interfaces2])
def test_what_others_have_seen_is_likely_and_stands_in_a_large_picture(values, interfaces):
    made = interfaces().message("vision_msgs/Detection2DArray")
    (detection,) = values.fields(made)["detections"]
    box, (result,) = detection["bbox"], detection["results"]
    at = box["center"].get("position", box["center"])
    assert (at["x"], at["y"], box["size_x"], box["size_y"]) == (576.0, 120.0, 64.0, 48.0)
    assert result.get("hypothesis", result)["score"] == 0.9
    parts = ["height", "width"]
    large = drafted_pictures.picture("sensor_msgs/CameraInfo", parts, "camera", "", is_large=True)
    assert large == {"height": 480, "width": 640}


@pytest.mark.parametrize(
    ("source", "does"),
    [
        ("node.create_subscription(Detection2DArray, topic, on, 1)", True),
        ("def on(message):\n    return message.bbox.center", True),
        ("node.create_subscription(Detection3DArray, topic, on, 1)", False),
    ],
)
def test_a_source_that_is_told_of_pixels_gets_pictures_that_have_them(tmp_path, source, does):
    path = tmp_path / "pick.py"
    path.write_text(source)
    assert takes_pixels(Location(str(path), 1)) == does


def test_markers_need_opencv(image, monkeypatch):
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(ScenarioError, match="pip install opencv-contrib-python-headless"):
        image("{picture: {markers: [{dictionary: DICT_4X4_50}]}}")


@pytest.mark.parametrize(
    ("topic", "encoding"),
    [
        ("/overhead/depth_sensor/image_raw", "bgr8"),
        ("/depth_camera/image_raw", "bgr8"),
        ("/depthcam/depth/image_raw", "16UC1"),
        ("/camera/aligned_depth_to_color/image_raw", "16UC1"),
        ("/depth_image", "16UC1"),
    ],
)
def test_a_depth_camera_sends_colours_too(topic, encoding):
    drafted = drafted_pictures.picture("sensor_msgs/Image", ["header"], "camera", topic)
    assert drafted["picture"]["encoding"] == encoding
