"""The solver itself, as the library's own module `trac_ik` uses it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import PyKDL as kdl
from kdl_parser_py._model import model_of
from kdl_parser_py.urdf import treeFromUrdfModel
from numpy.typing import NDArray

__all__ = ["TRAC_IK"]

_ENDLESS = float(np.finfo(np.float32).max)  # the limit of a joint without an end
_RESTARTS = 24
_STEPS = 40
_COMPARED = 4  # of what random starts lead to
_LONGEST = 1.0  # step of a joint [rad], [m]
_LOOSE = 0.01  # a miss that may be greater is left out of the steps [m], [rad]


class TRAC_IK:
    """The inverse kinematics of the chain from `base_link` to `tip_link` of a URDF.

    `timeout` and `solve_type` change nothing: the search has a bounded number of steps and begins
    at the positions given. Where these lead to none, the nearest to them is returned of the first
    few that other starts lead to, the same at every call.

    Raises:
        ValueError: the URDF has no such chain.
    """

    def __init__(
        self,
        base_link: str,
        tip_link: str,
        urdf_string: str,
        timeout: float,
        epsilon: float,
        solve_type: str = "Speed",
    ) -> None:
        model = model_of(urdf_string)
        missing = [name for name in (base_link, tip_link) if name not in model.link_map]
        if missing:
            raise ValueError(
                f"the URDF has no link '{missing[0]}'; it has {', '.join(model.link_map)}"
            )
        self._epsilon = epsilon
        self._chain = treeFromUrdfModel(model, quiet=True)[1].getChain(base_link, tip_link)
        self._segments = [self._chain.getSegment(i) for i in range(self._chain.getNrOfSegments())]
        joints = {item.name: item for item in model.joints}
        moving = [joints[name] for name in self.getJointNamesInChain(urdf_string)]
        limits = [_limits(joint) for joint in moving]
        self._lower, self._upper = np.array(limits, dtype=np.float64).reshape(-1, 2).T
        self._turns = np.array([joint.type != "prismatic" for joint in moving], dtype=bool)
        self._forward = kdl.ChainFkSolverPos_recursive(self._chain)
        self._jacobian = kdl.ChainJntToJacSolver(self._chain)

    def getNrOfJointsInChain(self) -> int:
        """Return the number of joints that move."""
        return int(self._chain.getNrOfJoints())

    def getJointNamesInChain(self, urdf_string: str) -> tuple[str, ...]:
        """Return the names of the joints that move."""
        joints = (segment.getJoint() for segment in self._segments)
        return tuple(joint.getName() for joint in joints if joint.getType() != kdl.Joint.Fixed)

    def getLinkNamesInChain(self) -> tuple[str, ...]:
        """Return the names of the links, without `base_link`."""
        return tuple(segment.getName() for segment in self._segments)

    def getLowerBoundLimits(self) -> tuple[float, ...]:
        """Return the lower limits [rad, m]."""
        return tuple(self._lower.tolist())

    def getUpperBoundLimits(self) -> tuple[float, ...]:
        """Return the upper limits [rad, m]."""
        return tuple(self._upper.tolist())

    def setKDLLimits(self, lower: Sequence[float], upper: Sequence[float]) -> None:
        """Set the limits [rad, m]."""
        self._lower, self._upper = (np.array(values, dtype=np.float64) for values in (lower, upper))

    def CartToJnt(
        self,
        qinit: Sequence[float],
        x: float,
        y: float,
        z: float,
        rx: float,
        ry: float,
        rz: float,
        rw: float,
        bx: float = 1e-5,
        by: float = 1e-5,
        bz: float = 1e-5,
        brx: float = 1e-3,
        bry: float = 1e-3,
        brz: float = 1e-3,
    ) -> tuple[float, ...]:
        """Return positions that bring the tip to a pose; nothing where none are found.

        qinit: where the search begins [rad, m]. bx ... brz: how far the tip may be from the pose,
        along and about the axes of the pose [m, rad].
        """
        goal = kdl.Frame(kdl.Rotation.Quaternion(rx, ry, rz, rw), kdl.Vector(x, y, z))
        bounds = np.abs(np.array((bx, by, bz, brx, bry, brz)))
        seed = np.clip(np.array(qinit, dtype=np.float64), self._lower, self._upper)
        generator = np.random.default_rng(0)
        lower = np.where(self._lower > -_ENDLESS, self._lower, seed - math.pi)
        upper = np.where(self._upper < _ENDLESS, self._upper, seed + math.pi)
        search = self._search(seed, goal, bounds)
        if search is not None:
            return tuple(self._nearest(search, seed).tolist())
        others: list[NDArray[np.float64]] = []
        for _ in range(_RESTARTS):
            search = self._search(generator.uniform(lower, upper), goal, bounds)
            if search is not None:
                others.append(self._nearest(search, seed))
            if len(others) == _COMPARED:
                break
        others.sort(key=lambda other: float(np.linalg.norm(other - seed)))
        return tuple(others[0].tolist()) if others else ()

    def _search(
        self, start: NDArray[np.float64], goal: Any, bounds: NDArray[np.float64]
    ) -> NDArray[np.float64] | None:
        count = len(start)
        q, here, jacobian = kdl.JntArray(count), kdl.Frame(), kdl.Jacobian(count)
        positions = start
        for _ in range(_STEPS):
            for place, value in enumerate(positions):
                q[place] = value
            self._forward.JntToCart(q, here)
            # Seen along the axes of the pose, to which the bounds belong.
            miss = np.array([*goal.M.Inverse(kdl.diff(here, goal))])
            near = np.abs(miss) <= np.maximum(bounds, self._epsilon)
            if near.all():
                return positions
            self._jacobian.JntToJac(q, jacobian)
            jacobian.changeBase(goal.M.Inverse())
            asked = ~(near & (bounds > _LOOSE))
            columns = np.array([[*jacobian.getColumn(place)] for place in range(count)])
            step = np.linalg.lstsq(columns.T[asked], miss[asked], rcond=1e-5)[0]
            step /= max(1.0, float(np.abs(step).max()) / _LONGEST)
            positions = np.clip(positions + step, self._lower, self._upper)
        return None

    def _nearest(
        self, found: NDArray[np.float64], seed: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return the positions whole turns away that are nearest to the seed, within limits."""
        turned = seed + np.remainder(found - seed + math.pi, 2 * math.pi) - math.pi
        can = self._turns & (turned >= self._lower) & (turned <= self._upper)
        return np.where(can, turned, found)


def _limits(joint: Any) -> tuple[float, float]:
    if joint.type == "continuous" or joint.limit is None:
        return -_ENDLESS, _ENDLESS
    return joint.limit.lower, joint.limit.upper
