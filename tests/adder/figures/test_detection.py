"""When hidden failures are detected: from the hardware description into blocks."""

import math

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.errors import HardwareError
from tracerisk.trace import Cycle, RunEnd, Trace, TracedFunction, Visit

PLACE = FunctionRef("cell.py", QualifiedName("place"))


def trace_of(*durations: float | None, cycle: Cycle | None = None) -> Trace:
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="bench",
        end=RunEnd("ended", "returned", 1.0),
        elements=(),
        functions=(TracedFunction(PLACE, 1, 1),),
        visits=tuple(Visit(PLACE, 0.0, seconds, "done", {}) for seconds in durations),
        cycle=cycle,
    )


@pytest.fixture
def power(tmp_path):
    """Compute the entry of a redundant power system, and the assumptions told of it."""

    def make(trace, detected="", figure="{value: 0.125, per: hour}"):
        path = tmp_path / "hardware.yaml"
        path.write_text(
            "components:\n"
            f"  power: {{probability: {figure}, quantity: 2, redundancy: true, active: always"
            f"{detected}}}\n"
        )
        hardware = read_hardware(path, shown="hardware.yaml")
        computed = compute_blocks(trace, hardware, active="moving+holding")
        (entry,) = computed.blocks[PLACE].components
        return entry, computed.assumptions

    return make


def test_a_block_says_only_what_is_not_the_default(power):
    trace = trace_of(60.0)
    assert power(trace)[0].redundancy.text == "true"
    assert power(trace, ", detected: mission_start")[0].redundancy.text == "true"
    entry, _ = power(trace, ", detected: each_visit")
    assert entry.redundancy.text == "true, detected each_visit"
    assert entry.redundancy.value.detected == "each_visit"
    # Figures per visit are the published reading.
    assert power(trace, figure="0.125")[0].redundancy.text == "true, detected each_visit"


def test_visits_of_unequal_length_weigh_as_the_hidden_failures_do(power):
    # Over both visits a unit survives 4 minutes, 2 a visit; renewed, the longer visit weighs more.
    trace = trace_of(60.0, 180.0)
    two_minutes = -math.expm1(math.log1p(-0.125) / 30)
    assert power(trace)[0].probability.value == pytest.approx(two_minutes, rel=1e-3)
    renewed = power(trace, ", detected: each_visit")[0].probability.value
    assert renewed == pytest.approx(two_minutes * math.sqrt((1 + 9) / 8), rel=5e-3)


TESTED = ", detected: {test_interval: 0.1, per: hour}"


@pytest.mark.parametrize(
    "trace",
    [
        trace_of(360.0),
        trace_of(100.0, 100.0, 200.0),
        # The cycle of 60 s comes six times in a mission, as often as it was seen in the run.
        trace_of(1.0, 60.0, 60.0, 60.0, cycle=Cycle(1, 1, 6)),
    ],
)
def test_tests_within_the_mission_are_left_out_and_reported(power, trace):
    entry, assumptions = power(trace, TESTED)
    assert entry.redundancy.text == "true"
    (line,) = assumptions
    assert line.startswith("power: tests within the mission are not counted")


@pytest.mark.parametrize("missions", [1.5, 2.0, 36.0])
def test_a_test_rarer_than_missions_says_the_mean_of_those_between_two(power, missions):
    entry, assumptions = power(trace_of(360.0 / missions), TESTED)
    alone, _ = power(trace_of(360.0 / missions))
    # A pair with P fails within n missions with (nP)^2, in the mean of one with n P^2.
    p, found = alone.probability.value, entry.probability.value
    assert -math.log1p(-(found**2)) == pytest.approx(
        -math.log1p(-((1 - (1 - p) ** missions) ** 2)) / missions, rel=2e-3
    )
    assert entry.redundancy.text == "true"
    (line,) = assumptions
    assert line.startswith(f"power: figures are means over the {missions:.4g} missions between")


def test_where_missions_are_cut_changes_nothing_of_what_lasts_beyond_them(power):
    whole = power(trace_of(120.0), TESTED)[0].probability.value
    parts = power(trace_of(40.0, 80.0), TESTED)[0].probability.value
    assert 1 - (1 - parts) ** 2 == pytest.approx(whole, rel=1e-3)


