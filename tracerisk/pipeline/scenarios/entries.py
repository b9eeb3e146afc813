"""What a scenario holds beside its base, and what a run with it came to."""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tracerisk.errors import TraceRiskError
from tracerisk.pipeline.run.ended_run import ControllerRun
from tracerisk.pipeline.scenarios.arguments.command_line import CommandLine
from tracerisk.ros.drafts.draft import Draft
from tracerisk.ros.drafts.pictures.drafted_pictures import PICTURES
from tracerisk.ros.drafts.shifted_poses import PlaceAndShift
from tracerisk.ros.scenario.file.lines import entry_lines, word_lines
from tracerisk.ros.scenario.scenario import Scenario
from tracerisk.trace import Trace

_ABOVE_M = 0.02  # a thing that is set down comes from above [m]
_BEGINS_S = 1.0  # when messages that are repeated begin
_REPEATED_HZ = 1.0
_REPEATED_S = 60.0  # until when [s]
_STREAM_HZ = 10.0
_MOVED_M = 0.1  # how far a pose of a stream is from the one before [m]
_IN_TURN = 4  # poses of a stream before the last one stays
_STREAMED = re.compile(r"std_msgs/Float|geometry_msgs/(Twist|Vector3|Wrench)")
_OF_COMMANDS = re.compile(r"std_msgs/|sensor_msgs/Joy|trajectory_msgs/")
_QUATERNION = frozenset("xyzw")

EntryKey = tuple[str, str]
"""The section and the key of an entry."""


@dataclass(slots=True)
class Entries:
    """What a scenario holds beside its base."""

    drafts: dict[EntryKey, Draft] = field(default_factory=dict)
    """The drafted entries, by section and key."""
    repeats: dict[EntryKey, int] = field(default_factory=dict)
    """How often an answer is given, by section and key; 1 where left out."""
    arguments: CommandLine | None = None
    """The command line of the controller; `None` for no arguments."""

    def copy(self) -> Entries:
        """Return entries that can be changed apart from these."""
        return Entries(dict(self.drafts), dict(self.repeats), self.arguments)

    @property
    def sections(self) -> Mapping[str, list[str]]:
        """The lines of each section of the scenario."""
        sections: dict[str, list[str]] = {}
        if self.arguments is not None:
            sections["arguments"] = word_lines(self.arguments.words, self.arguments.remark)
        # What is asked again is asked after all else, as a menu does.
        for time in range(max(self.repeats.values(), default=1)):
            for key, draft in self.drafts.items():
                if time < self.repeats.get(key, 1):
                    sections.setdefault(draft.section, []).extend(entry_lines(draft))
        return sections


@dataclass(frozen=True, slots=True)
class Attempt:
    """A run with some entries."""

    entries: Entries
    """The entries of the scenario."""
    trace: Trace | None = None
    """The trace of the run; `None` where it could not run."""
    wanted: tuple[Draft, ...] = ()
    """What a scenario could provide for what the run lacked."""
    error: TraceRiskError | None = None
    """What kept it from running; `None` where it ran."""
    shift: PlaceAndShift | None = None
    """A place that was not reached, and by how much to move it; `None` for none."""

    @property
    def is_traced(self) -> bool:
        """Whether the run shows risk."""
        return self.trace is not None and self.trace.is_usable and bool(self.trace.functions)

    @property
    def has_raised(self) -> bool:
        """Whether the run ended with an exception."""
        return self.trace is not None and self.trace.end.cause == "raised"

    @property
    def is_faulted(self) -> bool:
        """Whether the run shows risk, and that something went wrong."""
        verdict = None if self.trace is None else self.trace.verdict
        return self.is_traced and verdict is not None and verdict.kind == "faulted"

    @property
    def score(self) -> tuple[bool, bool, int]:
        """Rank runs: one that shows risk, one that did not go wrong, one that shows most."""
        trace = self.trace
        if trace is None or not self.is_traced:
            return False, False, 0
        is_well = trace.verdict is not None and trace.verdict.kind != "faulted"
        return True, is_well, len(trace.functions)

    @property
    def raised(self) -> tuple[Hashable, ...]:
        """The exception that ended the run, if one did."""
        if self.trace is None or not self.has_raised:
            return ()
        return ((self.trace.end.message, self.trace.end.location),)

    @property
    def shown(self) -> Hashable:
        """What the run showed: how it ended, what it lacked still, what went wrong."""
        trace = self.trace
        if trace is None:
            return None if self.error is None else self.error.message
        reasons = () if trace.verdict is None else trace.verdict.reasons
        lacking = {(draft.section, draft.key) for draft in self.wanted} - self.entries.drafts.keys()
        return (
            (trace.end.cause, trace.end.location, self.score, frozenset(lacking)),
            frozenset((e.code, e.function, e.object) for e in reasons if e.code != "input-assumed"),
        )


