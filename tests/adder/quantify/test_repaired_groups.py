"""Groups under repair, against exact rationals and matrix exponentials over all sets of units."""

import itertools
import math
import random
from decimal import Decimal
from fractions import Fraction

import pytest

from tests.slow import slow_but_every
from tracerisk.adder.quantify.function_use import FunctionUse
from tracerisk.adder.quantify.groups import group_unit_probabilities
from tracerisk.adder.quantify.outcome import Outcome, after, with_digits
from tracerisk.adder.quantify.repaired_groups import Renewal, repaired_group
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.errors import HardwareError

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")
repaired = with_digits(repaired_group)


def drawn(rng):
    """Hazards of two to four units, a redundancy, and the repairs in the time of a mission."""
    quantity = rng.randint(2, 4)
    hazards = [10.0 ** rng.uniform(-7, 0.5) for _ in range(quantity)]
    if rng.random() < 0.3:
        hazards = hazards[:1] * quantity
    redundancy = Redundancy(
        True,
        required=rng.randint(1, quantity - 1),
        dormancy=rng.choice([1.0, 0.0, 0.3]),
        switch=rng.choice([0.0, 0.0, 0.02]),
    )
    return hazards, redundancy, 10.0 ** rng.uniform(-3, 2.5)


def brute_force(hazards, redundancy, repairs, *, in_mission):
    """The share of missions that fail, in 80 digits: 1 over their mean number until one does."""
    quantity, required = len(hazards), redundancy.required
    sets = [
        frozenset(failed)
        for count in range(quantity - required + 1)
        for failed in itertools.combinations(range(quantity), count)
    ]
    place = {failed: number for number, failed in enumerate(sets)}
    lost = len(sets)
    with mpmath.workdps(80):
        generator = mpmath.matrix(lost + 1, lost + 1)

        def add(source, target, rate):
            generator[source, target] += rate
            generator[source, source] -= rate

        for failed in sets:
            sound = [unit for unit in range(quantity) if unit not in failed]
            for unit in sound[:required]:
                rate = mpmath.mpf(hazards[unit])
                if len(sound) == required:
                    add(place[failed], lost, rate)
                    continue
                switch = mpmath.mpf(redundancy.switch)
                add(place[failed], place[failed | {unit}], rate * (1 - switch))
                add(place[failed], lost, rate * switch)
            for unit in sound[required:]:
                rate = mpmath.mpf(hazards[unit]) * mpmath.mpf(redundancy.dormancy)
                add(place[failed], place[failed | {unit}], rate)
            for unit in failed if in_mission else ():
                add(place[failed], place[failed - {unit}], mpmath.mpf(repairs))
        mission = mpmath.expm(generator, method="taylor")
        back = 1 - mpmath.exp(-mpmath.mpf(repairs))
        matrix = mpmath.eye(lost)
        for before in sets:
            for now in sets:
                share = mission[place[before], place[now]]
                if in_mission:
                    matrix[place[before], place[now]] -= share
                    continue
                for kept in (kept for kept in sets if kept <= before):
                    if not before <= now:
                        continue
                    chance = back ** len(before - kept) * (1 - back) ** len(kept)
                    matrix[place[before], place[kept | (now - before)]] -= share * chance
        missions = mpmath.lu_solve(matrix, mpmath.ones(lost, 1))
        return 1 / missions[place[frozenset()], 0]


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("in_mission", [False, True])
@pytest.mark.parametrize("seed", slow_but_every(50, range(1000)))
def test_random_groups_fail_as_by_all_sets_of_failed_units(seed, in_mission):
    hazards, redundancy, repairs = drawn(random.Random(seed))
    own = [after(Decimal(hazard)) for hazard in hazards]
    found = repaired(own, redundancy, repairs, in_mission=in_mission)
    share = brute_force(hazards, redundancy, repairs, in_mission=in_mission)
    assert float(found.p) == pytest.approx(float(share), rel=1e-13, abs=0)
    assert float(found.q) == pytest.approx(float(1 - share), rel=1e-13, abs=0)


