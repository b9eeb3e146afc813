"""Trees of PyKDL from URDFs; each function returns whether all went in, and the tree."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import PyKDL as kdl

from ._model import model_of

__all__ = ["treeFromFile", "treeFromParam", "treeFromString", "treeFromUrdfModel"]


def treeFromFile(filename: str) -> tuple[bool, Any]:
    """Return the tree of a URDF file."""
    return treeFromString(Path(filename).read_bytes())


def treeFromParam(param: str) -> tuple[bool, Any]:
    """Return the tree of a URDF that is a parameter."""
    import rospy  # only here: ROS 2 has none

    return treeFromString(rospy.get_param(param))


def treeFromString(xml: str | bytes) -> tuple[bool, Any]:
    """Return the tree of a URDF text."""
    return treeFromUrdfModel(model_of(xml))


def treeFromUrdfModel(robot_model: Any, quiet: bool = False) -> tuple[bool, Any]:
    """Return the tree of a model of `urdf_parser_py`."""
    root = robot_model.link_map[robot_model.get_root()]
    if root.inertial and not quiet:
        print(  # noqa: T201 - as the library does
            f"The root link {root.name} has an inertia specified in the URDF, but KDL does not "
            "support a root link with an inertia. As a workaround, you can add an extra dummy "
            "link to your URDF."
        )
    tree = kdl.Tree(root.name)
    is_whole, links = True, [root.name]
    while links:
        link = links.pop()
        for joint in robot_model.joints:
            if joint.parent == link:
                segment = _segment(joint, robot_model.link_map[joint.child])
                is_whole = tree.addSegment(segment, link) and is_whole
                links.append(joint.child)
    return is_whole, tree


def _segment(joint: Any, link: Any) -> Any:
    frame = _frame(joint.origin)
    kinds = {
        "revolute": kdl.Joint.RotAxis,
        "continuous": kdl.Joint.RotAxis,
        "prismatic": kdl.Joint.TransAxis,
    }
    if joint.type in kinds:
        axis = frame.M * kdl.Vector(*(joint.axis or (1.0, 0.0, 0.0)))
        moving = kdl.Joint(joint.name, frame.p, axis, kinds[joint.type])
    else:
        moving = kdl.Joint(joint.name, kdl.Joint.Fixed)
    return kdl.Segment(joint.child, moving, frame, _inertia(link.inertial))


def _inertia(body: Any) -> Any:
    if not body:
        return kdl.RigidBodyInertia.Zero()
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    moments = kdl.RotationalInertia(*(getattr(body.inertia, name) for name in names))
    return _frame(body.origin) * kdl.RigidBodyInertia(body.mass, kdl.Vector(), moments)


def _frame(origin: Any) -> Any:
    if not origin:
        return kdl.Frame()
    turn, place = origin.rpy or (0.0, 0.0, 0.0), origin.xyz or (0.0, 0.0, 0.0)
    return kdl.Frame(kdl.Rotation.RPY(*turn), kdl.Vector(*place))
