"""Read one ROS 2 launch file, in a process of its own: `python -m ...launch.launch_child`.

On standard input comes JSON: `path`, `packages` (names and folders), `import_paths`, and
`installed`, the folders of Python modules of an installed ROS. What the file starts goes to
standard output, as JSON. A launch file is a program: it may never end, may print, and may do
anything. So the process has limits, and it writes nothing but in its own temporary folder, starts
no other program and speaks to nobody.
"""

from __future__ import annotations

import contextlib
import dataclasses
import importlib.abc
import importlib.machinery
import json
import os
import pkgutil
import resource
import sys
import tempfile
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from tracerisk.common.sandbox.limited_process import end_with, limit_memory, mark_start
from tracerisk.pipeline.launch_files.moveit_configs import moveit_configs_modules
from tracerisk.pipeline.launch_files.placeholders import (
    ABSENT_FOLDER,
    Absent,
    AbsentFinder,
    AbsentModule,
)
from tracerisk.pipeline.launch_files.robot_sources import is_robot_file, robots_read
from tracerisk.pipeline.launch_files.visit import visit
from tracerisk.ros.imports.installed_libraries import InstalledLibraries

if TYPE_CHECKING:
    from tracerisk.pipeline.launch_files.visit import Described

FILE_BYTES = 16 * 1024**2
_STAND_INS = ("launch", "launch_ros")
_ALSO = {
    "launch.event": "launch.events",
    "launch.event_handler": "launch.event_handlers",
    "launch.invalid_launch_file_error": "launch.launch_description_sources",
    "launch.launch_description_entity": "launch.launch_description",
    "launch.launch_introspector": "launch.launch_service",
    "launch_xml": "launch",
    "launch_yaml": "launch",
    "launch_xml.launch_description_sources": "launch.launch_description_sources",
    "launch_yaml.launch_description_sources": "launch.launch_description_sources",
}
_FORBIDDEN = frozenset(
    {
        "os.exec",
        "os.fork",
        "os.forkpty",
        "os.kill",
        "os.killpg",
        "os.posix_spawn",
        "os.spawn",
        "os.system",
        "pty.spawn",
        "socket.bind",
        "socket.connect",
        "socket.sendto",
        "subprocess.Popen",
    }
)
_CHANGES = frozenset(
    {
        "os.chmod",
        "os.chown",
        "os.link",
        "os.mkdir",
        "os.remove",
        "os.rename",
        "os.rmdir",
        "os.symlink",
        "os.truncate",
        "shutil.rmtree",
    }
)
_WRITES = os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND


def main() -> int:
    """Read the file that standard input names."""
    limit_memory()
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_BYTES, FILE_BYTES))
    asked = json.load(sys.stdin)
    packages = {name: Path(folder) for name, folder in asked["packages"].items()}
    # What a launch file prints goes to standard error; only the answer is one.
    with contextlib.redirect_stdout(sys.stderr):
        sys.dont_write_bytecode = True
        read: list[Path] = []
        robots: list[Described] = []
        _serve(packages, read, robots)
        sys.path += asked["import_paths"]
        folders = [Path(item) for item in asked["installed"]]
        sys.meta_path.insert(0, _InstalledOrAbsent(folders, sys.modules))
        sys.argv = ["launch"]
        with tempfile.TemporaryDirectory(prefix="tracerisk-launch-") as folder:
            tempfile.tempdir = folder
            mark_start()
            _forbid(folder, robots)
            given = [(str(name), str(value)) for name, value in asked["arguments"]]
            reading = visit(Path(asked["path"]), packages, robots, given)
            reading.sources += (path for path in read if path not in reading.sources)
    sys.stdout.write(
        json.dumps(
            {
                "nodes": [dataclasses.asdict(node) for node in reading.nodes],
                "sources": [str(path) for path in reading.sources],
                "problems": reading.problems,
                "robots": [
                    dataclasses.asdict(robot_source) for robot_source in robots_read(reading.robots)
                ],
            }
        )
    )
    return 0


def _serve(packages: dict[str, Path], read: list[Path], robots: list[Described]) -> None:
    """Put the stand-ins where launch files import them from.

    What they read goes to `read`, what of that describes a robot to `robots`.
    """
    home = f"{__package__}.stand_ins"
    for top in _STAND_INS:
        package = importlib.import_module(f"{home}.{top}")
        sys.modules[top] = package
        for walk_package in pkgutil.walk_packages(package.__path__, f"{home}.{top}."):
            module = importlib.import_module(walk_package.name)
            sys.modules[walk_package.name.removeprefix(f"{home}.")] = module
            # The library has a package where one module serves it here.
            vars(module).setdefault("__path__", [])
    for name, served in _ALSO.items():
        sys.modules[name] = sys.modules[served]
    # What is installed here may differ from what is installed where the file is launched.
    for name in ("ament_index_python", "ament_index_python.packages"):
        sys.modules[name] = _ament_index(packages)
    sys.modules.update(moveit_configs_modules(packages, read.append, robots.append))
    finder = AbsentFinder(_STAND_INS)
    # It would look for packages where they are installed, and a controller needs no URDF.
    sys.modules["xacro"] = _xacro(robots)
    sys.meta_path += [_Submodules(), finder]


