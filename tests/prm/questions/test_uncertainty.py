import math
import subprocess
import sys
import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from tracerisk.errors import ModelError
from tracerisk.prm import (
    BasicEvent,
    FaultTree,
    FunctionState,
    Gate,
    GateKind,
    HybridModel,
    NextStep,
    Parameter,
    build_model,
    solve,
)
from tracerisk.prm.numbers.absorption import absorption
from tracerisk.prm.numbers.distributions import Beta, Gamma, Lognormal, Normal, Uniform
from tracerisk.prm.numbers.strata import LatinHypercube
from tracerisk.prm.questions.draws import MOST_TOGETHER, InputDraws, UncertainInput
from tracerisk.prm.questions.sampled_mission import failure_samples
from tracerisk.prm.questions.set_values import with_values
from tracerisk.prm.questions.sobol import first_order_shares
from tracerisk.prm.questions.tails import intervals
from tracerisk.prm.questions.uncertainty import propagate
from tracerisk.report.model_answers import render_uncertainty

LOOP = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}
SHARES = np.array([0.05, 0.5, 0.95])


@pytest.fixture(scope="module")
def case(case_study):
    return build_model(case_study, profile=LOOP, name="case")


@pytest.fixture(scope="module")
def one_part(block, component):
    """A mission of one visit that fails with the figure of its one part."""
    return build_model([block("a", 1, (component("motor", 1e-6),))], name="m")


def of_each(model, distribution):
    return {parameter.name: distribution for parameter in model.parameters}


# distributions


def test_an_error_factor_is_the_95th_percentile_over_the_median():
    assert Lognormal(3.0).quantiles(SHARES, 2e-6) == pytest.approx(
        [2e-6 / 3, 2e-6, 6e-6], rel=1e-12
    )


def test_the_value_of_a_lognormal_may_be_its_mean():
    by_mean = Lognormal(3.0, "mean")
    assert by_mean.mean(2e-6) == pytest.approx(2e-6, rel=1e-14)
    _, median, high = by_mean.quantiles(SHARES, 2e-6)
    assert high / median == pytest.approx(3.0, rel=1e-12)
    assert median == pytest.approx(2e-6 * math.exp(-(by_mean.sigma**2) / 2), rel=1e-12)


@pytest.mark.parametrize(
    ("distribution", "reference"),
    [
        (Lognormal(5.0), ("lognorm", {"s": math.log(5) / 1.6448536269514722, "scale": 2e-3})),
        (Uniform(1e-6, 3e-6), ("uniform", {"loc": 1e-6, "scale": 2e-6})),
        (Uniform(1e-6, 1e-3, log=True), ("loguniform", {"a": 1e-6, "b": 1e-3})),
        (Beta(0.5, 2000.5), ("beta", {"a": 0.5, "b": 2000.5})),
        (Gamma(2.5, 1e-6), ("gamma", {"a": 2.5, "scale": 1e-6})),
        (Normal(1e-3, 1e-3), ("truncnorm", {"a": -1.0, "b": math.inf, "loc": 1e-3, "scale": 1e-3})),
    ],
    ids=lambda each: getattr(each, "__class__", each).__name__,
)
def test_quantiles_and_means_are_those_of_scipy(distribution, reference):
    stats = pytest.importorskip("scipy.stats")
    name, arguments = reference
    expected = getattr(stats, name)(**arguments)
    shares = np.array([1e-6, 0.05, 0.3, 0.5, 0.95, 0.999])
    assert distribution.quantiles(shares, 2e-3) == pytest.approx(expected.ppf(shares), rel=1e-9)
    assert distribution.mean(2e-3) == pytest.approx(expected.mean(), rel=1e-9)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Lognormal(0.9), "error factor 0.9: allowed: finite numbers from 1 on"),
        (lambda: Lognormal(math.nan), "error factor nan"),
        (lambda: Lognormal(3.0, "mode"), "value_is 'mode'; allowed: mean, median"),
        (lambda: Uniform(2.0, 1.0), "uniform from 2.0 to 1.0: give low <= high"),
        (lambda: Uniform(0.0, 1.0, log=True), "the bounds must be above 0"),
        (lambda: Beta(0.0, 1.0), "beta distribution: alpha is 0.0; give a finite number above 0"),
        (lambda: Gamma(1.0, math.inf), "gamma distribution: scale is inf"),
        (lambda: Normal(1.0, -1.0), "normal distribution: deviation is -1.0"),
    ],
)
def test_a_distribution_that_is_none_is_refused(make, message):
    with pytest.raises(ModelError, match=message):
        make()


