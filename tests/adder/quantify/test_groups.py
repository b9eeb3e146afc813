"""The equivalence of a block's one value with the unlike units it stands for.

The oracle multiplies out every outcome with rationals, or with 80 digits where a chain in
continuous time has none.
"""

import itertools
import math
from fractions import Fraction

import mpmath
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from tracerisk.adder.quantify.function_use import FunctionUse
from tracerisk.adder.quantify.groups import group_unit_probabilities
from tracerisk.adder.quantify.instance_shares import instance_shares
from tracerisk.common.hardware.redundancy import ALL_NEEDED, Redundancy
from tracerisk.errors import HardwareError

TOLERANCE = 1e-14

# Spread over the orders of magnitude, as the figures of components are.
probabilities = st.one_of(
    st.floats(-20.0, math.log10(0.9)).map(lambda power: 10.0**power),
    st.floats(0.01, 0.9),
    st.sampled_from([1e-20, 1e-8, 0.5, 0.9]),
)
shares = st.sampled_from([0.0, 0.0, 0.1, 0.37, 1.0])
detections = st.sampled_from(["mission_start", "each_visit"])


@st.composite
def groups(draw, *, spares=False):
    """Draw the visits of some units and the redundancy of their group."""
    units = draw(st.integers(1, 4))
    visits = draw(
        st.lists(st.lists(probabilities, min_size=units, max_size=units), min_size=1, max_size=4)
    )
    required = draw(st.integers(1, units))
    beta = draw(shares)
    if spares:
        dormancy, switch = draw(st.sampled_from([0.0, 0.2, 1.0])), draw(shares)
        assume(dormancy < 1.0 or switch > 0.0)
        return visits, Redundancy(True, required, beta, dormancy, switch, draw(detections))
    if draw(st.booleans()):
        return visits, Redundancy(True, required, beta, detected=draw(detections))
    return visits, ALL_NEEDED


def gate_failure(ps, redundancy):
    """Return the failure probability of a gate by every outcome of its units, as a rational."""
    threshold = len(ps) - redundancy.required + 1 if redundancy else 1
    total = Fraction(0)
    for failed in itertools.product((False, True), repeat=len(ps)):
        if sum(failed) >= threshold:
            total += math.prod(p if f else 1 - p for p, f in zip(ps, failed, strict=True))
    return total


def failure_over_visits(visits, redundancy):
    """Return the failure probability over the visits, as a rational: see docs/theory.md#groups."""
    exact = [[Fraction(p) for p in units] for units in visits]
    beta = Fraction(redundancy.common_cause) if redundancy and len(visits[0]) > 1 else Fraction(0)
    own = [[(1 - beta) * p for p in units] for units in exact]
    common = [1 - beta * sum(units) / len(units) for units in exact]
    if redundancy and redundancy.detected == "mission_start":
        ends = [1 - math.prod(1 - p for p in unit) for unit in zip(*own, strict=True)]
        return 1 - (1 - gate_failure(ends, redundancy)) * math.prod(common)
    alive = math.prod(1 - gate_failure(units, redundancy) for units in own)
    return 1 - alive * math.prod(common)


def group_unit_probability(visits, redundancy):
    """Return the value of a mission which has these visits and no others."""
    return group_unit_probabilities([FunctionUse(visits, len(visits))], redundancy)[0]


def relative_error(found, expected):
    return float(abs(Fraction(found) / expected - 1))


@given(groups())
@example(([[1e-20, 0.9, 1e-20, 0.9]] * 3, Redundancy(True, 1)))
@example(([[1e-20, 0.9, 1e-20, 1e-8]] * 2, Redundancy(True, 2, 0.1)))
@example(([[0.9, 0.9, 0.9, 0.89]] * 4, Redundancy(True, 2, 0.1, detected="each_visit")))
def test_like_units_at_the_groups_value_fail_as_the_unlike_units_do(group):
    visits, redundancy = group
    value = group_unit_probability(visits, redundancy)
    like = [[value] * len(visits[0])] * len(visits)
    expected = failure_over_visits(visits, redundancy)
    assert relative_error(failure_over_visits(like, redundancy), expected) < TOLERANCE


def spares_failure(hazards, redundancy):
    """Return the failure probability of spares with these hazards, from the matrix of their chain."""
    units, required = len(hazards), redundancy.required
    states = [s for s in range(2**units) if s.bit_count() <= units - required]
    rates = mpmath.matrix(len(states) + 1)
    for number, state in enumerate(states):
        sound = [u for u in range(units) if not state >> u & 1]
        for place, unit in enumerate(sound):
            target, works = state | 1 << unit, place < required
            rate = hazards[unit] * (1 if works else mpmath.mpf(redundancy.dormancy))
            kept = mpmath.mpf(1)
            if works:
                kept = 1 - mpmath.mpf(redundancy.switch) if len(sound) > required else 0
            if kept:
                rates[number, states.index(target)] += rate * kept
            rates[number, len(states)] += rate * (1 - kept)
            rates[number, number] -= rate
    return mpmath.expm(rates, method="taylor")[0, len(states)]


