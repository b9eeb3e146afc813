"""What GitLab reads: code quality and metrics, in the forms that its documentation states."""

import json
import re

from hypothesis import given

from tests.report.ci.test_sarif import alerts
from tracerisk.common.evidence.cells import Evidence
from tracerisk.errors import Location
from tracerisk.report.ci.code_quality import render_code_quality
from tracerisk.report.ci.open_metrics import (
    Sample,
    evidence_metrics,
    render_open_metrics,
    review_metrics,
)
from tracerisk.report.ci.sarif import alert_at


def test_an_alert_has_what_code_quality_takes():
    alert = alert_at(
        "lost-redundancy", "power lost", Location("x.py", 7), "cell/x.py", function="f"
    )
    (entry,) = json.loads(render_code_quality([alert, alert]))
    assert entry == {
        "description": "power lost",
        "check_name": "lost-redundancy",
        "fingerprint": alert.fingerprint,
        "severity": "minor",
        "location": {"path": "cell/x.py", "lines": {"begin": 7}},
    }


@given(alerts, alerts)
def test_no_two_entries_have_one_fingerprint(one, other):
    found = json.loads(render_code_quality([one, other]))
    assert len({entry["fingerprint"] for entry in found}) == len(found) == len({one, other})
    assert all(entry["location"]["lines"]["begin"] >= 1 for entry in found)


def test_metrics_are_lines_of_name_labels_and_value():
    name = 'a "b"\\\n.py'
    text = render_open_metrics(
        [
            Sample("tracerisk_run", name, 1, (("verdict", "complete"),)),
            Sample("tracerisk_mission_failure_probability", "b.py", 1.2345678e-07),
        ]
    )
    assert text.splitlines() == [
        "# TYPE tracerisk_mission_failure_probability gauge",
        "# HELP tracerisk_mission_failure_probability Probability that the mission fails by "
        "hardware.",
        'tracerisk_mission_failure_probability{controller="b.py"} 1.23457e-07',
        "# TYPE tracerisk_run gauge",
        "# HELP tracerisk_run 1 for the verdict of the run behind the blocks.",
        'tracerisk_run{controller="a \\"b\\"\\\\\\n.py",verdict="complete"} 1',
        "# EOF",
    ]


def test_of_no_drawn_failure_no_part_is_undetected():
    assert list(evidence_metrics("a.py", Evidence("f", "panda", 0, 0, (), ()))) == []


def test_a_change_has_its_figures_before_and_after(difference, review_of):
    before, after = ({"reach": ("done 1", f"motor = {p}")} for p in ("1e-7", "3e-7"))
    text = render_open_metrics(review_metrics(review_of(difference(before, after))))
    values = dict(re.findall(r"^tracerisk_(\w+)\{\S+ (\S+)$", text, re.MULTILINE))
    assert values == {
        "mission_failure_probability": "3e-07",
        "mission_failure_probability_before": "1e-07",
        "mission_failure_ratio": "3",
        "cycle_failure_probability": "3e-07",
    }
