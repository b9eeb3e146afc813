"""The tool centre points and tools that the controller keeps."""

from __future__ import annotations

from typing import Any

from DR_common2 import get_posx

from tracerisk.ros.imports.exported import defined as _defined

from ._box import (
    asked,
    done,
    numbers,
    wrong_type,
)


def set_tcp(name: str) -> int:
    """Use a tool centre point that is registered."""
    return done("SetCurrentTcp", "tcp/set_current_tcp", name=_named(name))


def get_tcp() -> str:
    """Return the name of the tool centre point."""
    return str(asked("GetCurrentTcp", "tcp/get_current_tcp").info)


def add_tcp(name: str, pos: Any) -> int:
    """Register a tool centre point."""
    made = numbers(get_posx(pos))
    return done("ConfigCreateTcp", "tcp/config_create_tcp", name=_named(name), pos=made)


def del_tcp(name: str) -> int:
    """Take away a tool centre point."""
    return done("ConfigDeleteTcp", "tcp/config_delete_tcp", name=_named(name))


def set_tool(name: str) -> int:
    """Use the mass of a tool that is registered."""
    return done("SetCurrentTool", "tool/set_current_tool", name=_named(name))


def get_tool() -> str:
    """Return the name of the tool."""
    return str(asked("GetCurrentTool", "tool/get_current_tool").info)


def add_tool(name: str, weight: float, cog: Any, inertia: Any) -> int:
    """Register a tool: its mass [kg], centre of mass [mm] and inertia [kg m^2]."""
    fields = {"weight": float(weight), "cog": numbers(cog), "inertia": numbers(inertia)}
    return done("ConfigCreateTool", "tool/config_create_tool", name=_named(name), **fields)


def del_tool(name: str) -> int:
    """Take away a tool."""
    return done("ConfigDeleteTool", "tool/config_delete_tool", name=_named(name))


def set_tool_shape(name: str) -> int:
    """Use the shape of a tool that is registered."""
    return done("SetToolShape", "tool/set_tool_shape", name=_named(name))


def _named(name: Any) -> str:
    if type(name) is not str:
        raise wrong_type("name")
    return name


__all__ = _defined(globals())
