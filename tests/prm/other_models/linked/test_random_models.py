"""Linked models drawn at random against the same models by definition."""

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from tracerisk.prm.other_models.expressions import Call, MissionTime, Number, Product, Reference
from tracerisk.prm.other_models.expressions.laws import Exponential
from tracerisk.prm.other_models.linked import (
    Absorption,
    Figure,
    LinkedChain,
    LinkedEvent,
    LinkedModel,
    LinkedTree,
    ModelParameter,
    Occupancy,
    TopEvent,
    Transition,
    complement,
)
from tracerisk.prm.trees.gates import Gate, GateKind

PARAMETERS = ("p", "q", "r")
SIZES = st.floats(-22.0, -0.5).map(lambda exponent: 10.0**exponent)


@st.composite
def probabilities(draw, links=(), monotone=False):
    """An expression whose value stays within [0, 1]; if monotone, it grows with each leaf."""
    leaf = st.one_of(
        st.sampled_from([Reference(name) for name in PARAMETERS]), *map(st.just, links)
    )

    def grown(inner):
        kinds = [
            st.tuples(inner, inner).map(Product),
            st.tuples(inner, inner).map(lambda two: Call("mean", two)),
            inner.map(lambda one: Exponential(one, MissionTime())),
            st.tuples(inner, inner).map(
                lambda two: complement(Product((complement(two[0]), complement(two[1]))))
            ),
        ]
        return st.one_of(*kinds, *([] if monotone else [inner.map(complement)]))

    return draw(st.recursive(leaf, grown, max_leaves=3))


@st.composite
def trees(draw, name, links=(), monotone=False):
    """A tree of up to five events that gates may share."""
    names = [f"e{number}" for number in range(draw(st.integers(2, 5)))]
    events = tuple(LinkedEvent(each, draw(probabilities(links, monotone))) for each in names)
    gates = []
    loose = list(names)
    while len(loose) > 1:
        kinds = [GateKind.OR, GateKind.AND, GateKind.ATLEAST]
        kind = draw(st.sampled_from(kinds if monotone else [*kinds, GateKind.XOR]))
        count = draw(st.integers(2, min(3, len(loose))))
        inputs = tuple(loose[:count])
        again = draw(st.sampled_from(names))
        if again not in inputs and draw(st.booleans()):
            inputs = (*inputs, again)
        k = draw(st.integers(1, len(inputs))) if kind is GateKind.ATLEAST else None
        gate = Gate(f"g{len(gates)}", kind, inputs, k)
        gates.append(gate)
        loose = [*loose[count:], gate.name]
    return LinkedTree(name, gates[-1].name, tuple(gates), events)


@st.composite
def models(draw, monotone):
    standby = LinkedChain(
        "standby",
        "up",
        (
            Transition("up", "down", draw(probabilities((), monotone))),
            Transition("down", "lost", draw(probabilities((), monotone))),
            Transition("down", "up", Number(draw(st.floats(0.0, 2.0)))),
        ),
        "continuous",
    )
    first = draw(trees("first", (Occupancy("standby", ("lost",)),), monotone))
    second = draw(trees("second", (TopEvent("first"),), monotone))
    failure = draw(probabilities((TopEvent("first"), TopEvent("second")), monotone))
    mission = LinkedChain(
        "mission",
        "a",
        (
            Transition("a", "failed", TopEvent("first")),
            Transition("a", "b"),
            Transition("b", "failed", TopEvent("second")),
            Transition("b", "a", Product((complement(TopEvent("second")), Number(0.75)))),
            Transition("b", "done", Product((complement(TopEvent("second")), Number(0.25)))),
        ),
    )
    return LinkedModel(
        "random",
        tuple(ModelParameter(name, Number(draw(SIZES))) for name in PARAMETERS),
        (first, second),
        (standby, mission),
        (
            Figure("failure", Absorption("mission", ("failed",))),
            Figure("soon", Occupancy("mission", ("failed",), steps=3)),
            Figure("odd", failure),
        ),
        2.0,
    )


def close(found, expected, scale=0.0):
    """Eleven digits, or as many of what is given as scale."""
    return found == pytest.approx(float(expected), rel=1e-11, abs=1e-11 * scale + 1e-45)


def check(model, oracle, scale):
    """Hold the figures, derivatives and changes of a model against its definition.

    `scale` gives what a change of a figure may be off by, times 1e-11: where what a parameter
    does has either sign, its parts cancel, and keep the digits of the figure alone.
    """
    by_hand = oracle(model)
    solution = model.solve()
    for figure in ("failure", "soon", "odd"):
        expected = by_hand.figure(figure)
        pair = solution.figure(figure)
        assert close(pair.p, expected)
        assert close(pair.q, 1 - expected)
        slopes = solution.sensitivities(figure)
        for name in PARAMETERS:
            off = scale(pair)
            slope = by_hand.slope(figure, name)
            assert close(slopes[name], slope, off / solution.parameters[name]), (
                figure,
                name,
                slopes[name],
                slope,
            )
            low = {name: 0.0}
            change = solution.change_from(model.solve(low), figure)
            fall = expected - oracle(model, low).figure(figure)
            assert close(change, fall, off), (figure, name, change, fall, pair)


def drawn(count):
    """Settings without shrinking: one model takes the oracle up to a second."""
    return settings(
        max_examples=count,
        deadline=None,
        phases=(Phase.explicit, Phase.reuse, Phase.generate),
        suppress_health_check=list(HealthCheck),
    )


@drawn(3)
@given(model=models(monotone=True))
def test_random_models_in_which_failures_only_add_keep_every_digit(oracle, model):
    check(model, oracle, lambda pair: 0.0)


@drawn(3)
@given(model=models(monotone=False))
def test_random_models_with_complements_keep_the_digits_of_their_figures(oracle, model):
    check(model, oracle, min)


@pytest.mark.slow
@drawn(100)
@given(model=models(monotone=True))
def test_many_random_models_in_which_failures_only_add_keep_every_digit(oracle, model):
    check(model, oracle, lambda pair: 0.0)


@pytest.mark.slow
@drawn(100)
@given(model=models(monotone=False))
def test_many_random_models_with_complements_keep_the_digits_of_their_figures(oracle, model):
    check(model, oracle, min)
