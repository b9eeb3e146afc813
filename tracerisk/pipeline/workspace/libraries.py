"""Which of a controller's own files are library code: their functions are never its steps.

A step is a function of the program that asks for motions. What several programs share serves them
all, as an installed library would, and so do its functions: they stand on no stack of a command,
so that a step has one name whether the library is installed, or lies in the same repository.

A file below the controller's root is library code where

- it belongs to another package: a folder between it and the root is one;
- it lies in a folder for others' code (`third_party`, `vendor`, ...);
- another program of the project imports it, at first hand or not. Tests are no programs, nor are
  modules of the controller itself, and what a program imports through the controller's script
  is the controller's.

A file with a function that `states` names is none.
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterator
from functools import cached_property, lru_cache
from pathlib import Path

from tracerisk.adder.sources.python_lines import parse_python
from tracerisk.common.limits import is_secret
from tracerisk.common.text.bounded import file_bytes, regular_file
from tracerisk.config import controller_root
from tracerisk.errors import TraceRiskError
from tracerisk.instrument.source.function_definitions import definitions
from tracerisk.pipeline.workspace.console_scripts import console_scripts, read_or_nothing
from tracerisk.pipeline.workspace.own_modules import module_files, names_in
from tracerisk.pipeline.workspace.package_folders import NOT_SEARCHED
from tracerisk.pipeline.workspace.project import Project
from tracerisk.pipeline.workspace.workspace import TESTS, searched

_OF_OTHERS = frozenset(
    {"3rdparty", "_vendor", "extern", "external", "third_party", "thirdparty", "vendor", "vendored"}
)
_MOST_FILES = 3000
_FROM = re.compile(
    r"^[ \t]*from[ \t]+(\.*)([\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n#;]*)", re.MULTILINE
)
_IMPORT = re.compile(r"^[ \t]*import[ \t]+([^\n#;]+)", re.MULTILINE)
_NAMED = re.compile(r"([\w.]+)(?:\s+as\s+\w+)?")
_STARTS = re.compile(r"\A#!.*python|^if[ (]+__name__\s*==|^main\(", re.MULTILINE)
_TEST_FILE = re.compile(r"test_.*|.*_test|conftest|setup")


class Libraries:
    """The library code among the files of the controller `script` of a project.

    `states` are the qualified names that a user declared as steps. Files are read when the
    first of them is asked for.
    """

    def __init__(self, script: Path, project: Project, states: Collection[str] = ()) -> None:
        self._script = script.resolve()
        self._project = project
        self._root = project.root.resolve()
        self._states = frozenset(states)
        self._known: dict[Path, bool] = {}
        self._imports = lru_cache(maxsize=None)(
            lambda file, bases: frozenset(self._looked_for(file, bases))
        )
        self._names_imported = lru_cache(maxsize=None)(_names_imported)
        self._names_in = lru_cache(maxsize=None)(names_in)
        self._modules = lru_cache(maxsize=None)(
            lambda parts, where: tuple(module_files(parts, where, self._names_in))
        )
        self._commands = lru_cache(maxsize=None)(_modules_of_commands)

    def holds(self, file: Path) -> bool:
        """Return whether a file below the root is library code."""
        path = file.resolve()
        if path not in self._known:
            self._known[path] = self._is_library(path)
        return self._known[path]

    def _is_library(self, path: Path) -> bool:
        if path == self._script or not path.is_relative_to(self._root):
            return False
        is_elsewhere = self._is_of_another_package(path) or self._is_of_others(path)
        if not is_elsewhere and path not in self._of_other_programs:
            return False
        return not (self._states and self._states & _functions(path))

    def _is_of_another_package(self, path: Path) -> bool:
        package = controller_root(path)
        return package != self._root and package.is_relative_to(self._root)

    def _is_of_others(self, path: Path) -> bool:
        own = self._script.relative_to(self._root).parts
        folders = path.relative_to(self._root).parts[:-1]
        return any(folder in _OF_OTHERS and folder not in own for folder in folders)

    @cached_property
    def _of_other_programs(self) -> frozenset[Path]:
        """The files that programs import which are no part of this controller."""
        mine = self._imported_by(self._script)
        other_programs: set[Path] = set()
        for program in self._programs:
            if program != self._script and program not in mine:
                other_programs |= self._imported_by(program)
        return frozenset(other_programs)

    @cached_property
    def _files(self) -> tuple[Path, ...]:
        top = self._project.top
        # A link may lead out of it.
        return tuple(path for path in _sources(top) if path.is_relative_to(top))

    @cached_property
    def _programs(self) -> tuple[Path, ...]:
        return tuple(path for path in self._files if self._is_program(path))

    @cached_property
    def _tops(self) -> frozenset[str]:
        """The names with which an import of something in the project may begin."""
        top = self._project.top
        folders = {part for path in self._files for part in path.relative_to(top).parts[:-1]}
        return frozenset(folders | {path.stem for path in self._files})

    @cached_property
    def _folders(self) -> tuple[Path, ...]:
        workspace = self._project.workspace()
        return (*workspace.import_paths, *workspace.packages.values())

    def _imported_by(self, program: Path) -> frozenset[Path]:
        """Return what a program imports, in turn too, but for what the script alone does."""
        root = controller_root(program)
        bases = (program.parent, root, root / "src", *self._folders)
        paths: set[Path] = set()
        waiting = [program]
        while waiting:
            new = self._imports(waiting.pop(), bases) - paths - {program, self._script}
            paths |= new
            waiting += new
        return frozenset(paths)

    def _looked_for(self, file: Path, bases: tuple[Path, ...]) -> Iterator[Path]:
        """Yield what a file imports that is looked for in `bases`."""
        package = file.parent
        while "__init__.py" in self._names_in(str(package)):
            package = package.parent
        first, *others = bases
        places = tuple(dict.fromkeys((first, package, *others)))
        for level, parts in self._names_imported(file):
            where = tuple(file.parents)[level - 1 : level] if level else places
            if level or parts[0] in self._tops:
                yield from self._modules(parts, where)

    def _is_program(self, path: Path) -> bool:
        if _STARTS.search(read_or_nothing(path)) is not None:
            return True
        return path.stem in self._commands(controller_root(path))


def _names_imported(file: Path) -> frozenset[tuple[int, tuple[str, ...]]]:
    """Return what a file names in its imports: the level of a relative one, and its parts."""
    return frozenset(_named(read_or_nothing(file)))


def _named(text: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    for dots, name, imported in _FROM.findall(text):
        parts = tuple(name.split(".")) if name else ()
        if parts:
            yield len(dots), parts
        for item in _NAMED.findall(imported.strip("() \t\r\n")):
            yield len(dots), (*parts, item)
    for names in _IMPORT.findall(text):
        for part in names.split(","):
            named = _NAMED.match(part.strip())
            if named is not None:
                yield 0, tuple(named[1].split("."))


def _modules_of_commands(root: Path) -> frozenset[str]:
    return frozenset(console_script.module for console_script in console_scripts(root))


def _functions(path: Path) -> set[str]:
    try:
        tree = parse_python(file_bytes(path), str(path)).tree
    except (OSError, TraceRiskError):
        return set()
    return {str(definition.name) for definition in definitions(tree)}


def _sources(top: Path) -> Iterator[Path]:
    """Yield the Python sources of a project that are no tests; scripts may have no ending.

    What no controller may read is not looked at either: it would count as refused to the run.
    """

    def all_sources() -> Iterator[Path]:
        for folder, files in searched(top, NOT_SEARCHED | TESTS, environments=False):
            for name in files:
                if is_secret(name):
                    continue
                path = Path(folder, name)
                is_python = path.suffix == ".py" and _TEST_FILE.fullmatch(path.stem) is None
                if is_python or (not path.suffix and _begins_as_script(path)):
                    yield path.resolve()

    return itertools.islice(all_sources(), _MOST_FILES)


def _begins_as_script(path: Path) -> bool:
    try:
        with regular_file(path) as stream:
            return re.match(rb"#!.*python", stream.readline(200)) is not None
    except OSError:
        return False
