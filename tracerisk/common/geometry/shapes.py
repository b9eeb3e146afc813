"""Primitive shapes: what bodies of robots and scenes are made of."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

from tracerisk.common.text.yaml_reader import YamlMap

ShapeKind = Literal["box", "sphere", "capsule", "cylinder"]

_SIZES = {"box": 3, "sphere": 1, "capsule": 2, "cylinder": 2}


@dataclass(frozen=True, slots=True)
class Mesh:
    """A mesh that is drawn and never simulated."""

    packed: str
    """Base64 of, little-endian: the number of vertices and of faces (uint32), a quantum [m]
    (float32), vertices in quanta (int16, 3 each), faces as indices of vertices (uint16, 3 each)."""
    paint: str = ""
    """Its colour as `#rrggbb`; "" for none of its own."""


@dataclass(frozen=True, slots=True)
class Shape:
    """A primitive in its body's frame."""

    kind: ShapeKind
    """`box`, `sphere`, `capsule` or `cylinder`."""
    size: tuple[float, ...]
    """Lengths [m]: box half lengths (x, y, z); sphere (radius); capsule and cylinder (radius, half
    length of the straight part), along z."""
    xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """The place of the middle in the body's frame [m]."""
    rpy: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch and yaw in the body's frame [rad]."""
    contact: bool = True
    """Whether it collides; false for a shape that is only shown."""
    pad: bool = False
    """Whether it is the soft surface of a finger."""
    mesh: Mesh | None = field(default=None, compare=False)
    """The mesh that it bounds, in the shape's own frame; `None` for none."""


def is_round(shape: Shape) -> bool:
    """Return whether a shape looks the same however its body is turned about its z axis."""
    is_on_axis = shape.xyz[:2] == (0.0, 0.0) and shape.rpy[:2] == (0.0, 0.0)
    return shape.kind != "box" and (
        is_on_axis or (shape.kind == "sphere" and not any(shape.xyz[:2]))
    )


def read_shapes(entry: YamlMap) -> tuple[Shape, ...]:
    """Return the shapes in the list `shapes` of a YAML mapping."""
    return tuple(_shape(shape) for shape in entry.maps("shapes"))


def _shape(entry: YamlMap) -> Shape:
    entry.forbid_unknown({"kind", "size", "xyz", "rpy", "contact", "pad"})
    kind = entry.choice("kind", get_args(ShapeKind), "shape")
    size = entry.numbers("size", length=_SIZES[kind])
    if min(size) <= 0.0:
        entry.fail("size", "every length must be above 0")
    return Shape(
        kind=kind,
        size=tuple(size),
        xyz=entry.triple("xyz"),
        rpy=entry.triple("rpy"),
        contact=entry.boolean("contact", default=True),
        pad=entry.boolean("pad", default=False),
    )
