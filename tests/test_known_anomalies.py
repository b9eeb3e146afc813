"""The known anomalies of docs/safety.md, each shown at work; a mended one must leave the list.

A test here fails as soon as its anomaly is mended: then delete both the test and the row.
"""

import re
from pathlib import Path

import pytest

from tracerisk import api
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml
from tracerisk.common.trace_log import read_log
from tracerisk.errors import LogError
from tracerisk.prm import FaultTree, HybridModel
from tracerisk.prm.other_models.formats.conversion import logic_of_functions
from tracerisk.prm.other_models.formats.openpra.writer import dumps_openpra

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


def test_an_inner_loop_at_the_head_of_the_outer_one_is_read_as_random(annotated_source):
    source = annotated_source(
        reach=("reach 6/9, place 3/9", "motor = 0.1"), place=("reach 2/3, done 1/3", "jaw = 0.1")
    )
    model = api.build({"cell.py": source.encode()}, name="cell")
    reported = api.solve(model).mission
    # Nine visits and three visits, each of which fails with 0.1.
    assert reported.visits_as_run == pytest.approx(1 - 0.9**12, rel=1e-12)
    assert reported.failure_probability == pytest.approx(0.71446, abs=1e-5)


def test_names_in_openpra_files_have_signs_that_its_engine_refuses():
    tree = FaultTree.of("fails", {"fails": ("and", "power[1]", "power[2]")})
    values = {"power[1]": 1e-6, "power[2]": 1e-6}
    model = HybridModel.of("cell", {"init": tree}, values=values)
    assert '"init.power[1]"' in dumps_openpra(logic_of_functions(model), mission_time_h=1.0)


def test_redundancy_by_metadata_of_others_is_not_read(tmp_path):
    path = tmp_path / "cell.sysml"
    path.write_text("""\
package Cell {
    private import RiskMetadata::*;
    metadata def Redundancy { attribute redundant : ScalarValues::Boolean; }
    part arm {
        part power [2] {
            @Risk { totalRisk { probability = 6.674e-08; } }
            @Redundancy { redundant = true; }
        }
    }
}
""")
    (power,) = read_sysml(path).components
    assert not power.redundancy.is_redundant


def test_a_log_whose_call_sequence_is_wrapped_is_refused():
    text = """\
Function:init()
ActiveComponents:gripper
Function:place()
ActiveComponents:gripper

CallSequence:init(),
place()
"""
    with pytest.raises(LogError):
        read_log(text, "log.txt", controller="cell.py")
