"""How a run reports the uncertainty of its figure."""

from argparse import Namespace

import pytest

from tracerisk.api import build
from tracerisk.cli.solving.computed_spreads import uncertainty_of_run
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.errors import InputError

SOURCE = b"""\
def place():
    # | RiskAnnotation
    # | @Function {
    # |   name = place
    # |   callSequence = 1
    # |   next = done 1
    # | }
    # | @Component {
    # |   name = gripper
    # |   probability = 1e-8
    # |   quantity = 1
    # |   redundancy = false
    # | }
    pass
"""


def hardware(error_factor: float | None) -> Hardware:
    figure = FailureFigure("probability", 1e-8, Basis.VISIT, error_factor=error_factor)
    return Hardware("cell.yaml", (Component("gripper", (figure,)),))


def spread(error_factor: float | None, by_hand: tuple[str, ...] = (), *, asked: bool = True):
    model = build({"place.py": SOURCE}, name="place")
    options = Namespace(uncertainty=asked, samples=500, quiet=True)
    return uncertainty_of_run(model, hardware(error_factor), (), by_hand, options, seed=1)


def test_a_run_draws_the_figures_with_its_seed():
    found = spread(3.0)
    assert found is not None
    assert (found.samples, found.seed) == (500, 1)
    assert found.percentiles == pytest.approx([1e-8 / 3, 1e-8, 3e-8], rel=0.02)
    assert spread(3.0, asked=False) is None


@pytest.mark.parametrize(("error_factor", "by_hand"), [(None, ()), (3.0, ("gripper",))])
def test_without_an_error_factor_for_the_model_it_says_what_to_do(error_factor, by_hand):
    with pytest.raises(InputError) as caught:
        spread(error_factor, by_hand)
    assert str(caught.value) == (
        "cell.yaml: has no error factor for a component of the model; give its figures one, as "
        "{value: 1e-7, per: hour, error_factor: 3}, or say --error-factor 3 to `solve`"
    )


def test_samples_without_uncertainty_are_reported_before_anything_runs(example):
    example.write("cell.py", "raise SystemExit(7)\n")
    outcome = example.run("run", "cell.py", "--samples", "10")
    assert outcome.code == 2
    assert "--samples goes with --uncertainty; add it" in outcome.err
