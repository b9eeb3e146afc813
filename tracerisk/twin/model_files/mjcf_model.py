"""A compiled MJCF as data, and the process with limits that compiles it."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tracerisk.common.geometry.frames import matrix_of, roll_pitch_yaw
from tracerisk.common.geometry.shapes import Mesh, Shape
from tracerisk.common.limits import DEFAULT_LIMITS, Limits
from tracerisk.common.sandbox.limited_process import last_words, run_limited
from tracerisk.errors import Location, RobotError
from tracerisk.twin.model_files.mjcf_document import MjcfDocument, error_of_mujoco
from tracerisk.twin.urdf.urdf import placed

_LONGEST_REASON = 200

Data = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class MjcfModel:
    """A compiled model: its parts as the compiling process sends them, in the compiler's order.

    Lengths in [m], angles in [rad], quaternions as (w, x, y, z); bodies and joints are given by
    their index, body 0 is the world.
    """

    name: str
    """The name of the model in its file."""
    bodies: tuple[Data, ...]
    """Name, parent, frame, mass [kg] and inertia [kg m^2] of each body."""
    joints: tuple[Data, ...]
    """Name, body, type, axis, limits, damping and armature of each joint."""
    shapes: tuple[Data, ...]
    """The primitives that collide or are drawn, with body and frame; a mesh as its bounds."""
    sites: tuple[Data, ...]
    """Name, body and frame of each site."""
    actuators: tuple[Data, ...]
    """Name, driven joints with gear, gain, bias and limits of each actuator."""
    couplings: tuple[Data, ...]
    """Joint, leader, offset and factor of each joint that follows another."""
    closed: tuple[int, ...]
    """The bodies on which a kinematic loop closes."""
    excludes: tuple[tuple[int, int], ...]
    """The pairs of bodies that do not collide."""
    keys: tuple[Data, ...]
    """Name and joint positions of each keyframe, (n_qpos,)."""
    without_mesh: frozenset[str]
    """The names of bodies that lost a shape because its mesh is missing."""


def compiled_mjcf(document: MjcfDocument, shown: str, limits: Limits = DEFAULT_LIMITS) -> MjcfModel:
    """Return the compiled model of a document.

    Raises RobotError when MuJoCo refuses it, LimitError when compiling it takes too long or too
    much memory.
    """
    answer = _asked(
        {
            "text": document.text,
            "meshes": {name: str(path) for name, path in document.meshes.items()},
            "missing": list(document.missing),
        },
        shown,
        limits,
    )
    if "error" in answer:
        raise error_of_mujoco(answer["error"], document, shown)
    return MjcfModel(
        **{
            **{key: tuple(value) for key, value in answer.items() if isinstance(value, list)},
            "name": answer["name"],
            "excludes": tuple((one, other) for one, other in answer["excludes"]),
            "without_mesh": frozenset(answer["without_mesh"]),
        }
    )


def mesh_shapes(
    meshes: Mapping[str, tuple[Path, tuple[float, float, float]]],
    shown: str,
    limits: Limits = DEFAULT_LIMITS,
) -> dict[str, Shape]:
    """Return what bounds each mesh, given as file and scale, in the mesh's own frame.

    Meshes that cannot be read are left out. Raises LimitError as `compiled_mjcf`.
    """
    if not meshes:
        return {}
    answer = _asked(
        {
            "text": None,
            "meshes": {name: str(path) for name, (path, _) in meshes.items()},
            "scales": {name: scale for name, (_, scale) in meshes.items()},
        },
        shown,
        limits,
    )
    return {name: shape_of(geom) for name, geom in answer.items() if geom is not None}


def shape_of(geom: Data) -> Shape:
    """Return a geom as a shape in the frame of its body."""
    data = geom["shape"]
    size = tuple(float(item) for item in data["size"])
    zero = (0.0, 0.0, 0.0)
    if data["kind"] == "ellipsoid":
        shape = _around_ellipsoid(size)
    else:
        shape = Shape(
            data["kind"],
            size,
            tuple(data.get("xyz", zero)),
            tuple(data.get("rpy", zero)),
            mesh=Mesh(data["mesh"], geom["paint"]) if data.get("mesh") else None,
        )
    x, y, z = geom["pos"]
    return placed(shape, (x, y, z), roll_pitch_yaw(matrix_of(geom["quat"])))


def _around_ellipsoid(radii: tuple[float, ...]) -> Shape:
    """Return the capsule along the longest radius that holds the ellipsoid."""
    longest = max(range(3), key=lambda i: radii[i])
    wide = sorted(radii)[1]
    turn = {0: (0.0, 1.5707963267948966, 0.0), 1: (1.5707963267948966, 0.0, 0.0)}
    return Shape(
        "capsule",
        (wide, max(radii[longest] - wide, 1e-4)),
        rpy=turn.get(longest, (0.0, 0.0, 0.0)),
    )


def _asked(request: Mapping[str, Any], shown: str, limits: Limits) -> Any:
    where = Location(shown)
    with tempfile.TemporaryDirectory() as empty:
        done = run_limited(
            "tracerisk.twin.model_files.child",
            request=json.dumps(request).encode(),
            limits=limits,
            doing="compiling the model",
            place=where,
            folder=Path(empty),
            reads=[Path(item) for item in request["meshes"].values()],
        )
    if done.returncode != 0:
        reason = last_words(done)
        raise RobotError(f"the model cannot be compiled: {reason[:_LONGEST_REASON]}", where)
    return json.loads(done.stdout)
