"""The compiled nodes of a live run: their command, the probe within them, and how they end."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tracerisk.errors import DependencyError, Location, signal_name
from tracerisk.instrument.native.calls import VARIABLE
from tracerisk.instrument.native.library import build_probe
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.pipeline.run.live.command import LAUNCHERS, command_words
from tracerisk.pipeline.run.live.compiled import MAIN, CompiledCalls, Place
from tracerisk.pipeline.run.live.compiled_ends import CompiledEnds
from tracerisk.pipeline.trace.run_files import STARTED
from tracerisk.ros.graph.failures import ERROR_LOGGED, plain_line
from tracerisk.ros.live.process_tree import has_ended
from tracerisk.ros.live.session import Command
from tracerisk.ros.time.clock import EPOCH_NS
from tracerisk.trace import EndCause

if TYPE_CHECKING:
    from collections.abc import Iterable

    from tracerisk.instrument.recorder import Recorder
    from tracerisk.instrument.tracer import Frame
    from tracerisk.pipeline.trace.run_files import RunRequest
    from tracerisk.ros.live.session import Session

_READY_S = 60.0
"""How long the first node may take to register with the master, wall time [s]."""
LOG = "/rosout"
"""The topic on which nodes log."""
LOG_TYPES: dict[RosVersion, str] = {1: "rosgraph_msgs/Log", 2: "rcl_interfaces/Log"}
_ERROR: dict[RosVersion, int] = {1: 8, 2: 40}
_FATAL: dict[RosVersion, int] = {1: 16, 2: 50}
"""The levels of lines of the log, from `rosgraph_msgs/Log` and `rcl_interfaces/msg/Log`."""
_PRELOAD = "LD_PRELOAD"
_ARGUMENTS = "TRACERISK_ROS_ARGUMENTS"
"""The variable that gives nodes of ROS 2 arguments, a word a line; probe/native/calls.c."""
_BEGINNING = "TRACERISK_TIME_BEGINS"
"""The variable that says when simulated time begins [ns since 1970]."""
_SEPARATORS = frozenset(" :")


class CompiledNodes:
    """Starts the command of a request, and says which functions sent what comes of its nodes."""

    def __init__(
        self,
        request: RunRequest,
        recorder: Recorder,
        temporary: Path,
        environment: dict[str, str],
        ros: RosVersion,
    ) -> None:
        self._recorder, self._ros = recorder, ros
        self._words, self._answers = command_words(request.argv, ros), request.answers
        self._environment = environment
        self._ends = CompiledEnds()
        self._gone: tuple[int, ...] = ()
        self._probe: Path | None = None
        self._without_probe = ""
        try:
            if set(str(temporary)) & _SEPARATORS:
                raise DependencyError(
                    f"{_PRELOAD} cannot name the folder {temporary}, for it separates names by "
                    "spaces and colons; set TMPDIR to another"
                )
            self._probe = build_probe(temporary)
        except DependencyError as error:
            if ros == 2:
                raise  # nothing else says what its nodes publish and ask for
            self._without_probe = error.message
        self._file = temporary / "calls.jsonl"
        root = Path(request.root)
        main = Path(request.controller).resolve().relative_to(root.resolve()).as_posix()
        self._calls = CompiledCalls(
            self._file, root, main, recorder.function_ran, recorder.source_compiled, ros
        )
        self._registered: set[str] = set()
        self._began = time.monotonic()
        self._pid: int | None = None
        self._event_ns = -1
        self._gone_round: set[int] = set()
        self.has_input_ended = False
        """Whether a node asked for more input than there was."""

    def begin(self, session: Session, parameter_file: str | None = None) -> None:
        """Start the command in the environment of the user, with the probe before its libraries.

        Nodes of ROS 2 find the parameters of the file, and take their time from `/clock`.
        """
        environment = self._environment
        if self._probe is not None:
            preloaded = [str(self._probe), *filter(None, [environment.get(_PRELOAD)])]
            environment |= {
                _PRELOAD: ":".join(preloaded),
                VARIABLE: str(self._file),
                _BEGINNING: str(EPOCH_NS),
            }
        if self._ros == 2:
            given = [] if parameter_file is None else ["--params-file", parameter_file]
            words = ["--ros-args", *given, "-p", "use_sim_time:=true", "--"]
            environment |= {_ARGUMENTS: "\n".join(words)}
        self._recorder.note(STARTED)
        self._pid = session.begin_command(Command(self._words, environment, self._answers))

    def registered(self, caller: str) -> None:
        """Note that a node has registered with the master."""
        self._registered.add(caller)

    def new_ends(self) -> list[dict[str, Any]]:
        """Return what nodes of ROS 2 have begun, or ceased, to publish, hear, serve and ask for."""
        ends = self._calls.new_ends()
        for end in ends:
            self.registered(end["node"])
        frames = [*self._ends.frames(ends), *self._ends.without(self._gone)]
        self._gone = ()
        return frames

    def input_ended(self) -> None:
        """Record that a node asked for more input than there was."""
        self.has_input_ended = True
        self._recorder.finding(
            "answer_assumed",
            f"{self._words[0]} reads its standard input after {len(self._answers)} answers, and "
            "its end is assumed; give what a user would type, in turn, by --answer TEXT",
            object_name="standard input",
        )

    def settled(self) -> None:
        """Note that nothing is under way between nodes and twin."""
        self._calls.settled()
        # What a process has sent last has come by now.
        self._gone = tuple(pid for pid in sorted(self._ends.processes) if has_ended(pid))

    def only_wait(self, processes: Iterable[int], event_ns: int) -> bool:
        """Return whether all processes of the command are nodes that only wait for what comes.

        Their loops without an end have gone round since the mission's last event, and have nothing
        to do. What starts them waits too. Of another process nobody knows what it will do.
        """
        if event_ns != self._event_ns:
            self._event_ns = event_ns
            self._gone_round.clear()
        launches = Path(self._words[0]).name in LAUNCHERS
        asked = [pid for pid in processes if pid != self._pid or not launches]
        return bool(asked) and all(
            self._calls.only_wait(pid) and (pid in self._gone_round or not self._calls.loops(pid))
            for pid in asked
        )

    def new_rounds(self) -> list[Place]:
        """Return the endless loop of each iteration that the node's main thread has begun.

        Of several nodes it is none: what they command together is no cycle of one of them.
        """
        rounds = self._calls.new_rounds()
        self._gone_round.update(pid for pid, _ in rounds)
        is_one = len(self._calls.processes) == 1
        return [loop for _, loop in rounds if is_one]

    @property
    def is_awaited(self) -> bool:
        """Whether no node is there yet: time begins with the first one."""
        return not self._registered and not self._is_late

    @property
    def missing(self) -> str:
        """Why no node is expected any more, where none has come in all the time; else empty."""
        if self._registered or not self._is_late:
            return ""
        words = " ".join(self._words)
        if self._ros == 2:
            return (
                f"no node has come up in {_READY_S:g} s: does `{words}` start a node of ROS 2 that "
                "is linked dynamically, so that the probe is loaded into it?"
            )
        return (
            f"no node has registered with the run's master in {_READY_S:g} s: "
            f"does `{words}` start a node of ROS 1, and does nothing in it name "
            "another master (ROS_MASTER_URI of a script, <machine> or <env> of a launch file)?"
        )

    @property
    def _is_late(self) -> bool:
        return time.monotonic() - self._began > _READY_S

    def sender(
        self,
        name: str,
        body: bytes,  # noqa: ARG002
        number: int | None,
        at_ns: int | None = None,
    ) -> tuple[Frame, ...]:
        """Return the functions that sent what has come on a topic, or to a service or action."""
        return self._calls.stack(name, number, at_ns)

    def logged(self, line: Any) -> None:
        """Record a line of the log that is an error, and that a source of the controller wrote."""
        if line.level < _ERROR[self._ros]:
            return
        file = self._calls.own_file(line.file)
        if file is None:
            return
        first = (line.msg.strip().splitlines() or [""])[0]
        severity = "FATAL" if line.level >= _FATAL[self._ros] else "ERROR"
        self._recorder.failed(
            ERROR_LOGGED,
            f"it logged {severity}: {first}",
            Location(file, line.line),
            asker=(file, line.line),
            object_name=plain_line(first),
        )

    def bad_end(self) -> tuple[EndCause, str] | None:
        """Return how a node of the command has ended badly; None where none did.

        What started it may say nothing of that: roslaunch ends with 0 when its nodes have crashed.
        """
        for pid, program, code in self._calls.ended():
            if pid != self._pid and code != 0:
                how = "was ended by a signal, as by a crash, or by _exit()"
                cause: EndCause = "died" if code is None else "exited"
                return cause, f"{program} {how if code is None else f'ended with code {code}'}"
        return None

    def report_end(self, code: int | None) -> None:
        """Record how the command has ended by itself."""
        cause, message = self._ended(code)
        self._recorder.run_ended(cause, message)

    def report_attribution(self) -> None:
        """Record what of the functions is not known, and why, and which never sent anything.

        So are topics, services and actions that did not reach the twin.
        """
        for name, node in sorted(self._ends.untyped.items()):
            self._recorder.finding(
                "not_simulated",
                f"what {node} exchanges on {name} does not reach the twin, for its type is not "
                "known: build the package of the type with rosidl_default_generators, and source "
                "the setup of its workspace",
                object_name=name,
            )
        calls, main = self._calls, "main()"
        calls.read_sources()
        for note in calls.notes:
            self._recorder.finding("not_simulated", f"functions: {note}")
        for file, binary in calls.newer.items():
            self._recorder.finding(
                "functions_assumed",
                f"functions: {file} has changed since {binary} was built from it, so that other "
                "code ran than it has now: build it again",
                object_name=file,
            )
        if not calls.n_unknown:
            return
        of = calls.n_known + calls.n_unknown
        if self._probe is None:
            why = f"no probe was loaded into the nodes: {self._without_probe}"
        elif not calls.has_reported:
            why = "the probe was loaded into no process: a statically linked node does not load it"
        else:
            why = "no function of a source below the root is known to have sent them"
        self._recorder.finding(
            "functions_assumed",
            f"functions: {calls.n_unknown} of {of} messages and calls count as those of {main}: "
            f"{why}",
            object_name=MAIN,
        )

    def _ended(self, code: int | None) -> tuple[EndCause, str]:
        words = self._words[0]
        if code is None:
            return "died", f"{words} did not end"
        if code < 0:
            return "died", f"{words} was ended by {signal_name(-code)}"
        if code == 0:
            return "ended", f"{words} ended"
        there = "come up" if self._ros == 2 else "registered with the run's master"
        hint = "" if self._registered else f"; no node of it has {there}"
        return "exited", f"{words} ended with code {code}{hint}"
