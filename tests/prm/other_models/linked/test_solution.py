from fractions import Fraction
from functools import cache

import pytest

from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm import build_model, solve
from tracerisk.prm.other_models.expressions import (
    Call,
    Difference,
    MissionTime,
    Negation,
    Number,
    Product,
    Quotient,
    Reference,
    Sum,
)
from tracerisk.prm.other_models.expressions.deviates import LognormalDeviate, UniformDeviate
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, Weibull
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
    linked,
)
from tracerisk.prm.other_models.markov import ContinuousChain
from tracerisk.prm.trees.gates import Gate, GateKind

FIGURES = ("failure", "lost", "done", "after ten", "unavailable", "odd", "cost")
PARAMETERS = ("power", "motor", "jam", "sensor", "wear rate", "repair rate")


def close(expected, rel=1e-12):
    return pytest.approx(float(expected), rel=rel, abs=0.0)


def one_state(failure, *parameters, time_h=None):
    """A mission of one visit that fails with an expression."""
    chain = LinkedChain(
        "mission",
        "work",
        (Transition("work", "failed", failure), Transition("work", "done")),
    )
    return LinkedModel(
        "m",
        tuple(ModelParameter(name, Number(value)) for name, value in parameters),
        (),
        (chain,),
        (
            Figure("failure", Absorption("mission", ("failed",))),
            Figure("success", Absorption("mission", ("done",))),
        ),
        time_h,
    )


# figures


@pytest.mark.parametrize("figure", FIGURES)
def test_every_figure_equals_the_model_by_definition(plant, oracle, figure):
    found = plant.solve().figure(figure)
    expected = oracle(plant).figure(figure)
    assert found.p == close(expected)
    if figure != "cost":
        assert found.q == close(1 - expected)


def test_what_is_set_stands_in_for_a_parameter_and_what_is_computed_from_it(plant, oracle):
    values = {"motor": 1e-3, "repair rate": 2.0}
    expected = oracle(plant, values)
    solution = plant.solve(values)
    assert solution.parameters["sensor"] == 5e-4
    for figure in FIGURES:
        assert solution.figure(figure).p == close(expected.figure(figure))


def test_each_half_of_a_link_keeps_its_digits_at_1e_20():
    # Survival of 1e-20: 1 - p of the computed p would be zero.
    tree = LinkedTree(
        "t",
        "top",
        (Gate("top", GateKind.OR, ("a", "b")),),
        (LinkedEvent("a", complement(Reference("x"))), LinkedEvent("b", Reference("y"))),
    )
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(1e-20)), ModelParameter("y", Number(0.5))),
        (tree,),
        (),
        (Figure("works", complement(TopEvent("t"))),),
    )
    assert model.solve().figures["works"] == close(5e-21)
    assert model.solve().sensitivities("works") == {"x": close(0.5), "y": close(-1e-20)}


def test_the_remainder_beside_a_transition_near_one_keeps_its_digits():
    model = one_state(complement(Reference("x")), ("x", 1e-20))
    assert model.solve().figures["success"] == close(1e-20)


def test_xor_of_two_events_of_1e_18_is_2e_18(plant):
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(1e-18)),),
        (
            LinkedTree(
                "t",
                "top",
                (Gate("top", GateKind.XOR, ("a", "b")),),
                (LinkedEvent("a", Reference("x")), LinkedEvent("b", Reference("x"))),
            ),
        ),
        (),
        (Figure("odd", TopEvent("t")),),
    )
    assert model.solve().figures["odd"] == close(2e-18)


