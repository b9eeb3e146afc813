"""Trace what the controller imports of its own, and change the libraries that it imports."""

from __future__ import annotations

import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any, Sequence

from tracerisk_probe import stacks
from tracerisk_probe.libraries import HOOKS
from tracerisk_probe.rewriting import compile_traced

_INSTALLED = frozenset({"site-packages", "dist-packages"})
_ROOT_MARKS = ("package.xml", "pyproject.toml", "setup.py", ".git")


def root_of(script: Path) -> Path:
    """Return the nearest folder upwards that is a package or repository, else the script's own."""
    folder = script.resolve().parent
    for each in (folder, *folder.parents):
        if any((each / mark).exists() for mark in _ROOT_MARKS):
            return each
    return folder


class Own:
    """Which files are the controller's own, and what stacks call them."""

    def __init__(self, root: Path, packages: Sequence[str] = ()) -> None:
        self._root = root.resolve()
        self._packages = frozenset(packages)
        self._foreign = tuple({Path(sys.prefix).resolve(), Path(sys.base_prefix).resolve()})

    def name_of(self, path: Path, module: str = "") -> str | None:
        """Return the name of a file; None where it is not the controller's own."""
        resolved = path.resolve()
        top = module.partition(".")[0]
        if top in self._packages:
            depth = module.count(".") + (1 if resolved.name == "__init__.py" else 0)
            return "/".join(resolved.parts[-depth - 1 :])
        if self._root not in resolved.parents:
            return None
        inside = resolved.relative_to(self._root)
        if _INSTALLED.intersection(inside.parts):
            return None
        for folder in self._foreign:
            # An environment below the root is not the controller's; a root below /usr is.
            if folder in resolved.parents and self._root in folder.parents:
                return None
        return inside.as_posix()


class Finder(MetaPathFinder):
    """Finds modules as the others do, and has those of the controller traced, hooks called."""

    def __init__(self, own: Own) -> None:
        self._own = own

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,
    ) -> ModuleSpec | None:
        """Return the spec of a module with a loader of ours, None where it needs none."""
        if fullname.partition(".")[0] == __package__:
            return None
        spec = self._found(fullname, path, target)
        if spec is None or spec.loader is None:
            return None
        if fullname in HOOKS:
            spec.loader = _Hooked(spec.loader)
            return spec
        if type(spec.loader) is not SourceFileLoader or spec.origin is None:
            return None
        name = self._own.name_of(Path(spec.origin), fullname)
        if name is None:
            return None
        spec.loader = _Traced(fullname, spec.origin, name)
        spec.cached = None
        return spec

    def _found(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None
    ) -> ModuleSpec | None:
        for finder in sys.meta_path:
            if finder is not self and hasattr(finder, "find_spec"):
                spec: ModuleSpec | None = finder.find_spec(fullname, path, target)
                if spec is not None:
                    return spec
        return None


class _Traced(SourceFileLoader):
    def __init__(self, fullname: str, path: str, file: str) -> None:
        super().__init__(fullname, path)
        self._file = file

    def get_code(self, fullname: str) -> CodeType | None:
        path = self.get_filename(fullname)
        try:
            return compile_traced(self.get_data(path), self._file, path)
        except (RecursionError, MemoryError):
            return super().get_code(fullname)

    def exec_module(self, module: ModuleType) -> None:
        code = self.get_code(module.__name__)
        if code is not None:
            stacks.run_module(code, module.__dict__, self._file)


class _Hooked(Loader):
    """A loader that calls the hook of a module when the module is loaded."""

    def __init__(self, loader: Any) -> None:
        self._loader = loader

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        found: ModuleType | None = self._loader.create_module(spec)
        return found

    def exec_module(self, module: ModuleType) -> None:
        self._loader.exec_module(module)
        call_hook(module.__name__, module)


def call_hook(name: str, module: ModuleType) -> None:
    """Change a library's module; one that is of another make is left as it is, and said."""
    try:
        HOOKS[name](module)
    except (AttributeError, TypeError, ValueError) as error:
        sys.stderr.write(f"tracerisk-probe: {name} is not recorded: {error}\n")


def trace_imports(own: Own) -> None:
    """Trace what is imported from now on; change what was imported already."""
    sys.meta_path.insert(0, Finder(own))
    for name in HOOKS:
        module = sys.modules.get(name)
        if module is not None:
            call_hook(name, module)


def compiled(path: Path, own: Own) -> tuple[CodeType, str | None]:
    """Return the code of a script, and its name where it is traced."""
    source = path.read_bytes()
    name = own.name_of(path) if path.suffix == ".py" else None
    if name is None:
        return compile(source, str(path), "exec", dont_inherit=True), None
    return compile_traced(source, name, str(path)), name
