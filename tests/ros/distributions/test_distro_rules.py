"""One table says what differs between the distributions of ROS; it is read, reported and shown."""

import re
from pathlib import Path

import pytest

from tracerisk.errors import Location
from tracerisk.ros.distributions.in_run import DistroRules, in_words
from tracerisk.ros.distributions.rules import RULE_OF, RULES

TEXT = (Path(__file__).parents[3] / "docs" / "ros.md").read_text(encoding="utf-8")
SECTION = TEXT.partition("## Distributions\n")[2].partition("\n## ")[0]
HERE = Location("arm.py", 7)


def test_docs_show_the_table_as_it_is():
    rows = re.findall(r"^\| `([\w-]+)` \|(.*)\|$", SECTION, re.MULTILINE)
    listed = {name: [cell.strip() for cell in cells.split(" | ")] for name, cells in rows}
    assert listed == {
        rule.name: [
            rule.subject,
            *(in_words(value) for value in (rule.noetic, rule.humble, rule.jazzy)),
            ", ".join(f"`{source}`" for source in rule.source.split(", ")),
        ]
        for rule in RULES
    }


def test_names_are_unique_and_every_source_is_a_repository_with_a_path():
    assert len(RULE_OF) == len(RULES)
    sources = [source for rule in RULES for source in rule.source.split(", ")]
    assert all(re.fullmatch(r"[\w.-]+/[\w.-]+ [\w./ -]+", source) for source in sources)


@pytest.mark.parametrize("name", ["noetic", "humble", "jazzy"])
def test_a_run_reads_the_value_of_its_distribution(name):
    rule = RULE_OF["call-with-timeout"]
    assert DistroRules(name).value("call-with-timeout") == getattr(rule, name)


def test_a_rule_that_decides_under_an_assumed_distribution_is_reported_once_a_place():
    reported = []
    rules = DistroRules("humble", lambda *found: reported.append(found))
    rules.decided("call-with-timeout", HERE)
    rules.decided("call-with-timeout", HERE)
    ((words, place, name),) = reported
    assert (place, name) == (HERE, "call-with-timeout")
    assert "no in ROS 2 Humble, which is assumed, and yes in ROS 2 Jazzy" in words


def test_a_rule_that_decides_under_a_known_distribution_is_not_reported():
    DistroRules("humble").decided("call-with-timeout", HERE)


def test_one_of_ros_1_is_served_and_none_of_its_rules_rests_on_an_assumption():
    reported = []
    DistroRules("noetic", lambda *found: reported.append(found)).decided("call-with-timeout")
    assert reported == []


def test_a_rule_that_the_table_does_not_have_is_an_error():
    with pytest.raises(KeyError, match="no-such-rule"):
        DistroRules().value("no-such-rule")
