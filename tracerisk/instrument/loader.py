"""Run a controller's instrumented source as the program `__main__`."""

from __future__ import annotations

import contextlib
import linecache
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from importlib.machinery import SourceFileLoader
from pathlib import Path
from types import CodeType, ModuleType

from tracerisk.common.text.bounded import file_bytes
from tracerisk.config import controller_root
from tracerisk.errors import InputError, Location
from tracerisk.instrument.hidden_frames import hidden_frames, hide
from tracerisk.instrument.marks.caught_exceptions import suppressed_reported
from tracerisk.instrument.marks.instrumented import TRACER_MODULE, InstrumentedSource
from tracerisk.instrument.tracer import Tracer
from tracerisk.instrument.transform import compile_instrumented


def source_key(file: str, source: bytes) -> str:
    """Return the name under which a source is kept once it is instrumented."""
    return f"{sha256(source).hexdigest()} {file}"


@dataclass(frozen=True, slots=True)
class Sources:
    """The sources that are compiled, by their names below the controller's root."""

    replaced: Mapping[str, bytes] = field(default_factory=dict)
    """What is compiled in the place of what the file of a name holds."""
    instrumented: Mapping[str, str] = field(default_factory=dict)
    """Texts that were instrumented before, by `source_key`: without them, libcst is imported."""

    def instrument(self, file: str, source: bytes) -> InstrumentedSource:
        """Return the source with its decorators; raises as `instrument_source`."""
        text = self.instrumented.get(source_key(file, source))
        if text is not None:
            return InstrumentedSource(file, source, text)
        from tracerisk.instrument.marks.decorators import instrument_source

        return instrument_source(source, file)


ON_DISK = Sources()
"""All sources are what the files hold."""


def compile_file(
    path: Path,
    root: Path,
    on_source: Callable[[str, bytes], None] | None = None,
    sources: Sources = ON_DISK,
) -> tuple[CodeType, str]:
    """Instrument and compile the file at `path`; return the code and its name below `root`.

    `on_source` is called with that name and the bytes that were compiled.

    Raises:
        InputError: there is no such file, or it cannot be read.
        SourceError: it is not Python.
        UnsafeRewriteError: it cannot be instrumented safely.
    """
    try:
        source = file_bytes(path)
    except OSError as error:
        raise InputError(
            f"the controller cannot be read: {error.strerror}; name a Python file",
            Location(str(path)),
        ) from error
    file = file_below(path, root)
    source = sources.replaced.get(file, source)
    code = compile_instrumented(sources.instrument(file, source), str(path))
    if on_source is not None:
        on_source(file, source)
    return code, file


def file_below(path: Path, root: Path) -> str:
    """Return `path` as a `FunctionRef` names it: relative to the root, with forward slashes."""
    resolved, folder = path.resolve(), root.resolve()
    return (
        resolved.relative_to(folder).as_posix()
        if resolved.is_relative_to(folder)
        else resolved.name
    )


@contextlib.contextmanager
def decorator_served(tracer: Tracer) -> Iterator[None]:
    """Serve the module from which instrumented code imports its decorator, until closed."""
    module = ModuleType(TRACER_MODULE, "Tracing decorator of the run in progress.")
    module.traced = tracer.traced  # type: ignore[attr-defined]
    module.looped = tracer.looped  # type: ignore[attr-defined]
    module.turned = tracer.turned  # type: ignore[attr-defined]
    module.waited = tracer.waited  # type: ignore[attr-defined]
    module.caught = tracer.caught  # type: ignore[attr-defined]
    module.called = tracer.calls.called  # type: ignore[attr-defined]
    module.made = tracer.calls.made  # type: ignore[attr-defined]
    with _registered(sys.modules, TRACER_MODULE, module):
        yield


@contextlib.contextmanager
def prepared_controller(
    path: Path | str,
    tracer: Tracer,
    argv: Sequence[str] = (),
    *,
    root: Path | None = None,
    entry: str | None = None,
    sources: Sources = ON_DISK,
) -> Iterator[Callable[[], None]]:
    """Compile the file at `path`; yield the function that runs it once as `__main__`, traced.

    `argv` are the arguments after the script's name; `root` is `controller_root(path)` unless
    given. `entry` names a function of the file that is called afterwards, as the wrapper of an
    installed command does; its result is the exit status.
    What the controller raises passes through, `SystemExit` too.
    Until closed, `sys.argv`, `sys.path`, `__main__` and the recursion limit are the controller's,
    and tracerisk's frames are hidden: threads and callbacks that outlive the module-level code need
    it open. All is put back at the end; modules that were imported stay imported.

    Raises:
        InputError, SourceError, UnsafeRewriteError: as `compile_file`; nothing has run then.
    """
    script = Path(path).absolute()
    root = controller_root(script) if root is None else root
    code, file = compile_file(script, root, tracer.on_source, sources)
    tracer.add_file(code.co_filename, file)
    with _program(script, tracer, argv) as module, hidden_frames():

        @hide
        def run() -> None:
            with tracer.root("main"):
                tracer.run_module(code, module.__dict__, file)
            if entry is not None:
                with tracer.root("main"):
                    sys.exit(module.__dict__[entry]())

        yield run


def run_controller(
    path: Path | str, tracer: Tracer, argv: Sequence[str] = (), *, root: Path | None = None
) -> None:
    """Run the file at `path` as `__main__`, traced; return when its module-level code ends.

    Arguments and errors are those of `prepared_controller`.
    """
    with prepared_controller(path, tracer, argv, root=root) as run:
        run()


@contextlib.contextmanager
def _program(script: Path, tracer: Tracer, argv: Sequence[str]) -> Iterator[ModuleType]:
    name = str(script)
    module = ModuleType("__main__")
    module.__dict__.update(
        __file__=name,
        __builtins__=__builtins__,
        __loader__=SourceFileLoader("__main__", name),
        __cached__=None,
        __annotations__={},
    )
    package, above = package_of(script)
    if package:
        # As `python -m package.module`, so that its relative imports work.
        module.__dict__["__package__"] = package
    linecache.checkcache(name)
    old_argv, old_path, old_limit = sys.argv, sys.path[:], sys.getrecursionlimit()
    sys.argv = [name, *argv]
    sys.path.insert(0, str(script.parent))
    if package and str(above) not in sys.path:
        sys.path.insert(1, str(above))
    # Each traced call takes two frames where the controller would take one.
    sys.setrecursionlimit(2 * old_limit)
    try:
        with (
            _registered(sys.modules, "__main__", module),
            decorator_served(tracer),
            suppressed_reported(tracer.note_caught),
        ):
            yield module
    finally:
        sys.argv, sys.path[:] = old_argv, old_path
        sys.setrecursionlimit(old_limit)


def package_of(script: Path) -> tuple[str, Path]:
    """Return the dotted name of the package a script stands in, and the folder that holds it."""
    parts: list[str] = []
    folder = script.parent
    while (folder / "__init__.py").is_file() and folder.name.isidentifier():
        parts.insert(0, folder.name)
        folder = folder.parent
    return ".".join(parts), folder


@contextlib.contextmanager
def _registered(table: dict[str, ModuleType], name: str, module: ModuleType) -> Iterator[None]:
    previous = table.get(name)
    table[name] = module
    try:
        yield
    finally:
        if previous is None:
            table.pop(name, None)
        else:
            table[name] = previous
