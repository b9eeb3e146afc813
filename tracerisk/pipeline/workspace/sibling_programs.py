"""The programs beside a controller: those of one folder are written for one robot."""

from __future__ import annotations

from pathlib import Path

from tracerisk.common.text.bounded import file_bytes, in_folder
from tracerisk.pipeline.workspace.controller import Controller

_MOST = 40
_MOST_BYTES = 256 * 1024
_NO_PROGRAMS = frozenset({"setup.py", "conftest.py", "__init__.py"})


def sibling_programs(controller: Controller) -> tuple[Controller, ...]:
    """Return the other Python files in the folder of a controller, sorted by their names.

    What cannot be read, a launch file or a file of tests is none of them.
    """
    script = controller.path.resolve()
    root = controller.root.resolve()
    controllers: list[Controller] = []
    for path in in_folder(script.parent, ".py"):
        is_other = path != script and path.name not in _NO_PROGRAMS
        if not is_other or path.name.startswith("test_") or len(controllers) >= _MOST:
            continue
        source = _source(path)
        if source and controller.project.tree(source) is not None:
            file = path.relative_to(root).as_posix()
            controllers.append(Controller(path, controller.project, file, source))
    return tuple(controllers)


def _source(path: Path) -> bytes:
    """Return the bytes of a program, none for what is not one."""
    try:
        source = file_bytes(path, _MOST_BYTES)
    except OSError:
        return b""
    return b"" if b"generate_launch_description" in source else source
