"""Stand-in for rosparam: parameters by name, and from files of YAML."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import rospy
from ruamel.yaml.error import YAMLError

from tracerisk.ros.graph.yaml_text import load_yaml
from tracerisk.ros.imports.exported import defined as _defined

_DOCUMENTS = re.compile(r"^---[ \t]*$", re.MULTILINE)


class RosParamException(Exception):
    """A file or a parameter is not as it should be."""


def get_param(param: str) -> Any:
    """Return a parameter.

    Raises:
        RosParamException: it is not set.
    """
    try:
        return rospy.get_param(param)
    except KeyError:
        raise RosParamException(f"Parameter [{param}] is not set") from None


def list_params(ns: str) -> list[str]:
    """Return the names of the parameters in a namespace, sorted."""
    begin = "/" + ns.strip("/")
    begin = begin if begin.endswith("/") else begin + "/"
    return sorted(name for name in rospy.get_param_names() if name.startswith(begin))


def set_param_raw(param: str, value: Any, verbose: bool = False) -> None:
    """Set a parameter to a value."""
    rospy.set_param(param, value)


def delete_param(param: str, verbose: bool = False) -> None:
    """Remove a parameter.

    Raises:
        RosParamException: it is not set.
    """
    try:
        rospy.delete_param(param)
    except KeyError:
        raise RosParamException(f"Parameter [{param}] is not set") from None


def upload_params(ns: str, values: Any, verbose: bool = False) -> None:
    """Set the parameters of a namespace; those already there stay, if they are not named.

    Raises:
        RosParamException: values for the root are no dictionary.
    """
    if ns == "/" and not isinstance(values, dict):
        raise RosParamException("global / can only be set to a dictionary")
    if not isinstance(values, dict):
        rospy.set_param(ns, values)
        return
    for name, value in values.items():
        rospy.set_param(f"{ns.rstrip('/')}/{name}", value)


def load_file(
    filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return the parameters of a YAML file: pairs of values and their namespace.

    Raises:
        RosParamException: there is no such file, or it is not YAML.
    """
    path = Path(filename)
    if not path.is_file():
        raise RosParamException(f"file [{filename}] does not exist")
    return load_str(path.read_text(encoding="utf-8"), filename, default_namespace)


def load_str(
    text: str, filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return the parameters of a text of YAML; see `load_file`.

    A document's `_ns` is a namespace within the default one.
    """
    top = "/" if default_namespace is None else rospy.resolve_name(default_namespace)
    loaded = []
    try:
        for document in _DOCUMENTS.split(text):
            values = load_yaml(document)
            space = top
            if isinstance(values, dict) and "_ns" in values:
                space = f"{top.rstrip('/')}/{str(values.pop('_ns')).strip('/')}"
            if values is not None:
                loaded.append((values, space))
    except YAMLError as error:
        raise RosParamException(f"Unable to load [{filename}]: {error}") from error
    return loaded


__all__ = _defined(globals())
