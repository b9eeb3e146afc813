"""What of a hazard ends the mission: additive however visits are cut, and never lowered unasked."""

import itertools
from dataclasses import replace

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.quantify import evidence_shares
from tracerisk.adder.quantify.component_activity import component_use
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.evidence.share_interval import clopper_pearson
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.binding import bind
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    TwinBinding,
)
from tracerisk.common.hardware.redundancy import Redundancy
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit


@pytest.fixture(autouse=True)
def few_cells_are_enough(monkeypatch):
    monkeypatch.setattr(evidence_shares, "LEAST_OF_UNIT", 1)


RATE = FailureFigure("failure_rate", 3.6e-3, Basis.HOUR)
"""1e-6 a second."""
MOTOR = Component("motor", (RATE,), twin=TwinBinding(joints=("joint_1",)))


def trace(*seconds):
    """A run of one function a visit, in which `joint_1` moves all the time."""
    starts = [sum(seconds[:i]) for i in range(len(seconds))]
    refs = [FunctionRef("cell.py", f"step_{i}") for i in range(len(seconds))]
    visits = tuple(
        Visit(ref, at, s, "succeeded", {"joint_1": moved(s)})
        for ref, at, s in zip(refs, starts, seconds, strict=True)
    )
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "", sum(seconds)),
        elements=(Element("joint_1", "joint"),),
        functions=tuple(TracedFunction(ref, 1, i + 1) for i, ref in enumerate(refs)),
        visits=visits,
    )


def moved(seconds):
    return Exposure(
        moving_s=seconds, active_s=seconds, longest_moving_s=seconds, longest_active_s=seconds
    )


def moved_and(starts, seconds=5.0):
    return replace(moved(seconds), starts=starts)


def cell(at, fails, **more):
    base = Cell("motor", "joint_1", "dead", at, "moving", "step_0", True, at, (at, 0.0, 0.0))
    return replace(base, fails=fails, **more)


def stretches(cells, whole_s=10.0):
    """The cells of one unit and mode, each with the stretch for which it stands."""
    ordered = sorted(cells, key=lambda each: each.active_s)
    between = [(a.active_s + b.active_s) / 2 for a, b in itertools.pairwise(ordered)]
    bounds = [0.0, *between, whole_s]
    return [
        replace(each, stretch=moved(high - low))
        for each, (low, high) in zip(ordered, itertools.pairwise(bounds), strict=True)
    ]


def evidence(*cells, success=("tube at its goal",), declared=None):
    return Evidence(
        fingerprint="f",
        robot="panda",
        seed=0,
        declared=len(cells) if declared is None else declared,
        success=tuple(success),
        cells=tuple(placed(cells)),
    )


def placed(cells):
    of = {}
    for each in cells:
        of.setdefault((each.unit, each.mode, each.use), []).append(each)
    for key, same in of.items():
        yield from same if key[2] == "idle" else stretches(same)


FAILS_EARLY = evidence(cell(1.0, True), cell(3.0, True), cell(7.0, False), cell(9.0, False))
"""Cells at 1, 3, 7 and 9 s: up to 5 s the mission ends, from then on it does not."""


def hazards(found, component, *seconds):
    run = trace(*seconds)
    (bound,) = bind(Hardware("h.yaml", (component,)), run.elements)
    used = component_use(bound, run, "moving+holding", EvidenceShares(found))
    return [row[0] for row in used.hazards(range(len(seconds)))]


def test_each_cell_stands_for_the_stretch_around_it():
    assert hazards(FAILS_EARLY, MOTOR, 2.0, 4.0, 4.0) == pytest.approx([2e-6, 3e-6, 0.0])


@pytest.mark.parametrize("cut", [(10.0,), (5.0, 5.0), (1.0, 2.5, 0.5, 6.0), (0.1,) * 100])
def test_the_sum_does_not_change_however_visits_are_cut(cut):
    assert sum(hazards(FAILS_EARLY, MOTOR, *cut)) == pytest.approx(5e-6, rel=1e-12)


@pytest.mark.parametrize(
    "found",
    [
        replace(FAILS_EARLY, success=()),
        replace(FAILS_EARLY, declared=5),
        evidence(cell(1.0, False, drawn=False), declared=0),
        evidence(cell(1.0, False, unit="joint_2")),
    ],
    ids=["no success", "not complete", "of the table alone", "of another unit"],
)
def test_what_is_not_shown_counts_in_full(found):
    assert sum(hazards(found, MOTOR, 4.0, 6.0)) == pytest.approx(1e-5, rel=1e-12)


@pytest.mark.parametrize(
    ("before", "counted"), [(0.5, 0.5), (0.3, 0.3), (0.9, 0.9), (0.0, 0.5), (1.0, 0.5)]
)
def test_a_share_stays_as_it_was_while_it_lies_in_the_interval(before, counted):
    found = replace(FAILS_EARLY, before={("joint_1", "dead", False): before})
    assert sum(hazards(found, MOTOR, 2.0, 4.0, 4.0)) == pytest.approx(1e-5 * counted)


def test_what_is_kept_of_a_share_follows_the_exposure():
    found = replace(FAILS_EARLY, before={("joint_1", "dead", False): 0.4})
    longer = replace(found, cells=tuple(placed(found.cells)))
    assert sum(hazards(longer, MOTOR, 20.0)) == pytest.approx(2e-5 * 0.4)


def test_without_modes_the_worst_fault_counts():
    found = evidence(
        cell(2.0, False),
        cell(8.0, True),
        cell(4.0, True, mode="jam"),
        cell(8.0, False, mode="jam"),
    )
    assert hazards(found, MOTOR, 10.0) == pytest.approx([6e-6])


