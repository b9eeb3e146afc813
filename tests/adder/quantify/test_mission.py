"""The law of refactoring: how a run is cut into visits moves no figure of its mission.

What a unit does is drawn as stretches of time, each in one state or several at once, and summed
up here, so that neither the unions of states nor the totals are those of the code under test.
"""

import itertools
import math
from dataclasses import dataclass, replace

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.adder.quantify.component_activity import (
    component_use,
    mission_time,
    visits_of_mission,
)
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.binding import BoundComponent
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, FailureMode, LoadLaw
from tracerisk.common.hardware.use import UnknownUseError
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Element, Exposure
from tracerisk.trace import Cycle, RunEnd, Trace, TracedFunction, Visit

STEP = FunctionRef("cell.py", QualifiedName("step"))
OVERLAPS = (
    frozenset(("moving",)),
    frozenset(("holding",)),
    frozenset(("grasping",)),
    frozenset(("moving", "grasping")),
    frozenset(("holding", "grasping")),
)


@dataclass(frozen=True)
class Stretch:
    """What one unit does for a while: seconds in each overlap of states, and counts."""

    seconds: tuple[float, ...]
    idle_s: float
    speed: float
    load: float
    starts: int
    grasps: int
    releases: int

    def within(self, *states: str) -> float:
        """The time in any of the states."""
        return math.fsum(
            seconds
            for overlap, seconds in zip(OVERLAPS, self.seconds, strict=True)
            if overlap & set(states)
        )

    @property
    def travel_s(self) -> float:
        return self.within("moving") * self.speed

    @property
    def duration_s(self) -> float:
        return math.fsum((*self.seconds, self.idle_s))

    def exposure(self) -> Exposure:
        moving = self.within("moving") > 0.0
        return Exposure(
            moving_s=self.within("moving"),
            holding_s=self.within("holding"),
            grasping_s=self.within("grasping"),
            active_s=self.within("moving", "holding", "grasping"),
            longest_moving_s=self.within("moving"),
            longest_active_s=self.within("moving", "holding", "grasping"),
            starts=self.starts,
            grasps=self.grasps,
            releases=self.releases,
            grasping_moving_s=self.seconds[3],
            travel_s=self.travel_s,
            wear=tuple(self.travel_s * self.load**k for k in WEAR_EXPONENTS) if moving else (),
        )


def together(stretches: list[Stretch]) -> tuple[Exposure, float]:
    """What one visit that holds all the stretches shows: every field that adds up, added up."""
    parts = [stretch.exposure() for stretch in stretches]
    added = {
        name: sum(getattr(part, name) for part in parts)
        for name in (
            *("moving_s", "holding_s", "grasping_s", "active_s", "grasping_moving_s"),
            *("starts", "grasps", "releases", "travel_s"),
        )
    }
    wear = tuple(map(math.fsum, zip(*(part.wear for part in parts if part.wear), strict=True)))
    return Exposure(**added, wear=wear), math.fsum(s.duration_s for s in stretches)


def trace_of(visits: list[tuple[Exposure, float]], kind="gripper", cycle=None) -> Trace:
    return Trace(
        controller="cell.py",
        robot="arm",
        scene="bench",
        end=RunEnd("ended", "returned", 1.0),
        elements=(Element("hand", kind),),
        functions=(TracedFunction(STEP, 1, 1),),
        visits=tuple(
            Visit(STEP, 0.0, seconds, "succeeded", {"hand": exposure})
            for exposure, seconds in visits
        ),
        cycle=cycle,
    )


def mission_hazard(component: Component, trace: Trace, active="moving+holding") -> float:
    used = component_use(BoundComponent(component, 1, ("hand",)), trace, active)
    times = visits_of_mission(trace)
    rows = used.hazards(range(len(trace.visits)))
    assert all(hazard >= 0.0 for row in rows for hazard in row)
    return math.fsum(comes * row[0] for comes, row in zip(times, rows, strict=True))


