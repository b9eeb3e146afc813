"""Build the model of a simulation in which a controller has declared bodies.

Declared bodies come last in the model, so that joints, actuators, sensors and objects of the
scene keep their places in every array.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError
from tracerisk.twin.physics.builder import FIXTURE, FREE, OBJECT, ROBOT, build_spec
from tracerisk.twin.physics.declared_log import LoggedShape
from tracerisk.twin.physics.motion import Pose
from tracerisk.twin.physics.scene import Scene
from tracerisk.twin.physics.scene_body import SceneBody, add_body, add_weld, body_name, wxyz
from tracerisk.twin.robots.robot import Robot

import mujoco  # isort: skip

_DEEP = 2e-3  # what overlaps further when it is declared would be blown apart [m]
_NEAR = 0.02  # horizontally between two middles: a body declared where an object stands [m]
_ALIKE = 8.0  # ratio of the bounding volumes of a declared body and the object it stands for


@dataclass(frozen=True, slots=True)
class Declared:
    """The declared bodies of a simulation, and their relation to what was there before."""

    bodies: tuple[SceneBody, ...] = ()
    """All bodies that the controller has declared."""
    stands_for: Mapping[str, str] | None = None
    """The object of the scene that a declared body describes; the object is then the body."""
    apart: frozenset[tuple[str, str]] = frozenset()
    """Pairs of body names that do not collide, since they overlapped when one was declared."""

    def simulated(self, body: SceneBody) -> bool:
        """Return whether a declared body is one of its own."""
        return body.name not in (self.stands_for or {})


def rebuild(
    robot: Robot,
    scene: Scene,
    before: Declared,
    bodies: Sequence[SceneBody],
    model: Any,
    data: Any,
) -> tuple[Declared, Any, Any]:
    """Return what is declared now, with a model and data that go on from `model` and `data`.

    Raises RobotError when MuJoCo refuses the model.
    """
    # Bodies are a step behind the joints until they are computed anew.
    mujoco.mj_kinematics(model, data)
    old = {body.name: body for body in before.bodies}
    fresh = {body.name for body in bodies if old.get(body.name) != body}
    names = {body.name for body in bodies}
    stands_for = {k: v for k, v in (before.stands_for or {}).items() if k in names}
    kept = {body_name(name) for name in names - fresh}
    apart = {pair for pair in before.apart if pair[0] in kept}
    # A free body that is declared anew is put where it is declared; one that is let go stays.
    anew = {
        body.name
        for body in bodies
        if body.name in fresh
        and body.is_free
        and body.link is None
        and (body.name not in old or old[body.name].link is None)
    }
    now = Declared(tuple(bodies), stands_for, frozenset(apart))
    new_model, new_data = _compiled(robot, scene, now, anew, (model, data))
    # Only what is new is looked at: what was there before has found its place.
    overlaps = [
        pair
        for pair in _overlaps(new_model, new_data)
        if pair[0].removeprefix(body_name("")) in fresh
    ]
    objects = {thing.name for thing in scene.objects}
    for declared, other in overlaps:
        name = declared.removeprefix(body_name(""))
        if other in objects and name not in old and _is_same(new_model, new_data, declared, other):
            stands_for.setdefault(name, other)
    # What is free is pushed out of what it overlaps.
    free = {body_name(body.name) for body in bodies if body.is_free and body.link is None}
    apart |= {pair for pair in overlaps if pair[0] not in free}
    now = replace(now, stands_for=stands_for, apart=frozenset(apart))
    if overlaps:
        new_model, new_data = _compiled(robot, scene, now, anew, (model, data))
    return now, new_model, new_data


def logged_bodies(declared: Declared, model: Any, data: Any) -> tuple[LoggedShape, ...]:
    """Return the bodies of their own that are simulated, as they are logged.

    Those that are free come in the order of their poses.
    """
    pairs = []
    for body in declared.bodies:
        if declared.simulated(body):
            here = model.body(body_name(body.name))
            planes = [half_space.pose for half_space in body.half_spaces]
            pose = (*data.xpos[here.id].tolist(), *data.xquat[here.id].tolist())
            logged = LoggedShape(
                name=body.name,
                is_free=bool(here.jntnum[0]),
                pose=pose,
                shapes=body.shapes,
                hulls=tuple(hull.points for hull in body.hulls),
                planes=tuple((*plane.position, *wxyz(plane.orientation)) for plane in planes),
            )
            address = int(model.jnt_qposadr[here.jntadr[0]]) if logged.is_free else 0
            pairs.append((address, logged))
    return tuple(logged for _, logged in sorted(pairs, key=lambda pair: pair[0]))


def _compiled(
    robot: Robot, scene: Scene, declared: Declared, anew: Set[str], old: tuple[Any, Any]
) -> tuple[Any, Any]:
    model, data = old
    spec = build_spec(robot, scene)
    base = spec.worldbody.add_frame(
        pos=model.body(robot.base_link).pos, quat=model.body(robot.base_link).quat
    )
    present: set[str] = set()
    for body in declared.bodies:
        is_own = declared.simulated(body)
        if is_own and body.link is None and not body.is_free:
            added = add_body(
                spec, body, spec.worldbody, contype=FIXTURE, conaffinity=ROBOT | OBJECT
            )
            added.set_frame(base)
        elif is_own:
            add_body(
                spec,
                body,
                spec.worldbody,
                contype=OBJECT | FREE if body.link is None else OBJECT,
                conaffinity=FIXTURE | ROBOT | OBJECT,
                free=True,
                pose=_in_world(data, body, robot.base_link if body.link is None else body.link),
            )
        if is_own:
            present.add(body_name(body.name))
        if body.link is not None:
            held = body_name(body.name) if is_own else (declared.stands_for or {})[body.name]
            in_link = body.pose if is_own else _relative(data, held, body.link)
            add_weld(spec, held, body.link, in_link)
    pads = {pad for gripper in robot.grippers for pad in gripper.pads}
    apart = {pair for pair in declared.apart if pair[0] in present}
    for body in declared.bodies:
        if body.link is not None and body_name(body.name) in present:
            links = set(robot.link_names) & {body.link, *body.touch_links}
            # The fingers go on holding what they hold.
            apart |= {(body_name(body.name), link) for link in links - pads}
    for one, two in sorted(apart):
        spec.add_exclude(bodyname1=one, bodyname2=two)
    try:
        new_model = spec.compile()
    except ValueError as cause:
        raise RobotError(f"the planning scene cannot be simulated: {cause}") from cause
    new_data = mujoco.MjData(new_model)
    _carry_over(robot, scene, declared, anew, old, (new_model, new_data))
    return new_model, new_data


def _carry_over(
    robot: Robot,
    scene: Scene,
    declared: Declared,
    anew: Set[str],
    old: tuple[Any, Any],
    new: tuple[Any, Any],
) -> None:
    """Copy the state of the simulation: joints by name, free bodies by name, time, controls."""
    (old_model, old_data), (new_model, new_data) = old, new
    names = [joint.name for joint in robot.joints] + [thing.name for thing in scene.objects]
    attached = [body_name(body.name) for body in declared.bodies if body.name not in anew]
    had = {old_model.joint(i).name for i in range(old_model.njnt)}
    has = {new_model.joint(i).name for i in range(new_model.njnt)}
    for name in [*names, *(name for name in attached if name in had and name in has)]:
        here, there = old_model.joint(name), new_model.joint(name)
        n_qpos, n_dofs = (7, 6) if here.type[0] == mujoco.mjtJoint.mjJNT_FREE else (1, 1)
        q, p = int(here.qposadr[0]), int(there.qposadr[0])
        v, w = int(here.dofadr[0]), int(there.dofadr[0])
        new_data.qpos[p : p + n_qpos] = old_data.qpos[q : q + n_qpos]
        new_data.qvel[w : w + n_dofs] = old_data.qvel[v : v + n_dofs]
        new_data.qacc_warmstart[w : w + n_dofs] = old_data.qacc_warmstart[v : v + n_dofs]
    new_data.ctrl[:] = old_data.ctrl
    new_data.time = old_data.time
    mujoco.mj_forward(new_model, new_data)


def _overlaps(model: Any, data: Any) -> list[tuple[str, str]]:
    """Return the pairs (declared body, other body) that overlap deeply."""
    prefix = body_name("")
    overlaps: set[tuple[str, str]] = set()
    for index in np.flatnonzero(data.contact.dist[: data.ncon] < -_DEEP):
        one, two = (model.body(model.geom_bodyid[geom]).name for geom in data.contact.geom[index])
        overlaps |= {(a, b) for a, b in ((one, two), (two, one)) if a.startswith(prefix)}
    return sorted(overlaps)


def _is_same(model: Any, data: Any, declared: str, thing: str) -> bool:
    """Return whether a declared body describes an object: of like size, and at the same place."""
    one, two = model.body(declared).id, model.body(thing).id
    away = data.xipos[one][:2] - data.xipos[two][:2]
    ratio = _bounding_volume(model, one) / _bounding_volume(model, two)
    return bool(np.linalg.norm(away) < _NEAR and 1 / _ALIKE < ratio < _ALIKE)


def _bounding_volume(model: Any, body: int) -> float:
    first, count = int(model.body_geomadr[body]), int(model.body_geomnum[body])
    halves: NDArray[np.float64] = model.geom_aabb[first : first + count, 3:]
    return float(np.prod(2 * halves, axis=1).sum())


def _in_world(data: Any, body: SceneBody, frame: str) -> Pose:
    link = data.body(frame)
    position, turn = np.zeros(3), np.zeros(4)
    x, y, z, w = body.pose.orientation
    mujoco.mju_mulPose(
        position, turn, link.xpos, link.xquat, np.array(body.pose.position), np.array([w, x, y, z])
    )
    return Pose.of(position, turn)


def _relative(data: Any, thing: str, link: str) -> Pose:
    """Return where an object is in the frame of a link."""
    back, turn_back = np.zeros(3), np.zeros(4)
    mujoco.mju_negPose(back, turn_back, data.body(link).xpos, data.body(link).xquat)
    position, turn = np.zeros(3), np.zeros(4)
    mujoco.mju_mulPose(
        position, turn, back, turn_back, data.body(thing).xpos, data.body(thing).xquat
    )
    return Pose.of(position, turn)
