"""What follows failures, from evidence: the same of a mission however its code is divided."""

import random
from dataclasses import replace
from fractions import Fraction

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.adder.figures.failure_outcomes import later_functions
from tracerisk.adder.quantify.evidence_shares import EvidenceShares
from tracerisk.common.evidence.cells import Cell, Evidence
from tracerisk.common.function_ref import FunctionRef
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    Hardware,
    TwinBinding,
)
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.prm.hybrid.solve import solve_figures
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

RATE = FailureFigure("failure_rate", 3.6e-3, Basis.HOUR)
MOTOR = Component("motor", (RATE,), twin=TwinBinding(joints=("joint_1",)))


def moved(seconds):
    return Exposure(
        moving_s=seconds, active_s=seconds, longest_moving_s=seconds, longest_active_s=seconds
    )


def trace(*seconds):
    """A run of one function a visit, in which `joint_1` moves all the time."""
    refs = [FunctionRef("cell.py", f"step_{number}") for number in range(len(seconds))]
    visits = tuple(
        Visit(ref, sum(seconds[:number]), length, "succeeded", {"joint_1": moved(length)})
        for number, (ref, length) in enumerate(zip(refs, seconds, strict=True))
    )
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="empty",
        end=RunEnd("ended", "", sum(seconds)),
        elements=(Element("joint_1", "joint"),),
        functions=tuple(TracedFunction(ref, 1, rank) for rank, ref in enumerate(refs, 1)),
        visits=visits,
    )


def evidence(fates, *, whole_s=10.0, shows_in=""):
    """One cell a fate, at even distances; `None` for a mission that was carried out."""
    count = len(fates)
    cells = []
    for number, fate in enumerate(fates):
        at = (number + 0.5) * whole_s / count
        base = Cell("motor", "joint_1", "dead", at, "moving", "step_0", True, at, (at, 0.0, 0.0))
        cells.append(
            replace(
                base,
                stretch=moved(whole_s / count),
                fails=fate not in (None, "recovered"),
                fate=fate or "carried_out",
                next_function="step_0" if fate == "recovered" else "",
                shows_in=shows_in,
            )
        )
    return Evidence("f", "panda", 0, count, ("tube at its goal",), tuple(cells))


def blocks(found, *seconds):
    run = trace(*seconds)
    computed = compute_blocks(
        run,
        Hardware("h.yaml", (MOTOR,)),
        active="moving+holding",
        evidence=EvidenceShares(found),
    )
    return list(computed.blocks.values())


def figures(found, *seconds):
    mission = solve_figures(build_model(blocks(found, *seconds), name="cell.py")).mission
    return mission.failure_probability, mission.undetected_probability


HALF = evidence(["stopped_safely"] * 6 + ["unaware"] * 3 + ["stopped_late"] + [None] * 10)


def test_shares_are_those_of_the_hazard_that_ends_the_mission():
    (block,) = blocks(HALF, 10.0)
    (entry,) = block.components
    assert entry.failures.text == ("dead 1: stopped late 0.1, stopped safely 0.6, unaware 0.3")
    failure, undetected = figures(HALF, 10.0)
    assert failure == pytest.approx(5e-6, rel=1e-3)
    assert undetected == pytest.approx(2e-6, rel=1e-3)


@pytest.mark.parametrize("seed", range(20))
def test_both_figures_stay_however_the_code_is_divided(seed):
    draw = random.Random(seed)
    fates = [draw.choice(["stopped_safely", "unaware", "stopped_late", None]) for _ in range(40)]
    found = evidence(fates, shows_in=draw.choice(["", "step_1"]))
    cuts = sorted(draw.uniform(0.0, 10.0) for _ in range(draw.randint(1, 6)))
    lengths = [b - a for a, b in zip([0.0, *cuts], [*cuts, 10.0], strict=True)]
    before, after = figures(found, 10.0), figures(found, *lengths)
    assert after == pytest.approx(before, rel=2e-3)


