"""What follows a failure: against rationals, drawn missions and rewritings of the code."""

from __future__ import annotations

import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product

import pytest

from tracerisk.prm.hybrid.elements import DONE, Fate, FunctionState, NextStep
from tracerisk.prm.hybrid.hybrid import HybridModel
from tracerisk.prm.hybrid.solve import solve, solve_figures
from tracerisk.prm.trees.fault_tree import FaultTree

FAILED, UNSEEN = "failed", "failed unseen"
LEVELS = {"unaware": 0, "stopped_late": 0, "stopped_safely": 1, "back": 2}


def solved_exactly(
    rows: Mapping[object, Mapping[object, Fraction]], entry: object
) -> dict[object, Fraction]:
    """Return where an absorbing chain ends, by elimination of one state after the other."""
    left = {state: dict(row) for state, row in rows.items()}
    for state in [state for state in left if state != entry]:
        row = left.pop(state)
        stays = row.pop(state, Fraction(0))
        out = {target: p / (1 - stays) for target, p in row.items()} if stays < 1 else {}
        for other in left.values():
            p = other.pop(state, Fraction(0))
            for target, share in out.items():
                other[target] = other.get(target, Fraction(0)) + p * share
    row = left[entry]
    stays = row.pop(entry, Fraction(0))
    return {target: p / (1 - stays) for target, p in row.items()}


class Exact:
    """The chain of a model by its definition: functions, failed units of one pair, each fate."""

    def __init__(self, model: HybridModel) -> None:
        self.model = model
        self.states = {state.name: state for state in model.states}
        self.rank = {state.name: number for number, state in enumerate(model.states)}

    def units(self, state: FunctionState) -> list[tuple[str, Fraction]]:
        return [
            (event.parameter, Fraction(state.probabilities[event.parameter]))
            for event in state.tree.events
            if event.parameter != "pair"
        ]

    def pair(self, state: FunctionState, lost: int) -> dict[int, Fraction]:
        """Return how many units of the pair have failed after a visit."""
        if "pair" not in state.probabilities:
            return {lost: Fraction(1)}
        p = Fraction(state.probabilities["pair"])
        if lost:
            return {1: 1 - p, 2: p}
        return {0: (1 - p) ** 2, 1: 2 * p * (1 - p), 2: p * p}

    def survives(self, state: FunctionState) -> Fraction:
        alive = 1 - self.pair(state, 0).get(2, Fraction(0))
        for _, p in self.units(state):
            alive *= 1 - p
        return alive

    def shows(self, source: str, target: str) -> Fraction:
        """Return how likely a mission gets from behind one function to another."""
        rows: dict[object, dict[object, Fraction]] = {}
        for name, state in self.states.items():
            alive = self.survives(state)
            row: dict[object, Fraction] = {FAILED: 1 - alive}
            for step in state.next:
                key = ("hit",) if step.target == target else step.target
                row[key] = row.get(key, Fraction(0)) + alive * step.weight
            rows[name] = row
        rows["start"] = {
            ("hit",) if step.target == target else step.target: step.weight
            for step in self.states[source].next
        }
        return solved_exactly(rows, "start").get(("hit",), Fraction(0))

    def fates(self, state: FunctionState, name: str) -> list[tuple[tuple[int, str], Fraction]]:
        """Return the fates of one failed unit, each as its rank and function, with its share."""
        found = []
        rest = Fraction(1)
        for fate in state.fates.get(name, ()):
            rest -= fate.share
            shows = self.shows(state.name, fate.shows_in) if fate.shows_in else Fraction(1)
            found.append(((LEVELS[fate.kind], fate.target), fate.share * shows))
            found.append(((0, ""), fate.share * (1 - shows)))
        return [*found, ((0, ""), rest)]

    def visit(self, state: FunctionState, lost: int) -> Iterator[tuple[object, Fraction]]:
        """Yield where a visit leads."""
        none = (9, "")
        outcomes = {none: Fraction(1)}
        for name, p in self.units(state):
            ways = [(none, 1 - p), *((fate, p * w) for fate, w in self.fates(state, name))]
            grown: dict[tuple[int, str], Fraction] = {}
            for (one, weight), (other, share) in product(outcomes.items(), ways):
                worst = min(one, other, key=lambda item: (item[0], self.rank.get(item[1], 0)))
                grown[worst] = grown.get(worst, Fraction(0)) + weight * share
            outcomes = grown
        for after, chance in self.pair(state, lost).items():
            for (level, target), weight in outcomes.items():
                p = chance * weight
                if after == 2 or level == 0:
                    yield UNSEEN, p
                elif level == 1:
                    yield FAILED, p
                elif level == 2:
                    yield (target, after), p
                else:
                    for step in state.next:
                        key = DONE if step.target == DONE else (step.target, after)
                        yield key, p * step.weight

    def figures(self) -> tuple[Fraction, Fraction]:
        """Return the failure of the mission, and the undetected one."""
        rows: dict[object, dict[object, Fraction]] = {}
        for state in self.states.values():
            for lost in (0, 1):
                row: dict[object, Fraction] = {}
                for key, p in self.visit(state, lost):
                    row[key] = row.get(key, Fraction(0)) + p
                rows[state.name, lost] = row
        ends = solved_exactly(rows, (self.model.entry, 0))
        unseen = ends.get(UNSEEN, Fraction(0))
        return ends.get(FAILED, Fraction(0)) + unseen, unseen


