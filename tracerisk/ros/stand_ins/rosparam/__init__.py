"""Stand-in for rosparam: parameters by name, and from and to files of YAML."""

from __future__ import annotations

import io
import os
import re
import sys
from pathlib import Path
from typing import Any

import rosgraph
from rosgraph.names import GLOBALNS, get_ros_namespace, make_caller_id, make_global_ns, ns_join
from ruamel.yaml.error import YAMLError

from tracerisk.ros.graph.yaml_text import load_yaml
from tracerisk.ros.imports.exported import defined as _defined

NAME = "rosparam"
NS = "_ns"
_DOCUMENTS = re.compile(r"^---[ \t]*$", re.MULTILINE)


class RosParamException(Exception):
    """A file or a parameter is not as it should be."""


class RosParamIOException(RosParamException):
    """The master does not answer."""


def get_param_server() -> rosgraph.Master:
    """Return the master, whose parameters these are."""
    return rosgraph.Master(make_caller_id(f"{NAME}-{os.getpid()}"))


def get_param(param: str) -> Any:
    """Return a parameter, or all of a namespace.

    Raises:
        rosgraph.MasterError: it is not set.
    """
    return get_param_server().getParam(param)


def list_params(ns: str) -> list[str]:
    """Return the names of the parameters in a namespace, sorted."""
    begin = make_global_ns(ns)
    return sorted(name for name in get_param_server().getParamNames() if name.startswith(begin))


def print_params(params: Any, ns: str) -> None:
    """Print the parameters of a namespace, a line each."""
    if not isinstance(params, dict):
        print(params)  # noqa: T201
        return
    for name, value in params.items():
        if isinstance(value, dict):
            print_params(value, ns_join(ns, name))
        else:
            print(f"{ns_join(ns, name)}={value}")  # noqa: T201


def set_param_raw(param: str, value: Any, verbose: bool = False) -> None:
    """Set a parameter to a value; those already in a namespace stay, if they are not named.

    Raises:
        RosParamException: a name within a namespace is no text.
    """
    if not isinstance(value, dict):
        get_param_server().setParam(param, value)
        if verbose:
            print(f"set parameter [{param}] to [{value}]")  # noqa: T201
        return
    for name, inner in value.items():
        if not isinstance(name, str):
            raise RosParamException(
                f"YAML dictionaries must have string keys. Invalid dictionary is:\n{value}"
            )
        set_param_raw(ns_join(param, name), inner, verbose)


def set_param(param: str, value: str, verbose: bool = False) -> None:
    """Set a parameter to a value that is a text of YAML."""
    set_param_raw(param, load_yaml(value), verbose)


def delete_param(param: str, verbose: bool = False) -> None:
    """Remove a parameter; of `/`, all of them.

    Raises:
        rosgraph.MasterError: it is not set.
    """
    if param == GLOBALNS:
        get_param_server().setParam(GLOBALNS, {})
    else:
        get_param_server().deleteParam(param)
    if verbose:
        what = "ENTIRE parameter server" if param == GLOBALNS else f"parameter [{param}]"
        print(f"deleted {what}")  # noqa: T201


def upload_params(ns: str, values: Any, verbose: bool = False) -> None:
    """Set the parameters of a namespace; those already there stay, if they are not named.

    Raises:
        RosParamException: values for the root are no dictionary.
    """
    if ns == GLOBALNS and not isinstance(values, dict):
        raise RosParamException("global / can only be set to a dictionary")
    if verbose:
        print_params(values, ns)
    set_param_raw(ns, values)


def dump_params(filename: str | None, param: str, verbose: bool = False) -> None:
    """Write a parameter, or all of a namespace, to a YAML file; without a name, print it.

    Raises:
        rosgraph.MasterError: it is not set.
    """
    from ruamel.yaml import YAML

    tree = get_param(param)
    if verbose:
        print_params(tree, param)
    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    out = io.StringIO()
    yaml.dump(tree, out)
    if filename:
        Path(filename).write_text(out.getvalue(), encoding="utf-8")
    else:
        sys.stdout.write(out.getvalue())


def load_file(
    filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return the parameters of a YAML file: pairs of values and their namespace.

    The file `-`, or one without a name, is the standard input.

    Raises:
        RosParamException: there is no such file, or it is not YAML.
    """
    if not filename or filename == "-":
        return load_str(sys.stdin.read(), filename, default_namespace, verbose)
    path = Path(filename)
    if not path.is_file():
        raise RosParamException(f"file [{filename}] does not exist")
    if verbose:
        print(f"reading parameters from [{filename}]")  # noqa: T201
    return load_str(path.read_text(encoding="utf-8"), filename, default_namespace, verbose)


def load_str(
    text: str, filename: str, default_namespace: str | None = None, verbose: bool = False
) -> list[tuple[Any, str]]:
    """Return the parameters of a text of YAML; see `load_file`.

    A document's `_ns` is a namespace within the default one.
    """
    top = default_namespace or get_ros_namespace()
    loaded = []
    try:
        for document in _DOCUMENTS.split(text):
            values = load_yaml(document)
            space = top
            if isinstance(values, dict) and NS in values:
                space = ns_join(top, str(values.pop(NS)))
                if verbose:
                    print(f"reading parameters into namespace [{space}]")  # noqa: T201
            if values is not None:
                loaded.append((values, space))
    except YAMLError as error:
        raise RosParamException(f"Unable to load [{filename}]: {error}") from error
    return loaded


__all__ = _defined(globals())
