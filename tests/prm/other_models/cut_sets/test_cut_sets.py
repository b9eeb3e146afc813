import random
from itertools import islice, pairwise, product
from math import comb
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.cut_sets import CutSet, minimal_cut_sets, prime_implicants
from tracerisk.prm.trees.events import BasicEvent, HouseEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

OR, AND, ATLEAST, NOT, XOR = (
    GateKind.OR,
    GateKind.AND,
    GateKind.ATLEAST,
    GateKind.NOT,
    GateKind.XOR,
)
ARALIA = Path(__file__).parents[5] / "shared" / "data" / "aralia"


@st.composite
def trees(draw, kinds):
    """Draw a tree over up to six events, each gate over any of what stands before it."""
    rng = random.Random(draw(st.integers(0, 2**32)))
    names = [f"e{i}" for i in range(rng.randint(2, 6))]
    gates = []
    for number in range(rng.randint(1, 8)):
        kind = rng.choice(kinds)
        inputs = tuple(rng.sample(names, 1 if kind is NOT else rng.randint(2, min(4, len(names)))))
        k = rng.randint(1, len(inputs)) if kind is ATLEAST else None
        gates.append(Gate(f"g{number}", kind, inputs, k))
        names.append(f"g{number}")
    by_name = {gate.name: gate for gate in gates}
    below, waiting = set(), [gates[-1].name]
    while waiting:
        name = waiting.pop()
        if name not in below:
            below.add(name)
            waiting += by_name[name].inputs if name in by_name else ()
    return FaultTree(
        gates[-1].name,
        tuple(gate for gate in gates if gate.name in below),
        tuple(BasicEvent(name) for name in names if name in below and name not in by_name),
    )


def truth(tree):
    """Return for each set of events whether the top happens when just these have: brute force."""
    found = {}
    names = [event.name for event in tree.events]
    for states in product((0, 1), repeat=len(names)):
        value = dict(zip(names, states, strict=True))
        for gate in tree.upwards:
            count, most = sum(value[name] for name in gate.inputs), len(gate.inputs)
            value[gate.name] = {
                OR: count >= 1,
                AND: count == most,
                ATLEAST: count >= (gate.k or 0),
                NOT: count == 0,
                XOR: count % 2 == 1,
            }[gate.kind]
        found[states] = bool(value[tree.top])
    return names, found


def listed(sets):
    return [(frozenset(each.events), frozenset(each.absent)) for each in sets]


@given(tree=trees([OR, AND, ATLEAST, NOT, XOR]), most=st.sampled_from([None, 1, 2, 3]))
def test_cut_sets_are_the_smallest_sets_that_bring_the_top_about(tree, most):
    names, found = truth(tree)
    points = [
        frozenset(name for name, state in zip(names, states, strict=True) if state)
        for states, happens in found.items()
        if happens
    ]
    expected = {
        (point, frozenset())
        for point in points
        if not any(other < point for other in points) and (most is None or len(point) <= most)
    }
    sets = minimal_cut_sets(tree, max_order=most)
    values = dict.fromkeys(names, 0.5)
    for ways in (sets.most_probable(), sets.most_probable(values)):
        ways = listed(ways)
        assert len(ways) == len(expected)
        assert set(ways) == expected
    assert sets.count() == len(expected)


def test_a_part_that_always_happens_is_in_no_prime_implicant():
    # `always` is a tautology of inputs of its own, which no rule of simplification sees.
    tree = FaultTree(
        "top",
        (
            Gate("either", GateKind.OR, ("c", "d")),
            Gate("odd", GateKind.XOR, ("d", "either")),
            Gate("even", GateKind.NOT, ("odd",)),
            Gate("both", GateKind.XOR, ("c", "d", "a", "even")),
            Gate("always", GateKind.ATLEAST, ("even", "either", "b", "both"), k=2),
            Gate("top", GateKind.OR, ("a", "always")),
        ),
        tuple(BasicEvent(name, name) for name in "abcd"),
    )
    assert all(truth(tree)[1].values())
    sets = prime_implicants(tree)
    assert listed(sets.most_probable()) == [(frozenset(), frozenset())]
    assert sets.count() == 1
    assert tree.probability(dict.fromkeys("abcd", 0.3)).p == 1.0


