"""Missions as event trees: their figures are those of the chain, and the engine takes them."""

import json
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.prm.other_models.formats.openpra_engine import engine_figures, needs_engine, violations
from tracerisk.prm import build_model, solve
from tracerisk.prm.other_models.formats.openpra import dumps_openpra, loads_openpra
from tracerisk.prm.other_models.formats.unrolled_mission import logic_of_mission
from tracerisk.prm.other_models.logic.event_trees import solved_event_trees


def solved(logic):
    (solution,) = solved_event_trees(logic, 1.0)
    ends = {}
    for sequence in logic.event_trees[0].tree.sequences:
        ends[sequence.end_state] = ends.get(sequence.end_state, 0.0) + solution[sequence.name]
    return ends


@pytest.fixture
def models(block, component):
    """Draw missions of functions in a row, each perhaps repeated, with groups of every kind."""
    kinds = ("false", "true", "required 2", "true, detected each_visit", "true, common_cause 0.2")

    @st.composite
    def draw_model(draw):
        names = [f"f{i}" for i in range(draw(st.integers(1, 4)))]
        kind = {part: draw(st.sampled_from(kinds)) for part in "ab"}
        blocks = []
        for rank, name in enumerate(names, start=1):
            parts = [
                component(part, draw(st.floats(1e-6, 0.3)), 3, kind[part])
                for part in draw(st.lists(st.sampled_from("ab"), unique=True))
            ]
            rounds = draw(st.integers(1, 4))
            following = names[rank] if rank < len(names) else "done"
            after = {following: Fraction(1, rounds)}
            if rounds > 1:
                after[name] = Fraction(rounds - 1, rounds)
            blocks.append(block(name, rank, tuple(parts), after=after, counts=True))
        if not any(each.components for each in blocks):
            blocks[0] = block(
                "f0",
                1,
                (component("a", 0.1),),
                after=after if len(names) == 1 else {names[1]: 1},
                counts=True,
            )
        return build_model(blocks, name="m.cpp")

    return draw_model()


@settings(suppress_health_check=list(HealthCheck))
@given(data=st.data())
def test_the_event_tree_has_the_figures_of_the_mission(models, data):
    model = data.draw(models)
    logic = logic_of_mission(model)
    mission = solve(model).mission
    ends = solved(logic)
    failed = sum(figure for end, figure in ends.items() if end != "done")
    assert failed == pytest.approx(mission.failure_probability, rel=1e-10)
    text = dumps_openpra(logic, mission_time_h=1.0)
    assert violations(json.loads(text)) == []
    assert solved(loads_openpra(text, "again.json")) == pytest.approx(ends, rel=1e-10)


@needs_engine
@settings(suppress_health_check=list(HealthCheck), max_examples=50, deadline=None)
@given(data=st.data())
def test_the_engine_itself_solves_a_mission_to_our_digits(models, data):
    model = data.draw(models)
    logic = logic_of_mission(model)
    _, ends = engine_figures(json.loads(dumps_openpra(logic, mission_time_h=1.0)))
    # The engine names a sequence by its end; ours of one end are written with ends of their own.
    (ours,) = solved_event_trees(logic, 1.0)
    sequences = sorted(ours[each.name] for each in logic.event_trees[0].tree.sequences)
    assert sorted(ends.values()) == pytest.approx(sequences, rel=1e-12, abs=1e-15)


def test_each_function_ends_as_often_as_in_the_chain(block, component):
    pair, arm = component("power", 0.01, 2, "true"), component("arm", 1e-3)
    model = build_model(
        [
            block("pick", 1, (pair, arm), after={"place": 1}, counts=True),
            block("place", 2, (pair,), after={"done": 1}, counts=True),
        ],
        name="m",
    )
    logic = logic_of_mission(model)
    assert [each.name for each in logic.event_trees] == ["mission"]
    found = solved(logic)
    for state in solve(model).states:
        end = f"{state.name}_failure"
        assert found[end] == pytest.approx(state.absorption_probability, rel=1e-12)


@pytest.mark.parametrize(
    ("after", "counts", "redundancy"),
    [
        ({"a": "9/10", "done": "1/10"}, False, "true"),
        ({"a": "199/200", "done": "1/200"}, True, "true"),
        ({"b": "1/2", "done": "1/2"}, True, "true"),
        ({"done": 1}, True, "true, spare cold"),
    ],
)
def test_a_mission_that_is_no_fixed_sequence_has_no_event_tree(
    block, component, after, counts, redundancy
):
    parts = (component("power", 0.01, 2, redundancy),)
    first = block("a", 1, parts, after=after, counts=counts)
    second = block("b", 2, parts, after={"done": 1}, counts=True)
    assert logic_of_mission(build_model([first, second], name="m")) is None
