"""Python libraries of an installed ROS and of overlays, which run on the stand-ins.

Only their sources are run. What is compiled there is made for real nodes, and so are the classes of
messages: those are made from the texts of their definitions.
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Collection, Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from importlib.abc import MetaPathFinder
from importlib.machinery import EXTENSION_SUFFIXES, FileFinder, ModuleSpec
from pathlib import Path
from types import ModuleType

from tracerisk.config import PACKAGE_FILE
from tracerisk.instrument.python_2.loader import ConvertingLoader
from tracerisk.ros.imports.vendor_libraries import is_installed

_GENERATED = frozenset({"msg", "srv", "action"})
_COMPILED = (*EXTENSION_SUFFIXES, ".so")
_MODULE = re.compile(r"([A-Za-z_]\w*)(\.py)?")


class InstalledLibraries(MetaPathFinder):
    """Finds modules in the `folders` of prefixes that nothing on Python's own path has.

    `reserved` are the top names of stand-ins that do not give way.
    `interfaces` are the packages whose messages are made from texts: of these only those are
    found that hold other modules besides.
    """

    def __init__(
        self,
        folders: Sequence[Path],
        reserved: Collection[str] = (),
        interfaces: Collection[str] = (),
    ) -> None:
        self._folders = tuple(map(str, folders))
        self._reserved = frozenset(reserved)
        self._interfaces = frozenset(interfaces)

    @contextmanager
    def active(self) -> Iterator[None]:
        """Find modules while this is open."""
        sys.meta_path.insert(0, self)
        try:
            yield
        finally:
            sys.meta_path.remove(self)

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,  # noqa: ARG002
    ) -> ModuleSpec | None:
        """Return the spec of a module of a prefix, `None` for what is none.

        Raises ModuleNotFoundError for one that is there in compiled form alone.
        """
        top, _, rest = fullname.partition(".")
        if path is None:
            if top not in self._tops or top in self._reserved or is_installed(top):
                return None
            return next(filter(None, (_source(fullname, tops) for tops in self._tops[top])), None)
        if rest.partition(".")[0] in _GENERATED and top in self._interfaces:
            return None
        inside = [name for name in path if self._holds(name)]
        for folder in inside:
            spec = _source(fullname, folder)
            if spec is not None:
                return spec
            _refuse_compiled(fullname, folder)
        return None

    def _holds(self, folder: str) -> bool:
        return any(folder == name or folder.startswith(name + os.sep) for name in self._folders)

    @cached_property
    def _tops(self) -> dict[str, list[str]]:
        """The top names of modules, each with the folders that have it.

        Where a package has its sources, only its Python packages would be installed.
        """
        tops: dict[str, list[str]] = {}
        for folder in self._folders:
            is_source = Path(folder, PACKAGE_FILE).is_file()
            for name in _names_in(folder):
                match = _MODULE.fullmatch(name)
                if match is None or (is_source and not Path(folder, name, "__init__.py").is_file()):
                    continue
                is_messages = match[1] in self._interfaces and not _has_code(folder, match[1])
                if not is_messages:
                    tops.setdefault(match[1], []).append(folder)
        return tops


def _source(fullname: str, folder: str) -> ModuleSpec | None:
    return FileFinder(folder, (ConvertingLoader, [".py"])).find_spec(fullname)


def _refuse_compiled(fullname: str, folder: str) -> None:
    leaf = fullname.rpartition(".")[2]
    names = _names_in(folder)
    if any(name.startswith(f"{leaf}.") and name.endswith(_COMPILED) for name in names):
        raise ModuleNotFoundError(
            f"No module named '{fullname}' that can be run here: {folder} has it in compiled form, "
            "and of an installed ROS only Python sources are run",
            name=fullname,
        )


def _has_code(folder: str, package: str) -> bool:
    """Return whether a generated package of messages holds modules of its own besides."""
    top = Path(folder, package)
    for name in _names_in(str(top)):
        if name.endswith(".py") and name != "__init__.py":
            return True
        is_own = name not in _GENERATED and not name.startswith(("_", "."))
        if is_own and (top / name / "__init__.py").is_file():
            return True
    return False


def _names_in(folder: str) -> list[str]:
    try:
        return sorted(os.listdir(folder))  # noqa: PTH208 - hundreds, of which few are looked at
    except OSError:
        return []
