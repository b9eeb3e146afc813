"""Run companions: nodes of the workspace that provide what a controller waits for.

Each runs on a thread of its own in the controller's process, as a program of its own: with its own
command line, parameters and states of the client libraries, untraced. What it commands is owned by
the function of the controller that asked it.
"""

from __future__ import annotations

import ast
import sys
import traceback
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.text.bounded import file_bytes
from tracerisk.common.text.printable import cut
from tracerisk.instrument.loader import package_of
from tracerisk.instrument.marks.busy_waits import mark_turns
from tracerisk.instrument.marks.instrumented import TRACER_MODULE
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.source.function_definitions import MODULE
from tracerisk.instrument.tracer import Frame
from tracerisk.pipeline.trace.run_files import COMPANION, Companion
from tracerisk.pipeline.workspace.entry_point import find_entry_point
from tracerisk.ros.controller.node_process import NodeProcess
from tracerisk.ros.graph.parameter_files import into_tree
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.time.scheduler import RunOver


class Companions:
    """The companions of one run: `start` begins them, before the controller's first line."""

    def __init__(
        self, companions: Sequence[Companion], runtime: Runtime, recorder: Recorder
    ) -> None:
        self._companions = companions
        self._runtime = runtime
        self._recorder = recorder
        self._scheduler = runtime.scheduler
        self._scheduler.has_companions = bool(companions)
        self._argv: list[str] | None = None

    def start(self) -> None:
        """Begin each on a thread; they get their first turn when the controller first waits."""
        if not self._companions:
            return
        self._scheduler.on_process_change = self._changed
        tracer: Any = self._runtime.tracer
        if tracer is not None:
            tracer.on_behalf = self._asking
        for companion in self._companions:
            script = Path(companion.script)
            for folder in (script.parent, package_of(script)[1]):
                if str(folder) not in sys.path:
                    sys.path.append(str(folder))
            self._scheduler.spawn(
                self._main(companion, script),
                f"companion {companion.told}",
                inherit=False,
                is_controllers=False,
                process=self._process_of(companion),
            )

    def _process_of(self, companion: Companion) -> NodeProcess:
        runtime, launch = self._runtime, companion.launch
        arguments = () if launch is None else launch.argv(())
        parameters = () if launch is None else launch.parameters
        into_tree(parameters, runtime.graph.parameters)
        argv = (companion.script, *arguments)
        own = Runtime(
            runtime.scheduler,
            runtime.graph,
            runtime.twin,
            runtime.tracer,
            runtime.recorder,
            argv,
            runtime.seed,
            runtime.packages,
            (*parameters, *runtime.parameters),
            runtime.distro,
            beside=runtime,
            installed=runtime.installed,
        )
        return NodeProcess(companion.told, own, list(argv))

    def _main(self, companion: Companion, script: Path) -> Callable[[], None]:
        def run() -> None:
            try:
                _execute(script, Path(companion.root))
            except RunOver:
                raise
            except SystemExit as error:
                if error.code not in (None, 0):
                    self._report(companion, f"exited with {error.code!r}")
            except BaseException as error:  # noqa: BLE001 - it must not end the controller's run
                self._report(companion, f"died of {_one_text(error)}")

        return run

    def _report(self, companion: Companion, message: str) -> None:
        text = f"{companion.told}, started beside the controller, {message}"
        self._recorder.finding("companion_failed", text)
        self._recorder.note(COMPANION, told=companion.told, ended=message)

    def _changed(self, process: NodeProcess | None) -> None:
        """Show each program its own command line."""
        if self._argv is None:
            self._argv = sys.argv
        sys.argv = self._argv if process is None else process.argv

    def _asking(self) -> tuple[Any, ...]:
        process = self._scheduler.process
        if process is None:
            return ()
        # What it does unasked is its own file's: such a node is none to start beside another.
        own = FunctionRef(process.name, MODULE)
        return process.asked_by or (Frame(own, 1, 0, (1, 0), "main"),)


def _execute(script: Path, root: Path) -> None:
    source = file_bytes(script)
    entry = find_entry_point(script, source, root)
    namespace: dict[str, Any] = {
        "__name__": "__main__",
        "__file__": str(script),
        "__builtins__": __builtins__,
        "__annotations__": {},
    }
    package, _ = package_of(script)
    if package:
        namespace["__package__"] = package
    tree = ast.parse(source, str(script))
    mark_turns(tree, TRACER_MODULE)
    exec(compile(tree, str(script), "exec", dont_inherit=True), namespace)
    if entry is not None:
        sys.exit(namespace[entry.function]())


def _one_text(error: BaseException) -> str:
    return cut("".join(traceback.format_exception_only(error)).strip())
