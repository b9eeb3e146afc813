"""Parameter files as ROS 2 reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

_EVERY_NODE = "/**"


def save_to_ros_params_file(
    params: dict[str, Any], filepath: str, namespace: str | None = None
) -> None:
    """Write parameters of a namespace, by default of every node."""
    with Path(filepath).open("w", encoding="utf-8") as file:
        YAML(typ="safe").dump({namespace or _EVERY_NODE: {"ros__parameters": params}}, file)


def load_from_ros_params_file(filepath: str, namespace: str | None = None) -> dict[str, Any]:
    """Read the parameters of a namespace, by default of every node."""
    result = YAML(typ="safe").load(Path(filepath).read_text(encoding="utf-8"))
    parameters: dict[str, Any] = result[namespace or _EVERY_NODE]["ros__parameters"]
    return parameters
