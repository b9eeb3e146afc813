"""Failure models against mpmath, against formulas on paper and against SCRAM."""

import math
import re
import shutil
import subprocess
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError
from tracerisk.prm import BasicEvent, FaultTree, Gate, GateKind
from tracerisk.prm.trees.failure_models import (
    GLM,
    Constant,
    Erlang,
    Exponential,
    Lognormal,
    PerDemand,
    PeriodicTest,
    Weibull,
)

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")

TINY = (1e-20, 1e-12, 1e-6, 1e-2, 1.0, 50.0)


@pytest.fixture(autouse=True)
def _forty_digits():
    with mpmath.workdps(40):
        yield


def assert_pair(found, p, rel=4e-15):
    """Both halves agree, each relative to itself."""
    assert found.p == pytest.approx(float(p), rel=rel, abs=0)
    assert found.q == pytest.approx(float(1 - p), rel=rel, abs=0)


def test_a_constant_is_the_same_for_every_mission():
    assert Constant(1e-20).probability(0.0) == Constant(1e-20).probability(1e4) == (1e-20, 1.0)


@pytest.mark.parametrize("hazard", TINY)
def test_an_exponential_keeps_its_digits_when_rare(hazard):
    rate = hazard / 8760
    assert_pair(Exponential(rate).probability(8760), 1 - mpmath.exp(-mpmath.mpf(rate) * 8760))


def test_an_erlang_law_of_many_events_or_phases_takes_no_time_for_each():
    assert Erlang(1e12, 3).probability(1e6) == (1.0, 0.0)
    assert Erlang(1e-9, 10_000).probability(1.0) == (0.0, 1.0)


@pytest.mark.slow(but=8)
@pytest.mark.parametrize("phases", [1, 2, 7, 900, 9000])
@pytest.mark.parametrize("mean", [1e-7, 1e-2, 3.3, 40.0, 1000.0])
def test_an_erlang_law_counts_poisson_events(phases, mean):
    found = Erlang(mean / 100, phases).probability(100.0)
    exact = mpmath.mpf(mean / 100) * 100
    with mpmath.workdps(600):
        p = mpmath.gammainc(phases, 0, exact, regularized=True)
        q = mpmath.gammainc(phases, exact, mpmath.inf, regularized=True)
    assert found.p == pytest.approx(float(p), rel=2e-13, abs=1e-300)
    assert found.q == pytest.approx(float(q), rel=2e-13, abs=1e-300)


@pytest.mark.parametrize("hours", [1e-3, 1.0, 1e4, 1e9])
def test_a_lognormal_law_keeps_both_tails(hours):
    found = Lognormal(9.0, 1.5).probability(hours)
    score = (mpmath.log(mpmath.mpf(hours)) - 9) / mpmath.mpf(1.5) / mpmath.sqrt(2)
    assert found.p == pytest.approx(float(mpmath.erfc(-score) / 2), rel=1e-13, abs=0)
    assert found.q == pytest.approx(float(mpmath.erfc(score) / 2), rel=1e-13, abs=0)
    assert Lognormal(9.0, 1.5).probability(0.0) == (0.0, 1.0)


def weibull(scale, shape, location, age, mission):
    scale, shape, location, age, mission = map(mpmath.mpf, (scale, shape, location, age, mission))

    def hazard(x):
        return ((x - location) / scale) ** shape if x > location else mpmath.mpf(0)

    return -mpmath.expm1(hazard(age) - hazard(age + mission))


@pytest.mark.parametrize("mission", [1e-9, 0.1, 500, 2e4])
@pytest.mark.parametrize(
    ("scale", "shape", "location", "age"),
    [
        (1e4, 1.0, 0, 0),
        (1e4, 2.5, 0, 0),
        (1e4, 2.5, 0, 7e3),
        (1e6, 0.5, 0, 1e5),
        (1e9, 3.0, 100, 1e3),
        (1e4, 1.5, 1e3, 200),
    ],
)
def test_a_weibull_law_is_conditional_on_the_age(scale, shape, location, age, mission):
    found = Weibull(scale, shape, location, age).probability(mission)
    assert_pair(found, weibull(scale, shape, location, age, mission), rel=2e-14)


def test_a_weibull_law_does_not_lose_what_its_location_nearly_cancels():
    found = Weibull(1.0, 1.0, 0.3, 0.1).probability(0.2 + 1e-16)
    exposed = mpmath.mpf(0.1) + mpmath.mpf(0.2 + 1e-16) - mpmath.mpf(0.3)
    assert exposed > 0
    assert_pair(found, -mpmath.expm1(-exposed))


