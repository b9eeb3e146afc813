from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.event_trees.elements import (
    Branch,
    Condition,
    End,
    EventSequence,
    Fork,
    Initiated,
    InitiatingEvent,
    InState,
    Link,
    Path,
    Resume,
    SetHouse,
    Weight,
    When,
)
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.other_models.expressions import ExpressionModel, MissionTime, Number, Product
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

OR, AND = GateKind.OR, GateKind.AND


def gate_of(name, kind, *events, houses=()):
    """A fault tree of one gate over events and house events."""
    inputs = (*events, *(house.name for house in houses))
    return FaultTree(name, (Gate(name, kind, inputs),), tuple(map(BasicEvent, events)), houses)


DETECTION = gate_of("detection", OR, "sensor", "cpu")
VALVES = gate_of("valves", AND, "a", "b")
VALUES = {"sensor": 1e-9, "cpu": 1e-12, "a": 1e-10, "b": 1e-10}
ROWS = {
    "S1": {"detected": "success", "isolated": "success"},
    "S2": {"detected": "success", "isolated": "failure"},
    "S3": {"detected": "failure"},
}
LEAK = EventTree.of(
    "leak",
    {"detected": "detection", "isolated": "valves"},
    ROWS,
    end_states={"S1": "safe", "S2": "release", "S3": "release"},
    initiating=0.25,
    per="year",
)


def test_sequences_are_products_of_branches_that_share_nothing():
    solution = LEAK.solve([DETECTION, VALVES], VALUES)
    undetected = Fraction(1e-9) + Fraction(1e-12) - Fraction(1e-9) * Fraction(1e-12)
    unisolated = Fraction(1e-10) ** 2
    quarter = Fraction(1, 4)
    assert solution["S1"] == pytest.approx(
        float(quarter * (1 - undetected) * (1 - unisolated)), rel=4e-16
    )
    assert solution["S2"] == pytest.approx(
        float(quarter * (1 - undetected) * unisolated), rel=1e-15
    )
    assert solution["S3"] == pytest.approx(float(quarter * undetected), rel=1e-15)


@st.composite
def shared_event_trees(draw):
    """Draw up to three fault trees over five events, and an event tree over their tops."""
    names = "abcde"
    trees = []
    for index in range(draw(st.integers(1, 3))):
        gates = []
        for inner in range(draw(st.integers(0, 2))):
            inputs = draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
            gates.append(
                Gate(
                    f"g{index}{inner}",
                    draw(st.sampled_from([OR, AND, GateKind.XOR][: len(inputs) + 1])),
                    tuple(inputs),
                )
                if len(inputs) > 1
                else Gate(f"g{index}{inner}", GateKind.NOT, tuple(inputs))
            )
        below = [gate.name for gate in gates]
        more = draw(st.lists(st.sampled_from(names), min_size=1, max_size=3, unique=True))
        gates.append(Gate(f"t{index}", draw(st.sampled_from([OR, AND])), (*below, *more)))
        used = dict.fromkeys(name for gate in gates for name in gate.inputs if name in names)
        trees.append(FaultTree(f"t{index}", tuple(gates), tuple(map(BasicEvent, used))))
    rows = {}

    def grow(rank, states):
        if rank == len(trees):
            rows[f"S{len(rows)}"] = states
            return
        if states and draw(st.booleans()):
            grow(rank + 1, states)
            return
        for state in ("success", "failure"):
            grow(rank + 1, {**states, f"f{rank}": state})

    grow(0, {})
    tree = EventTree.of("t", {f"f{i}": each.top for i, each in enumerate(trees)}, rows)
    return tree, trees, rows


def happens(tree, name, events):
    """Whether a gate or event happens, by the definition of each kind."""
    gates = {gate.name: gate for gate in tree.gates}
    if name not in gates:
        return name in events
    inputs = [happens(tree, each, events) for each in gates[name].inputs]
    kind = gates[name].kind
    if kind is GateKind.NOT:
        return not inputs[0]
    if kind is GateKind.XOR:
        return sum(inputs) % 2 == 1
    return any(inputs) if kind is OR else all(inputs)


