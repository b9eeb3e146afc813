"""Trees of repaired events, against matrix exponentials over all sets of failed events."""

import random
import re

import pytest

from tests.slow import slow_but_every
from tests.storm import of_gates, storm_probability
from tracerisk.errors import ModelError, TooLargeError
from tracerisk.prm.other_models.dynamic import DynamicEvent, DynamicGate, DynamicKind, DynamicTree
from tracerisk.prm.other_models.dynamic.first_failure import first_failure, without_repair
from tracerisk.prm.trees.failure_models import GLM, Constant, Exponential, Weibull
from tracerisk.prm.trees.gates import Gate, GateKind

mpmath = pytest.importorskip("mpmath", reason="mpmath gives the exact figures")

HOURS = 10.0


def drawn_tree(rng):
    """A random coherent tree of up to four events, most of them repaired, some shared."""
    count = rng.randint(2, 4)
    events = []
    for number in range(count):
        rate, repair = (10.0 ** rng.uniform(-6, 0) for _ in range(2))
        model = rng.choice(
            [
                GLM(rng.choice([0.0, 0.1]), rate, repair),
                GLM(0.0, rate, repair),
                Exponential(rate),
                Constant(rng.uniform(0.0, 0.5)),
            ]
        )
        events.append(DynamicEvent(f"e{number}", model))
    below = [event.name for event in events]
    rng.shuffle(below)
    gates = []
    for number in range(2):
        inputs = tuple(rng.sample(below, rng.randint(1, len(below))))
        kind = rng.choice([GateKind.AND, GateKind.OR, GateKind.ATLEAST])
        k = rng.randint(1, len(inputs)) if kind is GateKind.ATLEAST else None
        gates.append(Gate(f"g{number}", kind, inputs, k))
    used = {name for gate in gates for name in gate.inputs}
    rest = [event.name for event in events if event.name not in used]
    kind = rng.choice([GateKind.AND, GateKind.OR])
    gates.append(Gate("top", kind, ("g0", "g1", *rest)))
    return DynamicTree("top", tuple(gates), tuple(events))


def is_failed(tree, name, failed):
    gate = next((gate for gate in tree.gates if gate.name == name), None)
    if gate is None:
        return name in failed
    count = sum(is_failed(tree, below, failed) for below in gate.inputs)
    least = {GateKind.AND: len(gate.inputs), GateKind.OR: 1, GateKind.ATLEAST: gate.k}[gate.kind]
    return count >= least


def laws(event):
    model = event.model
    if isinstance(model, GLM):
        return model.failure_on_demand, model.failure_rate, model.repair_rate
    if isinstance(model, Exponential):
        return 0.0, model.rate, 0.0
    return model.p, 0.0, 0.0


def exact(tree, *, is_left):
    """The top's probability after `HOURS` by all sets of failed events, in 40 digits.

    The top's failure is left again by repair, or is not.
    """
    events = tree.events
    size = 2 ** len(events)
    sets = [{e.name for n, e in enumerate(events) if bits >> n & 1} for bits in range(size)]
    with mpmath.workdps(40):
        start = mpmath.matrix(1, size)
        generator = mpmath.matrix(size, size)
        for bits in range(size):
            chance = mpmath.mpf(1)
            for number, event in enumerate(events):
                at_start, rate, repair = map(mpmath.mpf, laws(event))
                chance *= at_start if bits >> number & 1 else 1 - at_start
                way = repair if bits >> number & 1 else rate
                if is_left or not is_failed(tree, "top", sets[bits]):
                    generator[bits, bits ^ 1 << number] += way
                    generator[bits, bits] -= way
            start[0, bits] = chance
        end = start * mpmath.expm(generator * HOURS, method="taylor")
        return mpmath.fsum(
            end[0, bits] for bits in range(size) if is_failed(tree, "top", sets[bits])
        )


