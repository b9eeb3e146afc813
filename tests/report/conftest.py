from collections.abc import Callable

import pytest

import tracerisk
from tracerisk.prm.review.risk_diff import Review, RiskDiff


@pytest.fixture(scope="session")
def difference(annotated_source) -> Callable[..., RiskDiff]:
    """Compare two versions of a controller, each told as `annotated_source` takes it."""

    def make(before, after, name="cell.py"):
        def sources(version):
            return {} if version is None else {"cell.py": annotated_source(**version).encode()}

        return tracerisk.diff(sources(before), sources(after), name=name)

    return make


@pytest.fixture(scope="session")
def review_of() -> Callable[..., Review]:
    def make(*controllers, notes=()):
        return Review("HEAD", "working tree", controllers, notes, ("HEAD:", ""))

    return make


@pytest.fixture(scope="session")
def eventful(difference) -> RiskDiff:
    """A change of everything that can change."""
    before = {
        "approach_the_rack_from_above": ("grasp 1", "electric_motor = 2e-8 x7; power = 1e-5 of2"),
        "grasp": ("place 1", "gripper = 1e-7"),
        "place": ("done 1", "gripper := 2e-7 ! computed 1e-7;FMEA|112 <b>"),
    }
    after = {
        "approach_the_rack_from_above": ("grasp 1", "electric_motor = 4e-8 x7; power = 1e-5 x2"),
        "grasp": ("check 1", "gripper = 1e-7"),
        "check": ("grasp 1/4, place 3/4", "camera = 1e-6"),
        "place": ("done 1", "gripper := 2e-7 ! computed 1.5e-7;FMEA|112 <b>"),
    }
    return difference(before, after)