@settings(max_examples=25, deadline=None)
@given(drawn=shared_event_trees(), data=st.data())
def test_sequences_over_shared_events_equal_exact_enumeration(drawn, data):
    tree, trees, rows = drawn
    names = sorted({event.name for each in trees for event in each.events})
    values = {name: data.draw(st.sampled_from([1e-18, 1e-9, 0.5, 1e-3])) for name in names}
    expected = dict.fromkeys(rows, Fraction(0))
    for outcome in product((False, True), repeat=len(names)):
        events = {name for name, happened in zip(names, outcome, strict=True) if happened}
        weight = Fraction(1)
        for name in names:
            weight *= Fraction(values[name]) if name in events else 1 - Fraction(values[name])
        states = ["failure" if happens(each, each.top, events) else "success" for each in trees]
        for sequence, row in rows.items():
            if all(states[int(function[1:])] == state for function, state in row.items()):
                expected[sequence] += weight
    solution = tree.solve(trees, values)
    for sequence, figure in expected.items():
        assert solution[sequence] == pytest.approx(float(figure), rel=1e-14, abs=0.0)
    assert solution.total == pytest.approx(1.0, rel=1e-14)


def test_a_house_event_changes_only_the_conditions_after_it():
    down = HouseEvent("down", False)
    first = FaultTree("first", (Gate("first", AND, ("p", "down")),), (BasicEvent("p"),), (down,))
    second = gate_of("second", OR, "p", "q", houses=(down,))
    start = Branch(
        End("S"),
        (Condition("second"), SetHouse("down", True), Condition("first"), Condition("second")),
    )
    # Before: p or q; after: p and true, p or q or true.
    assert event_tree(start).solve([first, second], {"p": 0.25, "q": 0.5})["S"] == 0.25


def test_outcomes_add_their_sequences_and_sum_to_the_initiating_frequency():
    solution = LEAK.solve([DETECTION, VALVES], VALUES)
    assert solution.outcomes == {"safe": solution["S1"], "release": solution["S2"] + solution["S3"]}
    assert sum(solution.outcomes.values()) == pytest.approx(0.25, rel=1e-15)
    assert solution.total == pytest.approx(1.0, rel=1e-15)
    assert solution.findings == ()
    assert solution.initiating == InitiatingEvent("leak", 0.25, "year")


def test_branches_of_given_probabilities_multiply():
    tree = EventTree.of(
        "attack",
        {"alarm": 0.8, "size": {"small": 0.7, "large": 0.3}},
        {
            "seen": {"alarm": "success"},
            "scratch": {"alarm": "failure", "size": "small"},
            "loss": {"alarm": "failure", "size": "large"},
        },
    )
    solution = tree.solve()
    assert solution["seen"] == 1.0 - 0.8
    assert solution["scratch"] == 0.8 * 0.7
    assert solution["loss"] == 0.8 * 0.3


def test_models_give_the_values_that_are_not_stated():
    pump = FaultTree("pump", (), (BasicEvent("pump", model=Halving()),))
    tree = EventTree.of(
        "start", {"pumping": "pump"}, {"ok": {"pumping": "success"}, "dry": {"pumping": "failure"}}
    )
    assert tree.solve(pump, mission_time_h=0.5)["dry"] == 0.25
    assert tree.solve(pump, {"pump": 0.125}, mission_time_h=0.5)["dry"] == 0.125


def event_tree(start, *, functions=("f", "g"), sequences=("S", "T"), branches=(), name="tree"):
    return EventTree(
        name, functions, start, tuple(map(EventSequence, sequences)), branches=branches
    )


def fork(function, **paths):
    """A fork; each path a target, or a target with its instructions."""
    return Fork(
        function,
        tuple(
            Path(state, *((path[0], path[1:]) if isinstance(path, tuple) else (path,)))
            for state, path in paths.items()
        ),
    )


def test_a_house_event_is_set_for_what_is_collected_after_it():
    maintained = HouseEvent("maintained", False)
    pump = gate_of("pump", OR, "p", houses=(maintained,))
    values = {"p": 0.25}
    before = event_tree(Branch(End("S"), (Condition("pump"), SetHouse("maintained", True))))
    after = event_tree(Branch(End("S"), (SetHouse("maintained", True), Condition("pump"))))
    same = event_tree(Branch(End("S"), (SetHouse("maintained", False), Condition("pump"))))
    assert before.solve(pump, values)["S"] == 0.25
    assert after.solve(pump, values)["S"] == 1.0
    assert same.solve(pump, values)["S"] == 0.25


