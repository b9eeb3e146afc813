"""Missions whose numbers of cycles are counted: the fixed reading holds."""

import math
from dataclasses import replace
from fractions import Fraction

import pytest

from tracerisk.prm import build_model, solve
from tracerisk.prm.formats.model_json import dumps, loads
from tracerisk.prm.review.risk_change import compare

P = 1e-3


@pytest.fixture
def looped(block, component):
    """Makes a model that visits one function `cycles` times, with a group of units in it."""

    def make(cycles, quantity=2, redundancy="true", p=P, pieces=1, counts=True):
        share = -math.expm1(math.log1p(-p) / pieces)
        parts = (component("cell", share, quantity, redundancy),)
        names = [f"f{number}" for number in range(pieces)]
        blocks = [
            block(name, rank, parts, after={names[rank]: 1}, counts=True)
            for rank, name in enumerate(names[:-1], start=1)
        ]
        ends = {names[0]: Fraction(cycles - 1, cycles), "done": Fraction(1, cycles)}
        last = block(names[-1], pieces, parts, after=ends, counts=counts)
        return build_model([*blocks, last], name="m")

    return make


@pytest.mark.parametrize("units", [1, 2, 3, 5])
def test_one_of_several_units_has_the_figure_of_all_cycles(looped, units):
    mission = solve(looped(100, units)).mission
    assert mission.reading == "fixed cycles"
    assert mission.failure_probability == mission.fixed_cycles
    unit = -math.expm1(100 * math.log1p(-P))
    assert mission.failure_probability == pytest.approx(unit**units, rel=1e-12)
    # A geometric number of cycles around 100 is about units! times as often fatal.
    assert mission.geometric_cycles > mission.fixed_cycles * (1 if units == 1 else 1.5) * 0.95


@pytest.mark.parametrize("redundancy", ["true", "required 2", "true, spare cold", "false"])
@pytest.mark.parametrize("cycles", [2, 7, 500])
def test_cutting_a_function_in_a_loop_changes_nothing(looped, redundancy, cycles):
    whole = solve(looped(cycles, 3, redundancy)).mission.failure_probability
    for pieces in (2, 10):
        cut = solve(looped(cycles, 3, redundancy, pieces=pieces)).mission.failure_probability
        assert cut == pytest.approx(whole, rel=1e-6)


@pytest.fixture
def nested(block, component):
    """A way in, ten rounds of a step, an inner loop of five and a step, and a way out."""
    pair = (component("cell", P, 2, "true"), component("arm", 1e-5))
    return build_model(
        [
            block("begin", 1, pair, after={"pick": 1}, counts=True),
            block("pick", 2, pair, after={"shake": 1}, counts=True),
            block("shake", 3, pair, after={"shake": "4/5", "place": "1/5"}, counts=True),
            block("place", 4, pair, after={"pick": "9/10", "home": "1/10"}, counts=True),
            block("home", 5, pair, after={"done": 1}, counts=True),
        ],
        name="nested",
    )


def test_loops_behind_the_entry_and_within_each_other_go_round_as_counted(nested):
    mission = solve(nested).mission
    visits = 1 + 10 * (1 + 5 + 1) + 1
    pair = -math.expm1(visits * math.log1p(-P))
    alone = -math.expm1(visits * math.log1p(-1e-5))
    assert mission.failure_probability == pytest.approx(1 - (1 - pair**2) * (1 - alone), rel=1e-12)
    assert mission.visits_as_run == pytest.approx(mission.failure_probability, rel=1e-12)
    assert mission.geometric_cycles > 1.3 * mission.failure_probability


