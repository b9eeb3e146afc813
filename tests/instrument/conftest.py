"""Run a few lines of controller under a real tracer."""

import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tracerisk.instrument.loader import run_controller
from tracerisk.instrument.tracer import Frame, Tracer


@dataclass(frozen=True)
class Commanded:
    """One call of `command(...)` by the controller."""

    tag: Any
    stack: tuple[Frame, ...]

    @property
    def names(self) -> list[str]:
        return [str(frame.function.name) for frame in self.stack]


@dataclass(frozen=True)
class Ran:
    """A controller that ran: its tracer, its commands and what it put into `shown`."""

    tracer: Tracer
    path: Path
    commands: list[Commanded]
    shown: list[Any]


class _Robot:
    """What the controllers of these tests import as `robot`: a library that asks the tracer."""

    def __init__(self, tracer: Tracer) -> None:
        self.tracer = tracer
        self.commands: list[Commanded] = []
        self.shown: list[Any] = []

    def command(self, tag: Any = None) -> Any:
        self.commands.append(Commanded(tag, self.tracer.stack()))
        return tag

    def show(self, value: Any) -> None:
        self.shown.append(value)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[str], Ran]:
    """Return what runs dedented source as a controller that may `import robot`."""
    import sys

    def run_source(source: str) -> Ran:
        path = tmp_path / "controller.py"
        path.write_text(textwrap.dedent(source), encoding="utf-8")
        tracer = Tracer()
        robot = _Robot(tracer)
        monkeypatch.setitem(sys.modules, "robot", robot)
        run_controller(path, tracer, root=tmp_path)
        return Ran(tracer, path, robot.commands, robot.shown)

    return run_source
