"""Redundant groups too many for one chain: each by itself, and certified bounds of all together."""

import math
from dataclasses import replace
from random import Random

import numpy as np
import pytest

from tests.prm.hybrid.brute_force import random_mission
from tests.prm.hybrid.test_brute_force import model_of  # noqa: F401 - a fixture
from tracerisk.errors import ModelError
from tracerisk.prm import build_model, solve
from tracerisk.prm.hybrid.assessment import FIXED, GEOMETRIC
from tracerisk.prm.hybrid.chain_solver import held_bound, mission_figures, solve_mission
from tracerisk.prm.hybrid.groups.bounds import Moments, any_group
from tracerisk.prm.questions.pair_importance import pair_importances
from tracerisk.prm.questions.sampled_mission import failure_samples
from tracerisk.prm.questions.set_values import with_values

ROUNDING = 1 + 1e-12


def loop(block, component, functions, groups, p, *, back="9/10", redundancy="true", units=2):
    """Make functions in a circle, each with some of the groups in turn, the last going back."""
    onward = {"f0": back, "done": f"{int(back.split('/')[1]) - int(back.split('/')[0])}/10"}
    blocks = []
    for number in range(functions):
        parts = [component(f"motor{number}", 1e-6, 1, "false")]
        parts += [
            component(f"g{group}", p * (1 + group % 3), units, redundancy)
            for group in range(groups)
            if (group - number) % functions < 2
        ]
        after = {f"f{number + 1}": "1"} if number + 1 < functions else onward
        blocks.append(block(f"f{number}", number + 1, parts, after=after))
    return build_model(blocks, name="m")


def readings(model):
    """The model with geometric and, where `next` may be counts, with fixed cycles."""
    return replace(model, counted=False), replace(model, counted=True)


@pytest.mark.parametrize("p", [1e-12, 1e-6, 1e-3, 0.02, 0.3, 1.0])
@pytest.mark.parametrize(
    ("redundancy", "units"),
    [("true", 2), ("required 2", 3), ("true, spare cold", 2), ("true, common_cause 0.1", 2)],
)
def test_the_bound_holds_the_figure_of_all_states(block, component, p, redundancy, units):
    model = loop(block, component, 4, 4, min(p, 1 / 3), redundancy=redundancy, units=units)
    for each in readings(model):
        exact, solved = solve_mission(each), solve_mission(each, limit=4)
        assert exact.states.most is None
        assert solved.grouped is not None
        (reading, whole), (same, bound) = held_bound(each, exact), held_bound(each, solved)
        assert reading == same == (FIXED if each.counted else GEOMETRIC)
        assert bound.least <= whole.outcome.p * ROUNDING
        assert whole.outcome.p <= bound.outcome.p * ROUNDING
        assert bound.outcome.p + bound.outcome.q == pytest.approx(1, rel=1e-12)
        figures, wholes = mission_figures(each, solved), mission_figures(each, exact)
        for name in ("cycle_failure_probability", "fixed_cycles", "geometric_cycles"):
            assert getattr(wholes, name) <= getattr(figures, name) * ROUNDING, name
        assert figures.visits_as_run == pytest.approx(wholes.visits_as_run, rel=1e-12)
        if each.counted:
            # How often each function is visited is certain, so that nothing is left open.
            assert bound.outcome.p == pytest.approx(whole.outcome.p, rel=1e-12)
            assert bound.least == pytest.approx(whole.outcome.p, rel=1e-12)


def bounded(model):
    """Return the bound and the exact figure of a model, where groups can be taken apart."""
    solved = solve_mission(model, limit=1)
    if solved.grouped is None:
        return None
    _, bound = held_bound(model, solved)
    _, exact = held_bound(model, solve_mission(model, limit=40_000))
    return bound, exact.outcome.p


def random_bounds(made, seeds):
    """Return how many random missions were bounded; each bound holds its figure."""
    found = 0
    for seed in seeds:
        mission = random_mission(Random(seed))
        if not any(mission.uses.values()):
            continue
        pair = bounded(made(mission))
        if pair is not None:
            bound, exact = pair
            assert bound.least <= exact * ROUNDING, seed
            assert exact <= bound.outcome.p * ROUNDING, seed
            found += 1
    return found


def test_the_bound_holds_random_missions(model_of):  # noqa: F811
    assert random_bounds(model_of, range(400)) > 40


@pytest.mark.slow
def test_the_bound_holds_many_random_missions(model_of):  # noqa: F811
    assert random_bounds(model_of, range(10_000, 20_000)) > 1_000


