"""Solvers of chains: where the tip is, how it moves, and which positions bring it where.

A solver returns 0, a negative code where it fails, or a positive one for half a success.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from tracerisk.common.geometry import frames
from tracerisk.ros.imports.exported import defined as _defined

from ._chain import Chain, JointType, Segment
from ._frames import Frame, FrameVel, diff
from ._joints import Jacobian, JntArray, JntArrayVel, JntSpaceInertiaMatrix
from ._values import Array, Twist, Vector, Wrench, reader

_NOT_CONVERGED, _SIZES, _TOO_MANY, _OUT_OF_RANGE, _FAILED = -1, -4, -5, -6, -100
_SINGULAR = 100
_WORDS = {
    0: "No error",
    1: "Converged but degraded solution",
    -1: "Failed to converge",
    -2: "Undefined value",
    -3: "Internal data structures not up to date with Chain",
    -4: "The size of the input does not match the internal state",
    -5: "The maximum number of iterations is exceeded",
    -6: "The requested index is out of range",
    -7: "Not implemented",
    -8: "SVD failed",
}


class SolverI:
    """What all solvers have: a chain, and the code of the last call."""

    def __init__(self, chain: Chain) -> None:
        self._chain = chain
        self._code = 0

    def _ended(self, code: int) -> int:
        self._code = code
        return code

    def _fits(self, *arrays: Any) -> bool:
        joints = self._chain.getNrOfJoints()
        return all(array._v.shape[-1] == joints for array in arrays)

    def _moved(self, q: Array) -> Iterator[tuple[Segment, float, int | None]]:
        """Yield each segment with its joint's position and place, none of a fixed one."""
        place = 0
        for segment in self._chain._segments:
            if segment._joint._type is JointType.Fixed:
                yield segment, 0.0, None
            else:
                yield segment, float(q[place]), place
                place += 1

    def _walk(self, q: Array, count: int = -1) -> tuple[Frame, Array]:
        """Return the frame behind `count` segments, all for -1, and its Jacobian (6, joints)."""
        # In arrays, for the solvers that search do this at every step.
        frame, jacobian, levers = np.eye(3, 4), np.zeros((6, len(q))), np.zeros((3, len(q)))
        for number, (segment, value, place) in enumerate(self._moved(q)):
            if number == count:
                break
            joint, tip = segment._joint, segment._tip._v
            turn, at = frame[:, :3], frame[:, 3]
            if place is not None:
                at = at + turn @ joint._origin._v
                axis = turn @ joint._axis._v
                jacobian[slice(3, 6) if joint._turns else slice(3), place] = axis * joint._scale
                levers[:, place] = at
                if joint._turns:
                    turn = turn @ joint._turn(value)
                else:
                    at = at + axis * (joint._scale * value + joint._offset)
            frame = turn @ tip
            frame[:, 3] += at
        # Joints behind the last segment turn nothing, whatever their levers.
        levers = frame[:, 3:] - levers
        jacobian[:3] += np.cross(jacobian[3:], levers, axis=0)
        return Frame._of(frame), jacobian

    getError = reader("_code", "Return the code of the last call.")

    def strError(self, error: int) -> str:
        """Return what a code means."""
        return _WORDS.get(error, "UNKNOWN ERROR")

    def updateInternalDataStructures(self) -> None:
        """Do nothing: the chain is read at each call."""


class ChainFkSolverPos_recursive(SolverI):
    """Positions of the joints to the frame of the tip."""

    def JntToCart(self, q_in: JntArray, p_out: Frame, segmentNr: int = -1) -> int:
        """Write the frame behind `segmentNr` segments, all for -1."""
        return self._ended(_forward(self, q_in, p_out, segmentNr))


class ChainFkSolverVel_recursive(SolverI):
    """Positions and velocities of the joints to the frame of the tip and its twist."""

    def JntToCart(self, q_in: JntArrayVel, p_out: FrameVel, segmentNr: int = -1) -> int:
        """Write the frame and the twist behind `segmentNr` segments, all for -1."""
        if not self._fits(q_in.qdot):
            return self._ended(_SIZES)
        code = _forward(self, q_in.q, p_out._frame, segmentNr)
        if code == 0:
            p_out._twist._v[:] = self._walk(q_in.q._v, segmentNr)[1] @ q_in.qdot._v
        return self._ended(code)


class ChainJntToJacSolver(SolverI):
    """Positions of the joints to the Jacobian of the tip, in the axes of the chain's root."""

    def JntToJac(self, q_in: JntArray, jac: Jacobian, seg_nr: int = -1) -> int:
        """Write the Jacobian behind `seg_nr` segments, all for -1."""
        if not self._fits(q_in, jac):
            return self._ended(_SIZES)
        if seg_nr > self._chain.getNrOfSegments():
            return self._ended(_OUT_OF_RANGE)
        jac._v[:] = self._walk(q_in._v, seg_nr)[1]
        return self._ended(0)


