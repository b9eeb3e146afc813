from pathlib import Path

import pytest

from tests.common.hardware.broken import BROKEN as BROKEN_BLOCKS
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    LoadLaw,
    TwinBinding,
)
from tracerisk.common.hardware.redundancy import Redundancy, Repair
from tracerisk.common.hardware.shipped import shipped_hardware
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.errors import HardwareError


def read(tmp_path: Path, text: str):
    path = tmp_path / "hardware.yaml"
    path.write_text(text, encoding="utf-8")
    return read_hardware(path, shown="hardware.yaml")


def test_every_basis_is_read(tmp_path):
    hardware = read(
        tmp_path,
        """\
components:
  a: {probability: 1e-7, active: always}
  b: {probability: {value: 2e-7, per: demand}, twin: {gripper: true}}
  c: {probability: {value: 3e-7, per: minute}, twin: {joints: "*"}}
  d: {failure_rate: {value: 5.7e-06, per: hour}, twin: {joints: [j1, j2]}, redundancy: true}
  e: {failure_rate: {value: 57, unit: FIT}, quantity: 3, active: always}
  f: {probability: {value: 1e-6, per: demand}, failure_rate: {value: 1, per: hour}, twin: {gripper: true}}
""",
    )
    a, b, c, d, e, f = hardware.components
    assert a.figures == (FailureFigure("probability", 1e-7, Basis.VISIT),)
    assert b.figures == (FailureFigure("probability", 2e-7, Basis.DEMAND),)
    assert c.figures == (FailureFigure("probability", 3e-7, Basis.MINUTE),)
    assert d.figures == (FailureFigure("failure_rate", 5.7e-06, Basis.HOUR),)
    (rate,) = e.figures
    assert rate == FailureFigure("failure_rate", 5.7e-08, Basis.HOUR)
    assert rate.stated == "57 FIT"
    assert len(f.figures) == 2
    assert (a.quantity, c.quantity, d.quantity, e.quantity) == (1, None, 2, 3)
    assert (a.always_active, b.always_active) == (True, False)
    assert (c.twin, d.redundancy) == (TwinBinding(joints="*"), Redundancy(True))


BROKEN = {
    "components: {a: {probability: 1.5, active: always}}": "1:18: components.a.probability: 1.5 is outside",
    "components: {a: {probability: -1e-9, active: always}}": "outside [0, 1]",
    "components: {a: {probability: .nan, active: always}}": "finite",
    "components: {a: {probability: {value: 1e-7, per: fortnight}}}": "allowed: demand, hour, minute, visit",
    "components: {a: {failure_rate: {value: 1e-7, per: visit}}}": "allowed: hour, minute",
    "components: {a: {failure_rate: {value: -1, per: hour}}}": "outside [0, inf]",
    "components: {a: {failure_rate: {value: 1, unit: fits}}}": "'fits' is not allowed; allowed: FIT",
    "components: {a: {failure_rate: {value: 1, unit: FIT, per: hour}}}": "remove 'per'",
    "components: {a: {probability: {per: hour}}}": "'value' is missing in components.a.probability",
    "components: {a: {active: always}}": "has no failure figure",
    "components: {a: {probability: 1e-7, quantitty: 2}}": "did you mean 'quantity'?",
    "components: {a: {probability: 1e-7, quantity: 0}}": "below 1",
    "components: {a: {probability: 1e-7, quantity: 1.5}}": "expected a whole number",
    "components: {a: {probability: 1e-7, redundancy: maybe}}": "expected true or false",
    "components: {a: {probability: 1e-7, detected: each_visit}}": "units that are all needed",
    "components: {a: {probability: 1e-7, redundancy: true, detected: never}}": (
        "components.a.detected: 'never' is not allowed; allowed: each_visit, mission_start"
    ),
    "components: {a: {probability: 1e-7, redundancy: true, detected: {test_interval: 8}}}": (
        "'per' is missing"
    ),
    "components: {a: {probability: 0, redundancy: true, detected: {test_interval: 0, per: hour}}}": (
        "components.a.detected.test_interval: is 0; give a number above 0"
    ),
    "components: {a: {probability: 1e-7, active: often}}": "allowed: always",
    "components: {a: {probability: 1e-7, twin: {}}}": "is empty",
    "components: {a: {probability: 1e-7, twin: {joints: all}}}": 'write "*"',
    "components: {a: {probability: 1e-7, twin: {joints: [j, j]}}}": "names 'j' twice",
    "components: {a: {probability: 1e-7, twin: {joints: []}}}": "empty list",
    "components: {a: {probability: 1e-7, quantity: 3, twin: {joints: [j, k]}}}": "names 2 places",
    "components: {a: {probability: 1e-7, twin: {gripper: false}}}": "there is no other binding",
    "components: {a: {probability: 1e-7, active: always, twin: {gripper: true}}}": "either",
    "components: {'two words': {probability: 1e-7}}": "not a component's name",
    "components: {a: {probability: {value: 1e-7, per: demand}, active: always}}": "has no demands",
    "components: {}": "has no components;",
    "components: []": "expected a mapping, found a list",
    "parts: {}": "unknown key 'parts'",
    "components: {a: {probability: 1, active: always}, a: {probability: 1}}": "not valid YAML",
    "components: {a: [": "not valid YAML",
    "": "expected a mapping at the top, found nothing",
}