def test_instructions_depend_on_the_states_taken_and_on_what_began_the_course():
    first = fork("f", yes=(Resume("rest"), Weight(0.25)), no=(Resume("rest"), Weight(0.75)))
    rest = Branch(
        End("S"),
        (
            When(InState("f", "yes"), (Weight(0.5),), (Weight(0.125),)),
            When(Initiated("tree"), (), (Weight(0.0),)),
        ),
        "rest",
    )
    solution = event_tree(Branch(first), branches=(rest,)).solve()
    assert solution["S"] == 0.25 * 0.5 + 0.75 * 0.125


def test_a_link_goes_on_in_another_event_tree():
    second = EventTree.of(
        "second", {"f": 0.5}, {"S": {"f": "success"}, "late": {"f": "failure"}}, initiating=0.1
    )
    first = event_tree(
        Branch(fork("f", yes=(Link("second"), Weight(0.25)), no=(End("S"), Weight(0.75))))
    )
    solution = first.solve(linked=[second])
    assert {(each.event_tree, each.name): each.value for each in solution.sequences} == {
        ("second", "S"): 0.125,
        ("second", "late"): 0.125,
        ("tree", "S"): 0.75,
    }
    assert solution["S"] == 0.875


def test_paths_that_may_overlap_are_not_counted_twice():
    x, y = (FaultTree(name, (), (BasicEvent(name),)) for name in "xy")
    tree = event_tree(
        Branch(fork("f", one=(End("S"), Condition("x")), two=(End("S"), Condition("y"))))
    )
    solution = tree.solve([x, y], {"x": 0.5, "y": 0.25})
    assert solution["S"] == 0.625
    assert solution.findings == (
        "the sequences of 'tree' sum to 0.625 of the initiating event, not 1: the paths of a fork "
        "overlap, or do not cover all cases",
    )


def test_paths_of_one_sequence_add_up_where_they_exclude_each_other_and_are_joined_else():
    trees = [FaultTree(name, (), (BasicEvent(name),)) for name in "xyz"]
    # x and y, or not x and z; beside it y and z, which overlaps with both.
    tree = event_tree(
        Branch(
            fork(
                "f",
                one=(End("S"), Condition("x"), Condition("y")),
                two=(End("S"), Condition("x", False), Condition("z")),
                three=(End("S"), Condition("y"), Condition("z")),
            )
        )
    )
    found = tree.solve(trees, {"x": 0.5, "y": 0.25, "z": 0.125})["S"]
    assert found == pytest.approx(0.5 * 0.25 + 0.5 * 0.125, rel=1e-15)


def test_sequences_of_thousands_of_paths_are_parted_by_what_they_choose():
    functions = [f"f{index}" for index in range(11)]
    branches = tuple(
        Branch(
            fork(
                name,
                up=(Resume(f"b{index + 1}"), Weight(0.25)),
                down=(Resume(f"b{index + 1}"), Weight(0.25, complement=True)),
            ),
            (),
            f"b{index}",
        )
        for index, name in enumerate(functions)
    )
    tree = event_tree(
        Branch(Resume("b0")),
        functions=tuple(functions),
        branches=(*branches, Branch(End("S"), (), "b11")),
    )
    assert tree.solve()["S"] == pytest.approx(1.0, rel=1e-15)


def test_a_path_that_collects_nothing_is_always_taken():
    x = FaultTree("x", (), (BasicEvent("x"),))
    tree = event_tree(Branch(fork("f", bypass=End("S"), failure=(End("S"), Condition("x")))))
    assert tree.solve(x, {"x": 0.5})["S"] == 1.0


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ({}, "event tree 't': no sequences; give one for each path"),
        ({"S": {"h": "success"}}, "sequence 'S': 'h' is not a functional event; allowed: f, g"),
        (
            {"S": {"f": "sucess"}},
            "sequence 'S': 'f' has no state 'sucess'; did you mean 'success'?",
        ),
        ({"S": {"f": "success"}}, "the path f failure is missing; give it a sequence"),
        (
            {"S": {"f": "success"}, "T": {"f": "failure"}, "U": {"f": "failure"}},
            "the sequences 'T' and 'U' have the same path, f failure;",
        ),
        (
            {"S": {"f": "success"}, "T": {"f": "success", "g": "success"}, "U": {"f": "failure"}},
            "after f success the sequence 'T' forks over 'g' and 'S' does not",
        ),
    ],
)
def test_a_table_that_makes_no_tree_is_refused(rows, message):
    with pytest.raises(ModelError, match=message.replace("?", r"\?")):
        EventTree.of("t", {"f": 0.5, "g": 0.5}, rows)


