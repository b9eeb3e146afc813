"""Files of parameters, written and found."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from tempfile import NamedTemporaryFile
from typing import Any

__all__ = ["create_params_file_from_dict", "get_launch_params_filepaths"]

_FLAG = "--params-file"


def create_params_file_from_dict(params: Mapping[str, Any], node_name: str) -> str:
    """Write the parameters of a node into a new YAML file, and return its path."""
    from ruamel.yaml import YAML

    yaml = YAML(typ="safe", pure=True)
    yaml.default_flow_style = False
    with NamedTemporaryFile(
        mode="w", encoding="utf-8", prefix="launch_params_", delete=False
    ) as file:
        yaml.dump({node_name: {"ros__parameters": dict(params)}}, file)
        return file.name


def get_launch_params_filepaths(cli_args: Sequence[str] | None = None) -> list[str]:
    """Return what follows each --params-file of a command line, by default the program's own."""
    arguments = list(sys.argv if cli_args is None else cli_args)
    places = [index for index, argument in enumerate(arguments) if argument == _FLAG]
    if places and places[-1] + 1 == len(arguments):
        return [
            "Failed to parse params file paths from command line arguments. Check that "
            "--params-file command line argument is specified."
        ]
    return [arguments[index + 1] for index in places]