def glm(gamma, failing, repaired, mission):
    gamma, failing, repaired, mission = map(mpmath.mpf, (gamma, failing, repaired, mission))
    rate = failing + repaired
    if rate == 0:
        return gamma
    return (failing - (failing - gamma * rate) * mpmath.exp(-rate * mission)) / rate


@given(
    st.sampled_from((0.0, 1e-20, 1e-3, 0.4, 1.0)),
    st.sampled_from((0.0, 1e-20, 1e-9, 1e-3, 0.1)),
    st.sampled_from((0.0, 1e-20, 1e-3, 0.1)),
    st.sampled_from((0.0, 1e-6, 1.0, 8760.0)),
)
def test_the_glm_law_has_no_difference(gamma, failing, repaired, mission):
    with mpmath.workdps(40):
        expected = glm(gamma, failing, repaired, mission)
    assert_pair(GLM(gamma, failing, repaired).probability(mission), expected, rel=1e-14)


@pytest.mark.parametrize("demands", [0, 1, 2, 1000])
@pytest.mark.parametrize("p", [0.0, 1e-20, 1e-5, 0.5, 1.0])
def test_demands_are_independent(p, demands):
    found = PerDemand(p, demands).probability(1.0)
    none = (1 - mpmath.mpf(p)) ** demands
    assert found.p == pytest.approx(float(1 - none), rel=1e-15, abs=0)
    assert found.q == pytest.approx(float(none), rel=1e-12, abs=0)


def phases(test, mission):
    """The phases of the mission of a tested unit: length, rate, and what happens after each."""
    yield min(mission, test.first_test_h), test.rate, True, None
    left = mission - test.first_test_h
    while left > 0:
        yield 0, test.rate, True, "break"
        if left <= test.test_duration_h:
            yield left, test.rate_in_test, test.available_in_test, None
            return
        yield test.test_duration_h, test.rate_in_test, test.available_in_test, "find"
        left -= test.test_duration_h
        waiting = test.interval_h - test.test_duration_h
        yield min(left, waiting), test.rate, True, None
        left -= waiting


def follow(test, mission):
    """Follow a tested unit phase by phase, by matrix exponentials.

    States: good, hidden, in repair, good again after a repair in the present phase, hidden since
    then (which the present test does not find), and the hours up.
    """
    chances = mpmath.matrix([[1, 0, 0, 0, 0, 0]])
    exponentials = {}
    down = mpmath.mpf(0)
    for length, rate, serves, event in phases(test, mission):
        rate, usual, mu, bad = map(
            mpmath.mpf, (rate, test.rate, test.repair_rate, test.bad_restart)
        )
        generator = mpmath.matrix(6, 6)
        generator[0, 0], generator[0, 1] = -rate, rate
        generator[2, 2], generator[2, 3], generator[2, 4] = -mu, (1 - bad) * mu, bad * mu
        generator[3, 3], generator[3, 4] = -usual, usual
        generator[0, 5], generator[3, 5] = int(serves), 1
        phase = (length, rate, serves)
        if phase not in exponentials:
            exponentials[phase] = mpmath.expm(generator * mpmath.mpf(length))
        chances = chances * exponentials[phase]
        good, hidden, repair, again, fresh, hours_up = chances
        down = hidden + repair + fresh + (0 if serves else good)
        if event == "find":
            found = hidden * mpmath.mpf(test.detection)
            hidden, repair = hidden - found, repair + found
        good, hidden = good + again, hidden + fresh
        if event == "break":
            broken = good * mpmath.mpf(test.failure_at_test)
            good, hidden = good - broken, hidden + broken
        chances = mpmath.matrix([[good, hidden, repair, 0, 0, hours_up]])
    return down, 1 - chances[5] / mpmath.mpf(mission)


TESTED = [
    PeriodicTest(1e-12, 720, 100, 0.05),
    PeriodicTest(7e-4, 720, 100, 4e-4),
    PeriodicTest(7e-4, 720, 100, 7e-4),
    PeriodicTest(1e-9, 720, 0, 1e-9),
    PeriodicTest(1e-4, 720, 0, 0.0),
    PeriodicTest(7e-4, 720, 300, 4e-4, 6e-4, 0.01, 20, True, 0.9, 0.01),
    PeriodicTest(7e-4, 720, 300, 4e-4, 6e-4, 0.01, 200, False, 0.9, 0.01),
    PeriodicTest(0.0, 720, 300, 0.1, 0.0, 1e-9, 20, True, 0.5, 0.3),
    PeriodicTest(1e-9, 720, 0, 0.02, 1e-7, 0.0, 24, False, 1.0, 0.0),
]


