"""The verdict of a run: how far it can be taken for the mission, and why no further."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal, get_args

from tracerisk.common.function_ref import FunctionRef
from tracerisk.errors import Location, with_file, with_line

VerdictKind = Literal["complete", "partial", "faulted", "stuck"]
"""How far the run can be taken for the mission, from best to worst; docs/verdict.md."""
VERDICTS: tuple[VerdictKind, ...] = get_args(VerdictKind)

BAD: frozenset[VerdictKind] = frozenset({"faulted", "stuck"})
"""The verdicts of runs that went wrong."""

NEVER_RAN = "never-ran"
"""The code of a function that can command hardware and did not run."""
MISSED_CALL = "missed-call"
"""The code of a call that was executed and led to no command, although it did elsewhere."""
NEVER_CALLED = "never-called"
"""The code of a call that was not executed, in a function that ran; elsewhere it commanded."""
MISSION_MISSED = "mission-missed"
"""The code of a condition of `success` that a run did not meet."""
INPUT_ASSUMED = "input-assumed"
"""The code of what was taken for granted of an input, such as an unconfirmed condition."""
UNUSED_INPUT = "unused-input"
"""The code of an entry of the scenario of which nobody made use."""
GAPS = frozenset({NEVER_RAN, NEVER_CALLED, MISSED_CALL, UNUSED_INPUT})
"""The codes of what a run left out, which `check` counts against the base alone."""


@dataclass(frozen=True, slots=True)
class Uncovered:
    """A function that can reach a motion command and never ran: no risk data, not no risk."""

    ref: FunctionRef
    """The file and qualified name of the function."""
    line: int
    """The line of its definition."""
    is_spare: bool = False
    """Whether only `except` clauses lead to it, for exceptions that did not occur."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """How many of the functions that can command hardware ran."""

    ran: int
    """The number of functions that can command hardware and ran."""
    all: int
    """The number of functions that can command hardware."""
    never_ran: tuple[Uncovered, ...] = ()
    """Those that did not run, with the line of each."""

    @property
    def never_ran_words(self) -> str:
        """The first of those that did not run, in words; empty where all ran."""
        if not self.never_ran:
            return ""
        first = self.never_ran[0]
        more = len(self.never_ran) - 1
        others = f" and {more} more function{'' if more == 1 else 's'}" if more else ""
        place = f"{first.ref.name} ({first.ref.file}:{first.line})"
        return f"{place}{others} can command hardware and never ran"


@dataclass(frozen=True, slots=True)
class Acceptance:
    """A reason that the user accepts."""

    code: str
    """The code of the reason, such as `never-ran`."""
    function: str
    """The qualified name of the function; empty for any."""
    object: str
    """The object of the reason, such as a topic; empty for none."""
    words: str
    """Why the user accepts it."""

    @property
    def key(self) -> tuple[str, str, str]:
        """What it accepts, whatever the words."""
        return self.code, self.function, self.object

    def __str__(self) -> str:
        of = f" of '{self.object}'" if self.object else ""
        where = f" in {self.function}" if self.function else ""
        return f"{self.code}{of}{where}: {self.words}"


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a run is not complete."""

    code: str
    """What kind of reason it is: docs/verdict.md lists all."""
    verdict: VerdictKind
    """What it makes of the run where it is not accepted."""
    words: str
    """What happened, without place and time."""
    function: str = ""
    """The qualified name of the function in which it happened; empty where none is known."""
    object: str = ""
    """The frame, service, joint, gripper or other thing; empty where there is none."""
    time_s: float | None = None
    """When it happened, in simulated time [s]."""
    location: Location | None = None
    """The file, from the controller's root, and the line."""
    accepted: str = ""
    """The words with which the user accepts it; empty where nobody does."""
    by: Location | None = None
    """The file and the line that brought it about, where that is another: what replaced it."""
    called_from: Location | None = None
    """The file and the line that called the function; `None` where none did or none is known."""

    @property
    def key(self) -> tuple[str, str, str]:
        """What an acceptance must name: code, function and object."""
        return self.code, self.function, self.object

    @property
    def accept_entry(self) -> str:
        """The entry of `accept` in the settings that accepts it, but for the words."""
        given = {"code": self.code, "function": self.function, "object": self.object}
        # A JSON string is a basic string of TOML.
        parts = [
            f"{key} = {json.dumps(text, ensure_ascii=False)}" for key, text in given.items() if text
        ]
        return f'{{{", ".join(parts)}, words = "WHY"}}'

    @property
    def message(self) -> str:
        """What happened and what brought it about, without place and time."""
        if self.by is None:
            return self.words
        is_here = self.location is not None and self.location.file == self.by.file
        return f"{self.words}, by line {self.by.line}" + ("" if is_here else f" of {self.by.file}")

    @property
    def message_with_caller(self) -> str:
        """The message with the line that called the function, if one did, beside a place."""
        caller = self.called_from
        return self.message + (f" ({_called(caller, self.location)})" if caller else "")

    def __str__(self) -> str:
        place = self.location
        where = [] if place is None else [str(Location(place.file, place.line))]
        where += [f"in {self.function}"] if self.function else []
        where += [] if self.called_from is None else [_called(self.called_from, place)]
        where += [f"at {self.time_s:.1f} s"] if self.time_s is not None else []
        return self.message + (f" ({', '.join(where)})" if where else "")


