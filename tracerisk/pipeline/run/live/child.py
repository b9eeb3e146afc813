"""The process of a live run's twin: it serves a controller, or nodes, that run on real ROS.

Started as the process of a run on stand-ins is, and leaves the same recording. Its network has
loopback alone, where the kernel allows that.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.sandbox.kernel import features as kernel
from tracerisk.common.sandbox.limited_process import mark_start
from tracerisk.common.text.bounded import MOST_WRITTEN, file_bytes, file_text, files_below
from tracerisk.errors import Location, SandboxError, TraceRiskError
from tracerisk.instrument.marks.call_log import CALLS
from tracerisk.instrument.recorder import Recorder
from tracerisk.instrument.recording import CELL
from tracerisk.instrument.source.language import is_c
from tracerisk.pipeline.launch_files.records import NOTHING_LAUNCHED
from tracerisk.pipeline.run.assembly.graph import build_graph
from tracerisk.pipeline.run.assembly.world import build_world
from tracerisk.pipeline.run.child import recorded
from tracerisk.pipeline.run.live.nodes import LOG, LOG_TYPES, CompiledNodes
from tracerisk.pipeline.run.live.watch import RemoteThreads
from tracerisk.pipeline.run.watching.run_watch import RunWatch
from tracerisk.pipeline.trace.run_files import (
    COMMAND_ENVIRONMENT,
    ENTRY,
    GRAPH_USE,
    MISSION_END,
    STARTED,
    RunRequest,
    WallTime,
)
from tracerisk.pipeline.workspace.entry_point import find_entry_point
from tracerisk.pipeline.workspace.project import Project
from tracerisk.ros.graph.failures import ERROR_LOGGED
from tracerisk.ros.graph.parameter_files import private_of, write_overrides
from tracerisk.ros.graph.parameters import ParameterTree
from tracerisk.ros.graph.runtime import activate
from tracerisk.ros.live.bridge import Bridge
from tracerisk.ros.live.loopback import REACHES_OTHERS, leaves_others
from tracerisk.ros.live.messages.modules import make_missing_modules
from tracerisk.ros.live.session import STEP_NS, Program, Session
from tracerisk.ros.live.wire import wire_of
from tracerisk.ros.robot.bring_up.node_parameters import SEMANTIC
from tracerisk.ros.robot.commands import TwinCommands
from tracerisk.ros.robot.frames import DESCRIPTION
from tracerisk.ros.robot.trajectories.robot_spaces import words_of_several_arms
from tracerisk.ros.time.scheduler import RunOver
from tracerisk.trace import EndCause
from tracerisk.twin.recording.samples import SampleWriter

_SHARE_OF_STEP = 0.5
_EXIT_POLL_S = 0.005
_EXIT_S = 5.0
_MAIN_OF_NODES = 1
"""The number of the main thread of compiled nodes; of the others nobody asks."""
_ENDS_OF_TOPICS = ("publisher", "subscriber", "no_publisher", "no_subscriber")
"""What a controller on ROS 2 reports of its ends; in ROS 1 the master does."""


def main() -> int:
    """Run the request named on the command line; the exit code says whether anything ran."""
    kernel.adopt_orphans()
    request = RunRequest.loads(file_text(sys.argv[1], most=MOST_WRITTEN))
    is_alone = leaves_others()

    def run(asked: RunRequest, samples: SampleWriter, recorder: Recorder) -> None:
        if not is_alone:
            raise SandboxError(REACHES_OTHERS)
        _LiveRun(asked, samples, recorder).run()

    return recorded(request, run)


class _LiveRun:
    def __init__(self, request: RunRequest, samples: SampleWriter, recorder: Recorder) -> None:
        self._request, self._recorder = request, recorder
        script, root = Path(request.controller), Path(request.root)
        world = build_world(request, samples, recorder)
        self._twin, self._scheduler = world.twin, world.scheduler
        self._graph = build_graph(request, Project(root), world)
        self._runtime = self._graph.runtime
        self._interfaces: Any = self._graph.interfaces
        self._environment: dict[str, str] = json.loads(os.environ.pop(COMMAND_ENVIRONMENT))
        self._threads = RemoteThreads(self._scheduler)
        self._watch = RunWatch(self._threads, recorder)  # type: ignore[arg-type]
        recorder.watch = self._watch
        self._watch.schedule = self._graph.scenario.schedule
        self._end: dict[str, Any] | None = None
        self._has_calls = False
        self._ended_wall: float | None = None
        self._refused: dict[str, Any] | None = None
        self._nodes: CompiledNodes | None = None
        world.tracer.add_file(str(script), script.resolve().relative_to(root.resolve()).as_posix())

    def run(self) -> None:
        """Run the controller to its end, and record how that was."""
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as modules:
            self._run(Path(modules))

    def _program(self, temporary: Path) -> Program:
        """Return the Python program to run, with the modules of messages that ROS 1 lacks.

        They lie in a temporary folder, as does the file of the parameters of nodes of ROS 2.
        """
        request, script = self._request, Path(self._request.controller)
        entry = find_entry_point(script, file_bytes(script), Path(request.root))
        has_made = False
        if self._graph.ros == 1:
            sources = []
            for path in files_below(Path(request.root), ".py"):
                with contextlib.suppress(OSError):
                    sources.append(file_bytes(path))
            has_made = make_missing_modules(self._interfaces, sources, temporary)
        launch = request.launch or NOTHING_LAUNCHED
        if entry is not None:
            self._recorder.note(ENTRY, function=entry.function, named_in=entry.named_in)
        return Program(
            str(script),
            request.root,
            request.argv,
            None if entry is None else entry.function,
            {
                name: str(python_package)
                for name, python_package in self._graph.workspace.python_packages.items()
            },
            (
                *map(str, self._graph.workspace.import_paths),
                *([str(temporary)] if has_made else []),
            ),
            dict(launch.environment),
            dict(private_of(self._runtime.parameters)),
            self._parameter_file(temporary),
        )

    def _parameter_file(self, temporary: Path) -> str | None:
        if self._graph.ros == 1:
            return None
        return write_overrides(self._runtime.parameters, temporary / "parameters.yaml")

    def _run(self, temporary: Path) -> None:
        begin: Callable[[Session], None]
        bad_end: tuple[EndCause, str] | None = None
        if is_c(self._request.controller):
            ros = self._graph.ros
            self._nodes = CompiledNodes(
                self._request, self._recorder, temporary, self._environment, ros
            )
            self._threads.main.ident = _MAIN_OF_NODES
            parameters = self._parameter_file(temporary)
            begin = functools.partial(self._nodes.begin, parameter_file=parameters)
        else:
            program = self._program(temporary)
            begin = functools.partial(Session.begin, program=program)
        session = Session(os.environ) if self._graph.ros == 1 else Session(self._environment, 2)
        try:
            with activate(self._runtime):
                self._bridge = Bridge(
                    self._runtime,
                    self._interfaces,
                    session.relay,
                    lambda message: self._recorder.finding("not_simulated", message),
                    self._threads.acts,
                )
                session.on_relay, session.on_controller = self._of_relay, self._of_controller
                if self._nodes is not None:
                    self._bridge.sender = self._nodes.sender
                if self._nodes is not None and self._graph.ros == 2:
                    session.look = self._look
                if self._graph.ros == 1:
                    self._give_parameters()
                mark_start()
                began = time.perf_counter()
                over = self._lived(session, begin)
                if self._nodes is not None:
                    bad_end = self._nodes.bad_end()
            session.ask_calls(lambda: self._has_calls)
        finally:
            session.close()
        if self._refused is not None:
            self._recorder.note("failed", **self._refused)
            return
        self._scheduler.outlast()
        if self._nodes is not None:
            self._nodes.report_attribution()
        self._report_end(over, bad_end, session.controller_code)
        self._recorder.note(GRAPH_USE, counts=dict(sorted(self._runtime.graph.counts.items())))
        if words := words_of_several_arms(self._runtime):
            self._recorder.finding("one_robot", words)
        self._recorder.note(CELL, **self._graph.cell.note())
        self._twin.close()
        WallTime(time.perf_counter() - began, 0.0).write(Path(self._request.folder))

    def _lived(self, session: Session, begin: Callable[[Session], None]) -> RunOver | None:
        def live() -> None:
            self._bridge.tick()
            session.settle()
            begin(session)
            session.send_time(self._bridge.now_ns)
            self._move_on(session)

        try:
            self._scheduler.run_main(live)
        except RunOver as over:
            return over
        return self._threads.over

    def _move_on(self, session: Session) -> None:
        speed = self._request.live_speed or 1.0
        due = time.monotonic()
        waits = True
        while session.settle():
            if self._threads.over is not None:
                return
            if self._ends_by_itself():
                # Calls at its exit may still command something; its own end takes no time.
                session.wait_wall(_EXIT_POLL_S)
                continue
            if self._nodes is not None:
                if session.end_input():
                    self._nodes.input_ended()
                if self._nodes.has_input_ended:
                    self._threads.look_without_input(waits=not session.is_computing)
                if not session.is_computing:
                    self._nodes.settled()
                for file, line in self._nodes.new_rounds():
                    self._threads.acts(_MAIN_OF_NODES)
                    self._watch.looped(file, line)
                waits = not session.is_computing and self._nodes.only_wait(
                    session.command_processes, self._watch.last_event_ns
                )
                self._threads.spins(alone=waits)
                if self._nodes.is_awaited:
                    session.wait_wall(_EXIT_POLL_S)
                    continue
                if self._nodes.missing:
                    self._threads.end("no_motion", self._nodes.missing)
            self._scheduler.sleep(STEP_NS)
            self._bridge.tick()
            session.send_time(self._bridge.now_ns)
            if waits:
                self._watch.time_passed()
            due = max(due + STEP_NS / 1e9 / speed, time.monotonic() - 10 * STEP_NS / 1e9)
            while (left := due - time.monotonic()) > 0.0:
                session.wait_wall(left)
                if left > _SHARE_OF_STEP * STEP_NS / 1e9:
                    session.settle()

    def _ends_by_itself(self) -> bool:
        """Return whether the controller has ended and is not long about it."""
        if self._end is None:
            return False
        if self._ended_wall is None:
            self._ended_wall = time.monotonic()
        return time.monotonic() - self._ended_wall < _EXIT_S

    def _of_relay(self, header: dict[str, Any], body: bytes) -> None:
        if self._nodes is not None and header["is"] == "publisher":
            self._nodes.registered(header["caller"])
            self._hear_log(header)
        elif self._nodes is not None and header.get("topic") == LOG:
            kind = self._interfaces.message(LOG_TYPES[self._graph.ros])
            self._nodes.logged(wire_of(self._interfaces).decode(body, kind))
            return
        if header["is"] in ("message", "call", "goal", "cancel"):
            self._threads.stirred()
        self._bridge.take(header, body)

    def _hear_log(self, header: dict[str, Any]) -> None:
        if header["name"] == LOG and header["is"] == "publisher":
            self._bridge.listen(LOG, LOG_TYPES[self._graph.ros], header.get("quality"))

    def _look(self) -> bool:
        """Take what compiled nodes of ROS 2 have made, as nodes in Python report it."""
        assert self._nodes is not None
        frames = self._nodes.new_ends()
        for frame in frames:
            self._hear_log(frame)
            self._of_controller(frame, b"")
        return bool(frames)

    def _of_controller(self, header: dict[str, Any], body: bytes) -> None:
        what = header["is"]
        if what == "sent":
            self._bridge.sent(header, body)
        elif what == "service_client":
            self._bridge.service_client(header["name"], header["type"])
        elif what in _ENDS_OF_TOPICS:
            self._bridge.take(header, b"")
        elif what == "serves":
            self._bridge.serves(header["name"])
        elif what == "action_client":
            self._bridge.actions.client(header["name"], header["type"], header["caller"])
        elif what == "acts":
            self._bridge.actions.serves(header["name"])
        elif what == "ran":
            ref = FunctionRef(header["file"], QualifiedName(header["name"]))
            self._recorder.function_ran(ref, header["line"])
        elif what == "source":
            self._recorder.source_compiled(header["file"], header["latin1"].encode("latin-1"))
        elif what == "looped":
            self._threads.baton.of = header["thread"]
            self._watch.looped(header["file"], header["line"])
        elif what == "failed":
            self._failed(header)
        elif what == "begins":
            self._recorder.note(STARTED)
            self._threads.main.ident = header["thread"]
        elif what in ("spins", "spun"):
            self._threads.spins(alone=what == "spins")
        elif what == "calls":
            if not self._has_calls:
                self._recorder.note(CALLS, **header["data"])
            self._has_calls = True
        elif what == "end":
            self._end = header
        elif what == "refused":
            self._refused = {key: header[key] for key in ("error", "message", "location")}

    def _failed(self, header: dict[str, Any]) -> None:
        place = None if header["location"] is None else Location(*header["location"])
        about = header["object"]
        if header["kind"] == ERROR_LOGGED:  # once, however often
            asker = None if place is None else (place.file, place.line)
            self._recorder.failed(
                ERROR_LOGGED, header["message"], place, asker=asker, object_name=about
            )
        else:
            self._recorder.finding(header["kind"], header["message"], place, object_name=about)

    def _give_parameters(self) -> None:
        parameters: ParameterTree = self._runtime.graph.parameters
        for name in (f"/{DESCRIPTION}", f"/{SEMANTIC}"):
            if name not in parameters.names():
                # The twin offers it to whoever asks; a master knows what is set alone.
                parameters.set(name, parameters.get(name))
        self._bridge.give_parameters()

    def _report_end(
        self, over: RunOver | None, bad_end: tuple[EndCause, str] | None, code: int | None
    ) -> None:
        self._runtime.client(TwinCommands).finish("ended" if over is None else over.cause)
        if over is not None and over.cause in ("idle", "quiescent"):
            self._recorder.note(MISSION_END, ns=self._watch.last_event_ns)
        if bad_end is not None:
            self._recorder.run_ended(*bad_end)
        elif over is not None and over.cause != "ended":
            self._recorder.run_ended(over.cause, over.message, over.location)
        elif self._end is not None:
            place = self._end["location"]
            self._recorder.run_ended(
                self._end["cause"],
                self._end["message"],
                None if place is None else Location(*place),
            )
        elif self._nodes is not None:
            self._nodes.report_end(code)
        else:
            message = f"the controller's process ended with code {code} and gave no reason"
            self._recorder.run_ended("died", message)


if __name__ == "__main__":
    try:
        code = main()
    except TraceRiskError as problem:
        print(problem, file=sys.stderr)  # noqa: T201 - it has no other mouth
        code = int(problem.exit_code)
    sys.stdout.flush()
    sys.exit(code)