@dataclass(frozen=True, slots=True)
class ScenarioDraft:
    """A scenario that a controller runs with, as far as one was found."""

    text: str
    """The scenario file."""
    given: tuple[Draft, ...]
    """The new entries."""
    missing: tuple[Draft, ...]
    """The needs that no scenario can provide."""
    cut: str = ""
    """What ended the search before its time, in words; empty where nothing did."""
    arguments: CommandLine | None = None
    """The command line of the controller; `None` for no arguments."""
    trace: Trace | None = None
    """The trace of the run with the scenario; `None` where it could not run."""
    error: TraceRiskError | None = None
    """What kept it from running; `None` where it ran."""


def is_given(known: Scenario, draft: Draft) -> bool:
    """Return whether a scenario gives it already, though nobody has made use of it yet."""
    names: Mapping[str, Iterable[str]] = {
        "publish": (published.topic for published in known.published),
        "services": (service.name for service in known.services),
        "actions": (action.name for action in known.actions),
        "frames": (frame.frame for frame in known.frames),
        "start": (draft.need.name,) if known.start else (),
        "mount": (draft.need.name,) if known.mount else (),
        "drivers": (driver.string("driver") for driver in known.drivers),
        "objects": (held.string("name") for held in known.objects),
        "calls": (
            str(call.get(key))
            for call in known.calls
            for key in ("service", "action")
            if key in call
        ),
    }
    return draft.need.name.strip("/") in {name.strip("/") for name in names.get(draft.section, ())}


def merged(fields: Any, over: Any) -> Any:
    """Return fields with others put over them, down into nested ones."""
    if not isinstance(fields, dict) or not isinstance(over, dict):
        return over
    if fields.keys() == _QUATERNION:
        # One that is given in part is no mixture of two turns.
        return {**dict.fromkeys(fields, 0.0), **over}
    more = {key: merged(fields.get(key), item) for key, item in over.items()}
    return {**fields, **more}


def useful_drafts(drafts: tuple[Draft, ...], runs: Sequence[ControllerRun]) -> tuple[Draft, ...]:
    """Return drafts without pictures for nodes beside the controller: nothing is to be found there.

    Where that leaves none, they are those of a run without such nodes.
    """
    alone = next((run.drafts for run in runs if not is_accompanied(run)), drafts)
    own = {(draft.section, draft.key) for draft in alone}
    kept = (e for e in drafts if e.need.type_name not in PICTURES or (e.section, e.key) in own)
    return tuple(kept) or alone


def is_accompanied(run: ControllerRun) -> bool:
    """Return whether nodes of the workspace were started beside the controller."""
    return _has_companions(run.trace)


def is_beside(attempt: Attempt) -> bool:
    """Return whether a run showed risk with nodes of the workspace beside the controller."""
    return attempt.trace is not None and attempt.is_traced and _has_companions(attempt.trace)


def _has_companions(trace: Trace) -> bool:
    return any(line.startswith("started beside:") for line in trace.assumptions)


def names_own_joints(draft: Draft, written: Mapping[str, Any]) -> bool:
    """Return whether written joint states are of the robot's joints, which the draft names."""
    if draft.need.type_name != "sensor_msgs/JointState":
        return True
    return {*written.get("name", ())} <= {*draft.value["message"]["name"]}


def without_repeats(entries: Entries) -> Entries:
    """Return entries that call each service and action once, with the first value alone.

    Of the objects that are held, and of the others, the first stay: those of the first values.
    Models of Gazebo stay, too, for one call may need them beside an object of the planning scene.
    """
    fewer = entries.copy()
    repeats = [key for key in entries.drafts if key[0] == "calls" and key[1].endswith("]")]
    objects = [
        (key, draft)
        for key, draft in entries.drafts.items()
        if key[0] == "objects" and draft.need.type_name != "model"
    ]
    for is_held in (True, False):
        alike = [key for key, item in objects if ("attached" in item.value) is is_held]
        repeats += alike[1:] if repeats else []
    for key in repeats:
        del fewer.drafts[key]
    return fewer