# propagation


def test_a_mission_of_one_part_has_the_percentiles_of_its_figure(one_part):
    found = propagate(one_part, distributions={"motor": Lognormal(3.0)})
    assert found.percentiles == pytest.approx([1e-6 / 3, 1e-6, 3e-6], rel=1e-3)
    assert found.point == pytest.approx(1e-6, rel=1e-14)
    assert found.mean == pytest.approx(Lognormal(3.0).mean(1e-6), rel=1e-3)
    (motor,) = found.inputs
    assert (motor.name, motor.value, motor.cut) == ("motor", 1e-6, 0)
    assert motor.share == pytest.approx(1.0, abs=1e-9)


def test_the_units_and_visits_of_a_component_share_its_draw(case):
    """All motors fail together in the draws: the spread is that of one draw, scaled."""
    only = replace(case, parameters=case.parameters)
    found = propagate(only, distributions={"electric_motor": Lognormal(10.0)})
    rest = solve(with_values(case, {"electric_motor": 0.0})).mission.failure_probability
    shares = np.array([0.05, 0.5, 0.95])
    thetas = Lognormal(10.0).quantiles(shares, 1.30644e-07)
    expected = [
        solve(with_values(case, {"electric_motor": theta})).mission.failure_probability
        for theta in thetas
    ]
    assert found.percentiles == pytest.approx(expected, rel=2e-3)
    assert found.percentiles[0] > rest


def test_each_draw_is_the_model_solved_there(case, exact):
    scales = (0.5, 1.0, 1e4)
    thetas = {
        name: theta * np.array(scales)
        for name, theta in (("electric_motor", 1.30644e-07), ("power_system", 6.674e-08))
    }
    expected = [
        float(
            exact.mission(
                case,
                {"electric_motor": Fraction(scale), "power_system": Fraction(scale)},
            )
        )
        for scale in scales
    ]
    assert failure_samples(case, thetas) == pytest.approx(expected, rel=1e-12)


def test_many_draws_are_taken_in_passes(case, monkeypatch):
    thetas = {"gripper": np.linspace(1e-9, 1e-6, 1000)}
    whole = failure_samples(case, thetas)
    monkeypatch.setattr("tracerisk.prm.questions.sampled_mission._CELLS", 10_000)
    assert np.array_equal(failure_samples(case, thetas), whole)


def test_a_chain_with_loops_is_solved_for_each_draw(exact):
    generator = np.random.default_rng(1)
    names = [f"s{index}" for index in range(8)]
    draws = 5
    rows = {}
    for name in names:
        targets = [*generator.choice(names, 3, replace=False), name, "fail", "done"]
        weights = generator.random((len(targets), draws)) * np.where(
            np.array(targets) == "fail", 1e-12, 1.0
        ).reshape(-1, 1)
        row = {}
        for target, weight in zip(targets, weights / weights.sum(axis=0), strict=True):
            row[str(target)] = row.get(str(target), 0.0) + weight
        rows[name] = row
    found = absorption(rows, "s0")
    for draw in range(draws):
        ways = exact.normalised(
            {name: {t: float(p[draw]) for t, p in row.items()} for name, row in rows.items()}
        )
        visits = exact.visits(ways, "s0")
        expected = sum(visits[name] * ways[name]["fail"] for name in names)
        assert found["fail"][draw] == pytest.approx(float(expected), rel=1e-12)


