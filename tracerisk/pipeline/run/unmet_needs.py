"""What a controller asked its world for in vain, reported at the end of a run with its remedy."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from tracerisk.errors import Location
from tracerisk.instrument.source.service_types import lines_of_function, service_type
from tracerisk.pipeline.trace.run_files import DRAFTS, UNMET, DraftsNoted
from tracerisk.pipeline.workspace.needs_in_source import reads_command_line
from tracerisk.ros.controller.needs import Missed, Need, NeedKind
from tracerisk.ros.drafts.commanding_messages import commands_something
from tracerisk.ros.drafts.draft import likely_mistake
from tracerisk.ros.drafts.drafted_entries import COMMANDING, names_command
from tracerisk.ros.drafts.drafting import drafts, drafts_instead
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.ros.drafts.usable_values import UsableValues
from tracerisk.ros.graph.actions import Actions
from tracerisk.ros.graph.runtime import Runtime
from tracerisk.ros.robot.bring_up.system import SystemState
from tracerisk.ros.scenario.asked_frames import further_frames
from tracerisk.ros.scenario.file.lines import scenario_lines
from tracerisk.trace import GOOD_ENDS, EndCause

_RECENT_NS = 1_000_000_000  # what was asked for last before an error may have led to it
_ASKED_AGAIN_NS = 10_000_000_000
_LISTED = 3
_DONE = frozenset({"no_motion", "ended", "duration"})
_OF_ENTER = re.compile(r"""(''|"")(?![\w])|could not convert string|EOF""")
_SEEN = re.compile(r"sensor_msgs/(\w*Image|PointCloud2?|LaserScan)$")
# What the twin publishes once somebody listens.
_OF_THE_TWIN = re.compile(
    r"sensor_msgs/|geometry_msgs/Wrench|control_msgs/|tf2_msgs/|rosgraph_msgs/"
)
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


_Asked = Callable[[], tuple[Missed, ...]]


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
    _at_end: dict[_Asked, tuple[Missed, ...]] | None = field(default=None, init=False)
    """What each query returned when the run was over; `None` while it goes on."""
    _named: tuple[Missed, ...] = field(default=(), init=False)
    """The needs that the error of the end names, or that were sought in vain."""
    _modules: tuple[Missed, ...] = field(default=(), init=False)
    """The modules that are not here, with their remedies."""

    def __post_init__(self) -> None:
        self.runtime.scheduler.on_over = self._keep

    def _keep(self) -> None:
        """Keep what is lacking now: a controller that is ended may still take down its node."""
        asked = (self._missed_now, self._all_now, self._unserved, self._uncalled)
        self._at_end = {query: query() for query in asked}

    def _as_of_end(self, asked: _Asked) -> tuple[Missed, ...]:
        """Return what one of its methods returned when the run was over, or does now."""
        return asked() if self._at_end is None else self._at_end[asked]

    def modules_missing(self, found: Mapping[str, str], place: Location | None) -> None:
        """Note modules that are not here, each with what to do about it."""
        self._modules = tuple(
            Missed(Need("module", name, words), 0, 0, place) for name, words in found.items()
        )

    def waited_for(self) -> tuple[Missed, ...]:
        """Return what a controller that only waits may be waiting for."""
        now_ns = self.runtime.scheduler.now_ns
        return tuple(
            missed
            for missed in self._all()
            if missed.need.kind in _LASTING or now_ns - missed.last_ns < _ASKED_AGAIN_NS
        )

    def judge(self, cause: EndCause, message: str, location: Location | None) -> JudgedEnd:
        """Return the end of a run with what it lacked, where that may be why it ended."""
        for text, place, entry in self.unused():
            here = replace(place, file=Path(place.file).name)
            text = f"in the scenario, but {text}"
            self.runtime.recorder.finding("unused", text, here, object_name=entry)
        cause, message = self._judge_unanswered(cause, message)
        if cause == "raised" and self._is_asked_beyond_answers(message):
            # A menu that has moved the arm waits for a user who has said all.
            cause = "idle"
        scheduler = self.runtime.scheduler
        named = scheduler.needs.named_in(message, scheduler.now_ns) if cause == "raised" else ()
        sought = scheduler.needs.sought_in_vain
        self._named = tuple(dict.fromkeys((*named, *sought)))
        shows_risk = cause in GOOD_ENDS and self.has_commanded()
        if self.drafts == "always" or (self.drafts == "without_risk" and not shows_risk):
            self._note_drafts(shows_risk=shows_risk)
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
        unmet = tuple(_typed(missed) for missed in led_to)
        for before, after in zip(led_to, unmet, strict=True):
            message = message.replace(f"{before.need.words},", f"{after.need.words},")
        plain = replace(plain, message=message, needs=tuple(missed.need for missed in unmet))
        plain = replace(plain, location=location or self.below_root(unmet[0].location))
        # What it would wait for next is reported now, not after another run.
        names = {(missed.need.kind, missed.need.name) for missed in unmet}
        more = tuple(
            missed
            for missed in (
                *self._as_of_end(self._unserved),
                *self._further(self.in_source(self.script)),
            )
            if (missed.need.kind, missed.need.name) not in names
        )
        lines = scenario_lines(drafts((*unmet, *more), self.interfaces, self.values))
        also = f"; nor does anything provide {self.listed(more, len(more))}" if more else ""
        if cause == "quiescent":
            text = f"nothing was commanded, and nothing provides {self.listed(unmet)}{also}"
            asked_at = self.below_root(unmet[0].location)
            return JudgedEnd("no_motion", text, asked_at, lines, plain.needs)
        if cause in _DONE:
            text = f"{message}; nothing provides {self.listed(unmet)}{also}"
            return replace(plain, message=text, scenario=lines)
        return replace(plain, message=f"{message}{also}", scenario=lines)

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
                place = self.below_root(late.location)
                name = late.need.name
                self.runtime.recorder.finding("unprovided", text, place, object_name=name)
        return "" if shows_risk else "".join(texts)

    def _further(self, asked: Iterable[Missed]) -> tuple[Missed, ...]:
        """Return what of that which sources ask for by name nothing would give."""
        unserved = self._as_of_end(self._unserved)
        waits = {(missed.need.kind, missed.need.name) for missed in unserved}
        read = [
            _plain(missed.need.name) for missed in self._missed() if missed.need.kind == "parameter"
        ]
        further: dict[tuple[NeedKind, str], Missed] = {}
        for missed in asked:
            need = missed.need
            if need.name.startswith("("):
                continue
            name = _plain(need.name) if need.kind == "parameter" else need.name
            if need.kind != "parameter" and not name.startswith(("/", "~")):
                name = f"/{name}"
            need = replace(need, name=name)
            if (need.kind, name) in waits or self._is_given(need):
                continue
            if need.kind == "parameter" and any(f"/{text}".endswith(f"/{name}") for text in read):
                continue
            kept = replace(missed.need, name=missed.need.name if need.kind == "parameter" else name)
            further.setdefault((need.kind, name), replace(missed, need=kept))
        return tuple(further.values())

    def _is_given(self, need: Need) -> bool:
        """Return whether somebody gives what a source asks for, or it cannot be known yet."""
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        if need.kind == "parameter":
            given = {_plain(parameter.name) for parameter in self.runtime.parameters}
            # A namespace is given by what it holds.
            is_given = any(f"/{need.name}/" in f"/{name}/" for name in given)
            return is_given or graph.parameters.has(f"/{need.name}")
        if need.name.startswith("~") or "/" not in need.type_name:
            return True
        if need.kind == "service":
            return self._is_served(need)
        if need.kind == "action":
            return actions.server(need.name, need.type_name) is not None or self._is_arms(need)
        if need.kind == "topic":
            is_twins = _OF_THE_TWIN.match(need.type_name) is not None
            return is_twins or bool(graph.publications(need.name))
        return True

    def _is_served(self, need: Need) -> bool:
        """Return whether somebody serves a service, of the type that is asked for."""
        server = self.runtime.graph.services.find(need.name, need.type_name or None)
        if server is not None:
            return need.type_name in ("", server.type_name)
        # What the bring-up serves is on the graph only once the controller uses it.
        return any(
            end.topic == need.name and need.type_name in ("", end.type_name)
            for end in self.runtime.client(SystemState).services()
        )

    def _is_arms(self, need: Need) -> bool:
        (draft,) = drafts([Missed(need, 0, 0, None)], self.interfaces, self.values)
        return draft.value is None

    def _note_drafts(self, *, shows_risk: bool) -> None:
        """Note what a scenario could say for all that nothing has given the controller.

        One that shows no risk may wait for a switch too.
        """
        lacking = {
            (missed.need.kind, missed.need.name): missed for missed in map(_typed, self._missed())
        }
        needs = self.runtime.scheduler.needs
        left_off = () if shows_risk else needs.left_off
        if needs.came_nowhere is not None and not shows_risk:
            left_off = (*left_off, needs.came_nowhere)
        # Of what the script asks for by name, what comes later is given with what comes first.
        later = () if shows_risk else self._further(self.in_source(self.script))
        frames = further_frames(lacking.values(), self.in_source(self.script), self.runtime)
        beside = (*self._further(self._beside()), *later, *frames)
        obeyed = self._may_be_obeyed(shows_risk=shows_risk)
        unserved, uncalled = map(self._as_of_end, (self._unserved, self._uncalled))
        # Of a library's many clients only those are in use that are waited for or called.
        own = [
            missed for missed in unserved if missed.need.kind == "topic" or self._is_script(missed)
        ]
        for missed in (*self._modules, *own, *beside, *uncalled, *left_off, *obeyed):
            lacking.setdefault((missed.need.kind, missed.need.name), missed)
        made = drafts(lacking.values(), self.interfaces, self.values, with_others=True)
        for need, dimensions in needs.doubts.items():
            doubting = self.values.doubting(sorted(dimensions))
            made += drafts([Missed(need, 0, 0, None)], self.interfaces, doubting)
        if not shows_risk:
            made += tuple(drafts_instead(needs.taken))
        placed = [replace(draft, location=self.below_root(draft.location)) for draft in made]
        fields = [asdict(draft) for draft in placed]
        reach = asdict(self.values.reach) if reads_command_line(self.script) else None
        self.runtime.recorder.note(DRAFTS, drafts=fields, shift=self.shift(), reach=reach)

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
        for missed in self.runtime.graph.unheard():
            if shows_risk and missed.need.type_name in COMMANDING:
                continue
            obeyed = replace(missed, need=replace(missed.need, kind="command"))
            (draft,) = drafts([obeyed], self.interfaces, self.values)
            if draft.value is None or "subscribed_topics" not in draft.value:
                continue
            heard = draft.value["subscribed_topics"].values()
            is_motion = any("move" in topic for topic in heard)
            if is_motion and not names_command(obeyed.need, self.interfaces):
                by_fields.append(obeyed)
            else:
                is_other = True
                yield obeyed
        if len(by_fields) == 1 and not is_other:
            yield by_fields[0]

    def _sees(self) -> bool:
        """Return whether the controller listens to a camera or the like: it says what it sees."""
        graph = self.runtime.graph
        return any(
            subscription.by_controller and _SEEN.match(subscription.type_name)
            for topic in graph.topic_names()
            for subscription in graph.subscriptions(topic)
        )

    def _beside(self) -> Iterator[Missed]:
        """Yield the services that a function asks for which waits for one: it waits for each."""
        for missed in self._missed():
            place = missed.location
            if missed.need.kind != "service" or place is None:
                continue
            first, last = lines_of_function(place)
            for asked in self.in_source(Path(place.file)):
                at = None if asked.location is None else asked.location.line
                if asked.need.kind == "service" and at is not None and first <= at <= last:
                    yield asked

    def listed(self, unmet: tuple[Missed, ...], most: int = _LISTED) -> str:
        """Return the needs in words, at most `most`, each with the place that asks for it."""
        places = [
            (self._words(missed.need), self.below_root(missed.location)) for missed in unmet[:most]
        ]
        lines = [name + (f", asked for at {place}" if place else "") for name, place in places]
        if len(unmet) > most:
            lines.append(f"{len(unmet) - most} more")
        return "; ".join(lines)

    def _slips(self) -> str:
        """Return in words which services and actions have names that are slips of a driver's."""
        unserved = self._as_of_end(self._unserved)
        texts = {missed.need.words: self._words(missed.need) for missed in unserved}
        return "".join(
            f"; nothing provides {text}" for words, text in texts.items() if text != words
        )

    def _words(self, need: Need) -> str:
        """Return a need in words; of one whose name is a slip also what is meant."""
        meant = likely_mistake(need, self.values)
        return f"{need.words}, {meant}" if meant else need.words

    def below_root(self, place: Location | None) -> Location | None:
        """Return a place in the controller's source by its file's name below the root."""
        if place is None or not Path(place.file).is_relative_to(self.root):
            return place
        return replace(place, file=Path(place.file).relative_to(self.root).as_posix())

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
                    self.below_root(missed.location),
                    object_name=name,
                )

    def _report_unpublished(self) -> None:
        """Report topics on which nobody publishes: the run may have ended because of them."""
        for missed in self.runtime.graph.unpublished():
            self.runtime.recorder.finding(
                "unprovided",
                f"nothing provides {missed.need.words}, to which the controller listens; a "
                "scenario "
                "(--scenario) can",
                self.below_root(missed.location),
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
            for missed in map(_typed, self._missed())
            for place in (self.below_root(missed.location),)
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
            missed = self._missed()
            return tuple(
                item
                for item in missed
                if now_ns - item.last_ns <= _RECENT_NS
                # An answer that was only Enter shows in what is raised for it.
                and (item.need.kind != "input" or cause == "exited" or _OF_ENTER.search(message))
            )
        if cause == "deadlock":
            return self._missed() or self._all()
        if cause in ("no_motion", "quiescent", "ended", "duration", "idle"):
            return self._all()
        return ()

    def _all(self) -> tuple[Missed, ...]:
        return (*self._as_of_end(self._all_now), *self._named)

    def _missed(self) -> tuple[Missed, ...]:
        return (*self._as_of_end(self._missed_now), *self._named)

    def _unserved(self) -> tuple[Missed, ...]:
        """Return what the controller has a client of, or listens to, and nobody provides."""
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        lacking = (*graph.services.unserved(), *actions.unserved(), *graph.unpublished())
        return tuple({(missed.need.kind, missed.need.name): missed for missed in lacking}.values())

    def _all_now(self) -> tuple[Missed, ...]:
        """Return what was asked for in vain, then the topics on which nobody publishes.

        Where there is neither, what the controller serves and nobody calls.
        """
        missed = self._missed_now()
        names = {(item.need.kind, item.need.name) for item in missed}
        topics: dict[str, Missed] = {}
        for item in self.runtime.graph.unpublished():
            if ("topic", item.need.name) not in names:
                topics.setdefault(item.need.name, item)
        lacking = (*missed, *topics.values())
        # Who lacks nothing and serves something waits to be asked.
        return lacking or self._uncalled()

    def _uncalled(self) -> tuple[Missed, ...]:
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        return (*graph.services.uncalled(), *actions.uncalled())

    def _missed_now(self) -> tuple[Missed, ...]:
        graph, actions = self.runtime.graph, self.runtime.client(Actions)
        given: dict[NeedKind, Callable[[Missed], bool]] = {
            "service": lambda missed: self._is_served(missed.need),
            "action": lambda missed: (
                actions.server(missed.need.name, missed.need.type_name) is not None
            ),
            "parameter": lambda missed: graph.parameters.has(missed.need.name),
        }
        return tuple(
            missed
            for missed in self.runtime.scheduler.needs.missed
            if not (missed.need.kind in given and given[missed.need.kind](missed))
        )


def _plain(name: str) -> str:
    return name.strip("~/").replace(".", "/")


def _typed(missed: Missed) -> Missed:
    """Return a service that was waited for by its name with the type that the source shows."""
    need = missed.need
    if need.kind != "service" or need.type_name:
        return missed
    return replace(missed, need=replace(need, type_name=service_type(need.name, missed.location)))
