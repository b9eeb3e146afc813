"""How the code is cut into functions is no risk: whatever the redundancy, the mission stays."""

import math
from fractions import Fraction

import pytest

from tests.slow import slow_but
from tracerisk.prm import build_model, solve
from tracerisk.prm.hybrid.assessment import RENEWED_REDUNDANCY, RENEWED_SPARES
from tracerisk.prm.hybrid.solve import solve_figures

KEPT = [
    (1, "false"),
    (3, "false"),
    (2, "true"),
    (3, "required 2"),
    (5, "required 3"),
    (2, "true, spare hot"),
    (2, "true, spare cold"),
    (4, "true, spare cold"),
    (4, "required 2, spare cold"),
    (2, "true, spare warm 0.5"),
    (2, "true, spare warm 0.999"),
    (5, "required 3, spare warm 0.1"),
    (2, "true, spare cold, switch 0.01"),
    (3, "true, spare hot, switch 0.2"),
    (4, "required 2, spare warm 0.3, switch 0.05"),
    (2, "true, spare cold, switch 1"),
    (3, "required 3, spare cold"),
]
SHARED = [
    (2, "true, common_cause 0.1"),
    (4, "required 2, common_cause 0.5"),
    (2, "true, spare cold, common_cause 0.1"),
    (3, "true, spare warm 0.2, switch 0.1, common_cause 0.05"),
]
RENEWED = [
    (2, "true, detected each_visit"),
    (3, "required 2, detected each_visit"),
    (2, "true, common_cause 0.1, detected each_visit"),
    (3, "true, spare cold, detected each_visit"),
    (2, "true, spare warm 0.5, switch 0.1, detected each_visit"),
]
CUTS = (2, 10, 50)


def piece(p: float, count: int) -> float:
    """Return what a unit fails with in one of so many pieces of an exposure."""
    return -math.expm1(math.log1p(-p) / count)


@pytest.fixture
def mission(block, component):
    """Return the figures of a component's mission, its function cut into so many."""

    def make(p, quantity, redundancy, count=1, cycles=1, others=()):
        blocks = []
        for number in range(count):
            parts = [
                component(name, piece(each, count), units, kind)
                for name, each, units, kind in (("unit", p, quantity, redundancy), *others)
            ]
            after = {f"f{number + 1}": 1}
            if number + 1 == count:
                again = {"f0": Fraction(cycles - 1, cycles)} if cycles > 1 else {}
                after = {**again, "done": Fraction(1, cycles)}
            blocks.append(block(f"f{number}", number + 1, parts, after=after))
        return solve_figures(build_model(blocks, name="m")).mission

    return make


def readings(figures):
    return (figures.failure_probability, figures.fixed_cycles, figures.visits_as_run)


@pytest.mark.parametrize("p", slow_but((1e-9, 0.4), (1e-9, 1e-6, 1e-2, 0.4, 0.999)))
@pytest.mark.parametrize(("quantity", "redundancy"), KEPT)
def test_cutting_a_function_leaves_the_mission(mission, p, quantity, redundancy):
    whole = readings(mission(p, quantity, redundancy))
    for count in CUTS:
        assert readings(mission(p, quantity, redundancy, count)) == pytest.approx(whole, rel=1e-11)


@pytest.mark.parametrize("p", [1e-6, 1e-2, 0.2])
@pytest.mark.parametrize(("quantity", "redundancy"), KEPT)
def test_cutting_a_loop_leaves_the_mission(mission, p, quantity, redundancy):
    whole = readings(mission(p, quantity, redundancy, cycles=20))
    for count in (2, 10):
        cut = readings(mission(p, quantity, redundancy, count, cycles=20))
        assert cut == pytest.approx(whole, rel=1e-11)


@pytest.mark.parametrize("p", [1e-6, 1e-4, 1e-2])
@pytest.mark.parametrize("cycles", [1, 20])
@pytest.mark.parametrize(("quantity", "redundancy"), SHARED)
def test_a_common_cause_depends_on_the_cut_by_the_order_of_p(
    mission, p, cycles, quantity, redundancy
):
    # It is a share of the probability, and not of the hazard.
    whole = mission(p, quantity, redundancy, cycles=cycles).failure_probability
    for count in CUTS[: 3 if cycles == 1 else 1]:
        cut = mission(p, quantity, redundancy, count, cycles).failure_probability
        assert cut == pytest.approx(whole, rel=p)


@pytest.mark.parametrize("p", [1e-6, 1e-2])
def test_groups_of_every_kind_side_by_side_do_as_well(mission, p):
    others = (
        ("cold", p, 3, "true, spare cold, switch 0.1"),
        ("pair", p / 2, 2, "true"),
        ("motor", p / 100, 7, "false"),
    )
    whole = mission(p, 4, "required 2, spare warm 0.3", 1, 20, others)
    cut = mission(p, 4, "required 2, spare warm 0.3", 2, 20, others)
    assert readings(cut) == pytest.approx(readings(whole), rel=1e-11)


@pytest.mark.parametrize("p", [1e-6, 1e-2, 0.3])
@pytest.mark.parametrize(("quantity", "redundancy"), RENEWED)
def test_groups_renewed_at_each_visit_are_inspected_as_often_as_the_code_is_cut(
    mission, p, quantity, redundancy
):
    # By declaration each piece begins with a whole group: the cut adds inspections.
    for count in CUTS:
        one = mission(piece(p, count), quantity, redundancy).failure_probability
        cut = mission(p, quantity, redundancy, count).failure_probability
        assert cut == pytest.approx(-math.expm1(count * math.log1p(-one)), rel=1e-11)


@pytest.mark.parametrize(("quantity", "redundancy"), RENEWED)
def test_that_the_cut_counts_for_renewed_groups_is_said(block, component, quantity, redundancy):
    part = component("unit", 1e-3, quantity, redundancy)
    assumptions = solve(build_model([block("f", 1, [part])], name="m")).assumptions
    assert RENEWED_REDUNDANCY in assumptions or RENEWED_SPARES in assumptions
    assert all("how the code is divided" in each for each in assumptions)


@pytest.mark.parametrize("p", slow_but((1e-6,), (1e-6, 1e-2, 0.5)))
@pytest.mark.parametrize(("quantity", "required"), [(2, 1), (3, 2), (4, 2)])
def test_there_is_no_jump_as_spares_become_hot(mission, p, quantity, required):
    for count in (1, 50):
        active = mission(p, quantity, f"required {required}", count).failure_probability
        hot = mission(p, quantity, f"required {required}, spare warm 1", count)
        assert hot.failure_probability == active
        for rest in (1e-3, 1e-6, 1e-9):
            warm = mission(p, quantity, f"required {required}, spare warm {1 - rest!r}", count)
            assert warm.failure_probability == pytest.approx(active, rel=quantity * rest)
        # Nearly no switch, which keeps the group one of spares.
        near = mission(p, quantity, f"required {required}, spare hot, switch 1e-15", count)
        assert near.failure_probability == pytest.approx(active, rel=1e-8)
