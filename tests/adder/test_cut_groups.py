"""From a trace to the mission: how it is cut into functions moves no redundant group's risk."""

from dataclasses import replace
from itertools import product

import pytest

from tests.adder.figures.test_computed import compute as compute
from tests.adder.figures.test_computed import moved, ref, trace_of
from tests.slow import slow_but_every
from tracerisk.adder.blocks.block import Field, RiskBlock
from tracerisk.prm import build_model
from tracerisk.prm.hybrid.solve import solve_figures

FIGURES = {
    "time": ("failure_rate: {value: 0.05, per: hour}",),
    "demands": ("probability: {value: 2.0e-5, per: demand}",),
    "standby": (
        "failure_rate: {value: 0.03, per: hour}",
        "standby_rate: {value: 0.02, per: hour}",
    ),
    "ageing": ("weibull: {shape: 2.2, scale: 9, per: hour}", "age: {value: 1, per: hour}"),
}
_WITHIN = "detected: {test_interval: 1, per: minute}"
_REPAIRED = "repair: {mean_time: 3, per: minute}"
_RARELY = "detected: {test_interval: 2, per: hour}"
GROUPS = {
    "one suffices": ("redundancy: true",),
    "two must work": ("required: 2",),
    "cold": ("spare: cold",),
    "cold with a switch": ("spare: cold", "switch: 0.05"),
    "warm": ("spare: warm", "dormancy: 0.999"),
    "two must work, warm": ("required: 2", "spare: warm", "dormancy: 0.3", "switch: 0.1"),
    "hot with a switch": ("spare: hot", "switch: 0.01"),
    "common cause": ("redundancy: true", "common_cause: {beta: 0.1}"),
    "cold, common cause": ("spare: cold", "common_cause: {beta: 0.1}"),
    "cold, tested within": ("spare: cold", _WITHIN),
    "tested rarely": ("redundancy: true", _RARELY),
    "cold, tested rarely": ("spare: cold", _RARELY),
    "repaired": ("redundancy: true", _REPAIRED),
    "cold with a switch, repaired": ("spare: cold", "switch: 0.05", _REPAIRED),
}

_PAIRS = list(product(FIGURES, GROUPS))
EVERY = slow_but_every(5, _PAIRS)
"""Every figure and every group; the slow run has each figure with each group."""
assert {pair[0] for pair in _PAIRS[::5]} == set(FIGURES)


def used(seconds: float, starts: int):
    return replace(moved(seconds), starts=starts)


def pieces_of(count: int, **joints: float):
    """Return the visits of a mission cut into so many functions."""
    each = {name: used(seconds / count, 100 // count) for name, seconds in joints.items()}
    return [(f"step{number}", 1_000.0 / count, each) for number in range(count)]


def rounds_of(rounds: int, count: int, **joints: float):
    """Return the visits of a mission that goes so often through so many functions."""
    starts = 100 // rounds // count
    each = {name: used(seconds / rounds / count, starts) for name, seconds in joints.items()}
    one = [(f"step{number}", 1_000.0 / rounds / count, each) for number in range(count)]
    return one * rounds


def failure(computed) -> float:
    """Return the mission's failure, with functions that follow one another."""
    blocks = [
        RiskBlock(name.name, Field(rank, str(rank)), None, block.components)
        for rank, (name, block) in enumerate(computed.blocks.items(), 1)
    ]
    return solve_figures(build_model(blocks, name="m")).mission.failure_probability


@pytest.fixture
def mission(compute):
    def make(visits, figure, group):
        lines = (*FIGURES[figure], *GROUPS[group], 'twin: {joints: "*"}')
        return failure(compute(trace_of(*visits), *lines))

    return make


@pytest.mark.parametrize(("figure", "group"), EVERY)
def test_units_alike(mission, figure, group):
    joints = {"j1": 300.0, "j2": 300.0, "j3": 300.0}
    whole = mission(pieces_of(1, **joints), figure, group)
    assert whole > 0.0
    for count in (2, 10, 50):
        assert mission(pieces_of(count, **joints), figure, group) == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize(("figure", "group"), EVERY)
def test_units_that_differ(mission, figure, group):
    joints = {"j1": 500.0, "j2": 100.0, "j3": 300.0}
    whole = mission(pieces_of(1, **joints), figure, group)
    for count in (2, 10, 50):
        assert mission(pieces_of(count, **joints), figure, group) == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize(("figure", "group"), EVERY)
def test_units_in_a_loop(compute, figure, group):
    lines = (*FIGURES[figure], *GROUPS[group], 'twin: {joints: "*"}')

    def readings(rounds, count):
        visits = rounds_of(rounds, count, j1=300.0, j2=300.0, j3=300.0)
        blocks = list(compute(trace_of(*visits), *lines).blocks.values())
        found = solve_figures(build_model(blocks, name="m")).mission
        return found.failure_probability, found.geometric_cycles

    # Ten rounds, counted: the mission is that without a loop, however a round is cut.
    whole, _ = readings(1, 1)
    loop, geometric = readings(10, 1)
    assert 0.0 < loop == pytest.approx(whole, rel=0.01)
    for count in (2, 5):
        assert readings(10, count) == pytest.approx((loop, geometric), rel=0.01)


@pytest.mark.parametrize("group", GROUPS)
def test_units_used_one_after_the_other(mission, group):
    visits = [
        ("first", 500.0, {"j1": used(500.0, 50), "j2": used(50.0, 20)}),
        ("second", 500.0, {"j2": used(50.0, 80), "j3": used(300.0, 100)}),
    ]
    apart = mission(visits, "time", group)
    both = mission(pieces_of(1, j1=500.0, j2=100.0, j3=300.0), "time", group)
    assert apart == pytest.approx(both, rel=0.01)


def test_the_functions_are_those_of_the_trace(compute):
    computed = compute(trace_of(*pieces_of(2, j1=1.0)), *FIGURES["time"], 'twin: {joints: "*"}')
    assert list(computed.blocks) == [ref("step0"), ref("step1")]