def test_groups_on_parts_of_the_path_that_know_nothing_of_each_other_are_exact(block, component):
    # Two loops one after the other, a group in each.
    blocks = [
        block(f"f{i}", i, [component(f"g{i}", 0.1, 2, "true")], after=after)
        for i, after in ((1, {"f1": "4/5", "f2": "1/5"}), (2, {"f2": "2/3", "done": "1/3"}))
    ]
    model = build_model(blocks, name="m")
    bound, exact = bounded(model)
    assert (bound.least, bound.outcome.p) == pytest.approx((exact, exact), rel=1e-13)


def test_groups_on_branches_of_which_one_is_taken_add_up(block, component):
    blocks = [
        block("fork", 1, [], after={"left": "1/2", "right": "1/2"}),
        block("left", 2, [component("x", 0.1, 2, "true")], after={"done": "1"}),
        block("right", 3, [component("y", 0.1, 2, "true")], after={"done": "1"}),
    ]
    bound, exact = bounded(build_model(blocks, name="m"))
    assert exact == pytest.approx(0.01, rel=1e-12)
    assert bound.least <= exact * ROUNDING
    assert exact <= bound.outcome.p * ROUNDING


def test_the_bounds_hold_every_distribution_of_few_paths():
    random = Random(1)
    for _ in range(3_000):
        groups, scale = random.randint(2, 5), 10 ** random.uniform(-4, 0)
        weights = [random.random() ** 3 for _ in range(random.randint(1, 4))]
        weights = [weight / math.fsum(weights) for weight in weights]
        paths = [
            [scale * random.random() ** random.choice((1, 6)) for _ in range(groups)]
            for _ in weights
        ]

        def mean(of, weights=weights, paths=paths):
            return math.fsum(w * of(path) for w, path in zip(weights, paths, strict=True))

        exact = 1 - mean(lambda path: math.prod(1 - f for f in path))
        moments = [
            Moments(first, first, mean(lambda path, g=g: path[g] ** 2))
            for g in range(groups)
            for first in [mean(lambda path, g=g: path[g])]
        ]
        found = any_group(moments, is_certain=False)
        assert found.least - 1e-14 <= exact <= found.most + 1e-14


def test_a_hundred_pairs_are_bounded_closely_and_have_importances(block, component):
    model = loop(block, component, 25, 100, 1e-5)
    found = solve(model)
    (reported,) = [each for each in found.assumptions if "100 redundant groups" in each]
    low, high = (float(each) for each in reported.split("between ")[1].split(",")[0].split(" and "))
    assert high == pytest.approx(found.mission.failure_probability, rel=1e-6)
    assert (high - low) / low < 1e-3
    assert math.fsum(each.absorption_probability for each in found.states) == pytest.approx(
        found.mission.failure_probability, rel=1e-12
    )


def test_importances_of_groups_by_themselves_are_near_those_of_all(block, component):
    model = loop(block, component, 3, 5, 1e-5)
    whole = {each.name: each for each in solve(model).components}
    for each in solve(model, limit=4).components:
        measures = ("birnbaum", "criticality", "fussell_vesely", "risk_reduction_worth", "tenfold")
        for measure in (*measures, "risk_achievement_worth", "without"):
            assert getattr(each, measure) == pytest.approx(
                getattr(whole[each.name], measure), rel=1e-3
            ), (each.name, measure)
    parts = {(s.name, c.name): c for s in solve(model).states for c in s.components}
    for state in solve(model, limit=4).states:
        for part in state.components:
            expected = parts[state.name, part.name].contribution
            assert part.contribution == pytest.approx(expected, rel=1e-3)


def test_importances_of_pairs_are_refused_where_groups_are_solved_by_themselves(block, component):
    with pytest.raises(ModelError, match="redundant groups are too many"):
        pair_importances(loop(block, component, 50, 60, 1e-5))


def test_samples_of_many_groups_follow_the_bound(block, component):
    model = loop(block, component, 10, 40, 1e-4)
    drawn = {"g0": np.array([1e-4, 1e-3, 1e-2]), "motor3": np.array([1e-6, 1e-5, 1e-3])}
    found = failure_samples(model, drawn)
    for number, sample in enumerate(found):
        each = with_values(model, {name: float(of[number]) for name, of in drawn.items()})
        assert solve_mission(each).grouped is not None
        bound = solve_mission(each)
        assert bound.least * (1 - 1e-12) <= sample
        assert sample == pytest.approx(bound.failure.p, rel=1e-3)
