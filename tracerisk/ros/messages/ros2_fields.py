"""The fields of ROS 2 messages: their types, defaults, and what an assignment accepts."""

from __future__ import annotations

import array
import math
from collections import UserList, UserString
from collections.abc import Callable, Sequence, Set
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from tracerisk.ros.messages.misfits import Misfits
    from tracerisk.ros.messages.ros2_base import Message2

SIGNED_BITS = {"int8": 8, "int16": 16, "int32": 32, "int64": 64}
UNSIGNED_BITS = {"char": 8, "uint8": 8, "uint16": 16, "uint32": 32, "uint64": 64}
FLOAT_LIMITS = {"float32": 3.402823466e38, "float64": 1.7976931348623157e308}
TYPE_CODES = {
    "float32": "f",
    "float64": "d",
    "int8": "b",
    "int16": "h",
    "int32": "i",
    "int64": "q",
    "char": "B",
    "uint8": "B",
    "uint16": "H",
    "uint32": "I",
    "uint64": "Q",
}
"""The numbers that arrays keep in place, by the type code of Python's `array`."""
_IDL_NAMES = {
    "float32": "float",
    "float64": "double",
    "bool": "boolean",
    "byte": "octet",
    "char": "uint8",
}
_SCALAR_DEFAULTS: dict[str, Any] = {"bool": False, "byte": b"\0", "string": ""}

Arrangement = Literal["scalar", "array", "sequence"]


