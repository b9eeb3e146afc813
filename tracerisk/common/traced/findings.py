"""What a run showed that a user should know, and which kinds of it are harmless."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from tracerisk.errors import Location, with_file, with_line

_NAMED_LINE = re.compile(r"\bline \d+")
UNUSED = "unused"
"""The kind of a finding on what of a scenario nobody made use of; `object` is an entry that nobody
has confirmed."""
NOTHING_TO_GRASP = "nothing_to_grasp"
"""The kind of a finding on where a gripper closed on nothing, and that was no fault."""
UNEXPECTED_CONTACT = "unexpected_contact"
"""The kind of a finding on a touch that was not to be expected."""
NOTES: frozenset[str] = frozenset(
    {
        "assumed_name",
        "assumed_setting",
        "assumed_start",
        "concurrent_owners",
        "distro_assumed",
        "handled_late",
        "not_simulated",
        NOTHING_TO_GRASP,
        "other_frame",
        "other_link",
        "qos_misfit",
        "removed_name",
        "stopped_nothing",
        "too_fast",
        "unlikely_turn",
        "unlikely_unit",
        UNUSED,
    }
)
"""The kinds of findings by which nothing went wrong: what was assumed, is not simulated, or did
nothing, and what may be meant otherwise."""
REPORTED: frozenset[str] = frozenset(
    {
        "attach_failure",
        "execution_failure",
        "fk_failure",
        "goal_rejected",
        "ik_failure",
        "lookup_failure",
        "path_cut",
        "planning_failure",
        "service_refused",
    }
)
"""The kinds of findings that an interface reports to the controller."""


@dataclass(frozen=True, slots=True)
class Finding:
    """Something the run showed that a user should know; not an error."""

    kind: str
    """The kind of finding, such as `planning_failure`; `NOTES` lists the harmless ones."""
    message: str
    """The finding in one sentence, for the user."""
    time_s: float | None = None
    """The simulated time at which it occurred [s]; `None` where it has no time."""
    location: Location | None = None
    """The line of the controller that it concerns; `None` where none is known."""
    function: str = ""
    """The qualified name of the function in which it happened; empty where none is known."""
    object: str = ""
    """What it is about: a frame, a service, a joint, a group, a gripper, a thing of the scene."""
    target: tuple[float, ...] = ()
    """The goal of what failed: joint positions [rad or m], or a position [m]."""
    recovered_s: float | None = None
    """When a retry of what failed succeeded [s]; `None` where none did."""
    called_from: Location | None = None
    """The line that called the function in which it happened; `None` where none is known."""
    named: tuple[Location, ...] = ()
    """The places whose lines the message names, as in `line 12`, in the order of the message."""

    def with_lines(self, line_of: Callable[[str, int], int]) -> Finding:
        """Return the finding with other lines, those that its message names included."""
        named = tuple(
            moved_place for place in self.named if (moved_place := with_line(place, line_of))
        )
        lines = iter(named)

        def moved(match: re.Match[str]) -> str:
            place = next(lines, None)
            return match[0] if place is None else f"line {place.line}"

        return replace(
            self,
            message=_NAMED_LINE.sub(moved, self.message),
            location=with_line(self.location, line_of),
            called_from=with_line(self.called_from, line_of),
            named=named,
        )

    def with_files(self, file_of: Callable[[str], str]) -> Finding:
        """Return the finding with other names of files; `file_of` takes a file."""
        return replace(
            self,
            location=with_file(self.location, file_of),
            called_from=with_file(self.called_from, file_of),
            named=tuple(replace(place, file=file_of(place.file)) for place in self.named),
        )
