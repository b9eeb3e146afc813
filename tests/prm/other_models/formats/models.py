"""Hypothesis strategies for logic models, in the form in which readers return them."""

import string
from dataclasses import replace
from functools import cache

from hypothesis import strategies as st

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
from tracerisk.prm.other_models.expressions.deviates import (
    BetaDeviate,
    GammaDeviate,
    Histogram,
    LognormalDeviate,
    NormalDeviate,
    UniformDeviate,
)
from tracerisk.prm.other_models.expressions.laws import Exponential, Glm, PeriodicTest, Weibull
from tracerisk.prm.other_models.logic.common_cause import CommonCauseLaw
from tracerisk.prm.other_models.logic.mission_parts import GroupDefinition
from tracerisk.prm.other_models.logic.model import (
    ALWAYS,
    NEVER,
    Attribute,
    Container,
    EventDefinition,
    GateDefinition,
    HouseDefinition,
    LogicModel,
    ParameterDefinition,
    Place,
)
from tracerisk.prm.trees.events import HouseEvent
from tracerisk.prm.trees.gates import Gate, GateKind

LETTERS = string.ascii_letters + string.digits + "_-. []/#éЖ"
names = st.text(LETTERS, min_size=1, max_size=8).filter(
    lambda name: name not in (ALWAYS, NEVER, "#") and name == name.strip()
)
texts = st.text(string.ascii_letters + "<&>\"' é", max_size=12).map(str.strip)
finite = st.floats(allow_nan=False, allow_infinity=False)
probabilities = st.floats(0.0, 1.0)
attributes = st.lists(
    st.builds(Attribute, st.sampled_from(("source", "owner")), texts.filter(bool)),
    max_size=2,
    unique_by=lambda each: each.name,
).map(tuple)


def ordered(model):
    """The model with its elements sorted by name: a file tells no order between fault trees."""
    sorted_parts = {
        part: tuple(sorted(getattr(model, part), key=lambda each: each.name))
        for part in ("gates", "events", "houses", "parameters", "groups")
    }
    containers = tuple(sorted(model.containers, key=lambda each: each.path))
    return replace(model, **sorted_parts, containers=containers)


@cache
def expressions(parameters):
    leaves = [
        finite.map(Number),
        st.integers(-9, 9).map(lambda number: Number(number, "int")),
        st.booleans().map(lambda value: Number(float(value), "bool")),
        st.just(MissionTime()),
        *([st.sampled_from(parameters).map(Reference)] if parameters else []),
    ]

    def grown(inner):
        several = st.lists(inner, min_size=2, max_size=3).map(tuple)
        return st.one_of(
            several.map(Sum),
            several.map(Difference),
            several.map(Product),
            several.map(Quotient),
            inner.map(Negation),
            st.builds(Exponential, inner, inner),
            st.builds(Glm, inner, inner, inner, inner),
            st.builds(Weibull, inner, inner, inner, inner),
            st.lists(inner, min_size=4, max_size=5).map(lambda terms: PeriodicTest(tuple(terms))),
            st.builds(UniformDeviate, inner, inner),
            st.builds(NormalDeviate, inner, inner),
            st.builds(GammaDeviate, inner, inner),
            st.builds(BetaDeviate, inner, inner),
            st.lists(inner, min_size=2, max_size=3).map(lambda t: LognormalDeviate(tuple(t))),
            st.lists(inner, min_size=2, max_size=4).map(
                lambda terms: Histogram(tuple(terms), tuple(terms[1:]))
            ),
            st.tuples(inner, inner, inner).map(lambda terms: Call("ite", terms)),
            st.tuples(inner, inner, inner).map(lambda terms: Call("switch", terms)),
            st.sampled_from(("min", "max", "mean")).flatmap(
                lambda name: several.map(lambda terms: Call(name, terms))
            ),
            st.just(Call("pi", ())),
        )

    return st.recursive(st.one_of(leaves), grown, max_leaves=4)


@cache
def _computed(parameters):
    return expressions(parameters).filter(lambda expression: expression.arguments)


KINDS = tuple(GateKind)


