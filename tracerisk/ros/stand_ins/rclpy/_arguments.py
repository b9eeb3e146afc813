"""The part of a command line that is meant for ROS: `--ros-args -r a:=b -p speed:=0.5`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tracerisk.ros.graph.yaml_text import load_yaml

from ._rclpy_pybind11 import RCLInvalidROSArgsError, UnknownROSArgsError

FLAG, END = "--ros-args", "--"
_LEVELS = {"unset": 0, "debug": 10, "info": 20, "warn": 30, "error": 40, "fatal": 50}
_WITH_VALUE = {
    "-r": "remap",
    "--remap": "remap",
    "-p": "param",
    "--param": "param",
    "--params-file": "params_file",
    "--log-level": "log_level",
    "-e": "ignored",
    "--enclave": "ignored",
    "--log-config-file": "ignored",
    "--log-file-name": "ignored",
}
_WITHOUT_VALUE = frozenset(
    f"--{state}-{what}"
    for state in ("enable", "disable")
    for what in ("rosout-logs", "stdout-logs", "external-lib-logs")
)


@dataclass(slots=True)
class Arguments:
    """The arguments for ROS on a command line."""

    remaps: list[tuple[str | None, str, str]] = field(default_factory=list)
    """Node, old name and new name of each remapping; node `None`: all nodes."""
    parameters: list[tuple[str | None, str, Any]] = field(default_factory=list)
    """Node pattern, name and value of each parameter; node `None`: all nodes."""
    log_levels: list[tuple[str, int]] = field(default_factory=list)
    """Name and level of each logger; an empty name is the root logger."""
    has_rosout: bool = True
    """Whether log lines are published on `/rosout`."""
    unknown: list[str] = field(default_factory=list)
    """The arguments that are not known."""

    def remapped(self, node: str, name: str) -> str | None:
        """Return what `name` is called instead, if anything; the first that fits counts."""
        for whom, old, new in self.remaps:
            if old == name and whom in (None, node):
                return new
        return None

    def overrides(self, full_name: str) -> dict[str, Any]:
        """Return the parameters that the command line sets for a node; later ones win."""
        return {
            name: value
            for whom, name, value in self.parameters
            if whom is None or _is_meant(whom, full_name)
        }


def _is_meant(pattern: str, full_name: str) -> bool:
    """Return whether a node is one of a pattern: `*` is a part of its name, `**` any number."""
    parts = (
        {"**": r"(/\w+)*", "*": r"/\w+"}.get(part, f"/{re.escape(part)}")
        for part in pattern.strip("/").split("/")
    )
    return re.fullmatch("".join(parts), full_name) is not None


def parse_arguments(argv: Sequence[str]) -> Arguments:
    """Read what stands between `--ros-args` and `--`.

    Raises:
        UnicodeEncodeError: an argument is not of characters.
        UnknownROSArgsError: something there is not known.
        RCLInvalidROSArgsError: something there is malformed.
    """
    for argument in argv:
        argument.encode()
    arguments = Arguments()
    waiting = list(argv)
    within = False
    while waiting:
        argument = waiting.pop(0)
        if argument == FLAG:
            within = True
        elif argument == END:
            within = False
        elif within:
            _read(arguments, argument, waiting)
    if arguments.unknown:
        raise UnknownROSArgsError(f"Found unknown ROS arguments: {arguments.unknown}")
    return arguments


def without_ros_arguments(argv: Sequence[str]) -> list[str]:
    """Return a command line without what is meant for ROS."""
    kept = []
    within = False
    for argument in argv:
        if argument == FLAG:
            within = True
        elif within and argument == END:
            within = False
        elif not within:
            kept.append(argument)
    return kept


def _read(found: Arguments, argument: str, waiting: list[str]) -> None:
    if argument in _WITHOUT_VALUE:
        if argument.endswith("rosout-logs"):
            found.has_rosout = argument.startswith("--enable")
        return
    kind = _WITH_VALUE.get(argument)
    if kind is None:
        found.unknown.append(argument)
        return
    if not waiting:
        raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: '{argument}' has no value")
    value = waiting.pop(0)
    if kind == "remap":
        whom, old, new = _rule(argument, value)
        found.remaps.append((whom, old, new))
    elif kind == "param":
        whom, name, text = _rule(argument, value)
        found.parameters.append((whom, name, _of_one_type(f"{argument} {value}", read_yaml(text))))
    elif kind == "params_file":
        found.parameters.extend(_parameters_of(value))
    elif kind == "log_level":
        name, _, level = value.rpartition(":=")
        if level.lower() not in _LEVELS:
            raise RCLInvalidROSArgsError(f"Failed to parse ROS arguments: no log level '{level}'")
        found.log_levels.append((name, _LEVELS[level.lower()]))


def _rule(argument: str, value: str) -> tuple[str | None, str, str]:
    old, assigned, new = value.partition(":=")
    if not assigned or not old or not new:
        raise RCLInvalidROSArgsError(
            f"Failed to parse ROS arguments: '{argument} {value}' is not of the form name:=value"
        )
    whom, colon, name = old.rpartition(":")
    return (whom, name, new) if colon else (None, old, new)


def _of_one_type(where: str, value: Any) -> Any:
    """Return a parameter's value; a list is read if all that it holds is of one type.

    Raises:
        RCLInvalidROSArgsError: it is not; `where` names the parameter.
    """
    kinds = sorted({type(item).__name__ for item in value}) if isinstance(value, list) else []
    if len(kinds) > 1:
        raise RCLInvalidROSArgsError(
            f"{where}: Sequence should be of same type, and it holds {' and '.join(kinds)}"
        )
    return value


def read_yaml(text: str) -> Any:
    """Return the value of a YAML text, as YAML 1.1 has it; text that is none stays text."""
    from ruamel.yaml.error import YAMLError

    try:
        return load_yaml(text)
    except YAMLError:
        return text


def _parameters_of(file: str) -> list[tuple[str | None, str, Any]]:
    from ruamel.yaml.error import YAMLError

    try:
        content = load_yaml(Path(file).read_text(encoding="utf-8"))
    except YAMLError as error:
        raise RCLInvalidROSArgsError(f"{file} is no YAML: {error}") from error
    except OSError as error:
        raise RCLInvalidROSArgsError(f"Couldn't open the parameter file {file}: {error}") from error
    if not isinstance(content, dict):
        raise RCLInvalidROSArgsError(f"{file} is not a file of ROS parameters: it holds no mapping")
    parameters: list[tuple[str | None, str, Any]] = []
    for node, tree in content.items():
        _walk(parameters, file, str(node), tree)
    return parameters


def _walk(found: list[tuple[str | None, str, Any]], file: str, node: str, tree: Any) -> None:
    if not isinstance(tree, dict):
        raise RCLInvalidROSArgsError(f"{file}: node '{node}' has no 'ros__parameters'")
    for key, inner in tree.items():
        if key == "ros__parameters":
            found.extend(
                (node, name, _of_one_type(f"{file}: {name}", value))
                for name, value in flat_parameters("", inner or {})
            )
        else:
            _walk(found, file, f"{node.rstrip('/')}/{key}", inner)


def flat_parameters(prefix: str, tree: dict[str, Any]) -> list[tuple[str, Any]]:
    """Return the parameters of a tree by their full names, each begun with `prefix`."""
    pairs: list[tuple[str, Any]] = []
    for key, value in tree.items():
        if isinstance(value, dict):
            pairs.extend(flat_parameters(f"{prefix}{key}.", value))
        else:
            pairs.append((f"{prefix}{key}", value))
    return pairs
