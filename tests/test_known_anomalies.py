"""The known anomalies of docs/safety.md, each shown at work; a mended one must leave the list.

A test here fails as soon as its anomaly is mended: then delete both the test and the row.
"""

import re
from pathlib import Path

import pytest

from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.errors import HardwareError

PAGE = Path(__file__).parents[1] / "docs" / "safety.md"
ROWS = re.findall(
    r"^\| (K\d+) \| [^|]+ \| [^|]+ \| [^|]+ \| `tests/test_known_anomalies\.py::(test_\w+)` \|$",
    PAGE.read_text(encoding="utf-8"),
    re.MULTILINE,
)


def test_each_row_of_the_page_is_shown_here_and_each_test_here_has_a_row():
    text = Path(__file__).read_text(encoding="utf-8")
    here = re.findall(r"^def (test_\w+)\(", text, re.MULTILINE)[1:]
    assert [test for _, test in ROWS] == here
    assert [number for number, _ in ROWS] == [f"K{n}" for n in range(1, len(here) + 1)]


def test_a_rate_that_is_one_over_an_mtbf_is_refused(tmp_path):
    path = tmp_path / "cell.sysml"
    path.write_text("""\
package Cell {
    private import TraceriskHardware::*;
    private import SI::*;
    part arm { part motor {
        attribute mtbf : ISQ::DurationValue = 50000 [h];
        @FailureData { rate = 1 / mtbf; }
    } }
}
""")
    with pytest.raises(HardwareError, match="'/' has no finite value"):
        read_sysml(path)


def test_a_controller_can_lift_its_memory_limit(example, quick):
    lift = "hard = resource.getrlimit(kind)[1]; resource.setrlimit(kind, (hard, hard))"
    show = "print('limit is', resource.getrlimit(kind)[0])"
    source = quick("import resource", "kind = resource.RLIMIT_AS", lift, show)
    example.write("controller.py", source)
    outcome = example.run("run", "controller.py", "--check", "--memory-limit", "3000")
    (limit,) = re.findall(r"limit is (-?\d+)", outcome.out + outcome.err)
    assert not 0 < int(limit) <= 3000 * 2**20
