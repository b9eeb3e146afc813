"""The modules that a controller imports and that are not there, reported all at once."""

from __future__ import annotations

import ast
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

from tracerisk.errors import Location, SourceError, TraceRiskError
from tracerisk.instrument.source.definitions.used_interfaces import imports_interfaces
from tracerisk.instrument.source.python_2 import RENAMED, walk_with_guards
from tracerisk.instrument.source.python_source import is_python_2, parse_source, parsed
from tracerisk.pipeline.workspace.controller import load_controller
from tracerisk.pipeline.workspace.own_modules import own_modules, source_bytes
from tracerisk.ros.controller.needs import FROM_USE
from tracerisk.ros.imports.vendor_libraries import may_stand_in, remedy

_INTERFACES = frozenset({"msg", "srv", "action"})


@dataclass(frozen=True, slots=True)
class MissingModules:
    """Finds what the script and its own modules lack."""

    script: Path
    """The file of the controller."""
    root: Path
    """The folder from which messages name files."""
    provided: Collection[str]
    """The names of modules that have stand-ins."""

    def sentence(self, failed: str) -> str:
        """Return what to say where the import of `failed` did: of all that would, with remedies.

        A module of its own that cannot be read goes first: whoever installs the others gets no
        further.
        """
        files = program_files(self.script)
        for path in files:
            shown = self._shown(path)
            hint = _unreadable(path, shown)
            if hint is not None:
                return hint
        return _sentence(self._missing(failed, files), self.provided)

    def replaceable(self, failed: str) -> Mapping[str, str]:
        """Return the modules that are missing where a placeholder may stand for each, else none.

        Each comes with what to do about it. A library that moves the robot, or is of ROS, has
        effects that no placeholder has. Of a package of messages, the program shows what it needs.
        """
        files = program_files(self.script)
        names = self._missing(failed, files)
        imported = [name.split(".") for name in self._imported(files)]
        # What is in `parts.srv` are definitions of a service, whatever the package is called.
        interfaces = {top for top, *below in imported if below[:1] and below[0] in _INTERFACES}
        of_messages = {name for name in interfaces if imports_interfaces(imported, name)}
        if not all(
            name in of_messages or (name not in interfaces and may_stand_in(name, self.provided))
            for name in names
        ):
            return {}
        return {
            name: f"{FROM_USE if name in of_messages else ''}{_remedy_words(name, self.provided)}"
            for name in names
        }

    def went_without(self, in_vain: Collection[str]) -> Iterator[tuple[str, Location]]:
        """Yield the modules that the program imports where it expects a failure, and where.

        `in_vain` are the top names of those that failed in the run; one that came at last, by
        another path, is none.
        """
        told = {name.partition(".")[0] for name in sys.modules}
        # Most runs miss nothing: their files are not read again.
        for path in program_files(self.script) if in_vain else ():
            for node, names in self._statements(path, guarded=True):
                for name in sorted({name.partition(".")[0] for name in names} - told):
                    if name in in_vain:
                        told.add(name)
                        yield name, Location(self._shown(path), node.lineno)

    def _missing(self, failed: str, files: Iterable[Path]) -> list[str]:
        """Return the top modules that are missing, the one whose import failed first."""
        top = failed.partition(".")[0]
        imported = (name.partition(".")[0] for name in self._imported(files))
        return [top, *_absent(imported, top)]

    def _shown(self, path: Path) -> str:
        try:
            return path.resolve().relative_to(self.root.resolve()).as_posix()
        except ValueError:
            return path.name

    def _imported(self, files: Iterable[Path]) -> Iterator[str]:
        """Yield the dotted names of the modules that files import, but for guarded imports."""
        for path in files:
            for _, names in self._statements(path, guarded=False):
                yield from names

    @staticmethod
    def _statements(path: Path, *, guarded: bool) -> Iterator[tuple[ast.stmt, list[str]]]:
        """Yield the imports of a file that are guarded, or are not, with the modules they name."""
        source = source_bytes(path)
        tree = parsed(source)
        if tree is None:
            return
        served = RENAMED if is_python_2(source) else ()
        for node, is_guarded in walk_with_guards(tree):
            names: list[str] = []
            if isinstance(node, ast.Import) and is_guarded == guarded:
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and is_guarded == guarded and not node.level:
                names = _modules_named(node)
            if isinstance(node, ast.stmt):
                yield node, [name for name in names if name not in served]


def program_files(script: Path) -> Sequence[Path]:
    """Return the files of a program: the script, and the modules of its own that it imports."""
    try:
        return (script, *own_modules(load_controller(script)))
    except TraceRiskError:
        return (script,)


def _modules_named(node: ast.ImportFrom) -> list[str]:
    """Return the dotted names of the modules that a statement names: `parts.msg`."""
    module = node.module or ""
    parts = [alias.name for alias in node.names if alias.name in _INTERFACES]
    if len(parts) == len(node.names) and "." not in module:
        return [f"{module}.{part}" for part in parts]
    return [module]


def _unreadable(path: Path, shown: str) -> str | None:
    """Return what keeps a source from being parsed, `None` for nothing."""
    try:
        parse_source(source_bytes(path), shown)
    except SourceError as error:
        return str(error)
    return None


def _absent(names: Iterable[str], known: str) -> Iterator[str]:
    for name in sorted(set(names) - {known, ""}):
        try:
            if find_spec(name) is None:
                yield name
        except ModuleNotFoundError:
            yield name
        except (ImportError, ValueError, TraceRiskError):
            # It is there, whatever is wrong with it.
            continue


def _remedy_words(name: str, provided: Collection[str]) -> str:
    result = remedy(name, provided)
    if result.distribution is None:
        return result.words
    return f"`pip install {result.distribution}` in {_ENVIRONMENT} gives the real one"


def _sentence(names: Sequence[str], provided: Collection[str]) -> str:
    """Return one sentence: those that one command installs together, then each other remedy."""
    groups: dict[str, list[str]] = {}
    commands: dict[str, str] = {}
    for name in names:
        result = remedy(name, provided)
        if result.distribution is not None:
            commands[name] = result.distribution
        else:
            groups.setdefault(result.words, []).append(name)
    parts = []
    if commands:
        distributions = " ".join(sorted(set(commands.values())))
        parts.append((list(commands), f"`pip install {distributions}` in {_ENVIRONMENT}"))
    parts += [(group, words) for words, group in groups.items()]
    parts.sort(key=lambda part: names.index(part[0][0]))
    if len(parts) == 1:
        group, words = parts[0]
        return f"No module named {_listed(group)}: {words}"
    text = "; ".join(f"{_listed(group)}: {words}" for group, words in parts)
    return f"No modules named {_listed(names)}; {text}"


_ENVIRONMENT = "the environment in which tracerisk runs"


def _listed(names: Sequence[str]) -> str:
    quoted = [f"'{name}'" for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} and {quoted[-1]}"
