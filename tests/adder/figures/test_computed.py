"""From use to blocks: which components a block has, how its figure adds up, what is assumed."""

import math
from dataclasses import replace

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import WEAR_EXPONENTS, Element, Exposure
from tracerisk.errors import HardwareError
from tracerisk.trace import Cycle, RunEnd, Trace, TracedFunction, Visit


def ref(name: str) -> FunctionRef:
    return FunctionRef("cell.py", QualifiedName(name))


def moved(seconds: float, holding: float = 0.0, speed: float = 0.3, load: float = 0.2):
    travel = seconds * speed
    return Exposure(
        moving_s=seconds,
        holding_s=holding,
        active_s=seconds + holding,
        longest_moving_s=seconds,
        longest_active_s=seconds + holding,
        starts=int(seconds > 0),
        travel_s=travel,
        wear=tuple(travel * load**k for k in WEAR_EXPONENTS) if seconds else (),
    )


def trace_of(*visits: tuple[str, float, dict], kind="joint", cycle=None) -> Trace:
    names = dict.fromkeys(name for name, _, _ in visits)
    elements = dict.fromkeys(name for _, _, exposures in visits for name in exposures)
    return Trace(
        controller="cell.py",
        robot="arm",
        scene="bench",
        end=RunEnd("ended", "returned", 1.0),
        elements=tuple(Element(name, kind) for name in elements),
        functions=tuple(TracedFunction(ref(name), n, n) for n, name in enumerate(names, start=1)),
        visits=tuple(
            Visit(ref(name), 0.0, seconds, "succeeded", exposures)
            for name, seconds, exposures in visits
        ),
        cycle=cycle,
    )


@pytest.fixture
def compute(tmp_path):
    """Compute the blocks of a trace from the lines of one component."""

    def make(trace, *lines, active="moving+holding"):
        path = tmp_path / "hardware.yaml"
        body = "".join(f"    {line}\n" for line in lines)
        path.write_text(f"components:\n  part:\n{body}")
        hardware = read_hardware(path, shown="hardware.yaml")
        return compute_blocks(trace, hardware, active=active)

    return make


JOINTS = 'twin: {joints: "*"}'
RATE = "failure_rate: {value: 3.6e-3, per: hour}"
IDLE = "standby_rate: {value: 3.6e-3, per: hour}"


def value(computed, name="move"):
    (entry,) = computed.blocks[ref(name)].components
    return entry.probability.value


def mission(computed, visits):
    """The failure probability of units that are all needed, by the values in the blocks."""
    total = 0.0
    for function, block in computed.blocks.items():
        for entry in block.components:
            units = entry.quantity.value * visits[function.name]
            total += units * math.log1p(-entry.probability.value)
    return -math.expm1(total)


LINES = {
    "time": (RATE,),
    "load": (RATE, "load_law: {reference_load: 0.3, wearing_share: 0.6}"),
    "modes": (
        RATE,
        "modes: {slips: {fraction: 0.4, when: [holding]}, jams: {fraction: 0.6, when: [moving]}}",
    ),
    "standby": (IDLE,),
    "demands": ("probability: {value: 1.0e-6, per: demand}",),
    "ageing": (
        "weibull: {shape: 2.2, scale: 30000, per: hour}",
        "age: {value: 9000, per: hour}",
        "load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 10/3}",
    ),
}


@pytest.mark.parametrize("name", LINES)
def test_the_cut_into_functions_moves_no_figure(name, compute):
    parts = [
        (3.0, {"j1": moved(2.0, 0.5, 0.5, 0.6), "j2": moved(3.0)}),
        (4.0, {"j1": moved(1.0, 2.0), "j2": replace(moved(0.5, 3.0, 0.1, 0.9), starts=2)}),
        (2.0, {"j1": moved(0.0, 2.0)}),
    ]
    one = trace_of(*(("work", *part) for part in parts))
    cut = trace_of(*((f"step{n}", *part) for n, part in enumerate(parts)))
    whole = mission(compute(one, *LINES[name], JOINTS), {"work": 3})
    pieces = mission(
        compute(cut, *LINES[name], JOINTS), dict.fromkeys(("step0", "step1", "step2"), 1)
    )
    assert whole > 0.0
    # Four digits stand in a block.
    assert pieces == pytest.approx(whole, rel=5e-4)


