"""What a program shows of the values in a message: their fields, their elements, their types."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

_TRUTH = re.compile(r"^(is|has|was|should|enabled?)_|^(ok|success|succeeded|done|result|enabled?)$")
_TEXT = re.compile(
    r"(^|_)(names?|text|messages?|msg|command|cmd|labels?|word|path|file|frame|frame_id|uuid|mode|"
    r"state|status_text|info|class_name)$"
)
_SEVERAL = re.compile(
    r"(^|_)(joints?|joint_\w*|values|positions?|velocit(y|ies)|efforts?|angles|data|array|list|"
    r"\w*[a-z]{2}s)$"
)
_LISTS_OF_TEXTS = re.compile(r"(^|_)(names|labels|texts)$")
_TEXTS_OF_ONE = re.compile(r"(^|_)(status|success|pos|radius|class|mass|axis|progress|has|is)$")
# The fields by which a message of ROS is known, the most telling first.
_KNOWN = (
    ({"secs", "nsecs"}, "time"),
    ({"x", "y", "z", "w"}, "geometry_msgs/Quaternion"),
    ({"w"}, "geometry_msgs/Quaternion"),
    ({"pose"}, "geometry_msgs/PoseStamped"),
    ({"transform"}, "geometry_msgs/TransformStamped"),
    ({"orientation"}, "geometry_msgs/Pose"),
    ({"joint_names"}, "trajectory_msgs/JointTrajectory"),
    ({"points"}, "trajectory_msgs/JointTrajectory"),
    ({"linear"}, "geometry_msgs/Twist"),
    ({"angular"}, "geometry_msgs/Twist"),
    ({"force"}, "geometry_msgs/Wrench"),
    ({"translation"}, "geometry_msgs/Transform"),
    ({"encoding"}, "sensor_msgs/Image"),
    ({"name", "position"}, "sensor_msgs/JointState"),
    ({"position"}, "geometry_msgs/Pose"),
    ({"z"}, "geometry_msgs/Point"),
    ({"x"}, "geometry_msgs/Point"),
    ({"stamp"}, "std_msgs/Header"),
    ({"seq"}, "std_msgs/Header"),
)
_STRICTEST = ("string", "float64", "int64", "bool")
HEADER = "std_msgs/Header"


@dataclass(slots=True, eq=False)
class Shape:
    """What is known of a value: nothing at first."""

    fields: dict[str, Shape] = field(default_factory=dict)
    """The shapes of the fields that are read or set, in the order in which they are met."""
    element: Shape | None = None
    """The shape of its elements, where it is used as a list."""
    kinds: set[str] = field(default_factory=set)
    """The types of what it is compared with, computed with or set to."""
    in_order: list[Shape] = field(default_factory=list)
    """The shapes of the values that are given without a name, in their order."""

    def at(self, name: str) -> Shape:
        """Return the shape of a field."""
        return self.fields.setdefault(name, Shape())

    def each(self) -> Shape:
        """Return the shape of its elements: it is a list."""
        if self.element is None:
            self.element = Shape()
        return self.element

    def given(self, number: int) -> Shape:
        """Return the shape of the value that is given without a name at a place, from 0."""
        while len(self.in_order) <= number:
            self.in_order.append(Shape())
        return self.in_order[number]


Nested = Callable[[str, Shape], str]
"""The function that defines a message of the package itself, and returns its name."""


def definition_lines(shape: Shape, nested: Nested) -> list[str]:
    """Return the lines of a definition: a type and a name for each field."""
    named = list(shape.fields.items())
    beyond = shape.in_order[len(named) :] if len(shape.in_order) > len(named) else []
    # What has no name comes first: constructors take all fields in order.
    unnamed = [(f"value_{number}", inner) for number, inner in enumerate(beyond)]
    if len(shape.in_order) == len(named):
        for (_, inner), other in zip(named, shape.in_order, strict=True):
            inner.kinds |= other.kinds
    return [f"{type_of_shape(name, inner, nested)} {name}" for name, inner in (*unnamed, *named)]


def type_of_shape(name: str, shape: Shape, nested: Nested) -> str:
    """Return the type of a field: what the program shows, else what its name says."""
    if name == "header":
        return HEADER
    if shape.element is not None and "string" not in shape.kinds:
        element = shape.element
        if not (element.fields or element.kinds or element.element):
            return "string[]" if _LISTS_OF_TEXTS.search(name) else "float64[]"
        if element.element is not None and not element.fields:
            # A definition knows no list of lists.
            return "float64[]"
        return f"{type_of_shape(name.removesuffix('s'), element, nested)}[]"
    references = sorted(kind for kind in shape.kinds if "/" in kind or kind in ("time", "duration"))
    if references:
        return references[0]
    if shape.fields:
        return _of_fields(name, shape, nested)
    for kind in _STRICTEST:
        if kind in shape.kinds:
            return kind
    return _by_name(name)


def _of_fields(name: str, shape: Shape, nested: Nested) -> str:
    names = shape.fields.keys()
    for telling, kind in _KNOWN:
        if telling <= names:
            is_stamped = kind == "geometry_msgs/Pose" and "header" in names
            return "geometry_msgs/PoseStamped" if is_stamped else kind
    return nested(name, shape)


def _by_name(name: str) -> str:
    if _TRUTH.search(name):
        return "bool"
    if _TEXT.search(name):
        return "string[]" if _LISTS_OF_TEXTS.search(name) else "string"
    if _SEVERAL.search(name) and not _TEXTS_OF_ONE.search(name):
        return "float64[]"
    return "float64"
