import json
import os
from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from tracerisk.errors import Location
from tracerisk.report.ci.sarif import RULES, Alert, alert_at, render_sarif

SCHEMA = os.environ.get("TRACERISK_SARIF_SCHEMA", "")
HOSTILE = 'a "b" </script> \\ <!-- é\u2028.py'

texts = st.text(max_size=30)
alerts = st.builds(
    Alert,
    st.sampled_from([rule.id for rule in RULES]),
    st.text(min_size=1, max_size=30),
    texts.filter(bool),
    st.none() | st.integers(1, 10**6),
    st.none() | st.integers(1, 200),
    texts,
    texts,
    texts,
)


def log_of(*found: Alert) -> dict:
    return json.loads(render_sarif(found, version="1.2.3"))


def results(*found: Alert) -> list[dict]:
    return log_of(*found)["runs"][0]["results"]


def test_an_alert_has_its_rule_place_names_and_message():
    alert = alert_at(
        "lost-redundancy",
        "power_system in place: redundancy true -> false",
        Location("place.py", 12, 5),
        "src/place.py",
        function="Node.place",
        component="power_system",
    )
    (result,) = results(alert)
    assert (result["ruleId"], result["level"]) == ("lost-redundancy", "warning")
    assert RULES[result["ruleIndex"]].id == "lost-redundancy"
    assert result["message"]["text"].startswith("power_system in place")
    (location,) = result["locations"]
    assert location["physicalLocation"] == {
        "artifactLocation": {"uri": "src/place.py", "uriBaseId": "SRCROOT"},
        "region": {"startLine": 12, "startColumn": 5},
    }
    assert [each["fullyQualifiedName"] for each in location["logicalLocations"]] == [
        "Node.place",
        "power_system",
    ]


def test_the_fingerprint_follows_names_and_never_the_line():
    alert = Alert("stale-block", "old", "a.py", 3, function="place", component="motor")
    assert (
        alert.fingerprint
        == Alert("stale-block", "new", "a.py", 90, 2, "place", "motor").fingerprint
    )
    others = [
        Alert("edited-block", "old", "a.py", 3, function="place", component="motor"),
        Alert("stale-block", "old", "b.py", 3, function="place", component="motor"),
        Alert("stale-block", "old", "a.py", 3, function="pick", component="motor"),
        Alert("stale-block", "old", "a.py", 3, function="place", component="gripper"),
        Alert("stale-block", "old", "a.py", 3, function="place", component="motor", subject="x"),
    ]
    assert alert.fingerprint not in {other.fingerprint for other in others}
    assert len({other.fingerprint for other in others}) == len(others)


@example([Alert("stale-block", "0", "0", 8, column, "f", "m") for column in (None, 1)])
@given(st.lists(alerts, max_size=6))
def test_the_order_of_what_is_found_changes_no_byte(found):
    text = render_sarif(found, version="1")
    assert text == render_sarif(found[::-1], version="1")
    assert len(json.loads(text)["runs"][0]["results"]) == len(set(found))


def test_names_of_files_are_uris_and_hostile_text_stays_text():
    (result,) = results(Alert("stale-block", HOSTILE, HOSTILE, 1, function=HOSTILE))
    assert result["message"]["text"] == HOSTILE.replace("\u2028", r"\u2028")
    uri = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == "a%20%22b%22%20%3C/script%3E%20%5C%20%3C%21--%20%C3%A9%E2%80%A8.py"


def test_every_rule_says_what_to_do():
    assert len({rule.id for rule in RULES}) == len(RULES)
    assert all(rule.says.endswith(".") and len(rule.help) > 40 for rule in RULES)


@pytest.mark.skipif(not Path(SCHEMA).is_file(), reason="TRACERISK_SARIF_SCHEMA names no schema")
@given(st.lists(alerts, max_size=4))
def test_the_log_is_valid_by_the_official_schema(found):
    import jsonschema

    schema = json.loads(Path(SCHEMA).read_text(encoding="utf-8"))
    checker = jsonschema.validators.validator_for(schema)(schema)
    checker.validate(json.loads(render_sarif(found, version="0.1.0")))
