"""A command on its way, with what is known of it while it lasts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from tracerisk.twin.motion.execution import Motion

if TYPE_CHECKING:
    from tracerisk.instrument.tracer import Frame


@dataclass(slots=True, eq=False)
class LiveCommand:
    """A command whose motion goes on.

    A stream of set-points puts the next motion in the place of the one before: `TwinCommands.lead`.
    """

    id: int
    """Its number in the recording; 0 where it has no stack."""
    motion: Motion
    """The motion that carries it out, the last one of a stream."""
    stack: tuple[Frame, ...]
    """The functions that issued it."""
    on_end: Callable[[Motion], None]
    """What is called once, when it has ended."""
    misses: Callable[[Motion], str]
    """What says of a motion that succeeded why it is a failure all the same; empty if it is not."""
    what: str
    """What it is called where it fails."""
    object_name: str
    """What its failure is about."""
    commanded_ns: int
    """When the controller last commanded it, in simulated time [ns]."""
    keep_until_ns: int = 0
    """Until when another set-point may follow [ns]."""
    led_by: float = 0.0
    """How far the earlier set-points of the stream have led [rad or m]."""
    has_led_on: bool = False
    """Whether it leads elsewhere than where it was issued to."""
    timed_out: str = ""
    """What to say where the driver ends a velocity that is not sent again; empty if it was."""
    kind: str = ""
    """What it is called where something is said of it."""
