"""Names of `cv2.aruco` that OpenCV has removed, for controllers written for that of their ROS.

OpenCV 4.7 gave markers an interface of classes, and took the functions away from the packages
without contributed modules. Noetic and Humble come with an OpenCV that has the functions.
"""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable, Iterator, Sequence
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from sys import _getframe
from types import ModuleType
from typing import Any

from tracerisk.errors import Location
from tracerisk.ros.controller.frames import is_library
from tracerisk.ros.graph.runtime import current

_RENAMED = {
    "Dictionary_get": "getPredefinedDictionary",
    "DetectorParameters_create": "DetectorParameters",
    "drawMarker": "generateImageMarker",
}


@contextlib.contextmanager
def removed_opencv_names() -> Iterator[None]:
    """Serve the controller's code the names of `cv2.aruco` that are gone, with a note."""
    finder = _Finder()
    sys.meta_path.insert(0, finder)
    before = sys.modules.get("cv2")
    if before is not None:
        _serve(before)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        aruco = getattr(sys.modules.get("cv2"), "aruco", None)
        if isinstance(aruco, ModuleType):
            vars(aruco).pop("__getattr__", None)


class _Finder(MetaPathFinder):
    """Finds OpenCV where it is installed, and adds the names once it is loaded."""

    def __init__(self) -> None:
        self._is_looking = False

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        del path, target
        # It loads a compiled module of its own name.
        if fullname != "cv2" or self._is_looking:
            return None
        self._is_looking = True
        try:
            spec = None if "cv2" in sys.modules else find_spec("cv2")
        finally:
            self._is_looking = False
        if spec is not None and spec.loader is not None:
            spec.loader = _Loader(spec.loader)
        return spec


class _Loader(Loader):
    def __init__(self, real: Any) -> None:
        self._real = real

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        made: ModuleType | None = self._real.create_module(spec)
        return made

    def exec_module(self, module: ModuleType) -> None:
        self._real.exec_module(module)
        _serve(sys.modules.get("cv2", module))


def _serve(cv2: ModuleType) -> None:
    aruco = getattr(cv2, "aruco", None)
    if not isinstance(aruco, ModuleType):
        return
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

    vars(aruco)["__getattr__"] = served


def _functions(cv2: Any, aruco: Any) -> dict[str, Callable[..., Any]]:
    """Return the functions that are gone, written on what replaces them."""
    import numpy as np

    def detect(
        image: Any, dictionary: Any, corners: Any = None, ids: Any = None, parameters: Any = None
    ) -> Any:
        del corners, ids
        chosen = aruco.DetectorParameters() if parameters is None else parameters
        found, numbers, refused = aruco.ArucoDetector(dictionary, chosen).detectMarkers(image)
        # One column, as before OpenCV 5.
        return found, None if numbers is None else np.asarray(numbers).reshape(-1, 1), refused

    def estimate(corners: Any, length: float, camera: Any, distortion: Any) -> Any:
        half = length / 2
        marker = np.array(
            [[-half, half, 0.0], [half, half, 0.0], [half, -half, 0.0], [-half, -half, 0.0]]
        )
        turns, places = [], []
        for each in corners:
            seen = np.asarray(each, dtype=np.float64).reshape(4, 2)
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