def spares_over_visits(visits, redundancy):
    alive = mpmath.mpf(1)
    beta = mpmath.mpf(redundancy.common_cause)
    hazards = []
    for units in visits:
        exact = [mpmath.mpf(p) for p in units]
        hazards.append([-mpmath.log1p(-(1 - beta) * p) for p in exact])
        alive *= 1 - beta * mpmath.fsum(exact) / len(exact)
    if redundancy.detected == "mission_start":
        hazards = [[mpmath.fsum(column) for column in zip(*hazards, strict=True)]]
    for each in hazards:
        alive *= 1 - spares_failure(each, redundancy)
    return 1 - alive


@settings(max_examples=6, deadline=None)
@given(groups(spares=True))
@example(([[1e-20, 0.9, 1e-12]], Redundancy(True, 1, 0.0, 0.0)))
@example(([[1e-20, 1e-18], [1e-12, 0.9]], Redundancy(True, 1, 0.0, 0.2, 0.1)))
def test_like_spares_at_the_groups_value_fail_as_the_unlike_ones_do(group):
    visits, redundancy = group
    assume(len(visits[0]) > 1)
    value = group_unit_probability(visits, redundancy)
    with mpmath.workdps(200):
        like = spares_over_visits([[value] * len(visits[0])] * len(visits), redundancy)
        expected = spares_over_visits(visits, redundancy)
        assert float(abs(like / expected - 1)) < TOLERANCE


@given(groups(), st.integers(1, 4))
def test_units_that_are_alike_give_back_their_probability(group, visits):
    drawn, redundancy = group
    like = [[drawn[0][0]] * len(drawn[0])] * visits
    assert group_unit_probability(like, redundancy) == drawn[0][0]


@pytest.mark.parametrize(
    "redundancy",
    [
        ALL_NEEDED,
        Redundancy(True),
        Redundancy(True, 2),
        Redundancy(True, 2, 0.1),
        Redundancy(True, detected="each_visit"),
        Redundancy(True, 1, 0.0, 0.0),
        Redundancy(True, 2, 0.2, 0.1, 0.5),
    ],
)
def test_a_group_that_never_or_surely_fails_keeps_that(redundancy):
    assert group_unit_probability([[0.0, 0.0, 0.0]] * 2, redundancy) == 0.0
    assert group_unit_probability([[1.0, 1.0, 1.0]] * 2, redundancy) == 1.0
    if not redundancy.common_cause:
        assert group_unit_probability([[1.0, 1.0, 1.0], [0.5, 0.1, 0.2]], redundancy) == 1.0


def test_a_group_at_rest_has_no_negative_zero():
    assert math.copysign(1.0, group_unit_probability([[0.0, 0.0], [-0.0, 0.0]], ALL_NEEDED)) == 1.0
    (one, _) = instance_shares([FunctionUse([[0.0, 0.1]], 1)], ALL_NEEDED)
    assert math.copysign(1.0, one.p_failure) == 1.0


def test_a_pair_of_which_one_unit_never_fails_does_not_fail():
    assert group_unit_probability([[0.0, 0.1], [0.0, 0.2]], Redundancy(True)) == 0.0
    each_visit = Redundancy(True, detected="each_visit")
    assert group_unit_probability([[0.0, 0.1], [0.3, 0.0]], each_visit) == 0.0
    cold = Redundancy(True, dormancy=0.0)
    assert group_unit_probability([[0.1, 0.0]], cold) == 0.0


def test_a_unit_that_surely_fails_leaves_the_group_to_the_others():
    assert group_unit_probability([[1.0, 0.25]], Redundancy(True)) == pytest.approx(0.5, rel=1e-15)
    cold = Redundancy(True, dormancy=0.0)
    value = group_unit_probability([[1.0, 0.25]], cold)
    hazard = -math.log1p(-value)
    # The first unit fails at once, and the second serves all the time.
    assert 1 - math.exp(-hazard) * (1 + hazard) == pytest.approx(0.25, rel=1e-14)
    switched = Redundancy(True, dormancy=0.0, switch=1.0)
    assert group_unit_probability([[1.0, 0.25]], switched) == 1.0


def test_a_hidden_pair_used_in_turns_fails_as_the_mission_does():
    # A function that uses the one unit, then one that uses the other: neither could fail alone.
    first, second = FunctionUse([[1e-6, 0.0]], 1), FunctionUse([[0.0, 1e-6]], 1)
    a, b = group_unit_probabilities([first, second], Redundancy(True))
    assert a == b
    assert (1 - (1 - Fraction(a)) * (1 - Fraction(b))) ** 2 == pytest.approx(1e-12, rel=1e-14)