class ChainIkSolverVel_pinv(SolverI):
    """A twist of the tip to velocities of the joints, of least squares where there are many."""

    def __init__(self, chain: Chain, eps: float = 1e-5, maxiter: int = 150) -> None:
        super().__init__(chain)
        self._eps = eps

    def CartToJnt(self, q_in: JntArray, v_in: Twist, qdot_out: JntArray) -> int:
        """Write velocities; the code is 100 where the arm is singular."""
        if not self._fits(q_in, qdot_out):
            return self._ended(_SIZES)
        left, sizes, right = np.linalg.svd(self._walk(q_in._v)[1], full_matrices=False)
        kept = sizes >= self._eps
        qdot_out._v[:] = (right[kept].T / sizes[kept]) @ (left[:, kept].T @ v_in._v)
        return self._ended(0 if kept.all() else _SINGULAR)


class ChainIkSolverPos_NR_JL(SolverI):
    """A frame of the tip to positions of the joints within limits: Newton and Raphson's steps."""

    def __init__(
        self,
        chain: Chain,
        q_min: JntArray,
        q_max: JntArray,
        fksolver: ChainFkSolverPos_recursive,
        iksolver: ChainIkSolverVel_pinv,
        maxiter: int = 100,
        eps: float = 1e-6,
    ) -> None:
        super().__init__(chain)
        self._lower, self._upper = JntArray(q_min), JntArray(q_max)
        self._forward, self._inverse = fksolver, iksolver
        self._most, self._eps = maxiter, eps

    def CartToJnt(self, q_init: JntArray, p_in: Frame, q_out: JntArray) -> int:
        """Write positions, sought from `q_init`; the code is -5 where none are found."""
        if not self._fits(q_init, q_out, self._lower, self._upper):
            return self._ended(_SIZES)
        here, step = Frame(), JntArray(q_init.rows())
        q_out._v[:] = q_init._v
        for _ in range(self._most):
            self._forward.JntToCart(q_out, here)
            miss = diff(here, p_in)
            if np.all(np.abs(miss._v) < self._eps):
                return self._ended(0)
            if self._inverse.CartToJnt(q_out, miss, step) < 0:
                return self._ended(_FAILED)
            q_out._v[:] = np.clip(q_out._v + step._v, self._lower._v, self._upper._v)
        return self._ended(_TOO_MANY)


class ChainIkSolverPos_NR(ChainIkSolverPos_NR_JL):
    """As `ChainIkSolverPos_NR_JL`, without limits."""

    def __init__(
        self,
        chain: Chain,
        fksolver: ChainFkSolverPos_recursive,
        iksolver: ChainIkSolverVel_pinv,
        maxiter: int = 100,
        eps: float = 1e-6,
    ) -> None:
        ends = JntArray(chain.getNrOfJoints())
        super().__init__(chain, ends, ends, fksolver, iksolver, maxiter, eps)
        self._lower._v[:], self._upper._v[:] = -np.inf, np.inf


class ChainIkSolverPos_LMA(SolverI):
    """A frame of the tip to positions of the joints: damped steps, less damped where they help.

    Source: K. Madsen, H. Nielsen, O. Tingleff, "Methods for non-linear least squares problems",
    2004, section 3.2.
    """

    def __init__(
        self,
        chain: Chain,
        *args: Any,
        eps: float = 1e-5,
        maxiter: int = 500,
        eps_joints: float = 1e-15,
    ) -> None:
        super().__init__(chain)
        self._weights = np.array((1.0, 1.0, 1.0, 0.01, 0.01, 0.01))
        if args and np.ndim(args[0]):
            self._weights, args = np.asarray(args[0], dtype=np.float64).reshape(6), args[1:]
        settings = (*args, *(eps, maxiter, eps_joints)[len(args) :])
        self._eps, self._most, self._least = settings

    def CartToJnt(self, q_init: JntArray, T_base_goal: Frame, q_out: JntArray) -> int:
        """Write the best positions found from `q_init`; the code is negative short of the goal."""
        if not self._fits(q_init, q_out):
            return self._ended(_SIZES)
        q, growth = q_init._v.copy(), 2.0
        miss, jacobian = self._miss(q, T_base_goal)
        damping = 10.0 * np.max(np.diag(jacobian.T @ jacobian), initial=0.0)
        code = _TOO_MANY
        for _ in range(self._most):
            if np.linalg.norm(miss) < self._eps:
                code = 0
                break
            slope, curve = jacobian.T @ miss, jacobian.T @ jacobian
            step = np.linalg.lstsq(curve + damping * np.eye(len(q)), slope, rcond=None)[0]
            if np.max(np.abs(slope), initial=0.0) < self._least:
                code = _FAILED
                break
            if np.linalg.norm(step) < self._least:
                code = _FAILED - 1
                break
            result, ahead = self._miss(q + step, T_base_goal)
            gain = (miss @ miss - result @ result) / (step @ (damping * step + slope))
            if gain > 0:
                q, miss, jacobian = q + step, result, ahead
                damping, growth = damping * max(1 / 3, 1 - (2 * gain - 1) ** 3), 2.0
            else:
                damping, growth = damping * growth, growth * 2.0
        q_out._v[:] = q
        return self._ended(code)

    def _miss(self, q: Array, goal: Frame) -> tuple[Array, Array]:
        here, jacobian = self._walk(q)
        return self._weights * diff(here, goal)._v, self._weights[:, None] * jacobian