@given(tree=trees([OR, AND, ATLEAST, NOT, XOR]))
def test_prime_implicants_are_the_largest_cubes_within_the_truth_table(tree):
    names, found = truth(tree)
    cubes = {
        cube
        for cube in product((0, 1, None), repeat=len(names))
        if all(found[p] for p in product(*[(0, 1) if c is None else (c,) for c in cube]))
    }
    primes = {
        cube
        for cube in cubes
        if not any(
            state is not None and (*cube[:i], None, *cube[i + 1 :]) in cubes
            for i, state in enumerate(cube)
        )
    }
    expected = {
        tuple(
            frozenset(name for name, s in zip(names, cube, strict=True) if s == state)
            for state in (1, 0)
        )
        for cube in primes
    }
    sets = prime_implicants(tree)
    ways = listed(sets.most_probable())
    assert len(ways) == len(expected)
    assert set(ways) == expected
    assert sets.count() == len(expected)


@given(tree=trees([OR, AND, ATLEAST]), seed=st.integers(0, 1000))
def test_cut_sets_come_by_falling_probability_and_sum_up(tree, seed):
    rng = random.Random(seed)
    values = {event.name: 10 ** rng.uniform(-6, 0) for event in tree.events}
    sets = minimal_cut_sets(tree)
    ways = list(sets.most_probable(values))
    chances = [way.probability for way in ways]
    for way in ways:
        expected = 1.0
        for event in way.events:
            expected *= values[event]
        assert way.probability == pytest.approx(expected, rel=1e-12)
    assert all(a >= b * (1 - 1e-12) for a, b in pairwise(chances))
    assert sets.rare_event_sum(values) == pytest.approx(sum(chances), rel=1e-12)
    assert sets.rare_event_sum(values) >= tree.probability(values).p * (1 - 1e-12)
    middle = chances[len(chances) // 2]
    kept = list(sets.most_probable(values, cut_off=middle * (1 - 1e-9)))
    assert len(kept) == sum(chance >= middle * (1 - 1e-9) for chance in chances)


def test_a_bridge_has_four_ways_to_fail():
    ways = [("a", "b"), ("c", "d"), ("a", "e", "d"), ("b", "e", "c")]
    gates = [Gate(f"way{i}", AND, way) for i, way in enumerate(ways)]
    top = Gate("top", OR, tuple(gate.name for gate in gates))
    tree = FaultTree("top", (top, *gates), tuple(BasicEvent(name) for name in "abcde"))
    values = {"a": 0.1, "b": 0.2, "c": 0.3, "d": 0.4, "e": 0.5}
    found = list(minimal_cut_sets(tree).most_probable(values))
    assert [set(way.events) for way in found] == [
        {"c", "d"},
        {"b", "c", "e"},
        {"a", "b"},
        {"a", "d", "e"},
    ]
    assert [way.probability for way in found] == pytest.approx([0.12, 0.03, 0.02, 0.02])
    assert minimal_cut_sets(tree).count_by_order() == {2: 2, 3: 2}


def test_a_hundred_million_sets_are_counted_and_the_first_of_them_listed():
    stages = [Gate(f"g{i}", OR, tuple(f"e{i}.{j}" for j in range(10))) for i in range(8)]
    top = Gate("top", AND, tuple(gate.name for gate in stages))
    events = tuple(BasicEvent(name) for gate in stages for name in gate.inputs)
    tree = FaultTree("top", (top, *stages), events)
    sets = minimal_cut_sets(tree)
    values = {event.name: 0.5 if event.name.endswith(".3") else 0.25 for event in events}
    assert sets.count() == 10**8
    assert sets.rare_event_sum(values) == pytest.approx((0.5 + 9 * 0.25) ** 8)
    first = next(sets.most_probable(values))
    assert first.events == tuple(f"e{i}.3" for i in range(8))
    assert first.probability == 0.5**8


def test_what_always_happens_has_the_empty_set_and_what_never_does_has_none():
    gates = (Gate("top", OR, ("a", "house")),)
    on = FaultTree("top", gates, (BasicEvent("a"),), (HouseEvent("house", True),))
    assert list(minimal_cut_sets(on).most_probable({"a": 0.5})) == [CutSet((), (), 1.0)]
    assert minimal_cut_sets(on).count() == 1
    gates = (Gate("top", AND, ("a", "house")),)
    off = FaultTree("top", gates, (BasicEvent("a"),), (HouseEvent("house", False),))
    assert list(minimal_cut_sets(off).most_probable()) == []
    assert minimal_cut_sets(off).rare_event_sum({"a": 0.5}) == 0.0


def test_an_event_may_be_the_top_itself():
    tree = FaultTree("motor", (), (BasicEvent("motor"),))
    assert list(minimal_cut_sets(tree).most_probable({"motor": 0.25})) == [
        CutSet(("motor",), (), 0.25)
    ]


def test_a_tree_that_is_not_coherent_says_what_must_not_happen():
    gates = (Gate("top", AND, ("a", "not b")), Gate("not b", NOT, ("b",)))
    tree = FaultTree("top", gates, (BasicEvent("a"), BasicEvent("b")))
    assert list(minimal_cut_sets(tree).most_probable()) == [CutSet(("a",))]
    found = list(prime_implicants(tree).most_probable({"a": 0.25, "b": 0.25}))
    assert found == [CutSet(("a",), ("b",), 0.1875)]
    assert found[0].order == 2


def two_of(count):
    names = tuple(f"e{i}" for i in range(count))
    pairs = [Gate(f"{a}&{b}", AND, (a, b)) for i, a in enumerate(names) for b in names[i + 1 :]]
    top = Gate("top", OR, tuple(gate.name for gate in pairs))
    return FaultTree("top", (top, *pairs), tuple(map(BasicEvent, names)))


def test_too_small_a_budget_is_reported_with_what_to_do():
    with pytest.raises(TooLargeError, match=r"need more than 10 nodes; limit their order"):
        minimal_cut_sets(two_of(12), budget=10)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"e0": 0.5}, "event 'e1': parameter 'e1' has no value; allowed: e0"),
        ({"e0": 0.5, "e1": 1.5, "e2": 0.1}, r"event 'e1': probability 1.5 is outside \[0, 1\]"),
    ],
)
def test_bad_values_are_refused(values, message):
    sets = minimal_cut_sets(two_of(3))
    with pytest.raises(ModelError, match=message):
        sets.rare_event_sum(values)
    with pytest.raises(ModelError, match=message):
        sets.most_probable(values)


