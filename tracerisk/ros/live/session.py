"""The processes of a live run and the clock that they share.

The clock moves in steps of `STEP_NS`, no faster than the wall clock times `speed`, and only while
every thread of the controller and of the relay sleeps and nothing is on its way: a machine that is
slow or busy loses no simulated time.
A compiled node that computes for `_PATIENCE_NS` between two steps may wait in a loop without a
sleep, which ends only if time passes: from then on, until it sleeps, the clock moves by what the
node computes, in time of the processor.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from tracerisk.common.sandbox.kernel.features import stat_fields
from tracerisk.errors import DependencyError, LimitError
from tracerisk.instrument.native.binaries import readers
from tracerisk.instrument.source.ros_version import RosVersion
from tracerisk.ros.live.link import Link
from tracerisk.ros.live.loopback import (
    command_environment,
    domain_environment,
    domain_of_run,
    loopback_environment,
)
from tracerisk.ros.live.process_tree import ProcessTree
from tracerisk.ros.live.real_ros import end_process, first_frame, start_linked

STEP_NS = 2_000_000
"""By how much the clock moves at once [ns]."""
_POLL_S, _LONGEST_POLL_S = 0.0005, 0.004
_QUICK_POLLS = 8
_PATIENCE_NS = 50_000_000
_STUCK_S = 60.0
_ANSWER_S = 5.0
_RELAYS: dict[RosVersion, str] = {
    1: "tracerisk.ros.live.relay",
    2: "tracerisk.ros.live.ros2.relay",
}


def poll_s(polls: int) -> float:
    """Return how long to wait before a node is looked at once more [s], after so many in vain.

    Looking takes the processor's time, which is short where a node waits for its turn.
    """
    return min(_POLL_S * max(1, polls // _QUICK_POLLS), _LONGEST_POLL_S)


@dataclass(frozen=True, slots=True)
class Program:
    """The controller as its process is to run it."""

    script: str
    """The path of the script to run."""
    root: str
    """The folder of the controller's root."""
    argv: tuple[str, ...] = ()
    """The command-line arguments."""
    entry: str | None = None
    """The function of the script to call; `None`: the script itself runs."""
    packages: Mapping[str, str] = field(default_factory=dict)
    """The folders of the workspace's Python packages, by name."""
    paths: tuple[str, ...] = ()
    """Folders behind those of the installed ROS in which modules are found."""
    environment: Mapping[str, str] = field(default_factory=dict)
    """The environment variables that a launch file sets."""
    private: Mapping[str, Any] = field(default_factory=dict)
    """Parameters that the node of ROS 1 finds under its own name."""
    parameter_file: str | None = None
    """The path of a parameter file for the nodes of ROS 2; `None` for none."""


@dataclass(frozen=True, slots=True)
class Command:
    """A command that starts compiled nodes, or a launch file."""

    words: tuple[str, ...]
    """The program and its arguments."""
    environment: Mapping[str, str]
    """The environment in which the user gave it, with what is added for its nodes."""
    answers: tuple[str, ...] = ()
    """The lines of its standard input."""


