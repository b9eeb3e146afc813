import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import pytest
from hypothesis import strategies as st

from tracerisk.adder.blocks.block import ComponentEntry, Field, RiskBlock, Transition
from tracerisk.adder.blocks.values import read_redundancy
from tracerisk.prm import FaultTree, HybridModel, build_model

MakeComponent = Callable[..., ComponentEntry]
MakeBlock = Callable[..., RiskBlock]


def _field(value):
    return Field(value, str(value))


@pytest.fixture(scope="session")
def component() -> MakeComponent:
    """Make one `@Component` entry."""

    def make(name, probability, quantity=1, redundancy="false", **marks):
        text = str(redundancy).lower()
        return ComponentEntry(
            name,
            _field(probability),
            _field(quantity),
            Field(read_redundancy(text), text),
            **marks,
        )

    return make


@pytest.fixture(scope="session")
def block() -> MakeBlock:
    """Make one risk block; `after` gives its `next` as a mapping from target to fraction, or none.

    It is written as a distribution, in decimals, or as `counts` are.
    """

    def make(
        name,
        call_sequence,
        components: Sequence[ComponentEntry] = (),
        after=None,
        counts=False,
        **marks,
    ):
        following = None
        if after is not None:
            steps = tuple(Transition(t, Fraction(w)) for t, w in after.items())
            shares = [str(step.weight) if counts else f"{float(step.weight):g}" for step in steps]
            text = ", ".join(f"{t} {share}" for t, share in zip(after, shares, strict=True))
            following = Field(steps, text)
        return RiskBlock(name, _field(call_sequence), following, tuple(components), **marks)

    return make


@pytest.fixture(scope="session")
def case_study(block, component) -> tuple[RiskBlock, ...]:
    """The published case: an arm that picks and places test tubes, in the published form."""
    renewed = "true, detected each_visit"
    power = component("power_system", 6.674e-08, 2, renewed)
    control = component("control_system", 2.167e-10, 2, renewed)
    gripper = component("gripper", 7.344e-08)
    motors = component("electric_motor", 9.5e-08, 7)
    loaded_motors = component("electric_motor", 1.30644e-07, 7)
    return (
        block("init", 1, (power, control, gripper, motors)),
        block("pick_position", 2, (power, control, motors)),
        block("pick", 3, (power, control, gripper, motors)),
        block("place_position", 4, (power, control, loaded_motors)),
        block("place", 5, (power, control, gripper)),
    )