def test_a_mission_without_a_time_cannot_be_compared_with_a_test_interval(power):
    with pytest.raises(HardwareError) as caught:
        power(trace_of(None), TESTED, figure="0.125")
    assert str(caught.value).startswith("hardware.yaml:2")
    assert "the time of a mission, which this trace does not hold" in str(caught.value)
    assert "write 'detected: mission_start'" in str(caught.value)


@pytest.mark.parametrize("missions", [1.5, 4.0])
def test_spares_tested_more_rarely_than_missions_come_say_the_mean_as_well(power, missions):
    def hazard(p, times):
        h = -times * math.log1p(-p)
        return h - math.log1p(h)

    entry, assumptions = power(trace_of(360.0 / missions), f"{TESTED}, spare: cold")
    alone, _ = power(trace_of(360.0 / missions), ", spare: cold")
    # One unit after the other fails over n missions, as often as one of n times the hazard.
    p, found = alone.probability.value, entry.probability.value
    assert hazard(found, 1) == pytest.approx(hazard(p, missions) / missions, rel=2e-3)
    assert entry.redundancy.text == "true, spare cold"
    assert assumptions[0].startswith(
        f"power: figures are means over the {missions:.4g} missions between"
    )


@pytest.mark.parametrize("in_mission", [False, True])
@pytest.mark.parametrize("spare", ["", ", spare: cold"])
def test_a_repaired_group_says_the_mean_mission_of_the_long_run(power, spare, in_mission):
    within = ", in_mission: true" if in_mission else ""
    rate = "{value: 0.125, per: hour}"
    repair = f"{spare}, repair: {{mean_time: 0.2, per: hour{within}}}"
    entry, assumptions = power(trace_of(360.0), repair, figure=rate)
    # The chain of a pair in missions of 0.1 h, by its own small matrices.
    failing, repairs = -math.log1p(-0.125) * 0.1, 0.5
    first = failing if spare else 2 * failing
    generator = [
        [-first, first, 0.0],
        [repairs if in_mission else 0.0, -failing - (repairs if in_mission else 0.0), failing],
        [0.0, 0.0, 0.0],
    ]
    mission = exponential(generator)
    back = 0.0 if in_mission else -math.expm1(-repairs)
    (a, b, _), (c, e, _), _ = mission
    c, e = c + e * back, e * (1 - back)
    # m0 = 1 + a m0 + b m1; m1 = 1 + c m0 + e m1.
    missions = (1 - e + b) / ((1 - a) * (1 - e) - b * c)
    p = entry.probability.value
    h = -math.log1p(-p)
    found = h - math.log1p(h) if spare else -math.log1p(-p * p)
    assert found == pytest.approx(-math.log1p(-1 / missions), rel=2e-3)
    (line,) = assumptions
    assert line.startswith("power: a failed unit is repaired in 0.2 h on average")
    assert ("missing in the next at least" in line) is not in_mission


def exponential(matrix):
    """The exponential of a small matrix, by its series."""
    size = range(len(matrix))
    total = term = [[float(i == j) for j in size] for i in size]
    for count in range(1, 40):
        term = [[sum(term[i][k] * matrix[k][j] for k in size) / count for j in size] for i in size]
        total = [[total[i][j] + term[i][j] for j in size] for i in size]
    return total


@pytest.mark.parametrize("within", ["", ", in_mission: true"])
def test_where_missions_are_cut_changes_nothing_of_what_is_repaired(power, within):
    """A wait more is a risk more, repair or not; the place of a cut is none."""
    repair = f", repair: {{mean_time: 0.01, per: hour{within}}}"
    whole = power(trace_of(120.0), repair)[0].probability.value
    parts = power(trace_of(40.0, 80.0), repair)[0].probability.value
    assert 1 - (1 - parts) ** 2 == pytest.approx(whole, rel=1e-3)
    longer = power(trace_of(120.0, 600.0), repair)[0].probability.value
    assert 1 - (1 - longer) ** 2 > whole


def test_a_mission_without_a_time_cannot_be_compared_with_a_repair(power):
    with pytest.raises(HardwareError, match="repair of 720 s cannot be compared with the time"):
        power(trace_of(None), ", repair: {mean_time: 0.2, per: hour}", figure="0.125")
