import itertools
import math
from dataclasses import replace
from fractions import Fraction

import pytest

from tracerisk.adder.blocks.block import Field
from tracerisk.errors import BlockError, Location, ModelError
from tracerisk.prm import GateKind, NextStep, build_model, solve
from tracerisk.prm.formats import dumps, loads
from tracerisk.prm.hybrid.from_blocks import MAX_QUANTITY
from tracerisk.prm.trees.events import Share

R = -math.log1p(-0.2)  # the rate of a unit that fails with 0.2 in a visit


def at(block, line):
    """Return the block with its place in `arm.py`, its `next` one line below."""
    placed = replace(block, location=Location("arm.py", line))
    if block.next is None:
        return placed
    return replace(placed, next=replace(block.next, location=Location("arm.py", line + 1)))


def test_a_function_is_a_top_or_over_its_components_by_redundancy(block, component):
    parts = (
        component("motor", 1e-8, 3),
        component("power", 1e-7, 2, True),
        component("gripper", 1e-9),
    )
    (state,) = build_model([block("grasp", 1, parts)], name="m").states
    gates = {gate.name: gate for gate in state.tree.gates}
    assert gates[state.tree.top].kind is GateKind.OR
    assert gates[state.tree.top].inputs == ("motor", "power", "gripper")
    assert gates["motor"].kind is GateKind.OR
    assert gates["motor"].inputs == ("motor[1]", "motor[2]", "motor[3]")
    assert gates["power"].kind is GateKind.AND
    assert set(gates) == {state.tree.top, "motor", "power"}
    assert [event.parameter for event in state.tree.events] == ["motor"] * 3 + ["power"] * 2 + [
        "gripper"
    ]


def test_top_events_equal_the_answer_on_paper(block, component):
    model = build_model(
        [
            block("move", 1, (component("motor", 0.1, 2),)),
            block("hold", 2, (component("power", 0.1, 2, True), component("brake", 0.5))),
        ],
        name="m",
    )
    tops = [state.top_event for state in solve(model).states]
    assert tops == pytest.approx([1 - 0.9**2, 1 - 0.99 * 0.5], rel=1e-15)


def test_blocks_without_next_chain_by_call_sequence_whatever_their_order(block):
    blocks = [block("third", 7), block("first", 1), block("second", 3)]
    model = build_model(blocks, name="m")
    assert model.entry == "first"
    assert [state.name for state in model.states] == ["first", "second", "third"]
    assert [state.next for state in model.states] == [
        (NextStep("second", Fraction(1)),),
        (NextStep("third", Fraction(1)),),
        (NextStep("done", Fraction(1)),),
    ]


def test_next_of_the_blocks_is_taken_as_written(block):
    blocks = [
        block("a", 1, after={"b": "9/10", "done": "1/10"}),
        block("b", 2, after={"a": 1}),
    ]
    model = build_model(blocks, name="m")
    assert model.states[0].next == (
        NextStep("b", Fraction(9, 10)),
        NextStep("done", Fraction(1, 10)),
    )
    assert model.states[1].next == (NextStep("a", Fraction(1)),)


def test_a_profile_replaces_next_and_leaves_the_blocks_alone(block):
    blocks = [block("a", 1, after={"done": 1})]
    model = build_model(
        blocks, profile={"a": {"a": Fraction(3, 4), "done": Fraction(1, 4)}}, name="m"
    )
    assert solve(model).states[0].expected_visits == pytest.approx(4, rel=1e-15)
    assert blocks[0].next.value[0].target == "done"


def test_omitted_components_are_left_out_and_added_ones_count(block, component):
    parts = (
        component("motor", 1e-8, omitted=True),
        component("cable", 1e-9, added=True),
    )
    model = build_model([block("move", 1, parts)], name="m")
    assert [parameter.name for parameter in model.parameters] == ["cable"]
    assert solve(model).mission.failure_probability == pytest.approx(1e-9, rel=1e-15)


def test_values_left_out_of_an_omitted_component_are_never_read(block, component):
    empty = Field(float("nan"), "")
    entry = replace(component("motor", 0.5, omitted=True), probability=empty)
    model = build_model([block("move", 1, (entry,))], name="m")
    assert solve(model).mission.failure_probability == 0.0


def test_a_function_on_no_hardware_never_fails(block):
    assessment = solve(build_model([block("think", 1)], name="m"))
    assert assessment.mission.failure_probability == 0.0
    assert assessment.mission.done_probability == 1.0
    assert assessment.components == ()


def test_a_component_of_several_functions_is_one_parameter(case_study):
    model = build_model(case_study, name="case")
    assert {parameter.name: parameter.theta for parameter in model.parameters} == {
        "control_system": 2.167e-10,
        "electric_motor": 1.30644e-07,
        "gripper": 7.344e-08,
        "power_system": 6.674e-08,
    }


