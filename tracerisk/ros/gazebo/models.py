"""Models that a controller spawns: bodies of primitives in SDF or URDF.

Source of the formats: sdformat.org/spec (model, link, collision, geometry, inertial) and
wiki.ros.org/urdf/XML.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError
from tracerisk.ros.transforms.poses import compose, quaternion_from_rpy, rpy_from_quaternion
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene_body import HalfSpace, SceneBody
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

_LONGEST_M = 1000.0
_ROUND = {"sphere": ("radius",), "cylinder": ("radius", "length")}


class ModelRefusedError(Exception):
    """A model that is not a body of the twin, and why."""


def model_body(name: str, text: str, pose: Pose) -> SceneBody:
    """Return the body of a model's text, at `pose` in the robot's base frame.

    Raises:
        ModelRefusedError: it is no SDF or URDF, has joints, or shapes other than box, sphere,
            cylinder and plane.
    """
    try:
        top = read_xml(text, f"model '{name}'")
    except RobotError as error:
        raise ModelRefusedError(f"the model is not XML: {error}") from error
    if top.tag == "robot":
        return _from_urdf(name, top, pose)
    model = top if top.tag == "model" else _model_in(top)
    if model is None:
        raise ModelRefusedError(f"<{top.tag}> is neither an SDF model nor a URDF robot")
    if model.first("joint") is not None or model.first("include") is not None:
        raise ModelRefusedError("the model has joints or includes; a single body can be spawned")
    shapes: list[Shape] = []
    grounds: list[HalfSpace] = []
    mass = 0.0
    own = _sdf_pose(model)
    for link in model.all("link"):
        in_link = _sdf_pose(link)
        mass += _number(_text(link, "inertial", "mass") or "0", "mass")
        for collision in link.all("collision"):
            place = compose(in_link, _sdf_pose(collision))
            geometry = collision.first("geometry")
            plane = None if geometry is None else geometry.first("plane")
            if plane is None:
                shapes.append(_shape_of(geometry, place, _text))
            else:
                grounds.append(HalfSpace(place))
    is_static = (_text(model, "static") or "").strip() in ("1", "true")
    return _body(name, compose(pose, own), shapes, grounds, mass, is_static=is_static)


def _from_urdf(name: str, top: XmlElement, pose: Pose) -> SceneBody:
    joints = [joint for joint in top.all("joint") if joint.attributes.get("type") != "fixed"]
    if joints:
        raise ModelRefusedError("the model has joints; a single body can be spawned")
    placed = {_attribute(joint.first("child"), "link"): joint for joint in top.all("joint")}
    shapes, mass = [], 0.0
    for link in top.all("link"):
        in_model = _urdf_place(link.attributes.get("name"), placed)
        mass += _number(_attribute(_at(link, "inertial", "mass"), "value") or "0", "mass")
        for collision in link.all("collision"):
            place = compose(in_model, _origin(collision))
            shapes.append(_shape_of(collision.first("geometry"), place, _written))
    return _body(name, pose, shapes, [], mass, is_static=any(_says_static(top)))


def _says_static(top: XmlElement) -> Iterator[bool]:
    for part in top.all("gazebo"):
        yield (_text(part, "static") or "").strip() in ("1", "true")


def _body(
    name: str,
    pose: Pose,
    shapes: list[Shape],
    grounds: list[HalfSpace],
    mass: float,
    *,
    is_static: bool,
) -> SceneBody:
    if not shapes and not grounds:
        raise ModelRefusedError("the model has no collision shape, so that nothing could touch it")
    return SceneBody(
        name,
        pose,
        tuple(shapes),
        half_spaces=tuple(grounds),
        is_free=not is_static and not grounds,
        given_mass=mass if mass > 0.0 else None,
    )


def _shape_of(
    geometry: XmlElement | None, place: Pose, length: Callable[[XmlElement, str], str | None]
) -> Shape:
    """Return the shape of a geometry; `length` gives the text of one of its lengths."""
    kind = None if geometry is None else next(iter(geometry.children), None)
    if kind is not None and kind.tag == "box":
        return _shape("box", _numbers(length(kind, "size"), 3, "size"), place)
    if kind is not None and kind.tag in _ROUND:
        sizes = [_number(length(kind, part), part) for part in _ROUND[kind.tag]]
        return _shape(kind.tag, sizes, place)
    text = "nothing" if kind is None else f"<{kind.tag}>"
    raise ModelRefusedError(
        f"a collision shape is {text}; tracerisk spawns bodies of box, sphere and cylinder"
    )


def _shape(kind: str, sizes: list[float], place: Pose) -> Shape:
    if min(sizes) <= 0.0:
        raise ModelRefusedError(f"a {kind} has a length that is not above 0")
    if max(sizes) > _LONGEST_M:
        raise ModelRefusedError(
            f"a {kind} is {max(sizes):g} m long; at most {_LONGEST_M:g} m are simulated"
        )
    rpy = rpy_from_quaternion(place.orientation)
    if kind == "box":
        return Shape("box", tuple(size / 2 for size in sizes), place.position, rpy)
    if kind == "sphere":
        return Shape("sphere", (sizes[0],), place.position, rpy)
    return Shape("cylinder", (sizes[0], sizes[1] / 2), place.position, rpy)


def _sdf_pose(element: XmlElement) -> Pose:
    text = _text(element, "pose")
    return _pose(_numbers(text, 6, "pose")) if text and text.strip() else _pose([0.0] * 6)


def _origin(element: XmlElement | None) -> Pose:
    origin = None if element is None else element.first("origin")
    xyz = _numbers(_attribute(origin, "xyz") or "0 0 0", 3, "xyz")
    return _pose([*xyz, *_numbers(_attribute(origin, "rpy") or "0 0 0", 3, "rpy")])


def _urdf_place(link: str | None, placed: dict[str | None, XmlElement]) -> Pose:
    place, seen = _pose([0.0] * 6), {link}
    while link in placed:
        joint = placed[link]
        place = compose(_origin(joint), place)
        link = _attribute(joint.first("parent"), "link")
        if link in seen:
            raise ModelRefusedError(f"the links of the model go round in a circle at '{link}'")
        seen.add(link)
    return place


def _model_in(top: XmlElement) -> XmlElement | None:
    """Return the first model of an SDF, which may be within a world."""
    worlds = [top, *top.all("world")]
    return next((model for world in worlds for model in world.all("model")), None)


def _at(element: XmlElement, *tags: str) -> XmlElement | None:
    first: XmlElement | None = element
    for tag in tags:
        first = None if first is None else first.first(tag)
    return first


def _text(element: XmlElement, *tags: str) -> str | None:
    xml_element = _at(element, *tags)
    return None if xml_element is None else xml_element.text


def _attribute(element: XmlElement | None, name: str) -> str | None:
    return None if element is None else element.attributes.get(name)


def _written(element: XmlElement, name: str) -> str:
    return element.attributes.get(name, "")


def _pose(values: list[float]) -> Pose:
    x, y, z, roll, pitch, yaw = values
    return Pose((x, y, z), quaternion_from_rpy(roll, pitch, yaw))


def _number(text: str | None, what: str) -> float:
    return _numbers(text, 1, what)[0]


def _numbers(text: str | None, count: int, what: str) -> list[float]:
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise ModelRefusedError(f"{what} '{text}' is not {count} finite number(s)")
    return values