def test_the_same_seed_gives_the_same_and_another_one_another(case):
    given = of_each(case, Lognormal(3.0))
    first = propagate(case, distributions=given, samples=500, seed=7)
    assert propagate(case, distributions=given, samples=500, seed=7) == first
    assert propagate(case, distributions=given, samples=500, seed=8) != first


def test_another_uncertain_parameter_changes_no_draw_of_the_first():
    alone = LatinHypercube(100, 3).uniform("a")
    beside = LatinHypercube(100, 3)
    beside.uniform("b")
    assert np.array_equal(beside.uniform("a"), alone)
    assert sorted((alone * 100).astype(int)) == list(range(100))


def test_the_common_cause_of_a_component_is_drawn_with_its_own_part(block, component):
    parts = (component("power", 1e-3, 2, "true, common_cause 0.1"),)
    model = build_model([block("a", 1, parts)], name="m")
    found = propagate(model, distributions={"power": Lognormal(2.0)})
    assert [each.name for each in found.inputs] == ["power"]
    high = solve(with_values(model, {"power": 2e-3})).mission.failure_probability
    assert found.percentiles[2] == pytest.approx(high, rel=1e-3)


def test_the_distribution_of_a_model_is_used_and_one_given_stands_in(one_part):
    (motor,) = one_part.parameters
    stated = replace(one_part, parameters=(replace(motor, distribution=Uniform(1e-7, 3e-7)),))
    assert propagate(stated, samples=1000).percentiles[1] == pytest.approx(2e-7, rel=1e-3)
    found = propagate(stated, samples=1000, distributions={"motor": Uniform(5e-7, 7e-7)})
    assert found.percentiles[1] == pytest.approx(6e-7, rel=1e-3)


def test_samples_above_one_are_taken_as_one_and_counted(block, component):
    model = build_model([block("a", 1, (component("motor", 0.5),))], name="m")
    found = propagate(model, distributions={"motor": Lognormal(2.0)}, samples=1000)
    # Above the median by a factor of 2: the 95th percentile is the bound.
    assert found.inputs[0].cut == 50
    assert found.percentiles[2] == pytest.approx(1.0, rel=1e-2)


def test_a_model_that_cannot_fail_has_no_spread_and_no_shares(block, component):
    model = build_model([block("a", 1, (component("motor", 0.0),))], name="m")
    found = propagate(model, distributions={"motor": Lognormal(2.0)}, samples=100)
    assert (found.mean, found.deviation, found.percentiles) == (0.0, 0.0, (0.0, 0.0, 0.0))
    assert found.inputs[0].share == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({}, "no parameter has a distribution; state it in the model, or give"),
        ({"distributions": {"x": Lognormal(3.0)}}, "no parameter 'x' in 'm'; allowed: motor"),
        ({"distributions": {"motor": Lognormal(3.0)}, "samples": 1}, "1 samples; give at least 2"),
    ],
)
def test_what_cannot_be_sampled_is_refused(one_part, arguments, message):
    with pytest.raises(ModelError, match=message):
        propagate(one_part, **arguments)


def test_ten_thousand_samples_of_the_case_study_take_less_than_a_second(case):
    given = of_each(case, Lognormal(3.0))
    propagate(case, distributions=given, samples=100)
    start = time.process_time()
    propagate(case, distributions=given)
    assert time.process_time() - start < 1.0


# shares


def lognormal(width, factor, count=10_000):
    draws = LatinHypercube(count, 5)
    columns = [draws.uniform(str(number)) for number in range(width)]
    return np.column_stack([Lognormal(factor).quantiles(each, 1.0) for each in columns])


def test_the_shares_of_a_sum_are_those_of_the_variances():
    inputs = lognormal(3, 3.0)
    weights = np.array([1.0, 2.0, 0.1])
    expected = weights**2 / (weights**2).sum()
    assert first_order_shares(inputs, inputs @ weights) == pytest.approx(expected, abs=0.02)


