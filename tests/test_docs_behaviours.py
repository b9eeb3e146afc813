"""The list of behaviours: each row has a distribution, a source and a test that exists."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "behaviours.md"
DISTRIBUTIONS = {"noetic", "humble", "jazzy", "all"}
ROWS = [
    [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
    for line in PAGE.read_text(encoding="utf-8").splitlines()
    if line.startswith("|") and not re.match(r"\|(---| what )", line)
]


@pytest.mark.parametrize("row", ROWS, ids=[row[0][:60] for row in ROWS])
def test_a_behaviour_has_a_distribution_a_source_and_a_test_that_exists(row):
    _, distributions, source, tests = row
    assert set(re.split(r", *", distributions)) <= DISTRIBUTIONS
    assert re.search(r"`[\w.-]+/[\w.-]+ [\w./-]+`", source), "`owner/repository path/of/the/file`"
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)[^`]*`", tests)
    assert named
    for path, name in named:
        assert re.search(
            rf"^ *(async )?def {name}\(", (ROOT / path).read_text(encoding="utf-8"), re.MULTILINE
        )
