import builtins
from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.bayes.network import BayesianNetwork
from tracerisk.prm.other_models.bayes.tables import Given
from tracerisk.prm.other_models.event_trees.event_tree import EventTree
from tracerisk.prm.trees.events import BasicEvent
from tracerisk.prm.trees.fault_tree import FaultTree
from tracerisk.prm.trees.gates import Gate, GateKind

PAIR = FaultTree(
    "top", (Gate("top", GateKind.AND, ("a", "b")),), (BasicEvent("a"), BasicEvent("b"))
)
ANY = FaultTree("top", (Gate("top", GateKind.OR, ("a", "b")),), (BasicEvent("a"), BasicEvent("b")))
HEAT = BayesianNetwork(
    {"heat": {"cool": 1.0 - 2.0**-10, "hot": 2.0**-10}},
    {
        "a": Given("heat", {"cool": 2.0**-20, "hot": 0.5}),
        "b": Given("heat", {"cool": 2.0**-20, "hot": 0.25}),
    },
)


def inference_of(network):
    pytest.importorskip("pyagrum", reason="pyAgrum is not installed")
    return network


def enumerated(network, tops):
    """P(state of all conditions, top) in rationals, by the chain rule."""
    found = {}
    for joint in product(*(network.states(name) for name in network.conditions)):
        states = dict(zip(network.conditions, joint, strict=True))
        weight = Fraction(1)
        for name, condition in network.conditions.items():
            row = condition
            if isinstance(condition, Given):
                row = condition.rows()[tuple(states[parent] for parent in condition.names)]
            weight *= Fraction(row[states[name]]) / sum(map(Fraction, row.values()))
        found[joint] = (weight, tops(states))
    return found


def test_events_of_a_common_condition_are_not_independent():
    solution = inference_of(HEAT).solve(PAIR)
    hot, cool = Fraction(1, 2**10), 1 - Fraction(1, 2**10)
    joint = cool * Fraction(1, 2**40) + hot * Fraction(1, 8)
    assert solution.top.p == pytest.approx(float(joint), rel=1e-15)
    assert solution.top.q == pytest.approx(float(1 - joint), rel=1e-15)
    alone = (cool * Fraction(1, 2**20) + hot / 2) * (cool * Fraction(1, 2**20) + hot / 4)
    assert solution.top.p > 900 * alone


def test_conditions_given_that_the_top_happened_follow_bayes_rule():
    solution = inference_of(HEAT).solve(PAIR)
    hot, cool = Fraction(1, 2**10) / 8, (1 - Fraction(1, 2**10)) / 2**40
    posterior = solution.posterior("heat")
    assert posterior["hot"] == pytest.approx(float(hot / (hot + cool)), rel=1e-15)
    assert posterior["cool"] == pytest.approx(float(cool / (hot + cool)), rel=1e-15)


def rows_of(draw, states):
    """Draw a distribution whose small states may be as rare as 1e-25."""
    rare = [10.0 ** -draw(st.integers(1, 25)) for _ in states[1:]]
    return dict(zip(states, [1.0 - sum(rare), *rare], strict=True))


@st.composite
def networks(draw):
    """Draw a network of up to four conditions, and two or three events over them."""
    conditions = {}
    for index in range(draw(st.integers(1, 4))):
        names = list(conditions)
        states = tuple(f"s{state}" for state in range(draw(st.integers(1, 3))))
        parents = draw(st.lists(st.sampled_from(names), max_size=2, unique=True)) if names else []
        if not parents:
            conditions[f"c{index}"] = rows_of(draw, states)
            continue
        domains = [states_of(conditions[parent]) for parent in parents]
        conditions[f"c{index}"] = Given(
            tuple(parents), {joint: rows_of(draw, states) for joint in product(*domains)}
        )
    events = {}
    for name in "abc"[: draw(st.integers(1, 3))]:
        parents = draw(
            st.lists(st.sampled_from(list(conditions)), min_size=1, max_size=2, unique=True)
        )
        domains = [states_of(conditions[parent]) for parent in parents]
        events[name] = Given(
            tuple(parents),
            {joint: draw(st.floats(1e-20, 1.0)) for joint in product(*domains)},
        )
    return BayesianNetwork(conditions, events)


def states_of(condition):
    return tuple(
        next(iter(condition.rows().values())) if isinstance(condition, Given) else condition
    )


@given(network=networks(), kind=st.sampled_from([GateKind.OR, GateKind.AND]))
def test_top_and_posteriors_equal_exact_enumeration(network, kind):
    inference_of(network)
    events = tuple(map(BasicEvent, network.events))
    tree = FaultTree("top", (Gate("top", kind, tuple(network.events)),), events)

    def top(states):
        values = [
            Fraction(event.rows()[tuple(states[parent] for parent in event.names)])
            for event in network.events.values()
        ]
        total = Fraction(1)
        for p in values:
            total *= p if kind is GateKind.AND else 1 - p
        return total if kind is GateKind.AND else 1 - total

    joint = enumerated(network, top)
    solution = network.solve(tree)
    expected = sum(weight * p for weight, p in joint.values())
    assert solution.top.p == pytest.approx(float(expected), rel=1e-14)
    assert solution.top.q == pytest.approx(float(1 - expected), rel=1e-14)
    for rank, name in enumerate(network.conditions):
        prior, posterior = network.distribution(name), solution.posterior(name)
        for state in network.states(name):
            cells = [cell for states, cell in joint.items() if states[rank] == state]
            assert prior.get(state, 0.0) == pytest.approx(
                float(sum(w for w, _ in cells)), rel=1e-14
            )
            expected_state = sum(w * p for w, p in cells) / expected
            assert posterior[state] == pytest.approx(float(expected_state), rel=1e-13)


