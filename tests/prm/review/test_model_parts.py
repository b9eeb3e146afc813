"""A model taken apart: every edit together turns the earlier version into the later one."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.blocks.values import computed_redundancy
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import BlockError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind, solve
from tracerisk.prm.review.component_changes import component_items
from tracerisk.prm.review.flow_changes import flow_items
from tracerisk.prm.review.model_parts import (
    ModelParts,
    RiskVersion,
    single_points,
    tolerated_failures,
)


def field(value):
    if isinstance(value, bool):
        return computed_redundancy(Redundancy(value))
    return Field(value, str(value))


@st.composite
def versions(draw):
    """A version of up to five functions with up to three components, that has an end."""
    names = draw(st.lists(st.sampled_from("abcdef"), min_size=1, max_size=5, unique=True))
    blocks = []
    for rank, name in enumerate(names, start=1):
        # A first step to the next or the end, so that every mission has one.
        onward = names[rank] if rank < len(names) else "done"
        back = draw(st.sampled_from([*names, "done"]))
        share = draw(st.sampled_from([Fraction(1, 4), Fraction(1, 2), Fraction(1)]))
        steps = {onward: share}
        if share < 1:
            steps[back] = steps.get(back, 0) + 1 - share
        entries = [
            ComponentEntry(
                component,
                field(draw(st.sampled_from([0.0, 1e-9, 3e-9, 1e-4, 0.2]))),
                field(draw(st.integers(1, 3))),
                field(draw(st.booleans())),
                omitted=draw(st.sampled_from([False, False, True])),
            )
            for component in draw(st.lists(st.sampled_from("xyz"), max_size=3, unique=True))
        ]
        following = tuple(Transition(target, weight) for target, weight in steps.items())
        text = ", ".join(f"{target} {weight}" for target, weight in steps.items())
        blocks.append(RiskBlock(name, field(rank), Field(following, text), tuple(entries)))
    return RiskVersion.of_blocks(blocks, "c.py")


@given(versions(), versions())
def test_all_changes_together_make_the_later_model(before, after):
    flows, _ = flow_items(before, after)
    items, _ = component_items(before, after)
    parts = ModelParts(before)
    for item in [*flows, *items]:
        item.edit(parts)
    made = parts.model()
    states = {state.name: state for state in made.states}
    assert made.entry == after.model.entry
    assert made.parameters == after.model.parameters
    assert states.keys() == after.states.keys()
    for name, state in after.states.items():
        assert set(states[name].next) == set(state.next)
        assert states[name].probabilities == state.probabilities
        assert tolerated_failures(states[name].tree) == tolerated_failures(state.tree)
    expected = after.figures.mission.failure_probability
    assert solve(made).mission.failure_probability == pytest.approx(expected, rel=1e-12, abs=1e-30)


@settings(max_examples=20, deadline=None)
@given(versions())
def test_figures_are_those_of_the_whole_solution(version):
    whole = solve(version.model)
    assert version.figures.mission == whole.mission
    assert version.figures.top_events == {state.name: state.top_event for state in whole.states}
    visits = {state.name: state.expected_visits for state in whole.states}
    assert version.figures.expected_visits == visits


def test_how_many_units_may_fail_is_reported_through_nested_gates():
    gates = (
        Gate("top", GateKind.OR, ("pair", "a", "voted")),
        Gate("pair", GateKind.AND, ("b1", "b2")),
        Gate("voted", GateKind.ATLEAST, ("c1", "c2", "c3", "lone"), k=3),
        Gate("lone", GateKind.OR, ("d",)),
    )
    events = tuple(BasicEvent(name, name[0]) for name in ("a", "b1", "b2", "c1", "c2", "c3", "d"))
    tree = FaultTree("top", gates, events)
    assert tolerated_failures(tree) == {"a": 0, "b": 1, "c": 2, "d": 2}


def test_a_state_that_is_never_reached_has_no_single_point(block, component):
    blocks = [
        block("a", 1, [component("x", 0.1)], {"done": 1}),
        block("b", 2, [component("y", 0.1)], {"done": 1}),
    ]
    assert single_points(RiskVersion.of_blocks(blocks, "c.py").model) == {"x": ["a"]}


def test_what_cannot_fail_in_a_function_is_no_single_point_there(block, component):
    blocks = [
        block("a", 1, [component("x", 0.1), component("y", 0.0)], {"b": 1}),
        block("b", 2, [component("y", 0.1)], {"done": 1}),
    ]
    points = single_points(RiskVersion.of_blocks(blocks, "c.py").model)
    assert points == {"x": ["a"], "y": ["b"]}


def test_a_version_that_makes_no_model_is_an_error(block):
    with pytest.raises(BlockError, match="cannot be reached"):
        RiskVersion.of_blocks([block("a", 1, [], {"a": 1})], "c.py")


def test_what_hits_all_units_at_once_is_no_unit():
    gates = (
        Gate("top", GateKind.OR, ("pair", "pair[all]")),
        Gate("pair", GateKind.AND, ("pair[1]", "pair[2]")),
    )
    own, common = "pair {own}", "pair {common cause}"
    events = (
        BasicEvent("pair[1]", own, component="pair"),
        BasicEvent("pair[2]", own, component="pair"),
        BasicEvent("pair[all]", common, component="pair"),
    )
    assert tolerated_failures(FaultTree("top", gates, events)) == {"pair": 1}