def test_a_repairable_part_has_the_unavailability_of_the_textbook():
    # Rausand and Hoyland (2004), 9.2: lambda / (lambda + mu) (1 - exp(-(lambda + mu) t)).
    rate, repair, time = 1e-4, 0.1, 100.0
    chain = LinkedChain(
        "part",
        "up",
        (
            Transition("up", "down", Reference("rate")),
            Transition("down", "up", Reference("repair")),
        ),
        "continuous",
    )
    model = LinkedModel(
        "m",
        (ModelParameter("rate", Number(rate)), ModelParameter("repair", Number(repair))),
        (),
        (chain,),
        (
            Figure("down", Occupancy("part", ("down",))),
            Figure("by then", Occupancy("part", ("down",), 5.0)),
        ),
        time,
    )
    solution = model.solve()
    glm = Glm(Number(0.0), Reference("rate"), Reference("repair"), MissionTime())
    assert solution.figures["down"] == close(solution.figure(glm).p)
    assert solution.sensitivities("down")["rate"] == close(
        solution.sensitivities(glm)["rate"], rel=1e-9
    )
    assert solution.figures["by then"] < solution.figures["down"]


def test_a_cold_spare_of_rare_failures_keeps_its_digits():
    # Two failures of a Poisson process: 1 - exp(-x) (1 + x).
    chain = LinkedChain(
        "spare",
        "first",
        (
            Transition("first", "second", Reference("rate")),
            Transition("second", "none", Reference("rate")),
        ),
        "continuous",
    )
    model = LinkedModel(
        "m",
        (ModelParameter("rate", Number(1e-12)),),
        (),
        (chain,),
        (Figure("lost", Occupancy("spare", ("none",))),),
        1.0,
    )
    solution = model.solve()
    assert solution.figures["lost"] == close(5e-25)
    assert solution.sensitivities("lost")["rate"] == close(1e-12)
    assert solution.change_from(model.solve({"rate": 0.0}), "lost") == close(5e-25)


# derivatives and changes


@pytest.mark.slow(but=3)
@pytest.mark.parametrize("figure", FIGURES)
def test_the_derivatives_of_one_pass_equal_finite_differences(plant, oracle, figure):
    found = plant.solve().sensitivities(figure)
    assert list(found) == list(PARAMETERS)
    by_hand = oracle(plant)
    for name in PARAMETERS:
        assert found[name] == close(by_hand.slope(figure, name), rel=1e-11), name


@pytest.fixture(scope="module")
def plant_without(plant, oracle):
    """The plant, solved and by definition, with all parameters or without one."""

    @cache
    def solved(name=None):
        values = {} if name is None else {name: 0.0}
        by_definition = oracle(plant, values)
        return plant.solve(values), {figure: by_definition.figure(figure) for figure in FIGURES}

    return solved


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("name", PARAMETERS)
def test_what_a_parameter_adds_keeps_its_digits(plant_without, figure, name):
    (whole, figures), (less, lower) = plant_without(), plant_without(name)
    found = whole.change_from(less, figure)
    assert found == close(figures[figure] - lower[figure], rel=1e-11)


def test_a_small_change_of_a_sum_keeps_its_digits(plant, oracle):
    """1e-20 beside 2e-6: the events' own probabilities are equal in double precision."""
    high, low = {"jam": 1e-20}, {"jam": 0.0}
    found = plant.solve(high).change_from(plant.solve(low), "failure")
    expected = oracle(plant, high).figure("failure") - oracle(plant, low).figure("failure")
    assert found == close(expected, rel=1e-10)


EXPRESSIONS = {
    "sum": Sum((Reference("x"), Reference("y"))),
    "difference": Difference((Reference("y"), Reference("x"))),
    "product": Product((Reference("x"), Reference("x"), Reference("y"))),
    "quotient": Quotient((Reference("x"), Reference("y"), Number(2.0))),
    "negation": Sum((Number(0.5), Negation(Reference("x")), Reference("y"))),
    "exponential": Exponential(Reference("x"), Quotient((Reference("y"), Number(0.5)))),
    "exp": Call("exp", (Negation(Quotient((Number(1.0), Reference("y")))),)),
    "log": Negation(Call("log", (Difference((Number(1.0), Reference("x"))),))),
    "sqrt": Call("sqrt", (Product((Reference("x"), Reference("y"))),)),
    "pow": Call("pow", (Reference("y"), Sum((Number(2.0), Reference("x"))))),
    "max": Call("max", (Reference("x"), Reference("y"))),
    "min": Call("min", (Reference("x"), Reference("y"))),
    "mean": Call("mean", (Reference("x"), Reference("y"), Number(0.25))),
}