def test_evidence_of_an_earlier_version_says_nothing_of_what_followed():
    old = replace(HALF, cells=tuple(replace(cell, fate=None) for cell in HALF.cells))
    (block,) = blocks(old, 10.0)
    assert not block.components[0].failures.is_stated
    assert figures(old, 10.0)[1] is None


def test_a_failure_shows_later_only_where_each_mission_comes_there():
    following = {"pick": {"place": 1}, "place": {"pick": 9, "done": 1}}
    shows_in = later_functions(following)
    assert shows_in("pick", "place") == "place"
    assert shows_in("place", "pick") == ""  # the last cycle ends before
    assert shows_in("pick", "pick") == ""
    assert shows_in("pick", "gone") == ""


def test_a_failure_that_shows_later_leads_there():
    found = evidence(["stopped_safely"] * 20, shows_in="step_1")
    first, second = blocks(found, 5.0, 5.0)
    (mode,) = first.components[0].failures.value
    assert mode.outcomes[0][:3] == ("stopped safely", "", "step_1")
    assert mode.share == Fraction(1)
    assert second.components[0].failures.text == "dead 1: stopped safely 1"


RECOVERED = ["recovered"] * 6 + ["stopped_safely"] * 3 + ["unaware"] * 3 + [None] * 12


def test_a_recovery_leads_back_and_fails_no_mission():
    found = evidence(RECOVERED)
    (block,) = blocks(found, 10.0)
    (entry,) = block.components
    assert entry.failures.text == "dead 1: back to step_0 0.5, stopped safely 0.25, unaware 0.25"
    # Half of the failures matter: a quarter leads back, a quarter ends the mission.
    assert entry.probability.value == pytest.approx(5e-6, rel=1e-3)
    assert figures(found, 10.0) == pytest.approx((2.5e-6, 1.25e-6), rel=1e-3)


@pytest.mark.parametrize("seed", range(20))
def test_recoveries_stay_however_the_code_is_divided(seed):
    draw = random.Random(seed)
    kinds = ["stopped_safely", "unaware", "stopped_late", "recovered", "recovered", None]
    found = evidence([draw.choice(kinds) for _ in range(40)])
    cuts = sorted(draw.uniform(0.0, 10.0) for _ in range(draw.randint(1, 6)))
    lengths = [b - a for a, b in zip([0.0, *cuts], [*cuts, 10.0], strict=True)]
    before, after = figures(found, 10.0), figures(found, *lengths)
    assert after == pytest.approx(before, rel=2e-3)


def test_a_recovery_to_no_function_of_the_trace_is_left_out_as_before():
    cells = [replace(cell, next_function="gone") for cell in evidence(RECOVERED).cells]
    found = replace(evidence(RECOVERED), cells=tuple(cells))
    (entry,) = blocks(found, 10.0)[0].components
    assert entry.failures.text == "dead 1: stopped safely 0.5, unaware 0.5"
    assert figures(found, 10.0) == pytest.approx((2.5e-6, 1.25e-6), rel=1e-3)


def test_recoveries_never_stand_for_failures_of_which_too_few_were_tried():
    # Of five tries none ended the mission: up to 45 % may.
    found = evidence(["recovered"] * 2 + [None] * 3)
    failure, undetected = figures(found, 10.0)
    assert failure == pytest.approx(undetected) == pytest.approx(4.507e-6, rel=1e-3)


def test_recoveries_lower_no_failure_that_figures_took_before():
    found = evidence(["recovered"] * 6 + [None] * 14)
    before = {("joint_1", "dead", False): 0.1}
    failure, _ = figures(replace(found, before=before), 10.0)
    assert failure == pytest.approx(1e-6, rel=1e-3)


def test_a_function_named_as_the_end_of_a_mission_is_no_place_to_recover():
    refs = [FunctionRef("arm.py", name) for name in ("pick", "done")]
    traced = replace(trace(1.0), functions=tuple(TracedFunction(ref, 1, 1) for ref in refs))
    shares = EvidenceShares(evidence(["recovered"])).among(traced)
    assert shares.functions == {"pick"}
