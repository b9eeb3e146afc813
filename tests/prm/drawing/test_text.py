"""Models and results where no drawing can be shown."""

from dataclasses import replace

import pytest
from lxml import html

from tracerisk.prm import EventTree, FaultTree, HybridModel, MarkovChain, solve
from tracerisk.prm.notebook.drawings import text_of

TREE = FaultTree.of("top", {"top": ("or", "a", "b")}, {"a": 1e-7, "b": 2e-7})
MODEL = HybridModel.of("arm", {"pick": TREE})
HOSTILE = "</td></svg><script>alert(1)</script>'\" onload='x'"


def test_models_say_their_size():
    assert text_of(TREE) == "Fault tree top: 1 gates, 2 events"
    assert text_of(MODEL) == "arm: 1 functions, 2 parameters"
    chain = MarkovChain({"a": {"end": 1.0}}, ("end",))
    assert text_of(chain) == "Markov chain: 1 transient and 1 absorbing states"
    tree = EventTree.of("t", {"f": 0.5}, {"S": {"f": "success"}, "F": {"f": "failure"}})
    assert text_of(tree) == "Event tree t: 2 sequences"
    with pytest.raises(TypeError, match="str cannot be drawn"):
        text_of("text")


def test_an_assessment_is_its_figures_and_what_they_are_not():
    lines = text_of(solve(MODEL)).split("\n")
    assert lines[0].startswith("arm: mission failure probability 3e-07 (fixed cycles 3e-07,")
    assert any(line.startswith("b ") for line in lines)
    assert lines[-1].startswith("Probability of mission failure by hardware; not harm")


def test_a_notebook_shows_text_beside_the_html_and_not_all_fields():
    formatters = pytest.importorskip("IPython.core.formatters", reason="IPython is not installed")
    shown = formatters.DisplayFormatter().format
    assessment = solve(MODEL)
    for each in (TREE, MODEL, assessment):
        data, _ = shown(each)
        assert data["text/plain"] == text_of(each)
        assert data["text/html"] == each._repr_html_()
        assert data["image/svg+xml"] == each._repr_svg_()
    data, _ = shown(assessment.importance())
    assert data["text/plain"] == str(assessment.importance())
    assert data["text/html"].startswith("<table>")


def test_of_very_many_assumptions_the_first_are_shown():
    assessment = replace(solve(MODEL), findings=tuple(f"finding {n}" for n in range(500)))
    for reported in (assessment._repr_html_(), text_of(assessment)):
        assert "finding 20" in reported
        assert "finding 40" not in reported
        assert "more" in reported


def test_hostile_names_are_text_in_every_drawing():
    tree = FaultTree.of(
        HOSTILE, {HOSTILE: ("or", f"a{HOSTILE}", "b")}, {f"a{HOSTILE}": 1e-7, "b": 2e-7}
    )
    model = HybridModel.of(HOSTILE, {HOSTILE: tree})
    assessment = replace(solve(model), assumptions=(HOSTILE,), findings=(HOSTILE,))
    for each in (tree, model, assessment):
        page = html.fragment_fromstring(each._repr_html_())
        assert not page.xpath("//script | //*[@onload]")
        assert HOSTILE in page.text_content()


def test_large_models_are_summarised():
    trees = {
        f"f{n}": FaultTree.of(
            f"t{n}",
            {f"t{n}": ("or", *(f"e{k}" for k in range(20)))},
            dict.fromkeys((f"e{k}" for k in range(20)), 1e-9),
        )
        for n in range(120)
    }
    model = HybridModel.of("large", trees)
    assert len(model._repr_html_()) < 200_000
    assert len(solve(model)._repr_html_()) < 200_000
