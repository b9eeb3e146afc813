"""Instrument every module that a controller imports from under its root, in memory.

Nothing is written beside the sources, no `__pycache__` either. Modules of installed libraries,
of Python itself and of tracerisk are left alone wherever they stand.
"""

from __future__ import annotations

import contextlib
import sys
import sysconfig
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from importlib.abc import MetaPathFinder
from importlib.machinery import FrozenImporter, ModuleSpec, PathFinder, SourceFileLoader
from importlib.util import spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType

from tracerisk.common.settings.python_here import foreign_folders
from tracerisk.instrument.hidden_frames import hide
from tracerisk.instrument.loader import ON_DISK, Sources, compile_file
from tracerisk.instrument.python_2.loader import ConvertingLoader
from tracerisk.instrument.tracer import Tracer

_INSTALLED = frozenset({"site-packages", "dist-packages"})


class ControllerFinder(MetaPathFinder):
    """Finds those modules that a controller imports and that are its own.

    A module below `root` is traced. `packages` maps the name of a Python package of the
    workspace to the folder that holds it; those are importable as if they were built, and go
    before what is installed for Python.
    Top-level names in `reserved` are left to another finder. So are those in `shared`, unless the
    controller has a real Python package of that name (a mere script may share its name with the
    messages it uses). `elsewhere` is asked last: for the folder of a module that is nowhere on the
    path.
    `is_library` returns whether a file below the root is library code.
    """

    def __init__(
        self,
        tracer: Tracer,
        root: Path,
        *,
        packages: Mapping[str, Path] | None = None,
        reserved: Collection[str] = (),
        shared: Collection[str] = (),
        elsewhere: Callable[[str], Path | None] = lambda _: None,
        is_library: Callable[[Path], bool] = lambda _: False,
        sources: Sources = ON_DISK,
    ) -> None:
        self._tracer = tracer
        self._root = root.resolve()
        self._packages = dict(packages or {})
        self._reserved = frozenset(reserved)
        self._shared = frozenset(shared)
        self._elsewhere = elsewhere
        self._is_library = is_library
        self._sources = sources
        self._foreign = foreign_folders()

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        """Return the spec of a module of the controller or its workspace, else None."""
        top = fullname.partition(".")[0]
        if top in self._reserved or fullname in sys.builtin_module_names:
            return None
        spec = PathFinder.find_spec(fullname, path, target)
        if path is None and fullname in self._packages and not _is_beside_script(spec):
            # As if built: what `import` finds beside the script comes first, as a whole package,
            # and what is installed for Python comes last.
            spec = PathFinder.find_spec(fullname, [str(self._packages[fullname])], target)
        if spec is None and path is None and self._is_unknown(fullname):
            folder = self._elsewhere(fullname)
            if folder is not None:
                self._packages[fullname] = folder
                spec = PathFinder.find_spec(fullname, [str(folder)], target)
        if spec is None or (path is None and fullname in self._shared and not _is_package(spec)):
            return None
        if spec.loader is None:
            # A namespace package: the folder of a workspace package that has no `__init__.py`.
            return spec if fullname in self._packages else None
        if not isinstance(spec.loader, SourceFileLoader) or spec.origin is None:
            return None
        if FrozenImporter.find_spec(fullname) is not None:
            return None
        if not self.is_own(Path(spec.origin)):
            # Return it here: the other finder for this name serves only its interfaces and would
            # not look in this folder.
            spec.loader = ConvertingLoader(fullname, spec.origin)
            return spec if top in self._packages else None
        return spec_from_file_location(
            fullname,
            spec.origin,
            loader=_TracedLoader(
                fullname,
                spec.origin,
                self._tracer,
                self._root,
                is_library=self._is_library(Path(spec.origin)),
                sources=self._sources,
            ),
            submodule_search_locations=spec.submodule_search_locations,
        )

    def _is_unknown(self, name: str) -> bool:
        return name not in self._shared and name not in sys.stdlib_module_names

    def is_own(self, file: Path) -> bool:
        """Return whether a file is the controller's own source."""
        resolved = file.resolve()
        if not resolved.is_relative_to(self._root):
            return False
        if _INSTALLED.intersection(resolved.relative_to(self._root).parts):
            return False
        return not any(resolved.is_relative_to(folder) for folder in self._foreign)


@contextlib.contextmanager
def controller_imports(finder: ControllerFinder) -> Iterator[None]:
    """Route the controller's imports through `finder` until closed; its modules go with it."""
    before = set(sys.modules)
    sys.meta_path.insert(0, finder)
    try:
        yield
    finally:
        sys.meta_path.remove(finder)
        for name in set(sys.modules) - before:
            loader = getattr(getattr(sys.modules[name], "__spec__", None), "loader", None)
            if isinstance(loader, _TracedLoader):
                del sys.modules[name]


class _TracedLoader(SourceFileLoader):
    """Compiles a module with its tracing decorators; reads and writes no bytecode."""

    def __init__(
        self,
        fullname: str,
        path: str,
        tracer: Tracer,
        root: Path,
        *,
        is_library: bool,
        sources: Sources,
    ) -> None:
        super().__init__(fullname, path)
        self._is_library = is_library
        self._tracer = tracer
        self._root = root
        self._sources = sources

    def get_code(self, fullname: str) -> CodeType:
        path = Path(self.get_filename(fullname))
        return compile_file(path, self._root, sources=self._sources)[0]

    @hide
    def exec_module(self, module: ModuleType) -> None:
        path = Path(self.get_filename(module.__name__))
        on_source = None if self._is_library else self._tracer.on_source
        code, file = compile_file(path, self._root, on_source, self._sources)
        # There is no bytecode file, and without one Python sets no `__cached__`.
        module.__dict__.pop("__cached__", None)
        self._tracer.run_module(code, module.__dict__, file, is_library=self._is_library)


def _is_package(spec: ModuleSpec | None) -> bool:
    return spec is not None and bool(spec.submodule_search_locations) and spec.loader is not None


def _is_beside_script(spec: ModuleSpec | None) -> bool:
    """Return whether a package was found, and not among what is installed for Python."""
    installed = sysconfig.get_path("purelib")
    return _is_package(spec) and not Path(str(spec and spec.origin)).is_relative_to(installed)
