"""The modules of its own project that a controller imports, found without running it."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from tracerisk.common.text.bounded import file_bytes
from tracerisk.instrument.source.python_source import decoded
from tracerisk.pipeline.workspace.controller import Controller

_MOST_MODULES = 100


def own_modules(controller: Controller) -> tuple[Path, ...]:
    """Return the modules below the project's top that the script imports, and these in turn.

    They are in the order in which they are met; what cannot be read or parsed imports nothing.
    """
    top, imports = controller.project.top, controller.project.imports
    bases = _bases(controller)
    script = controller.path.resolve()
    modules: dict[Path, None] = {}
    waiting = list(_imported(imports(controller.source), script, bases))
    while waiting and len(modules) < _MOST_MODULES:
        path = waiting.pop(0)
        if path in modules or path == script or not path.is_relative_to(top):
            continue
        modules[path] = None
        waiting += _imported(imports(source_bytes(path)), path, bases)
    return tuple(modules)


def imported_directly(controller: Controller) -> frozenset[Path]:
    """Return the modules of the project that the script itself names in its imports.

    The packages that they are in, which Python runs before them, are none unless they are named.
    """
    script = controller.path.resolve()
    bases = _bases(controller)
    own = frozenset(own_modules(controller))
    named: set[Path] = set()
    for level, parts in controller.project.imports(controller.source):
        above = tuple(script.parents)[:level]
        files = list(module_files(parts, above[-1:] if level else bases))
        if not files:
            continue
        last = files[-1]
        name = parts[-1] if parts else ""
        if last in own and name in (last.stem, last.parent.name):
            named.add(last)
    return frozenset(named)


def with_own_modules(controller: Controller) -> Controller:
    """Return the controller with the sources of its own modules behind that of its script.

    For those who look for names of joints, groups and robots in it; it is not the one that runs.
    """
    tree = controller.project.tree
    modules = map(source_bytes, own_modules(controller))
    texts = [decoded(controller.source), *(decoded(source) for source in modules if tree(source))]
    # Two lines before it, so that no line is taken for a declaration of the encoding.
    source = "\n\n".join(("", *texts, "")).encode()
    return replace(controller, source=source) if tree(source) else controller


def _bases(controller: Controller) -> tuple[Path, ...]:
    """Return the folders in which a build, or Python itself, would look for modules."""
    root = controller.root.resolve()
    workspace = controller.workspace
    folders = (
        controller.path.resolve().parent,
        root,
        root / "src",
        *workspace.import_paths,
        *workspace.packages.values(),
    )
    return tuple(dict.fromkeys(folders))


def _imported(
    imports: Iterable[tuple[int, tuple[str, ...]]], file: Path, bases: tuple[Path, ...]
) -> Iterator[Path]:
    for level, parts in imports:
        above = tuple(file.parents)[:level]
        # Last, what stands beside it: there Python 2 looks, without a dot.
        yield from module_files(parts, above[-1:] if level else (*bases, file.parent))


def names_in(folder: str) -> frozenset[str]:
    """Return the names in a folder, those of folders with a slash; none where it is not there."""
    try:
        with os.scandir(folder) as entries:
            return frozenset(
                f"{entry.name}/" if entry.is_dir() else entry.name for entry in entries
            )
    except OSError:
        return frozenset()


def module_files(
    parts: Sequence[str],
    bases: Iterable[Path],
    names: Callable[[str], Collection[str]] = names_in,
) -> Iterator[Path]:
    """Yield the files that are run where a module is imported: those of its packages, and its.

    `names` returns the names in a folder; who asks often hands one that remembers them.
    """
    for base in bases:
        there, module, folder = [], [], str(base)
        for number, part in enumerate(parts, 1):
            known = names(folder)
            if number == len(parts) and f"{part}.py" in known:
                module = [f"{folder}/{part}.py"]
            if f"{part}/" not in known:
                break
            folder = f"{folder}/{part}"
            if "__init__.py" in names(folder):
                there.append(f"{folder}/__init__.py")
        if there or module:
            yield from map(Path, there + module)
            return


def source_bytes(path: Path) -> bytes:
    """Return what a file holds, nothing where it cannot be read."""
    try:
        return file_bytes(path)
    except OSError:
        return b""
