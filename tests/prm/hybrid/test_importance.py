"""Importance over the mission against differences in 250 digits, hidden failures included."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tracerisk.prm import build_model, solve


def close(expected, rel=1e-12):
    return pytest.approx(float(expected), rel=rel, abs=0.0)


def importance_of(model, name):
    return next(each for each in solve(model).components if each.name == name)


@settings(max_examples=10, deadline=None)
@given(data=st.data())
def test_every_measure_equals_differences_of_missions_in_250_digits(
    in_many_digits, small_models, data
):
    def mission(name, factor):
        return in_many_digits.mission_by_events(model, {name: factor})

    model = data.draw(small_models(functions=2, rare=True))
    one, step = in_many_digits.number(1), in_many_digits.number(10) ** -50
    for found in solve(model).components:
        name = found.name
        total, without = mission(name, 1), mission(name, 0)
        assume(total > 0)
        slope = (mission(name, one + step) - mission(name, one - step)) / (2 * step * found.theta)
        assert found.birnbaum == close(slope, 1e-11)
        assert found.criticality == close(slope * found.theta / total, 1e-11)
        assert found.without == close(without)
        assert found.fussell_vesely == close((total - without) / total, 1e-11)
        assert found.tenfold == close(mission(name, 10) / total)


def test_a_pair_of_published_size_keeps_twelve_digits(in_many_digits, block, component):
    # Ten cycles of five functions; the pair's share of the risk is some 1e-6 of the motors'.
    pair, motor = component("power", 6.674e-08, 2, "true"), component("motor", 9.5e-08)
    blocks = [
        block(
            f"f{i}",
            i,
            (pair, motor),
            after={f"f{i + 1}": 1} if i < 5 else {"f1": "9/10", "done": "1/10"},
        )
        for i in range(1, 6)
    ]
    model = build_model(blocks, name="m")
    total = in_many_digits.mission_by_events(model, {})
    without = in_many_digits.mission_by_events(model, {"power": 0})
    found = importance_of(model, "power")
    assert found.fussell_vesely == close((total - without) / total)
    assert found.fussell_vesely < 1e-5


def test_the_slope_of_a_pair_at_zero_is_that_of_its_first_failure(block, component):
    # Both are needed in the second function: what fails unseen in the first is missing there.
    blocks = [
        block("a", 1, (component("motor", 0.0, 2, "true"),)),
        block("b", 2, (component("motor", 0.0, 2, "false"), component("other", 0.25))),
    ]
    found = importance_of(build_model(blocks, name="m"), "motor")
    assert found.birnbaum == close(2 * 0.75 + 2 * 0.75)
    by_state = {share.name: share.birnbaum for share in found.by_state}
    assert by_state == {"a": close(1.5), "b": close(1.5)}
    assert [share.name for share in found.by_unit] == ["motor[1]", "motor[2]"]


def test_without_the_only_group_that_can_fail_the_mission_never_does(block, component):
    blocks = [
        block(name, i, (component("pair", 1e-9, 2, "true"),)) for i, name in enumerate("ab", 1)
    ]
    found = importance_of(build_model(blocks, name="m"), "pair")
    assert found.risk_reduction_worth == math.inf
    assert found.fussell_vesely == close(1)
    assert (found.without, found.criticality) == (0.0, close(2, 1e-8))
    # To first order (2p)^2: ten times the figure is a hundred times the risk.
    assert found.tenfold == close(100, 1e-7)
    assert found.risk_achievement_worth == close(
        1 / solve(build_model(blocks, name="m")).mission.failure_probability
    )


def test_shares_of_hidden_failures_sum_to_the_whole(block, component):
    blocks = [
        block("a", 1, (component("cell", 0.125, 4, "required 2"),), after={"b": 1}),
        block(
            "b", 2, (component("cell", 0.25, 3, "required 2"),), after={"a": "1/2", "done": "1/2"}
        ),
    ]
    found = importance_of(build_model(blocks, name="m"), "cell")
    for shares in (found.by_state, found.by_unit):
        assert math.fsum(share.birnbaum for share in shares) == close(found.birnbaum)
    units = {share.name: share.birnbaum for share in found.by_unit}
    assert units["cell[1]"] == close(units["cell[3]"])
    # The fourth cell is there in one function only.
    assert units["cell[4]"] < units["cell[1]"]
