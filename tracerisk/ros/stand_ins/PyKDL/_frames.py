"""Rotations and frames."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from tracerisk.common.geometry import frames
from tracerisk.ros.readings.euler_angles import look_at_euler

from ._values import (
    EPSILON,
    Array,
    Screw,
    Twist,
    Value,
    Vector,
    Wrench,
    ordered,
    part,
    plain,
    reader,
    refused,
    row,
)

_FLAT = 1e-12  # [rad] from where two of three angles turn about the same axis


def _about(axis: Array) -> Any:
    def turn(angle: float) -> Rotation:
        """Return a turn about the axis [rad]."""
        return Rotation._of(frames.about(tuple(axis), angle))

    return turn


def _turn_about(axis: Array) -> Any:
    def turn(self: Rotation, angle: float) -> None:
        """Turn about the own axis [rad]."""
        self._v[:] = self._v @ frames.about(tuple(axis), angle)

    return turn


def _axis(column: int) -> Any:
    def unit(self: Rotation, X: Vector | None = None) -> Vector | None:
        """Return the axis, or set it."""
        if X is None:
            return Vector._of(self._v[:, column].copy())
        self._v[:, column] = X._v
        return None

    return unit


class Rotation(Value):
    """A rotation as a matrix (3, 3)."""

    def __init__(self, *args: Any) -> None:
        if not args:
            self._v = np.eye(3)
        elif len(args) == 9:
            self._v = np.array(args, dtype=np.float64).reshape(3, 3)
        elif len(args) == 3 and all(isinstance(argument, Vector) for argument in args):
            self._v = np.column_stack([axis._v for axis in args])
        elif len(args) == 1 and isinstance(args[0], Rotation):
            self._v = args[0]._v.copy()
        else:
            raise refused("Rotation", *args)

    Identity = classmethod(plain)
    RotX, RotY, RotZ = (staticmethod(_about(axis)) for axis in np.eye(3))
    DoRotX, DoRotY, DoRotZ = (_turn_about(axis) for axis in np.eye(3))
    UnitX, UnitY, UnitZ = (_axis(column) for column in range(3))

    @staticmethod
    def Rot(rotvec: Vector, angle: float) -> Rotation:
        """Return a turn about a vector [rad]; about one of no length it is about x."""
        axis = Vector(rotvec)
        axis.Normalize()
        return Rotation.Rot2(axis, angle)

    @staticmethod
    def Rot2(rotvec: Vector, angle: float) -> Rotation:
        """Return a turn about a vector of length 1 [rad]."""
        return Rotation._of(frames.about(tuple(rotvec._v), angle))

    @staticmethod
    def RPY(roll: float, pitch: float, yaw: float) -> Rotation:
        """Return the turn by roll, pitch and yaw about the fixed x, y, z [rad]."""
        look_at_euler((roll, pitch, yaw), "Rotation.RPY")
        return Rotation._of(frames.rotation((roll, pitch, yaw)))

    @staticmethod
    def EulerZYX(Alfa: float, Beta: float, Gamma: float) -> Rotation:
        """Return the turn about z, the new y and the new x [rad]."""
        return Rotation.RPY(Gamma, Beta, Alfa)

    @staticmethod
    def EulerZYZ(Alfa: float, Beta: float, Gamma: float) -> Rotation:
        """Return the turn about z, the new y and the new z [rad]."""
        turn: Rotation = Rotation.RotZ(Alfa) * Rotation.RotY(Beta) * Rotation.RotZ(Gamma)
        return turn

    @staticmethod
    def Quaternion(x: float, y: float, z: float, w: float) -> Rotation:
        """Return the turn of a quaternion, which is taken as being of length 1."""
        v = np.array((x, y, z), dtype=np.float64)
        square = (w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v)
        return Rotation._of(square + 2.0 * w * frames.skew(v))

    def GetRPY(self) -> tuple[float, float, float]:
        """Return roll, pitch and yaw [rad]; where pitch is upright, roll is 0."""
        m = self._v
        pitch = math.atan2(-m[2, 0], math.hypot(m[0, 0], m[1, 0]))
        if abs(pitch) > math.pi / 2 - _FLAT:
            return 0.0, pitch, math.atan2(-m[0, 1], m[1, 1])
        return math.atan2(m[2, 1], m[2, 2]), pitch, math.atan2(m[1, 0], m[0, 0])

    def GetEulerZYX(self) -> tuple[float, float, float]:
        """Return the angles about z, the new y and the new x [rad]."""
        roll, pitch, yaw = self.GetRPY()
        return yaw, pitch, roll

    def GetEulerZYZ(self) -> tuple[float, float, float]:
        """Return the angles about z, the new y and the new z [rad]; the last may be chosen 0."""
        m = self._v
        if abs(m[2, 2]) > 1.0 - _FLAT:
            if m[2, 2] > 0.0:
                return math.atan2(m[1, 0], m[0, 0]), 0.0, 0.0
            return math.atan2(-m[1, 0], -m[0, 0]), math.pi, 0.0
        tilt = math.atan2(math.hypot(m[2, 0], m[2, 1]), m[2, 2])
        return math.atan2(m[1, 2], m[0, 2]), tilt, math.atan2(m[2, 1], -m[2, 0])

    def GetQuaternion(self) -> tuple[float, float, float, float]:
        """Return the quaternion (x, y, z, w), w not negative where it is the greatest."""
        m, trace = self._v, float(np.trace(self._v))
        # The greatest of the four is found from a root, the others from it (Shepperd, 1978).
        empty = np.empty(4)
        if trace > EPSILON:
            empty[3] = math.sqrt(1.0 + trace) / 2.0
            for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                empty[i] = (m[k, j] - m[j, k]) / (4.0 * empty[3])
        else:
            i = int(np.argmax(np.diag(m)))
            j, k = (i + 1) % 3, (i + 2) % 3
            empty[i] = math.sqrt(max(1.0 + m[i, i] - m[j, j] - m[k, k], 0.0)) / 2.0
            sums = (m[j, i] + m[i, j], m[k, i] + m[i, k], m[k, j] - m[j, k])
            empty[[j, k, 3]] = np.array(sums) / (4.0 * empty[i])
        x, y, z, w = (float(value) for value in empty)
        return x, y, z, w

    def GetRotAngle(self, eps: float = EPSILON) -> tuple[float, Vector]:
        """Return the angle, from 0 to pi [rad], and the axis; without a turn it is z."""
        m = self._v
        twice = np.array([m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
        sine, cosine = float(np.linalg.norm(twice)) / 2.0, (float(np.trace(m)) - 1.0) / 2.0
        if sine > eps:
            return math.atan2(sine, cosine), Vector._of(twice / (2.0 * sine))
        if cosine > 0.0:
            return 0.0, Vector(0.0, 0.0, 1.0)
        # Half a turn: (m + 1) / 2 is the axis times itself. Of the two axes it is the one whose
        # last number that is not 0 is positive.
        square = (m + m.T) / 4.0 + np.eye(3) / 2.0
        column = square[:, int(np.argmax(np.diag(square)))]
        axis = column / np.linalg.norm(column)
        last = next((value for value in axis[::-1] if abs(value) > eps), 1.0)
        return math.pi, Vector._of(-axis if last < 0.0 else axis)

    def GetRot(self) -> Vector:
        """Return the axis, as long as the angle [rad]."""
        angle, axis = self.GetRotAngle()
        return axis * angle  # type: ignore[no-any-return]

    def SetInverse(self) -> None:
        """Turn into the inverse."""
        self._v[:] = self._v.T.copy()

    def Inverse(self, arg: Any = None) -> Any:
        """Return the inverse, or what it makes of a vector, twist or wrench."""
        inverse = Rotation._of(self._v.T.copy())
        return inverse if arg is None else inverse * arg

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Rotation | Vector):
            return other._of(self._v @ other._v)
        return other._turned(self._v) if isinstance(other, Screw) else NotImplemented

    def __repr__(self) -> str:
        return "[" + ";\n ".join(row(values) for values in self._v) + "]"


class Frame(Value):
    """A rotation `M` and the origin `p` [m], as a matrix (3, 4)."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        args = ordered(args, kwargs, *(("V",) if "V" in kwargs and not args else ("R", "V")))
        self._v = np.eye(3, 4)
        match args:
            case (Frame() as frame,):
                self._v[:] = frame._v
            case () | (Rotation(),) | (Vector(),) | (Rotation(), Vector()):
                for part in args:
                    if isinstance(part, Rotation):
                        self.M = part
                    else:
                        self.p = part
            case _:
                raise refused("Frame", *args)

    Identity = classmethod(plain)
    M = part(np.s_[:, :3], Rotation, "The rotation.")
    p = part(np.s_[:, 3], Vector, "The origin [m].")

    @staticmethod
    def DH(a: float, alpha: float, d: float, theta: float) -> Frame:
        """Return the frame of Denavit and Hartenberg's parameters [m, rad]."""
        about_z = Frame(Rotation.RotZ(theta), Vector(0.0, 0.0, d))
        return about_z * Frame(Rotation.RotX(alpha), Vector(a, 0.0, 0.0))  # type: ignore[no-any-return]

    @staticmethod
    def DH_Craig1989(a: float, alpha: float, d: float, theta: float) -> Frame:
        """Return the frame of the parameters as Craig has them (1989) [m, rad]."""
        about_x = Frame(Rotation.RotX(alpha), Vector(a, 0.0, 0.0))
        return about_x * Frame(Rotation.RotZ(theta), Vector(0.0, 0.0, d))  # type: ignore[no-any-return]

    def Inverse(self, arg: Any = None) -> Any:
        """Return the inverse, or what it makes of a vector, twist or wrench."""
        back = self.M.Inverse()
        inverse = Frame(back, -(back * self.p))
        return inverse if arg is None else inverse * arg

    def Integrate(self, t_this: Twist, frequency: float) -> None:
        """Move by a twist, given in the frame itself, for one period of a frequency [Hz]."""
        turn = Rotation.Rot(t_this.rot, t_this.rot.Norm() / frequency)
        self._v[:] = (self * Frame(turn, t_this.vel / frequency))._v

    def __mul__(self, other: Any) -> Any:
        turn, place = self._v[:, :3], self._v[:, 3]
        if isinstance(other, Frame):
            moved = turn @ other._v
            moved[:, 3] += place
            return Frame._of(moved)
        if isinstance(other, Vector):
            return Vector._of(turn @ other._v + place)
        if isinstance(other, Screw):
            motion = other._turned(turn)
            # A rate of turn moves what is away from it; a force turns what is away from it.
            to, by = slice(3), slice(3, 6)
            if isinstance(other, Wrench):
                to, by = by, to
            motion._v[to] += np.cross(place, motion._v[by])
            return motion
        return NotImplemented

    def __repr__(self) -> str:
        return f"[{self.M}\n{self.p}]"