def random_fates(draw: random.Random, names: list[str]) -> tuple[Fate, ...]:
    count = draw.randint(1, 4)
    weights = [draw.randint(1, 5) for _ in range(count + draw.randint(0, 1))]
    fates = []
    for weight in weights[:count]:
        kind = draw.choice(["stopped_safely", "stopped_late", "unaware", "back", "stopped_safely"])
        fates.append(
            Fate(
                kind,  # type: ignore[arg-type]
                Fraction(weight, sum(weights)),
                target=draw.choice(names) if kind == "back" else "",
                shows_in=draw.choice(["", "", draw.choice(names)]),
            )
        )
    return tuple(fates)


def random_model(draw: random.Random, *, may_lead_back: bool = True) -> HybridModel:
    names = [f"f{number}" for number in range(draw.randint(1, 4))]
    has_pair = draw.random() < 0.3
    trees, values = {}, {}
    for name in ("a", "b"):
        values[name] = draw.choice([0.5, 0.2, 0.01, 1e-5, 1e-9]) * draw.uniform(0.2, 1.0)
    for name in names:
        parts: dict[str, tuple[str, ...]] = {}
        used: list[str] = [part for part in "ab" if draw.random() < 0.8] or ["a"]
        top = f"{name} fails"
        inputs = list(used)
        if "a" in used and draw.random() < 0.4:
            parts["a"] = ("or", "a[1]", "a[2]")
        if has_pair and draw.random() < 0.7:
            inputs.append("pair")
            parts["pair"] = ("and", "pair[1]", "pair[2]")
        trees[name] = (top, inputs, parts)
    following: dict[str, dict[str, Fraction]] = {}
    for number, name in enumerate(names):
        onward = names[number + 1] if number + 1 < len(names) else DONE
        targets = {onward: draw.randint(1, 3)}
        if draw.random() < 0.5:
            other = draw.choice(names)
            targets[other] = targets.get(other, 0) + draw.randint(1, 3)
        whole = sum(targets.values())
        following[name] = {target: Fraction(count, whole) for target, count in targets.items()}
    model = built(names, trees, following, {**values, "pair": draw.uniform(0.01, 0.3)})
    states = []
    for state in model.states:
        fates = {}
        for parameter in state.probabilities:
            if parameter != "pair" and draw.random() < 0.8:
                fates[parameter] = random_fates(draw, names)
        if not may_lead_back:
            fates = {
                name: tuple(fate for fate in items if fate.kind != "back")
                for name, items in fates.items()
            }
        states.append(replace(state, fates=fates))
    return replace(model, states=tuple(states))


def built(
    names: list[str],
    trees: Mapping[str, tuple[str, list[str], Mapping[str, tuple[str, ...]]]],
    following: Mapping[str, Mapping[str, Fraction]],
    values: Mapping[str, float],
) -> HybridModel:
    from tracerisk.prm.hybrid.elements import Parameter
    from tracerisk.prm.trees.events import BasicEvent
    from tracerisk.prm.trees.gates import Gate, GateKind

    states, latent = [], False
    for rank, name in enumerate(names, 1):
        top, inputs, parts = trees[name]
        gates = [Gate(top, GateKind.OR, tuple(inputs))]
        events = []
        for part in inputs:
            if part in parts:
                kind, *units = parts[part]
                gates.append(Gate(part, GateKind(kind), tuple(units)))
                events += [BasicEvent(unit, part, component=part) for unit in units]
                latent = latent or part == "pair"
            else:
                events.append(BasicEvent(part, part, component=part))
        tree = FaultTree(top, tuple(gates), tuple(events))
        states.append(
            FunctionState(
                name,
                rank,
                tree,
                {parameter: values[parameter] for parameter in tree.parameters},
                tuple(NextStep(target, share) for target, share in following[name].items()),
            )
        )
    used = {parameter for state in states for parameter in state.probabilities}
    return HybridModel(
        "random",
        names[0],
        tuple(states),
        tuple(Parameter(name, values[name]) for name in sorted(used)),
        ("pair[1]", "pair[2]") if latent else (),
    )


@pytest.mark.parametrize("block", range(6))
def test_random_models_agree_with_rationals(block: int) -> None:
    draw = random.Random(block)
    for _ in range(500):
        model = random_model(draw)
        mission = solve_figures(model).mission
        failure, undetected = Exact(model).figures()
        assert mission.geometric_cycles == pytest.approx(float(failure), rel=1e-10)
        if mission.undetected_geometric is not None:
            assert mission.undetected_geometric == pytest.approx(float(undetected), rel=1e-10)


def test_without_ways_back_the_failure_of_the_mission_is_as_without_fates() -> None:
    draw = random.Random(5)
    for _ in range(100):
        model = random_model(draw, may_lead_back=False)
        plain = replace(model, states=tuple(replace(s, fates={}) for s in model.states))
        with_fates, without = solve(model).mission, solve(plain).mission
        assert with_fates.failure_probability == without.failure_probability
        assert with_fates.visits_as_run == without.visits_as_run
        assert without.undetected_probability is None
