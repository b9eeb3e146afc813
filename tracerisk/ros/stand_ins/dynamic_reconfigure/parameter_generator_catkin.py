"""What a `.cfg` file describes its parameters with."""

from __future__ import annotations

import math
import re
from typing import Any

str_t = "str"
bool_t = "bool"
int_t = "int"
double_t = "double"

_PYTHON: dict[str, Any] = {"str": str, "int": int, "double": float, "bool": bool}
_LEAST: dict[str, Any] = {"int": -0x80000000, "double": -math.inf, "str": "", "bool": False}
_MOST: dict[str, Any] = {"int": 0x7FFFFFFF, "double": math.inf, "str": "", "bool": True}
_DEFAULT: dict[str, Any] = {"int": 0, "double": 0.0, "str": "", "bool": False}


class ParameterGenerator:
    """Collects parameters, groups and constants; `generate` ends the description."""

    latest: ParameterGenerator | None = None
    """The generator that a file has ended with."""

    class Group:
        """A group of parameters."""

        def __init__(
            self, gen: ParameterGenerator, name: str, type: str, state: bool, id: int, parent: int
        ) -> None:
            self.gen, self.type, self.state, self.id, self.parent = gen, type, state, id, parent
            self.name = name.replace(" ", "_")
            self.groups: list[ParameterGenerator.Group] = []
            self.parameters: list[dict[str, Any]] = []

        def add_group(
            self, name: str, type: str = "", state: bool = True
        ) -> ParameterGenerator.Group:
            """Add a group to this one."""
            self.gen._n_groups += 1
            made = ParameterGenerator.Group(
                self.gen, name, type, state, self.gen._n_groups, self.id
            )
            self.groups.append(made)
            return made

        def add(
            self,
            name: str,
            paramtype: str,
            level: int,
            description: str,
            default: Any = None,
            min: Any = None,
            max: Any = None,
            edit_method: str = "",
        ) -> None:
            """Add a parameter.

            Raises:
                TypeError: a value is not of the parameter's type.
                Exception: the name is none, or a text or truth value has limits.
            """
            if paramtype in (str_t, bool_t) and (max is not None or min is not None):
                raise Exception(f"Max or min specified for {name}, which is of '{paramtype}' type")
            if not re.match(r"^[a-zA-Z][a-zA-Z0-9_]*$", name):
                raise Exception(
                    f"The name of field '{name}' does not follow the ROS naming conventions, "
                    "see http://wiki.ros.org/ROS/Patterns/Conventions"
                )
            table = {
                "name": name,
                "type": paramtype,
                "level": level,
                "description": description,
                "edit_method": edit_method,
            }
            for field, value, unset in (
                ("default", default, _DEFAULT),
                ("min", min, _LEAST),
                ("max", max, _MOST),
            ):
                known = unset[paramtype] if value is None else value
                table[field] = _cast(name, paramtype, field, known)
            self.parameters.append(table)

        def to_dict(self) -> dict[str, Any]:
            """Return the group as a description."""
            return {
                "name": self.name,
                "type": self.type,
                "state": self.state,
                "id": self.id,
                "parent": self.parent,
                "parameters": self.parameters,
                "groups": [group.to_dict() for group in self.groups],
            }

    def __init__(self) -> None:
        self._n_groups = 0
        self.group = self.Group(self, "Default", "", True, 0, 0)
        self.constants: list[dict[str, Any]] = []

    def const(self, name: str, type: str, value: Any, descr: str) -> dict[str, Any]:
        """Add a constant.

        Raises:
            TypeError: the value is not of the type.
        """
        made = {
            "name": name,
            "type": type,
            "value": _cast(name, type, "value", value),
            "description": descr,
        }
        self.constants.append(made)
        return made

    def enum(self, constants: list[dict[str, Any]], description: str) -> str:
        """Return the edit method of a parameter that is one of several constants."""
        if len({constant["type"] for constant in constants}) != 1:
            raise Exception("Inconsistent types in enum!")
        return repr({"enum": constants, "enum_description": description})

    def add(
        self,
        name: str,
        paramtype: str,
        level: int,
        description: str,
        default: Any = None,
        min: Any = None,
        max: Any = None,
        edit_method: str = "",
    ) -> None:
        """Add a parameter to the outermost group; see `Group.add`."""
        self.group.add(name, paramtype, level, description, default, min, max, edit_method)

    def add_group(self, name: str, type: str = "", state: bool = True) -> Group:
        """Add a group to the outermost one."""
        return self.group.add_group(name, type, state)

    def generate(self, pkgname: str, nodename: str, name: str) -> int:
        """End the description; the status to exit with is 0."""
        ParameterGenerator.latest = self
        return 0


def _cast(name: str, kind: str, field: str, value: Any) -> Any:
    wanted = _PYTHON[kind]
    if type(value) is not wanted and not (wanted is float and type(value) is int):
        raise TypeError(f"'{name}' has type {kind}, but {field} is {value!r}")
    return wanted(value)