class FrameVel:
    """A frame and the twist with which it moves, in the frame of reference, about its origin."""

    def __init__(self, T: Any = None, t: Twist | None = None) -> None:
        if isinstance(T, FrameVel):
            T, t = T._frame, T._twist
        self._frame: Frame = Frame(T or Frame())
        self._twist: Twist = Twist(t or Twist())

    value = GetFrame = reader("_frame", "Return the frame.")
    deriv = GetTwist = reader("_twist", "Return the twist [m/s, rad/s].")


def dot(a: Any, b: Any) -> float:
    """Return the product of two vectors [unit of both], or the power of a twist and a wrench [W].

    Raises:
        TypeError: they are neither.
    """
    if {type(a), type(b)} in ({Vector}, {Twist, Wrench}):
        return float(a._v @ b._v)
    raise refused("dot", a, b)


def diff(a: Any, b: Any, dt: float = 1.0) -> Any:
    """Return the constant rate that leads from `a` to `b` in `dt` [s]; frames give a twist.

    Raises:
        TypeError: they are not of one kind that has rates.
    """
    if isinstance(a, Rotation) and isinstance(b, Rotation):
        return a * (a.Inverse() * b).GetRot() / dt
    if isinstance(a, Frame) and isinstance(b, Frame):
        return Twist(diff(a.p, b.p, dt), diff(a.M, b.M, dt))
    if isinstance(a, Vector | Screw) and type(a) is type(b):
        return (b - a) / dt
    raise refused("diff", a, b)


def addDelta(a: Any, da: Any, dt: float = 1.0) -> Any:
    """Return where the rate `da` leads from `a` in `dt` [s]; the inverse of `diff`.

    Raises:
        TypeError: the rate is not of the kind that `a` needs.
    """
    if isinstance(a, Rotation) and isinstance(da, Vector):
        return Rotation.Rot(da, da.Norm() * dt) * a
    if isinstance(a, Frame) and isinstance(da, Twist):
        return Frame(addDelta(a.M, da.rot, dt), addDelta(a.p, da.vel, dt))
    if isinstance(a, Vector | Screw) and type(a) is type(da):
        return a + da * dt
    raise refused("addDelta", a, da)
