"""Pictures that a scenario describes: a plain ground, with markers and discs on it."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterable, Mapping
from importlib import import_module
from typing import Any

from tracerisk.common.text.yaml_reader import YamlMap
from tracerisk.errors import one_of

PICTURE = "picture"
"""The key that stands in a message for the fields which a picture fills."""
ENCODINGS: Mapping[str, str] = {
    "bgr8": "bgr", "rgb8": "rgb", "mono8": "y", "16UC1": "", "32FC1": "",
}  # fmt: skip
"""What can be drawn, each with the order of its colours; depths [mm], [m] have none."""

_KEYS = ("size", "encoding", "fill", "markers", "discs")
_LARGEST = 4096  # pixels along a side
_DEPTHS = {"16UC1": ("<H", 65535), "32FC1": ("<f", 1e6)}
_GREY = 128.0
_QUIET = 6  # a marker's side is so many of the white border around it


def picture_fields(entry: YamlMap, *, is_png: bool) -> dict[str, Any]:
    """Return the fields of an Image, or of a CompressedImage with `is_png`, as `entry` says.

    Raises:
        ScenarioError: an unknown key, or a value that cannot be drawn, with its place.
    """
    entry.forbid_unknown(_KEYS)
    width, height = _pixels(entry, "size", default=(640, 480))
    encoding = "rgb8" if is_png else "bgr8"
    encoding = entry.string("encoding", default=encoding)
    known = ("rgb8", "mono8") if is_png else tuple(ENCODINGS)
    if encoding not in known:
        entry.fail("encoding", f"'{encoding}' cannot be drawn here; {one_of(known, encoding)}")
    drawn = _Drawn(width, height, encoding, entry)
    for marker in entry.maps("markers"):
        drawn.draw_marker(marker)
    for disc in entry.maps("discs"):
        drawn.draw_disc(disc)
    if is_png:
        return {"format": "png", "data": _png(drawn)}
    return {
        "height": height, "width": width, "encoding": encoding, "is_bigendian": 0,
        "step": drawn.step, "data": bytes(drawn.data),
    }  # fmt: skip


class _Drawn:
    """The pixels of a picture, row by row."""

    def __init__(self, width: int, height: int, encoding: str, entry: YamlMap) -> None:
        self.width, self.height = width, height
        self._order = ENCODINGS[encoding]
        if self._order:
            ground = self._pixel(entry, "fill")
        else:
            code, most = _DEPTHS[encoding]
            fill = entry.number("fill", default=0.0, minimum=0.0, maximum=most)
            ground = struct.pack(code, round(fill) if code == "<H" else fill)
        self.step = len(ground) * width
        self.data = bytearray(ground * (width * height))

    @property
    def channels(self) -> int:
        """The bytes of a pixel."""
        return self.step // self.width

    def draw_marker(self, entry: YamlMap) -> None:
        """Draw a marker of a dictionary of OpenCV, with a white border around it."""
        entry.forbid_unknown(("dictionary", "id", "at", "side"))
        x, y = self._place(entry)
        side = entry.integer("side", default=self.height // 4, minimum=8)
        border = -(-side // _QUIET)
        marker = _marker_rows(entry, side)
        white = b"\xff" * (side + 2 * border)
        wide = [b"\xff" * border + row + b"\xff" * border for row in marker]
        rows = [*[white] * border, *wide, *[white] * border]
        left, top = x - len(white) // 2, y - len(rows) // 2
        if left < 0 or top < 0 or left + len(white) > self.width or top + len(rows) > self.height:
            entry.fail(
                "at",
                f"a marker of {side} pixels and its border do not fit into the picture at "
                f"[{x}, {y}]",
            )
        for number, row in enumerate(rows, top):
            pixels = row if self.channels == 1 else bytes(v for v in row for _ in range(3))
            self._paint(number, left, pixels)

    def draw_disc(self, entry: YamlMap) -> None:
        """Draw a disc of one colour, as far as it lies in the picture."""
        entry.forbid_unknown(("color", "at", "radius"))
        x, y = self._place(entry)
        radius = entry.integer("radius", default=self.height // 8, minimum=1)
        pixel = self._pixel(entry, "color")
        for row in range(max(0, y - radius), min(self.height, y + radius + 1)):
            half = int((radius**2 - (row - y) ** 2) ** 0.5)
            left, right = max(0, x - half), min(self.width, x + half + 1)
            self._paint(row, left, pixel * max(0, right - left))

    def _paint(self, row: int, left: int, pixels: bytes) -> None:
        begin = row * self.step + left * self.channels
        self.data[begin : begin + len(pixels)] = pixels

    def _place(self, entry: YamlMap) -> tuple[int, int]:
        if not self._order:
            entry.fail("at", "nothing is drawn into a picture of depths")
        return _pixels(entry, "at", default=(self.width // 2, self.height // 2))

    def _pixel(self, entry: YamlMap, key: str) -> bytes:
        """Return a colour, which is a grey or [red, green, blue], in the order of the encoding."""
        value = entry.get(key) if key in entry else _GREY
        if isinstance(value, list):
            red, green, blue = entry.numbers(key, length=3)
        else:
            red = green = blue = entry.number(key, default=_GREY)
        if not all(0 <= item <= 255 for item in (red, green, blue)):
            entry.fail(key, "a colour is a grey, or [red, green, blue], each from 0 to 255")
        parts = {"r": red, "g": green, "b": blue, "y": (red + green + blue) / 3}
        return bytes(round(parts[name]) for name in self._order)


def _pixels(entry: YamlMap, key: str, *, default: tuple[int, int]) -> tuple[int, int]:
    numbers = entry.numbers(key, length=2) if key in entry else default
    if not all(item == round(item) and 0 <= item <= _LARGEST for item in numbers):
        entry.fail(key, f"expected two whole numbers of pixels, from 0 to {_LARGEST}")
    first, second = map(round, numbers)
    if key == "size" and 0 in (first, second):
        entry.fail(key, "a picture has at least one pixel")
    return first, second


def _marker_rows(entry: YamlMap, side: int) -> Iterable[bytes]:
    """Return the rows of a marker as OpenCV draws it, which need not be installed else."""
    name = entry.string("dictionary")
    number = entry.integer("id", default=0, minimum=0)
    try:
        aruco = import_module("cv2").aruco
    except (ImportError, AttributeError):
        entry.fail(
            "dictionary",
            "markers are drawn by OpenCV's aruco, which is not installed beside the controller; "
            "pip install opencv-contrib-python-headless",
        )
    known = sorted(text for text in dir(aruco) if text.startswith("DICT_"))
    if name not in known:
        entry.fail("dictionary", f"OpenCV has no dictionary '{name}'; {one_of(known, name)}")
    dictionary = aruco.getPredefinedDictionary(getattr(aruco, name))
    count = len(dictionary.bytesList)
    if number >= count:
        entry.fail("id", f"{name} has the markers 0 to {count - 1}")
    draw = getattr(aruco, "generateImageMarker", None) or aruco.drawMarker
    return [bytes(row) for row in draw(dictionary, number, side)]


def _png(drawn: _Drawn) -> bytes:
    kind = 0 if drawn.channels == 1 else 2
    rows = b"".join(
        b"\0" + drawn.data[at : at + drawn.step] for at in range(0, len(drawn.data), drawn.step)
    )
    header = struct.pack(">IIBBBBB", drawn.width, drawn.height, 8, kind, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", zlib.compress(rows, 1)), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in parts
    )