def test_a_pair_fails_as_by_hand():
    """The chain of two states in rationals: p in a mission, r to be back for the next but one."""
    p, r = Fraction(1, 100), Fraction(1, 4)
    q = 1 - p
    # From all sound: one fails with 2pq and is missing in the next mission at least. With one
    # missing: the other fails with p; else the first is back with r.
    # m0 = 1 + q^2 m0 + 2pq m1; m1 = 1 + q (r m0 + (1 - r) m1).
    b = 1 - q * (1 - r)
    m0 = (1 + 2 * p * q / b) / (1 - q * q - 2 * p * q * q * r / b)
    repairs = -math.log1p(-0.25)
    found = repaired(
        [Outcome(Decimal("0.01"), Decimal("0.99"))] * 2, Redundancy(True), repairs, in_mission=False
    )
    assert float(found.p) == pytest.approx(float(1 / m0), rel=1e-13)


def test_a_slow_repair_is_worse_and_one_within_missions_better():
    own = [after(Decimal("1e-3"))] * 3
    redundancy = Redundancy(True, required=2)
    shares = [
        repaired(own, redundancy, repairs, in_mission=False).p for repairs in (0.01, 0.1, 1.0, 50.0)
    ]
    assert shares == sorted(shares, reverse=True)
    for repairs in (0.01, 0.1, 1.0, 50.0):
        within = repaired(own, redundancy, repairs, in_mission=True).p
        assert within < repaired(own, redundancy, repairs, in_mission=False).p
    # Without repair within a mission, but whole at its begin: between these two.
    alone = 3 * (1 - math.exp(-1e-3)) ** 2 * math.exp(-1e-3) + (1 - math.exp(-1e-3)) ** 3
    assert within < alone < shares[-1]


@pytest.mark.slow(but=10)
@pytest.mark.parametrize("in_mission", [False, True])
@pytest.mark.parametrize(
    "redundancy",
    [Redundancy(True), Redundancy(True, 2), Redundancy(True, dormancy=0.0, switch=0.1)],
)
@pytest.mark.parametrize("seed", range(5))
def test_cutting_a_function_in_pieces_moves_no_figure_of_the_mission(seed, redundancy, in_mission):
    """The sum of a group's hazards stays, however the visits of a mission are cut into functions."""
    rng = random.Random(seed)
    renewal = Renewal(repair=rng.choice([0.02, 0.5, 30.0]), in_mission=in_mission)
    rows = [[10.0 ** rng.uniform(-6, -2) for _ in range(3)] for _ in range(6)]

    def hazard(cuts):
        parts = [rows[low:high] for low, high in itertools.pairwise((0, *cuts, len(rows)))]
        functions = [FunctionUse(part, len(part)) for part in parts]
        values = group_unit_probabilities(functions, redundancy, renewal)
        return math.fsum(-len(part) * math.log1p(-p) for part, p in zip(parts, values, strict=True))

    whole = hazard(())
    # A visit may be cut, too.
    first = [-math.log1p(-p) for p in rows[0]]
    rows[0:1] = [[-math.expm1(-h * part) for h in first] for part in (0.2, 0.5, 0.3)]
    for cuts in ((1,), (3,), (2, 5), (1, 2, 3, 4, 5, 6, 7)):
        assert hazard(cuts) == pytest.approx(whole, rel=1e-12)


@pytest.mark.parametrize("in_mission", [False, True])
def test_the_value_gives_like_units_the_hazard_of_the_mean_mission(in_mission):
    renewal = Renewal(repair=0.5, in_mission=in_mission)
    (p,) = group_unit_probabilities([FunctionUse([[1e-3, 1e-3]], 1)], Redundancy(True), renewal)
    share = brute_force([-math.log1p(-1e-3)] * 2, Redundancy(True), 0.5, in_mission=in_mission)
    assert p * p == pytest.approx(float(share), rel=1e-12)


@pytest.mark.parametrize("in_mission", [False, True])
def test_a_unit_that_never_fails_keeps_its_group(in_mission):
    own = [after(Decimal(1)), after(Decimal(0))]
    assert repaired(own, Redundancy(True), 0.1, in_mission=in_mission).p == 0


def test_too_many_units_that_differ_are_refused():
    own = [after(Decimal(number) / 1000) for number in range(1, 8)]
    with pytest.raises(HardwareError, match="7 units are too many to follow with repair; allowed"):
        repaired(own, Redundancy(True), 1.0, in_mission=False)
    like = repaired([after(Decimal("1e-3"))] * 63, Redundancy(True, 60), 1.0, in_mission=True)
    assert 0 < like.p < 1