nothing_or = st.just(0.0) | st.floats(0.1, 50.0)
stretches = st.builds(
    Stretch,
    seconds=st.tuples(*[nothing_or] * len(OVERLAPS)),
    # In use for longer than the visit is the current one, where it is below zero.
    idle_s=st.floats(-20.0, 50.0),
    speed=st.floats(0.05, 1.0),
    load=st.floats(0.05, 1.0),
    starts=st.integers(0, 5),
    grasps=st.integers(0, 5),
    releases=st.integers(0, 5),
)
when = st.lists(
    st.sampled_from(("moving", "holding", "grasping", "start", "grasp", "release")),
    min_size=1,
    unique=True,
).map(tuple)
modes = st.lists(when, max_size=3).map(
    lambda whens: tuple(FailureMode(f"mode{n}", 0.3, each) for n, each in enumerate(whens))
)
load_laws = st.none() | st.builds(
    LoadLaw,
    reference_load=st.floats(0.1, 1.0),
    wearing_share=st.floats(0.0, 1.0),
    exponent=st.sampled_from(WEAR_EXPONENTS),
    reference_speed=st.none() | st.floats(0.05, 1.0),
)
FIGURES = {
    "probability per minute": FailureFigure("probability", 0.01, Basis.MINUTE),
    "rate per hour": FailureFigure("failure_rate", 0.7, Basis.HOUR),
    "weibull": FailureFigure("weibull", 0.1, Basis.HOUR, shape=2.3),
    "weibull of a new unit": FailureFigure("weibull", 0.1, Basis.HOUR, shape=0.6),
    "standby": FailureFigure("failure_rate", 0.4, Basis.HOUR, standby=True),
    "demand": FailureFigure("probability", 0.001, Basis.DEMAND),
    "release": FailureFigure("probability", 0.001, Basis.DEMAND, demand="release"),
}
runs = st.lists(st.lists(stretches, min_size=1, max_size=3), min_size=1, max_size=4)


@given(
    name=st.sampled_from(sorted(FIGURES)),
    run=runs,
    load_law=load_laws,
    modes=modes,
    active=st.sampled_from(("moving", "moving+holding")),
    kind=st.sampled_from(("joint", "gripper")),
)
def test_cutting_visits_leaves_the_missions_figure(name, run, load_law, modes, active, kind):
    age_s = 100.0 if name == "weibull" else 0.0
    component = Component("part", (FIGURES[name],), load_law=load_law, modes=modes, age_s=age_s)
    whole = trace_of([together(visit) for visit in run], kind)
    cut = trace_of([together([stretch]) for visit in run for stretch in visit], kind)
    one = trace_of([together(list(itertools.chain(*run)))], kind)
    hazards = [mission_hazard(component, each, active) for each in (whole, cut, one)]
    p = [-math.expm1(-hazard) for hazard in hazards]
    # Times on standby are differences of sums, which are up to 1e4 times as great.
    nothing = 1e-15 if name == "standby" else 0.0
    assert p[1] == pytest.approx(p[0], rel=1e-12, abs=nothing)
    assert p[2] == pytest.approx(p[0], rel=1e-12, abs=nothing)


