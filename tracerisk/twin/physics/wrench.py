"""The force and torque at a link, as a sensor in the wrist measures them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from tracerisk.common.geometry.frames import Triple, triple

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Wrench:
    """A force and a torque about the origin of a link, in the link's axes."""

    force: Triple
    """The force (x, y, z) [N]."""
    torque: Triple
    """The torque (x, y, z) [N m]."""


def load_on(model: Any, data: Any, link: str) -> Wrench:
    """Return what a link, with all that hangs on it, exerts on what holds it.

    That is weight, inertia and contacts: what a sensor between the two measures, without a tare.
    Recursive Newton-Euler after the constraints are solved (MuJoCo's mj_rnePostConstraint).
    """
    mujoco.mj_rnePostConstraint(model, data)
    body = model.body(link).id
    return _wrench(model, data, body, -data.cfrc_int[body])


def touch_on(model: Any, data: Any, link: str, links: Collection[str]) -> Wrench:
    """Return what the world exerts by touch on a link and on all that hangs on its last joint.

    `links` are the names of the robot's links. A wrench that an arm estimates of the torques of
    its joints is this, where it knows the masses of its own tool.
    """
    mujoco.mj_rnePostConstraint(model, data)
    body = model.body(link).id
    first = int(model.body_weldid[body])
    hanging = {first}
    for index in range(first + 1, model.nbody):
        if model.body_parentid[index] in hanging and model.body(index).name in links:
            hanging.add(index)
    return _wrench(model, data, body, data.cfrc_ext[sorted(hanging)].sum(axis=0))


def _wrench(model: Any, data: Any, body: int, spatial: Array) -> Wrench:
    """Return a spatial force, about the centre of mass of the robot's tree, at a body's frame."""
    torque, force = spatial[:3], spatial[3:]
    centre = data.subtree_com[model.body_rootid[body]]
    axes = data.xmat[body].reshape(3, 3)
    about = torque + np.cross(centre - data.xpos[body], force)
    return Wrench(triple(axes.T @ force), triple(axes.T @ about))