class ChainIdSolver_RNE(SolverI):
    """Motion of the joints to the efforts that it takes [N m or N]: Newton and Euler's equations.

    Source: R. Featherstone, "Rigid Body Dynamics Algorithms", 2008, section 5.3.
    """

    def __init__(self, chain: Chain, grav: Vector) -> None:
        super().__init__(chain)
        self._gravity = Twist(grav, Vector())

    def CartToJnt(
        self,
        q: JntArray,
        q_dot: JntArray,
        q_dotdot: JntArray,
        f_ext: list[Wrench],
        torques: JntArray,
    ) -> int:
        """Write the efforts under loads `f_ext` on each segment, in its own frame."""
        segments = self._chain.getNrOfSegments()
        if not self._fits(q, q_dot, q_dotdot, torques) or len(f_ext) != segments:
            return self._ended(_SIZES)
        speed, rise = Twist(), -self._gravity
        passed = []
        for (segment, value, place), load in zip(self._moved(q._v), f_ext, strict=True):
            frame, body = segment.pose(value), segment.getInertia()
            axis = frame.M.Inverse(segment.twist(value, 1.0 if place is not None else 0.0))
            rate, growth = (0.0, 0.0) if place is None else (q_dot[place], q_dotdot[place])
            speed = frame.Inverse(speed) + axis * rate
            turning, shifting = (frames.skew(item._v) for item in (speed.rot, speed.vel))
            carrying = np.block([[turning, shifting], [np.zeros((3, 3)), turning]])
            along = Twist._of(carrying @ axis._v * rate)
            rise = frame.Inverse(rise) + axis * growth + along
            push = body * rise - Wrench._of(carrying.T @ (body * speed)._v) - load
            passed.append((frame, axis, place, push, segment.getJoint()._inertia * growth))
        carried = Wrench()
        for frame, axis, place, push, own in reversed(passed):
            carried = carried + push
            if place is not None:
                torques[place] = float(axis._v @ carried._v) + own
            carried = frame * carried
        return self._ended(0)


class ChainDynParam(SolverI):
    """The parts of the efforts that an arm's motion takes: masses, velocities and weight."""

    def __init__(self, chain: Chain, _grav: Vector) -> None:
        super().__init__(chain)
        self._weight = ChainIdSolver_RNE(chain, _grav)
        self._weightless = ChainIdSolver_RNE(chain, Vector())

    def _efforts(self, solver: ChainIdSolver_RNE, *motion: JntArray) -> int:
        *given, out = motion
        rest = [JntArray(self._chain.getNrOfJoints()) for _ in range(3 - len(given))]
        free = [Wrench() for _ in range(self._chain.getNrOfSegments())]
        q, q_dot, q_dotdot = (*given, *rest)
        return self._ended(solver.CartToJnt(q, q_dot, q_dotdot, free, out))

    def JntToGravity(self, q: JntArray, gravity: JntArray) -> int:
        """Write the efforts that hold the arm's weight [N m or N]."""
        return self._efforts(self._weight, q, gravity)

    def JntToCoriolis(self, q: JntArray, q_dot: JntArray, coriolis: JntArray) -> int:
        """Write the efforts of a motion at even velocities, without weight [N m or N]."""
        return self._efforts(self._weightless, q, q_dot, coriolis)

    def JntToMass(self, q: JntArray, H: JntSpaceInertiaMatrix) -> int:
        """Write the masses as the joints feel them."""
        joints = self._chain.getNrOfJoints()
        if not self._fits(q, H):
            return self._ended(_SIZES)
        for place in range(joints):
            push, column = JntArray(joints), JntArray(joints)
            push[place] = 1.0
            self._efforts(self._weightless, q, JntArray(joints), push, column)
            H._v[:, place] = column._v
        return self._ended(0)


def _forward(solver: SolverI, q: JntArray, frame: Frame, count: int) -> int:
    if not solver._fits(q):
        return _SIZES
    if count > solver._chain.getNrOfSegments():
        return _OUT_OF_RANGE
    frame._v[:] = solver._walk(q._v, count)[0]._v
    return 0


__all__ = _defined(globals())
