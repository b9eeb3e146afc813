"""Parameter files of a package that name the controller's node, where no launch file starts it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from tracerisk.common.text.bounded import files_below
from tracerisk.pipeline.launch.parameter_reads import Asked
from tracerisk.pipeline.launch.program import Program, shown
from tracerisk.pipeline.launch_files.parameter_text import (
    ParameterTextError,
    node_parameters,
    read_text,
    yaml_value,
)
from tracerisk.pipeline.launch_files.records import (
    EVERY_NODE,
    LaunchParameter,
    LaunchReading,
    LaunchSetup,
    split_arguments,
)
from tracerisk.pipeline.workspace.workspace import Workspace
from tracerisk.twin.workspace.description_files import distance

_FOLDERS = ("config", "params", "param", "cfg")
_FURTHER = ("launch", "yaml", "resource", "test", "tests")  # where a test's launch file finds some
_MOST_FILES = 200
_MOST_BYTES = 256 * 1024


@dataclass(frozen=True, slots=True)
class GivenParameters:
    """The parameters of the files that the controller's own arguments name."""

    files: tuple[Path, ...] = ()
    """The files."""
    parameters: tuple[LaunchParameter, ...] = ()
    """What they hold for the controller's node."""

    def beside(self, reading: LaunchReading) -> int:
        """Return for how many of the files a launch file reads one in the same folder."""
        if not self.files:
            return 0
        folders = {path.resolve().parent for path in reading.sources}
        return sum(1 for file in self.files if file.parent in folders)

    def are_near(self, text: str) -> bool:
        """Return whether a text names one of the files, or the folder in which it is."""
        return any(file.name in text or file.parent.name in text for file in self.files)


NO_PARAMETERS_GIVEN = GivenParameters()
"""Of arguments that name no file of parameters."""


def given_parameters(arguments: Sequence[str], nodes: tuple[str, ...]) -> GivenParameters:
    """Return what each `--params-file` behind `--ros-args` gives a node with one of these names.

    A file that cannot be read gives nothing here: the run says so.
    """
    _, ros = split_arguments(arguments)
    files = tuple(Path(name).resolve() for flag, name in pairwise(ros) if flag == "--params-file")
    mine = (
        parameter
        for path in files
        for parameter in _parameters(path)
        if _is_for_every(parameter, nodes) or _is_for_any(parameter, nodes)
    )
    return GivenParameters(files, tuple(mine))


def setup_of_parameter_file(
    program: Program, workspace: Workspace, asked: Asked, root: Path
) -> LaunchSetup | None:
    """Return the parameters of a file that is for the controller's node; `None` for none.

    That is one of its package with a section for exactly this node, else such a one of another
    folder than those of parameters (`launch`, `test`, ...), else one of another package, the
    nearest first, else one of its package for every node; all but the first only if they give what
    the source asks for. Of several that with most of these parameters, and of equal ones the
    one sorted first.
    """
    own = workspace.packages.get(program.package, root).resolve()
    elsewhere = sorted(
        {package.resolve() for package in workspace.packages.values()} - {own},
        key=lambda resolve: (distance(program.script, resolve), resolve),
    )
    for_node = _for_node([own], asked, _is_for_any)
    further = _for_node([own], asked, _is_for_any, _FURTHER)
    for_node = for_node or [row for row in further if row[0]]
    for_node = for_node or [row for row in _for_node(elsewhere, asked, _is_for_any) if row[0]]
    for_node = for_node or [row for row in _for_node([own], asked, _is_for_every) if row[0]]
    if not for_node:
        return None
    _, path, parameters = max(for_node, key=lambda row: row[0])
    file = shown([path], root)[0]
    whom = str(parameters[0].node)
    node = "every node" if whom == EVERY_NODE else f"node {whom.rpartition('/')[2]}"
    namespace = _namespace(parameters)
    within = f", in the namespace {namespace}" if namespace else ""
    notes = [
        f"launch: parameters of {node} from {file} ({len(parameters)}){within}, for no launch file "
        "gives it any; --no-launch leaves them out"
    ]
    others = [item for _, item, _ in for_node if item != path]
    if others:
        notes.append(f"launch: {', '.join(shown(others, root))} would give others")
    return LaunchSetup(
        file=file,
        kind="parameters",
        ros=2,
        namespace=namespace,
        parameters=parameters,
        own=parameters,
        sources=(file,),
        notes=(*notes,),
    )


def _namespace(parameters: Iterable[LaunchParameter]) -> str:
    """Return the namespace in which alone a node gets its parameters; empty for none."""
    spaces = {str(parameter.node).rpartition("/")[0] for parameter in parameters}
    return spaces.pop() if len(spaces) == 1 and "*" not in "".join(spaces) else ""


_Found = tuple[int, Path, tuple[LaunchParameter, ...]]


def _for_node(
    folders: Iterable[Path],
    asked: Asked,
    is_meant: Callable[[LaunchParameter, tuple[str, ...]], bool],
    within: tuple[str, ...] = _FOLDERS,
) -> list[_Found]:
    """Return the files with parameters that are meant, and how many of them are asked for."""
    for_node = []
    for folder in folders:
        for path in parameter_files(folder, within):
            mine = tuple(
                parameter
                for parameter in _parameters(path)
                if is_meant(parameter, asked.nodes) and not _is_of_other_space(parameter, asked)
            )
            if mine:
                for_node.append(
                    (len(asked.names & {parameter.name for parameter in mine}), path, mine)
                )
    return for_node


def _is_of_other_space(parameter: LaunchParameter, asked: Asked) -> bool:
    """Return whether a node is meant in another namespace than those that the source gives."""
    space = str(parameter.node).rpartition("/")[0]
    return bool(asked.spaces) and bool(space) and "*" not in space and space not in asked.spaces


def _is_for_every(parameter: LaunchParameter, _nodes: tuple[str, ...]) -> bool:
    return parameter.node == EVERY_NODE


def _is_for_any(parameter: LaunchParameter, nodes: tuple[str, ...]) -> bool:
    return parameter.node is not None and parameter.node.rpartition("/")[2] in nodes


def parameter_files(folder: Path, within: tuple[str, ...] = _FOLDERS) -> Iterator[Path]:
    """Yield the YAML files of a package that may hold parameters, at most 200."""
    count = 0
    for name in within:
        for path in files_below(folder / name, ".yaml"):
            count += 1
            if count > _MOST_FILES:
                return
            yield path


def _parameters(path: Path) -> tuple[LaunchParameter, ...]:
    try:
        text = read_text(path) if path.stat().st_size <= _MOST_BYTES else ""
        return node_parameters(yaml_value(text)) if "ros__parameters" in text else ()
    except (OSError, ParameterTextError):
        # It may be of anything: what is not a file of parameters gives none.
        return ()