@given(
    name=st.sampled_from(sorted(FIGURES)),
    run=runs,
    load_law=load_laws,
    modes=modes,
    active=st.sampled_from(("moving", "moving+holding")),
)
def test_the_missions_figure_is_that_of_its_totals(name, run, load_law, modes, active):
    figure = FIGURES[name]
    age_s = 100.0 if name == "weibull" else 0.0
    component = Component("part", (figure,), load_law=load_law, modes=modes, age_s=age_s)
    everything = list(itertools.chain(*run))
    states = ("moving",) if active == "moving" else ("moving", "holding", "grasping")
    in_use = {*states, *(each for mode in modes for each in mode.when)}

    def total(*states):
        return math.fsum(stretch.within(*states) for stretch in everything)

    def counted(*states):
        seconds = total(*states)
        if load_law is None or not seconds:
            return seconds
        phi, k = load_law.wearing_share, load_law.exponent
        travel = math.fsum(stretch.travel_s for stretch in everything)
        wear = math.fsum(stretch.travel_s * stretch.load**k for stretch in everything)
        speed = load_law.reference_speed or (travel / total("moving") if travel else 1.0)
        wearing = wear / (speed * load_law.reference_load**k) if "moving" in states else 0.0
        return (1 - phi) * seconds + phi * wearing

    def events(*names):
        fields = {"start": "starts", "grasp": "grasps", "release": "releases"}
        return sum(
            getattr(stretch, fields[each])
            for stretch in everything
            for each in names
            if each in fields
        )

    if name == "standby":
        idle = math.fsum(stretch.duration_s - stretch.within(*in_use) for stretch in everything)
        expected = 0.4 / 3600 * max(0.0, idle)
    elif figure.per is Basis.DEMAND:
        mine = {figure.demand or "grasp"}
        wanted = {"start", "grasp", "release"} if figure.demand is None else mine
        amount = (
            math.fsum(mode.fraction * events(*(wanted & set(mode.when))) for mode in modes)
            if modes
            else events(*mine)
        )
        expected = -math.log1p(-0.001) * amount
    else:
        if figure.kind == "weibull":
            clock = counted(*in_use)
            with mpmath.workdps(50):
                old, new = (
                    (mpmath.mpf(t) / 360) ** figure.shape
                    for t in (age_s, mpmath.mpf(age_s) + clock)
                )
                rate = float((new - old) / clock) if clock else 0.0
        else:
            rate = 0.7 / 3600 if figure.kind == "failure_rate" else -math.log1p(-0.01) / 60
        amount = (
            math.fsum(mode.fraction * counted(*mode.when) for mode in modes)
            if modes
            else counted(*states)
        )
        expected = rate * amount
    found = mission_hazard(component, trace_of([together(visit) for visit in run]), active)
    assert found == pytest.approx(expected, rel=1e-11, abs=1e-15 if name == "standby" else 0.0)


@given(
    name=st.sampled_from(sorted(FIGURES)),
    before=st.lists(stretches, max_size=2),
    cycle=st.lists(stretches, min_size=2, max_size=3),
    load_law=load_laws,
)
def test_a_cycle_counts_as_often_as_it_comes_in_the_mission(name, before, cycle, load_law):
    component = Component("part", (FIGURES[name],), load_law=load_law, age_s=7.0)
    seen = [together([stretch]) for stretch in (*before, *cycle, *cycle, *cycle)]
    declared = trace_of(seen, cycle=Cycle(len(before), len(cycle), 7))
    mission = trace_of([together([stretch]) for stretch in (*before, *cycle * 7)])
    nothing = 1e-15 if name == "standby" else 0.0
    assert mission_hazard(component, declared) == pytest.approx(
        mission_hazard(component, mission), rel=1e-11, abs=nothing
    )
    assert mission_time(declared) == pytest.approx(mission_time(mission), rel=1e-12, abs=1e-9)


IDLE = FailureFigure("failure_rate", 3.6, Basis.HOUR, standby=True)
BUSY = replace(IDLE, standby=False)


def hazards(component, trace, active="moving+holding"):
    used = component_use(BoundComponent(component, 1, ("hand",)), trace, active)
    return [row[0] for row in used.hazards(range(len(trace.visits)))]


def test_standby_is_what_is_left_of_each_visit():
    moving = Exposure(moving_s=4.0, active_s=4.0)
    trace = trace_of([(moving, 10.0), (Exposure(), 5.0)])
    assert hazards(Component("part", (IDLE,)), trace) == pytest.approx([6e-3, 5e-3])


def test_use_beyond_its_visit_is_taken_from_the_idle_time_of_the_others():
    # The hand closes by a command of the first visit for 4 s after the next visit has begun.
    closing = Exposure(moving_s=6.0, active_s=6.0)
    trace = trace_of([(closing, 2.0), (Exposure(), 10.0), (Exposure(), 5.0)])
    found = hazards(Component("part", (IDLE,)), trace)
    assert found == pytest.approx([0.0, 10e-3 * 11 / 15, 5e-3 * 11 / 15])


