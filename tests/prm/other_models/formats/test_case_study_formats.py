"""The published case study's fault trees, out through Open-PSA and OpenPRA and back."""

import pytest

from tests.prm.other_models.formats.models import solved_tops
from tracerisk.prm import build_model
from tracerisk.prm.other_models.formats.conversion import logic_of_functions
from tracerisk.prm.other_models.formats.open_psa import loads_open_psa
from tracerisk.prm.other_models.formats.open_psa.rewriting import written_name
from tracerisk.prm.other_models.formats.open_psa.writer import dumps_open_psa
from tracerisk.prm.other_models.formats.openpra import dumps_openpra, loads_openpra


@pytest.fixture(scope="module")
def functions(case_study):
    model = build_model(case_study, name="case")
    tops = {f"{state.name}.{state.tree.top}": state for state in model.states}
    expected = {name: state.tree.probability(state.probabilities).p for name, state in tops.items()}
    return model, expected


def test_the_figures_come_back_through_open_psa_and_openpra(functions):
    model, expected = functions
    logic = logic_of_functions(model)
    assert solved_tops(logic, 1.0) == expected
    xml = dumps_open_psa(logic)
    again = loads_open_psa(xml, "case.xml")
    assert again == logic
    assert solved_tops(again, 1.0) == expected
    text = dumps_openpra(logic, mission_time_h=1.0)
    assert solved_tops(loads_openpra(text, "case.json"), 1.0) == expected
    across = dumps_open_psa(loads_openpra(text, "case.json"))
    assert solved_tops(loads_open_psa(across, "across.xml"), 1.0) == expected


def test_scram_finds_the_same_figures(functions, scram, tmp_path):
    model, expected = functions
    path = tmp_path / "case.xml"
    path.write_text(dumps_open_psa(logic_of_functions(model)), encoding="utf-8")
    report = scram(path)
    # SCRAM prints six digits, and the names as they are written.
    assert report.tops == {
        ".".join(map(written_name, name.split("."))): pytest.approx(figure, rel=6e-6)
        for name, figure in expected.items()
    }