def _xacro(robots: list[Described]) -> ModuleType:
    """Return a module whose documents are absent; what it is called with goes to `robots`."""

    class Document(Absent):
        def __init__(self, path: str) -> None:
            super().__init__("the output of xacro")
            self.xacro_path = path

    def parse(inp: Any, filename: str | None = None) -> Document:
        return Document(filename or getattr(inp, "name", None) or "")

    def process_doc(doc: Any, mappings: Any = None, **_: Any) -> None:
        if isinstance(doc, Document) and doc.xacro_path:
            given = mappings if isinstance(mappings, dict) else {}
            robots.append((doc.xacro_path, given))

    def process_file(input_file_name: Any, mappings: Any = None, **_: Any) -> Absent:
        if isinstance(input_file_name, Absent):
            return input_file_name
        document = Document(os.fspath(input_file_name))
        process_doc(document, mappings)
        return document

    module = AbsentModule("xacro")
    vars(module).update(
        parse=parse,
        process=process_file,
        process_doc=process_doc,
        process_file=process_file,
    )
    return module


def _ament_index(packages: dict[str, Path]) -> ModuleType:
    module = ModuleType("ament_index_python.packages")

    def folder_of(package_name: str, **_: Any) -> str:
        """Return the folder of a package; where it is not here, one that is not there either."""
        folder = packages.get(package_name)
        return str(folder) if folder is not None else str(ABSENT_FOLDER / package_name)

    vars(module).update(
        PackageNotFoundError=type("PackageNotFoundError", (KeyError,), {}),
        get_package_prefix=folder_of,
        get_package_share_directory=folder_of,
        get_package_share_path=lambda name, **_: Path(folder_of(name)),
        get_packages_with_prefixes=lambda: {n: str(p) for n, p in packages.items()},
        packages=module,
    )
    return module


class _InstalledOrAbsent(InstalledLibraries):
    """Finds modules of an installed ROS; one that does not run here is as one that is not there."""

    def find_spec(
        self, fullname: str, path: Any = None, target: Any = None
    ) -> importlib.machinery.ModuleSpec | None:
        """Return the spec of a module of a prefix, `None` for what is none."""
        spec = super().find_spec(fullname, path, target)
        if spec is not None and isinstance(spec.loader, SourceFileLoader):
            spec.loader = _OrAbsent(spec.loader)
        return spec


class _OrAbsent(importlib.abc.Loader):
    def __init__(self, loader: SourceFileLoader) -> None:
        self._loader = loader

    def exec_module(self, module: ModuleType) -> None:
        """Run the source; where that fails, all names of the module are absent."""
        try:
            self._loader.exec_module(module)
        except Exception:  # noqa: BLE001 - it is written for real ROS, and anything may be lacking
            absent = AbsentModule(module.__name__)
            absent.__path__ = []
            sys.modules[module.__name__] = absent


class _Submodules(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Finds `launch.actions.timer_action` and the like: names of the module above."""

    def find_spec(
        self,
        fullname: str,
        path: Any = None,  # noqa: ARG002 - the import system gives it
        target: Any = None,  # noqa: ARG002
    ) -> importlib.machinery.ModuleSpec | None:
        """Return a spec for a module below one that the stand-ins have."""
        above = fullname.rpartition(".")[0]
        if above.partition(".")[0] not in _STAND_INS or above in _STAND_INS:
            return None
        return importlib.machinery.ModuleSpec(fullname, self)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType:
        """Return a module with the names of the module above it."""
        module = ModuleType(spec.name)
        vars(module).update(
            {
                name: value
                for name, value in vars(sys.modules[spec.name.rpartition(".")[0]]).items()
                if not name.startswith("_")
            }
        )
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Do nothing: the names are there."""


def _forbid(folder: str, robots: list[Described]) -> None:
    """Refuse from here on what a file that only describes has no need to do.

    Files of robots that it opens go to `robots`.
    """

    def check(event: str, arguments: tuple[Any, ...]) -> None:
        if event in _FORBIDDEN:
            raise PermissionError(f"a launch file that is read may not do {event}")
        if event in _CHANGES and not _is_within(arguments[0]):
            raise PermissionError(f"a launch file that is read may not do {event}")
        if event == "open" and _is_write(*arguments[:3]) and not _is_within(arguments[0]):
            raise PermissionError(f"a launch file that is read may not write {arguments[0]}")
        if event == "open" and isinstance(arguments[0], (str, bytes)):
            path = os.path.realpath(os.fsdecode(arguments[0]))
            if is_robot_file(path):
                robots.append((path, {}))

    def _is_within(path: Any) -> bool:
        if isinstance(path, int):
            return True
        full = os.path.realpath(os.fsdecode(path))
        return full == folder or full.startswith(folder + os.sep) or full == os.devnull

    def _is_write(_path: Any, mode: Any, flags: Any) -> bool:
        if isinstance(mode, str):
            return any(char in mode for char in "wax+")
        return isinstance(flags, int) and bool(flags & _WRITES)

    folder = os.path.realpath(folder)
    sys.addaudithook(check)


if __name__ == "__main__":
    end_with(main)
