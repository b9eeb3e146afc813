"""How far what follows failures may be off: against scipy's beta and Dirichlet distributions."""

from fractions import Fraction

import numpy as np
import pytest
import scipy  # whose statistics, which take a second, are imported when they are used

from tracerisk.prm import HybridModel
from tracerisk.prm.hybrid.elements import DONE, Fate, FunctionState, NextStep, Parameter
from tracerisk.prm.hybrid.fates.ends import UNNOTICED
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.prm.numbers.distributions import Lognormal
from tracerisk.prm.questions.draws import InputDraws
from tracerisk.prm.questions.fate_draws import FateDraws
from tracerisk.prm.questions.uncertainty import propagate
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

LEVELS = np.array([0.05, 0.5, 0.95])
COUNTED = (("stopped_safely", 12), ("stopped_late", 3), ("unaware", 5))
SAMPLES = 20_000


def fates_of(counts, of=None):
    whole = of or sum(count for _, count in counts)
    return tuple(
        Fate(kind, Fraction(count, whole), "f0" if kind == "back" else "")
        for kind, count in counts
        if count
    )


def model_of(*functions):
    """Functions one after the other, each with p of the grip and what follows."""
    states = []
    for number, (p, fates) in enumerate(functions):
        name, last = f"f{number}", number + 1 == len(functions)
        tree = FaultTree(
            f"{name} fails",
            (Gate(f"{name} fails", GateKind.OR, ("grip",)),),
            (BasicEvent("grip", "grip", component="grip"),),
        )
        steps = (NextStep(DONE if last else f"f{number + 1}", Fraction(1)),)
        states.append(
            FunctionState(name, number + 1, tree, {"grip": p}, steps, fates={"grip": fates})
        )
    greatest = max(p for p, _ in functions)
    return HybridModel("m", "f0", tuple(states), (Parameter("grip", greatest),))


def test_the_undetected_failure_has_the_interval_of_the_fractions():
    model = model_of((1e-6, fates_of(COUNTED)))
    found = propagate(model, samples=SAMPLES, outcomes={"grip": 20.0})
    expected = 1e-6 * scipy.stats.beta.ppf(LEVELS, 3.5 + 5.5, 12.5)
    assert found.undetected == pytest.approx(expected, rel=5e-3)
    # Where nothing leads back, the mission fails as often in every draw.
    assert found.percentiles == pytest.approx([1e-6] * 3, rel=1e-9)
    assert sum(item.share for item in found.undetected_inputs) == pytest.approx(1.0, abs=0.01)


def test_the_shares_are_those_of_a_dirichlet_distribution():
    model = model_of((1e-6, fates_of((*COUNTED, ("back", 4)))))
    draws = FateDraws(model, {"grip": 24.0})
    values = InputDraws(draws.inputs, SAMPLES, 3).whole(tuple(draws.inputs))
    row = draws.shares(values)["f0"]["grip"]
    shares = {way.kind: np.broadcast_to(share, SAMPLES) for way, share in row.items()}
    law = scipy.stats.dirichlet([5.5, 3.5, 4.5, 12.5])
    kinds = ("unaware", "stopped_late", "back", "stopped_safely")
    drawn = np.stack([shares[kind] for kind in kinds])
    assert drawn.sum(axis=0) == pytest.approx(np.ones(SAMPLES))
    assert drawn.mean(axis=1) == pytest.approx(law.mean(), rel=5e-3)
    assert np.cov(drawn) == pytest.approx(law.cov(), abs=3e-4)


def test_both_figures_take_part_where_failures_lead_back():
    model = model_of((1e-6, fates_of((("back", 15), ("unaware", 5)))))
    found = propagate(model, samples=SAMPLES, outcomes={"grip": 20.0})
    fails = 1e-6 * scipy.stats.beta.ppf(LEVELS, 5.5 + 0.5 + 0.5, 15.5)
    assert found.percentiles == pytest.approx(fails, rel=1.5e-2)


def test_over_a_mission_the_shares_are_those_drawn_however_functions_differ():
    functions = (
        (2e-6, fates_of((("stopped_safely", 6),))),
        (1e-6, fates_of((("stopped_late", 1), ("unaware", 2)))),
        (4e-6, fates_of((("stopped_safely", 6), ("unaware", 3), ("stopped_late", 3)))),
    )
    model = model_of(*functions)
    draws = FateDraws(model, {"grip": 21.0})
    values = InputDraws(draws.inputs, 500, 3).whole(tuple(draws.inputs))
    rows = draws.shares(values)
    unaware = sum(
        p / 7e-6 * rows[f"f{number}"]["grip"][UNNOTICED] for number, (p, _) in enumerate(functions)
    )
    (name, *_) = draws.inputs
    assert unaware == pytest.approx(values[name], rel=1e-5)
    for row in (rows[f"f{number}"]["grip"] for number in range(3)):
        assert all(np.all((share >= 0.0) & (share <= 1.0)) for share in row.values())


def test_the_interval_stays_where_a_function_is_divided():
    counted = fates_of((("stopped_safely", 6), ("unaware", 4)))
    whole = model_of((3e-6, counted), (1e-6, fates_of((("unaware", 1),))))
    parted = model_of((1e-6, counted), (2e-6, counted), (1e-6, fates_of((("unaware", 1),))))
    one, other = (
        propagate(model, samples=2_000, outcomes={"grip": 30.0}).undetected
        for model in (whole, parted)
    )
    assert other == pytest.approx(one, rel=1e-5)


def test_what_no_fate_is_known_of_stays_undetected_in_every_draw():
    model = model_of((1e-6, fates_of(COUNTED, of=40)))
    found = propagate(model, samples=SAMPLES, outcomes={"grip": 20.0})
    expected = 1e-6 * (0.5 + 0.5 * scipy.stats.beta.ppf(LEVELS, 9.0, 12.5))
    assert found.undetected == pytest.approx(expected, rel=5e-3)


def test_figures_and_fractions_are_drawn_together():
    model = model_of((1e-6, fates_of(COUNTED)))
    law = {"grip": Lognormal(3.0)}
    alone = propagate(model, samples=SAMPLES, distributions=law)
    both = propagate(model, samples=SAMPLES, distributions=law, outcomes={"grip": 20.0})
    assert both.percentiles == alone.percentiles
    assert both.undetected[2] / both.undetected[0] > 1.1 * alone.undetected[2] / alone.undetected[0]
    assert solve_figures(model).mission.undetected_geometric == pytest.approx(4e-7)