def test_holding_is_standby_where_only_moving_counts_and_no_mode_names_it():
    exposure = Exposure(moving_s=4.0, holding_s=3.0, active_s=7.0)
    trace = trace_of([(exposure, 10.0)])
    assert hazards(Component("part", (IDLE,)), trace, "moving") == pytest.approx([6e-3])
    holds = (FailureMode("slips", 1.0, ("holding",)),)
    assert hazards(Component("part", (IDLE,), modes=holds), trace, "moving") == pytest.approx(
        [3e-3]
    )


@pytest.mark.parametrize("kind", ["sensor", "contact"])
def test_a_sensor_is_in_use_while_it_is_active_whatever_moves(kind):
    exposure = Exposure(active_s=4.0, reading_s=4.0, longest_active_s=4.0)
    trace = trace_of([(exposure, 10.0)], kind)
    for active in ("moving", "moving+holding"):
        assert hazards(Component("part", (BUSY,)), trace, active) == pytest.approx([4e-3])
        used = component_use(BoundComponent(Component("p", (BUSY,)), 1, ("hand",)), trace, active)
        assert used.is_active == (True,)


def test_what_is_always_active_counts_every_second_and_is_never_idle():
    bound = BoundComponent(Component("power", (BUSY,), 2, always_active=True), 2, ())
    used = component_use(bound, trace_of([(Exposure(), 10.0), (Exposure(), 5.0)]), "moving")
    assert used.hazards((0, 1)) == [
        pytest.approx([10e-3] * 2),
        pytest.approx([5e-3] * 2),
    ]
    ageing = replace(
        bound.component, figures=(FailureFigure("weibull", 1.0, Basis.HOUR, shape=2.0),)
    )
    used = component_use(
        replace(bound, component=ageing),
        trace_of([(Exposure(), 10.0), (Exposure(), 5.0)]),
        "moving",
    )
    first, second = (row[0] for row in used.hazards((0, 1)))
    assert first + second == pytest.approx((15 / 3600) ** 2)
    assert first == pytest.approx(2 * second)


@pytest.mark.parametrize(
    ("figure", "load_law", "what"),
    [
        (IDLE, None, "the exposure"),
        (BUSY, LoadLaw(0.5, 0.5), "the exposure"),
        (FailureFigure("weibull", 1.0, Basis.HOUR, shape=2.0), None, "the exposure"),
    ],
)
def test_what_depends_on_the_mission_needs_every_exposure(figure, load_law, what):
    trace = trace_of([(None, 10.0), (Exposure(), 5.0)])
    with pytest.raises(UnknownUseError, match=f"{what} is not known"):
        hazards(Component("part", (figure,), load_law=load_law), trace)


def test_standby_needs_the_length_of_every_visit():
    trace = trace_of([(Exposure(), None), (Exposure(), 5.0)])
    assert mission_time(trace) is None
    with pytest.raises(UnknownUseError, match="the time on standby is not known"):
        hazards(Component("part", (IDLE,)), trace)


def test_a_demand_counts_in_a_visit_that_is_too_short_for_activity():
    brief = Exposure(moving_s=0.01, active_s=0.01, longest_moving_s=0.01, starts=1)
    trace = trace_of([(brief, 0.01), (replace(brief, starts=0), 0.01)], "joint")
    component = Component("part", (BUSY, FIGURES["demand"]))
    used = component_use(BoundComponent(component, 1, ("hand",)), trace, "moving+holding")
    assert [used.is_at_stake([visit]) for visit in (0, 1)] == [True, False]


def test_a_component_counts_where_it_is_active_or_fails_idle():
    moving = Exposure(moving_s=4.0, active_s=4.0, longest_moving_s=4.0, longest_active_s=4.0)
    trace = trace_of([(moving, 4.0), (Exposure(), 5.0)])
    for figures, counts in (((BUSY,), [True, False]), ((BUSY, IDLE), [True, True])):
        bound = BoundComponent(Component("part", figures), 1, ("hand",))
        used = component_use(bound, trace, "moving+holding")
        assert [used.is_at_stake([visit]) for visit in (0, 1)] == counts
