"""What the compiled part of moveit_commander takes: arguments of exact types, messages as bytes.

As `wrap_python_move_group.cpp` of moveit/moveit, which Boost.Python checks: a string is no number,
a tuple or an array no list of a pose. Scalars of NumPy are taken for numbers.
"""

from collections.abc import Iterable
from numbers import Integral, Real
from typing import Any, Literal

from .conversions import msg_to_string

Kind = Literal["double", "int", "unsigned int", "bool", "std::string", "boost::python::list"]
_TYPES: dict[str, tuple[type, ...]] = {
    "double": (Real,),
    "int": (Integral,),
    "unsigned int": (Integral,),
    "bool": (Integral, type(None)),
    "std::string": (str, bytes),
    "boost::python::list": (list,),
}


class ArgumentError(TypeError):
    """Arguments of types that no overload of a compiled function takes."""


ArgumentError.__module__ = "Boost.Python"


def check_arguments(name: str, *arguments: tuple[Any, Kind]) -> None:
    """Raise what the binding raises for arguments of other types than its function takes.

    Raises:
        ArgumentError: an argument is of another type.
        OverflowError: a negative number where there are none.
    """
    if not all(isinstance(value, _TYPES[kind]) for value, kind in arguments):
        given = ", ".join(["MoveGroupInterface", *(type(value).__name__ for value, _ in arguments)])
        wanted = ", ".join(kind for _, kind in arguments)
        raise ArgumentError(
            f"Python argument types in\n    MoveGroupInterface.{name}({given})\n"
            f"did not match C++ signature:\n    {name}(MoveGroupInterface {{lvalue}}, {wanted})"
        )
    if any(kind == "unsigned int" and value < 0 for value, kind in arguments):
        raise OverflowError("can't convert negative value to unsigned int")


def doubles(values: Iterable[Any]) -> list[float]:
    """Return values as the binding reads a sequence of numbers.

    Raises:
        TypeError: one is no number.
    """
    listed = list(values)
    for value in listed:
        if not isinstance(value, Real):
            raise TypeError(
                "No registered converter was able to produce a C++ rvalue of type double from "
                f"this Python object of type {type(value).__name__}"
            )
    return [float(value) for value in listed]


def received(kind: type, message: Any) -> Any:
    """Return a message as the binding gets it: its bytes, read as the type that it takes.

    Raises:
        AttributeError: it is no message.
        RuntimeError: its bytes are too few for that type.
    """
    from genpy import DeserializationError

    data = msg_to_string(message)
    if isinstance(message, kind):
        return message
    try:
        return kind().deserialize(data)
    except (DeserializationError, MemoryError, OverflowError, ValueError):
        raise RuntimeError("Buffer Overrun") from None
