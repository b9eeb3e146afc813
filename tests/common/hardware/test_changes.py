"""What is said of two descriptions: old and new figures with their sources."""

from pathlib import Path

import pytest

from tracerisk.common.hardware.changes import description_changes, figure_ratios, moved_units
from tracerisk.common.hardware.formats import read_description

MOTOR = """\
components:
  motor:
    failure_rate: {value: 2.1e-7, per: hour, source: IEC 61709}
    quantity: 7
    twin: {joints: "*"}
"""


def changes(before: Path, after: Path) -> list[str]:
    """Return what differs, without the place behind each name that is not gone."""
    lines = description_changes(read_description(before), read_description(after))
    assert all(f" ({after}:2)" in line or " is gone: " in line for line in lines)
    return [line.replace(f" ({after}:2)", "") for line in lines]


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("", "", []),
        (
            "value: 2.1e-7, per: hour, source: IEC 61709",
            "value: 3.0e-7, per: hour, source: data sheet",
            ["motor: failure_rate 2.1e-07/h (IEC 61709) -> 3e-07/h (data sheet)"],
        ),
        (
            "IEC 61709",
            "IEC 61709:2017",
            ["motor: failure_rate 2.1e-07/h (IEC 61709) -> 2.1e-07/h (IEC 61709:2017)"],
        ),
        (
            "failure_rate: {value: 2.1e-7, per: hour, source: IEC 61709}",
            "probability: {value: 1e-6, per: demand}",
            [
                "motor: failure_rate 2.1e-07/h (IEC 61709) -> probability 1e-06 per demand "
                "(no source)",
            ],
        ),
        (
            "failure_rate: {value: 2.1e-7, per: hour, source: IEC 61709}",
            "probability: {value: 9.5e-08, per: minute, source: DS-114}",
            [
                "motor: failure_rate 2.1e-07/h = 3.5e-09/min (IEC 61709) -> probability "
                "9.5e-08/min (DS-114)",
            ],
        ),
        (
            "{value: 2.1e-7, per: hour, source: IEC 61709}",
            "{value: 9.5e-08, per: minute, error_factor: 3, source: DS-114}",
            [
                "motor: failure_rate 2.1e-07/h = 3.5e-09/min (IEC 61709) -> 9.5e-08/min, "
                "error factor 3 (DS-114)",
            ],
        ),
        (
            "    quantity: 7",
            "    standby_rate: {value: 1e-9, per: hour}\n    quantity: 7",
            ["motor: standby_rate not given -> 1e-09/h (no source)"],
        ),
        ("quantity: 7", "quantity: 6", ["motor: quantity 7 -> 6"]),
        (
            "quantity: 7",
            "quantity: 7\n    redundancy: true",
            ["motor: redundancy false -> true"],
        ),
        (
            "  motor:",
            "  drive:",
            [
                "drive is new: failure_rate 2.1e-07/h (IEC 61709)",
                "motor is gone: failure_rate 2.1e-07/h (IEC 61709)",
            ],
        ),
    ],
)
def test_each_value_that_differs_is_said_with_its_sources(tmp_path: Path, before, after, expected):
    paths = tmp_path / "before.yaml", tmp_path / "after.yaml"
    for path, text in zip(
        paths, (MOTOR, MOTOR.replace(before, after) if before else MOTOR), strict=True
    ):
        path.write_text(text)
    assert changes(*paths) == expected


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        ("[a, b, c]", "[a, c]", ["motor: twin.joints no longer b"]),
        ("[a, b]", "[a, c]", ["motor: twin.joints no longer b and now also c"]),
        ('"*"', "[a, c]", ["motor: twin.joints * -> a, c"]),
        # It says only that a robot may lack the component.
        ('"*"', '"*", optional: true', []),
    ],
)
def test_of_joints_those_that_differ_are_said(tmp_path: Path, before, after, expected):
    paths = tmp_path / "before.yaml", tmp_path / "after.yaml"
    for path, joints in zip(paths, (before, after), strict=True):
        path.write_text(MOTOR.replace("    quantity: 7\n", "").replace('"*"', joints))
    found = changes(*paths)
    # The number of names is a change only where it was known before.
    assert [line for line in found if ": quantity " not in line] == expected
    assert found == expected or before != '"*"'