def test_what_fails_idle_stands_in_the_blocks_of_functions_that_do_not_use_it(compute):
    trace = trace_of(("move", 5.0, {"j1": moved(5.0)}), ("wait", 4.0, {}))
    active = compute(trace, RATE, JOINTS)
    assert active.blocks[ref("wait")].components == ()
    idle = compute(trace, RATE, IDLE, JOINTS)
    assert value(idle, "move") == pytest.approx(5e-6, rel=1e-3)
    assert value(idle, "wait") == pytest.approx(4e-6, rel=1e-3)
    assert idle.observed == {ref("move"): ("part",), ref("wait"): ()}
    assert idle.exposures[ref("wait")] == {"part": 0.0}


def test_the_mean_speed_is_that_of_the_mission_in_which_a_cycle_comes_often(compute):
    law = "load_law: {reference_load: 0.5, wearing_share: 1.0}"
    slow, fast = moved(1.0, 0.0, 0.1, 0.5), moved(1.0, 0.0, 0.4, 0.5)
    visits = [("begin", 1.0, {"j1": slow}), *[("loop", 1.0, {"j1": fast})] * 3]
    computed = compute(trace_of(*visits, cycle=Cycle(1, 1, 9)), RATE, law, JOINTS)
    mean = (0.1 + 9 * 0.4) / 10
    assert value(computed, "begin") == pytest.approx(1e-6 * 0.1 / mean, rel=1e-3)
    assert value(computed, "loop") == pytest.approx(1e-6 * 0.4 / mean, rel=1e-3)


def mission_of_pairs(computed, visits):
    """The failure probability of pairs that are whole again at each visit."""
    total = 0.0
    for function, block in computed.blocks.items():
        for entry in block.components:
            total += visits[function.name] * math.log1p(-(entry.probability.value**2))
    return -math.expm1(total)


@pytest.mark.parametrize(
    ("lines", "failure"),
    [
        ((RATE, JOINTS), mission),
        ((RATE, "quantity: 2", "redundancy: true", "active: always"), mission),
        (
            (RATE, "quantity: 2", "redundancy: true", "detected: each_visit", "active: always"),
            mission_of_pairs,
        ),
    ],
    ids=["each needed", "hidden", "whole again"],
)
def test_a_visit_before_the_cycle_weighs_once_in_a_function_of_the_cycle(lines, failure, compute):
    cycle = [("back", 5.0, {"j1": moved(4.0)}), ("there", 3.0, {"j1": moved(2.0)})] * 3
    begin = (300.0, {"j1": moved(200.0)})
    declared = Cycle(1, 2, 10)
    same = compute(trace_of(("there", *begin), *cycle, cycle=declared), *lines)
    apart = compute(trace_of(("begin", *begin), *cycle, cycle=declared), *lines)
    expected = failure(apart, {"begin": 1, "there": 10, "back": 10})
    assert failure(same, {"there": 11, "back": 10}) == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize(
    ("exposure", "lines", "message"),
    [
        (
            None,
            (RATE,),
            "component 'part': the exposure is not known from this trace; "
            "give its figure 'per: visit', or use a trace of the twin",
        ),
        (
            None,
            ("probability: 1.0e-6", IDLE),
            "component 'part': the exposure is not known from this trace; "
            "give its figure 'per: visit', or use a trace of the twin",
        ),
        (
            replace(moved(2.0), wear=()),
            (RATE, "load_law: {reference_load: 0.5, wearing_share: 0.5}"),
            "component 'part': the wear of what moves is not known from this trace; "
            "`tracerisk run FILE` gives it",
        ),
    ],
)
def test_what_a_trace_does_not_say_is_an_error_that_says_what_to_do(
    exposure, lines, message, compute
):
    trace = trace_of(("move", 5.0, {"j1": exposure}))
    with pytest.raises(HardwareError) as caught:
        compute(trace, *lines, JOINTS)
    assert str(caught.value).startswith("hardware.yaml:2")
    assert str(caught.value).endswith(message)


