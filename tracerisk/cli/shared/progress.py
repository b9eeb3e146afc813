"""Show at a terminal how far a run or a campaign is."""

from __future__ import annotations

import contextlib
import io
import math
import os
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from types import ModuleType
from typing import Any

from tracerisk.cli.shared.output import is_dumb
from tracerisk.pipeline.check.cached_run import last_duration_s


@contextlib.contextmanager
def progress_bar(
    most_s: float | None = None, *, quiet: bool, controller: str | None = None
) -> Iterator[Callable[[str, float], None] | None]:
    """Yield what shows the phase and the simulated seconds; `None` where there is no terminal.

    `most_s` is the simulated time [s] after which a run is over, where it is known. Of a
    `controller` that `tracerisk.lock` knows, the time left is shown, as if it ran as long again.
    What is printed on standard error meanwhile stands above the bar, which is gone at the end.
    Where it is `quiet`, what a controller prints meanwhile goes nowhere.
    """
    usual_s = None
    if controller is not None:
        usual_s = last_duration_s(controller)

    def columns(rich: ModuleType) -> Iterable[Any]:
        yield rich.SpinnerColumn()
        yield rich.TextColumn("{task.description:<17}")
        yield rich.BarColumn(bar_width=20)
        yield rich.TextColumn("{task.fields[simulated]}")
        yield rich.TimeElapsedColumn()
        yield rich.TextColumn("{task.fields[left]}")

    with _bar(columns, quiet=quiet) as bar:
        if bar is None:
            yield None
            return
        # Nobody knows when a new controller will end: the bar says that it runs, not how far it is.
        task = bar.add_task("reading", total=None, simulated="", left="")
        first: tuple[float, float] | None = None  # wall and simulated time [s] of the first sign

        def notify(phase: str, simulated_s: float) -> None:
            nonlocal first
            most = "" if most_s is None else f" of at most {most_s:g}"
            simulated = f"{simulated_s:.1f}{most} s simulated" if simulated_s > 0.0 else ""
            left, done, total = "", None, None
            if usual_s is not None and simulated_s > 0.0:
                now = time.monotonic()
                first = first or (now, simulated_s)
                done, total = min(simulated_s, usual_s), usual_s
                if (gained := simulated_s - first[1]) > 0.0:
                    left_s = (total - done) * (now - first[0]) / gained
                    left = f"about {math.ceil(left_s)} s left"
            bar.update(
                task,
                description=phase,
                simulated=simulated,
                left=left,
                total=total,
                completed=done,
                # A new phase is drawn at once: it may be over before the next regular draw.
                refresh=phase != bar.tasks[0].description,
            )

        yield notify


@contextlib.contextmanager
def bar_of_cells(
    what: str, first: str = "", *, quiet: bool
) -> Iterator[Callable[[int, int, float], None] | None]:
    """Yield what shows how many parts of a campaign are done; `None` without a terminal.

    `what` are the parts, `first` is what is done before them.
    Where it is `quiet`, what a controller prints meanwhile goes nowhere.
    """

    def columns(rich: ModuleType) -> Iterable[Any]:
        yield rich.TextColumn("{task.description}")
        yield rich.BarColumn(bar_width=20)
        yield rich.MofNCompleteColumn()
        yield rich.TextColumn("{task.fields[left]}")

    with _bar(columns, quiet=quiet) as bar:
        if bar is None:
            yield None
            return
        task = bar.add_task(what, total=None, left=first)

        def notify(done: int, of: int, left_s: float) -> None:
            bar.update(task, completed=done, total=of, left=f"{left_s:.0f} s left")

        yield notify


@contextlib.contextmanager
def _bar(columns: Callable[[ModuleType], Iterable[Any]], *, quiet: bool) -> Iterator[Any]:
    """Yield a bar of these columns of `rich.progress`; `None` where there is no terminal.

    Where it is `quiet` there is none either, and what is printed meanwhile goes nowhere.
    """
    if quiet:
        with contextlib.redirect_stderr(_Nowhere()):
            yield None
    elif not sys.stderr.isatty() or is_dumb():
        yield None
    else:
        from rich import progress
        from rich.console import Console

        console = Console(stderr=True, no_color=bool(os.environ.get("NO_COLOR")))
        shown = progress.Progress(
            *columns(progress), console=console, transient=True, redirect_stdout=False
        )
        with shown:
            yield shown


class _Nowhere(io.TextIOBase):
    """A stream without a file descriptor that takes text and drops it."""

    def write(self, text: str) -> int:
        return len(text)