def test_load_and_demands_within_a_stretch_are_those_of_the_stretch():
    # Grasps come at the end of the visit alone, where failures end the mission.
    demand = FailureFigure("probability", 1e-6, Basis.DEMAND, demand="start")
    motor = replace(MOTOR, figures=(demand,))
    one = replace(moved(5.0), starts=0)
    found = evidence(cell(2.5, False), cell(7.5, True))
    cells = (replace(found.cells[0], stretch=one), replace(found.cells[1], stretch=moved_and(4)))
    run = trace(10.0)
    visit = replace(run.visits[0], exposures={"joint_1": moved_and(4, 10.0)})
    run = replace(run, visits=(visit,))
    (bound,) = bind(Hardware("h.yaml", (motor,)), run.elements)
    shares = EvidenceShares(replace(found, cells=cells))
    used = component_use(bound, run, "moving+holding", shares)
    assert used.hazards([0])[0][0] == pytest.approx(4e-6, rel=1e-5)


def test_a_mode_counts_with_its_fault_and_one_without_in_full():
    modes = (
        FailureMode("jam", 0.25, ("moving",), fault="jam"),
        FailureMode("dead", 0.25, ("moving",), fault="dead"),
        FailureMode("noise", 0.5, ("moving",)),
    )
    found = evidence(cell(1.0, False), cell(1.0, True, mode="jam"))
    assert hazards(found, replace(MOTOR, modes=modes), 10.0) == pytest.approx([7.5e-6])


def test_modes_that_say_nothing_of_uses_share_out_what_was_found():
    modes = (FailureMode("jam", 0.25, (), fault="jam"), FailureMode("dead", 0.75, (), fault="dead"))
    motor = replace(MOTOR, modes=modes)
    found = evidence(cell(1.0, False), cell(1.0, True, mode="jam"))
    assert hazards(found, motor, 10.0) == pytest.approx([2.5e-6])
    # Of a mode that was not tried every failure counts, and without cells all of both.
    assert hazards(evidence(cell(1.0, False)), motor, 10.0) == pytest.approx([2.5e-6])
    other = evidence(cell(1.0, False, unit="joint_2"))
    assert hazards(other, motor, 10.0) == hazards(other, MOTOR, 10.0) == pytest.approx([1e-5])


def test_redundant_units_count_in_full():
    pair = replace(MOTOR, quantity=2, redundancy=Redundancy(True))
    found = evidence(cell(1.0, False))
    assert hazards(found, pair, 10.0) == pytest.approx([1e-5])


def test_standby_hazard_counts_by_the_idle_cells():
    standby = replace(RATE, standby=True)
    both = replace(MOTOR, figures=(RATE, standby))
    run = trace(4.0, 6.0)
    still = replace(run.visits[1], exposures={})
    run = replace(run, visits=(run.visits[0], still))
    (bound,) = bind(Hardware("h.yaml", (both,)), run.elements)
    found = evidence(
        cell(1.0, True),
        cell(5.0, True, use="idle", active_s=4.0, idle_s=3.0),
        cell(9.0, False, use="idle", active_s=4.0, idle_s=3.0),
    )
    used = component_use(bound, run, "moving+holding", EvidenceShares(found))
    # Idle for six seconds: the cells are one and five seconds in, so that three of six count.
    assert [row[0] for row in used.hazards([0, 1])] == pytest.approx([4e-6, 3e-6])


def test_blocks_say_that_they_take_evidence():
    run, hardware = trace(4.0, 6.0), Hardware("h.yaml", (MOTOR,))
    with_it = compute_blocks(
        run, hardware, active="moving+holding", evidence=EvidenceShares(FAILS_EARLY)
    )
    without = compute_blocks(run, hardware, active="moving+holding")
    assert all(block.has_evidence for block in with_it.blocks.values())
    assert not any(block.has_evidence for block in without.blocks.values())
    assert any(line.startswith("evidence: motor count") for line in with_it.assumptions)
    last = run.functions[1].ref
    (component,) = with_it.blocks[last].components
    assert component.probability.value == pytest.approx(1e-6, rel=1e-3)


ARM = replace(MOTOR, twin=TwinBinding(joints=("joint_1", "joint_2")), quantity=2)


def of_two_joints(cells):
    run = trace(4.0, 6.0)
    both = tuple(
        replace(each, exposures={**each.exposures, "joint_2": each.exposures["joint_1"]})
        for each in run.visits
    )
    run = replace(run, visits=both, elements=(*run.elements, Element("joint_2", "joint")))
    (bound,) = bind(Hardware("h.yaml", (ARM,)), run.elements)
    used = component_use(bound, run, "moving+holding", EvidenceShares(evidence(*cells)))
    return [sum(column) for column in zip(*used.hazards([0, 1]), strict=True)]


def test_few_cells_of_a_unit_are_pooled_with_those_of_its_like(monkeypatch):
    monkeypatch.setattr(evidence_shares, "LEAST_OF_UNIT", 4)
    cells = [cell(1.0, True), cell(5.0, False), cell(9.0, False)]
    cells += [replace(each, unit="joint_2", fails=each.time_s > 2.0) for each in cells]
    # Failing stretches: 3 of 10 s of the first joint, 7 of 10 s of the second.
    assert of_two_joints(cells) == pytest.approx([5e-6, 5e-6])


@pytest.mark.parametrize("failed", [0, 1, 3])
def test_where_all_are_few_the_pessimistic_end_counts(monkeypatch, failed):
    monkeypatch.setattr(evidence_shares, "LEAST_OF_UNIT", 10)
    cells = [cell(float(at), at < failed) for at in range(6)]
    low, high = clopper_pearson(failed, 6)
    assert hazards(evidence(*cells), MOTOR, 4.0, 6.0) == pytest.approx([4e-6 * high, 6e-6 * high])
    assert high > low
