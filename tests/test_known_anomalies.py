"""The known anomalies of docs/safety.md, each shown at work; a mended one must leave the list.

A test here fails as soon as its anomaly is mended: then delete both the test and the row.
"""

import re
from pathlib import Path

import pytest

from tracerisk import api

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"
ROWS = re.findall(
    r"^\| (K\d+) (?:\| [^|]+ ){4}\| `tests/test_known_anomalies\.py::(test_\w+)` \|$",
    PAGE.read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_each_row_of_the_page_is_shown_here_and_each_test_here_has_a_row():
    text = Path(__file__).read_text(encoding="utf-8")
    here = re.findall(r"^def (test_\w+)\(", text, re.MULTILINE)[1:]
    assert [test for _, test in ROWS] == here
    assert [number for number, _ in ROWS] == [f"K{n}" for n in range(1, len(here) + 1)]


def test_a_loop_that_is_left_in_its_middle_is_read_as_random(annotated_source):
    source = annotated_source(
        reach=("place 3/4, done 1/4", "motor = 0.1"), place=("reach 3/3", "jaw = 0.1")
    )
    model = api.build({"cell.py": source.encode()}, name="cell")
    reported = api.solve(model).mission
    # Four visits and three visits, each of which fails with 0.1.
    assert reported.visits_as_run == pytest.approx(1 - 0.9**7, rel=1e-12)
    assert reported.failure_probability == pytest.approx(0.51967, abs=1e-5)


def test_a_file_that_is_only_looked_for_is_no_input(example, quick):
    example.write("c.py", quick("if os.path.exists('again'): arm.go(joints, wait=True)"))
    example.run("run", "c.py")
    example.write("again", "")
    assert example.run("check", "c.py").code == 0
