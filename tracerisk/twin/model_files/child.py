"""Compile one model, in a process of its own: `python -m tracerisk.twin.model_files.child`.

On standard input comes JSON: `text`, an MJCF document that names no file (`null` for meshes
alone), `meshes`, the files of its meshes by their names in it, and `missing`, the names of meshes
without a file; for meshes alone `scales`. JSON goes to standard output: see `mjcf_model`.
A model may be made to take all memory or time, or to break the compiler: so the process has
limits, and nothing that it writes is kept.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
from dataclasses import asdict
from typing import Any

from tracerisk.common.geometry.frames import rotation
from tracerisk.common.sandbox.limited_process import end_with, limit_memory, mark_start
from tracerisk.common.text.bounded import MOST_WRITTEN, NoFileError, file_bytes
from tracerisk.twin.model_files.bounds import bounding_shape
from tracerisk.twin.model_files.coarse import MOST_FACES, coarsened, most_faces, packed

_MOST = {"bodies": 500, "joints": 300, "geoms": 5000, "actuators": 300}


def main() -> int:
    """Compile what standard input holds."""
    _limit()
    asked = json.load(sys.stdin)
    # MuJoCo must not look for a display.
    os.environ["MUJOCO_GL"] = "disable"
    import mujoco  # noqa: F401 - importing it is no part of the work

    mark_start()
    try:
        meshes = {name: file_bytes(path, MOST_WRITTEN) for name, path in asked["meshes"].items()}
    except NoFileError as error:
        sys.exit(str(error))
    answer: dict[str, Any]
    if asked["text"] is None:
        most = most_faces(len(meshes))
        answer = {
            name: _shape_of(name, data, asked["scales"], most) for name, data in meshes.items()
        }
    else:
        try:
            answer = _model(asked["text"], meshes, asked["missing"])
        except ValueError as error:
            answer = {"error": str(error)}
    json.dump(answer, sys.stdout)
    return 0


def _limit() -> None:
    limit_memory()
    # MuJoCo logs its warnings into a file of the working folder.
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))


def _model(text: str, meshes: dict[str, bytes], missing: list[str]) -> dict[str, Any]:
    try:
        return _compiled(text, meshes, set(missing))
    except ValueError:
        if not meshes:
            raise
    # A mesh that the compiler refuses is none of the model's faults: capsules stand for it.
    import mujoco

    spec = mujoco.MjSpec.from_string(text)
    return _compiled(text, {}, {mesh.name for mesh in spec.meshes})


def _compiled(text: str, meshes: dict[str, bytes], missing: set[str]) -> dict[str, Any]:
    import mujoco

    spec = mujoco.MjSpec.from_string(text, assets=meshes)
    for kind, most in _MOST.items():
        count = len(getattr(spec, kind))
        if count > most:
            raise ValueError(f"the model has {count} {kind}; at most {most} are read")
    without = sorted({geom.parent.name for geom in spec.geoms if geom.meshname in missing})
    if missing:
        for pair in list(spec.pairs):
            spec.delete(pair)
        for geom in list(spec.geoms):
            if geom.meshname in missing:
                spec.delete(geom)
        for mesh in list(spec.meshes):
            if mesh.name in missing:
                spec.delete(mesh)
    compiler = spec.compiler
    compiler.fusestatic = False
    compiler.discardvisual = False
    compiler.balanceinertia = True
    if missing and compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE:
        compiler.inertiafromgeom = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO
    # A link between two joints may weigh nothing: what it weighs is assumed later.
    compiler.boundmass = max(float(compiler.boundmass), 1e-9)
    compiler.boundinertia = max(float(compiler.boundinertia), 1e-12)
    return {**_described(spec.compile()), "without_mesh": without}


def _described(model: Any) -> dict[str, Any]:
    import mujoco

    def name(kind: Any, index: int) -> str:
        return mujoco.mj_id2name(model, kind, index) or ""

    def figures(kind: str, index: int, *fields: str) -> dict[str, Any]:
        return {field: getattr(model, f"{kind}_{field}")[index].tolist() for field in fields}

    body, joint = mujoco.mjtObj.mjOBJ_BODY, mujoco.mjtObj.mjOBJ_JOINT
    return {
        "name": str(model.names[: model.names.find(b"\0")].decode(errors="replace")),
        "bodies": [
            {
                "name": name(body, i),
                "parent": int(model.body_parentid[i]),
                **figures("body", i, "pos", "quat", "mass", "ipos", "iquat", "inertia"),
            }
            for i in range(model.nbody)
        ],
        "joints": [
            {
                "name": name(joint, i),
                "body": int(model.jnt_bodyid[i]),
                **figures("jnt", i, "type", "pos", "axis", "stiffness"),
                "range": model.jnt_range[i].tolist() if model.jnt_limited[i] else None,
                "force": model.jnt_actfrcrange[i].tolist() if model.jnt_actfrclimited[i] else None,
                "armature": float(model.dof_armature[model.jnt_dofadr[i]]),
                "damping": float(model.dof_damping[model.jnt_dofadr[i]]),
                "ref": float(model.qpos0[model.jnt_qposadr[i]]),
                "qpos": int(model.jnt_qposadr[i]),
            }
            for i in range(model.njnt)
        ],
        "shapes": _shapes(model, most_faces(int(model.nmesh))),
        "sites": [
            {
                "name": name(mujoco.mjtObj.mjOBJ_SITE, i),
                "body": int(model.site_bodyid[i]),
                **figures("site", i, "pos", "quat"),
            }
            for i in range(model.nsite)
        ],
        "actuators": [_actuator(model, i) for i in range(model.nu)],
        "couplings": _couplings(model),
        "closed": _closed(model),
        "excludes": [
            [int(signature) >> 16, int(signature) & 0xFFFF] for signature in model.exclude_signature
        ],
        "keys": [
            {"name": name(mujoco.mjtObj.mjOBJ_KEY, i), "qpos": model.key_qpos[i].tolist()}
            for i in range(model.nkey)
        ],
    }


def _shapes(model: Any, most: int) -> list[dict[str, Any]]:
    """Return the geoms as primitives; planes and height fields are no part of a robot.

    A mesh is bounded by its primitive, and drawn with at most `most` faces.
    """
    import mujoco  # isort: skip

    kinds = {
        int(mujoco.mjtGeom.mjGEOM_BOX): ("box", 3),
        int(mujoco.mjtGeom.mjGEOM_SPHERE): ("sphere", 1),
        int(mujoco.mjtGeom.mjGEOM_CAPSULE): ("capsule", 2),
        int(mujoco.mjtGeom.mjGEOM_CYLINDER): ("cylinder", 2),
        int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): ("ellipsoid", 3),
    }
    shapes = []
    bounds: dict[int, dict[str, Any]] = {}
    for i in range(model.ngeom):
        kind = int(model.geom_type[i])
        shape: dict[str, Any]
        if kind == int(mujoco.mjtGeom.mjGEOM_MESH):
            mesh = int(model.geom_dataid[i])
            if mesh not in bounds:
                first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
                vertices = model.mesh_vert[first : first + count]
                bound = bounding_shape(vertices)
                first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
                faces = model.mesh_face[first : first + count]
                bounds[mesh] = asdict(bound) | {"mesh": _drawn(bound, vertices, faces, most)}
            shape = bounds[mesh]
        elif kind in kinds:
            name, length = kinds[kind]
            shape = {"kind": name, "size": model.geom_size[i, :length].tolist()}
        else:
            continue
        shapes.append(
            {
                "body": int(model.geom_bodyid[i]),
                "pos": model.geom_pos[i].tolist(),
                "quat": model.geom_quat[i].tolist(),
                "meets": bool(model.geom_contype[i] or model.geom_conaffinity[i]),
                "is_mesh": kind not in kinds,
                "paint": _paint(model, i),
                "shape": shape,
            }
        )
    return shapes


def _drawn(bound: Any, vertices: Any, faces: Any, most: int) -> str:
    """Return a mesh in the frame of the primitive that bounds it, coarse and packed."""
    inside = (vertices.astype(float) - bound.xyz) @ rotation(bound.rpy)
    return packed(*coarsened(inside, faces.astype(int), most))


def _paint(model: Any, geom: int) -> str:
    """Return the colour of a geom as `#rrggbb`."""
    material = int(model.geom_matid[geom])
    rgba = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return "#" + "".join(f"{round(255 * min(max(float(part), 0.0), 1.0)):02x}" for part in rgba[:3])


def _actuator(model: Any, i: int) -> dict[str, Any]:
    import mujoco

    transmission = int(model.actuator_trntype[i])
    target = int(model.actuator_trnid[i, 0])
    gear = float(model.actuator_gear[i, 0])
    joints: list[list[float]] = []
    if transmission in (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT)):
        joints = [[target, gear]]
    elif transmission == int(mujoco.mjtTrn.mjTRN_TENDON):
        first, count = int(model.tendon_adr[target]), int(model.tendon_num[target])
        joints = [
            [int(model.wrap_objid[w]), gear * float(model.wrap_prm[w])]
            for w in range(first, first + count)
            if int(model.wrap_type[w]) == int(mujoco.mjtWrap.mjWRAP_JOINT)
        ]
    is_fixed = int(model.actuator_gaintype[i]) == int(mujoco.mjtGain.mjGAIN_FIXED)
    is_affine = int(model.actuator_biastype[i]) == int(mujoco.mjtBias.mjBIAS_AFFINE)
    limit = model.actuator_forcerange[i].tolist() if model.actuator_forcelimited[i] else None
    control = model.actuator_ctrlrange[i].tolist() if model.actuator_ctrllimited[i] else None
    bias = model.actuator_biasprm[i, :3].tolist() if is_affine else [0.0, 0.0, 0.0]
    return {
        "name": mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) or "",
        "joints": joints,
        "gain": float(model.actuator_gainprm[i, 0]) if is_fixed else 0.0,
        "bias": bias,
        "force": limit,
        "control": control,
    }


def _couplings(model: Any) -> list[dict[str, Any]]:
    """Return the joints that follow another one: joint = offset + factor * leader."""
    import mujoco

    return [
        {
            "joint": int(model.eq_obj1id[i]),
            "leader": int(model.eq_obj2id[i]),
            "offset": float(model.eq_data[i, 0]),
            "factor": float(model.eq_data[i, 1]),
        }
        for i in range(model.neq)
        if int(model.eq_type[i]) == int(mujoco.mjtEq.mjEQ_JOINT) and int(model.eq_obj2id[i]) >= 0
    ]


def _closed(model: Any) -> list[int]:
    """Return the bodies that a loop closes on."""
    import mujoco

    kinds = (int(mujoco.mjtEq.mjEQ_CONNECT), int(mujoco.mjtEq.mjEQ_WELD))
    is_body = int(mujoco.mjtObj.mjOBJ_BODY)
    numbers: set[int] = set()
    for i in range(model.neq):
        if int(model.eq_type[i]) in kinds:
            is_bodies = int(model.eq_objtype[i]) == is_body
            for index in (int(model.eq_obj1id[i]), int(model.eq_obj2id[i])):
                numbers.add(index if is_bodies else int(model.site_bodyid[index]))
    return sorted(numbers)


def _shape_of(
    name: str, data: bytes, scales: dict[str, list[float]], most: int = MOST_FACES
) -> dict[str, Any] | None:
    """Return what bounds one mesh, in its own frame, `None` for one that is refused."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.assets = {name: data}
    mesh = spec.add_mesh(name="mesh", file=name)
    mesh.scale = scales[name]
    mesh.inertia = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname="mesh")
    try:
        model = spec.compile()
    except ValueError:
        return None
    shapes = _shapes(model, most)
    return shapes[0] | {"paint": ""} if shapes else None


if __name__ == "__main__":
    end_with(main)
