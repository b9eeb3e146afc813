"""Vectors, twists and wrenches, and what all values of numbers have in common.

A part of a value (`frame.p`, `twist.rot`) is a view: what is written to it is written to the whole.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from copy import copy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import Self

Array = NDArray[np.float64]

EPSILON = 1e-6
"""Numbers that differ by less are equal."""


def near(one: Array, other: Array, eps: float = EPSILON) -> bool:
    """Return whether all numbers differ by less than `eps`."""
    return one.shape == other.shape and bool(np.all(np.abs(one - other) < eps))


def row(values: Iterable[float], between: str = ",") -> str:
    """Return numbers as the library prints them."""
    return between.join(f"{value:12g}" for value in values)


def ordered(args: tuple[Any, ...], kwargs: Mapping[str, Any], *names: str) -> tuple[Any, ...]:
    """Return arguments by their places, those by name behind.

    Raises:
        TypeError: a name is not known, or leaves a gap.
    """
    rest = names[len(args) :]
    if not kwargs:
        return args
    if tuple(kwargs) != rest[: len(kwargs)] and set(kwargs) != set(rest[: len(kwargs)]):
        raise TypeError(f"incompatible arguments {', '.join(kwargs)}; give {', '.join(names)}")
    return (*args, *(kwargs[name] for name in rest if name in kwargs))


def refused(name: str, *values: Any) -> TypeError:
    """Return the error of a call that no form of a function fits."""
    kinds = ", ".join(type(value).__name__ for value in values)
    return TypeError(f"{name}({kinds}): incompatible function arguments")


def is_number(value: Any) -> bool:
    """Return whether a compiled library takes a value as a number."""
    return hasattr(value, "__float__") and getattr(value, "ndim", 0) == 0


def plain(cls: Any) -> Any:
    """Return the zero, or the identity."""
    return cls()


class Value:
    """An array of numbers: copied by the constructor, compared by its numbers."""

    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]

    _v: Array

    @classmethod
    def _of(cls, numbers: Any) -> Self:
        made = cls.__new__(cls)
        made._v = np.asarray(numbers, dtype=np.float64)
        return made

    def _cell(self, key: Any) -> Any:
        """Return an index, or row and column; there are no negative ones."""
        cell = key if isinstance(key, tuple) else (key,)
        bad = len(cell) != self._v.ndim
        if bad or any(not 0 <= at < size for at, size in zip(cell, self._v.shape, strict=True)):
            raise IndexError(f"{type(self).__name__} index out of range")
        return cell

    def __getitem__(self, key: Any) -> float:
        return float(self._v[self._cell(key)])

    def __setitem__(self, key: Any, value: float) -> None:
        self._v[self._cell(key)] = value

    def __deepcopy__(self, memo: Any = None) -> Self:
        return self._of(self._v.copy())

    __copy__ = __deepcopy__

    def __reduce__(self) -> Any:
        return type(self)._of, (self._v.tolist(),)

    def __eq__(self, other: object) -> bool:
        return near(self._v, other._v) if isinstance(other, type(self)) else NotImplemented


def part(cells: Any, kind: type[Value], meaning: str) -> Any:
    """Return a property: some of the numbers of a value as a value of their own."""

    def write(whole: Value, value: Value) -> None:
        whole._v[cells] = value._v

    return property(lambda whole: kind._of(whole._v[cells]), write, doc=meaning)


def reader(name: str, meaning: str) -> Any:
    """Return a method that gives a copy of an attribute."""

    def read(self: Any) -> Any:
        return copy(getattr(self, name))

    read.__doc__ = meaning
    return read


class Linear(Value):
    """What is added, and multiplied by numbers."""

    Zero = classmethod(plain)

    def __add__(self, other: Any) -> Self:
        return self._of(self._v + other._v) if type(other) is type(self) else NotImplemented

    def __sub__(self, other: Any) -> Self:
        return self._of(self._v - other._v) if type(other) is type(self) else NotImplemented

    def __iadd__(self, other: Any) -> Self:
        self._v[:] = (self + other)._v
        return self

    def __isub__(self, other: Any) -> Self:
        self._v[:] = (self - other)._v
        return self

    def __neg__(self) -> Self:
        return self._of(-self._v)

    def __mul__(self, other: Any) -> Any:
        return self._of(self._v * float(other)) if is_number(other) else NotImplemented

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Self:
        return self._of(self._v / np.float64(other)) if is_number(other) else NotImplemented

    def __repr__(self) -> str:
        return f"[{row(self._v)}]"

    def ReverseSign(self) -> None:
        """Turn it around."""
        self._v *= -1.0


def _number(place: int) -> Any:
    def number(self: Vector, value: float | None = None) -> float | None:
        """Return the number, or set it."""
        if value is None:
            return float(self._v[place])
        self._v[place] = value
        return None

    return number


class Vector(Linear):
    """Three numbers; `*` of two vectors is the cross product."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        args = ordered(args, kwargs, "x", "y", "z")
        if not args:
            self._v = np.zeros(3)
        elif len(args) == 3 and all(map(is_number, args)):
            self._v = np.array(args, dtype=np.float64)
        elif len(args) == 1 and isinstance(args[0], Vector):
            self._v = args[0]._v.copy()
        else:
            raise refused("Vector", *args)

    x, y, z = (_number(place) for place in range(3))

    def Norm(self, eps: float = EPSILON) -> float:
        """Return the length."""
        return float(np.linalg.norm(self._v))

    def Normalize(self, eps: float = EPSILON) -> float:
        """Make the length 1 and return what it was; one below `eps` becomes (1, 0, 0)."""
        length = self.Norm()
        self._v[:] = (1.0, 0.0, 0.0) if length < eps else self._v / length
        return length

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, Vector):
            return Vector._of(np.cross(self._v, other._v))
        return super().__mul__(other)


class Screw(Linear):
    """Two vectors, counted as six numbers."""

    _PARTS: tuple[str, str]

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        name = type(self).__name__
        args = ordered(args, kwargs, *self._PARTS)
        if not args:
            self._v = np.zeros(6)
        elif len(args) == 2 and all(isinstance(argument, Vector) for argument in args):
            self._v = np.concatenate([argument._v for argument in args])
        elif len(args) == 1 and type(args[0]) is type(self):
            self._v = args[0]._v.copy()
        else:
            raise refused(name, *args)

    def _turned(self, turn: Array) -> Self:
        return self._of((self._v.reshape(2, 3) @ turn.T).reshape(6))


class Twist(Screw):
    """A velocity `vel` [m/s] of a point, and a rate of turn `rot` [rad/s]."""

    _PARTS = ("vel", "rot")
    vel = part(np.s_[:3], Vector, "The velocity of the point of reference [m/s].")
    rot = part(np.s_[3:], Vector, "The rate of turn [rad/s].")

    def RefPoint(self, v_base_AB: Vector) -> Twist:
        """Return the same motion for another point of the body, `v_base_AB` away."""
        return Twist(self.vel + self.rot * v_base_AB, self.rot)


class Wrench(Screw):
    """A force [N] and a torque [N m] about a point."""

    _PARTS = ("force", "torque")
    force = part(np.s_[:3], Vector, "The force [N].")
    torque = part(np.s_[3:], Vector, "The torque about the point of reference [N m].")

    def RefPoint(self, v_base_AB: Vector) -> Wrench:
        """Return the same load about another point, `v_base_AB` away."""
        return Wrench(self.force, self.torque + self.force * v_base_AB)
