"""What a scenario could provide for what a run lacked, noted at its end."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from tracerisk.instrument.source.service_types import lines_of_function
from tracerisk.pipeline.run.needs.lacked import Lacked, below_root, typed
from tracerisk.pipeline.trace.run_files import DRAFTS
from tracerisk.pipeline.workspace.needs_in_source import reads_command_line
from tracerisk.ros.controller.needs import Missed
from tracerisk.ros.drafts.drafted_entries import COMMANDING, names_command
from tracerisk.ros.drafts.drafting import drafts, drafts_instead
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.ros.scenario.asked_frames import further_frames

_SEEN = re.compile(r"sensor_msgs/(\w*Image|PointCloud2?|LaserScan)$")


@dataclass(frozen=True, slots=True)
class NotedDrafts:
    """Drafts what a scenario could say for the needs of one run, and notes it in the recording."""

    lacked: Lacked
    """What the run lacked."""
    root: Path
    """The folder from which messages name files."""
    script: Path
    """The controller's file."""
    in_source: Callable[[Path], Iterable[Missed]]
    """Returns what a source asks for, whether or not the run came so far."""
    shift: Callable[[], PlaceAndShift | None]
    """Returns by how much to move assumed poses whose goals were not reached; `None` for none."""

    def note(self, *, shows_risk: bool) -> None:
        """Note what a scenario could say for all that nothing has given the controller.

        One that shows no risk may wait for a switch too.
        """
        lacked, values = self.lacked, self.lacked.values
        runtime, interfaces = lacked.runtime, lacked.interfaces
        lacking = {
            (missed.need.kind, missed.need.name): missed for missed in map(typed, lacked.missed())
        }
        needs = runtime.scheduler.needs
        left_off = () if shows_risk else needs.left_off
        if needs.came_nowhere is not None and not shows_risk:
            need = needs.came_nowhere.need
            if values.mount() is not None:
                need = replace(need, kind="mount")
            left_off = (*left_off, replace(needs.came_nowhere, need=need))
        # Of what the script asks for by name, what comes later is given with what comes first.
        later = () if shows_risk else lacked.further(self.in_source(self.script))
        frames = further_frames(lacking.values(), self.in_source(self.script), runtime)
        beside = (*lacked.further(self._beside()), *later, *frames)
        obeyed = self._may_be_obeyed(shows_risk=shows_risk)
        # Of a library's many clients only those are in use that are waited for or called.
        own = [
            missed
            for missed in lacked.unserved()
            if missed.need.kind == "topic" or self._is_script(missed)
        ]
        for missed in (*lacked.modules, *own, *beside, *lacked.uncalled(), *left_off, *obeyed):
            lacking.setdefault((missed.need.kind, missed.need.name), missed)
        made = drafts(lacking.values(), interfaces, values, with_others=True)
        for need, dimensions in needs.doubts.items():
            doubting = values.doubting(sorted(dimensions))
            made += drafts([Missed(need, 0, 0, None)], interfaces, doubting)
        if not shows_risk:
            made += tuple(drafts_instead(needs.taken))
        placed = [replace(draft, location=below_root(draft.location, self.root)) for draft in made]
        fields = [asdict(draft) for draft in placed]
        reach = asdict(values.reach) if reads_command_line(self.script) else None
        runtime.recorder.note(DRAFTS, drafts=fields, shift=self.shift(), reach=reach)

    def _is_script(self, missed: Missed) -> bool:
        """Return whether the script itself asks for something, and no module that it imports."""
        return missed.location is not None and Path(missed.location.file) == self.script

    def _may_be_obeyed(self, *, shows_risk: bool) -> Iterator[Missed]:
        """Yield what is published to nobody, and by its fields may move the robot.

        What has moved it otherwise may publish a pose for a display. A message of which nothing but
        its fields says that it is a command is one where it is the only one.
        """
        by_fields: list[Missed] = []
        is_other = shows_risk or self._sees()
        for missed in self.lacked.runtime.graph.unheard():
            if shows_risk and missed.need.type_name in COMMANDING:
                continue
            obeyed = replace(missed, need=replace(missed.need, kind="command"))
            (draft,) = drafts([obeyed], self.lacked.interfaces, self.lacked.values)
            if draft.value is None or "subscribed_topics" not in draft.value:
                continue
            heard = draft.value["subscribed_topics"].values()
            is_motion = any("move" in topic for topic in heard)
            if is_motion and not names_command(obeyed.need, self.lacked.interfaces):
                by_fields.append(obeyed)
            else:
                is_other = True
                yield obeyed
        if len(by_fields) == 1 and not is_other:
            yield by_fields[0]

    def _sees(self) -> bool:
        """Return whether the controller listens to a camera or the like: it says what it sees."""
        graph = self.lacked.runtime.graph
        return any(
            subscription.by_controller and _SEEN.match(subscription.type_name)
            for topic in graph.topic_names()
            for subscription in graph.subscriptions(topic)
        )

    def _beside(self) -> Iterator[Missed]:
        """Yield the services that a function asks for which waits for one: it waits for each."""
        for missed in self.lacked.missed():
            place = missed.location
            if missed.need.kind != "service" or place is None:
                continue
            first, last = lines_of_function(place)
            for asked in self.in_source(Path(place.file)):
                at = None if asked.location is None else asked.location.line
                if asked.need.kind == "service" and at is not None and first <= at <= last:
                    yield asked