@st.composite
def gates(draw, name, below):
    """A gate over some of the names below it, one of them perhaps twice."""
    kind = draw(st.sampled_from(KINDS))
    least, most = {
        GateKind.NOT: (1, 1),
        GateKind.TRANSFER: (1, 1),
        GateKind.IFF: (2, 2),
        GateKind.IMPLY: (2, 2),
        GateKind.INHIBIT: (2, 2),
        GateKind.XOR: (2, 4),
        GateKind.OR: (0, 4),
    }.get(kind, (1, 4))
    inputs = tuple(draw(st.lists(st.sampled_from(below), min_size=least, max_size=most)))
    k = top = None
    if kind is GateKind.ATLEAST:
        k = draw(st.integers(1, len(inputs)))
    if kind is GateKind.CARDINALITY:
        k = draw(st.integers(0, len(inputs)))
        top = draw(st.integers(k, len(inputs)))
    return Gate(name, kind, inputs, k, top)


@st.composite
def logic_models(draw, *, figures=None, plain_names=False):
    """A model with homes, private names, common causes and every kind of gate."""
    name_of = st.text(string.ascii_lowercase, min_size=1, max_size=5) if plain_names else names
    homes = draw(st.lists(name_of, max_size=2, unique=True))
    containers = [Container(home, label=draw(texts)) for home in homes]
    if homes and draw(st.booleans()):
        inner = Container(f"{homes[0]}.inner", draw(st.booleans()), "", draw(attributes))
        if inner.path not in homes:
            containers.append(inner)
    paths = ["", *(each.path for each in containers)]

    def place():
        home = draw(st.sampled_from(paths))
        private = bool(home) and draw(st.booleans())
        return Place(home, private, draw(texts), draw(attributes))

    def named(short, where):
        return f"{where.home}.{short}" if where.private else short

    shorts = draw(st.lists(name_of, min_size=4, max_size=14, unique=True))
    taken = set()

    def fresh(short):
        where = place()
        full = named(short, where)
        if full in taken:
            return None
        taken.add(full)
        return full, where

    parameters = []
    for short in draw(st.lists(name_of, max_size=3, unique=True)):
        where = place()
        full = named(short, where)
        if all(full != each.name for each in parameters):
            known = tuple(each.name for each in parameters)
            unit = draw(st.sampled_from(("", "hours-1", "float")))
            value = expressions(known) if figures is None else figures
            parameters.append(ParameterDefinition(full, draw(value), unit, where))
    known = tuple(each.name for each in parameters)
    figure = figures
    if figure is None:
        computed = _computed(known)
        figure = st.one_of(st.none(), probabilities.map(Number), computed)
    events, houses, found = [], [], []
    count = max(2, len(shorts) // 2)
    for short in shorts[:count]:
        got = fresh(short)
        if got is None:
            continue
        if draw(st.integers(0, 4)) == 0:
            houses.append(HouseDefinition(HouseEvent(got[0], draw(st.booleans())), got[1]))
        else:
            events.append(EventDefinition(got[0], draw(figure), got[1]))
    below = [ALWAYS, NEVER, *(each.name for each in (*events, *houses))]
    for short in shorts[count:]:
        got = fresh(short)
        if got is not None:
            gate = draw(gates(got[0], below))
            found.append(GateDefinition(gate, got[1], nested=draw(st.booleans())))
            below.append(got[0])
    groups = []
    members = [each for each in events if each.place == Place()]
    if len(members) >= 2 and draw(st.booleans()):
        events = [each for each in events if each not in members]
        distribution = draw(probabilities.map(Number))
        groups.append(
            GroupDefinition(
                "group",
                CommonCauseLaw.BETA,
                tuple(each.name for each in members),
                distribution,
                ((len(members), Number(draw(probabilities))),),
            )
        )
        events += [EventDefinition(each.name) for each in members]
    return LogicModel(
        draw(st.one_of(st.just(""), name_of)),
        tuple(found),
        tuple(events),
        tuple(houses),
        tuple(parameters),
        tuple(groups),
        containers=tuple(containers),
        label=draw(texts),
    )


def solved_tops(model, mission_time_h, *, common_cause=True):
    """Return the probability of each top event for a mission, [h]."""
    found = {}
    for top in model.tops:
        tree = model.fault_tree(top, common_cause=common_cause, mission_time_h=mission_time_h)
        found[top] = tree.probability(tree.values_at(mission_time_h)).p
    return found