def test_functions_share_a_hidden_groups_hazard_by_what_each_adds_to_it():
    # The pair's failure is the product of both hazards, so each unit has half of its logarithm:
    # all of the first unit's half is used in the one function, and half of the second's in either.
    first, second = FunctionUse([[1e-9, 0.5e-12]], 1), FunctionUse([[0.0, 0.5e-12]], 1)
    a, b = group_unit_probabilities([first, second], Redundancy(True))
    assert a / b == pytest.approx(3.0, rel=1e-8)
    assert (a + b) ** 2 == pytest.approx(1e-21, rel=1e-8)


@given(st.lists(groups(), min_size=1, max_size=3), st.lists(st.integers(1, 9), min_size=3))
def test_functions_share_the_hazard_of_a_hidden_group_over_the_mission(drawn, times):
    units = min(len(visits[0]) for visits, _ in drawn)
    redundancy = Redundancy(True, max(1, units - 1))
    assume(units > 1 and redundancy.required < units)
    functions = [
        FunctionUse([row[:units] for row in visits[:1]], count)
        for (visits, _), count in zip(drawn, times, strict=False)
    ]
    values = group_unit_probabilities(functions, redundancy)
    unlike, like = [], []
    for each, value in zip(functions, values, strict=True):
        unlike += each.visits * each.times
        like += [[value] * units] * each.times
    expected = failure_over_visits(unlike, redundancy)
    assert relative_error(failure_over_visits(like, redundancy), expected) < TOLERANCE


def halves(units):
    """Return the probabilities of each half of a visit."""
    return [-math.expm1(math.log1p(-p) / 2) for p in units]


@pytest.mark.parametrize(
    "redundancy",
    [
        ALL_NEEDED,
        Redundancy(True),
        Redundancy(True, 2),
        Redundancy(True, 1, 0.1),
        Redundancy(True, dormancy=0.0),
        Redundancy(True, 2, 0.0, 0.3, 0.1),
        Redundancy(True, 1, 0.1, 0.2),
    ],
)
def test_cutting_visits_moves_no_figure(redundancy):
    visits = [[1e-7, 3e-6, 2e-9], [4e-8, 1e-7, 1e-6]]
    cut = [halves(units) for units in visits for _ in range(2)]
    whole = group_unit_probability(visits, redundancy)
    part = group_unit_probability(cut, redundancy)
    # What is left of it is the share of a common cause, which is one of p and not of the hazard.
    tolerance = 1e-12 if not redundancy.common_cause else 1e-6
    assert -math.expm1(2 * math.log1p(-part)) == pytest.approx(whole, rel=tolerance)


@pytest.mark.parametrize(
    "redundancy",
    [
        ALL_NEEDED,
        Redundancy(True),
        Redundancy(True, 2),
        Redundancy(True, dormancy=0.0),
        Redundancy(True, 2, 0.0, 0.3, 0.1),
    ],
)
def test_cutting_a_function_in_two_moves_no_figure_of_the_mission(redundancy):
    first, second, third = [1e-3, 3e-2, 2e-5], [4e-2, 1e-7, 1e-3], [0.0, 0.0, 5e-3]
    whole = group_unit_probabilities(
        [FunctionUse([first, second], 2), FunctionUse([third], 3)], redundancy
    )
    cut = group_unit_probabilities(
        [FunctionUse([first], 1), FunctionUse([second], 1), FunctionUse([third], 3)], redundancy
    )
    hazard = [-math.log1p(-p) for p in whole]
    parts = [-math.log1p(-p) for p in cut]
    assert 2 * hazard[0] + 3 * hazard[1] == pytest.approx(
        parts[0] + parts[1] + 3 * parts[2], rel=1e-12
    )


def test_the_shares_of_units_in_series_are_those_of_their_hazards():
    function = FunctionUse([[1e-6, 3e-6], [1e-6, 5e-6]], 4)
    one, other = instance_shares([function], ALL_NEEDED)
    assert (one.p_failure, other.p_failure) == pytest.approx((4e-6, 16e-6), rel=1e-5)
    assert (one.share, other.share) == pytest.approx((0.2, 0.8), rel=1e-5)
    assert one.fussell_vesely == pytest.approx(one.share, rel=1e-12)


def test_each_unit_of_a_pair_has_the_whole_of_its_failures_and_half_the_share():
    shares = instance_shares([FunctionUse([[1e-6, 3e-3]], 1)], Redundancy(True))
    assert [each.fussell_vesely for each in shares] == [1.0, 1.0]
    assert [each.share for each in shares] == [0.5, 0.5]


def test_units_that_never_fail_have_no_share():
    shares = instance_shares([FunctionUse([[0.0, 0.0]], 1)], ALL_NEEDED)
    assert [each.share for each in shares] == [0.0, 0.0]


def test_spares_too_many_to_follow_are_an_error():
    units = [1e-3 * (number + 1) for number in range(14)]
    with pytest.raises(HardwareError, match="14 spares that differ are too many to follow"):
        group_unit_probability([units], Redundancy(True, dormancy=0.5))