@pytest.mark.slow(but=12)
@pytest.mark.parametrize("mission", [50.0, 1500.0, 5100.5, 5150.0])
@pytest.mark.parametrize("test", TESTED, ids=range(len(TESTED)))
def test_a_tested_unit_follows_its_markov_chain(test, mission):
    down, mean = follow(test, mission)
    assert_pair(test.probability(mission), down, rel=1e-12)
    assert_pair(replace(test, averaged=True).probability(mission), mean, rel=1e-12)


@pytest.mark.parametrize("mission", [500.0, 2200.0, 1e5])
def test_repair_in_no_time_is_the_limit_of_fast_repair(mission):
    at_once = PeriodicTest(1e-5, 720, 100, math.inf, 1e-5, 0.1, 24, True, 0.9, 0.01)
    for averaged in (False, True):
        found = replace(at_once, averaged=averaged).probability(mission)
        fast = replace(at_once, averaged=averaged, repair_rate=1e9).probability(mission)
        assert found.p == pytest.approx(fast.p, rel=1e-6)


def test_a_thousand_periods_keep_their_digits():
    test = TESTED[5]
    mission = test.first_test_h + 1000 * test.interval_h + 13.0
    down, mean = follow(test, mission)
    assert_pair(test.probability(mission), down, rel=1e-12)
    assert_pair(replace(test, averaged=True).probability(mission), mean, rel=1e-12)


def test_many_periods_are_taken_at_once():
    found = PeriodicTest(1e-10, 1.0, 0, 1e-3).probability(1e6)
    # After a long time: the rate into the repair of 1000 h, and half an hour hidden.
    assert found.p == pytest.approx(1e-10 * (1000 + 0.5), rel=1e-3)
    assert found.p + found.q == pytest.approx(1.0, rel=1e-12)


def test_the_end_at_a_test_is_the_moment_before_it():
    # 0.6000000000000001 is a whole number of intervals only within rounding.
    before = PeriodicTest(1e-3, 0.2, 0.0).probability(0.6000000000000001)
    assert before.p == pytest.approx(-math.expm1(-2e-4), rel=1e-12)
    assert PeriodicTest(1e-3, 720.0, 720.0).probability(720.0).p == pytest.approx(
        -math.expm1(-0.72), rel=1e-15
    )


def test_the_mean_of_a_tested_unit_is_that_of_iec_61508():
    """IEC 61508-6, B.3.2.2.1: rate (interval / 2 + mean time to restore)."""
    mean = PeriodicTest(1e-8, 8760, 8760, 1 / 8, averaged=True).probability(876000).p
    assert mean == pytest.approx(1e-8 * (8760 / 2 + 8), rel=1e-3)


def test_a_mission_of_no_length_finds_the_unit_up():
    assert PeriodicTest(1.0, 1.0, averaged=True).probability(0.0) == (0.0, 1.0)
    assert PeriodicTest(1.0, 1.0).probability(0.0) == (0.0, 1.0)