@pytest.mark.parametrize("kind", EXPRESSIONS)
def test_every_operation_is_differentiated_and_compared(oracle, kind):
    model = one_state(EXPRESSIONS[kind], ("x", 1e-5), ("y", 0.125))
    by_hand = oracle(model)
    solution = model.solve()
    assert solution.figures["failure"] == close(by_hand.figure("failure"))
    found = solution.sensitivities("failure")
    for name in ("x", "y"):
        expected = by_hand.slope("failure", name)
        assert found[name] == pytest.approx(float(expected), rel=1e-11, abs=1e-30)
    low = {"x": 1e-5 * (1 - 1e-6), "y": 0.125}
    expected = by_hand.figure("failure") - oracle(model, low).figure("failure")
    # The change of x itself is a difference of doubles, 1e-6 of them.
    moved = solution.change_from(model.solve(low), "failure")
    assert moved == pytest.approx(float(expected), rel=1e-11, abs=1e-30)


LAWS = {
    "GLM": Glm(Reference("x"), Number(1e-4), Number(0.1), MissionTime()),
    "Weibull": Weibull(Number(1e3), Sum((Number(1.5), Reference("x"))), Number(0.0), MissionTime()),
    "uniform": UniformDeviate(Reference("x"), Number(0.01)),
    "lognormal": LognormalDeviate((Reference("x"), Number(3.0), Number(0.95))),
}


@pytest.mark.parametrize("kind", LAWS)
def test_laws_and_deviates_are_differentiated(kind):
    model = one_state(LAWS[kind], ("x", 1e-3), time_h=100.0)
    step = 1e-3 * 2.0**-14
    ends = [model.solve({"x": 1e-3 + sign * step}).figures["failure"] for sign in (1, -1)]
    expected = (ends[0] - ends[1]) / (2 * step)
    assert model.solve().sensitivities("failure")["x"] == pytest.approx(expected, rel=1e-7)


def test_the_links_are_a_graph_of_networkx(plant):
    pytest.importorskip("networkx", reason="graphs are of networkx")
    graph = plant.to_networkx()
    assert graph.nodes["fault tree 'cell'"] == {"kind": "fault tree", "name": "cell"}
    assert set(graph.predecessors("parameter 'sensor'")) == {"parameter 'motor'"}
    assert set(graph.predecessors("Markov chain 'mission'")) == {
        "fault tree 'cell'",
        "parameter 'sensor'",
    }
    assert set(graph.predecessors("figure 'odd'")) == {"fault tree 'odd'"}
    # The cell's tree takes in the pump's, with its events.
    assert graph.has_edge("Markov chain 'standby'", "fault tree 'cell'")


# the hybrid model of functions


@pytest.fixture(scope="module")
def case(case_study):
    loop = {"place": {"init": Fraction(9, 10), "done": Fraction(1, 10)}}
    return build_model(case_study, profile=loop, name="case study")


@pytest.fixture(scope="module")
def hidden(block, component):
    """Functions that share latent groups, beside parts whose failure shows."""
    power = component("power", 1e-3, 3, "required 2, detected mission_start")
    motor = component("motor", 1e-5, 2)
    blocks = [
        block("pick", 1, (power, motor), after={"place": 1}),
        block("place", 2, (motor,), after={"pick": "4/5", "home": "1/5"}),
        block(
            "home",
            3,
            (component("power", 2e-3, 3, "required 2, detected mission_start"),),
            after={"pick": "1/2", "done": "1/2"},
        ),
    ]
    return build_model(blocks, name="hidden")