def test_states_that_do_not_sum_to_one_are_refused():
    with pytest.raises(ModelError, match=r"the states of 'f' sum to 0\.75; they must sum to 1"):
        EventTree.of("t", {"f": {"x": 0.5, "y": 0.25}}, {"S": {"f": "x"}, "T": {"f": "y"}})


def test_an_end_state_of_no_sequence_is_refused():
    with pytest.raises(
        ModelError, match="end state is given for 'S9', which is not a sequence; allowed: S1"
    ):
        EventTree.of("t", {}, {"S1": {}}, end_states={"S9": "safe"})


@pytest.mark.parametrize(
    ("made", "message"),
    [
        (
            lambda: event_tree(Branch(End("X"))),
            "a path ends in 'X', which is not a sequence; allowed: S, T",
        ),
        (
            lambda: event_tree(Branch(Resume("X"))),
            "as 'X', which is not a branch; allowed: none",
        ),
        (
            lambda: event_tree(Branch(fork("h", a=End("S")))),
            "a fork over 'h', which is not a functional",
        ),
        (lambda: event_tree(Branch(Fork("f", ()))), "fork over 'f': a path is missing"),
        (
            lambda: event_tree(Branch(Fork("f", (Path("a", End("S")), Path("a", End("T")))))),
            "fork over 'f': two paths for the state 'a';",
        ),
        (
            lambda: event_tree(Branch(fork("g", a=fork("f", a=End("S"))))),
            "a path forks over 'f' after 'g'; a path may fork over each functional event",
        ),
        (
            lambda: event_tree(Branch(End("S")), branches=(Branch(Resume("x"), (), "x"),)),
            "the branch 'x' resumes itself",
        ),
        (lambda: event_tree(Branch(End("S")), sequences=("S", "S")), "duplicate sequence 'S'"),
        (lambda: event_tree(Branch(End("S")), functions=("f", "")), "needs printable characters"),
        (
            lambda: InitiatingEvent("i", 1.5),
            "initiating event 'i': probability 1.5; allowed: 0 to 1",
        ),
        (
            lambda: InitiatingEvent("i", -1.0, "year"),
            "initiating event 'i': frequency per year -1.0; allowed: finite, 0 or more",
        ),
    ],
)
def test_a_malformed_event_tree_is_refused_with_its_element(made, message):
    with pytest.raises(ModelError, match=message):
        made()


PUMP = gate_of("pump", OR, "p")


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (
            event_tree(Branch(End("S"), (Condition("pumps"),))),
            "sequence 'S': 'pumps' is not a gate or event of the fault trees; did you mean 'pump'?",
        ),
        (
            event_tree(Branch(End("S"), (SetHouse("h", True), Condition("pump")))),
            "sequence 'S': 'h' is set, but is not a house event; allowed: none",
        ),
        (event_tree(Branch(End("S"), (Weight(1.5),))), "probability 1.5 is outside \\[0, 1\\]"),
        (
            event_tree(Branch(Link("other"))),
            "a path links to the event tree 'other', which is missing; allowed: tree",
        ),
        (event_tree(Branch(Link("tree"))), "event tree 'tree' links back to itself by tree"),
        (
            event_tree(
                Branch(
                    fork("f", a=Resume("x"), b=Resume("y")),
                ),
                branches=(
                    Branch(End("S"), (Weight(0.5),), "x"),
                    Branch(End("S"), (Weight(0.25),), "y"),
                ),
            ),
            "sequence 'S': its paths have probabilities but are not mutually exclusive; give each path",
        ),
        (
            event_tree(Branch(End("S"), (Condition("pump"),))),
            "sequence 'S': event 'p': parameter 'p' has no value; allowed: none",
        ),
    ],
)
def test_an_event_tree_without_solution_is_refused_with_its_element(tree, message):
    with pytest.raises(ModelError, match=message.replace("?", r"\?")):
        tree.solve(PUMP)