@pytest.mark.parametrize(
    ("after", "visits"),
    [
        # A loop within a loop at one head: three rounds, in each of them three and one visits.
        ({"a": {"a": "6/9", "b": "3/9"}, "b": {"a": "2/3", "done": "1/3"}}, {"a": 9, "b": 3}),
        # The inner loop has two functions.
        (
            {
                "a": {"b": 1},
                "b": {"a": "4/6", "c": "2/6"},
                "c": {"a": "1/2", "done": "1/2"},
            },
            {"a": 6, "b": 6, "c": 2},
        ),
        # Three loops at one head, and a way out behind them.
        (
            {
                "a": {"a": "4/8", "b": "4/8"},
                "b": {"a": "2/4", "c": "2/4"},
                "c": {"a": "1/2", "d": "1/2"},
                "d": {"done": 1},
            },
            {"a": 8, "b": 4, "c": 2, "d": 1},
        ),
        # Such loops within a loop of another head.
        (
            {
                "d": {"a": 1},
                "a": {"a": "12/18", "b": "6/18"},
                "b": {"a": "4/6", "d": "1/6", "done": "1/6"},
            },
            {"a": 18, "b": 6, "d": 2},
        ),
    ],
)
@pytest.mark.parametrize("quantity", [1, 2])
def test_loops_that_begin_at_the_head_of_others_go_round_as_counted(
    block, component, after, visits, quantity
):
    parts = (component("arm", 0.01, quantity, "true" if quantity > 1 else "false"),)
    blocks = [
        block(name, rank, parts, after=ways, counts=True)
        for rank, (name, ways) in enumerate(after.items(), start=1)
    ]
    mission = solve(build_model(blocks, name="m")).mission
    assert mission.reading == "fixed cycles"
    unit = 1 - 0.99 ** sum(visits.values())
    assert mission.failure_probability == pytest.approx(unit**quantity, rel=1e-12)
    assert mission.visits_as_run == pytest.approx(mission.failure_probability, rel=1e-12)


def test_a_head_that_ends_rounds_unevenly_is_a_branch(block, component):
    """Nine visits in four rounds are no loop within a loop."""
    arm = (component("arm", P),)
    after = {"a": {"a": "5/9", "b": "4/9"}, "b": {"a": "3/4", "done": "1/4"}}
    blocks = [
        block(name, rank, arm, after=ways, counts=True)
        for rank, (name, ways) in enumerate(after.items(), start=1)
    ]
    mission = solve(build_model(blocks, name="m")).mission
    sound = (1 - P) * (5 / 9 + 4 / 9 * (1 - P))
    assert mission.failure_probability == pytest.approx(1 - sound**9, rel=1e-12)


def test_branches_within_a_round_are_taken_by_their_shares(block, component):
    arm = (component("arm", P),)
    model = build_model(
        [
            block("pick", 1, arm, after={"retry": "3/10", "place": "7/10"}, counts=True),
            block("retry", 2, arm, after={"place": 1}, counts=True),
            block("place", 3, arm, after={"pick": "9/10", "done": "1/10"}, counts=True),
        ],
        name="m",
    )
    mission = solve(model).mission
    assert mission.reading == "fixed cycles"
    sound = (1 - P) ** 2 * (0.7 + 0.3 * (1 - P))
    assert mission.failure_probability == pytest.approx(1 - sound**10, rel=1e-12)


def test_a_distribution_keeps_the_geometric_reading(looped, block, component):
    assert solve(looped(100, counts=False)).mission.reading == "geometric cycles"
    parts = (component("arm", P),)
    by_hand = block("a", 1, parts, after={"a": "9/10", "done": "1/10"}, counts=True)
    by_hand = replace(by_hand, next=replace(by_hand.next, pinned=True))
    mission = solve(build_model([by_hand], name="m")).mission
    assert mission.reading == "geometric cycles"
    assert mission.failure_probability == mission.geometric_cycles
    profile = {"a": {"a": Fraction(9, 10), "done": Fraction(1, 10)}}
    published = build_model([block("a", 1, parts)], profile=profile, name="m")
    assert solve(published).mission.reading == "geometric cycles"


def test_shares_that_no_mission_can_count_are_a_distribution(block, component):
    parts = (component("arm", P),)
    ends = {"a": "2/7", "done": "5/7"}
    found = solve(build_model([block("a", 1, parts, after=ends, counts=True)], name="m"))
    assert found.mission.reading == "geometric cycles"


def test_the_json_of_a_model_keeps_the_reading(nested):
    again = loads(dumps(nested), "m.json")
    assert again == nested
    assert solve(again).mission == solve(nested).mission


def test_counting_cycles_that_were_a_distribution_is_no_change_of_risk(versions_of):
    before, after = versions_of(pinned=True), versions_of(pinned=False)
    diff = compare(before, after, name="m", cause_of=lambda *_: ())
    assert diff.before.reading == diff.after.reading == "geometric cycles"
    assert diff.ratio == 1.0


@pytest.fixture
def versions_of(block, component):
    from tracerisk.prm.review.model_parts import RiskVersion

    def make(pinned):
        parts = (component("cell", P, 2, "true"),)
        made = block("a", 1, parts, after={"a": "99/100", "done": "1/100"}, counts=True)
        made = replace(made, next=replace(made.next, pinned=pinned))
        return RiskVersion.of_blocks([made], "m")

    return make
