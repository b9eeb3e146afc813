"""What follows a failure in functions with redundant groups: by enumeration, or refused."""

from collections.abc import Mapping
from dataclasses import replace
from decimal import Decimal, localcontext
from fractions import Fraction
from random import Random

import pytest

from tests.prm.hybrid.brute_force import DIGITS, Mission, Use, random_mission
from tracerisk.adder.blocks.block import Field
from tracerisk.adder.blocks.failures import read_failures
from tracerisk.adder.blocks.values import read_redundancy
from tracerisk.errors import BlockError
from tracerisk.prm import HybridModel, build_model, solve
from tracerisk.prm.other_models.formats.expanded_chain import expanded_chain

SECTION = "dead 4/5: stopped safely 1/2, stopped late 1/8, unaware 1/8, back to f0 1/4"
SHARES = {
    "unaware": Fraction(3, 10),
    "late": Fraction(1, 10),
    "safely": Fraction(2, 5),
    "back": Fraction(1, 5),
}
"""The shares of `SECTION` in all failures of the drive."""


@pytest.fixture
def said(component):
    """Make a component of which a section says what follows its failures."""

    def make(name, p, text, quantity=1, redundancy="false"):
        entry = component(name, p, quantity, redundancy)
        return replace(entry, failures=Field(read_failures(text), text))

    return make


@pytest.fixture
def model_of(block, component, said):
    """Build the model of a mission with a drive of its own in some functions."""

    def make(mission: Mission, drives: Mapping[str, float]) -> HybridModel:
        blocks = []
        for number, (function, uses) in enumerate(mission.uses.items(), 1):
            entries = [
                component(name, use.p, mission.quantities[name], use.text)
                for name, use in uses.items()
            ]
            if function in drives:
                entries.append(said("drive", drives[function], SECTION))
            blocks.append(block(function, number, entries, after=mission.following[function]))
        return build_model(blocks, name="random")

    return make


def failing(mission: Mission, drives: Mapping[str, float], *ways: str) -> Decimal:
    """Return how likely a mission ends in these ways, in which other stops end it well.

    What does not fail a visit of the drive is a way on from it.
    """
    uses, following = dict(mission.uses), dict(mission.following)
    only = read_redundancy("false")
    for function, value in drives.items():
        p = Fraction(value)
        fails = p * sum(SHARES[way] for way in ways)
        stops = p * sum(SHARES[way] for way in ("late", "safely") if way not in ways)
        ends, back = (part / (1 - fails) for part in (stops, p * SHARES["back"]))
        chance = Decimal(fails.numerator) / Decimal(fails.denominator)
        uses[function] = {**uses[function], "drive": Use(chance, only, "false")}  # type: ignore[arg-type]
        row = {target: w * (1 - ends - back) for target, w in following[function].items()}
        row["done"] = row.get("done", Fraction(0)) + ends
        row["f0"] = row.get("f0", Fraction(0)) + back
        following[function] = row
    quantities = {**mission.quantities, "drive": 1}
    return Mission(quantities, uses, following).failure()


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("block_of_seeds", range(4))
def test_functions_with_any_redundancy_equal_the_enumeration(model_of, block_of_seeds):
    with localcontext() as context:
        context.prec = DIGITS
        for seed in range(40 * block_of_seeds, 40 * block_of_seeds + 40):
            draw = Random(seed)
            mission = random_mission(draw)
            drives = {
                f: draw.choice([1e-9, 1e-3, 0.3]) for f in mission.uses if draw.random() < 0.8
            }
            if not drives:
                continue
            model = model_of(mission, drives)
            found = solve(model).mission
            unaware = failing(mission, drives, "unaware")
            undetected = failing(mission, drives, "unaware", "late")
            failure = failing(mission, drives, "unaware", "late", "safely")
            for figure, expected in (
                (found.failure_probability, failure),
                (found.undetected_probability, undetected),
                (found.stopped_late_probability, undetected - unaware),
                (found.stopped_safely_probability, failure - undetected),
            ):
                assert figure == pytest.approx(float(expected), rel=1e-11, abs=1e-80), seed


def test_the_chain_written_out_has_each_end(model_of):
    draw = Random(3)
    model = model_of(random_mission(draw), {"f0": 0.01})
    mission = solve(model).mission
    ends = expanded_chain(model).solve(model.entry).absorption()
    assert ends["stopped_late"] == pytest.approx(mission.stopped_late_probability, rel=1e-12)
    assert ends["stopped_safely"] == pytest.approx(mission.stopped_safely_probability, rel=1e-12)
    undetected = ends["unaware"] + ends["stopped_late"]
    assert undetected == pytest.approx(mission.undetected_probability, rel=1e-12)


@pytest.mark.parametrize(
    "redundancy",
    ["true", "required 2", "true, spare cold", "true, common_cause 0.1, detected each_visit"],
)
def test_a_redundant_group_has_no_section(block, said, redundancy):
    entry = said("drive", 0.1, SECTION, 3, redundancy)
    with pytest.raises(BlockError, match=r"function 'f0': what follows failures of 'drive' can be"):
        build_model([block("f0", 1, [entry])], name="m")


@pytest.mark.parametrize("quantity", [1, 3])
def test_a_group_has_no_section_where_another_function_needs_every_unit(
    block, component, said, quantity
):
    blocks = [
        block("f0", 1, [said("drive", 0.1, SECTION, quantity)]),
        block("f1", 2, [component("drive", 0.1, 3, "true")]),
    ]
    with pytest.raises(
        BlockError, match=r"failures of 'drive' .* redundant in 'f1', .* delete its `@Failure`"
    ):
        build_model(blocks, name="m")