class Exact:
    """An independent solver: enumeration and Gauss-Jordan elimination in exact rationals."""

    def __init__(self, number: Callable[..., Any] = Fraction) -> None:
        self.number = number
        self._combinations: dict[FaultTree, Counter[tuple[int, ...]]] = {}

    def top(self, tree: FaultTree, values: Mapping[str, Fraction]) -> Fraction:
        """Sum over all combinations of events, those alike in their counts taken together."""
        if tree not in self._combinations:
            self._combinations[tree] = self._enumerate(tree)
        units = Counter(event.parameter for event in tree.events)
        total = Fraction(0)
        for happened, number in self._combinations[tree].items():
            share = Fraction(number)
            for parameter, count in zip(tree.parameters, happened, strict=True):
                p = values[parameter]
                share *= p**count * (1 - p) ** (units[parameter] - count)
            total += share
        return total

    def _enumerate(self, tree: FaultTree) -> Counter[tuple[int, ...]]:
        """Count the combinations that cause the top, by how many events of each parameter."""
        found: Counter[tuple[int, ...]] = Counter()
        for outcome in product((False, True), repeat=len(tree.events)):
            happened = dict(zip((event.name for event in tree.events), outcome, strict=True))
            if self._happens(tree, tree.top, happened):
                counts = Counter(e.parameter for e in tree.events if happened[e.name])
                found[tuple(counts[parameter] for parameter in tree.parameters)] += 1
        return found

    def _happens(self, tree: FaultTree, name: str, happened: Mapping[str, bool]) -> bool:
        if name in happened:
            return happened[name]
        gate = next(gate for gate in tree.gates if gate.name == name)
        count = sum(self._happens(tree, child, happened) for child in gate.inputs)
        needed = {"or": 1, "and": len(gate.inputs), "atleast": gate.k}[gate.kind.value]
        return count >= needed

    def visits(self, rows: Mapping[str, Mapping[str, Fraction]], entry: str) -> dict:
        """Solve v (I - Q) = e."""
        names = list(rows)
        matrix = [
            [self.number(int(i == j)) - rows[j].get(i, self.number(0)) for j in names]
            + [self.number(int(i == entry))]
            for i in names
        ]
        size = len(names)
        for column in range(size):
            pivot = next(row for row in range(column, size) if matrix[row][column] != 0)
            matrix[column], matrix[pivot] = matrix[pivot], matrix[column]
            lead = matrix[column][column]
            matrix[column] = [value / lead for value in matrix[column]]
            for row in range(size):
                factor = matrix[row][column]
                if row != column and factor != 0:
                    matrix[row] = [
                        a - factor * b for a, b in zip(matrix[row], matrix[column], strict=True)
                    ]
        return {name: matrix[index][size] for index, name in enumerate(names)}

    def normalised(self, rows: Mapping[str, Mapping[str, float]]) -> dict:
        """Return the rows as rationals, each divided by its sum."""
        exact = {}
        for state, row in rows.items():
            total = sum(map(Fraction, row.values()))
            exact[state] = {target: Fraction(p) / total for target, p in row.items()}
        return exact

    def mission(self, model: HybridModel, scale: Mapping[str, Fraction] | None = None) -> Fraction:
        """Return the mission's failure probability, parameters multiplied by `scale`."""
        if model.latent:
            return self.mission_by_events(model, scale or {})
        tops = {}
        rows = {}
        for state in model.states:
            values = {
                name: Fraction(p) * (scale or {}).get(name, 1)
                for name, p in state.probabilities.items()
            }
            tops[state.name] = self.top(state.tree, values)
            rows[state.name] = {
                step.target: (1 - tops[state.name]) * step.weight
                for step in state.next
                if step.target != "done"
            }
        visits = self.visits(rows, model.entry)
        return sum((visits[name] * tops[name] for name in tops), Fraction(0))

    def mission_by_events(self, model: HybridModel, scale: Mapping[str, Any]) -> Any:
        """Enumerate every combination of events in every function and set of failed units."""
        functions = {state.name: state for state in model.states}
        latent = set(model.latent)
        rows: dict[tuple, dict] = {}
        tops: dict[tuple, Any] = {}
        waiting = [(model.entry, frozenset())]
        while waiting:
            at = waiting.pop()
            if at in rows:
                continue
            function, failed = functions[at[0]], at[1]
            rows[at], tops[at] = {}, self.number(0)
            for happened, share in self._outcomes(function, failed, scale):
                if self._happens(function.tree, function.tree.top, happened):
                    tops[at] += share
                    continue
                now = failed | {name for name in latent if happened.get(name)}
                for step in function.next:
                    if step.target != "done" and step.weight > 0:
                        there = (step.target, now)
                        weight = self.number(step.weight.numerator) / step.weight.denominator
                        rows[at][there] = rows[at].get(there, 0) + share * weight
                        waiting.append(there)
        visits = self.visits(rows, (model.entry, frozenset()))
        return sum((visits[at] * tops[at] for at in tops), self.number(0))

    def _outcomes(self, function, failed, scale):
        events = function.tree.events
        values = {
            name: self.number(p) * scale.get(name, 1) for name, p in function.probabilities.items()
        }
        for outcome in product((False, True), repeat=len(events)):
            share = self.number(1)
            for event, happens in zip(events, outcome, strict=True):
                p = self.number(1) if event.name in failed else values[event.parameter]
                share *= p if happens else 1 - p
            if share:
                yield {e.name: o for e, o in zip(events, outcome, strict=True)}, share


@pytest.fixture(scope="session")
def in_many_digits() -> Exact:
    """The same solver in floats of 250 digits, for differences that fractions are too slow for."""
    mpmath = pytest.importorskip("mpmath")
    context = mpmath.mp.clone()
    context.dps = 250
    return Exact(context.mpf)


@pytest.fixture(scope="session")
def exact() -> Exact:
    return Exact()


PARTS = {
    "pair": (2, ("true", "true, detected each_visit", "false", "true, common_cause 0.25")),
    "cell": (3, ("required 2", "true", "required 2, detected each_visit")),
    "motor": (1, ("false",)),
}


@pytest.fixture(scope="session")
def small_models(block, component):
    """Draw models of one to three functions with groups of every kind, loops and branches."""

    @st.composite
    def models(draw, least=1e-20, functions=3, parts_each=0, rare=False):
        names = [f"f{i}" for i in range(draw(st.integers(1, functions)))]
        chance = st.floats(math.log10(least), -1.0).map(lambda x: 10**x)
        if not rare:
            chance = st.one_of(chance, st.just(0.25))
        blocks = []
        for index, name in enumerate(names):
            parts = []
            names_here = st.lists(
                st.sampled_from(sorted(PARTS)), unique=True, min_size=parts_each, max_size=2
            )
            for part in draw(names_here):
                quantity, kinds = PARTS[part]
                parts.append(component(part, draw(chance), quantity, draw(st.sampled_from(kinds))))
            weights = {target: draw(st.integers(0, 4)) for target in (*names, "done")}
            weights["done"] += 1
            total = sum(weights.values())
            after = {target: Fraction(weight, total) for target, weight in weights.items()}
            blocks.append(block(name, index + 1, parts, after=after))
        return build_model(blocks, name="random")

    return models
