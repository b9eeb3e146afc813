"""What the twin measures of a payload, and what that does to the figures of those who carry it."""

import math

import pytest

from tracerisk.common import trace_json
from tracerisk.common.traced.elements import WEAR_EXPONENTS
from tracerisk.trace import Trace
from tracerisk.twin.physics.scene import SHIPPED_SCENES

HEAVY_KG = 0.5
TUBES = 1
CARRYING = ("pick", "place_position")
EMPTY_HANDED = ("init", "pick_position")

HARDWARE = """\
robot: panda
components:
  electric_motor:
    quantity: 7
    failure_rate: {value: 5.7e-06, per: hour}
    load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 3, source: assumed}
    source: assumed
    twin: {joints: "*"}
"""


def heavy_tubes() -> str:
    """The shipped scene with tubes of 0.5 kg instead of 25 g."""
    text = (SHIPPED_SCENES / "tube_racks.yaml").read_text(encoding="utf-8")
    assert text.count("mass: 0.025") == 1
    return text.replace("mass: 0.025", f"mass: {HEAVY_KG}").replace(
        "name: tube_racks", "name: heavy_tubes", 1
    )


@pytest.fixture(scope="module")
def runs(tmp_path_factory, example_in, pick_and_place) -> dict[str, tuple[Trace, dict]]:
    """The sample with light and with heavy tubes: trace and what `run --json` printed."""
    found = {}
    for weight in ("light", "heavy"):
        example = example_in(tmp_path_factory.mktemp(weight))
        example.write("pick.py", pick_and_place.replace(b"TUBES = 10", b"TUBES = %d" % TUBES))
        example.write("hardware.yaml", HARDWARE)
        example.write("heavy.yaml", heavy_tubes())
        scene = ("--scene", "heavy.yaml") if weight == "heavy" else ()
        outcome = example.run(
            "run", "pick.py", "--hardware", "hardware.yaml", "--json", "--trace", "t.json", *scene
        )
        assert outcome.code == 0, outcome.err
        found[weight] = (trace_json.loads(example.read("t.json").decode(), "t.json"), outcome.json)
    return found


def cubic_torque(trace: Trace, function: str) -> float:
    """The speed-weighted cubic mean torque of all motors over the visits of a function."""
    place = WEAR_EXPONENTS.index(3.0)
    motors = [element.name for element in trace.elements if element.kind == "joint"]
    exposures = [
        visit.exposures[motor]
        for visit in trace.visits
        if visit.function.name == function
        for motor in motors
        if motor in visit.exposures
    ]
    wear = math.fsum(each.wear[place] for each in exposures if each.wear)
    return (wear / math.fsum(each.travel_s for each in exposures)) ** (1 / 3)


def figure(outcome: dict, function: str) -> float:
    (state,) = [each for each in outcome["model"]["states"] if each["name"] == function]
    return state["probabilities"]["electric_motor"]


def test_the_grip_holds_what_is_heavy_and_every_tube_arrives(runs):
    for trace, _ in runs.values():
        moved = [each for each in trace.objects if each.goal and each.goal.startswith("target")]
        assert len(moved[:TUBES]) == TUBES
        assert all(each.upright and each.offset_m < 0.003 for each in moved[:TUBES])


@pytest.mark.parametrize(("weight", "mass"), [("light", 0.025), ("heavy", HEAVY_KG)])
def test_what_is_held_is_reported_of_those_who_carry_and_of_no_other(
    runs, weight: str, mass: float
):
    trace, _ = runs[weight]
    for visit in trace.visits:
        name, payloads = visit.function.name, visit.payloads
        assert {payload.mass_kg for payload in payloads} <= {mass}
        if name in EMPTY_HANDED:
            assert not payloads
        if name in CARRYING:
            (payload,) = payloads
            held = visit.exposures["panda_hand"]
            assert held is not None
            assert payload.held_s == pytest.approx(held.grasping_s, abs=0.05)
            assert 0.5 < payload.pad_force_n <= payload.most_pad_force_n < 40.0
    carried = [p.object for v in trace.visits if v.function.name == "pick" for p in v.payloads]
    assert carried == [f"tube_{i}" for i in range(1, TUBES + 1)]


def test_the_friction_of_the_pads_can_hold_what_is_carried(runs):
    """Two pads, each with friction 1, against the weight: nothing is held by a weld."""
    trace, _ = runs["heavy"]
    for visit in trace.visits:
        for payload in visit.payloads:
            if visit.function.name == "place_position":
                assert 2.0 * payload.pad_force_n > payload.mass_kg * 9.81


def test_a_payload_raises_the_torque_of_those_who_carry_it_alone(runs):
    (light, _), (heavy, _) = runs["light"], runs["heavy"]
    for function in CARRYING:
        assert cubic_torque(heavy, function) > 1.03 * cubic_torque(light, function)
    for function in EMPTY_HANDED:
        assert cubic_torque(heavy, function) == pytest.approx(
            cubic_torque(light, function), rel=0.01
        )


def test_with_a_load_law_the_motors_of_those_who_carry_are_likelier_to_fail(runs):
    (_, light), (_, heavy) = runs["light"], runs["heavy"]
    for function in CARRYING:
        assert figure(heavy, function) > 1.01 * figure(light, function)
    for function in EMPTY_HANDED:
        assert figure(heavy, function) == pytest.approx(figure(light, function), rel=0.01)


def test_payloads_and_contacts_of_all_visits_sum_to_those_of_the_run(runs):
    """What is held at each step belongs to one visit: the whole is as long as the grasps are."""
    for trace, _ in runs.values():
        held = math.fsum(p.held_s for visit in trace.visits for p in visit.payloads)
        assert held == pytest.approx(trace.active["panda_hand"].grasping_s, abs=0.05 * TUBES)
