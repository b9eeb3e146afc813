"""Names of `cv2.aruco` that OpenCV has removed, and windows, which a run does not open."""

import pytest

# An OpenCV of today, as far as these names go.
OPENCV = {
    "cv2/__init__.py": """\
from . import aruco
SOLVEPNP_IPPE_SQUARE = 7


def imshow(name, image):
    raise RuntimeError("no screen")


waitKey = namedWindow = createTrackbar = getTrackbarPos = imshow
""",
    "cv2/aruco.py": """\
DICT_4X4_50 = 0


def getPredefinedDictionary(number):
    return number


class DetectorParameters:
    pass


class ArucoDetector:
    def __init__(self, dictionary, parameters):
        self.kind = type(parameters).__name__

    def detectMarkers(self, image):
        return [image], [7], [self.kind]
""",
}
PROGRAM = """\
import sys, time
import cv2, moveit_commander, rospy
from cv2 import aruco


def turn():
    group = moveit_commander.MoveGroupCommander("panda_arm")
    joints = group.get_current_joint_values()
    words = cv2.aruco.Dictionary_get(aruco.DICT_4X4_50)
    parameters = aruco.DetectorParameters_create()
    _, ids, found = aruco.detectMarkers("image", words, parameters=parameters)
    assert found == ["DetectorParameters"]
    joints[0] += ids[0][0] / 70
    group.go(joints, wait=True)
    try:
        aruco.detectAll("image")
    except AttributeError as error:
        print(error, file=sys.stderr)


def show():
    cv2.namedWindow("view")
    cv2.createTrackbar("turn", "view", 20, 100, lambda value: None)
    group = moveit_commander.MoveGroupCommander("panda_arm")
    joints = group.get_current_joint_values()
    joints[0] -= cv2.getTrackbarPos("turn", "view") / 100
    group.go(joints, wait=True)
    cv2.imshow("view", "image")
    began = time.monotonic()
    assert [cv2.waitKey(500) for _ in range(2)] == [-1, -1]
    assert 1.0 <= time.monotonic() - began < 1.1
    assert cv2.waitKey(0) == 13


rospy.init_node("program")
turn()
show()
print("shown", file=sys.stderr)
"""


@pytest.fixture(scope="module")
def ran(example_in, tmp_path_factory):
    """The program, run where that OpenCV is installed."""
    installed = tmp_path_factory.mktemp("installed")
    for name, text in OPENCV.items():
        file = installed / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    example = example_in(tmp_path_factory.mktemp("controller"))
    example.write("c.py", PROGRAM)
    environment = {"PYTHONPATH": str(installed)}
    return example.run("run", "c.py", "--check", "--json", environment=environment)


def test_a_controller_for_an_older_opencv_runs_with_a_note(ran):
    assert ran.json["verdict"]["kind"] == "complete", ran.err
    reported = {each["message"].partition(" ")[0] for each in ran.json["trace"]["findings"]}
    assert reported == {
        "cv2.aruco.Dictionary_get",
        "cv2.aruco.DetectorParameters_create",
        "cv2.aruco.detectMarkers",
    }


def test_what_opencv_never_had_is_not_there(ran):
    assert "module 'cv2.aruco' has no attribute 'detectAll'" in ran.err


def test_the_functions_give_what_todays_classes_give():
    cv2 = pytest.importorskip("cv2")
    np = pytest.importorskip("numpy")
    from tracerisk.ros.imports.opencv_names import _functions

    made = _functions(cv2, cv2.aruco)
    words = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    image = np.full((240, 320), 255, np.uint8)
    image[70:170, 110:210] = cv2.aruco.generateImageMarker(words, 7, 100)
    corners, ids, _ = made["detectMarkers"](image, words)
    assert ids.tolist() == [[7]]
    camera = np.array([[300.0, 0.0, 160.0], [0.0, 300.0, 120.0], [0.0, 0.0, 1.0]])
    turns, places, _ = made["estimatePoseSingleMarkers"](corners, 0.1, camera, np.zeros(5))
    assert (turns.shape, places.shape) == ((1, 1, 3), (1, 1, 3))
    assert places[0, 0, 2] == pytest.approx(0.3, rel=0.03)


def test_no_window_opens_and_the_wait_for_a_key_takes_simulated_time(ran):
    assert ran.json["verdict"]["kind"] == "complete", ran.err
    assert "shown" in ran.err
