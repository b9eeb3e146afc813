"""Start recording: in a process that begins again under the probe, and to its end."""

from __future__ import annotations

import atexit
import os
import runpy
import signal
import subprocess
import sys
from pathlib import Path
from types import FrameType, ModuleType
from typing import Any, Callable, NoReturn, Sequence, Union

from tracerisk_probe import nodes, stacks
from tracerisk_probe.importing import Own, compiled, root_of, trace_imports
from tracerisk_probe.recording import output, record_to
from tracerisk_probe.writing import Output, Topic

AnyPath = Union[str, "os.PathLike[str]"]


def start(
    out: AnyPath | None = None,
    root: AnyPath | None = None,
    packages: Sequence[str] = (),
    *,
    publish: bool = True,
) -> None:
    """Record the commands of this process with the functions that issued them.

    Starts the process again by `python -m tracerisk_probe`, so it is called first of all, in the
    controller's first line; in a process that runs so already it does nothing.

    `out` is a file for the commands; `root` the folder of the controller's own code; `packages`
    are Python packages that are the controller's too; `publish` has them published on a topic.
    Raises RuntimeError where Python runs no file that could be started again, OSError where it
    cannot be.
    """
    if output() is not None:
        return
    main = sys.modules["__main__"]
    program = _program(main)
    options: list[str] = []
    if out is not None:
        options += ["--out", os.fspath(out)]
    if root is not None:
        options += ["--root", os.fspath(root)]
    for each in packages:
        options += ["--package", each]
    if not publish:
        options += ["--no-publish"]
    flags = subprocess._args_from_interpreter_flags()  # type: ignore[attr-defined]
    command = [sys.executable, *flags, "-m", __package__, *options, *program, *sys.argv[1:]]
    sys.stdout.flush()
    sys.stderr.flush()
    os.execv(sys.executable, command)


def _program(main: ModuleType) -> list[str]:
    spec = main.__spec__
    if spec is not None:
        name = spec.name
        return ["-m", name[: -len(".__main__")] if name.endswith(".__main__") else name]
    file = getattr(main, "__file__", None)
    if file is None or not Path(file).is_file():
        raise RuntimeError(
            "tracerisk_probe.start() starts the program again, but Python runs no file; start it "
            "by `python -m tracerisk_probe FILE`"
        )
    return [file]


def record(own: Own, controller: str, out: str | None, *, publish: bool) -> None:
    """Record from now on in this process. Raises OSError where `out` cannot be written."""
    topic = Topic() if publish else None
    found = Output(out, topic)
    if topic is not None:
        found.before_sending = nodes.Finding(topic)
    # Each traced call takes two frames where the controller's alone would take one.
    sys.setrecursionlimit(2 * sys.getrecursionlimit())
    record_to(found, controller)
    trace_imports(own)
    _flush_at_the_end(found)


def run_script(path: Path, arguments: Sequence[str], own: Own) -> None:
    """Run a script as `__main__`, traced."""
    code, name = compiled(path, own)
    module = ModuleType("__main__")
    module.__dict__.update(__file__=str(path), __builtins__=__builtins__, __spec__=None)
    sys.modules["__main__"] = module
    sys.argv = [str(path), *arguments]
    sys.path[0] = str(path.resolve().parent)
    with stacks.root("main"):
        if name is None:
            exec(code, module.__dict__)
        else:
            stacks.run_module(code, module.__dict__, name)


def run_module(name: str, arguments: Sequence[str]) -> None:
    """Run a module as `python -m` does; its functions are traced, as any module's."""
    sys.argv = [name, *arguments]
    sys.path[0] = str(Path.cwd())
    with stacks.root("main"):
        runpy.run_module(name, run_name="__main__", alter_sys=True)


def _flush_at_the_end(found: Output) -> None:
    def end() -> None:
        found.flush()
        _report_unpublished(found)

    atexit.register(end)
    real_exit: Callable[[int], NoReturn] = os._exit

    def flush_and_exit(status: int) -> NoReturn:
        found.flush()
        real_exit(status)

    os._exit = flush_and_exit
    for number in (signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) is signal.SIG_DFL:
            signal.signal(number, _ending(found))


def _ending(found: Output) -> Callable[[int, FrameType | None], Any]:
    def end(number: int, _: FrameType | None) -> None:
        found.flush()
        signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)

    return end


def _report_unpublished(found: Output) -> None:
    topic = found.topic
    if topic is not None and found.path is None and not topic.is_used:
        sys.stderr.write(
            "tracerisk-probe: the commands went nowhere: no node of ROS was started; give --out\n"
        )


def controller_name(own: Own, path: Path) -> str:
    """Return what recordings call a script."""
    return own.name_of(path) or path.name


def own_code(script: Path, root: str | None, packages: Sequence[str]) -> Own:
    """Return which code is the controller's, with the package of an installed command."""
    more = [] if script.suffix == ".py" else [script.resolve().parent.name]
    return Own(root_of(script) if root is None else Path(root), [*packages, *more])