def test_the_shares_of_products_leave_out_what_the_inputs_do_together():
    inputs = lognormal(3, 3.0)
    sigma2 = Lognormal(3.0).sigma ** 2
    mean, variance = math.exp(sigma2 / 2), math.exp(sigma2) * math.expm1(sigma2)
    total = variance**2 + 2 * mean**2 * variance + 0.25 * variance
    expected = [mean**2 * variance / total] * 2 + [0.25 * variance / total]
    found = first_order_shares(inputs, inputs[:, 0] * inputs[:, 1] + 0.5 * inputs[:, 2])
    assert found == pytest.approx(expected, abs=0.05)


def test_shares_keep_their_size_at_1e_200_and_are_zero_without_spread():
    inputs = lognormal(2, 3.0, 1000)
    inputs[:, 1] = 1.0
    found = first_order_shares(inputs * 1e-200, inputs[:, 0] * 1e-200)
    assert found == pytest.approx([1.0, 0.0], abs=1e-9)
    assert list(first_order_shares(inputs, np.full(1000, 0.25))) == [0.0, 0.0]


def test_importing_uncertainty_needs_nothing_heavy():
    code = (
        "import sys, tracerisk.prm.questions.uncertainty, tracerisk.prm.numbers.distributions;"
        "print(sorted({'numpy', 'scipy', 'rich'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_hidden_failures_are_part_of_each_draw(block, component):
    parts = (
        component("power", 1e-3, 3, "required 2, detected mission_start"),
        component("motor", 1e-6, 2),
    )
    others = (component("power", 2e-3, 3, "required 2, detected mission_start"),)
    blocks = [
        block("a", 1, parts, after={"b": 1}),
        block("b", 2, others, after={"a": "9/10", "done": "1/10"}),
    ]
    model = build_model(blocks, name="m")
    assert model.latent
    thetas = {"power": np.array([2e-3, 1e-5, 0.3]), "motor": np.array([1e-6, 1e-2, 1e-9])}
    expected = [
        solve(
            with_values(model, {"power": float(power), "motor": float(motor)})
        ).mission.failure_probability
        for power, motor in zip(*thetas.values(), strict=True)
    ]
    assert failure_samples(model, thetas) == pytest.approx(expected, rel=1e-12)


def test_trees_that_share_events_are_drawn_too():
    tree = FaultTree(
        "top",
        (
            Gate("top", GateKind.OR, ("left", "right")),
            Gate("left", GateKind.AND, ("a", "b")),
            Gate("right", GateKind.AND, ("a", "c")),
        ),
        (BasicEvent("a"), BasicEvent("b"), BasicEvent("c")),
    )
    state = FunctionState(
        "s", 1, tree, {"a": 0.5, "b": 0.25, "c": 0.125}, (NextStep("done", Fraction(1)),)
    )
    thetas = tuple(Parameter(name, value) for name, value in state.probabilities.items())
    model = HybridModel("m", "s", (state,), thetas)
    drawn = np.array([1e-9, 0.5, 1.0])
    expected = drawn * (1 - 0.75 * 0.875)
    assert failure_samples(model, {"a": drawn}) == pytest.approx(expected, rel=1e-12)


def test_more_hidden_failures_than_are_held_count_as_failures(block, component, monkeypatch):
    parts = (component("power", 0.1, 5, "required 1, detected mission_start"),)
    blocks = [block("a", 1, parts, after={"a": "1/2", "done": "1/2"})]
    model = build_model(blocks, name="m")
    drawn = {"power": np.array([0.1, 0.2])}
    whole = failure_samples(model, drawn)
    exact = [
        solve(with_values(model, {"power": p})).mission.failure_probability for p in (0.1, 0.2)
    ]
    assert whole == pytest.approx(exact, rel=1e-12)
    monkeypatch.setattr("tracerisk.prm.questions.sampled_mission.MOST_STATES", 3)
    bound = failure_samples(model, drawn)
    assert (bound > whole).all()
    # Two failed units at most are held: three are no rarity here.
    assert (bound < 0.5).all()


def test_a_mean_above_the_point_is_reported_with_its_ratio(case_study):
    model = build_model(case_study, name="case")
    shown = [
        render_uncertainty(propagate(model, samples=2000, distributions={"gripper": law}))
        for law in (Lognormal(10.0), Lognormal(1.01))
    ]
    assert "times the point, in which" in shown[0]
    assert "times the point" not in shown[1]


def test_the_standard_error_of_the_mean_is_reported(one_part):
    found = propagate(one_part, samples=10_000, distributions={"motor": Lognormal(3.0)})
    assert found.standard_error == pytest.approx(found.deviation / 100.0, rel=1e-12)
    exact = 1e-6 * math.exp((math.log(3.0) / 1.6448536269514722) ** 2 / 2.0)
    assert abs(found.mean - exact) < 2.0 * found.standard_error
    assert found.knows_mean
    shown = render_uncertainty(found)
    assert f"standard error of {found.standard_error:.2g}" in shown
    assert "does not give the mean" not in shown


@pytest.mark.parametrize("samples", [10_000, 100_000])
def test_the_mean_of_a_heavy_tail_comes_from_the_tail(block, component, samples):
    # The mean of a pair with the error factor 30 lies beyond 4 standard deviations.
    pair = component("pair", 1e-9, 2, "true")
    model = build_model([block("a", 1, (pair,))], name="m")
    law = Lognormal(30.0)
    found = propagate(model, samples=samples, distributions={"pair": law})
    exact = 1e-18 * math.exp(2.0 * law.sigma**2)
    assert found.is_weighted
    assert found.knows_mean
    assert abs(found.mean - exact) < 3.0 * found.standard_error
    assert found.standard_error < 0.03 * exact
    assert found == propagate(model, samples=samples, distributions={"pair": law})
    shown = " ".join(render_uncertainty(found).split())
    assert "The mean lies in draws too rare" in shown
    assert "does not give the mean" not in shown


def test_a_sample_that_cannot_know_the_mean_says_so(block, component):
    # Ten tails at once are beyond draws that shift one input.
    names = [f"c{number}" for number in range(2)]
    parts = [component(name, 1e-5, 5, "required 1, detected each_visit") for name in names]
    model = build_model([block("a", 1, parts)], name="m")
    laws = dict.fromkeys(names, Lognormal(300.0))
    found = propagate(model, samples=100, distributions=laws)
    assert not found.knows_mean
    assert "does not give the mean" in " ".join(render_uncertainty(found).split())


def test_intervals_hold_percentiles_as_often_as_they_say(one_part):
    laws = {"motor": Lognormal(10.0)}
    exact = laws["motor"].quantiles(np.array([0.05, 0.5, 0.95]), 1e-6)
    random = np.random.default_rng(3)
    held = np.zeros(3)
    for _ in range(400):
        draws = laws["motor"].quantiles(random.random(200), 1e-6)
        found = intervals(draws, (5.0, 50.0, 95.0))
        held += [low <= each <= high for (low, high), each in zip(found, exact, strict=True)]
    # Of 400 with 95 % fewer than 367 are rarer than one in a thousand.
    assert (held >= 367).all()
    assert (held < 398).all()
    reported = propagate(one_part, samples=1_000, distributions=laws)
    for (low, high), middle in zip(reported.intervals, reported.percentiles, strict=True):
        assert low < middle < high
    assert "95 % from" in render_uncertainty(reported)


def test_few_draws_leave_ends_of_intervals_open():
    assert intervals(np.array([1.0, 2.0]), (5.0, 50.0)) == ((None, 2.0), (None, None))


def test_many_inputs_are_drawn_in_blocks(block, component, monkeypatch):
    parts = [component(f"c{i}", 1e-6 * (1 + 100 * (i == 3)), 1, "false") for i in range(20)]
    model = build_model([block("a", 1, parts)], name="m")
    laws = {f"c{i}": Lognormal(3.0) for i in range(20)}
    whole = propagate(model, samples=4_000, distributions=laws)
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_FITTED", 8_000)
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_DRAWN", 10_000)
    parted = propagate(model, samples=4_000, distributions=laws)
    assert parted == propagate(model, samples=4_000, distributions=laws)
    assert parted.mean == pytest.approx(whole.mean, rel=0.01)
    assert parted.percentiles == pytest.approx(whole.percentiles, rel=0.1)
    assert parted.inputs[0].name == whole.inputs[0].name == "c3"
    assert parted.inputs[0].share == pytest.approx(whole.inputs[0].share, abs=0.01)
    names = {each.name: each for each in parted.inputs}
    for each in whole.inputs:
        assert names[each.name].percentiles == pytest.approx(each.percentiles, rel=0.1)


@pytest.fixture
def drawn_in_blocks(monkeypatch):
    """Return the draws of 40 inputs, of 20 laws, in blocks of 500 of 1,200 samples."""
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_FITTED", 1_200)
    monkeypatch.setattr("tracerisk.prm.questions.draws.MOST_DRAWN", 20_000)

    def make(strata):
        monkeypatch.setattr("tracerisk.prm.questions.draws._STRATA", strata)
        laws = [Lognormal(3.0, "mean"), Lognormal(30.0), Uniform(0.0, 1.0), Beta(0.5, 20.0)]
        inputs = {
            f"c{i}": UncertainInput(0.01 * (1 + i % 3), laws[i % 4], is_probability=i != 5)
            for i in range(40)
        }
        return InputDraws(inputs, 1_200, 7)

    return make


def test_each_stratum_of_a_block_holds_one_draw(drawn_in_blocks):
    drawn = drawn_in_blocks(2_048)
    blocks = [dict(zip(*block, strict=True))["c2"].copy() for block in drawn.blocks()]
    assert [len(block) for block in blocks] == [500, 500, 200]
    for block in blocks:
        assert sorted(np.floor(block * len(block))) == list(range(len(block)))
        assert list(block) != sorted(block)
    assert len(set(np.concatenate(blocks))) == 1_200


def test_inputs_of_one_law_are_drawn_as_if_each_were_alone(drawn_in_blocks):
    # With so few strata the quantiles are taken once for a law, with so many for each input.
    for strata in (2_048, 65_536):
        drawn = drawn_in_blocks(strata)
        names, parts, cut = (), [], {}
        for names, block in drawn.blocks():  # noqa: B007 - the same each time
            parts.append(block.copy())
        values = dict(zip(names, np.concatenate(parts, axis=1), strict=True))
        cut = dict(drawn.cut)
        for name, whole in drawn.whole(list(drawn.inputs)).items():
            assert values[name] == pytest.approx(whole, rel=1e-15), name
        assert cut == drawn.cut
        assert cut["c1"] > 0 == cut["c5"]
        assert values["c1"].max() == 1.0 < values["c5"].max()


def test_draws_of_inputs_in_blocks_are_independent(drawn_in_blocks):
    drawn = drawn_in_blocks(2_048)
    ranks = np.argsort(np.argsort(list(drawn.whole(list(drawn.inputs)).values()), axis=1), axis=1)
    found = np.corrcoef(ranks)[np.triu_indices(40, 1)]
    # Of 780 pairs: the spread of a correlation of 1,200 independent draws is 1 / sqrt(1,200).
    assert found.std() == pytest.approx(1_200**-0.5, rel=0.1)
    assert abs(found.mean()) < 4 * found.std() / math.sqrt(780)


def test_few_draws_of_a_narrow_figure_know_its_mean(one_part):
    for samples in (2, 20, 100):
        assert propagate(
            one_part, samples=samples, distributions={"motor": Lognormal(3.0)}
        ).knows_mean


def test_shares_of_hundreds_of_inputs_are_not_fitted_all_together(block, component):
    # The fit takes time with the cube of the inputs.
    parts = [component(f"c{i}", 1e-6, 1, "false") for i in range(300)]
    model = build_model([block("a", 1, parts)], name="m")
    laws = {f"c{i}": Lognormal(3.0) for i in range(300)}
    found = propagate(model, samples=2_000, distributions=laws)
    exact = laws["c0"].mean(1e-6) * 300
    assert found.mean == pytest.approx(exact, rel=0.01)
    assert sum(each.share > 0.0 for each in found.inputs) <= MOST_TOGETHER