@dataclass(frozen=True, slots=True)
class Field2:
    """One field of a ROS 2 message."""

    name: str
    """The name of the field."""
    base: str
    """The type of an element."""
    arrangement: Arrangement = "scalar"
    """How many elements it holds: one, a fixed number or any number."""
    size: int | None = None
    """The length of an array, or the upper bound of a sequence; `None`: unbounded."""
    longest: int | None = None
    """The upper bound of a string's length; `None`: unbounded."""
    message: type[Message2] | None = None
    """The class of a nested message; `None` for primitives."""
    default: Any = None
    """The default that the definition sets; `None` where it sets none."""
    is_guessed: bool = False
    """Whether nobody has the definition: the field holds whatever the program gives it."""

    @property
    def type_text(self) -> str:
        """The type as IDL has it: `sequence<double, 3>`."""
        inner = _IDL_NAMES.get(self.base, self.base)
        if self.longest is not None:
            inner = f"{inner}<{self.longest}>"
        if self.arrangement == "scalar":
            return inner
        if self.arrangement == "array":
            return f"{inner}[{self.size}]"
        return f"sequence<{inner}>" if self.size is None else f"sequence<{inner}, {self.size}>"

    @property
    def is_numbers(self) -> bool:
        """Whether the value is an array of numbers kept in place: numpy's, or Python's."""
        return self.arrangement != "scalar" and self.base in TYPE_CODES

    @property
    def dtype(self) -> Any:
        """numpy's type of an element."""
        return getattr(np, "uint8" if self.base == "char" else self.base)

    def make_default(self) -> Any:
        """Make the value that the field has where the constructor is not given one."""
        if self.arrangement == "scalar":
            return self._element() if self.default is None else self.default
        values = [] if self.default is None else list(self.default)
        if self.arrangement == "array" and not values:
            values = [self._element() for _ in range(self.size or 0)]
        return self.pack(values)

    def pack(self, values: Any) -> Any:
        """Return what the field keeps of a sequence that its constructor is given."""
        if not self.is_numbers:
            return values
        if self.is_guessed:
            try:
                return array.array(TYPE_CODES[self.base], values)
            except (TypeError, ValueError, OverflowError):
                return values
        if self.arrangement == "array":
            return np.array(values, dtype=self.dtype)
        return array.array(TYPE_CODES[self.base], values)

    def take(self, value: Any) -> Any:
        """Return what the field keeps of an assigned value that nobody checks.

        Raises:
            TypeError: an array of numbers cannot be made of it.
            ValueError: likewise.
            OverflowError: a number is too large for the array.
        """
        return self.pack(value)

    def unsendable(self, value: Any) -> str:
        """Return the assertion of rosidl's C code that a value fails; empty where it can be sent.

        The value is a scalar, or an item of a sequence.
        """
        if self.is_guessed:
            return ""
        if self.message is not None:
            wanted, result = self.message, type(value)
            # By the name, as in C: of a subclass it is another.
            same = f"{result.__module__}.{result.__qualname__}".startswith(
                f"{wanted.__module__}.{wanted.__qualname__}"
            )
            return "" if same else f"the class is {wanted.__module__}.{wanted.__qualname__}"
        if self.base in FLOAT_LIMITS:
            return "" if isinstance(value, float) else "PyFloat_Check(field)"
        if self.base == "bool":
            return "" if isinstance(value, bool) else "PyBool_Check(field)"
        if self.base == "byte":
            return "" if isinstance(value, bytes) else "PyBytes_Check(field)"
        if self.base == "string":
            return "" if isinstance(value, str) else "PyUnicode_Check(field)"
        return "" if isinstance(value, int) else "PyLong_Check(field)"

    def as_sent(self, value: Any) -> Any:
        """Return what arrives of an element: C keeps as many bits of a whole number as it has.

        Raises:
            UnicodeEncodeError: a string holds what UTF-8 has not.
        """
        if self.is_guessed:
            return value
        if self.base == "string":
            value.encode()
            return value
        bits = SIGNED_BITS.get(self.base) or UNSIGNED_BITS.get(self.base)
        if bits is None or self._in_range(value):
            return value
        kept = int(value) & ((1 << bits) - 1)
        is_negative = self.base in SIGNED_BITS and kept >> (bits - 1)
        return kept - (1 << bits) if is_negative else kept

    def accept(self, value: Any) -> Any:
        """Return what the field keeps of a value that is assigned to it.

        Raises:
            AssertionError: the value does not fit, in rosidl's words.
        """
        if self.is_guessed:
            return self.pack(value)
        if self.arrangement == "scalar":
            self._check_scalar(value)
            return value
        if self.is_numbers and self._keeps_in_place(value):
            return value
        self._check_many(value)
        return self.pack(value)

    def _element(self) -> Any:
        if self.message is not None:
            return self.message()
        if self.base in FLOAT_LIMITS:
            return 0.0
        return _SCALAR_DEFAULTS.get(self.base, 0)

    def _keeps_in_place(self, value: Any) -> bool:
        if self.arrangement == "array" and isinstance(value, np.ndarray):
            kind = f"numpy.{self.dtype.__name__}"
            self._assert(
                value.dtype == self.dtype,
                f"The '{self.name}' numpy.ndarray() must have the dtype of '{kind}'",
            )
            self._assert(
                value.size == self.size,
                f"The '{self.name}' numpy.ndarray() must have a size of {self.size}",
            )
            return True
        if self.arrangement == "sequence" and isinstance(value, array.array):
            code = TYPE_CODES[self.base]
            self._assert(
                value.typecode == code,
                f"The '{self.name}' array.array() must have the type code of '{code}'",
            )
            self._assert(
                self.size is None or len(value) <= self.size,
                f"The '{self.name}' array.array() must have a size <= {self.size}",
            )
            return True
        return False

    def _check_scalar(self, value: Any) -> None:
        field = f"The '{self.name}' field must be"
        if self.message is not None:
            kind = self.message.__name__
            self._assert(isinstance(value, self.message), f"{field} a sub message of type '{kind}'")
        elif self.base == "byte":
            self._assert(
                isinstance(value, bytes | bytearray) and len(value) == 1,
                f"{field} of type 'bytes' or 'ByteString' with length 1",
            )
        elif self.base == "string" and self.longest is not None:
            self._assert(
                isinstance(value, str | UserString) and len(value) <= self.longest,
                f"{field} string value not longer than {self.longest}",
            )
        else:
            self._assert(
                isinstance(value, self._python_type), f"{field} of type '{self._python_name}'"
            )
            # Written only where it is needed: it costs more than all else that a message does.
            if not self._in_range(value):
                raise AssertionError(f"{field} {self._range_text()}")

    def _check_many(self, value: Any) -> None:
        is_sequence = isinstance(value, Sequence | Set | UserList) and not isinstance(
            value, str | UserString
        )
        kind, longest = self._python_type, self.longest
        # Pictures are long, and each byte of one fits.
        are_bytes = self.base == "uint8" and isinstance(value, bytes | bytearray)
        fits = are_bytes or (is_sequence and all(isinstance(item, kind) for item in value))
        if fits and self.size is not None:
            exactly = self.arrangement == "array"
            fits = len(value) == self.size if exactly else len(value) <= self.size
        if fits and longest is not None:
            fits = all(len(item) <= longest for item in value)
        if fits and self.base in TYPE_CODES and not are_bytes:
            fits = all(self._in_range(item) for item in value)
        if not fits:
            raise AssertionError(self._many_text())

    def _many_text(self) -> str:
        texts = ["a set or sequence"]
        if self.size is not None:
            texts.append(f"with length {'' if self.arrangement == 'array' else '<= '}{self.size}")
        if self.longest is not None:
            texts.append(f"and each string value not longer than {self.longest}")
        texts.append(f"and each value of type '{self._python_name}'")
        if self.base in TYPE_CODES:
            texts.append(f"and each {self._range_text(many=True)}")
        return f"The '{self.name}' field must be {' '.join(texts)}"

    @property
    def _python_type(self) -> Any:
        if self.message is not None:
            return self.message
        if self.base in FLOAT_LIMITS:
            return float
        return {"bool": bool, "byte": bytes, "string": str}.get(self.base, int)

    @property
    def _python_name(self) -> str:
        name: str = self._python_type.__name__
        return name

    def _in_range(self, value: Any) -> bool:
        low, high = self._limits()
        if self.base in FLOAT_LIMITS:
            return not (value < low or value > high) or math.isinf(value)
        return low is None or bool(low <= value <= high)

    def _limits(self) -> tuple[Any, Any]:
        if self.base in FLOAT_LIMITS:
            return -FLOAT_LIMITS[self.base], FLOAT_LIMITS[self.base]
        if self.base in SIGNED_BITS:
            bound = 1 << (SIGNED_BITS[self.base] - 1)
            return -bound, bound - 1
        if self.base in UNSIGNED_BITS:
            return 0, (1 << UNSIGNED_BITS[self.base]) - 1
        return None, None

    def _range_text(self, *, many: bool = False) -> str:
        low, high = self._limits()
        if self.base in FLOAT_LIMITS:
            name = _IDL_NAMES[self.base]
            # rosidl prints the limits of a sequence's items with all of their digits.
            text = f"{name} in [{low:f}, {high:f}]" if many else f"{name} in [{low}, {high}]"
        elif self.base in SIGNED_BITS:
            text = f"integer in [{low}, {high}]"
        else:
            text = f"unsigned integer in [{low}, {high}]"
        if many:
            return text
        return f"{'an' if text[0] in 'iu' else 'a'} {text}"

    @staticmethod
    def _assert(holds: bool, message: str) -> None:
        # Not `assert`: what the real library refuses is refused under `python -O` too.
        if not holds:
            raise AssertionError(message)


def accessor(field: Field2, misfits: Misfits) -> property:
    """Return the property that reads `field` of a message, and checks what is assigned to it."""
    slot = f"_{field.name}"

    def read(message: Any) -> Any:
        return getattr(message, slot)

    def write(message: Any, value: Any) -> None:
        try:
            kept = field.accept(value)
        except AssertionError as error:
            if not misfits.are_taken(field):
                raise error from None
            kept = field.take(value)
        object.__setattr__(message, slot, kept)

    get: Callable[[Any], Any] = read
    return property(get, write, doc=f"The field '{field.name}', {field.type_text}.")
