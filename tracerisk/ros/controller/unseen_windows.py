"""Where the figures of matplotlib are drawn in a run: in memory, and only when they are wanted.

A run has no screen. A figure that a loop shows anew at each step, which nobody sees, would take
most of the processor's time of the run. One that is saved, or whose pixels are read, is drawn.
matplotlib loads this module as its backend, by the name in `MPLBACKEND`.
"""

from __future__ import annotations

from typing import Any

from matplotlib.backend_bases import FigureManagerBase
from matplotlib.backends.backend_agg import FigureCanvasAgg


class FigureCanvas(FigureCanvasAgg):  # type: ignore[misc]
    """A canvas in memory, of which nothing is shown."""

    def draw_idle(self, *_: Any, **__: Any) -> None:
        """Draw nothing: there is no window in which it would be seen."""


FigureManager = FigureManagerBase