@pytest.mark.parametrize("name", ["case", "hidden"])
def test_a_model_of_functions_has_the_same_figures_as_a_linked_model(request, name):
    model = request.getfixturevalue(name)
    assert (name == "hidden") <= bool(model.latent)
    assessment = solve(model)
    converted = linked(model)
    solution = converted.solve()
    figures = solution.figures
    assert figures["mission failure"] == close(assessment.mission.failure_probability, 1e-14)
    assert figures["done"] == close(assessment.mission.done_probability, 1e-14)
    for state in assessment.states:
        assert figures[state.failure_state] == close(state.absorption_probability, 1e-13)
    slopes = solution.sensitivities("mission failure")
    for part in assessment.components:
        assert slopes[part.name] == close(part.birnbaum)
        without = converted.solve({part.name: 0.0})
        fall = solution.change_from(without, "mission failure")
        assert fall / figures["mission failure"] == close(part.fussell_vesely)


def test_too_many_hidden_failures_are_no_linked_model(block, component, monkeypatch):
    monkeypatch.setattr("tracerisk.prm.other_models.linked.conversion.MOST_STATES", 3)
    parts = (component("power", 1e-3, 9, "required 2, detected mission_start"),)
    model = build_model([block("a", 1, parts)], name="m")
    with pytest.raises(TooLargeError, match="'m' has more than 3 states with its hidden failures"):
        linked(model)


# errors


def test_elements_that_depend_on_one_another_are_named():
    tree = LinkedTree("t", "a", (), (LinkedEvent("a", Reference("x")),))
    chain = LinkedChain("c", "s", (Transition("s", "bad", TopEvent("t")), Transition("s", "good")))
    with pytest.raises(
        ModelError,
        match="elements depend on each other: parameter 'x' -> Markov chain 'c' -> "
        "fault tree 't' -> parameter 'x'; break the cycle",
    ):
        LinkedModel("m", (ModelParameter("x", Absorption("c", ("bad",))),), (tree,), (chain,))


STEPS = (Transition("s", "bad", Reference("x")), Transition("s", "done"))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: one_state(Reference("y"), ("x", 0.5)),
            "Markov chain 'mission': there is no parameter 'y'; allowed: x",
        ),
        (
            lambda: one_state(TopEvent("t"), ("x", 0.5)),
            "Markov chain 'mission': there is no fault tree 't'; allowed: none",
        ),
        (
            lambda: LinkedModel("m", figures=(Figure("f", Absorption("c", ("s",))),)),
            "figure 'f': there is no Markov chain 'c'; allowed: none",
        ),
        (
            lambda: LinkedModel(
                "m",
                (ModelParameter("x", Number(0.5)),),
                chains=(LinkedChain("c", "s", STEPS),),
                figures=(Figure("f", Absorption("c", ("s",))),),
            ),
            "figure 'f': Markov chain 'c': 's' is not an absorbing state; allowed: bad, done",
        ),
        (
            lambda: one_state(MissionTime(), ("x", 0.5)),
            "Markov chain 'mission': needs the mission time; give the model one, in hours",
        ),
        (
            lambda: LinkedModel("m", (ModelParameter("x", Number(1.0)),) * 2),
            "duplicate parameter 'x'; rename one",
        ),
        (lambda: LinkedModel("m", mission_time_h=0.0), "mission time 0.0: give a finite number"),
        (
            lambda: LinkedChain("c", "s", (STEPS[0], STEPS[0])),
            "Markov chain 'c', transition 's' to 'bad': duplicate transition; add up the two",
        ),
        (lambda: LinkedChain("c", "t", STEPS), "entry 't' is not a state; allowed: bad, done, s"),
        (
            lambda: LinkedChain("c", "s", (Transition("s", "a", share=Fraction(1, 2)),)),
            "Markov chain 'c', state 's': the shares of its remainder sum to 1/2; they must sum to 1",
        ),
        (
            lambda: LinkedChain("c", "s", STEPS, "continuous"),
            "transition 's' to 'done': the remainder in continuous time; give a rate to another state",
        ),
        (
            lambda: LinkedChain("c", "s", (Transition("s", "s", Number(1.0)),), "continuous"),
            "transition 's' to 's': its own source in continuous time",
        ),
    ],
)
def test_a_model_that_does_not_hold_together_is_refused(make, message):
    with pytest.raises(ModelError) as raised:
        make()
    assert message in str(raised.value)


