"""The hash of an interface's definition."""

from __future__ import annotations

_LENGTH = 32


class TypeHash:
    """A version of how hashes are made, and the hash: 32 bytes.

    Raises:
        AssertionError: the version is no integer, or the hash no bytes.
    """

    __slots__ = ("_value", "_version")

    def __init__(self, version: int = -1, value: bytes = bytes(_LENGTH)) -> None:
        self.version = version
        self.value = value

    @property
    def version(self) -> int:
        """The version; -1 of a hash that is none."""
        return self._version

    @version.setter
    def version(self, value: int) -> None:
        if not isinstance(value, int):
            raise AssertionError("the version must be an integer")
        self._version = value

    @property
    def value(self) -> bytes:
        """The hash."""
        return self._value

    @value.setter
    def value(self, value: bytes) -> None:
        if not isinstance(value, bytes):
            raise AssertionError("the hash must be bytes")
        self._value = value

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, TypeHash):
            return False
        return (self.version, self.value) == (other.version, other.value)

    __hash__ = None  # type: ignore[assignment]  # as in the real library

    def __str__(self) -> str:
        if self.version <= 0 or len(self.value) != _LENGTH:
            return "INVALID"
        return f"RIHS{self.version:02}_{self.value.hex()}"