@pytest.mark.parametrize(("text", "message"), BROKEN.items())
def test_broken_description_is_an_error_with_file_and_line(tmp_path, text, message):
    with pytest.raises(HardwareError) as caught:
        read(tmp_path, text)
    assert message in str(caught.value)
    assert str(caught.value).startswith("hardware.yaml:1:")


def test_absent_and_binary_files_are_named(tmp_path):
    with pytest.raises(HardwareError, match=r"gone\.yaml: cannot be read"):
        read_hardware(tmp_path / "gone.yaml", shown="gone.yaml")
    (tmp_path / "b.yaml").write_bytes(b"components:\n  \xff: 1\n")
    with pytest.raises(HardwareError, match=r"b\.yaml:2: is not UTF-8"):
        read_hardware(tmp_path / "b.yaml", shown="b.yaml")


def test_shipped_panda_holds_the_published_figures():
    by_name = {c.name: c for c in shipped_hardware("panda").components}
    figures = {name: c.figures[0].value for name, c in by_name.items()}
    assert figures == {
        "power_system": 6.674e-08,
        "control_system": 2.167e-10,
        "gripper": 7.344e-08,
        "electric_motor": 9.5e-08,
    }
    assert all(c.figures[0].per is Basis.MINUTE for c in by_name.values())
    assert by_name["power_system"].redundancy == Redundancy(True)
    assert by_name["electric_motor"].quantity == 7


def test_robot_without_shipped_hardware_is_an_error_that_lists_those_with():
    with pytest.raises(HardwareError, match=r"allowed: .*panda"):
        shipped_hardware("r2d2")


@pytest.mark.parametrize(
    ("figure", "detected", "expected"),
    [
        ("{value: 1e-7, per: hour}", "", ("mission_start", None)),
        ("{value: 1e-7, per: hour}", ", detected: each_visit", ("each_visit", None)),
        # The published reading: a figure for each visit, and groups renewed with each.
        ("1e-7", "", ("each_visit", None)),
        ("1e-7", ", detected: mission_start", ("mission_start", None)),
        (
            "{value: 1e-7, per: visit}",
            ", detected: {test_interval: 0.5, per: hour}",
            ("mission_start", 1800.0),
        ),
    ],
)
def test_when_a_hidden_failure_is_detected_is_read_or_follows_from_the_figures(
    tmp_path, figure, detected, expected
):
    path = tmp_path / "h.yaml"
    path.write_text(
        "components:\n"
        f"  a: {{probability: {figure}, quantity: 2, redundancy: true, active: always{detected}}}\n"
    )
    (component,) = read_hardware(path).components
    assert (component.redundancy.detected, component.test_interval_s) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{mean_time: 8, per: hour}", Repair(28800.0)),
        ("{rate: 0.125, per: hour}", Repair(28800.0)),
        ("{mean_time: 30, per: minute, in_mission: true}", Repair(1800.0, True)),
    ],
)
def test_repair_is_read_as_a_time_or_a_rate(tmp_path, text, expected):
    path = tmp_path / "h.yaml"
    path.write_text(
        "components:\n  a: {failure_rate: {value: 1e-7, per: hour}, quantity: 2, "
        f"redundancy: true, active: always, repair: {text}}}\n"
    )
    (component,) = read_hardware(path).components
    assert component.repair == expected
    assert component.redundancy.detected == "mission_start"


@pytest.mark.parametrize("broken", BROKEN_BLOCKS, ids=lambda broken: broken.message.split(":")[3])
def test_each_fault_is_reported_at_its_line_and_column(tmp_path, broken):
    path = tmp_path / "h.yaml"
    path.write_text(broken.text, encoding="utf-8")
    with pytest.raises(HardwareError) as caught:
        read_hardware(path, shown="h.yaml")
    assert str(caught.value) == broken.message


