"""The one run that a process of the controller serves.

Client libraries are global by nature: `rospy.loginfo` is handed no context. This is the single
slot from which the stand-ins take theirs; nothing else in tracerisk is process-wide.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from tracerisk.ros.distributions.in_run import DistroRules

if TYPE_CHECKING:
    from tracerisk.ros.graph.graph import Graph
    from tracerisk.ros.graph.parameter_files import Parameter
    from tracerisk.ros.time.scheduler import CallTracer, Scheduler

State = TypeVar("State")


@dataclass(frozen=True, slots=True)
class Runtime:
    """The parts of a run."""

    scheduler: Scheduler
    """The scheduler of threads and simulated time."""
    graph: Graph
    """The topics, services and parameters."""
    twin: Any = None
    """The simulated robot and scene; `None` in a run without one."""
    tracer: CallTracer | Any = None
    """The tracer of the controller's functions; `None` without tracing."""
    recorder: Any = None
    """The recorder of events; `None` where nothing is recorded."""
    argv: tuple[str, ...] = ("controller",)
    """The controller's command line."""
    seed: int = 0
    """The seed of everything random."""
    packages: Mapping[str, Path] = field(default_factory=dict)
    """The folders of the workspace's packages, by name."""
    parameters: tuple[Parameter, ...] = ()
    """The parameters of the scenario and of files, in rising rank."""
    distro: DistroRules = field(default_factory=DistroRules)
    """The rules of the ROS distribution that the run follows."""
    moveit_release: str | None = None
    """The release of MoveIt that the settings name; `None` where they name none."""
    clients: dict[type, Any] = field(default_factory=dict)
    """The state of each client library, by its class."""
    beside: Runtime | None = None
    """The controller's runtime, for a companion's, with which it shares the states whose class has
    `is_of_world`; else `None`."""
    installed: Mapping[str, Path] = field(default_factory=dict)
    """The folders of packages that only an installed ROS or an overlay has, by name."""

    @property
    def findable(self) -> Mapping[str, Path]:
        """The packages that can be asked for by their names, those of the workspace first."""
        return {**self.packages, **self.installed}

    @property
    def searched(self) -> str:
        """In words where packages are looked for, for the message that one is not there."""
        known = ", ".join(self.packages) or "none"
        count = len(self.installed)
        there = (
            f"; {count} more are installed or beside it" if count else "; no ROS is installed here"
        )
        return f"the workspace of the controller, which has {known}{there}"

    def client(self, kind: Callable[[Runtime], State]) -> State:
        """Return the state of a client library, made by its class when first asked for."""
        if self.beside is not None and getattr(kind, "is_of_world", False):
            return self.beside.client(kind)
        if kind not in self.clients:
            self.clients[kind] = kind(self)  # type: ignore[index]
        state: State = self.clients[kind]  # type: ignore[index]
        return state


_active: list[Runtime] = []


def current() -> Runtime:
    """Return the runtime that is active: in the code of a companion its own.

    Raises:
        RuntimeError: none is; a stand-in was used outside a run.
    """
    if not _active:
        raise RuntimeError(
            "no run is active: the ROS stand-ins work inside `tracerisk run FILE` only"
        )
    process = _active[-1].scheduler.process
    return _active[-1] if process is None else process.runtime


def running() -> Runtime | None:
    """Return the runtime that is active, `None` outside a run."""
    return current() if _active else None


@contextmanager
def activate(runtime: Runtime) -> Iterator[Runtime]:
    """Make `runtime` the active one within the block."""
    _active.append(runtime)
    try:
        yield runtime
    finally:
        _active.remove(runtime)
