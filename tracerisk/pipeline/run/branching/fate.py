"""End a run with a failure once what becomes of its mission is decided.

What happens later adds words to what is known, and costs most of the time of a campaign. What
decides is simulated: a branch, and a run from the beginning, end at the same instant.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from tracerisk.common.traced.findings import REPORTED
from tracerisk.instrument.recorder import Recorder
from tracerisk.pipeline.run.branching.flow import flow_key
from tracerisk.pipeline.trace.run_files import DECIDED, RunBeside
from tracerisk.ros.time.scheduler import Scheduler
from tracerisk.twin.faults.armed import first_step
from tracerisk.twin.faults.fault import Fault
from tracerisk.twin.recording.contact_log import LoggedBody
from tracerisk.twin.recording.contact_pairs import hand_links
from tracerisk.twin.robots.robot import Robot
from tracerisk.twin.simulation.twin import Twin

TOLD_S = 10.0
"""How long a run goes on after its mission failed and its controller was notified [s]."""
UNTOLD_S = 20.0
"""How long it goes on where the controller is not notified [s]."""
OFF = 0.021
"""How far off a joint is between two visits where it is elsewhere [rad, or m of a sliding one]: a
little more than whoever judges the run takes."""


class FateWatch:
    """Watches a run with a failure, and sets its end once its mission has failed for certain.

    `beside` is the run without the failure. A mission has failed where a link of the robot touches
    what it does not touch there; where a joint is elsewhere than there when the next visit begins;
    or where the controller, notified of a failure that is not reported there, has gone on to its
    next command. Whoever judges the run confirms it.
    """

    def __init__(
        self, beside: RunBeside, robot: Robot, scheduler: Scheduler, twin: Twin, recorder: Recorder
    ) -> None:
        self._scheduler, self._twin, self._recorder = scheduler, twin, recorder
        self._reports = frozenset(beside.reports)
        self._touches = frozenset(map(frozenset, beside.touches))
        self._arrivals = {number: np.array(at) for number, at in beside.arrivals}
        self._only_touches = beside.has_conditions
        self._flow = beside.flow
        self._hands = frozenset(
            link for gripper in robot.grippers for link in hand_links(robot, gripper.name)[1]
        )
        self._longest_ns = scheduler.duration_ns
        self._from_ns = 0
        self._notified_ns: int | None = None
        self._failed_ns: int | None = None
        self._is_struck = self._has_left = False
        self._end_ns: int | None = None

    def begin(self, faults: Sequence[Fault]) -> None:
        """Watch from the first instant of these failures on."""
        self._from_ns = min(map(first_step, faults)) * self._twin.step_ns
        self._recorder.on_event = self._recorded
        self._twin.watch_touches(self._touched)

    def note_end(self) -> None:
        """Note that the run ends here because its fate is decided, where it does."""
        if self._end_ns is not None and self._scheduler.now_ns >= self._end_ns:
            self._recorder.note(DECIDED)

    def _recorded(self, event: str, time_ns: int, data: Mapping[str, Any]) -> None:
        if time_ns < self._from_ns:
            return
        if event == "finding" and self._notified_ns is None and data["kind"] in REPORTED:
            if (data["kind"], data["message"], data["object"]) not in self._reports:
                self._notified_ns = time_ns
                self._decide()
        elif event == "command":
            self._has_left = self._has_left or not self._is_as_before(data)
            if self._shows_in(data["id"]):
                self._fail(time_ns)
            elif self._has_left:
                self._decide()

    def _is_as_before(self, command: Mapping[str, Any]) -> bool:
        """Return whether a command is the one that the run without the failure issued there."""
        place = command["id"] - 1
        sites = [frame[2:4] for frame in command["stack"]]
        now = flow_key(command["kind"], command["elements"], sites)
        return self._flow[place : place + 1] == (now,)

    def _shows_in(self, command: int) -> bool:
        """Return whether it shows where a command is issued that the mission has failed."""
        if self._only_touches or self._notified_ns is not None:
            return not self._only_touches
        expected = self._arrivals.get(command)
        return expected is not None and bool(np.abs(self._twin.posture() - expected).max() > OFF)

    def _touched(self, step: int, one: LoggedBody, two: LoggedBody) -> None:
        link, other = (one, two) if one.kind == "link" else (two, one)
        if link.kind != "link" or frozenset((link.name, other.name)) in self._touches:
            return
        if link.name in self._hands and (other.kind == "free" or other.name in self._hands):
            return  # it may be about to grasp
        self._is_struck = True
        self._fail(max(step * self._twin.step_ns, self._from_ns))

    def _fail(self, time_ns: int) -> None:
        if self._failed_ns is None:
            self._failed_ns = time_ns
            self._decide()

    def _decide(self) -> None:
        """Set the end of the run where its fate is decided.

        A controller that has left the way of the run without the failure, and has struck nothing,
        may stop safely: it is followed to its end.
        """
        if self._has_left and not self._is_struck:
            self._end(None)
            return
        if self._failed_ns is None:
            return
        end_ns = self._failed_ns + round(UNTOLD_S * 1e9)
        if self._notified_ns is not None:
            both_ns = max(self._failed_ns, self._notified_ns) + round(TOLD_S * 1e9)
            end_ns = min(end_ns, both_ns)
        end_ns = -(-end_ns // self._twin.step_ns) * self._twin.step_ns
        if end_ns < self._longest_ns:
            self._end(end_ns)

    def _end(self, end_ns: int | None) -> None:
        """End the run at an instant; `None` where it has all its time."""
        if end_ns != self._end_ns:
            self._end_ns = end_ns
            end_ns = self._longest_ns if end_ns is None else end_ns
            self._scheduler.duration_ns = self._twin.ends_ns = end_ns
