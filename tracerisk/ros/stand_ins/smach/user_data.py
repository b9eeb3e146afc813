"""The data that states hand each other, and the part of it that one state may see."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from .exceptions import InvalidUserCodeError


class UserData:
    """Values by key, read and set as attributes or as items."""

    def __init__(self) -> None:
        object.__setattr__(self, "_data", {})

    def __getitem__(self, key: str) -> Any:
        return self.__getattr__(key)

    def __setitem__(self, key: str, item: Any) -> None:
        self.__setattr__(key, item)

    def __contains__(self, key: str) -> bool:
        return key in self._data

    def __iter__(self) -> Iterator[str]:
        return iter(self._data)

    def keys(self) -> list[str]:
        """Return the keys."""
        return list(self._data)

    def update(self, ud: UserData) -> None:
        """Take all values of other data."""
        self._data.update(ud._data)

    def extract(self, keys: Iterable[str], remapping: Mapping[str, str]) -> UserData:
        """Return data with some keys of this, under the names that `remapping` reads."""
        user_data = UserData()
        for key in keys:
            source = remapping.get(key, key)
            if source in self._data:
                user_data[key] = self._data[source]
        return user_data

    def merge(self, ud: Any, keys: Iterable[str], remapping: Mapping[str, str]) -> None:
        """Take some keys of other data, under the names that `remapping` gives them."""
        for key in keys:
            if key in ud:
                self[remapping.get(key, key)] = ud[key]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return object.__getattribute__(self, "_data")[name]
        except KeyError:
            raise KeyError(f"'{name}'") from None

    def __setattr__(self, name: str, value: Any) -> None:
        self._data[name] = value


class Remapper:
    """What one state sees of the data: its own keys, under its own names."""

    def __init__(
        self,
        ud: UserData,
        input_keys: Collection[str] = (),
        output_keys: Collection[str] = (),
        remapping: Mapping[str, str] | None = None,
    ) -> None:
        vars(self).update(
            _ud=ud,
            _input_keys=tuple(input_keys),
            _output_keys=tuple(output_keys),
            _remapping=dict(remapping or {}),
        )

    def _map(self, key: str) -> str:
        return str(self._remapping.get(key, key))

    def __getitem__(self, key: str) -> Any:
        if key not in self._input_keys:
            raise InvalidUserCodeError(
                f"userdata '{key}' is read, which is none of the state's input_keys: "
                f"{list(self._input_keys)}"
            )
        return self._ud[self._map(key)]

    def __setitem__(self, key: str, value: Any) -> None:
        if key not in self._output_keys:
            raise InvalidUserCodeError(
                f"userdata '{key}' is set, which is none of the state's output_keys: "
                f"{list(self._output_keys)}"
            )
        self._ud[self._map(key)] = value

    def __contains__(self, key: str) -> bool:
        return key in self._input_keys and self._map(key) in self._ud

    def keys(self) -> list[str]:
        """Return the keys that can be read and are there."""
        return [key for key in self._input_keys if self._map(key) in self._ud]

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value