MOVE = trace_of(("move", 5.0, {"j1": moved(5.0)}))


def test_a_load_law_without_a_speed_says_whose_speed_it_takes(compute):
    law = "load_law: {reference_load: 0.5, wearing_share: 0.5"
    (line,) = compute(MOVE, RATE, f"{law}}}", JOINTS).assumptions
    assert line == (
        "part: the figures are taken to hold at the mean speed of the mission itself, since the "
        "load law states no reference_speed, so a component that always moves faster does not "
        "count as wearing more"
    )
    assert compute(MOVE, RATE, f"{law}, reference_speed: 0.3}}", JOINTS).assumptions == ()


@pytest.mark.parametrize(
    ("age", "expected"),
    [((), "are new"), (("age: {value: 12000, per: hour}",), "were in use for 12000 h")],
)
def test_what_ages_says_from_what_age(age, expected, compute):
    (line,) = compute(
        MOVE, "weibull: {shape: 2, scale: 30000, per: hour}", *age, JOINTS
    ).assumptions
    assert line == (
        f"part: Weibull, of units that {expected} when the mission begins; the mission's hazard is "
        "spread over its time in use"
    )


def test_failures_that_no_mode_has_are_reported_as_harmless(compute):
    modes = "modes: {jams: {fraction: 0.4, when: [moving]}, slips: {fraction: %s, when: [holding]}}"
    (line,) = compute(MOVE, RATE, modes % "0.35", JOINTS).assumptions
    assert line == (
        "part: the failure modes make up 75 % of the failures; the other 25 % are taken as harmless"
    )
    assert compute(MOVE, RATE, modes % "0.6", JOINTS).assumptions == ()


@pytest.mark.parametrize(
    ("figure", "is_said"),
    [
        ("mttfd: {value: 150, unit: year}", True),
        ("b10d: {value: 2e7, cycles: {value: 25, per: hour}}", True),
        ("mttfd: {value: 150, unit: year, dangerous: 0.5}", False),
        ("b10: {value: 2e7, cycles: {value: 25, per: hour}}", False),
        ("mtbf: {value: 886000, unit: hour}", False),
    ],
)
def test_figures_of_dangerous_failures_alone_say_so(compute, figure, is_said):
    lines = compute(MOVE, figure, JOINTS).assumptions
    assert [line for line in lines if "count dangerous failures alone" in line] == list(lines)
    assert len(lines) == is_said
    assert all(line.startswith("part: MTTFd and B10d") for line in lines)


@pytest.mark.parametrize(
    ("rated", "working", "is_said"), [(40, 328.15, True), (85, 0, True), (40, 85, False)]
)
def test_a_temperature_that_changes_a_rate_beyond_belief_is_said(compute, rated, working, is_said):
    at = f"temperature: {{rated: {rated}, working: {working}, activation_energy: 0.7}}"
    lines = compute(MOVE, f"mtbf: {{value: 886000, unit: hour, {at}}}", JOINTS).assumptions
    assert len(lines) == is_said
    for line in lines:
        assert line.startswith("part: the temperature multiplies the rate by ")
        assert f"are {rated} and {working} in degC" in line


