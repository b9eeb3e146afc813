"""A mission as one fault tree, against what the chain says of it."""

from fractions import Fraction
from random import Random

import pytest

from tests.prm.hybrid.brute_force import random_mission
from tracerisk.prm import HybridModel, build_model, solve
from tracerisk.prm.hybrid.mission_tree import mission_tree, visits_without_failure


def hybrid(block, component, mission) -> HybridModel:
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


def test_random_missions_have_the_figure_of_the_mission_as_executed(block, component):
    compared = 0
    for seed in range(300):
        mission = random_mission(Random(seed))
        if not any(mission.uses.values()):
            continue
        model = hybrid(block, component, mission)
        made = mission_tree(model)
        expected = solve(model).mission.visits_as_run
        if made is None:
            assert expected == 0.0 or any(state.spares for state in model.states)
            continue
        assert made.probability == pytest.approx(expected, rel=1e-11, abs=1e-300), seed
        compared += 1
    assert compared > 100


def test_visits_are_counted_exactly(block, component):
    motor = component("motor", 1e-7)
    model = build_model(
        [
            block("init", 1, [motor], after={"pick": "1"}, counts=True),
            block("pick", 2, [motor], after={"place": "9/10", "pick": "1/10"}),
            block("place", 3, [motor], after={"pick": "6/7", "done": "1/7"}, counts=True),
        ],
        name="cell",
    )
    assert visits_without_failure(model) == {
        "init": 1,
        "pick": Fraction(70, 9),
        "place": 7,
    }