def set_down_above(entries: Entries) -> Entries | None:
    """Return entries whose later calls have their poses a little higher; None where none has any.

    What is taken at a pose, and set down at the same one, touches what it lay on.
    """
    above = entries.copy()
    seen: list[tuple[str, Any]] = []
    is_new = False
    for key, draft in entries.drafts.items():
        if key[0] != "calls":
            continue
        content = "goal" if draft.need.kind == "goal" else "request"
        sent = draft.need.type_name, draft.value[content]
        if sent in seen and (raised := _raised(sent[1])) != sent[1]:
            words = f"{draft.words}; {_ABOVE_M:g} m above the one before"
            value = {**draft.value, content: raised}
            above.drafts[key] = replace(draft, value=value, words=words)
            is_new = True
        seen.append(sent)
    return above if is_new else None


def without_one(entries: Entries) -> Iterator[tuple[EntryKey, Entries]]:
    """Yield each message with the entries that lack it: a program may do better without."""
    published = [key for key in entries.drafts if key[0] == "publish"]
    for key in published if len(entries.drafts) > 1 else ():
        fewer = entries.copy()
        del fewer.drafts[key]
        yield key, fewer


def answered_alone(entries: Entries) -> Entries | None:
    """Return entries whose drafted drivers only answer; None where none is a driver.

    A driver that hears a topic, and answers nobody, is left out.
    """
    answered = entries.copy()
    for key, draft in entries.drafts.items():
        if draft.is_driver and (draft.plain is not None or draft.need.kind == "command"):
            del answered.drafts[key]
            plain = draft.without_motion
            if plain is not None:
                answered.drafts[plain.section, plain.key] = plain
    return None if answered.drafts.keys() == entries.drafts.keys() else answered


def without_instead(entries: Entries) -> Entries:
    """Return entries without those that take the place of a default."""
    fewer = entries.copy()
    fewer.drafts = {key: draft for key, draft in fewer.drafts.items() if not draft.is_instead}
    return fewer


def repeated(entries: Entries) -> Entries | None:
    """Return entries whose messages come once a second; None where none comes but once.

    What a program overwrites, or hears before it is ready, an estimator publishes again. Commands
    come once: each would be obeyed anew.
    """
    again = entries.copy()
    for key, draft in entries.drafts.items():
        is_once = key[0] == "publish" and "after" in draft.value and "message" in draft.value
        if is_once and not _OF_COMMANDS.match(draft.need.type_name):
            value = {name: item for name, item in draft.value.items() if name != "after"}
            value = {**value, "at": _BEGINS_S, "rate": _REPEATED_HZ, "until": _REPEATED_S}
            again.drafts[key] = replace(draft, value=value, words=f"{draft.words}; once a second")
    return None if again.drafts == entries.drafts else again


def as_streams(entries: Entries) -> Entries | None:
    """Return entries whose messages are a live stream; None where none can be one.

    Numbers and speeds come ten times a second, for a program forgets what is old; poses once a
    second and each other than the one before, for a program may follow what changes alone.
    """
    streamed = entries.copy()
    for key, draft in entries.drafts.items():
        message = draft.value.get("message") if key[0] == "publish" else None
        if not isinstance(message, dict):
            continue
        value = {name: item for name, item in draft.value.items() if name != "after"}
        words = draft.words.partition("; once a second")[0]
        moved = _raised(message, _MOVED_M)
        if moved != message:
            del value["message"]
            in_turn = [message, moved] * (_IN_TURN // 2)
            value |= {"messages": in_turn, "rate": _REPEATED_HZ}
            words += "; moved a little once a second"
        elif _STREAMED.match(draft.need.type_name) and "rate" not in value:
            value["rate"] = _STREAM_HZ
            words += f"; {_STREAM_HZ:g} times a second"
        else:
            continue
        value |= {"at": _BEGINS_S, "until": _REPEATED_S}
        streamed.drafts[key] = replace(draft, value=value, words=words)
    return None if streamed.drafts == entries.drafts else streamed


def _raised(value: Any, metres: float = _ABOVE_M) -> Any:
    """Return a message with the position of each pose in it higher."""
    if isinstance(value, list):
        return [_raised(item, metres) for item in value]
    if not isinstance(value, dict):
        return value
    made = {key: _raised(item, metres) for key, item in value.items()}
    place = made.get("position")
    if isinstance(place, dict) and "orientation" in made and "z" in place:
        made["position"] = {**place, "z": round(place["z"] + metres, 3)}
    return made


def one_by_one(best: Entries, tried: Entries) -> list[Entries]:
    """Return each of what was tried beyond the best, alone."""
    more = [key for key in tried.drafts if key not in best.drafts]
    if len(more) < 2:
        return []
    return [Entries({key: tried.drafts[key]}) for key in more]


def on_top(best: Entries, single: Entries) -> Entries:
    """Return the best entries with one of those that were tried beyond them."""
    entries = best.copy()
    entries.drafts.update(single.drafts)
    return entries