def test_figures_with_an_error_factor_are_reported_as_medians(compute):
    rate = "failure_rate: {value: 570, unit: FIT, error_factor: 3%s}"
    (line,) = compute(MOVE, rate % "", JOINTS).assumptions
    assert line == (
        "part: the figures with an error factor are medians, and so the mission's is about its "
        "median; its mean is higher; `solve --hardware --uncertainty` prints it"
    )
    assert compute(MOVE, rate % ", value_is: mean", JOINTS).assumptions == ()


def test_a_description_of_nothing_that_the_robot_has_is_an_error(compute):
    camera = "twin: {sensors: camera, optional: true}"
    with pytest.raises(HardwareError, match="only optional components, of which the robot has no"):
        compute(MOVE, RATE, camera)


@pytest.mark.parametrize("active", [0.0, 2.0])
def test_what_is_in_use_without_a_figure_is_an_assumption(compute, active):
    elements = (Element("a", "joint"), Element("a/torque", "sensor", "torque", "a"))
    use = {"a": moved(2.0), "a/torque": moved(active)}
    trace = replace(trace_of(("move", 2.0, {"a": moved(2.0)})), elements=elements, active=use)
    lines = compute(trace, RATE, JOINTS).assumptions
    words = "in use but not counted, as the hardware data has no figures for them: "
    assert lines == ((f"{words}1 torque sensor (a/torque)",) if active else ())


@pytest.mark.parametrize(
    ("idle", "listed"), [("e", "4 joints (a to d)"), ("c", "4 joints (a, b, d, e)")]
)
def test_only_elements_that_are_all_in_use_are_told_as_one_to_another(compute, idle, listed):
    elements = tuple(Element(name, "joint") for name in "xabcde")
    use = {name: moved(2.0) for name in "xabcde" if name != idle}
    trace = replace(trace_of(("move", 2.0, {"x": moved(2.0)})), elements=elements, active=use)
    (line,) = compute(trace, RATE, "twin: {joints: [x]}").assumptions
    assert line.endswith(f": {listed}")


@pytest.mark.parametrize("held_s", [0.0, 15.0])
@pytest.mark.parametrize("figure", ["probability: {value: 2e-8, per: demand}", RATE])
def test_holding_that_no_figure_of_a_gripper_counts_is_an_assumption(compute, figure, held_s):
    use = Exposure(active_s=1.0 + held_s, moving_s=1.0, grasping_s=held_s, grasps=1, starts=1)
    trace = replace(trace_of(("pick", 2.0, {"hand": use}), kind="gripper"), active={"hand": use})
    lines = compute(trace, figure, "twin: {gripper: true}").assumptions
    told = [line for line in lines if "(15 s in this run) is not counted" in line]
    assert len(told) == (held_s > 0.0 and figure != RATE)


def test_time_out_of_use_counts_no_holding(compute):
    use = Exposure(active_s=16.0, moving_s=1.0, grasping_s=15.0, grasps=1, starts=1)
    trace = replace(trace_of(("pick", 20.0, {"hand": use}), kind="gripper"), active={"hand": use})
    figures = ("probability: {value: 2e-8, per: demand}", "standby_rate: {value: 1e-7, per: hour}")
    lines = compute(trace, *figures, "twin: {gripper: true}").assumptions
    assert (
        "part: its figures count demands and the time out of use alone; that it lets go while it "
        "holds something (15 s in this run) is not counted"
    ) in lines


@pytest.mark.parametrize("is_near", [True, False])
def test_a_joint_that_is_idle_by_a_value_near_its_threshold_is_an_assumption(compute, is_near):
    elements = (Element("a", "joint"), Element("b", "joint"))
    use = {"a": moved(2.0), "b": Exposure(borderline=is_near)}
    trace = replace(trace_of(("move", 2.0, {"a": moved(2.0)})), elements=elements, active=use)
    lines = compute(trace, RATE, JOINTS).assumptions
    told = "b: taken as idle for the whole run, though its torque or motion is within a factor"
    assert [line.startswith(told) for line in lines] == [True] * is_near
    assert all("in use as the busiest joint is, it would count for 2 s" in line for line in lines)
