"""Which failures a campaign tries: by the hazard, by a seed, and so that the table has no gap."""

import random

import numpy as np
import pytest

from tracerisk.common.evidence.cells import Cell
from tracerisk.common.evidence.share_interval import clopper_pearson, weighted_interval
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.traced.elements import Exposure
from tracerisk.pipeline.evidence.campaign import (
    LEAST_IN_BATCH,
    MOST_IN_BATCH,
    batch_sizes,
    shared_sizes,
)
from tracerisk.pipeline.evidence.draw import LEAST_DRAWN, LEAST_IN_TABLE, Target, draw_cells
from tracerisk.pipeline.evidence.unit_use import UnitUse
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

STEP_S = 0.002
STEPS = 5000
PICK, PLACE = FunctionRef("cell.py", "pick"), FunctionRef("cell.py", "place")


def trace():
    """Two visits of five seconds each."""
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "the controller ended", STEPS * STEP_S),
        elements=(),
        functions=(TracedFunction(PICK, 1, 1), TracedFunction(PLACE, 5, 2)),
        visits=(
            Visit(PICK, 0.0, 5.0, "succeeded", {}),
            Visit(PLACE, 5.0, 5.0, "succeeded", {}),
        ),
    )


def unit(name="joint_1", begin=1000, end=3000):
    """A unit that moves for one stretch of steps and is idle else."""
    moving = np.zeros(STEPS, dtype=bool)
    moving[begin:end] = True
    none = np.zeros(STEPS, dtype=bool)
    owner = np.repeat([0, 1], STEPS // 2)
    return UnitUse(
        name, moving, (moving, none, none), owner, STEP_S, lambda steps: moved(moving & steps)
    )


def moved(flags):
    seconds = float(flags.sum()) * STEP_S
    return Exposure(moving_s=seconds, active_s=seconds)


def drawn(cells, *targets, seed=0):
    uses = {each.unit: unit(each.unit) for each in targets}
    return draw_cells(targets, uses, trace(), cells=cells, seed=seed)


DEAD = Target("motor", "joint_1", "dead", hazard=1e-6)


def test_cells_are_drawn_while_the_unit_is_in_use():
    cells = [each for each in drawn(50, DEAD) if each.drawn]
    assert len(cells) == 50
    assert {each.use for each in cells} == {"moving"}
    assert all(2.0 <= each.time_s < 6.0 for each in cells)
    assert {each.function for each in cells} == {"pick", "place"}
    assert len({each.key for each in cells}) == 50


def test_a_cell_says_how_long_the_unit_was_in_use_before():
    for each in drawn(20, DEAD):
        if each.drawn:
            assert each.active_s == pytest.approx(each.time_s - 2.0)
            assert each.states_s == (each.active_s, 0.0, 0.0)


def test_the_same_seed_draws_the_same_and_more_cells_begin_with_fewer():
    few = [each for each in drawn(20, DEAD) if each.drawn]
    many = [each for each in drawn(60, DEAD) if each.drawn]
    assert [each.key for each in many[:20]] == [each.key for each in few]
    assert drawn(20, DEAD) == drawn(20, DEAD)
    assert [c.key for c in drawn(20, DEAD, seed=1)] != [c.key for c in drawn(20, DEAD)]


def test_drawn_cells_stand_for_all_of_the_use_between_them():
    cells = [each for each in drawn(30, DEAD) if each.drawn]
    assert sum(each.stretch.moving_s for each in cells) == pytest.approx(4.0)
    ordered = sorted(cells, key=lambda each: each.time_s)
    between = (ordered[2].time_s - ordered[0].time_s) / 2.0
    assert ordered[1].stretch.active_s == pytest.approx(between, abs=2 * STEP_S)


def test_cells_are_shared_by_hazard_with_a_least_number():
    jam = Target("motor", "joint_2", "jam", hazard=9e-6)
    rare = Target("motor", "joint_3", "dead", hazard=1e-12)
    cells = [each for each in drawn(109, DEAD, jam, rare) if each.drawn]
    counts = {name: sum(1 for c in cells if c.unit == name) for name in ("joint_1", "joint_2")}
    assert len(cells) == 109
    assert counts == {"joint_1": LEAST_DRAWN + 10, "joint_2": LEAST_DRAWN + 90}
    assert sum(1 for c in cells if c.unit == "joint_3") == LEAST_DRAWN


def test_an_idle_hazard_is_drawn_from_the_idle_time():
    target = Target("motor", "joint_1", "dead", hazard=1e-6, idle_hazard=1e-6)
    cells = [each for each in drawn(40, target) if each.drawn]
    idle = [each for each in cells if each.is_idle]
    assert len(idle) == 20
    assert not any(2.0 <= each.time_s < 6.0 for each in idle)
    assert sum(each.idle_s for each in idle) == pytest.approx(6.0)


def test_the_table_has_instants_of_each_component_mode_and_function():
    late = unit("joint_1", 4000, 4800)
    cells = draw_cells([DEAD], {"joint_1": late}, trace(), cells=3, seed=0)
    for name in ("pick", "place"):
        assert sum(1 for each in cells if each.function == name) >= LEAST_IN_TABLE
    assert {each.use for each in cells if each.function == "pick"} == {"idle"}


def test_units_of_one_component_share_its_table():
    targets = [Target("motor", f"joint_{i}", "dead", hazard=1e-6) for i in range(1, 8)]
    uses = {each.unit: unit(each.unit) for each in targets}
    cells = draw_cells(targets, uses, trace(), cells=21, seed=0)
    assert sum(1 for each in cells if not each.drawn) <= 2 * LEAST_IN_TABLE


def test_a_unit_that_is_never_in_use_has_cells_of_the_table_alone():
    idle = unit("joint_1", 0, 0)
    cells = draw_cells([DEAD], {"joint_1": idle}, trace(), cells=10, seed=0)
    assert cells
    assert not any(each.drawn for each in cells)


def test_the_interval_is_that_of_clopper_and_pearson():
    # Table values: 90 % two-sided, that is 5 % on each side.
    low, high = clopper_pearson(2, 10)
    assert (low, high) == (pytest.approx(0.036771, abs=1e-6), pytest.approx(0.506901, abs=1e-6))
    assert clopper_pearson(0, 10)[0] == 0.0
    assert clopper_pearson(0, 10)[1] == pytest.approx(1 - 0.05**0.1)
    assert clopper_pearson(10, 10) == (pytest.approx(0.05**0.1), 1.0)
    assert clopper_pearson(0, 0) == (0.0, 1.0)


def test_equal_strata_have_the_interval_of_their_sum():
    assert weighted_interval([(1.0, 3, 10), (1.0, 5, 10)]) == (
        pytest.approx(0.4),
        pytest.approx(clopper_pearson(8, 20)),
    )


def ends_mission(time_s):
    """A program whose c is known by exhaustion: it fails at three instants of four, or so."""
    return (time_s * 7.0) % 1.0 < 0.7


@pytest.mark.parametrize(
    "number", [50, *(pytest.param(each, marks=pytest.mark.slow) for each in (100, 300))]
)
def test_two_hundred_campaigns_hold_the_known_share_as_often_as_they_say(number):
    known = np.mean([ends_mission(round(s * STEP_S, 6)) for s in range(1000, 3000)])
    held = 0
    for seed in range(200):
        cells: list[Cell] = [c for c in drawn(number, DEAD, seed=seed) if c.drawn]
        failed = sum(ends_mission(c.time_s) for c in cells)
        low, high = clopper_pearson(failed, len(cells))
        held += low <= known <= high
    assert 0.86 <= held / 200 <= 0.94, held


def test_the_stream_of_one_unit_does_not_hang_on_the_others():
    other = Target("motor", "joint_2", "dead", hazard=1e-6)
    alone = [c for c in drawn(20, DEAD) if c.drawn]
    both = [c for c in drawn(40, other, DEAD) if c.drawn and c.unit == "joint_1"]
    keys = [[each.key for each in cells] for cells in (alone, both)]
    assert keys[0][: len(keys[1])] == keys[1][: len(keys[0])]
    assert random.Random("0:joint_1:dead:use").random() != random.Random("0:joint_2").random()


@pytest.mark.parametrize(
    ("number", "workers"), [(0, 2), (1, 2), (5, 2), (30, 2), (445, 2), (445, 1), (445, 64)]
)
def test_batches_hold_every_cell_and_get_smaller(number, workers):
    sizes = batch_sizes(number, workers)
    assert sum(sizes) == number
    assert all(1 <= each <= MOST_IN_BATCH for each in sizes)
    assert sizes == sorted(sizes, reverse=True) or sizes[-1] <= LEAST_IN_BATCH
    assert len(sizes) >= min(number, workers)


@pytest.mark.parametrize(("number", "workers"), [(0, 2), (1, 2), (138, 2), (445, 2), (445, 1)])
def test_what_workers_share_is_cut_into_equal_parts(number, workers):
    sizes = shared_sizes(number, workers)
    assert sum(sizes) == number
    assert max(sizes, default=0) - min(sizes, default=0) <= 1
    assert all(each <= MOST_IN_BATCH * workers for each in sizes)