@pytest.mark.parametrize("most", [0, -1, 1.5])
def test_an_order_that_is_no_count_is_refused(most):
    with pytest.raises(ModelError, match=f"max_order is {most}; give a whole number, at least 1"):
        minimal_cut_sets(two_of(3), max_order=most)


def test_a_budget_without_room_is_refused():
    with pytest.raises(ModelError, match="budget is 1 nodes; give at least 2"):
        minimal_cut_sets(two_of(3), budget=1)


@pytest.mark.parametrize("cut_off", [-0.1, 1.5, float("nan"), float("inf")])
def test_a_cut_off_that_is_no_probability_is_refused(cut_off):
    values = dict.fromkeys(("e0", "e1", "e2"), 0.5)
    with pytest.raises(ModelError, match=f"cut_off is {cut_off}; give a probability, 0 to 1"):
        minimal_cut_sets(two_of(3)).most_probable(values, cut_off=cut_off)


@given(tree=trees([OR, AND, ATLEAST]), seed=st.integers(0, 1000), most=st.integers(1, 4))
def test_what_is_left_out_is_left_out_of_the_sum_the_counts_and_the_list(tree, seed, most):
    rng = random.Random(seed)
    values = {event.name: 10 ** rng.uniform(-3, 0) for event in tree.events}
    everything = list(minimal_cut_sets(tree).most_probable(values))
    kept = [way.probability for way in everything if way.order <= most]
    sets = minimal_cut_sets(tree, max_order=most)
    assert sets.rare_event_sum(values) == pytest.approx(sum(kept), rel=1e-12)
    assert sets.count() == len(kept)
    assert len(list(sets.most_probable(values))) == len(kept)


