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
    """What a run is made of.

    `argv` is the controller's command line, `seed` that of everything random.
    `parameters` are those of the scenario and of parameter files, later ones first in rank.
    `packages` are those of the controller's workspace, each name with its folder; `installed` those
    that it does not have itself, of an installed ROS and of overlays.
    `distro` has the rules of the distribution of ROS that the run follows.
    `clients` holds the state of each client library, by the class of that state. `beside` is the
    runtime of the controller where this one is that of a companion: what is the world's of the
    states, and no process's own (its class says `is_of_world`), they share.
    """

    scheduler: Scheduler
    graph: Graph
    twin: Any = None
    tracer: CallTracer | Any = None
    recorder: Any = None
    argv: tuple[str, ...] = ("controller",)
    seed: int = 0
    packages: Mapping[str, Path] = field(default_factory=dict)
    parameters: tuple[Parameter, ...] = ()
    distro: DistroRules = field(default_factory=DistroRules)
    clients: dict[type, Any] = field(default_factory=dict)
    beside: Runtime | None = None
    installed: Mapping[str, Path] = field(default_factory=dict)

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
        raise RuntimeError("no run is active: the ROS stand-ins work inside `tracerisk run` only")
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
