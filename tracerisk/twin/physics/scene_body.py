"""Bodies that a controller declares while it runs: what a planning scene holds.

A body of the world stands still where it was put, as in MoveIt's planning scene; one that is
attached is a free body, welded to its link. A model that a controller spawns is free as well.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError
from tracerisk.twin.physics.builder import add_geom, shape_volume
from tracerisk.twin.physics.motion import Pose

import mujoco  # isort: skip

_DENSITY = 300.0  # of an attached body: assumed, as of a filled carton [kg/m^3]
_HEAVIEST = 0.5  # an attached body's mass, at most: assumed [kg]
_FRICTION = 0.5
_FLAT = 1e-6  # a hull thinner than this is not a body [m]
_WELD = (0.004, 1.0)  # time constant [s] and damping of the weld: two steps, the stiffest stable


@dataclass(frozen=True, slots=True)
class Hull:
    """The convex hull of a set of points."""

    points: tuple[tuple[float, float, float], ...]
    """The points in the body's frame [m], (n_points, 3)."""


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """All that lies below a plane."""

    pose: Pose
    """A pose on the plane in the body's frame, z pointing out of the ground."""


@dataclass(frozen=True, slots=True)
class SceneBody:
    """A body that a controller has declared."""

    name: str
    """The name under which the controller declared it."""
    pose: Pose
    """The pose in the robot's base frame, or in the frame of `link` when attached."""
    shapes: tuple[Shape, ...] = ()
    """The primitives, in the body's frame."""
    hulls: tuple[Hull, ...] = ()
    """The convex hulls of its meshes, in the body's frame."""
    half_spaces: tuple[HalfSpace, ...] = ()
    """Ground planes, in the body's frame."""
    link: str | None = None
    """The robot's link to which the body is attached; `None` for a body of the world."""
    touch_links: tuple[str, ...] = ()
    """The links that an attached body may touch."""
    is_free: bool = False
    """Whether a body of the world can be moved."""
    given_mass: float | None = None
    """The declared mass [kg]; `None` where it is assumed from the volume."""

    def __post_init__(self) -> None:
        for hull in self.hulls:
            if not _is_solid(hull):
                raise RobotError(
                    f"a mesh of scene object '{self.name}' has no volume: its "
                    f"{len(hull.points)} points lie in one plane or are not finite; give a solid "
                    "body, or a box"
                )
        if self.half_spaces and self.link is not None:
            raise RobotError(
                f"scene object '{self.name}' is a plane and cannot be attached to "
                f"'{self.link}'; attach a box"
            )

    @property
    def is_solid(self) -> bool:
        """Whether the body has any shape at all."""
        return bool(self.shapes or self.hulls or self.half_spaces)

    @property
    def mass(self) -> float:
        """The mass of the body where it is not fixed: as given, else assumed [kg]."""
        if self.given_mass is not None:
            return self.given_mass
        volume = sum(shape_volume(shape) for shape in self.shapes)
        for hull in self.hulls:
            spans = np.ptp(np.array(hull.points), axis=0)
            volume += float(np.prod(spans)) / 2
        return min(max(_DENSITY * volume, 1e-3), _HEAVIEST)


def body_name(name: str) -> str:
    """Return what a declared body is called in a model, apart from the names of the robot."""
    return f"declared/{name}"


def add_body(
    spec: Any,
    body: SceneBody,
    parent: Any,
    *,
    contype: int,
    conaffinity: int,
    free: bool = False,
    pose: Pose | None = None,
) -> Any:
    """Add a body under `parent`, at `pose` (its own), and return it."""
    placed = body.pose if pose is None else pose
    meets: dict[str, Any] = {"contype": contype, "conaffinity": conaffinity}
    rubs = (_FRICTION, 0.005, 0.0001)
    added = parent.add_body(
        name=body_name(body.name), pos=placed.position, quat=wxyz(placed.orientation)
    )
    if free:
        added.add_freejoint(name=body_name(body.name))
    geoms = [add_geom(added, shape, **meets, friction=_FRICTION) for shape in body.shapes]
    for index, hull in enumerate(body.hulls):
        mesh = spec.add_mesh(
            name=f"{body_name(body.name)}/{index}",
            uservert=np.array(hull.points, dtype=np.float64).ravel(),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_CONVEX,
        )
        geoms.append(
            added.add_geom(
                type=mujoco.mjtGeom.mjGEOM_MESH, meshname=mesh.name, **meets, friction=rubs
            )
        )
    for ground in body.half_spaces:
        added.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=(0.0, 0.0, 1.0),
            pos=ground.pose.position,
            quat=wxyz(ground.pose.orientation),
            **meets,
            friction=rubs,
        )
    for geom in geoms:
        geom.mass = body.mass / len(geoms)
    return added


def add_weld(spec: Any, name: str, link: str, in_link: Pose) -> None:
    """Weld the free body `name` to a link, where `in_link` says."""
    weld = spec.add_equality(
        name=f"{name}={link}",
        type=mujoco.mjtEq.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=link,
        name2=name,
        solref=_WELD,
        solimp=(0.95, 0.99, 0.001, 0.5, 2.0),
    )
    # Anchor, position and turn of the second body in the first, and the weight of the turn.
    weld.data[:11] = (0.0, 0.0, 0.0, *in_link.position, *wxyz(in_link.orientation), 1.0)


def wxyz(orientation: Sequence[float]) -> tuple[float, float, float, float]:
    """Return a quaternion (x, y, z, w) as MuJoCo orders it."""
    x, y, z, w = orientation
    return w, x, y, z


def _is_solid(hull: Hull) -> bool:
    points = np.array(hull.points, dtype=np.float64)
    if len(points) < 4 or not np.isfinite(points).all():
        return False
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[2] / math.sqrt(len(points)) > _FLAT)