def test_another_data_sheet_is_a_change_though_its_rate_is_the_same(tmp_path: Path):
    at = "value: 2.1e-7, per: hour, temperature: {rated: 40, working: 40, activation_energy: 0.5}"
    before = MOTOR.replace("value: 2.1e-7, per: hour", at)
    paths = tmp_path / "before.yaml", tmp_path / "after.yaml"
    for path, text in zip(paths, (before, before.replace("40", "55")), strict=True):
        path.write_text(text)
    (line,) = changes(*paths)
    assert "at 40 degC" in line
    assert "2.1e-07/h of 2.1e-07 at 55 degC" in line


@pytest.mark.parametrize(
    ("was", "now", "ratio"),
    [
        ("value: 2.1e-7, per: hour, source: IEC", "value: 4.2e-7, per: hour, source: ISO", 2.0),
        ("quantity: 7", "quantity: 6", None),
        ("IEC 61709", "IEC 61709:2017", None),
        # Where more than the figure differs, nobody knows how much each does.
        ("value: 2.1e-7, per: hour, source: IEC 61709}\n    quantity: 7",
         "value: 4.2e-7, per: hour, source: IEC 61709}\n    quantity: 6", None),
        ("per: hour", "per: minute", None),
    ],
)  # fmt: skip
def test_one_ratio_of_all_figures_is_known(tmp_path: Path, was, now, ratio):
    before, after = tmp_path / "before.yaml", tmp_path / "after.yaml"
    assert was in MOTOR
    before.write_text(MOTOR)
    after.write_text(MOTOR.replace(was, now))
    found = figure_ratios(read_description(before), read_description(after))
    assert found == ({} if ratio is None else {"motor": pytest.approx(ratio)})


def test_the_same_rate_in_fit_is_no_change(tmp_path: Path):
    fit = MOTOR.replace("value: 2.1e-7, per: hour", "value: 210, unit: FIT")
    paths = tmp_path / "before.yaml", tmp_path / "after.yaml"
    for path, text in zip(paths, (MOTOR, fit), strict=True):
        path.write_text(text)
    assert changes(*paths) == []
    paths[1].write_text(fit.replace("210", "420"))
    (line,) = changes(*paths)
    # A source that both have is said once.
    assert line == "motor: failure_rate 2.1e-07/h -> 4.2e-07/h of 420 FIT (both: IEC 61709)"


ARM = "components:\n  motor: {{probability: {{value: 1e-7, per: minute}}, twin: {{joints: {0}}}}}\n"
ELBOW = "  {0}: {{probability: {{value: 4e-7, per: minute}}, twin: {{joints: [b]}}}}\n"


@pytest.mark.parametrize(
    ("before", "after", "expected"),
    [
        (ARM.format("[a, b]"), ARM.format("[a]") + ELBOW.format("elbow"), {"elbow": ("motor",)}),
        (ARM.format('"*"'), ARM.format("[a]") + ELBOW.format("elbow"), {"elbow": ("motor",)}),
        # The joint has a brake more: nothing was moved.
        (ARM.format("[a, b]"), ARM.format("[a, b]") + ELBOW.format("brake"), {}),
        (ARM.format("[a, b]"), ARM.format('"*"') + ELBOW.format("brake"), {}),
        (ARM.format("[a]"), ARM.format("[a]") + ELBOW.format("elbow"), {}),
        (ARM.format("[a]") + ELBOW.format("elbow"), ARM.format("[a, b]"), {}),
    ],
)
def test_a_joint_that_another_component_gave_up_is_known(tmp_path, before, after, expected):
    paths = tmp_path / "before.yaml", tmp_path / "after.yaml"
    for path, text in zip(paths, (before, after), strict=True):
        path.write_text(text)
    assert moved_units(*(read_description(path) for path in paths)) == expected
