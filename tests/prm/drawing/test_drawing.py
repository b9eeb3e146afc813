import xml.etree.ElementTree as ET

import pytest

from tracerisk.prm import (
    BayesianNetwork,
    EventTree,
    FaultTree,
    Given,
    HybridModel,
    MarkovChain,
    solve,
)
from tracerisk.prm.notebook.drawings import html_of, svg_of
from tracerisk.prm.other_models.event_trees.elements import Branch, Link, Resume

SVG = "{http://www.w3.org/2000/svg}"


def texts(svg: str) -> list[str]:
    """The words of a drawing, which must be well-formed XML."""
    return [element.text or "" for element in ET.fromstring(svg).iter(f"{SVG}text")]


def shapes(svg: str, kind: str) -> int:
    return sum(1 for _ in ET.fromstring(svg).iter(SVG + kind))


TREE = FaultTree.of(
    "top",
    {
        "top": ("or", "a&b", ("xor", "shared", "c"), ("nand", "d", "e"), "off"),
        "a&b": ("atleast", 2, "shared", "<x>", ("inhibit", "f", "g"), ("transfer", "h")),
    },
    houses={"off": False},
)


@pytest.fixture(scope="module")
def arm() -> HybridModel:
    pick = FaultTree.of(
        "pick", {"pick": ("or", "gripper", "motor")}, {"gripper": 7e-8, "motor": 9e-8}
    )
    return HybridModel.of(
        "<arm>",
        {"init": pick, "pick": pick},
        {"init": "pick", "pick": {"pick": 0.9, "done": 0.1}},
    )


def test_a_fault_tree_is_drawn_with_every_gate_and_event_once():
    words = texts(TREE._repr_svg_())
    for name in ("top", "a&b", "shared", "<x>", "top.2", "top.3", "a&b.3", "a&b.4", "off"):
        assert words.count(name) == 1
    assert {"≥1", "≥2", "=1", "&", "0"} <= set(words)
    # A circle for each event, and the dot of the NAND.
    assert shapes(TREE._repr_svg_(), "circle") == len(TREE.events) + 1


def test_of_a_large_tree_the_uppermost_part_is_drawn_and_the_rest_reported():
    tree = FaultTree.of("top", {"top": ("or", *(f"e{index}" for index in range(10_000)))})
    words = texts(svg_of(tree))
    assert "e148" in words
    assert "e149" not in words
    assert "+9851" in words
    assert "9851 more below" in words


def test_long_names_are_shortened_and_whole_in_their_tooltip():
    name = "a" * 60
    svg = svg_of(FaultTree.of(name, {name: ("or", "b")}))
    assert "a" * 27 + "…" in texts(svg)
    assert f"<title>{name}</title>" in svg


def test_a_chain_is_drawn_with_its_probabilities_and_ways_back():
    chain = MarkovChain(
        {"a": {"b": 0.875, "fail": 0.125}, "b": {"a": 0.5, "done": 0.375, "b": 0.125}},
        ("fail", "done"),
    )
    words = texts(chain._repr_svg_())
    assert {"a", "b", "fail", "done", "0.875", "0.5", "0.375", "↻0.125"} <= set(words)


def test_of_a_large_chain_the_first_states_are_drawn_and_the_rest_reported():
    size = 300
    chain = MarkovChain(
        {f"s{index}": {f"s{(index + 1) % size}": 0.5, "end": 0.5} for index in range(size)},
        ("end",),
    )
    words = texts(chain._repr_svg_())
    assert {"s0", "s79", "end"} <= set(words)
    assert "s80" not in words
    assert "220 more states" in words


def test_a_hybrid_model_is_drawn_with_its_failures(arm):
    words = texts(arm._repr_svg_())
    assert {"init", "pick", "done", "init_failure", "pick_failure", "↻0.9", "0.1"} <= set(words)


def test_html_escapes_names_and_says_the_size(arm):
    assert "<figcaption>&lt;arm&gt;: 2 functions, 2 parameters</figcaption>" in arm._repr_html_()
    assert "Fault tree top: 6 gates, 8 events" in TREE._repr_html_()
    chain = MarkovChain({"a": {"end": 1.0}}, ("end",))
    assert "1 transient and 1 absorbing states" in chain._repr_html_()


def test_an_assessment_is_shown_by_its_figures_and_shares(arm):
    assessment = solve(arm)
    html = assessment._repr_html_()
    assert f"{assessment.mission.failure_probability:.6g}" in html
    assert "<h4>&lt;arm&gt;</h4>" in html
    words = texts(assessment._repr_svg_())
    assert words[0] == "motor"
    assert f"{assessment.components[0].fussell_vesely:.3g}" in words


LEAK = EventTree.of(
    "leak",
    {"detected": "blind", "closed": 0.125},
    {
        "S1": {"detected": "success", "closed": "success"},
        "S2": {"detected": "success", "closed": "failure"},
        "S3": {"detected": "failure"},
    },
    end_states={"S1": "<safe>", "S2": "release"},
    initiating=0.5,
    per="year",
)


def test_an_event_tree_is_drawn_with_its_paths_from_the_first_state_up():
    root = ET.fromstring(LEAK._repr_svg_())
    at = {text.text: float(text.get("y")) for text in root.iter(f"{SVG}text")}
    assert {"leak", "detected", "closed", "success", "failure", "<safe>", "release"} <= set(at)
    assert at["S1"] < at["S2"] < at["S3"]
    assert at["S1"] == at["<safe>"]
    assert "<figcaption>Event tree leak: 3 sequences</figcaption>" in LEAK._repr_html_()


def test_a_path_into_another_event_tree_ends_with_its_name():
    shared = Branch(Link("second"), (), "on")
    tree = EventTree("first", (), Branch(Resume("on")), (), (shared,))
    assert "→ second" in texts(tree._repr_svg_())


def test_of_a_large_event_tree_the_first_paths_are_drawn():
    functions = {f"f{index}": 0.5 for index in range(7)}
    rows = {
        f"S{number}": {
            name: "failure" if number >> index & 1 else "success"
            for index, name in enumerate(functions)
        }
        for number in range(128)
    }
    words = texts(EventTree.of("t", functions, rows)._repr_svg_())
    assert sum(word.startswith("S") for word in words) == 60
    assert "and more paths" in words


def test_a_solved_event_tree_shows_its_outcomes_and_sequences():
    blind = FaultTree.of("blind", {}, {"blind": 0.25})
    html = LEAK.solve(blind)._repr_html_()
    assert "<li>&lt;safe&gt;: 0.328125 per year</li>" in html
    assert "<td>S3</td><td>0.25</td><td>0.125</td>" in html


def test_a_network_is_drawn_from_conditions_to_events():
    network = BayesianNetwork(
        {"heat": {"cool": 0.5, "hot": 0.5}},
        {
            "motor": Given("heat", {"cool": 0.1, "hot": 0.2}),
            "heat": Given("heat", {"cool": 0.1, "hot": 0.2}),
        },
    )
    words = texts(network._repr_svg_())
    assert sorted(words) == ["heat", "heat (event)", "motor"]
    assert "Bayesian network: 1 conditions, 2 events" in network._repr_html_()


@pytest.mark.parametrize("of", [svg_of, html_of])
def test_what_has_no_drawing_is_refused(of):
    with pytest.raises(TypeError, match="str cannot be drawn"):
        of("text")
