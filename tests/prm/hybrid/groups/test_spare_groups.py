"""Groups with spares in models of functions: what is asked of them, and what is refused."""

import math
from fractions import Fraction

import numpy as np
import pytest

from tracerisk.errors import BlockError, ModelError
from tracerisk.prm import FaultTree, HybridModel, build_model, failure_probabilities, solve
from tracerisk.prm.formats.model_json import dumps, loads
from tracerisk.prm.other_models.formats import linked_json
from tracerisk.prm.other_models.formats.conversion import logic_of_functions
from tracerisk.prm.other_models.formats.expanded_chain import expanded_chain
from tracerisk.prm.other_models.linked import linked
from tracerisk.prm.other_models.linked.conversion import FAILURE
from tracerisk.prm.questions.pair_importance import pair_importances
from tracerisk.prm.questions.set_values import with_values
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.gates import Gate, GateKind
from tracerisk.prm.trees.spares import Spares


@pytest.fixture
def cell(block, component):
    """Build a loop of two functions with two groups with spares, a pair and a motor."""

    def make(p=0.02, kind="true, spare cold, switch 0.1"):
        first = [
            component("power", p, 3, kind),
            component("control", 0.01, 2, "true"),
            component("motor", 0.003, 4),
        ]
        second = [
            component("power", p / 4, 3, "required 2, spare warm 0.25"),
            component("brake", 0.05, 2, "true, spare warm 0.5, common_cause 0.2"),
        ]
        return build_model(
            [block("a", 1, first), block("b", 2, second, after={"a": "3/4", "done": "1/4"})],
            name="cell",
        )

    return make


def failure(model):
    return solve(model).mission.failure_probability


def test_the_chain_written_out_ends_as_the_model_does(cell):
    model = cell()
    chain = expanded_chain(model).solve("a").absorption()
    found = math.fsum(chain[name] for name in ("a_failure", "b_failure"))
    assert found == pytest.approx(failure(model), rel=1e-13)


def test_a_model_reads_back_from_json_with_its_spares(cell):
    model = cell()
    again = loads(dumps(model), "cell.json")
    assert again == model
    assert again.states[1].spares["power"] == Spares(0.25, 0.0)


def test_many_draws_at_once_give_what_one_by_one_does(cell):
    model = cell()
    drawn = {
        "power": np.array([1e-9, 1e-3, 0.3, 0.99]),
        "brake {own}": np.array([0.0, 0.2, 0.9, 1]),
    }
    found = failure_probabilities(model, drawn)
    for number, each in enumerate(found):
        one = with_values(model, {name: values[number] for name, values in drawn.items()})
        assert each == pytest.approx(failure(one), rel=1e-12)


def test_pairs_of_parameters_have_their_mixed_derivative(cell):
    model = cell()
    thetas = {each.name: each.theta for each in model.parameters}

    def at(first, second, one, other):
        values = {first: thetas[first] * (1 + one), second: thetas[second] * (1 + other)}
        return failure(with_values(model, values))

    step = 1e-3
    for pair in pair_importances(model):
        names = pair.first, pair.second
        corners = math.fsum(
            a * b * at(*names, a * step, b * step) for a in (1, -1) for b in (1, -1)
        )
        slope = corners / (4 * step**2 * thetas[pair.first] * thetas[pair.second])
        assert pair.joint_birnbaum == pytest.approx(slope, rel=1e-3, abs=1e-4), names


def test_a_chain_too_large_is_bounded_and_holds_the_figure(cell):
    model = cell(0.1)
    exact = failure(model)
    for limit in (4, 8, 16):
        found = solve(model, limit=limit)
        (reported,) = [each for each in found.assumptions if "bound" in each]
        low, high = (
            float(each) for each in reported.split("between ")[1].split(",")[0].split(" and ")
        )
        assert low <= exact * (1 + 1e-6)
        assert exact <= high * (1 + 1e-6)
        for each in found.components:
            assert 0.0 <= each.fussell_vesely <= 1.0 + 1e-12
            assert each.birnbaum >= 0.0


