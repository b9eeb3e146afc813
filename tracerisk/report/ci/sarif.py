"""What a review should see, as SARIF 2.1.0 for code scanning.

Source of the format: OASIS, "Static Analysis Results Interchange Format (SARIF) Version 2.1.0".
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal
from urllib.parse import quote

from tracerisk.common.text.printable import printable, printable_json
from tracerisk.errors import Location

SCHEMA = (
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
)
ROOT = "SRCROOT"
"""What the files of the results are relative to: the root of the repository."""

Level = Literal["error", "warning", "note"]


@dataclass(frozen=True, slots=True)
class Rule:
    """A kind of alert."""

    id: str
    """Identifier in the log, such as `stale-block`."""
    level: Level
    """Severity in SARIF."""
    says: str
    """What an alert of the kind means, one sentence."""
    help: str
    """Why it matters and what to do."""

    @property
    def name(self) -> str:
        """The id as SARIF has names: `StaleBlock`."""
        return "".join(word.capitalize() for word in self.id.split("-"))


RULES: tuple[Rule, ...] = (
    Rule(
        "stale-block",
        "warning",
        "The risk blocks are older than what they depend on.",
        "The controller, its robot, scene, settings or hardware data changed after the blocks "
        "were written, so their figures are those of another program. Run `tracerisk "
        "refresh FILE`.",
    ),
    Rule(
        "faulted-run",
        "error",
        "The run behind the risk blocks went wrong.",
        "A run that went wrong is shorter and moves less, so its figure is not that of the "
        "mission. Mend the cause, or accept the reason in [tool.tracerisk] with words.",
    ),
    Rule(
        "partial-run",
        "warning",
        "The run behind the risk blocks is not the whole mission.",
        "Something that the controller asked for was not there, or was assumed. Give it in a "
        "scenario, name the robot, or accept the reason in [tool.tracerisk] with words.",
    ),
    Rule(
        "world-dependence",
        "warning",
        "What the run brings about depends on luck.",
        "In a world that a real cell may be, with other delays, another order of joints or another "
        "start, the run ends otherwise. `tracerisk docs worlds` says what to do for each world.",
    ),
    Rule(
        "edited-block",
        "error",
        "A value that tracerisk computes was changed by hand.",
        "Write `:=` and a reason behind `!` to keep the value, or run `tracerisk refresh "
        "FILE --discard-edits`.",
    ),
    Rule(
        "undecided-block",
        "error",
        "It is unknown who wrote a value: a user, or tracerisk on another branch.",
        "Run `tracerisk refresh FILE --discard-edits` to overwrite it with the computed value, or "
        "take the whole block from a version that you trust.",
    ),
    Rule(
        "missing-block",
        "error",
        "A risk block is gone, or stands in a function of another name.",
        "The model is built from the blocks alone: without this one the function's failures are "
        "left out. Run `tracerisk refresh FILE`.",
    ),
    Rule(
        "unknown-blocks",
        "warning",
        "The lock file knows nothing of a controller's blocks, or git lacks what they rest on.",
        "It is unknown whether the blocks fit the controller. Run `tracerisk run FILE` and commit "
        "tracerisk.lock with the source.",
    ),
    Rule(
        "unreadable",
        "error",
        "A source, a block or the lock file cannot be read.",
        "Nothing can be said of the controller's risk until it is mended.",
    ),
    Rule(
        "over-threshold",
        "error",
        "The mission fails more often than is allowed.",
        "The failure probability of the mission is above `max_failure_probability`. The table of "
        "`tracerisk solve FILE` lists the components that it comes from.",
    ),
    Rule(
        "single-point-of-failure",
        "note",
        "A component fails the mission alone.",
        "One failed unit is a failed mission: nothing takes over. State redundancy in the "
        "hardware description if there is any; what is new in a change deserves a look.",
    ),
    Rule(
        "changed-outcome",
        "warning",
        "The mission brings about something else.",
        "Objects, rests, grips or uses of the cell differ from those of the earlier run. Check "
        "that the change of the mission is meant; figures of different missions cannot be "
        "compared.",
    ),
    Rule(
        "lost-check",
        "warning",
        "The controller no longer looks at an answer.",
        "An answer of a service, an action or a driver decided something and does not any more: a "
        "failure that it reports may go unnoticed. Put the check back, or say why it is not "
        "needed.",
    ),
    Rule(
        "lost-redundancy",
        "warning",
        "A component lost its redundancy.",
        "Fewer units may fail than before. Check that the change of hardware data, or of the "
        "value set by hand, is meant.",
    ),
    Rule(
        "omitted-component",
        "warning",
        "A component was left out of the risk by hand.",
        "Its failures count no more in this function. Check the reason behind `:= omit`.",
    ),
    Rule(
        "unjustified-pin",
        "warning",
        "A value is set by hand without a reason.",
        "Write why behind `!`: who decided, and on what ground. The next engineer cannot check "
        "the figure otherwise.",
    ),
    Rule(
        "unequal-units",
        "error",
        "A redundancy is set by hand over units that differ.",
        "A block holds one probability for all units, computed for the redundancy that the "
        "hardware description states. State the redundancy there, or set the probability by "
        "hand as well.",
    ),
    Rule(
        "moved-use",
        "warning",
        "A value is set by hand for what its function does no more, or not alone.",
        "The function was split, merged or changed since the value was written, so that a use "
        "may count twice or not at all. Move the value, or write what holds now with a reason.",
    ),
    Rule(
        "unexpected-contact",
        "error",
        "The arm, or what it holds, touched something that it should not.",
        "On the twin two bodies touched that are not to. Watch the moment in the report's "
        "replay; mend the motion, the scene or the planning scene.",
    ),
    Rule(
        "uncovered-motion",
        "note",
        "A function can move the arm and never ran: no risk data.",
        "Its risk is unknown, which is not none. Run the branch with a scenario or arguments, or "
        "give the function a block by hand (`@Function := {`).",
    ),
    Rule(
        "undetected-failure",
        "note",
        "Failures end the mission, and the controller does not notice them here.",
        "On the twin, parts that failed ended the mission undetected, and a check at this place "
        "would have shown it: the answer of a call, the width of the gripper, a limit of the time "
        "to wait. `tracerisk evidence FILE --show` lists the failures.",
    ),
    Rule(
        "run-finding",
        "warning",
        "The run on the twin showed something that a user should know.",
        "The message says what; `tracerisk trace FILE` shows the run again.",
    ),
)

_RULES = {rule.id: index for index, rule in enumerate(RULES)}


@dataclass(frozen=True, slots=True)
class Alert:
    """One alert at a place of a source.

    Rule, file, function, component and subject identify the alert when lines have shifted.
    """

    rule: str
    """Id of one of `RULES`."""
    message: str
    """What was found."""
    file: str
    """Path from the root of the repository, with `/`."""
    line: int | None = None
    """Line of the place, from 1; `None` for the whole file."""
    column: int | None = None
    """Column of the place, from 1; `None` for the whole line."""
    function: str = ""
    """Qualified name of the function concerned; "" for none."""
    component: str = ""
    """Name of the component concerned; "" for none."""
    subject: str = ""
    """Distinguishes alerts of one rule, function and component, such as the field of a block;
    "" for none."""

    @property
    def fingerprint(self) -> str:
        """What identifies the alert from one version to the next; no line is part of it."""
        parts = (self.rule, self.file, self.function, self.component, self.subject)
        return hashlib.sha256("\0".join(parts).encode(errors="surrogatepass")).hexdigest()[:32]


def alert_at(rule: str, message: str, location: Location, file: str, **names: str) -> Alert:
    """Return the alert at a location, whose file is called `file` from the root."""
    return Alert(rule, message, file, location.line, location.column, **names)


def render_sarif(alerts: Sequence[Alert], *, version: str) -> str:
    """Return the alerts as a SARIF log of one run, sorted by place; `version` is the tool's."""
    log = {
        "$schema": SCHEMA,
        "version": "2.1.0",
        "runs": [
            {
                "tool": {
                    "driver": {
                        "name": "tracerisk",
                        "version": version,
                        "rules": [_rule(rule) for rule in RULES],
                    }
                },
                "columnKind": "unicodeCodePoints",
                "originalUriBaseIds": {
                    ROOT: {"description": {"text": "The root of the repository."}}
                },
                "results": [_result(alert) for alert in ordered(alerts)],
            }
        ],
    }
    return printable_json(json.dumps(log, indent=1, ensure_ascii=False, sort_keys=True)) + "\n"


