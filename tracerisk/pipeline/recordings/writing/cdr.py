"""The messages of ROS 2 that a recording holds: their definitions, and their bytes in CDR.

These types are written by hand: to load a package that knows all of them takes longer than to
write the recording of a run.
Sources: the interface packages of ROS 2; OMG DDSI-RTPS 2.3, section 10, for CDR.
"""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import NamedTuple

STATE = "sensor_msgs/msg/JointState"
TEXT = "std_msgs/msg/String"
LOG = "rcl_interfaces/msg/Log"
FRAMES = "tf2_msgs/msg/TFMessage"
MARKERS = "visualization_msgs/msg/MarkerArray"
NUMBER = "std_msgs/msg/Float64"
DEFINITIONS = {
    "builtin_interfaces/msg/Time": "int32 sec\nuint32 nanosec",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "geometry_msgs/msg/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/msg/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/msg/Transform": "geometry_msgs/Vector3 translation\n"
    "geometry_msgs/Quaternion rotation",
    "geometry_msgs/msg/TransformStamped": "std_msgs/Header header\nstring child_frame_id\n"
    "geometry_msgs/Transform transform",
    STATE: "std_msgs/Header header\nstring[] name\n"
    "float64[] position\nfloat64[] velocity\nfloat64[] effort",
    TEXT: "string data",
    LOG: "uint8 DEBUG=10\nuint8 INFO=20\nuint8 WARN=30\nuint8 ERROR=40\nuint8 FATAL=50\n"
    "builtin_interfaces/Time stamp\nuint8 level\n"
    "string name\nstring msg\nstring file\nstring function\nuint32 line",
    FRAMES: "geometry_msgs/TransformStamped[] transforms",
    NUMBER: "float64 data",
    "builtin_interfaces/msg/Duration": "int32 sec\nuint32 nanosec",
    "geometry_msgs/msg/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/msg/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "std_msgs/msg/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "visualization_msgs/msg/UVCoordinate": "float32 u\nfloat32 v",
    "visualization_msgs/msg/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/msg/Marker": "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\n"
    "int32 CYLINDER=3\nint32 LINE_STRIP=4\nint32 LINE_LIST=5\nint32 CUBE_LIST=6\n"
    "int32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\nint32 MESH_RESOURCE=10\n"
    "int32 TRIANGLE_LIST=11\nint32 ARROW_STRIP=12\nint32 ADD=0\nint32 MODIFY=0\n"
    "int32 DELETE=2\nint32 DELETEALL=3\n"
    "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
    "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
    "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
    "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
    "sensor_msgs/CompressedImage texture\nvisualization_msgs/UVCoordinate[] uv_coordinates\n"
    "string text\nstring mesh_resource\nvisualization_msgs/MeshFile mesh_file\n"
    "bool mesh_use_embedded_materials",
    MARKERS: "visualization_msgs/Marker[] markers",
}
"""The messages that are written, as ROS 2 defines them."""
WARN = 30
"""The level of a warning in `rcl_interfaces/msg/Log`."""

_SECOND_NS = 1_000_000_000
_ENCAPSULATION = b"\x00\x01\x00\x00"  # CDR, little-endian


class Stamped(NamedTuple):
    """A message with its time and topic."""

    time_ns: int
    """The time in the simulation, from 0 [ns]."""
    topic: str
    """The topic of the message."""
    data: bytes
    """The message in CDR."""


def definition(name: str) -> str:
    """Return the definition of a message with those that it is made of, as `ros2msg`."""
    parts = [DEFINITIONS[name]]
    for used in dict.fromkeys(_used(name)):
        package, _, short = used.split("/")
        parts.append(f"{'=' * 80}\nMSG: {package}/{short}\n{DEFINITIONS[used]}")
    return "\n".join(parts) + "\n"


def _used(name: str) -> Iterable[str]:
    for line in DEFINITIONS[name].splitlines():
        package, _, short = line.split()[0].removesuffix("[]").partition("/")
        if short:
            yield f"{package}/msg/{short}"
            yield from _used(f"{package}/msg/{short}")


class Cdr:
    """Writes one message, field by field; `data` are its bytes so far."""

    def __init__(self) -> None:
        self.data = bytearray(_ENCAPSULATION)

    def number(self, code: str, value: float) -> None:
        """Write a number of `struct`'s type `code`."""
        self._align(struct.calcsize(f"<{code}"))
        self.data += struct.pack(f"<{code}", value)

    def text(self, value: str) -> None:
        """Write a string."""
        raw = value.encode("utf-8", "replace") + b"\0"
        self.number("I", len(raw))
        self.data += raw

    def stamp(self, time_ns: int) -> int:
        """Write a time; return where it stands."""
        self._align(4)
        begin = len(self.data)
        self.data += struct.pack("<iI", *divmod(time_ns, _SECOND_NS))
        return begin

    def doubles(self, values: Sequence[float], *, counted: bool) -> int:
        """Write numbers, as a sequence with its length if `counted`; return where they stand."""
        if counted:
            self.number("I", len(values))
        if values:
            self._align(8)
        begin = len(self.data)
        self.data += struct.pack(f"<{len(values)}d", *values)
        return begin

    def _align(self, size: int) -> None:
        self.data += bytes(-(len(self.data) - len(_ENCAPSULATION)) % size)


def text_message(value: str) -> bytes:
    """Return a `std_msgs/msg/String`."""
    out = Cdr()
    out.text(value)
    return bytes(out.data)


def number_message(value: float) -> bytes:
    """Return a `std_msgs/msg/Float64`."""
    out = Cdr()
    out.number("d", value)
    return bytes(out.data)


def joint_message(
    time_ns: int,
    names: Sequence[str],
    *columns: Sequence[float],
) -> tuple[bytes, int, list[int]]:
    """Return a `sensor_msgs/msg/JointState`, and where its stamp and its numbers stand.

    `columns` are position, velocity and effort; what is not given is empty.
    """
    out = Cdr()
    stamp = out.stamp(time_ns)
    out.text("")
    out.number("I", len(names))
    for name in names:
        out.text(name)
    places = [out.doubles(column, counted=True) for column in (*columns, (), ())[:3]]
    return bytes(out.data), stamp, places


def log_message(
    time_ns: int, level: int, name: str, message: str, file: str, function: str, line: int
) -> bytes:
    """Return a `rcl_interfaces/msg/Log`."""
    out = Cdr()
    out.stamp(time_ns)
    out.number("B", level)
    for text in (name, message, file, function):
        out.text(text)
    out.number("I", line)
    return bytes(out.data)