def _called(place: Location, of: Location | None) -> str:
    is_here = of is not None and of.file == place.file
    return f"called from line {place.line}" + ("" if is_here else f" of {place.file}")


@dataclass(frozen=True, slots=True)
class Verdict:
    """How far a run can be taken for the mission."""

    kind: VerdictKind
    """`complete`, `partial`, `faulted` or `stuck`."""
    reasons: tuple[Reason, ...] = ()
    """Every reason, the worst first, then by time; accepted ones last."""
    coverage: Coverage = Coverage(0, 0)
    """How many of the functions that can command hardware ran."""
    acceptances: tuple[Acceptance, ...] = ()
    """What the settings and the scenario of the run accept."""

    @property
    def open_reasons(self) -> tuple[Reason, ...]:
        """The reasons that are not accepted."""
        return tuple(reason for reason in self.reasons if not reason.accepted)

    @property
    def is_bad(self) -> bool:
        """Whether the run went wrong, so that its figure passes no limit."""
        return self.kind in BAD

    @property
    def deciding_reasons(self) -> tuple[Reason, ...]:
        """The open reasons of this very verdict, without functions that never ran.

        The coverage counts those.
        """
        return tuple(
            reason
            for reason in self.open_reasons
            if reason.verdict == self.kind and reason.code != NEVER_RAN
        )

    def with_lines(self, line_of: Callable[[str, int], int]) -> Verdict:
        """Return the verdict with other lines; `line_of` takes a file and a line of it."""
        never = (replace(u, line=line_of(u.ref.file, u.line)) for u in self.coverage.never_ran)
        return replace(
            self,
            reasons=tuple(
                replace(
                    reason,
                    location=with_line(reason.location, line_of),
                    by=with_line(reason.by, line_of),
                    called_from=with_line(reason.called_from, line_of),
                )
                for reason in self.reasons
            ),
            coverage=replace(self.coverage, never_ran=tuple(never)),
        )

    def with_files(self, file_of: Callable[[str], str]) -> Verdict:
        """Return the verdict with other names of files; `file_of` takes a file."""
        never = (
            replace(uncovered, ref=uncovered.ref.with_file(file_of))
            for uncovered in self.coverage.never_ran
        )
        return replace(
            self,
            reasons=tuple(
                replace(
                    reason,
                    location=with_file(reason.location, file_of),
                    by=with_file(reason.by, file_of),
                    called_from=with_file(reason.called_from, file_of),
                )
                for reason in self.reasons
            ),
            coverage=replace(self.coverage, never_ran=tuple(never)),
        )

    @property
    def unused_acceptances(self) -> tuple[Acceptance, ...]:
        """The acceptances of which nothing occurred."""
        occurred = {reason.key for reason in self.reasons}
        return tuple(
            acceptance for acceptance in self.acceptances if acceptance.key not in occurred
        )

    def __str__(self) -> str:
        """Return the verdict as one line: `partial: ...; 4 of 6 functions with commands ran`."""
        return verdict_line(self)


UNKNOWN_VERDICT = "verdict unknown"
"""The line of a run of which no verdict is kept."""


def kind_of(verdict: Verdict | None) -> str:
    """Return how far a run can be taken, in a word; `None` is an unknown verdict."""
    return UNKNOWN_VERDICT if verdict is None else verdict.kind


def verdict_line(verdict: Verdict | None, *, others_follow: bool = False) -> str:
    """Return a verdict in one line, its coverage included; `None` is an unknown one.

    Where the other reasons follow on lines of their own, their number is left out.
    """
    if verdict is None:
        return UNKNOWN_VERDICT
    ran, number = verdict.coverage.ran, verdict.coverage.all
    covered = f"{ran} of {number} function{'' if number == 1 else 's'} with commands ran"
    reported = verdict.deciding_reasons
    if not reported:
        return f"{verdict.kind}, {covered}"
    more = f" (and {len(reported) - 1} more)" if len(reported) > 1 and not others_follow else ""
    return f"{verdict.kind}: {reported[0]}{more}; {covered}"