def test_a_function_that_bears_the_name_of_a_failure_state_keeps_it(block, component):
    motor = component("motor", 0.5)
    model = build_model([block("pick", 1, (motor,)), block("pick_failure", 2)], name="m")
    assert model.failure_states == {
        "pick": "pick__failure",
        "pick_failure": "pick_failure_failure",
    }
    assert solve(model).states[0].absorption_probability == 0.5


def test_a_block_that_nothing_leads_to_adds_nothing_and_is_reported(block, component):
    motor = component("motor", 0.5)
    blocks = [
        block("move", 1, (component("cable", 0.25),), after={"done": 1}),
        block("recover", 2, (motor,), after={"recover": 1}, added=True),
    ]
    assessment = solve(build_model(blocks, name="m"))
    assert assessment.mission.failure_probability == 0.25
    recover = assessment.states[1]
    assert (recover.top_event, recover.expected_visits) == (0.5, 0.0)
    assert assessment.findings == (
        "recover is never reached from move and does not contribute to the mission",
    )


def test_a_next_of_weight_zero_leads_nowhere(block):
    blocks = [
        block("move", 1, after={"recover": 0, "done": 1}),
        block("recover", 2, after={"recover": 1}),
    ]
    model = build_model(blocks, name="m")
    assert model.reachable == ("move",)
    assert not model.has_cycle
    assert solve(model).mission.done_probability == 1.0


def test_no_blocks_at_all_is_an_error_that_says_what_writes_them():
    with pytest.raises(BlockError, match="no risk blocks; `tracerisk run FILE`"):
        build_model([], name="m")


def test_a_name_used_twice_is_refused_with_both_places(block):
    blocks = [at(block("pick", 1), 10), at(block("pick", 2), 20)]
    with pytest.raises(BlockError) as caught:
        build_model(blocks, name="m")
    assert str(caught.value).startswith("arm.py:20: function 'pick': duplicate block name")
    assert "arm.py:10" in str(caught.value)


def test_a_call_sequence_used_twice_is_refused_with_both_names(block):
    blocks = [at(block("pick", 1), 10), at(block("place", 1), 20)]
    message = r"arm.py:20: function 'place': callSequence 1 is already used by 'pick' .*arm.py:10"
    with pytest.raises(BlockError, match=message):
        build_model(blocks, name="m")


def test_a_function_named_done_is_refused(block):
    with pytest.raises(BlockError, match="would be taken for the end"):
        build_model([block("done", 1)], name="m")


@pytest.mark.parametrize(
    ("after", "message"),
    [
        ({"plase": 1}, "next leads to 'plase', which has no block; did you mean 'place'"),
        ({"place": "1/2", "done": "1/3"}, "next sums to 5/6; the lines of one function must sum"),
        ({"place": "3/2", "done": "-1/2"}, "next done -1/2 is below zero"),
        ({}, "next sums to 0; "),
    ],
)
def test_a_bad_next_is_refused_at_its_line(block, after, message):
    blocks = [at(block("pick", 1, after=after), 10), block("place", 2)]
    with pytest.raises(BlockError, match=f"arm.py:11: function 'pick': {message}"):
        build_model(blocks, name="m")


def test_functions_that_never_lead_to_done_are_named(block):
    blocks = [
        block("start", 1, after={"a": "1/2", "done": "1/2"}),
        at(block("a", 2, after={"b": 1}), 30),
        block("b", 3, after={"a": 1, "done": 0}),
    ]
    message = "arm.py:31: function 'a': 'done' cannot be reached from a, b; add 'done'"
    with pytest.raises(BlockError, match=message):
        build_model(blocks, name="m")


@pytest.mark.parametrize(
    ("profile", "message"),
    [
        ({"plase": {"done": 1}}, "profile: 'plase' has no risk block; did you mean 'place'"),
        (
            {"place": {"dome": 1}},
            "profile of 'place': 'dome' has no risk block; did you mean 'done'",
        ),
        (
            {"place": {"pick": "9/10", "done": "1/20"}},
            "profile of 'place': the probabilities sum to 19/20; they must sum to 1",
        ),
        ({"place": {"pick": 2, "done": -1}}, "profile of 'place': done=-1 is below zero"),
    ],
)
def test_a_bad_profile_is_refused(block, profile, message):
    rows = {f: {t: Fraction(w) for t, w in row.items()} for f, row in profile.items()}
    with pytest.raises(ModelError, match=message):
        build_model([block("pick", 1), block("place", 2)], profile=rows, name="m")


