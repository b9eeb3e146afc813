"""The band that is shown without being asked for."""

import math

import pytest

from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.pipeline.failure_data import band as module
from tracerisk.pipeline.failure_data.band import figure_band
from tracerisk.prm import FaultTree, HybridModel

TREE = FaultTree.of("step fails", {"step fails": ("or", "motor", "gripper")})
MODEL = HybridModel.of("arm", {"step": TREE}, values={"motor": 1e-6, "gripper": 1e-30})


@pytest.fixture
def hardware(tmp_path):
    def make(**figures: str):
        lines = [
            f"  {name}: {{probability: {{value: 1e-6, per: minute{more}}}, active: always}}\n"
            for name, more in figures.items()
        ]
        path = tmp_path / "hardware.yaml"
        path.write_text("components:\n" + "".join(lines))
        return read_hardware(path)

    return make


def of(description, by_hand=()):
    return figure_band(MODEL, description, (), by_hand, robot="", seed=0)


def test_it_is_that_of_the_lognormal_where_one_figure_counts(hardware):
    band = of(hardware(motor=", error_factor: 3", gripper=""))
    assert band.low == pytest.approx(1e-6 / 3, rel=0.01)
    assert band.high == pytest.approx(3e-6, rel=0.01)
    assert (band.drawn, band.exact) == (("motor",), ("gripper",))
    assert band.words == (
        f"With 90 % probability that figure lies between {band.low:.1e} and {band.high:.1e}, by "
        "the error factors of motor in 2,000 samples; gripper has none and counts as exact. "
        f"The mean is {band.mean:.1e}, {100.0 * (band.mean / 1e-6 - 1.0):.2g} % above the figure."
    )
    # exp(sigma^2 / 2) times the median, where 1.645 sigma is the logarithm of the error factor.
    assert band.mean == pytest.approx(1e-6 * math.exp((math.log(3.0) / 1.6449) ** 2 / 2), rel=0.02)


def test_a_mean_that_few_draws_decide_is_not_told():
    band = module.Band(1e-9, 1e-3, ("motor",), (), None, 1e-6)
    assert "Their mean hangs on the few greatest of them" in band.words


def test_without_an_error_factor_there_is_none(hardware):
    assert of(hardware(motor="", gripper="")) is None
    assert of(hardware(motor=", error_factor: 3", gripper=""), by_hand=["motor"]) is None


def test_without_what_draws_samples_there_is_none(hardware, monkeypatch):
    monkeypatch.setattr(module, "is_installed", lambda name: name != "scipy")
    description = hardware(motor=", error_factor: 3", gripper="")
    assert of(description) is None
    assert module.band_lacks(description) == (
        "How far that figure may be off follows from the error factors of motor; `pip install "
        "'tracerisk[large]'` brings what draws samples of them."
    )
    assert module.band_lacks(hardware(motor="", gripper="")) == ""


def test_where_samples_can_be_drawn_nothing_is_lacking(hardware):
    assert module.band_lacks(hardware(motor=", error_factor: 3", gripper="")) == ""


def test_the_same_inputs_give_the_same_band(hardware):
    description = hardware(motor=", error_factor: 3", gripper=", error_factor: 10")
    assert of(description) == of(description)
    assert of(description).exact == ()