@pytest.mark.parametrize(
    ("model", "values", "message"),
    [
        (
            one_state(Reference("x"), ("x", 1.5)),
            {},
            "Markov chain 'mission', state 'work': probability 1.5 to 'failed' is outside [0, 1]",
        ),
        (one_state(Reference("x"), ("x", 0.5)), {"y": 1.0}, "no parameter 'y' in 'm'; allowed: x"),
        (one_state(Reference("x"), ("x", 0.5)), {"x": float("nan")}, "'x' is set to nan"),
        (
            LinkedModel(
                "m",
                (ModelParameter("x", Number(0.5)),),
                (),
                (
                    LinkedChain(
                        "c",
                        "s",
                        (
                            Transition("s", "bad", Reference("x")),
                            Transition("s", "done", Reference("x")),
                        ),
                    ),
                ),
            ),
            {"x": 0.4},
            "Markov chain 'c', state 's': its transitions sum to 0.8; they must sum to 1, or one of them must be the remainder",
        ),
        (
            LinkedModel(
                "m",
                (ModelParameter("x", Number(1.5)),),
                (LinkedTree("t", "a", (), (LinkedEvent("a", Reference("x")),)),),
                (),
                (Figure("f", TopEvent("t")),),
            ),
            {},
            "fault tree 't', event 'a': probability 1.5 is outside [0, 1]",
        ),
        (
            LinkedModel("m", (ModelParameter("x", Quotient((Number(1.0), Number(0.0)))),), (), ()),
            {},
            "parameter 'x': a quotient divides by zero",
        ),
        (
            LinkedModel(
                "m",
                (),
                (),
                (
                    LinkedChain(
                        "c",
                        "s",
                        (Transition("s", "t", Number(1.0)), Transition("t", "s", Number(1.0))),
                    ),
                ),
                (Figure("f", Occupancy("c", ("t",), steps=1)),),
            ),
            {},
            None,
        ),
    ],
)
def test_what_cannot_be_solved_names_its_element(model, values, message):
    if message is None:
        # A chain without an end has occupancies, and no absorption.
        assert model.solve(values).figures == {"f": 1.0}
        return
    with pytest.raises(ModelError) as raised:
        model.solve(values)
    assert message in str(raised.value)


def test_a_chain_that_never_ends_is_reported_when_its_end_is_asked_for():
    chain = LinkedChain(
        "c",
        "s",
        (
            Transition("s", "bad", Reference("x")),
            Transition("s", "t"),
            Transition("t", "s", Number(1.0)),
        ),
    )
    model = LinkedModel(
        "m",
        (ModelParameter("x", Number(0.0)),),
        (),
        (chain,),
        (Figure("f", Absorption("c", ("bad",))),),
    )
    with pytest.raises(
        ModelError, match="Markov chain 'c': no absorbing state can be reached from s, t"
    ):
        _ = model.solve().figures
    with pytest.raises(ModelError, match="no figure 'g' in 'm'; allowed: f"):
        model.solve().figure("g")


def test_a_stiff_chain_has_the_figure_of_the_chain_alone():
    # Repaired sixty times an hour, over a year.
    rates = {"up": {"down": 1e-4}, "down": {"up": 60.0, "lost": 1e-3}}
    model = LinkedModel(
        "m",
        (),
        (),
        (
            LinkedChain(
                "c",
                "up",
                tuple(
                    Transition(source, target, Number(rate))
                    for source, row in rates.items()
                    for target, rate in row.items()
                ),
                "continuous",
            ),
        ),
        (Figure("lost", Occupancy("c", ("lost",))), Figure("down", Occupancy("c", ("down",)))),
        8760.0,
    )
    expected = ContinuousChain(rates, ("lost",)).transient("up", 8760.0)
    for name in ("lost", "down"):
        assert model.solve().figure(name).p == pytest.approx(expected[name], rel=1e-13)
