"""What follows a failure: against rationals, drawn missions and rewritings of the code."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping
from dataclasses import replace
from fractions import Fraction
from itertools import product

import pytest

from tracerisk.errors import ModelError
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


def drawn(model: HybridModel, missions: int, seed: int) -> tuple[int, int]:
    """Return how many of so many drawn missions failed, and how many of them unnoticed."""
    draw = random.Random(seed)
    states = {state.name: state for state in model.states}
    rank = {state.name: number for number, state in enumerate(model.states)}
    failed = unseen = 0
    for _ in range(missions):
        now, remembered = model.entry, None
        while True:
            if remembered is not None and now == remembered.shows_in:
                # The failure shows, and what follows is now known.
                kind, target = remembered.kind, remembered.target
                remembered = None
            else:
                state = states[now]
                worst = None
                for event in state.tree.events:
                    if draw.random() >= state.probabilities[event.parameter]:
                        continue
                    fate = drawn_fate(draw, state.fates.get(event.parameter, ()))
                    key = (LEVELS[fate.kind], rank.get(fate.target, 0))
                    if worst is None or key < worst[0]:
                        worst = (key, fate)
                if worst is None:
                    steps = state.next
                    now = draw.choices([s.target for s in steps], [float(s.weight) for s in steps])[
                        0
                    ]
                    if now == DONE:
                        failed += remembered is not None
                        unseen += remembered is not None
                        break
                    continue
                fate = worst[1]
                if remembered is not None:
                    kind, target = "unaware", ""
                elif fate.shows_in and LEVELS[fate.kind]:
                    remembered = fate
                    steps = state.next
                    now = draw.choices([s.target for s in steps], [float(s.weight) for s in steps])[
                        0
                    ]
                    if now == DONE:
                        failed += 1
                        unseen += 1
                        break
                    continue
                else:
                    kind, target = fate.kind, fate.target
            if kind == "back":
                now = target
                continue
            failed += 1
            unseen += LEVELS[kind] == 0
            break
    return failed, unseen


def drawn_fate(draw: random.Random, fates: tuple[Fate, ...]) -> Fate:
    at = draw.random()
    for fate in fates:
        at -= float(fate.share)
        if at < 0.0:
            return fate
    return Fate("unaware", Fraction(1))


RECOVERING = built(
    ["pick", "look", "place"],
    {
        "pick": ("pick fails", ["a"], {}),
        "look": ("look fails", ["b"], {}),
        "place": ("place fails", ["b"], {}),
    },
    {
        "pick": {"look": Fraction(1)},
        "look": {"place": Fraction(1)},
        "place": {"pick": Fraction(3, 4), DONE: Fraction(1, 4)},
    },
    {"a": 0.04, "b": 0.02},
)


def with_fates(model: HybridModel, **fates: Mapping[str, tuple[Fate, ...]]) -> HybridModel:
    states = [replace(state, fates=fates.get(state.name, {})) for state in model.states]
    return replace(model, states=tuple(states))


@pytest.mark.parametrize(
    "fates",
    [
        {"a": (Fate("back", Fraction(3, 4), target="pick"),)},
        {
            "a": (
                Fate("back", Fraction(1, 2), target="pick", shows_in="look"),
                Fate("stopped_safely", Fraction(3, 8), shows_in="place"),
                Fate("stopped_late", Fraction(1, 16)),
            )
        },
    ],
    ids=["retries", "shown later"],
)
def test_drawn_missions_fail_as_often_as_is_solved(fates: Mapping[str, tuple[Fate, ...]]) -> None:
    missions = 100_000
    model = with_fates(RECOVERING, pick=fates, look={"b": (Fate("stopped_safely", Fraction(1)),)})
    mission = solve_figures(model).mission
    for count, p in zip(
        drawn(model, missions, 7),
        (mission.geometric_cycles, mission.undetected_geometric or 0.0),
        strict=True,
    ):
        assert abs(count / missions - p) < 3.0 * (p * (1.0 - p) / missions) ** 0.5


def test_with_fixed_cycles_what_is_undetected_counts_over_all_of_them() -> None:
    model = replace(
        with_fates(RECOVERING, pick={"a": (Fate("stopped_safely", Fraction(1, 4)),)}), counted=True
    )
    mission = solve_figures(model).mission
    alive, unseen = 1.0, 0.0
    for p, noticed in [(0.04, 0.25), (0.02, 0.0), (0.02, 0.0)] * 4:
        unseen += alive * p * (1.0 - noticed)
        alive *= 1.0 - p
    assert mission.reading == "fixed cycles"
    assert mission.failure_probability == pytest.approx(1.0 - alive, rel=1e-12)
    assert mission.undetected_probability == pytest.approx(unseen, rel=1e-12)


def split(model: HybridModel, name: str, share: float) -> HybridModel:
    """Return a model in which a function is two, the second after the first."""
    more = f"{name}_rest"
    states = []
    for state in model.states:
        if state.name != name:
            states.append(state)
            continue
        first = {key: -math.expm1(share * math.log1p(-p)) for key, p in state.probabilities.items()}
        second = {
            key: -math.expm1((1 - share) * math.log1p(-p)) for key, p in state.probabilities.items()
        }
        states.append(replace(state, probabilities=first, next=(NextStep(more, Fraction(1)),)))
        states.append(replace(state, name=more, probabilities=second))
    numbered = [replace(state, call_sequence=rank) for rank, state in enumerate(states, 1)]
    return replace(model, states=tuple(numbered))


@pytest.mark.parametrize("rewriting", range(20))
def test_the_law_of_refactoring_holds_for_both_figures(rewriting: int) -> None:
    draw = random.Random(rewriting)
    fates = {
        "a": (
            Fate("stopped_safely", Fraction(1, 3)),
            Fate("back", Fraction(1, 5), target="pick", shows_in="place"),
            Fate("stopped_safely", Fraction(1, 7), shows_in="look"),
        )
    }
    values = {"a": 4e-6, "b": 7e-7}
    model = with_fates(RECOVERING, pick=fates, look={"b": (Fate("stopped_safely", Fraction(1)),)})
    model = replace(
        model,
        states=tuple(
            replace(state, probabilities={key: values[key] for key in state.probabilities})
            for state in model.states
        ),
    )
    before = solve_figures(model).mission
    for _ in range(draw.randint(1, 4)):
        name = draw.choice([state.name for state in model.states])
        if f"{name}_rest" not in {state.name for state in model.states}:
            model = split(model, name, draw.uniform(0.1, 0.9))
    after = solve_figures(model).mission
    assert after.failure_probability == pytest.approx(before.failure_probability, rel=1e-4)
    assert after.undetected_probability == pytest.approx(before.undetected_probability, rel=1e-4)


def test_a_redundant_unit_cannot_have_fates() -> None:
    model = built(
        ["f"],
        {"f": ("f fails", ["pair"], {"pair": ("and", "pair[1]", "pair[2]")})},
        {"f": {DONE: Fraction(1)}},
        {"pair": 0.1},
    )
    with pytest.raises(ModelError, match="where each unit is needed"):
        with_fates(model, f={"pair": (Fate("unaware", Fraction(1)),)})


@pytest.mark.parametrize(
    ("fate", "message"),
    [
        (Fate("back", Fraction(1), target="gone"), "'gone' is not a state"),
        (Fate("back", Fraction(1)), "'back' with the target ''"),
        (Fate("unaware", Fraction(3, 2)), "may sum to 1 at most"),
    ],
)
def test_fates_that_make_no_sense_are_named(fate: Fate, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        with_fates(RECOVERING, pick={"a": (fate,)})


def test_draws_of_the_parameters_give_what_each_gives_alone() -> None:
    import numpy as np

    from tracerisk.prm.questions.sampled_mission import failure_samples
    from tracerisk.prm.questions.set_values import with_values

    draw = random.Random(3)
    for _ in range(60):
        model = random_model(draw)
        if shown(model) or not any(state.fates for state in model.states):
            continue
        values = {
            p.name: np.array([p.theta * 0.3, p.theta, p.theta * 0.8]) for p in model.parameters
        }
        for undetected in (False, True):
            samples = failure_samples(model, values, undetected=undetected)
            for number in range(3):
                one = solve_figures(
                    with_values(model, {name: float(row[number]) for name, row in values.items()})
                ).mission
                alone = one.undetected_geometric if undetected else one.geometric_cycles
                assert samples[number] == pytest.approx(alone, rel=1e-9)


def shown(model: HybridModel) -> bool:
    return any(f.shows_in for s in model.states for fs in s.fates.values() for f in fs)


def test_a_function_that_only_a_way_back_reaches_is_solved_exactly() -> None:
    model = built(
        ["mend", "pick", "place"],
        {
            "mend": ("mend fails", ["c"], {}),
            "pick": ("pick fails", ["a"], {}),
            "place": ("place fails", ["b"], {}),
        },
        {
            "mend": {"place": Fraction(1)},
            "pick": {"place": Fraction(1)},
            "place": {"pick": Fraction(3, 4), DONE: Fraction(1, 4)},
        },
        {"a": 0.04, "b": 0.02, "c": 0.01},
    )
    fates = {"a": (Fate("back", Fraction(1, 2), target="mend"),)}
    model = replace(with_fates(model, pick=fates), entry="pick")
    mission = solve_figures(model).mission
    failure, undetected = Exact(model).figures()
    assert mission.geometric_cycles == pytest.approx(float(failure), rel=1e-12)
    assert mission.undetected_geometric == pytest.approx(float(undetected), rel=1e-12)
    # Without a failure nobody comes to `mend`.
    assert mission.expected_cycles == pytest.approx(4.0)