@pytest.mark.slow(but=10)
@pytest.mark.parametrize("seed", slow_but_every(50, range(1000)))
def test_random_trees_are_those_of_all_sets_of_failed_events(seed):
    tree = drawn_tree(random.Random(seed))
    now, ever = exact(tree, is_left=True), exact(tree, is_left=False)
    found = first_failure(tree, HOURS)
    assert found.p == pytest.approx(float(ever), rel=1e-11, abs=1e-35)
    assert found.q == pytest.approx(float(1 - ever), rel=1e-11, abs=1e-35)
    assert tree.probability(HOURS).p == pytest.approx(float(now), rel=1e-11, abs=1e-35)
    assert found.p >= tree.probability(HOURS).p * (1 - 1e-12)


def program(tree):
    """The events as modules of a chain in continuous time, of PRISM."""
    text = ["ctmc"]
    for event in tree.events:
        at_start, rate, repair = laws(event)
        if at_start:
            return None
        text += [f"module {event.name}", f"x{event.name} : bool init false;"]
        if rate:
            text.append(f"[] !x{event.name} -> {rate:.20f} : (x{event.name}'=true);")
        if repair:
            text.append(f"[] x{event.name} -> {repair:.20f} : (x{event.name}'=false);")
        text.append("endmodule")
    shapes = {gate.name: (gate.kind.value, gate.k, gate.inputs) for gate in tree.gates}
    leaves = {event.name: f"x{event.name}" for event in tree.events}
    text.append(f'label "failed" = {of_gates(shapes, tree.top, leaves)};')
    return "\n".join(text)


@pytest.mark.parametrize("seed", slow_but_every(50, range(1000)))
def test_storm_finds_the_same(seed, tmp_path):
    random_ = random.Random(seed)
    while (text := program(tree := drawn_tree(random_))) is None:
        pass
    path = tmp_path / "m.prism"
    ever = storm_probability(path, text, f'P=? [F<={HOURS} "failed"]')
    now = storm_probability(path, text, f'P=? [F[{HOURS},{HOURS}] "failed"]')
    assert first_failure(tree, HOURS).p == pytest.approx(float(ever), rel=1e-5, abs=1e-10)
    assert tree.probability(HOURS).p == pytest.approx(float(now), rel=1e-5, abs=1e-10)


def test_a_tree_without_repair_is_above_what_happens_at_any_time():
    pair = DynamicTree.of("top", {"top": ("and", "a", "b")}, {n: GLM(0.0, 0.1, 0.5) for n in "ab"})
    now, ever = (answer.p for answer in (pair.probability(HOURS), first_failure(pair, HOURS)))
    assert now < ever < without_repair(pair).probability(HOURS).p
    # Two events of rate a, repaired at b: the transform of the first failure is that of a chain
    # of three states, whose two roots give it by hand.
    a, b = 0.1, 0.5
    mid, root = (3 * a + b) / 2, ((a * a + 6 * a * b + b * b) ** 0.5) / 2
    fast, slow = mid + root, mid - root
    e = 2.718281828459045
    survival = (fast * e ** (-slow * HOURS) - slow * e ** (-fast * HOURS)) / (fast - slow)
    assert ever == pytest.approx(1 - survival, rel=1e-12)


@pytest.mark.parametrize(
    ("tree", "error", "message"),
    [
        (
            DynamicTree(
                "t",
                (DynamicGate("t", DynamicKind.PAND, ("a", "b")),),
                tuple(DynamicEvent(name, Exponential(1.0)) for name in "ab"),
            ),
            ModelError,
            "gate 't': pand has no meaning with repair",
        ),
        (
            DynamicTree.of("a", {}, {"a": Weibull(1.0, 2.0)}),
            ModelError,
            "event 'a': Weibull has no constant rate",
        ),
        (
            DynamicTree.of(
                "t",
                {"t": ("or", *(f"e{n}" for n in range(15)))},
                {f"e{n}": GLM(0.0, 1.0, 1.0) for n in range(15)},
            ),
            TooLargeError,
            "15 events; the first failure of a tree with repair is found for up to 14",
        ),
    ],
)
def test_what_has_no_first_failure_says_so(tree, error, message):
    with pytest.raises(error, match=re.escape(message)):
        first_failure(tree, 1.0)
