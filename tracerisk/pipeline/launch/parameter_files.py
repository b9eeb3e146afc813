"""Parameter files of a package that name the controller's node, where no launch file starts it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tracerisk.pipeline.launch.asked import Asked
from tracerisk.pipeline.launch.parameter_text import (
    ParameterTextError,
    node_parameters,
    read_text,
    yaml_value,
)
from tracerisk.pipeline.launch.program import Program, shown
from tracerisk.pipeline.launch.records import LaunchParameter, LaunchSetup
from tracerisk.pipeline.workspace import Workspace

_FOLDERS = ("config", "params", "param", "cfg")
_MOST_FILES = 200
_MOST_BYTES = 256 * 1024


def setup_of_parameter_file(
    program: Program, workspace: Workspace, asked: Asked, root: Path
) -> LaunchSetup | None:
    """Return the parameters of a file that has a section for exactly the controller's node.

    Of several that with most of the parameters which the source asks for, and of equal ones the
    one sorted first. None where there is none.
    """
    folder = workspace.packages.get(program.package, root)
    found = []
    for path in parameter_files(folder):
        mine = [each for each in _parameters(path) if _is_for_any(each, asked.nodes)]
        if mine:
            given = len(asked.names & {each.name for each in mine})
            found.append((given, path, tuple(mine)))
    if not found:
        return None
    _, path, parameters = max(found, key=lambda each: each[0])
    file = shown([path], root)[0]
    node = str(parameters[0].node).rpartition("/")[2]
    notes = [
        f"launch: parameters of node {node} from {file} ({len(parameters)}), for no launch file "
        "gives it any; --no-launch leaves them out"
    ]
    others = [each for _, each, _ in found if each != path]
    if others:
        notes.append(f"launch: {', '.join(shown(others, root))} would give others")
    return LaunchSetup(
        file=file,
        kind="parameters",
        ros=2,
        parameters=parameters,
        own=parameters,
        sources=(file,),
        notes=(*notes,),
    )


def _is_for_any(parameter: LaunchParameter, nodes: tuple[str, ...]) -> bool:
    return parameter.node is not None and parameter.node.rpartition("/")[2] in nodes


def parameter_files(folder: Path) -> Iterator[Path]:
    """Yield the YAML files of a package that may hold parameters, at most 200."""
    count = 0
    for name in _FOLDERS:
        for path in sorted((folder / name).rglob("*.yaml")) if (folder / name).is_dir() else ():
            count += 1
            if count > _MOST_FILES:
                return
            yield path


def _parameters(path: Path) -> tuple[LaunchParameter, ...]:
    try:
        text = read_text(path) if path.stat().st_size <= _MOST_BYTES else ""
        return node_parameters(yaml_value(text)) if "ros__parameters" in text else ()
    except (OSError, ParameterTextError):
        # It may be of anything: what is no file of parameters gives none.
        return ()
