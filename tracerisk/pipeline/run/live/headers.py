"""C++ headers of the messages that sources include and a machine lacks."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from tracerisk.common.dependencies import require_linux
from tracerisk.common.text.bounded import file_bytes, files_below
from tracerisk.errors import InputError, Location, readable
from tracerisk.instrument.source.language import is_c
from tracerisk.instrument.source.ros_version import ros_version
from tracerisk.pipeline.trace.compiled.includes import included_files
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.prefixes import with_interfaces
from tracerisk.pipeline.workspace.workspace import workspace_of
from tracerisk.ros.live.messages.headers import include_folders, make_headers
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.vendors.driver_search import definitions_of, shipped_drivers


def headers_for(named: Sequence[Path], out: Path) -> tuple[str, ...]:
    """Make in `out` the headers that C++ sources, or those in folders, include and nobody has.

    So are those that headers of their own include.
    Return the packages that were made, sorted.

    Raises:
        InputError: a name is neither that of a folder nor of a C or C++ source, or there is none;
            `out` is no folder.
        DependencyError: there is no ROS 1, or no gencpp.
    """
    require_linux("making headers of messages")
    if out.exists() and not out.is_dir():
        raise InputError("is no folder; name one for the headers", Location(str(out)))
    files: list[Path] = []
    for path in named:
        found = [item for item in files_below(path) if is_c(item.name)]
        if not found and not (is_c(path.name) and path.is_file()):
            raise InputError(
                "is neither a C or C++ source nor a folder with any; name what includes the "
                "headers of messages",
                Location(str(path)),
            )
        files += found or [path]
    sources = {}
    for path in files:
        with readable(path):
            sources[str(path.resolve())] = file_bytes(path)
    controller = load_controller(files[0])
    for file in included_files(sources, controller.root):
        sources[file] = file_bytes(controller.root / file)
    workspace = workspace_of(controller, controller.settings)
    more, installed = definitions_of(shipped_drivers()), with_interfaces(workspace.installed)
    interfaces = Interfaces(workspace.interfaces, more, installed)
    folders = [folder for folder in include_folders(os.environ) if folder != out]
    is_ros2 = any(ros_version(path, controller.root) == 2 for path in files)
    return make_headers(interfaces, sources.values(), out, folders, 2 if is_ros2 else 1)