def test_a_row_is_read_as_divided_by_its_sum():
    loose = {"x": 0.5, "y": 0.5 + 9e-10}
    network = inference_of(
        BayesianNetwork({"h": loose, "c": Given("h", {"x": {"x": 0.5, "y": 0.5}, "y": loose})})
    )
    y = Fraction(0.5 + 9e-10) / (Fraction(0.5 + 9e-10) + Fraction(0.5))
    assert network.distribution("h")["y"] == pytest.approx(float(y), rel=1e-15)
    assert network.joint(("h", "c"))["y", "y"] == pytest.approx(float(y * y), rel=1e-15)


def test_a_condition_of_one_state_is_none():
    network = inference_of(
        BayesianNetwork(
            {
                "place": {"here": 1.0},
                "day": Given("place", {"here": {"only": 1.0}}),
                "heat": Given(("day", "place"), {("only", "here"): {"cool": 0.75, "hot": 0.25}}),
            },
            {"a": Given(("place", "heat"), {("here", "cool"): 0.0, ("here", "hot"): 0.5})},
        )
    )
    solution = network.solve(FaultTree("a", (), (BasicEvent("a"),)), evidence={"place": "here"})
    assert solution.top.p == 0.125
    assert solution.posterior("heat") == {"cool": 0.0, "hot": 1.0}
    assert solution.posterior("day") == {"only": 1.0}


def test_evidence_is_respected():
    network = inference_of(
        BayesianNetwork(
            {
                "season": {"summer": 0.25, "winter": 0.75},
                "heat": Given(
                    "season",
                    {"summer": {"cool": 0.5, "hot": 0.5}, "winter": {"cool": 1.0, "hot": 0.0}},
                ),
            },
            HEAT.events,
        )
    )
    assert network.solve(PAIR, evidence={"season": "winter"}).top.p == 2.0**-40
    assert network.solve(PAIR, evidence={"heat": "hot"}).top.p == 0.125
    assert network.solve(PAIR, evidence={"heat": "hot"}).posterior("season") == {
        "summer": 1.0,
        "winter": 0.0,
    }
    assert network.distribution("season", {"heat": "cool"})["summer"] == pytest.approx(
        1 / 7, rel=1e-15
    )
    with pytest.raises(ModelError, match=r"the evidence \(season winter, heat hot\) has"):
        network.solve(PAIR, evidence={"season": "winter", "heat": "hot"})


def test_what_is_known_may_be_as_unlikely_as_can_be():
    rare = {"no": 1.0, "yes": 1e-150}
    network = inference_of(
        BayesianNetwork(
            {
                "cause": {"a": 0.75, "b": 0.25},
                "first": Given("cause", {"a": rare, "b": {"no": 1.0, "yes": 3e-150}}),
                "second": Given("cause", {"a": rare, "b": rare}),
            },
        )
    )
    found = network.distribution("cause", {"first": "yes", "second": "yes"})
    assert found == {"a": pytest.approx(0.5, rel=1e-15), "b": pytest.approx(0.5, rel=1e-15)}


def test_a_basic_event_may_be_a_condition_itself():
    network = inference_of(
        BayesianNetwork(
            {
                "first": {"works": 0.75, "failed": 0.25},
                "second": Given(
                    "first",
                    {
                        "works": {"works": 0.875, "failed": 0.125},
                        "failed": {"works": 0.5, "failed": 0.5},
                    },
                ),
            },
            {
                "a": Given("first", {"works": 0.0, "failed": 1.0}),
                "b": Given("second", {"works": 0, "failed": 1}),
            },
        )
    )
    assert network.solve(PAIR).top.p == 0.125
    assert network.solve(ANY).top.p == 0.25 + 0.75 * 0.125


def test_values_and_models_fill_what_the_network_does_not_give():
    class Halving:
        def probability(self, mission_time_h):
            return Probability.of(0.5 * mission_time_h)

    network = BayesianNetwork(
        {"heat": {"cool": 0.5, "hot": 0.5}}, {"a": Given("heat", {"cool": 0.25, "hot": Halving()})}
    )
    inference_of(network)
    assert network.solve(PAIR, {"b": 0.5}, mission_time_h=1.0).top.p == 0.5 * 0.5 * (0.25 + 0.5)
    tree = FaultTree("b", (), (BasicEvent("b", model=Halving()),))
    assert network.solve(tree, mission_time_h=1.0).top.p == 0.5
    with pytest.raises(
        ModelError, match="event 'a' depends on the mission time; give mission_time_h"
    ):
        network.solve(PAIR, {"b": 0.5})


