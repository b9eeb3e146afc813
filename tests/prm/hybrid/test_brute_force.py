"""Random missions with every redundancy, against an enumeration of every set of failed units."""

from decimal import Decimal, localcontext
from random import Random

import pytest

from tests.prm.hybrid.brute_force import DIGITS, Mission, random_mission
from tracerisk.prm import build_model, solve


@pytest.fixture(scope="module")
def model_of(block, component):
    """Build the model of a mission from its blocks."""

    def make(mission: Mission):
        blocks = [
            block(
                function,
                number,
                [
                    component(name, use.p, mission.quantities[name], use.text)
                    for name, use in uses.items()
                ],
                after=mission.following[function],
            )
            for number, (function, uses) in enumerate(mission.uses.items(), 1)
        ]
        return build_model(blocks, name="random")

    return make


def error(found: float, expected) -> float:
    if expected == 0 or abs(expected) < 1e-80:
        return abs(found)
    return float(abs(Decimal(found) - expected) / abs(expected))


STEP = Decimal("1e-60")


def worst_errors(model_of, seeds) -> dict[str, tuple[float, int]]:
    """Return the greatest relative error of each figure, and the seed that gives it."""
    worst: dict[str, tuple[float, int]] = {}

    def note(figure: str, seed: int, found: float, expected) -> None:
        worst[figure] = max(worst.get(figure, (0.0, seed)), (error(found, expected), seed))

    for seed in seeds:
        mission = random_mission(Random(seed))
        if not any(mission.uses.values()):
            continue
        assessment = solve(model_of(mission))
        failure = mission.failure()
        note("failure", seed, assessment.mission.failure_probability, failure)
        note("success", seed, assessment.mission.done_probability, 1 - failure)
        for each in assessment.components:
            without = mission.failure({each.name: Decimal(0)})
            note("without", seed, each.without, without)
            if failure > 0:
                note("share", seed, each.fussell_vesely, (failure - without) / failure)
            if each.name.endswith("{spares}"):
                continue
            below = mission.failure({each.name: 1 - STEP})
            note("slope", seed, each.birnbaum * each.theta, (failure - below) / STEP)
    return worst


@pytest.fixture(autouse=True)
def _many_digits():
    with localcontext() as context:
        context.prec = DIGITS
        yield


def test_random_missions_equal_the_enumeration_of_failed_units(model_of):
    for figure, (worst, seed) in worst_errors(model_of, range(60)).items():
        assert worst < 1e-12, (figure, seed)


@pytest.mark.slow
def test_many_random_missions_equal_the_enumeration_of_failed_units(model_of, record_property):
    worst = worst_errors(model_of, range(1_000, 6_000))
    record_property("worst relative errors", worst)
    for figure, (found, seed) in worst.items():
        assert found < 1e-12, (figure, seed)