def test_every_key_of_a_component_is_read(tmp_path):
    hardware = read(
        tmp_path,
        """\
robot: ur5e
source: "the maker's data book"
components:
  arm.joint.motor:
    twin: {joints: [j1, j2, j3]}
    required: 2
    common_cause: {beta: 0.1}
    detected: {test_interval: 8, per: hour}
    probability:
      - {value: 1e-7, per: demand, of: start, error_factor: 3, value_is: mean, source: "assumed"}
      - {value: 2e-7, per: hour}
    failure_rate: {value: 570, unit: FIT, error_factor: 10}
    standby_rate: {value: 1e-8, per: hour}
    weibull: {shape: 2.0, scale: 30000, per: hour}
    age: {value: 12000, per: hour}
    load_law: {reference_load: 0.3, wearing_share: 0.6, exponent: 10/3, reference_speed: 0.2}
    modes:
      lost_torque: {fraction: 0.6, when: [moving, holding, start]}
      jam: {fraction: 0.4, when: [moving], source: "assumed: a third"}
    source: "test report 7"
  pump:
    failure_rate: {value: 1e-6, per: hour}
    quantity: 3
    spare: warm
    dormancy: 0.2
    switch: 0.01
    active: always
  camera:
    failure_rate: {value: 1e-6, per: hour}
    twin: {sensors: camera, optional: true, contacts: [hand], actuators: [j1], gripper: true}
""",
    )
    motor, pump, camera = hardware.components
    assert (hardware.robot, hardware.source) == ("ur5e", "the maker's data book")
    assert motor == Component(
        "arm.joint.motor",
        (
            FailureFigure(
                "probability",
                1e-7,
                Basis.DEMAND,
                demand="start",
                error_factor=3.0,
                value_is="mean",
                source="assumed",
            ),
            FailureFigure("probability", 2e-7, Basis.HOUR),
            FailureFigure("failure_rate", 5.7e-7, Basis.HOUR, error_factor=10.0),
            FailureFigure("failure_rate", 1e-8, Basis.HOUR, standby=True),
            FailureFigure("weibull", 30000.0, Basis.HOUR, shape=2.0),
        ),
        quantity=3,
        redundancy=Redundancy(True, required=2, common_cause=0.1),
        twin=TwinBinding(joints=("j1", "j2", "j3")),
        load_law=LoadLaw(0.3, 0.6, 10 / 3, 0.2),
        modes=(
            FailureMode("lost_torque", 0.6, ("moving", "holding", "start")),
            FailureMode("jam", 0.4, ("moving",), "assumed: a third"),
        ),
        age_s=12000 * 3600.0,
        source="test report 7",
        test_interval_s=8 * 3600.0,
    )
    assert motor.is_assumed
    assert pump.redundancy == Redundancy(True, dormancy=0.2, switch=0.01)
    assert not pump.is_assumed
    assert camera.twin == TwinBinding((), True, True, ("j1",), "camera", ("hand",))
    assert camera.quantity is None


def test_merged_keys_are_read_and_faults_in_them_have_a_place(tmp_path):
    text = """\
components:
  one: &motor
    failure_rate: {value: 1e-6, per: hour}
    twin: {joints: [j1]}
  two:
    <<: *motor
    twin: {joints: [j2]}
"""
    one, two = read(tmp_path, text).components
    assert (two.figures, two.twin) == (one.figures, TwinBinding(joints=("j2",)))
    with pytest.raises(
        HardwareError, match=r"^hardware\.yaml:3:5: a\.age: applies to wear-out only"
    ):
        read(tmp_path, "components:\n  a:\n    age: {value: 1, per: hour}\n    probability: 1\n")
    broken = text.replace("twin: {joints: [j2]}", "active: always")
    with pytest.raises(HardwareError, match=r"^hardware\.yaml:7:5: two\.active: .* either"):
        read(tmp_path, broken)
    broken = text.replace("twin: {joints: [j2]}", "quantity: 0")
    with pytest.raises(HardwareError, match=r"^hardware\.yaml:7:5: "):
        read(tmp_path, broken)
    merged = text.replace("  one: &motor\n", "  one: &motor\n    age: {value: 1, per: hour}\n")
    with pytest.raises(HardwareError, match=r"^hardware\.yaml:3:5: one\.age"):
        read(tmp_path, merged)