def test_an_event_tree_is_weighed_by_the_cases_of_a_network():
    network = inference_of(HEAT)
    tree = EventTree.of(
        "t", {"first": "top"}, {"ok": {"first": "success"}, "bad": {"first": "failure"}}
    )
    bad = sum(
        case.probability * tree.solve(PAIR, case.values)["bad"]
        for case in network.cases(PAIR.parameters)
    )
    assert bad == pytest.approx(network.solve(PAIR).top.p, rel=1e-15)


def test_a_top_that_never_happens_says_nothing():
    network = inference_of(
        BayesianNetwork({"c": {"x": 0.5, "y": 0.5}}, {"a": Given("c", {"x": 0.0, "y": 0.0})})
    )
    solution = network.solve(FaultTree("a", (), (BasicEvent("a"),)))
    with pytest.raises(ModelError, match="the top event never happens"):
        solution.posterior("c")
    assert solution.posterior("c", top_happened=False) == {"x": 0.5, "y": 0.5}


def test_too_many_joint_states_are_refused():
    names = [f"c{index}" for index in range(17)]
    network = BayesianNetwork(
        {name: {"x": 0.5, "y": 0.5} for name in names},
        {name: Given(name, {"x": 0.1, "y": 0.2}) for name in names},
    )
    tree = FaultTree(
        "top", (Gate("top", GateKind.OR, tuple(names)),), tuple(map(BasicEvent, names))
    )
    with pytest.raises(
        TooLargeError, match="have 131072 joint states; at most 100000 are supported;"
    ):
        network.solve(tree)


def test_without_pyagrum_the_extra_to_install_is_named(monkeypatch):
    real = builtins.__import__

    def refusing(name, *rest):
        if name == "pyagrum":
            raise ImportError(name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", refusing)
    with pytest.raises(ModelError, match=r"install it with: pip install 'tracerisk\[bayes\]'"):
        HEAT.solve(PAIR)


@pytest.mark.parametrize(
    ("conditions", "events", "message"),
    [
        (
            {"c": {"x": 0.5, "y": 0.25}},
            {},
            r"condition 'c': its states sum to 0\.75; they must sum",
        ),
        ({"c": {"x": 1.5, "y": -0.5}}, {}, r"condition 'c': probability 1\.5 of 'x' is outside"),
        ({"c": Given("d", {"x": {"y": 1.0}})}, {}, "condition 'c': it depends on 'd', which is no"),
        (
            {"c": {"x": 1.0}, "d": Given("c", {"z": {"y": 1.0}})},
            {},
            "condition 'd': a row for z, which is not a state of c; allowed: x",
        ),
        (
            {"c": {"x": 0.5, "w": 0.5}, "d": Given("c", {"x": {"y": 1.0}})},
            {},
            "condition 'd': no row for w; give one",
        ),
        (
            {"c": {"x": 0.5, "w": 0.5}, "d": Given("c", {"x": {"y": 1.0}, "w": {"z": 1.0}})},
            {},
            "condition 'd': its rows have different states",
        ),
        (
            {"c": Given("d", {"x": {"x": 1.0}}), "d": Given("c", {"x": {"x": 1.0}})},
            {},
            "the conditions c, d depend on each other in a cycle;",
        ),
        (
            {"c": {"x": 1.0}},
            {"a": Given("c", {"x": 1.5})},
            r"event 'a' given x: probability 1\.5 is",
        ),
        (
            {"c": {"x": 1.0}},
            {"a": Given("b", {"x": 0.5})},
            "event 'a': it depends on 'b', which is",
        ),
    ],
)
def test_a_malformed_network_is_refused_with_its_element(conditions, events, message):
    with pytest.raises(ModelError, match=message):
        BayesianNetwork(conditions, events)


@pytest.mark.parametrize(
    ("evidence", "message"),
    [
        ({"cold": "hot"}, "'cold' is not a condition; allowed: heat"),
        ({"heat": "warm"}, "condition 'heat' has no state 'warm'; allowed: cool, hot"),
    ],
)
def test_evidence_of_unknown_names_is_refused(evidence, message):
    with pytest.raises(ModelError, match=message):
        HEAT.solve(PAIR, evidence=evidence)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"aa": 0.5}, "value of 'aa', which is not a parameter; did you mean 'a'"),
        ({"a": 0.5}, "a value is given for 'a', which the network defines already"),
    ],
)
def test_a_value_that_would_count_for_nothing_is_refused(values, message):
    with pytest.raises(ModelError, match=message):
        HEAT.solve(PAIR, values)


def test_evidence_too_unlikely_for_a_number_is_reported():
    network = BayesianNetwork(
        {
            "heat": {"hot": 1e-200, "cool": 1.0},
            "alarm": Given(
                "heat", {"hot": {"on": 1e-200, "off": 1.0}, "cool": {"on": 0.0, "off": 1.0}}
            ),
        }
    )
    with pytest.raises(ModelError, match="has a probability of 0 or below 1e-308; correct it"):
        inference_of(network).distribution("heat", {"alarm": "on"})