def test_bad_components_are_refused_at_their_place(block, component):
    place = Location("arm.py", 12)
    cases = {
        r"component 'motor': probability 1.5 is outside \[0, 1\]": component("motor", 1.5),
        r"component 'motor': probability nan is outside": component("motor", float("nan")),
        f"component 'motor': quantity is 0; allowed: 1 to {MAX_QUANTITY}": component(
            "motor", 0.5, 0
        ),
        f"component 'motor': quantity is {MAX_QUANTITY + 1}; allowed": component(
            "motor", 0.5, MAX_QUANTITY + 1
        ),
    }
    for message, entry in cases.items():
        bad = replace(entry, location=place)
        with pytest.raises(BlockError, match=f"arm.py:12: function 'move': {message}"):
            build_model([block("move", 1, (bad,))], name="m")
    twice = (component("motor", 0.5), replace(component("motor", 0.1), location=place))
    with pytest.raises(BlockError, match=r"arm.py:12: .* duplicate component 'motor'"):
        build_model([block("move", 1, twice)], name="m")


def test_the_greatest_quantity_is_solved(block, component):
    model = build_model([block("move", 1, (component("cell", 1e-12, MAX_QUANTITY),))], name="m")
    assert solve(model).mission.failure_probability == pytest.approx(MAX_QUANTITY * 1e-12, rel=1e-7)


def by_enumeration(p: float, n: int, required: int, beta: float) -> float:
    """The probability that fewer than `required` of n work, each state of the units at a time."""
    own, total = (1 - beta) * p, 0.0
    for state in itertools.product((False, True), repeat=n):
        chance = math.prod(own if failed else 1 - own for failed in state)
        total += chance * (n - sum(state) < required)
    return beta * p + (1 - beta * p) * total


@pytest.mark.parametrize(
    ("quantity", "redundancy", "required", "beta"),
    [
        (3, "required 2", 2, 0.0),
        (4, "required 3", 3, 0.0),
        (3, "required 1", 1, 0.0),
        (3, "required 3", 3, 0.0),
        (2, "true, common_cause 0.1", 1, 0.1),
        (4, "required 2, common_cause 0.05", 2, 0.05),
        (3, "true, common_cause 1", 1, 1.0),
    ],
)
def test_units_that_must_work_and_common_causes(
    block, component, quantity, redundancy, required, beta
):
    model = build_model([block("a", 1, (component("unit", 0.2, quantity, redundancy),))], name="m")
    (state,) = solve(model).states
    expected = by_enumeration(0.2, quantity, required, beta)
    assert state.top_event == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("quantity", "required"),
    [(quantity, required) for quantity in range(2, 7) for required in range(1, quantity + 1)],
)
def test_units_that_must_work_keep_their_digits_when_rare(block, component, quantity, required):
    """Against every state of the units, in exact rationals: 3 of 4 and 1 of n among them."""
    p, expected = Fraction(6.674e-08), Fraction(0)
    for state in itertools.product((False, True), repeat=quantity):
        if quantity - sum(state) < required:
            expected += math.prod((p if failed else 1 - p for failed in state), start=Fraction(1))
    unit = component("unit", 6.674e-08, quantity, f"required {required}")
    (found,) = solve(build_model([block("a", 1, (unit,))], name="m")).states
    assert found.top_event == pytest.approx(float(expected), rel=1e-14, abs=0)


def test_a_common_cause_of_a_rare_failure_keeps_its_digits(block, component):
    pair = component("power", 6.674e-08, 2, "true, common_cause 0.1")
    (state,) = solve(build_model([block("a", 1, (pair,))], name="m")).states
    assert state.top_event == pytest.approx(6.674e-09 + (0.9 * 6.674e-08) ** 2, rel=1e-12)


def test_more_units_than_there_are_cannot_be_required(block, component):
    with pytest.raises(BlockError, match="component 'unit': required 4 of 3; allowed: 1 to 3"):
        build_model([block("a", 1, (component("unit", 0.2, 3, "required 4"),))], name="m")


@pytest.mark.parametrize(
    ("redundancy", "expected"),
    [
        ("true, spare cold", 1 - math.exp(-R) * (1 + R)),
        ("true, spare hot", 0.04),
        ("true, spare cold, switch 1", 0.2),
        ("required 2, spare cold", 0.36),
    ],
)
def test_spares_are_one_event_of_their_group(block, component, redundancy, expected):
    model = build_model([block("a", 1, (component("unit", 0.2, 2, redundancy),))], name="m")
    assert solve(model).states[0].top_event == pytest.approx(expected, rel=1e-12)


def test_spares_and_common_causes_stand_side_by_side(block, component):
    entry = component("unit", 0.2, 2, "true, spare cold, common_cause 0.5")
    model = build_model([block("a", 1, (entry,))], name="m")
    own = -math.log1p(-0.1)
    apart = 1 - math.exp(-own) * (1 + own)
    assert solve(model).states[0].top_event == pytest.approx(1 - 0.9 * (1 - apart), rel=1e-12)
    names = [parameter.name for parameter in model.parameters]
    assert names == ["unit {common cause}", "unit {own}"]
    parts = [(each.component, each.share) for each in model.parameters]
    assert parts == [("unit", Share.COMMON_CAUSE), ("unit", Share.OWN)]
    assert loads(dumps(model), "model.json") == model, "the names in the file say the same"