@given(tree=trees([OR, AND, ATLEAST]), seed=st.integers(0, 1000))
def test_a_cut_off_at_the_probability_of_a_set_keeps_the_set(tree, seed):
    rng = random.Random(seed)
    values = {event.name: rng.choice((0.1, 0.3, 0.7, 1e-3)) for event in tree.events}
    sets = minimal_cut_sets(tree)
    ways = list(sets.most_probable(values))
    for way in ways:
        kept = list(sets.most_probable(values, cut_off=way.probability))
        assert set(kept) == {each for each in ways if each.probability >= way.probability}


def test_sets_of_one_probability_come_with_the_smallest_first():
    gates = {"top": ("or", ("and", *"abc"), ("and", *"de"), ("and", *"fghi"))}
    tree = FaultTree.of("top", gates)
    for values in (None, dict.fromkeys("abcdefghi", 0.0), dict.fromkeys("abcdefghi", 1.0)):
        found = minimal_cut_sets(tree).most_probable(values)
        assert [way.order for way in found] == [2, 3, 4]


def test_an_order_limit_ends_the_search_where_modules_leave_no_set():
    stages = [("or", *(f"e{i}.{j}" for j in range(10))) for i in range(8)]
    sets = minimal_cut_sets(FaultTree.of("top", {"top": ("and", *stages)}), max_order=7)
    assert list(sets.most_probable()) == []
    assert sets.count() == 0
    assert sets.rare_event_sum({f"e{i}.{j}": 0.5 for i in range(8) for j in range(10)}) == 0.0


def test_events_that_share_a_parameter_take_their_value_from_it():
    motors = (BasicEvent("m1", "motor"), BasicEvent("m2", "motor"))
    tree = FaultTree("top", (Gate("top", AND, ("m1", "m2")),), motors)
    sets = minimal_cut_sets(tree)
    assert list(sets.most_probable({"motor": 0.25})) == [CutSet(("m1", "m2"), (), 0.0625)]
    assert sets.rare_event_sum({"motor": 0.25}) == 0.0625
    with pytest.raises(ModelError, match="event 'm1': parameter 'motor' has no value; allowed: m1"):
        sets.rare_event_sum({"m1": 0.25})


@pytest.mark.skipif(not ARALIA.exists(), reason="the Aralia trees are not beside the project")
@pytest.mark.parametrize(
    ("name", "count"),
    [("chinese", 392), ("das9201", 14217), ("isp9602", 5197647), ("edf9202", 130112)],
)
def test_real_trees_have_as_many_cut_sets_as_is_known(name, count):
    from tracerisk.prm.other_models.formats.open_psa import read_open_psa

    model = read_open_psa(ARALIA / f"{name}.xml")
    assert minimal_cut_sets(model.fault_tree(model.tops[0])).count() == count


def counting_tree(k, n):
    names = [f"e{i}" for i in range(n)]
    gates = (Gate("most", ATLEAST, tuple(names), k),)
    return FaultTree("most", gates, tuple(BasicEvent(name, "p") for name in names))


def test_sets_of_one_probability_are_listed_without_going_through_all_of_them():
    found = minimal_cut_sets(counting_tree(25, 50))
    assert found.count() == comb(50, 25)
    listed = list(islice(found.most_probable({"p": 0.01}), 3))
    assert [each.order for each in listed] == [25, 25, 25]
    assert len(set(listed)) == 3


def test_a_gate_with_too_many_sets_is_refused_at_once_by_its_name():
    with pytest.raises(
        TooLargeError, match="gate 'most' has one set for each choice of 500 of its"
    ):
        minimal_cut_sets(counting_tree(500, 1000))
    assert minimal_cut_sets(counting_tree(998, 1000)).count() == comb(1000, 2)
