"""Whether the arm touches itself or what a controller has declared, at given joint positions.

It knows what MoveIt's planning scene would: the robot and the declared bodies, never the twin's
own scene. Pairs of links that touch by build are no collision: neighbours, the fingers of one
gripper, those that the robot's SRDF disables, and those that touch at a named state, for the
primitive shapes overstate the links.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from tracerisk.errors import RobotError, one_of
from tracerisk.twin.physics.builder import build_spec
from tracerisk.twin.physics.scene_body import SceneBody, add_body, body_name
from tracerisk.twin.robots.robot import Robot

import mujoco  # isort: skip

_TOUCH = 1e-3  # bodies that overlap less than this touch, they do not collide [m]
CLEAR = 5e-3  # what a way around a declared body keeps from it, where it can [m]
_OVERSTATED = 0.03  # by which two links may overlap: their primitive shapes are thicker [m]
_LINK, _BODY = 1, 2  # collision classes: links meet one another and bodies, bodies meet links

Pair = frozenset[str]


class CollisionWorld:
    """The robot among declared bodies; answers are the same for the same arguments.

    `allowed` are pairs of names (links or bodies) that may touch beside those that do by build;
    a set of one name allows it to touch anything.
    Raises RobotError for a body on a link that the robot does not have.
    """

    def __init__(
        self,
        robot: Robot,
        bodies: Sequence[SceneBody] = (),
        allowed: Iterable[Pair] = (),
        *,
        by_build: frozenset[Pair] | None = None,
    ) -> None:
        self._robot = robot
        allowed = frozenset(allowed)
        self.declared = (tuple(bodies), allowed)
        """The bodies, and the pairs that may touch, as they were given."""
        self.has_bodies = bool(bodies)
        touch = {
            frozenset((body.name, link))
            for body in bodies
            if body.link is not None
            for link in (*body.touch_links, body.link)
        }
        self._model = self._compiled(bodies, by_build or frozenset())
        self._data = mujoco.MjData(self._model)
        # With no other bodies all that overlaps are links, whose shapes overstate them.
        self._least_depth = _TOUCH if bodies else _OVERSTATED
        names = {body_name(body.name): body.name for body in bodies}
        self._names = [
            names.get(self._model.body(i).name, self._model.body(i).name)
            for i in range(self._model.nbody)
        ]
        links = set(robot.link_names)
        self._is_link = [self._model.body(i).name in links for i in range(self._model.nbody)]
        self._body_of = np.array(self._model.geom_bodyid)
        self._address = {
            joint.name: int(self._model.joint(joint.name).qposadr[0]) for joint in robot.joints
        }
        self._allowed: frozenset[Pair] = frozenset()
        self._depths: dict[float, NDArray[np.float64]] = {}
        self.by_build = self._touching_by_build() if by_build is None else by_build
        self._allowed = allowed | self.by_build | touch

    def columns(self, joints: Sequence[str]) -> NDArray[np.int64]:
        """Return where the joints stand in a configuration."""
        return np.array([self._address[name] for name in joints])

    def configuration(self, positions: Mapping[str, float]) -> NDArray[np.float64]:
        """Return the configuration for joint positions; joints left out are at rest."""
        qpos = np.zeros(self._model.nq)
        for name, value in {**self._robot.initial_state, **positions}.items():
            qpos[self._address[name]] = value
        return qpos

    def pairs(
        self, configuration: NDArray[np.float64], *, clear: float = 0.0
    ) -> list[tuple[str, str]]:
        """Return the names of what collides, pair by pair; configuration: (n_joints,).

        With `clear` a declared body collides with what is nearer to it [m], `CLEAR` at most.
        """
        self._data.qpos[:] = configuration
        mujoco.mj_kinematics(self._model, self._data)
        mujoco.mj_collision(self._model, self._data)
        count = self._data.ncon
        if not count:
            return []
        depth = -self._data.contact.dist[:count]
        result: list[tuple[str, str]] = []
        for index in np.flatnonzero(depth >= (-clear if clear else self._least_depth)):
            one, two = self._body_of[self._data.contact.geom[index]]
            if self._is_link[one] and self._is_link[two] and depth[index] < _OVERSTATED:
                continue
            pair = (self._names[one], self._names[two])
            if pair not in result and not self._may_touch(pair):
                result.append(pair)
        return result

    def depths(
        self, *, clear: float = 0.0, passing: frozenset[Pair] = frozenset()
    ) -> NDArray[np.float64]:
        """Return from which overlap on two bodies collide [m]: (n_bodies, n_bodies), by number.

        It is infinite for those that may touch and for the pairs `passing`; `clear` as in `pairs`.
        """
        if clear not in self._depths:
            self._depths[clear] = self._depths_of(clear)
        copy: NDArray[np.float64] = self._depths[clear].copy()
        for pair in passing:
            numbers = [i for i, name in enumerate(self._names) if name in pair]
            copy[np.ix_(numbers, numbers)] = np.inf
        return copy

    def _depths_of(self, clear: float) -> NDArray[np.float64]:
        is_link = np.array(self._is_link)
        depths: NDArray[np.float64] = np.full(
            (len(is_link), len(is_link)), -clear if clear else self._least_depth
        )
        depths[np.ix_(is_link, is_link)] = _OVERSTATED
        for i, one in enumerate(self._names):
            for j, two in enumerate(self._names[: i + 1]):
                if self._may_touch((one, two)):
                    depths[i, j] = depths[j, i] = np.inf
        return depths

    def touches(self, configuration: NDArray[np.float64], depths: NDArray[np.float64]) -> bool:
        """Return whether anything collides; `depths` are those of `depths`, for many looks."""
        data = self._data
        data.qpos[:] = configuration
        mujoco.mj_kinematics(self._model, data)
        mujoco.mj_collision(self._model, data)
        if not data.ncon:
            return False
        contact = data.contact
        bodies = self._body_of[contact.geom]
        return bool((contact.dist <= -depths[bodies[:, 0], bodies[:, 1]]).any())

    def touching_links(self, configuration: NDArray[np.float64]) -> frozenset[Pair]:
        """Return the pairs of links, and of no other bodies, that collide."""
        links = self._robot.link_names
        return frozenset(
            frozenset(pair) for pair in self.pairs(configuration) if set(pair) <= set(links)
        )

    def _may_touch(self, pair: tuple[str, str]) -> bool:
        return any(
            allowed in self._allowed for allowed in map(frozenset, (pair, pair[:1], pair[1:]))
        )

    def _compiled(self, bodies: Sequence[SceneBody], by_build: frozenset[Pair]) -> mujoco.MjModel:
        spec = build_spec(self._robot)
        spec.option.enableflags = 0
        for geom in spec.geoms:
            if geom.contype:
                geom.contype, geom.conaffinity = _LINK, _LINK | _BODY
        links = set(self._robot.link_names)
        # Left out before they are looked at: an SRDF disables most pairs. MuJoCo itself leaves out
        # neighbours, but for those of a link that stands on the ground.
        disabled = {frozenset(pair) for pair in self._robot.disabled_collisions} | by_build
        disabled |= {frozenset((hung.parent, hung.child)) for hung in self._robot.attachments}
        for pair in sorted(sorted(pair) for pair in disabled):
            if len(pair) == 2 and links.issuperset(pair):
                spec.add_exclude(bodyname1=pair[0], bodyname2=pair[1])
        for body in bodies:
            parent = spec.worldbody if body.link is None else spec.body(body.link)
            if parent is None:
                raise RobotError(
                    f"robot '{self._robot.name}' has no link '{body.link}'; "
                    f"{one_of(self._robot.link_names, body.link or '')}"
                )
            # An attached body meets the links and what stands in the world.
            kind, meets = (_BODY, _LINK) if body.link is None else (_LINK, _LINK | _BODY)
            added = add_body(spec, body, parent, contype=kind, conaffinity=meets)
            if body.link is not None:
                # MuJoCo leaves out what neighbours in the tree do; by a joint of its own, which
                # stays at 0, a body is a neighbour of its link alone, and not of its fingers.
                added.add_joint(type=mujoco.mjtJoint.mjJNT_SLIDE, name=f"{added.name}/held")
            for geom in added.geoms:
                geom.margin = CLEAR
        try:
            return spec.compile()
        except ValueError as cause:
            if "allocate memory" in str(cause):
                raise MemoryError(str(cause)) from cause
            raise RobotError(f"the planning scene cannot be built: {cause}") from cause

    def _touching_by_build(self) -> frozenset[Pair]:
        states: list[Mapping[str, float]] = [{}]
        for named in self._robot.named_states.values():
            states += named.values()
        by_build = {frozenset(pair) for pair in self._robot.disabled_collisions}
        for state in states:
            by_build |= self.touching_links(self.configuration(state))
        for gripper in self._robot.grippers:
            moved = [
                one.child for one in self._robot.attachments if one.name in gripper.joints
            ] + list(gripper.pads)
            by_build |= {frozenset((a, b)) for a in moved for b in moved if a != b}
        return frozenset(by_build)
