"""The links and joints of a URDF, in the shape that `urdf_parser_py` gives them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from tracerisk.errors import RobotError
from tracerisk.twin.urdf.xml_reader import XmlElement, read_xml

_ZEROS = (0.0, 0.0, 0.0)
_MOMENTS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def model_of(xml: str | bytes) -> Any:
    """Return the model of a URDF.

    Raises:
        ValueError: it is not one; says where.
    """
    try:
        top = read_xml(xml, "robot_description")
        if top.tag != "robot":
            top.fail("is not the element <robot> of a URDF")
        links = {xml_element.string("name"): _link(xml_element) for xml_element in top.all("link")}
        joints = [_joint(xml_element) for xml_element in top.all("joint")]
    except RobotError as error:
        raise ValueError(str(error)) from error
    hung = {joint.child for joint in joints}
    roots = [name for name in links if name not in hung]
    if len(roots) != 1:
        raise ValueError(f"the URDF has {len(roots)} links that hang on nothing; one is the root")
    return SimpleNamespace(link_map=links, joints=joints, get_root=lambda: roots[0])


def _link(element: XmlElement) -> Any:
    inertial = element.first("inertial")
    if inertial is None:
        return SimpleNamespace(name=element.string("name"), inertial=None)
    mass, moments = inertial.first("mass"), inertial.first("inertia")
    body = SimpleNamespace(
        origin=_origin(inertial),
        mass=0.0 if mass is None else mass.number("value", 0.0),
        inertia=SimpleNamespace(
            **{name: 0.0 if moments is None else moments.number(name, 0.0) for name in _MOMENTS}
        ),
    )
    return SimpleNamespace(name=element.string("name"), inertial=body)


def _joint(element: XmlElement) -> Any:
    axis, limit = element.first("axis"), element.first("limit")
    parent, child = (element.first(tag) for tag in ("parent", "child"))
    if parent is None or child is None:
        element.fail("has no parent or no child")
    return SimpleNamespace(
        name=element.string("name"),
        type=element.string("type"),
        origin=_origin(element),
        axis=(1.0, 0.0, 0.0) if axis is None else axis.triple("xyz", (1.0, 0.0, 0.0)),
        parent=parent.string("link"),
        child=child.string("link"),
        limit=limit
        and SimpleNamespace(lower=limit.number("lower", 0.0), upper=limit.number("upper", 0.0)),
    )


def _origin(element: XmlElement) -> Any:
    origin = element.first("origin")
    if origin is None:
        return SimpleNamespace(xyz=_ZEROS, rpy=_ZEROS)
    return SimpleNamespace(xyz=origin.triple("xyz", _ZEROS), rpy=origin.triple("rpy", _ZEROS))