def ordered(alerts: Sequence[Alert]) -> list[Alert]:
    """Return the alerts, each once, sorted by place."""
    return sorted(
        set(alerts),
        key=lambda item: (
            *(item.file, item.line or 0, _RULES[item.rule], item.fingerprint),
            *(item.column or 0, item.message, item.line is None, item.column is None),
        ),
    )


def level_of(alert: Alert) -> Level:
    """Return the severity of an alert, which is that of its rule."""
    return RULES[_RULES[alert.rule]].level


def _rule(rule: Rule) -> dict[str, Any]:
    return {
        "id": rule.id,
        "name": rule.name,
        "shortDescription": {"text": rule.says},
        "fullDescription": {"text": rule.help},
        "help": {"text": f"{rule.says} {rule.help}", "markdown": f"{rule.says}\n\n{rule.help}"},
        "defaultConfiguration": {"level": rule.level},
        "properties": {"tags": ["reliability", "risk"]},
    }


def _result(alert: Alert) -> dict[str, Any]:
    place: dict[str, Any] = {
        "artifactLocation": {
            "uri": quote(alert.file, safe="/", errors="surrogateescape"),
            "uriBaseId": ROOT,
        },
    }
    if alert.line is not None:
        place["region"] = {"startLine": alert.line}
        if alert.column is not None:
            place["region"]["startColumn"] = alert.column
    location: dict[str, Any] = {"physicalLocation": place}
    names = [
        {"fullyQualifiedName": name, "kind": kind}
        for name, kind in ((alert.function, "function"), (alert.component, "resource"))
        if name
    ]
    if names:
        location["logicalLocations"] = names
    index = _RULES[alert.rule]
    return {
        "ruleId": alert.rule,
        "ruleIndex": index,
        "level": RULES[index].level,
        "message": {"text": printable(alert.message)},
        "locations": [location],
        # GitHub knows alerts again by the first only, and computes it from the line if it lacks.
        "partialFingerprints": {
            "primaryLocationLineHash": f"{alert.fingerprint}:1",
            "tracerisk/v1": alert.fingerprint,
        },
    }
