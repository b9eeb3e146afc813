"""A description that is written as YAML reads back as the same."""

import time
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from tests.common.hardware.strategies import hardware_descriptions
from tracerisk.common.hardware.model import (
    Basis,
    Component,
    FailureFigure,
    FailureMode,
    Hardware,
    LoadLaw,
)
from tracerisk.common.hardware.shipped import shipped_hardware, shipped_names
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.common.hardware.yaml.writer import write_hardware


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("written") / "hardware.yaml"


@given(hardware=hardware_descriptions())
def test_what_is_written_reads_back_as_the_same_description(file, hardware):
    text = write_hardware(hardware)
    file.write_text(text, encoding="utf-8")
    again = read_hardware(file)
    assert again == hardware, text
    assert write_hardware(again) == text


@pytest.mark.slow(but=20)
@pytest.mark.parametrize("robot", shipped_names())
def test_shipped_descriptions_survive_writing(file, robot):
    hardware = shipped_hardware(robot)
    file.write_text(write_hardware(hardware), encoding="utf-8")
    assert read_hardware(file) == hardware


@pytest.mark.parametrize(("fit", "per_hour"), [("570", 5.7e-7), ("0.57", 5.7e-10), ("3e9", 3.0)])
def test_fit_and_the_same_rate_per_hour_are_one_figure(file, fit, per_hour):
    expected = (FailureFigure("failure_rate", per_hour, Basis.HOUR),)
    file.write_text(
        f"components: {{a: {{failure_rate: {{value: {fit}, unit: FIT}}, active: always}}}}\n"
    )
    (component,) = read_hardware(file).components
    assert component.figures == expected
    hardware = Hardware("h", (Component("a", expected, always_active=True),))
    file.write_text(write_hardware(hardware))
    assert read_hardware(file) == hardware


def test_a_thousand_components_are_read_in_less_than_a_second_of_computing(file):
    (motor,) = (
        each for each in shipped_hardware("ur5e").components if each.name == "electric_motor"
    )
    figures = (
        FailureFigure("probability", 1e-7, Basis.DEMAND, demand="start", error_factor=3.0),
        FailureFigure("failure_rate", 5.7e-7, Basis.HOUR, source="data book, table 3"),
    )
    modes = (FailureMode("jam", 0.4, ("moving", "start")), FailureMode("slip", 0.6, ("holding",)))
    many = Hardware(
        "h",
        tuple(
            replace(
                motor,
                name=f"cell{i}.motor",
                figures=figures,
                modes=modes,
                load_law=LoadLaw(0.3, 0.6),
            )
            for i in range(1000)
        ),
    )
    file.write_text(write_hardware(many), encoding="utf-8")
    begin = time.process_time()
    assert read_hardware(file) == many
    assert time.process_time() - begin < 1.0