class Session:
    """A relay, in ROS 1 with a master, and later a controller; both end with the session.

    `on_relay` and `on_controller` are given the frames of each, in the order of their coming.
    `environment` is that of the processes; in ROS 2 the user's own.
    """

    def __init__(self, environment: Mapping[str, str], ros: RosVersion = 1) -> None:
        self._environment, self._ros = environment, ros
        self._domain = domain_of_run()
        self.on_relay: Callable[[dict[str, Any], bytes], None] = lambda header, body: None  # noqa: ARG005
        self.on_controller: Callable[[dict[str, Any], bytes], None] = lambda header, body: None  # noqa: ARG005
        self.look: Callable[[], bool] = lambda: False
        """Takes what compiled nodes of ROS 2 have noted; returns whether there was anything."""
        self.master = ""
        self.relay, self._relay_process = start_linked(
            _RELAYS[ros], environment=self._surroundings(), ros=ros
        )
        self.master = self._ready()
        self.controller: Link | None = None
        self._controller_process: subprocess.Popen[bytes] | None = None
        self._tree: ProcessTree | None = None
        self._computed_ns = 0
        self.is_computing = False
        """Whether the clock moves by what a compiled node computes; messages may be under way."""

    @property
    def controller_code(self) -> int | None:
        """The return code of the controller's process; None while it lives."""
        if self._tree is not None:
            return self._tree.code
        return None if self._controller_process is None else self._controller_process.poll()

    @property
    def command_processes(self) -> tuple[int, ...]:
        """The processes of a command that live."""
        return () if self._tree is None else self._tree.pids

    def begin(self, program: Program) -> None:
        """Start the controller."""
        asked = asdict(program)
        own = asked.pop("environment")
        self.controller, self._controller_process = start_linked(
            "tracerisk.ros.live.controller_process",
            environment={**self._surroundings(), **own},
            ros=self._ros,
            domain=self._domain,
            **asked,
        )

    def _surroundings(self) -> dict[str, str]:
        """Return the environment of a process of ours."""
        if self._ros == 2:
            return domain_environment(self._environment, self._domain)
        return loopback_environment(self._environment, self.master)

    def send_time(self, now_ns: int) -> None:
        """Send a controller on ROS 2 the time, which its nodes get by no message."""
        if self._ros == 2 and self.controller is not None and not self.controller.is_closed:
            with contextlib.suppress(OSError):  # it has ended, as will be seen
                self.controller.send({"do": "time", "ns": now_ns})

    def ask_calls(self, have_come: Callable[[], bool]) -> None:
        """Ask a controller in Python which of its calls were executed, and take its answer."""
        if self.controller is None or self.controller.is_closed:
            return
        with contextlib.suppress(OSError):
            self.controller.send({"do": "calls"})
        until = time.monotonic() + _ANSWER_S
        while not have_come() and not self.controller.is_closed and time.monotonic() < until:
            self._wait(_POLL_S)
            self._take()

    def begin_command(self, command: Command) -> int:
        """Start a command in the place of a controller; return the number of its process."""
        environment = (
            domain_environment(command.environment, self._domain)
            if self._ros == 2
            else command_environment(command.environment, self.master)
        )
        self._tree = ProcessTree(
            command.words,
            environment,
            lambda: (self._relay_process.pid, *readers()),
            command.answers,
        )
        return self._tree.pid

    def end_input(self) -> bool:
        """End the input of a command that waits for more than its answers; whether it did."""
        return self._tree is not None and self._tree.end_input()

    def settle(self) -> bool:
        """Take what has come until nothing stirs; False once the controller has ended.

        A compiled node that computes on and on does not delay the clock for ever.

        Raises:
            LimitError: the controller computes, or waits for the disk, for too long.
        """
        began, polls = time.monotonic(), 0
        while True:
            came = self._take()
            polls = 0 if came else polls + 1
            if self.controller is not None and self.controller.is_closed:
                return False
            if self.relay.is_closed:
                raise DependencyError(
                    f"the node of the twin on ROS {self._ros} has ended: see what it printed"
                )
            has_ended = self._tree is not None and self._tree.code is not None
            if not came and self._sleeps() and not self._has_input():
                self._computed_ns, self.is_computing = 0, False
                return not has_ended
            if self._has_computed_a_step():
                return True
            if came:
                began = time.monotonic()
            elif time.monotonic() - began > _STUCK_S:
                raise LimitError(
                    f"the controller has computed for {_STUCK_S:g} s without a message, a call "
                    "or a wait; a live run moves on only while it waits"
                )
            self._wait(poll_s(polls))

    def wait_wall(self, seconds: float) -> None:
        """Wait for some wall time, or less where something comes."""
        self._wait(seconds)

    def close(self) -> None:
        """End all processes, the controller's by an interrupt at first."""
        if self._tree is not None:
            self._tree.end()
        for process, signals in (
            (self._controller_process, (signal.SIGINT, signal.SIGTERM, signal.SIGKILL)),
            (self._relay_process, (signal.SIGTERM, signal.SIGKILL)),
        ):
            if process is not None:
                end_process(process, *signals)
        self.relay.close()
        if self.controller is not None:
            self.controller.close()

    def _ready(self) -> str:
        frame = first_frame(self.relay)
        if frame is None or frame[0].get("is") != "ready":
            self._relay_process.kill()
            self._relay_process.wait()
            what = "the master of ROS 1" if self._ros == 1 else "the node of the twin on ROS 2"
            raise DependencyError(f"{what} does not start: see what it has printed")
        return str(frame[0]["uri"])

    def _take(self) -> bool:
        """Take all frames that have come, of the controller first: it reports before it sends."""
        of_relay = self.relay.waiting()
        has_noted = self.look()
        of_controller = self.controller.waiting() if self.controller is not None else []
        for header, body in of_controller:
            self.on_controller(header, body)
        for header, body in of_relay:
            self.on_relay(header, body)
        return bool(of_relay or of_controller or has_noted)

    def _has_computed_a_step(self) -> bool:
        """Return whether a compiled node has computed for as long as a step of the clock takes."""
        if self._tree is None:
            return False
        self._computed_ns += self._tree.computed_ns()
        self.is_computing = self.is_computing or self._computed_ns > _PATIENCE_NS
        if not self.is_computing or self._computed_ns < STEP_NS:
            return False
        self._computed_ns = min(self._computed_ns - STEP_NS, STEP_NS)
        return True

    def _links(self) -> Sequence[Link]:
        links = [self.relay] if self.controller is None else [self.relay, self.controller]
        return [link for link in links if not link.is_closed]

    def _has_input(self) -> bool:
        readable, _, _ = select.select(self._links(), [], [], 0.0)
        return bool(readable)

    def _wait(self, seconds: float) -> None:
        select.select(self._links(), [], [], seconds)

    def _sleeps(self) -> bool:
        """Return whether all threads sleep, looked at twice: one may just have woken another."""
        pids = [self._relay_process.pid]
        if self._controller_process is not None:
            pids.insert(0, self._controller_process.pid)
        pids += self.command_processes
        return all(_all_sleep(pid) for _ in range(2) for pid in pids)


def _all_sleep(pid: int) -> bool:
    try:
        for task in os.scandir(f"/proc/{pid}/task"):
            if stat_fields(task.path)[0] not in b"SZXt":
                return False
    except (FileNotFoundError, ProcessLookupError):
        # A thread, or all of them, has ended: another look says what is left.
        return not Path(f"/proc/{pid}").exists()
    return True