def test_a_tree_takes_its_values_from_the_models():
    tree = FaultTree(
        "top",
        (Gate("top", GateKind.AND, ("a", "b")),),
        (BasicEvent("a", model=Exponential(1e-12)), BasicEvent("b", model=Constant(1e-9))),
    )
    found = tree.probability(tree.values_at(1000.0))
    assert found.p == pytest.approx(1e-18, rel=1e-8)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Constant(1.5), "p is 1.5; allowed: 0 to 1"),
        (lambda: Constant(math.nan), "p is nan; allowed: 0 to 1"),
        (lambda: Exponential(-1.0), "rate is -1.0 1/h; allowed: 0 or more, finite"),
        (lambda: Exponential(math.inf), "rate is inf 1/h; allowed: 0 or more, finite"),
        (lambda: Weibull(0.0, 1.0), "scale_h is 0.0 h; allowed: above 0, finite"),
        (lambda: Weibull(1.0, -1.0), "shape is -1.0; allowed: above 0, finite"),
        (lambda: Weibull(1.0, 1.0, age_h=-1.0), "age_h is -1.0 h; allowed: 0 or more"),
        (lambda: Erlang(1e-3, 10**9), "1000000000 phases; allowed: 1 to 10000"),
        (lambda: Erlang(1e-3, 0), "phases is 0; allowed: whole numbers from 1 on"),
        (lambda: Lognormal(1.0, 0.0), "deviation is 0.0; allowed: above 0, finite"),
        (lambda: GLM(2.0, 0.0, 0.0), "failure_on_demand is 2.0; allowed: 0 to 1"),
        (lambda: PerDemand(0.1, -1), "demands is -1; allowed: whole numbers from 0 on"),
        (lambda: PerDemand(0.1, 1.5), "demands is 1.5; allowed: whole numbers from 0 on"),
        (lambda: PeriodicTest(1e-3, 0.0), "interval_h is 0.0 h; allowed: above 0"),
        (
            lambda: PeriodicTest(1e-3, 10.0, test_duration_h=11.0),
            "test_duration_h is 11.0 h, longer than the interval of 10.0 h between tests",
        ),
        (
            lambda: PeriodicTest.of_open_psa((1.0, 2.0)),
            "a periodic test with 3 arguments; allowed: 4, 5 or 11",
        ),
        (lambda: Constant(0.1).probability(-1.0), "the mission time is -1.0 h; allowed: 0 or more"),
    ],
)
def test_figures_outside_their_ranges_are_refused(make, message):
    with pytest.raises(ModelError, match=re.escape(message)):
        make()


OPEN_PSA = {
    "exponential": ((3e-5,), Exponential(3e-5)),
    "Weibull": ((9e3, 1.7, 500), Weibull(9e3, 1.7, 500)),
    "GLM": ((0.02, 1e-4, 3e-3), GLM(0.02, 1e-4, 3e-3)),
    "periodic-test": [
        (7e-4, 120, 4740),
        (7e-4, 4020, 4740),
        (7e-4, 4e-4, 110, 4740),
        (7e-4, 4e-4, 2010, 4740),
        (7e-4, 7e-4, 110, 4740),
        (7e-4, 6e-4, 4e-4, 110, 4740, 0.01, 20, 1, 0.9, 0.01),
        (7e-4, 6e-4, 4e-4, 110, 4740, 0.01, 20, 0, 0.9, 0.01),
        (7e-4, 6e-4, 4e-4, 131, 4740, 0.1, 100, 0, 0.9, 0.2),
        (7e-4, 6e-4, 4e-4, 131, 4740, 0.1, 100, 1, 0.9, 0.2),
    ],
}


@pytest.mark.skipif(shutil.which("scram") is None, reason="SCRAM is not installed")
def test_scram_agrees_on_its_built_ins(tmp_path):
    cases = [(name, *OPEN_PSA[name]) for name in ("exponential", "Weibull", "GLM")]
    cases += [
        ("periodic-test", arguments, PeriodicTest.of_open_psa(arguments))
        for arguments in OPEN_PSA["periodic-test"]
    ]
    trees, events = [], []
    for number, (name, arguments, _) in enumerate(cases):
        trees.append(
            f'<define-fault-tree name="T{number}"><define-gate name="G{number}">'
            f'<or><basic-event name="E{number}"/><basic-event name="Z"/></or>'
            "</define-gate></define-fault-tree>"
        )
        values = "".join(
            f'<bool value="{"true" if value else "false"}"/>'
            if len(arguments) == 10 and position == 7
            else f'<float value="{value}"/>'
            for position, value in enumerate(arguments)
        )
        events.append(
            f'<define-basic-event name="E{number}"><{name}>{values}<system-mission-time/></{name}>'
            "</define-basic-event>"
        )
    events.append('<define-basic-event name="Z"><float value="0"/></define-basic-event>')
    model = tmp_path / "model.xml"
    model.write_text(
        f"<opsa-mef>{''.join(trees)}<model-data>{''.join(events)}</model-data></opsa-mef>"
    )
    command = ["scram", "--bdd", "--probability", "1", "--mission-time", "8760", str(model)]
    report = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    found = re.findall(r'<sum-of-products name="(\w+)"[^>]*probability="([^"]+)"', report)
    assert len(found) == len(cases)
    by_gate = dict(found)
    for number, (_, arguments, model_here) in enumerate(cases):
        ours = model_here.probability(8760.0).p
        assert ours == pytest.approx(float(by_gate[f"G{number}"]), rel=1e-5), arguments
