"""What a check does not let pass: the findings, by kind and place."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal, NamedTuple

from tracerisk.common.text.plain_data import picked
from tracerisk.common.verdict import Verdict
from tracerisk.errors import ExitCode, Location

FindingKind = Literal[
    "stale",
    "edited",
    "undecided",
    "missing",
    "orphaned",
    "over_threshold",
    "unjustified",
    "unequal",
    "moved",
    "unknown",
    "gone",
    "unsolvable",
    "contact",
    "faulted",
    "stuck",
    "partial",
    "coverage",
    "world",
    "untracked",
]
"""Why blocks are not to be trusted: what they depend on has changed; a user changed a value
that is the tool's; it is unknown who changed one; a block is gone; its function is gone or
renamed; a mission's failure probability is above `max_failure_probability`; a value is set by
hand without a reason; a redundancy is set by hand over units that differed in the last run; a
value is set by hand for what its function does no more, or not alone; the
lock knows nothing; the lock knows a controller that is gone or renamed; the blocks make no model
that has a solution; in the last run something touched that should not, and `fail_on` says that
this is to fail; the last run went wrong, did not come to an end, or rests on needs that nothing
met or on assumptions that nobody accepted; of the functions that can command hardware too few
ran; it was not repeated in a world that `require_worlds` names, or depends on one; git tracks
the blocks, and not the lock or an input of their run."""


class CheckFinding(NamedTuple):
    """One thing that `check` does not let pass, with its place."""

    kind: FindingKind
    """The kind of the finding, such as `stale` or `edited`."""
    message: str
    """What is wrong, without its place and without the remedy."""
    location: Location
    """The file and line."""
    subject: str = ""
    """The dotted path of the part that it is about, such as `place.gripper.probability` or
    `place`; empty for the whole controller."""
    remedy: str = ""
    """What to do about it, with the command; empty until `with_remedy` sets that of its kind."""

    @property
    def text(self) -> str:
        """What is wrong, and what to do about it."""
        return f"{self.message}; {self.remedy}" if self.remedy else self.message

    @property
    def exit_code(self) -> ExitCode:
        """What the finding makes of the command's exit code."""
        is_edit = self.kind in ("edited", "undecided")
        return ExitCode.EDIT_IN_THE_WAY if is_edit else ExitCode.WOULD_CHANGE

    def __str__(self) -> str:
        return f"{self.location}: {self.kind.replace('_', ' ')}: {self.text}"


class Checked(NamedTuple):
    """A controller with its findings."""

    path: Path
    """The path of the controller."""
    findings: tuple[CheckFinding, ...]
    """All findings, sorted by place; empty where the blocks may be trusted."""
    verdict: Verdict | None = None
    """The verdict of the last run; `None` where the lock keeps none."""
    notes: tuple[str, ...] = ()
    """What else the figure rests on that no finding says: values by hand, options of one run."""


def finding_data(finding: CheckFinding) -> dict[str, Any]:
    """Return what the JSON of a verb holds of a finding."""
    return picked(finding, "kind", "message", "remedy") | picked(finding.location, "file", "line")