def test_contributions_are_the_fall_of_the_top_event(cell):
    for state in solve(cell()).states:
        parts = {part.name: part for part in state.components}
        assert all(0.0 <= part.contribution <= state.top_event for part in parts.values())
        assert (parts["power"].units, parts["power"].required) == (
            (3, 1) if state.name == "a" else (3, 2)
        )


def test_exported_trees_have_one_event_for_the_group(cell):
    logic = logic_of_functions(cell())
    assert "a.power[spares]" in {each.name for each in logic.events}
    assert "a.power[1]" not in {each.name for each in logic.events}


def test_a_function_that_is_never_reached_has_its_group_in_one_visit(block, component):
    part = component("unit", 0.2, 2, "true, spare cold")
    model = build_model([block("a", 1, [part], after={"done": 1}), block("b", 2, [part])], name="m")
    reached, other = solve(model).states
    assert other.top_event == pytest.approx(reached.top_event, rel=1e-14)
    assert other.components[0].contribution == pytest.approx(other.top_event, rel=1e-14)


@pytest.mark.parametrize("kind", ["true, spare cold, switch 0.1", "true, spare cold, switch 1"])
@pytest.mark.parametrize("p", [1e-8, 0.02, 0.5])
def test_a_linked_model_has_the_figures_of_the_model(cell, p, kind):
    model = cell(p, kind)
    expected = solve(model)
    found = linked(model).solve()
    assert found.figures[FAILURE] == pytest.approx(expected.mission.failure_probability, rel=1e-12)
    for state in expected.states:
        assert found.figures[state.failure_state] == pytest.approx(
            state.absorption_probability, rel=1e-12
        )
    assert (
        found.figures
        == linked_json.loads(linked_json.dumps(linked(model)), "m.json").solve().figures
    )


def test_spares_need_one_quantity_in_every_function(block, component):
    blocks = [
        block("a", 1, [component("power", 0.1, 3, "true, spare cold")]),
        block("b", 2, [component("power", 0.1, 2, "true")]),
    ]
    with pytest.raises(BlockError, match="'power': quantity is 2 here, but 3 in another function"):
        build_model(blocks, name="m")


def test_all_units_of_a_group_are_needed_where_another_function_says_so(block, component):
    # A cold spare that took over in one function is missing in the next, which needs both.
    p = Fraction(1, 4)
    model = build_model(
        [
            block("a", 1, [component("power", float(p), 2, "true, spare cold")]),
            block("b", 2, [component("power", 1e-300, 2, "false")]),
        ],
        name="m",
    )
    assert failure(model) == pytest.approx(float(p), rel=1e-13)


def hybrid(spares, latent=("x", "y"), parameters=("u", "u"), kind=GateKind.AND):
    tree = FaultTree(
        "group",
        (Gate("group", kind, ("x", "y")),),
        tuple(BasicEvent(name, of) for name, of in zip("xy", parameters, strict=True)),
    )
    model = HybridModel.of("m", {"a": tree}, values=dict.fromkeys(parameters, 0.1), latent=latent)
    (state,) = model.states
    from dataclasses import replace

    return replace(model, states=(replace(state, spares=spares),))


def test_spares_of_any_names_are_solved():
    found = solve(hybrid({"group": Spares(0.0)})).mission.failure_probability
    assert found == pytest.approx(0.1 + 0.9 * math.log(0.9), rel=1e-12)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"spares": {"other": Spares(0.0)}}, "spares of 'other': allowed: a gate 'and'"),
        ({"spares": {"group": Spares(0.0)}, "latent": ("x",)}, "latent unit 'x' is an input of"),
        ({"spares": {"group": Spares(0.0)}, "latent": ()}, "allowed: a gate 'and' or 'atleast'"),
        ({"spares": {"group": Spares(0.0)}, "kind": GateKind.OR}, "allowed: a gate 'and'"),
        (
            {"spares": {"group": Spares(0.0)}, "parameters": ("u", "v")},
            "of a group with spares need the same",
        ),
    ],
)
def test_what_spares_cannot_be_is_refused(wrong, message):
    with pytest.raises(ModelError, match=message):
        hybrid(**wrong)


def test_shares_outside_their_range_are_refused():
    with pytest.raises(ModelError, match=r"switch 1.5 is outside \[0, 1\]"):
        Spares(0.0, 1.5)
