"""The error of a run that came to a bad end."""

from __future__ import annotations

from tracerisk.errors import ControllerFailedError

TYPE_CHECKING = False
if TYPE_CHECKING:
    from tracerisk.trace import Trace


class RunFailedError(ControllerFailedError):
    """The run of a controller came to a bad end; `trace` is what it showed until then."""

    def __init__(self, trace: Trace) -> None:
        super().__init__(trace.end.message, trace.end.location, trace.end.scenario)
        self.trace = trace
