"""What controllers ask of OpenCV that today's does not give, or a run has no use for.

A run has no screen: no window opens, and where one waits for a key without an end, Enter comes.

OpenCV 4.7 gave markers an interface of classes, and took the functions away from the packages
without contributed modules. Noetic and Humble come with an OpenCV that has the functions.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from functools import partial
from sys import _getframe
from types import ModuleType
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import is_library
from tracerisk.ros.graph.runtime import current
from tracerisk.ros.imports.once_loaded import once_loaded

_RENAMED = {
    "Dictionary_get": "getPredefinedDictionary",
    "DetectorParameters_create": "DetectorParameters",
    "drawMarker": "generateImageMarker",
}
_OF_WINDOWS = (
    *("imshow", "namedWindow", "destroyWindow", "destroyAllWindows", "moveWindow"),
    *("resizeWindow", "setWindowTitle", "setWindowProperty", "setMouseCallback"),
    *("startWindowThread", "setTrackbarMin", "setTrackbarMax", "displayOverlay"),
)
_ENTER = 13
_ENTER_NS = 1_000_000_000  # until it is pressed


@contextlib.contextmanager
def served_opencv_names() -> Iterator[None]:
    """Serve names of `cv2.aruco` that are gone, with a note, and windows that do not open."""
    with contextlib.ExitStack() as undo, once_loaded("cv2", partial(_serve, undo)):
        yield


def _serve(undo: contextlib.ExitStack, cv2: ModuleType) -> None:
    windows = {name: window for name, window in _windows().items() if name in vars(cv2)}
    undo.callback(vars(cv2).update, {name: vars(cv2)[name] for name in windows})
    vars(cv2).update(windows)
    aruco = getattr(cv2, "aruco", None)
    if isinstance(aruco, ModuleType):
        vars(aruco)["__getattr__"] = _removed(cv2, aruco)
        undo.callback(vars(aruco).pop, "__getattr__", None)


def _windows() -> dict[str, Callable[..., Any]]:
    """Return functions of windows that open none; a wait for a key takes its simulated time."""
    bars: dict[tuple[str, str], int] = {}

    def wait(delay: int = 0) -> int:
        current().scheduler.sleep(delay * 1_000_000 if delay > 0 else _ENTER_NS)
        return -1 if delay > 0 else _ENTER

    def add_bar(bar: str, window: str, value: int, *_: Any, **__: Any) -> None:
        bars[window, bar] = value

    return {
        **dict.fromkeys(_OF_WINDOWS, lambda *_, **__: None),
        **dict.fromkeys(("waitKey", "waitKeyEx"), wait),
        "pollKey": lambda: wait(1),
        "createTrackbar": add_bar,
        "getTrackbarPos": lambda bar, window: bars.get((window, bar), -1),
        "setTrackbarPos": lambda bar, window, value: add_bar(bar, window, value),
        "getWindowProperty": lambda *_: 1.0,
    }


def _removed(cv2: ModuleType, aruco: ModuleType) -> Callable[[str], Any]:
    made = _functions(cv2, aruco)

    def served(name: str) -> Any:
        asker = _getframe(1)
        stands = getattr(aruco, _RENAMED[name], None) if name in _RENAMED else made.get(name)
        if stands is None or is_library(asker.f_code.co_filename):
            raise AttributeError(f"module 'cv2.aruco' has no attribute '{name}'")
        current().recorder.finding(
            "removed_name",
            f"cv2.aruco.{name} is gone from the OpenCV that is installed here; what replaces it "
            "stands for it, as in the OpenCV of older ROS",
            Location(asker.f_code.co_filename, asker.f_lineno),
            object_name=f"cv2.aruco.{name}",
        )
        return stands

    return served


def _functions(cv2: Any, aruco: Any) -> dict[str, Callable[..., Any]]:
    """Return the functions that are gone, written on what replaces them."""
    import numpy as np

    def detect(
        image: Any, dictionary: Any, corners: Any = None, ids: Any = None, parameters: Any = None
    ) -> Any:
        del corners, ids
        chosen = aruco.DetectorParameters() if parameters is None else parameters
        result, numbers, refused = aruco.ArucoDetector(dictionary, chosen).detectMarkers(image)
        # One column, as before OpenCV 5.
        return result, None if numbers is None else np.asarray(numbers).reshape(-1, 1), refused

    def estimate(corners: Any, length: float, camera: Any, distortion: Any) -> Any:
        half = length / 2
        marker = np.array(
            [[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]]
        )
        turns, places = [], []
        for corner in corners:
            seen = np.asarray(corner, dtype=np.float64).reshape(4, 2)
            _, turn, place = cv2.solvePnP(
                marker, seen, camera, distortion, flags=cv2.SOLVEPNP_IPPE_SQUARE
            )
            turns.append(turn.reshape(1, 3))
            places.append(place.reshape(1, 3))
        return np.array(turns), np.array(places), marker.reshape(4, 1, 3)

    def draw_axis(
        image: Any, camera: Any, distortion: Any, turn: Any, place: Any, length: float
    ) -> Any:
        return cv2.drawFrameAxes(image, camera, distortion, turn, place, length)

    return {
        "detectMarkers": detect,
        "estimatePoseSingleMarkers": estimate,
        "drawAxis": draw_axis,
    }