def test_an_unknown_sequence_is_refused_with_those_there_are():
    with pytest.raises(ModelError, match="'S9' is not a sequence; allowed: S1, S2, S3"):
        LEAK.solve([DETECTION, VALVES], VALUES)["S9"]


def test_an_outcome_is_a_fault_tree_with_importances():
    tree = LEAK.outcome_tree("release", [DETECTION, VALVES])
    solution = LEAK.solve([DETECTION, VALVES], VALUES)
    solved = tree.solve(VALUES)
    assert 0.25 * solved.probability == pytest.approx(solution.outcomes["release"], rel=1e-15)
    # What remains without the valves' first unit is that nothing is detected.
    undetected = 1e-9 + 1e-12
    assert solved.importance()["a"].fussell_vesely == pytest.approx(1e-20 / undetected, rel=1e-8)


@pytest.mark.parametrize(
    ("tree", "message"),
    [
        (LEAK, "event tree 'leak': no path ends in 'S'; allowed: release, safe"),
        (
            event_tree(Branch(End("S"), (Weight(0.5),))),
            "sequence 'S': a path states a probability, which is not an event;",
        ),
        (
            event_tree(Branch(End("S"))),
            "sequence 'S': a path has no condition; its outcome is certain",
        ),
    ],
)
def test_an_outcome_that_is_no_fault_tree_is_refused(tree, message):
    with pytest.raises(ModelError, match=message):
        tree.outcome_tree("S", [DETECTION, VALVES])


class Halving:
    """Fails with half the mission time."""

    def probability(self, mission_time_h):
        return Probability.of(0.5 * mission_time_h)


def test_the_probability_of_a_path_may_come_from_a_failure_model():
    tree = event_tree(
        Branch(
            fork(
                "f",
                yes=(End("S"), Weight(Halving())),
                no=(End("T"), Weight(Halving(), complement=True)),
            )
        )
    )
    solution = tree.solve(mission_time_h=0.25)
    assert (solution["S"], solution["T"]) == (0.125, 0.875)
    with pytest.raises(ModelError, match="sequence 'S': a probability depends on the mission time"):
        tree.solve()


def test_a_table_takes_failure_models_and_expressions_too():
    call = ExpressionModel(Product((Number(0.5), MissionTime())))
    tree = EventTree.of(
        "t",
        {"pump": Halving(), "call": {"early": call, "late": 0.75}},
        {
            "dry": {"pump": "failure"},
            "soon": {"pump": "success", "call": "early"},
            "then": {"pump": "success", "call": "late"},
        },
    )
    solution = tree.solve(mission_time_h=0.5)
    assert [each.value for each in solution.sequences] == [0.75 * 0.25, 0.75 * 0.75, 0.25]
    assert solution.findings == ()
    assert tree.solve(mission_time_h=1.0).findings


def test_too_many_paths_are_refused():
    functions = tuple(f"f{index}" for index in range(17))
    branches = tuple(
        Branch(fork(name, a=Resume(f"b{index + 1}"), b=Resume(f"b{index + 1}")), (), f"b{index}")
        for index, name in enumerate(functions)
    )
    tree = event_tree(
        Branch(Resume("b0")), functions=functions, branches=(*branches, Branch(End("S"), (), "b17"))
    )
    with pytest.raises(TooLargeError, match="more than 100000 paths; split it"):
        tree.solve()


@pytest.mark.parametrize(
    ("trees", "message"),
    [
        (
            (gate_of("g", OR, "a"), gate_of("g", AND, "a")),
            "gate 'g' has different definitions in two",
        ),
        (
            (gate_of("g", OR, "a"), gate_of("a", OR, "b")),
            "'a' names a gate in one fault tree and a basic event",
        ),
    ],
)
def test_fault_trees_that_mean_two_things_by_a_name_are_refused(trees, message):
    with pytest.raises(ModelError, match=message):
        LEAK.solve(trees, VALUES)


def test_a_value_of_no_parameter_is_refused():
    with pytest.raises(
        ModelError,
        match="event tree 'leak': a value is given for 'senser', which is not a parameter of the fault trees; "
        "did you mean 'sensor'",
    ):
        LEAK.solve([DETECTION, VALVES], {**VALUES, "senser": 0.5})
