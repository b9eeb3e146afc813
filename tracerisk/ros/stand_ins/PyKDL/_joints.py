"""Numbers of the joints of a chain, and the masses that they move."""

from __future__ import annotations

from typing import Any

import numpy as np

from tracerisk.common.geometry import frames
from tracerisk.ros.imports.exported import defined as _defined

from ._frames import Frame, Rotation
from ._values import (
    EPSILON,
    Array,
    Twist,
    Value,
    Vector,
    Wrench,
    is_number,
    near,
    plain,
    reader,
    refused,
    row,
)


class _Sized(Value):
    """Numbers whose count is that of the joints, 0 at first."""

    _FIXED: tuple[int, ...] = ()  # the sizes that are not the number of joints
    _AXES = 1

    def __init__(self, size: Any = 0) -> None:
        if isinstance(size, type(self)):
            self._v = size._v.copy()
        elif is_number(size) and hasattr(size, "__index__"):
            self._v = np.zeros((*self._FIXED, *[int(size)] * self._AXES))
        else:
            raise refused(type(self).__name__, size)

    def rows(self) -> int:
        """Return the number of rows."""
        return len(self._v)

    def columns(self) -> int:
        """Return the number of columns."""
        return int(self._v.shape[1]) if self._v.ndim > 1 else min(1, self.rows())

    def resize(self, newSize: int) -> None:
        """Change the number of joints; new numbers are 0."""
        kept, self._v = self._v, type(self)(newSize)._v
        both = tuple(slice(min(sizes)) for sizes in zip(kept.shape, self._v.shape, strict=True))
        self._v[both] = kept[both]

    def __repr__(self) -> str:
        if self._v.ndim == 1:
            return f"[{row(self._v, '')}]"
        return "[" + "".join(row(values, "") + "\n" for values in self._v) + "]"


class JntArray(_Sized):
    """One number for each joint."""


class JntSpaceInertiaMatrix(_Sized):
    """The masses of an arm as its joints feel them: (joints, joints)."""

    _AXES = 2


class Jacobian(_Sized):
    """The twist that a unit of velocity of each joint gives: (6, joints)."""

    _FIXED = (6,)

    def getColumn(self, i: int) -> Twist:
        """Return the twist of a joint."""
        self._cell((0, i))
        return Twist._of(self._v[:, i].copy())

    def setColumn(self, i: int, t: Twist) -> None:
        """Set the twist of a joint."""
        self._cell((0, i))
        self._v[:, i] = t._v

    def changeRefPoint(self, base_AB: Vector) -> None:
        """Move the reference point of the twists by `base_AB` [m]."""
        for i in range(self.columns()):
            self.setColumn(i, self.getColumn(i).RefPoint(base_AB))

    def changeBase(self, rot: Rotation | Frame) -> None:
        """Give the twists in other axes."""
        for i in range(self.columns()):
            self.setColumn(i, rot * self.getColumn(i))

    changeRefFrame = changeBase


class JntArrayVel:
    """Positions `q` and velocities `qdot` of joints [rad, rad/s or m, m/s]."""

    def __init__(self, q: Any = 0, qdot: JntArray | None = None) -> None:
        if isinstance(q, JntArrayVel):
            q, qdot = q.q, q.qdot
        self.q: JntArray = JntArray(q)
        self.qdot: JntArray = JntArray(self.q.rows() if qdot is None else qdot)

    value = reader("q", "Return the positions.")
    deriv = reader("qdot", "Return the velocities.")

    def resize(self, newSize: int) -> None:
        """Change how many joints there are."""
        self.q.resize(newSize)
        self.qdot.resize(newSize)


class RotationalInertia(Value):
    """The inertia of a body against turning (3, 3), counted as nine numbers [kg m^2]."""

    Zero = classmethod(plain)

    def __init__(
        self,
        Ixx: float = 0,
        Iyy: float = 0,
        Izz: float = 0,
        Ixy: float = 0,
        Ixz: float = 0,
        Iyz: float = 0,
    ) -> None:
        self._v = np.array((Ixx, Ixy, Ixz, Ixy, Iyy, Iyz, Ixz, Iyz, Izz), dtype=np.float64)

    def __add__(self, other: RotationalInertia) -> RotationalInertia:
        return RotationalInertia._of(self._v + other._v)

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return Vector._of(self._v.reshape(3, 3) @ other._v)
        return RotationalInertia._of(self._v * float(other))

    __rmul__ = __mul__


