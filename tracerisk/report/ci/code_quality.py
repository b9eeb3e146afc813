"""Alerts as a Code Quality report, which GitLab shows on a merge request.

Source of the format: GitLab Docs, "Code Quality", "Code Quality report format".
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

from tracerisk.common.text.printable import printable, printable_json
from tracerisk.report.ci.sarif import Alert, Level, level_of, ordered

SEVERITIES: Mapping[Level, str] = {"error": "major", "warning": "minor", "note": "info"}
"""What GitLab calls the levels of SARIF."""


def render_code_quality(alerts: Sequence[Alert]) -> str:
    """Return the alerts as a JSON list, sorted by place.

    GitLab knows an alert again by its fingerprint, in which no line counts; of several alerts with
    one fingerprint the later ones are numbered.
    """
    seen: dict[str, int] = {}
    entries = []
    for alert in ordered(alerts):
        number = seen[alert.fingerprint] = seen.get(alert.fingerprint, 0) + 1
        entries.append(
            {
                "description": printable(alert.message),
                "check_name": alert.rule,
                "fingerprint": alert.fingerprint + (f"-{number}" if number > 1 else ""),
                "severity": SEVERITIES[level_of(alert)],
                "location": {"path": alert.file, "lines": {"begin": alert.line or 1}},
            }
        )
    text = json.dumps(entries, indent=1, ensure_ascii=False, sort_keys=True)
    return printable_json(text) + "\n"
