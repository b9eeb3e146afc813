"""What a controller asked its world for in vain, reported at the end of a run with its remedy."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from tracerisk.common.text.near_names import near_names
from tracerisk.errors import Location
from tracerisk.pipeline.run.needs.lacked import Lacked, below_root, typed
from tracerisk.pipeline.run.needs.noted_drafts import NotedDrafts
from tracerisk.pipeline.trace.run_files import UNMET, DraftsNoted
from tracerisk.ros.controller.needs import Missed, Need, NeedKind
from tracerisk.ros.drafts.commanding_messages import commands_something
from tracerisk.ros.drafts.draft import likely_mistake
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.scenario.file.lines import scenario_lines
from tracerisk.trace import GOOD_ENDS, EndCause

_RECENT_NS = 1_000_000_000  # what was asked for last before an error may have led to it
_ASKED_AGAIN_NS = 10_000_000_000
_LISTED = 3
_DONE = frozenset({"no_motion", "ended", "duration"})
_OF_ENTER = re.compile(r"""(''|"")(?![\w])|could not convert string|EOF""")
_LISTENING = frozenset({"quiescent", "idle"})
# An answer that never comes: the call of a service that nobody serves, a goal for nobody.
_LASTING: frozenset[NeedKind] = frozenset({"topic", "service", "action"})


@dataclass(frozen=True, slots=True)
class JudgedEnd:
    """How a run ended in the light of what it lacked."""

    cause: EndCause
    """The cause of the end."""
    message: str
    """How the run ended, in words, with what it lacked."""
    location: Location | None
    """The place of the controller at the end; `None` where not known."""
    scenario: str = ""
    """The lines of a scenario that would provide what it lacked; empty for none."""
    needs: tuple[Need, ...] = ()
    """What it lacked."""


@dataclass(slots=True, eq=False)
class UnmetNeeds:
    """The needs of one run."""

    runtime: Runtime
    """The ROS graph, the scheduler and the recording of the run."""
    interfaces: Any
    """Makes the message classes whose fields the scenario lines show."""
    root: Path
    """The folder from which messages name files."""
    has_commanded: Callable[[], bool]
    """Returns whether anything was commanded."""
    unused: Callable[[], Iterable[tuple[str, Location, str]]]
    """Returns what of the scenario nobody used: words, place, and the entry where it is not
    confirmed."""
    unanswered: Callable[[], Iterable[tuple[str, Location, bool]]]
    """Returns the goals of the scenario without a result: words, place, whether taken."""
    values: UsableValues
    """The values that are proposed for fields of messages."""
    script: Path = Path()
    """The controller's file."""
    in_source: Callable[[Path], Iterable[Missed]] = lambda _: ()
    """Returns what a source asks for, whether or not the run came so far."""
    drafts: DraftsNoted = "never"
    """When the end notes what a scenario could provide for every need, however it came."""
    shift: Callable[[], PlaceAndShift | None] = lambda: None
    """Returns by how much to move assumed poses whose goals were not reached; `None` for none."""
    _lacked: Lacked = field(init=False)
    """What the run lacks."""

    def __post_init__(self) -> None:
        self._lacked = Lacked(self.runtime, self.interfaces, self.values)

    def modules_missing(self, found: Mapping[str, str], place: Location | None) -> None:
        """Note modules that are not here, each with what to do about it."""
        self._lacked.modules = tuple(
            Missed(Need("module", name, words), 0, 0, place) for name, words in found.items()
        )

    def waited_for(self) -> tuple[Missed, ...]:
        """Return what a controller that only waits may be waiting for."""
        now_ns = self.runtime.scheduler.now_ns
        return tuple(
            missed
            for missed in self._lacked.all()
            if missed.need.kind in _LASTING or now_ns - missed.last_ns < _ASKED_AGAIN_NS
        )

    def judge(self, cause: EndCause, message: str, location: Location | None) -> JudgedEnd:
        """Return the end of a run with what it lacked, where that may be why it ended."""
        for text, place, entry in self.unused():
            here = replace(place, file=Path(place.file).name)
            text = f"in the scenario, but {text}{self._asked_instead(text)}"
            self.runtime.recorder.finding("unused", text, here, object_name=entry)
        cause, message = self._judge_unanswered(cause, message)
        if cause == "raised" and self._is_asked_beyond_answers(message):
            # A menu that has moved the arm waits for a user who has said all.
            cause = "idle"
        scheduler = self.runtime.scheduler
        named = scheduler.needs.named_in(message, scheduler.now_ns) if cause == "raised" else ()
        sought = scheduler.needs.sought_in_vain
        self._lacked.named = tuple(dict.fromkeys((*named, *sought)))
        shows_risk = cause in GOOD_ENDS and self.has_commanded()
        if self.drafts == "always" or (self.drafts == "without_risk" and not shows_risk):
            noted = NotedDrafts(self._lacked, self.root, self.script, self.in_source, self.shift)
            noted.note(shows_risk=shows_risk)
        message += self._judge_too_late(shows_risk=shows_risk)
        if cause == "raised":
            message += self._slips()
        plain = JudgedEnd(cause, message, location)
        if shows_risk:
            self._note_unmet()
            self._report_unheard()
            if cause in _LISTENING:
                self._report_unpublished()
            return plain
        led_to = self._led_to(cause, message)
        if not led_to:
            unheard = self._unheard() if cause in _DONE else ""
            return replace(plain, message=f"{message}{unheard}")
        unmet = tuple(typed(missed) for missed in led_to)
        for before, after in zip(led_to, unmet, strict=True):
            message = message.replace(f"{before.need.words},", f"{after.need.words},")
        plain = replace(plain, message=message, needs=tuple(missed.need for missed in unmet))
        plain = replace(plain, location=location or below_root(unmet[0].location, self.root))
        # What it would wait for next is reported now, not after another run.
        names = {(missed.need.kind, missed.need.name) for missed in unmet}
        more = tuple(
            missed
            for missed in (
                *self._lacked.unserved(),
                *self._lacked.further(self.in_source(self.script)),
            )
            if (missed.need.kind, missed.need.name) not in names
        )
        lines = scenario_lines(drafts((*unmet, *more), self.interfaces, self.values))
        also = f"; nor does anything provide {self.listed(more, len(more))}" if more else ""
        if cause == "quiescent":
            text = f"nothing was commanded, and nothing provides {self.listed(unmet)}{also}"
            asked_at = below_root(unmet[0].location, self.root)
            return JudgedEnd("no_motion", text, asked_at, lines, plain.needs)
        if cause in _DONE:
            text = f"{message}; nothing provides {self.listed(unmet)}{also}"
            return replace(plain, message=text, scenario=lines)
        return replace(plain, message=f"{message}{also}", scenario=lines)

    def _asked_instead(self, unused: str) -> str:
        """Return in words what the controller asks for in vain by a name near that of an entry.

        `unused` says that nobody uses the entry, its name last.
        """
        asked = {
            missed.need.name: missed
            for missed in (*self._lacked.unserved(), *self._lacked.missed())
        }
        near = near_names(unused.rpartition(" ")[2], asked)
        return "".join(
            f"; did you mean {name}? The controller asks for it in vain ({place})"
            for name in near
            if (place := below_root(asked[name].location, self.root)) is not None
        )

    def _judge_unanswered(self, cause: EndCause, message: str) -> tuple[EndCause, str]:
        """Report goals of a scenario without a result; return how the run then ended, in words.

        That nobody takes a goal although nothing else can happen is a deadlock.
        """
        untaken = []
        if cause == "cycles":
            return cause, message
        for text, place, is_taken in self.unanswered():
            if cause == "duration" and is_taken:
                continue
            untaken += [] if is_taken else [text]
            here = replace(place, file=Path(place.file).name)
            self.runtime.recorder.finding("unprovided", f"in the scenario, {text}", here)
        if untaken and cause == "quiescent":
            return "deadlock", "; ".join((message, *untaken))
        return cause, message

    def _judge_too_late(self, *, shows_risk: bool) -> str:
        """Report subscriptions that came after the only message; return words for a stuck run."""
        texts = []
        for late in self.runtime.graph.too_late():
            text = (
                f"the message on {late.need.name} was published before the controller subscribed, "
                "and a volatile subscription does not get it; subscribe with the durability "
                "TRANSIENT_LOCAL"
            )
            texts.append(f"; {text}")
            if shows_risk:
                place = below_root(late.location, self.root)
                name = late.need.name
                self.runtime.recorder.finding("unprovided", text, place, object_name=name)
        return "" if shows_risk else "".join(texts)

    def listed(self, unmet: tuple[Missed, ...], most: int = _LISTED) -> str:
        """Return the needs in words, at most `most`, each with the place that asks for it."""
        places = [
            (self._words(missed.need), below_root(missed.location, self.root))
            for missed in unmet[:most]
        ]
        lines = [name + (f", asked for at {place}" if place else "") for name, place in places]
        if len(unmet) > most:
            lines.append(f"{len(unmet) - most} more")
        return "; ".join(lines)

    def _slips(self) -> str:
        """Return in words which services and actions have names that are slips of a driver's."""
        unserved = self._lacked.unserved()
        texts = {missed.need.words: self._words(missed.need) for missed in unserved}
        return "".join(
            f"; nothing provides {text}" for words, text in texts.items() if text != words
        )

    def _words(self, need: Need) -> str:
        """Return a need in words; of one whose name is a slip also what is meant."""
        meant = likely_mistake(need, self.values)
        return f"{need.words}, {meant}" if meant else need.words

    def _unheard(self) -> str:
        """Return in words that what a controller publishes reaches nobody, the twin included."""
        needs = [missed.need for missed in self.runtime.graph.unheard()]
        lines = [f"{need.name} ({need.type_name})" for need in needs[:_LISTED]]
        if len(needs) > _LISTED:
            lines.append(f"{len(needs) - _LISTED} more")
        return f"; nobody receives what it publishes on {', '.join(lines)}" if lines else ""

    def _report_unheard(self) -> None:
        """Report what a controller publishes as if to move something, and reaches nobody."""
        for missed in self.runtime.graph.unheard():
            name, type_name = missed.need.name, missed.need.type_name
            if commands_something(name, type_name, self.interfaces.message(type_name)):
                self.runtime.recorder.finding(
                    "unprovided",
                    f"nobody receives what it publishes on {name} ({type_name}): if that moves "
                    "anything, no figure has it",
                    below_root(missed.location, self.root),
                    object_name=name,
                )

    def _report_unpublished(self) -> None:
        """Report topics on which nobody publishes: the run may have ended because of them."""
        for missed in self.runtime.graph.unpublished():
            self.runtime.recorder.finding(
                "unprovided",
                f"nothing provides {missed.need.words}, to which the controller listens; a "
                "scenario (--scenario) can",
                below_root(missed.location, self.root),
                object_name=missed.need.name,
            )

    def _note_unmet(self) -> None:
        """Note what the controller asked for in vain and went on without."""
        needs = [
            {
                "kind": missed.need.kind,
                "name": missed.need.name,
                "words": self._words(missed.need),
                "location": None if place is None else [place.file, place.line, place.column],
            }
            for missed in map(typed, self._lacked.missed())
            for place in (below_root(missed.location, self.root),)
        ]
        if needs:
            self.runtime.recorder.note(UNMET, needs=needs)

    def _is_asked_beyond_answers(self, message: str) -> bool:
        """Return whether an exception is for Enter, where a question that was answered comes again.

        The controller has moved something by then.
        """
        if not self.has_commanded() or _OF_ENTER.search(message) is None:
            return False
        needs, now_ns = self.runtime.scheduler.needs, self.runtime.scheduler.now_ns
        return any(
            missed.need.kind == "input"
            and missed.last_ns == now_ns
            and needs.is_met("input", missed.need.name)
            for missed in needs.missed
        )

    def _led_to(self, cause: EndCause, message: str) -> tuple[Missed, ...]:
        if cause in ("raised", "exited"):
            now_ns = self.runtime.scheduler.now_ns
            missed = self._lacked.missed()
            return tuple(
                item
                for item in missed
                if now_ns - item.last_ns <= _RECENT_NS
                # An answer that was only Enter shows in what is raised for it.
                and (item.need.kind != "input" or cause == "exited" or _OF_ENTER.search(message))
            )
        if cause == "deadlock":
            return self._lacked.missed() or self._lacked.all()
        if cause in ("no_motion", "quiescent", "ended", "duration", "idle"):
            return self._lacked.all()
        return ()
