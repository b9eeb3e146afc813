"""The instances behind a block's value: by function, over the mission, and in the lock."""

import pytest

from tracerisk.adder.figures.computed import compute_blocks
from tracerisk.common.function_ref import FunctionRef, QualifiedName
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.traced.elements import Element, Exposure
from tracerisk.pipeline.trace.summary import trace_summary
from tracerisk.prm import solve
from tracerisk.prm.hybrid.from_blocks import build_model
from tracerisk.trace import RunEnd, Trace, TracedFunction, Visit

PICK = FunctionRef("cell.py", QualifiedName("pick"))
PLACE = FunctionRef("cell.py", QualifiedName("place"))
HARDWARE = """\
components:
  motor: {{quantity: 2, failure_rate: {{value: 3.6e-3, per: hour}}, twin: {{joints: "*"}}{more}}}
  power: {{failure_rate: {{value: 1e-6, per: hour}}, active: always}}
"""


def exposed(seconds: float) -> Exposure:
    return Exposure(moving_s=seconds, active_s=seconds, longest_moving_s=9, longest_active_s=9)


def trace_of(*visits: tuple[FunctionRef, float, float]) -> Trace:
    return Trace(
        controller="cell.py",
        robot="panda",
        scene="bench",
        end=RunEnd("ended", "returned", 1.0),
        elements=(Element("joint1", "joint"), Element("joint2", "joint")),
        functions=tuple(
            TracedFunction(ref, 1, rank)
            for rank, ref in enumerate(dict.fromkeys(ref for ref, _, _ in visits), start=1)
        ),
        visits=tuple(
            Visit(ref, 0.0, a + b, "succeeded", {"joint1": exposed(a), "joint2": exposed(b)})
            for ref, a, b in visits
        ),
    )


TRACE = trace_of((PICK, 1.0, 3.0), (PLACE, 4.0, 4.0), (PICK, 3.0, 3.0))


@pytest.fixture
def computed(tmp_path):
    def make(trace, more=""):
        path = tmp_path / "hardware.yaml"
        path.write_text(HARDWARE.format(more=more))
        return compute_blocks(trace, read_hardware(path), active="moving+holding")

    return make


def test_each_unit_has_its_probability_in_a_visit_and_over_the_mission(computed):
    motor, power = computed(TRACE).instances
    # A rate of 1e-6 a second.
    assert motor.in_function(PICK) == pytest.approx({"joint1": 2e-6, "joint2": 3e-6}, rel=1e-5)
    assert motor.in_function(PLACE) == pytest.approx({"joint1": 4e-6, "joint2": 4e-6}, rel=1e-5)
    one, other = motor.instances
    assert (one.p_failure, other.p_failure) == pytest.approx((8e-6, 10e-6), rel=1e-4)
    assert (one.share, other.share) == pytest.approx((8 / 18, 10 / 18), rel=1e-12)
    assert not motor.are_alike
    # What the twin sees nowhere has no instances.
    assert (power.component.name, power.instances) == ("power", ())


def test_units_of_one_element_are_one_instance(computed):
    more = ", redundancy: true"
    motor, _ = computed(TRACE, more).instances
    assert [each.fussell_vesely for each in motor.instances] == [1.0, 1.0]
    assert [each.units for each in motor.instances] == [1, 1]


def test_a_hidden_pair_has_the_mission_that_its_units_have_however_it_is_cut(computed):
    # One function uses the first joint, the other the second: alone neither could fail the pair.
    trace = trace_of((PICK, 5.0, 0.0), (PLACE, 0.0, 5.0))
    pick, place = computed(trace, ", redundancy: true").blocks.values()
    per_visit = [pick.components[0].probability.value, place.components[0].probability.value]
    assert per_visit == pytest.approx([2.5e-6, 2.5e-6], rel=1e-3)


def test_the_lock_holds_four_digits_and_keeps_what_is_within_the_noise(computed):
    first = trace_summary(TRACE, computed(TRACE).instances)
    assert first["functions"]["pick"]["instances"] == {
        "motor": {"joint1": 2e-6, "joint2": 3e-6},
    }
    near = trace_of((PICK, 1.01, 3.0), (PLACE, 4.0, 4.0), (PICK, 3.01, 3.1))
    again = trace_summary(near, computed(near).instances, kept=first, noise=0.01)
    kept = again["functions"]["pick"]["instances"]["motor"]
    assert kept == {"joint1": 2e-6, "joint2": 3.05e-6}
    fresh = trace_summary(near, computed(near).instances)
    assert fresh["functions"]["pick"]["instances"]["motor"]["joint1"] == 2.01e-6


@pytest.mark.parametrize(
    "more",
    [", redundancy: true", ", redundancy: true, common_cause: {beta: 0.1}", ""],
    ids=["hidden pair", "with a common cause", "each needed"],
)
def test_cutting_a_function_in_two_moves_no_figure_of_the_mission(computed, more):
    # The one joint works in the first half of the function, the other in the second.
    def mission(trace):
        blocks = list(computed(trace, more).blocks.values())
        model = build_model(blocks, name="cell.py")
        return solve(model).mission.failure_probability

    whole = trace_of((PICK, 500.0, 100.0))
    cut = trace_of((PICK, 490.0, 0.0), (PLACE, 10.0, 100.0))
    # Four digits of a block are what is left of it.
    assert mission(cut) == pytest.approx(mission(whole), rel=1e-3)