class RigidBodyInertia(Value):
    """A body's mass [kg], centre of mass [m] and inertia about that [kg m^2].

    It is kept as the matrix (6, 6) that makes a twist a momentum, both about the frame's origin.
    """

    Zero = classmethod(plain)

    def __init__(
        self, m: float = 0, oc: Vector | None = None, Ic: RotationalInertia | None = None
    ) -> None:
        about = np.zeros((3, 3)) if Ic is None else Ic._v.reshape(3, 3)
        self._v = _body(float(m), np.zeros(3) if oc is None else oc._v, about)

    def getMass(self) -> float:
        """Return the mass [kg]."""
        return float(self._v[0, 0])

    def getCOG(self) -> Vector:
        """Return the centre of mass [m]; the origin of what has no mass."""
        moment = self._v[[5, 3, 4], [1, 2, 0]]
        return Vector._of(moment / self.getMass() if self.getMass() else np.zeros(3))

    def getRotationalInertia(self) -> RotationalInertia:
        """Return the inertia about the origin [kg m^2]."""
        return RotationalInertia._of(self._v[3:, 3:].reshape(9))

    def RefPoint(self, p: Vector) -> RigidBodyInertia:
        """Return the same body about another point [m]."""
        return Frame(-p) * self  # type: ignore[no-any-return]

    def __add__(self, other: RigidBodyInertia) -> RigidBodyInertia:
        return RigidBodyInertia._of(self._v + other._v)

    def __mul__(self, other: Any) -> Any:
        return Wrench._of(self._v @ other._v) if isinstance(other, Twist) else self.__rmul__(other)

    def __rmul__(self, other: Any) -> Any:
        if is_number(other):
            return RigidBodyInertia._of(self._v * float(other))
        if isinstance(other, Rotation | Frame):
            # A motion is brought back to the body's frame, its momentum forth from there.
            back = other.Inverse()
            motion = np.column_stack([(back * Twist._of(axis))._v for axis in np.eye(6)])
            return RigidBodyInertia._of(motion.T @ self._v @ motion)
        return NotImplemented


def _body(mass: float, centre: Array, about_centre: Array) -> Array:
    spread = mass * frames.skew(centre)
    about = about_centre + mass * ((centre @ centre) * np.eye(3) - np.outer(centre, centre))
    return np.block([[mass * np.eye(3), -spread], [spread, about]])


def Add(src1: Any, src2: Any, dest: Any) -> None:
    """Write the sum of two arrays or matrices to a third."""
    dest._v = src1._v + src2._v


def Subtract(src1: Any, src2: Any, dest: Any) -> None:
    """Write the difference of two arrays or matrices to a third."""
    dest._v = src1._v - src2._v


def Multiply(src: Any, factor: Any, dest: Any) -> None:
    """Write an array or matrix times a number, or a matrix times an array."""
    dest._v = src._v @ factor._v if isinstance(factor, JntArray) else src._v * float(factor)


def Divide(src: Any, factor: float, dest: Any) -> None:
    """Write an array or matrix divided by a number."""
    dest._v = src._v / np.float64(factor)


def MultiplyJacobian(jac: Jacobian, src: JntArray, dest: Twist) -> None:
    """Write the twist that velocities of the joints give."""
    dest._v[:] = jac._v @ src._v


def Equal(a: Any, b: Any, eps: float = EPSILON) -> bool:
    """Return whether all numbers of two like values differ by less than `eps`."""
    if is_number(a) and is_number(b):
        return abs(float(a) - float(b)) < eps
    if type(a) is not type(b) or not isinstance(a, Value):
        raise refused("Equal", a, b)
    return near(a._v, b._v, eps)


def SetToZero(a: Any) -> None:
    """Set every number to 0."""
    if not isinstance(a, Value):
        raise refused("SetToZero", a)
    a._v[:] = 0.0


__all__ = _defined(globals())
