"""Configurations and their descriptions as dictionaries and as messages."""

from __future__ import annotations

import copy
from collections.abc import Iterable, Mapping
from typing import Any

from dynamic_reconfigure.msg import (
    BoolParameter,
    DoubleParameter,
    GroupState,
    IntParameter,
    ParamDescription,
    StrParameter,
)
from dynamic_reconfigure.msg import Config as ConfigMsg
from dynamic_reconfigure.msg import ConfigDescription as ConfigDescrMsg
from dynamic_reconfigure.msg import Group as GroupMsg

# `bool` before `int`, which it is one of.
_KINDS: tuple[tuple[type, str, Any], ...] = (
    (bool, "bools", BoolParameter),
    (int, "ints", IntParameter),
    (str, "strs", StrParameter),
    (float, "doubles", DoubleParameter),
)


class Config(dict[str, Any]):
    """A configuration: values by name, also as attributes."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return self[name]

    def __setattr__(self, name: str, value: Any) -> None:
        self[name] = value

    def copy(self) -> Config:
        """Return a copy."""
        return Config(self)

    def __deepcopy__(self, memo: dict[int, Any]) -> Config:
        return Config({name: copy.deepcopy(value, memo) for name, value in self.items()})


def encode_config(config: Mapping[str, Any], flat: bool = True) -> Any:
    """Return a configuration as a message; its groups as a flat list of states."""
    msg = ConfigMsg()
    for name, value in config.items():
        if isinstance(value, dict):
            states = [value, *_below(value)] if flat else list(value.values())
            msg.groups.extend(
                GroupState(state["name"], state["state"], state["id"], state["parent"])
                for state in states
            )
            continue
        for kind, field, parameter in _KINDS:
            if isinstance(value, kind):
                getattr(msg, field).append(parameter(name, value))
                break
    return msg


def decode_config(msg: Any, description: Any = None) -> Config:
    """Return the configuration of a message; with a description, its groups too."""
    config = Config((item.name, item.value) for field in _KINDS for item in getattr(msg, field[1]))
    if not msg.groups or description is None:
        return config
    root = next((group for group in msg.groups if group.id == 0), None)
    if root is not None:
        config["groups"] = _group(root, msg.groups, config, description)
    return config


def initial_config(msg: Any, description: Any = None) -> Config:
    """Return the configuration that a server begins with."""
    return decode_config(msg, description)


def encode_description(descr: Any) -> Any:
    """Return what a generated type says of its parameters as a message."""
    return ConfigDescrMsg(
        groups=encode_groups(None, descr.config_description),
        max=encode_config(descr.max),
        min=encode_config(descr.min),
        dflt=encode_config(descr.defaults),
    )


def encode_groups(parent: Any, group: Mapping[str, Any]) -> list[Any]:
    """Return a group and those in it as messages."""
    msg = GroupMsg(name=group["name"], id=group["id"], parent=group["parent"], type=group["type"])
    msg.parameters = [
        ParamDescription(p["name"], p["type"], p["level"], p["description"], p["edit_method"])
        for p in group["parameters"]
    ]
    return [
        msg,
        *(encode_group for inner in group["groups"] for encode_group in encode_groups(msg, inner)),
    ]


def decode_description(msg: Any) -> Any:
    """Return the tree of groups of a description's message, with their parameters."""
    least, most, default = (decode_config(item) for item in (msg.min, msg.max, msg.dflt))

    def parameters(group: Any) -> list[dict[str, Any]]:
        return [
            {
                "name": p.name,
                "min": least[p.name],
                "max": most[p.name],
                "default": default[p.name],
                "type": p.type,
                "level": p.level,
                "description": p.description,
                "edit_method": p.edit_method,
            }
            for p in group.parameters
        ]

    def tree(group: Any) -> Config:
        made = group_dict(group)
        made["parameters"] = parameters(group)
        made["groups"] = Config(
            (item.name, tree(item))
            for item in msg.groups
            if item.id != 0 and item.parent == group.id
        )
        return made

    root = next((item for item in msg.groups if item.id == 0), None)
    return Config() if root is None else tree(root)


def get_tree(m: Any, group: Any = None) -> Config:
    """Return the groups of a description's message below a group, by default the outermost."""
    root = next((item for item in m.groups if item.id == 0), None) if group is None else group
    inner = Config()
    for item in m.groups:
        if root is not None and item.id != 0 and item.parent == root.id:
            inner[item.name] = group_dict(item)
            inner[item.name]["groups"] = get_tree(m, item)
    if root is None or root.id != 0:
        return inner
    made = group_dict(root)
    made["groups"] = inner
    return made


def group_dict(group: Any) -> Config:
    """Return a group's message as a dictionary, without what is in the group."""
    return Config(
        id=group.id,
        parent=group.parent,
        name=group.name,
        type=getattr(group, "type", ""),
        state=getattr(group, "state", True),
        groups=Config(),
        parameters=Config(),
    )


def extract_params(group: Any) -> list[Any]:
    """Return the parameters of a group and of those in it."""
    inner = group["groups"]
    groups: Iterable[Any] = inner.values() if isinstance(inner, dict) else inner
    return [
        *group["parameters"],
        *(extract_parameter for item in groups for extract_parameter in extract_params(item)),
    ]


def _group(state: Any, states: Any, config: Config, description: Any) -> Config:
    made = group_dict(state)
    own = {p["name"] for p in description["parameters"]}
    made["parameters"] = Config((name, config[name]) for name in sorted(own & set(config)))
    made.update(made["parameters"])
    inner = description["groups"]
    known = inner.values() if isinstance(inner, dict) else inner
    for item in states:
        result = next((d for d in known if d["name"] == item.name), None)
        if item.id != 0 and item.parent == state.id and result is not None:
            made["groups"][item.name] = _group(item, states, config, result)
    return made


def _below(group: Mapping[str, Any]) -> list[Any]:
    below: list[Any] = []
    for item in group["groups"].values():
        below.extend([*_below(item), item])
    return below
