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

UNAWARE, LATE, SAFE = "unaware", "stopped_late", "stopped_safely"
LEVELS = {UNAWARE: 0, LATE: 1, SAFE: 2, "back": 3}


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


Known = tuple[str, str, str]
"""What follows a failure: its kind, the function it leads back to, and where it shows."""
UNNOTICED: Known = (UNAWARE, "", "")


class Exact:
    """The chain of a model by its definition: functions, failed units, what is remembered."""

    def __init__(self, model: HybridModel) -> None:
        self.model = model
        self.states = {state.name: state for state in model.states}
        self.rank = {state.name: number for number, state in enumerate(model.states)}
        gates = [gate for state in model.states for gate in state.tree.gates if gate.name == "pair"]
        self.size = len(gates[0].inputs) if gates else 2
        self.fails_at = gates[0].threshold if gates else 2

    def units(self, state: FunctionState) -> list[tuple[str, Fraction]]:
        return [
            (event.parameter, Fraction(state.probabilities[event.parameter]))
            for event in state.tree.events
            if event.parameter != "pair"
        ]

    def pair(self, state: FunctionState, lost: int) -> dict[int, Fraction]:
        """Return how many units of the group have failed after a visit."""
        if "pair" not in state.probabilities:
            return {lost: Fraction(1)}
        p = Fraction(state.probabilities["pair"])
        left = self.size - lost
        return {
            lost + more: math.comb(left, more) * p**more * (1 - p) ** (left - more)
            for more in range(left + 1)
        }

    def badness(self, known: Known) -> tuple[int, bool, int, int]:
        """Return how bad what follows is, the worst least."""
        kind, target, shows_in = known
        later = bool(shows_in) if kind != "back" else not shows_in
        return (LEVELS[kind], later, self.rank.get(target, -1), self.rank.get(shows_in, -1))

    def fates(self, state: FunctionState, name: str) -> list[tuple[Known, Fraction]]:
        """Return what follows the failure of one unit, each with its share."""
        found = []
        rest = Fraction(1)
        for fate in state.fates.get(name, ()):
            rest -= fate.share
            known = (fate.kind, fate.target, fate.shows_in)
            found.append((UNNOTICED if fate.kind == UNAWARE else known, fate.share))
        return [*found, (UNNOTICED, rest)]

    def visit(self, state: FunctionState) -> dict[Known | None, Fraction]:
        """Return the worst of what follows the failures in a visit; `None` for none."""
        outcomes: dict[Known | None, Fraction] = {None: Fraction(1)}
        for name, p in self.units(state):
            ways: list[tuple[Known | None, Fraction]] = [(None, 1 - p)]
            ways += [(known, p * share) for known, share in self.fates(state, name)]
            grown: dict[Known | None, Fraction] = {}
            for (one, weight), (other, share) in product(outcomes.items(), ways):
                failed = [known for known in (one, other) if known is not None]
                worst = min(failed, key=self.badness, default=None)
                grown[worst] = grown.get(worst, Fraction(0)) + weight * share
            outcomes = grown
        return outcomes

    def onward(self, state: FunctionState, memory: Known | None) -> Iterator[tuple[object, ...]]:
        """Yield where a visit leads that goes on, what is remembered then, and how likely."""
        for step in state.next:
            if step.target == DONE:
                yield (DONE if memory is None else UNAWARE), None, step.weight
            elif memory is not None and memory[2] == step.target:
                yield (memory[1] or memory[0]), None, step.weight
            else:
                yield step.target, memory, step.weight

    def row(self, name: str, lost: int, memory: Known | None) -> dict[object, Fraction]:
        state = self.states[name]
        row: dict[object, Fraction] = {}
        for after, chance in self.pair(state, lost).items():
            for known, weight in self.visit(state).items():
                gone = after >= self.fails_at and "pair" in state.probabilities
                if gone or known == UNNOTICED or (memory is not None and known is not None):
                    ways = [(UNAWARE, None, Fraction(1))]
                elif known is not None and not known[2]:
                    ways = [(known[1] or known[0], None, Fraction(1))]
                else:
                    ways = list(self.onward(state, memory or known))
                for target, kept, share in ways:
                    key = (target, after, kept) if target in self.states else target
                    row[key] = row.get(key, Fraction(0)) + chance * weight * share
        return row

    def ends(self) -> dict[str, Fraction]:
        """Return how likely each end of a mission is."""
        start = (self.model.entry, 0, None)
        rows: dict[object, dict[object, Fraction]] = {}
        waiting = [start]
        while waiting:
            now = waiting.pop()
            if now not in rows:
                rows[now] = self.row(*now)
                waiting += [key for key in rows[now] if isinstance(key, tuple)]
        ends = solved_exactly(rows, start)
        return {end: ends.get(end, Fraction(0)) for end in (UNAWARE, LATE, SAFE)}


def random_fates(draw: random.Random, names: list[str]) -> tuple[Fate, ...]:
    count = draw.randint(1, 4)
    weights = [draw.randint(1, 5) for _ in range(count + draw.randint(0, 1))]
    fates = []
    for weight in weights[:count]:
        kind = draw.choice([SAFE, LATE, UNAWARE, "back", SAFE])
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
    has_pair = draw.random() < 0.4
    units = draw.choice([2, 2, 3])
    fails_at = draw.randint(2, units)
    trees, values = {}, {}
    for name in ("a", "b"):
        values[name] = 2.0 ** -draw.choice([1, 2, 7, 17, 30]) * draw.randint(2, 8) / 8
    for name in names:
        parts: dict[str, tuple[str, ...]] = {}
        used: list[str] = [part for part in "ab" if draw.random() < 0.8] or ["a"]
        top = f"{name} fails"
        inputs = list(used)
        if "a" in used and draw.random() < 0.4:
            parts["a"] = ("or", "a[1]", "a[2]")
        if has_pair and draw.random() < 0.7:
            inputs.append("pair")
            parts["pair"] = group(units, fails_at)
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
    model = built(names, trees, following, {**values, "pair": draw.randint(1, 10) / 32})
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


def group(units: int, fails_at: int) -> tuple[str, ...]:
    """Return a group of units that fails where so many of them have."""
    names = tuple(f"pair[{number}]" for number in range(1, units + 1))
    return ("and" if fails_at == units else f"atleast {fails_at}", *names)


def built(
    names: list[str],
    trees: Mapping[str, tuple[str, list[str], Mapping[str, tuple[str, ...]]]],
    following: Mapping[str, Mapping[str, Fraction]],
    values: Mapping[str, float],
) -> HybridModel:
    from tracerisk.prm.hybrid.elements import Parameter
    from tracerisk.prm.trees.events import BasicEvent
    from tracerisk.prm.trees.gates import Gate, GateKind

    states: list[FunctionState] = []
    latent: tuple[str, ...] = ()
    for rank, name in enumerate(names, 1):
        top, inputs, parts = trees[name]
        gates = [Gate(top, GateKind.OR, tuple(inputs))]
        events = []
        for part in inputs:
            if part in parts:
                kind, *units = parts[part]
                kind, _, least = kind.partition(" ")
                gates.append(
                    Gate(part, GateKind(kind), tuple(units), int(least) if least else None)
                )
                events += [BasicEvent(unit, part, component=part) for unit in units]
                latent = tuple(units) if part == "pair" else latent
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
        latent,
    )


@pytest.mark.slow(but=2)
@pytest.mark.parametrize("block", range(6))
def test_random_models_agree_with_rationals(block: int) -> None:
    draw = random.Random(block)
    for _ in range(500):
        model = random_model(draw)
        mission = solve_figures(model).mission
        ends = Exact(model).ends()
        assert mission.geometric_cycles == pytest.approx(float(sum(ends.values())), rel=1e-10)
        if mission.undetected_geometric is None:
            continue
        undetected = float(ends[UNAWARE] + ends[LATE])
        assert mission.undetected_geometric == pytest.approx(undetected, rel=1e-10)
        assert mission.stopped_late_geometric == pytest.approx(float(ends[LATE]), rel=1e-10)
        assert mission.stopped_safely_geometric == pytest.approx(float(ends[SAFE]), rel=1e-10)


def test_without_ways_back_the_failure_of_the_mission_is_as_without_fates() -> None:
    draw = random.Random(5)
    for _ in range(100):
        model = random_model(draw, may_lead_back=False)
        plain = replace(model, states=tuple(replace(s, fates={}) for s in model.states))
        with_fates, without = solve(model).mission, solve(plain).mission
        assert with_fates.failure_probability == without.failure_probability
        assert with_fates.visits_as_run == without.visits_as_run
        assert without.undetected_probability is None


def drawn(model: HybridModel, missions: int, seed: int) -> dict[str, int]:
    """Return how many of so many drawn missions end in each way."""
    draw = random.Random(seed)
    exact = Exact(model)
    ends: dict[str, int] = {}
    for _ in range(missions):
        end = drawn_end(draw, model, exact)
        ends[end] = ends.get(end, 0) + 1
    return ends


def drawn_end(draw: random.Random, model: HybridModel, exact: Exact) -> str:
    """Return how one drawn mission ends."""
    now, memory = model.entry, None
    gone: set[str] = set()
    while True:
        state = exact.states[now]
        failed = []
        for event in state.tree.events:
            if event.name in gone or draw.random() >= state.probabilities[event.parameter]:
                continue
            if event.name in model.latent:
                gone.add(event.name)
            else:
                failed.append(drawn_fate(draw, state.fates.get(event.parameter, ())))
        if "pair" in state.probabilities and len(gone) >= exact.fails_at:
            return UNAWARE
        if failed:
            known = min(failed, key=exact.badness)
            if memory is not None or known[0] == UNAWARE:
                return UNAWARE
            if known[2]:
                memory = known
            elif known[0] == "back":
                now = known[1]
                continue
            else:
                return known[0]
        steps = state.next
        now = draw.choices([s.target for s in steps], [float(s.weight) for s in steps])[0]
        if now == DONE:
            return DONE if memory is None else UNAWARE
        if memory is not None and now == memory[2]:
            if memory[0] != "back":
                return memory[0]
            now, memory = memory[1], None


def drawn_fate(draw: random.Random, fates: tuple[Fate, ...]) -> Known:
    at = draw.random()
    for fate in fates:
        at -= float(fate.share)
        if at < 0.0:
            return UNNOTICED if fate.kind == UNAWARE else (fate.kind, fate.target, fate.shows_in)
    return UNNOTICED


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


WORN = built(
    ["pick", "look", "place"],
    {
        "pick": ("pick fails", ["a", "pair"], {"pair": group(3, 2)}),
        "look": ("look fails", ["b"], {}),
        "place": ("place fails", ["b", "pair"], {"pair": group(3, 2)}),
    },
    {
        "pick": {"look": Fraction(1)},
        "look": {"place": Fraction(1)},
        "place": {"pick": Fraction(3, 4), DONE: Fraction(1, 4)},
    },
    {"a": 0.04, "b": 0.02, "pair": 0.02},
)


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("model", [RECOVERING, WORN], ids=["plain", "with a worn group"])
@pytest.mark.parametrize(
    "fates",
    [
        {"a": (Fate("back", Fraction(3, 4), target="pick"),)},
        {
            "a": (
                Fate("back", Fraction(1, 2), target="pick", shows_in="look"),
                Fate("stopped_safely", Fraction(1, 4), shows_in="place"),
                Fate("stopped_late", Fraction(1, 8), shows_in="pick"),
                Fate("stopped_late", Fraction(1, 16)),
            )
        },
    ],
    ids=["retries", "shown later"],
)
def test_drawn_missions_end_as_often_as_is_solved(
    model: HybridModel, fates: Mapping[str, tuple[Fate, ...]]
) -> None:
    missions = 100_000
    noticed = {"b": (Fate("stopped_safely", Fraction(2, 3)), Fate("stopped_late", Fraction(1, 6)))}
    model = with_fates(model, pick=fates, look=noticed)
    mission = solve_figures(model).mission
    ends = drawn(model, missions, 7)
    undetected = ends.get(UNAWARE, 0) + ends.get(LATE, 0)
    for count, p in (
        (missions - ends[DONE], mission.geometric_cycles),
        (undetected, mission.undetected_geometric),
        (ends.get(LATE, 0), mission.stopped_late_geometric),
        (ends.get(SAFE, 0), mission.stopped_safely_geometric),
    ):
        assert p is not None
        assert abs(count / missions - p) < 3.0 * (p * (1.0 - p) / missions) ** 0.5


def test_with_fixed_cycles_each_end_counts_over_all_of_them() -> None:
    fates = (Fate("stopped_safely", Fraction(1, 4)), Fate("stopped_late", Fraction(1, 8)))
    model = replace(with_fates(RECOVERING, pick={"a": fates}), counted=True)
    mission = solve_figures(model).mission
    alive, unseen, late, safely = 1.0, 0.0, 0.0, 0.0
    for p, stops, harm in [(0.04, 0.25, 0.125), (0.02, 0.0, 0.0), (0.02, 0.0, 0.0)] * 4:
        unseen += alive * p * (1.0 - stops)
        late += alive * p * harm
        safely += alive * p * stops
        alive *= 1.0 - p
    assert mission.reading == "fixed cycles"
    assert mission.failure_probability == pytest.approx(1.0 - alive, rel=1e-12)
    assert mission.undetected_probability == pytest.approx(unseen, rel=1e-12)
    assert mission.stopped_late_probability == pytest.approx(late, rel=1e-12)
    assert mission.stopped_safely_probability == pytest.approx(safely, rel=1e-12)


def test_of_too_many_states_the_rest_counts_as_undetected() -> None:
    fates = {"a": (Fate("stopped_safely", Fraction(1, 4)), Fate("stopped_late", Fraction(1, 8)))}
    model = with_fates(WORN, pick=fates)
    exact, bound = solve(model).mission, solve(model, limit=3).mission
    for name in ("undetected", "stopped_late", "stopped_safely"):
        one, other = (getattr(mission, f"{name}_probability") for mission in (exact, bound))
        assert other > one if name == "undetected" else 0.5 * one < other < one


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
def test_the_law_of_refactoring_holds_for_each_figure(rewriting: int) -> None:
    draw = random.Random(rewriting)
    fates = {
        "a": (
            Fate("stopped_safely", Fraction(1, 3)),
            Fate("back", Fraction(1, 5), target="pick", shows_in="place"),
            Fate("stopped_safely", Fraction(1, 7), shows_in="look"),
            Fate("stopped_late", Fraction(1, 11)),
            Fate("stopped_late", Fraction(1, 13), shows_in="place"),
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
    for name in ("failure", "undetected", "stopped_late", "stopped_safely"):
        one, other = (getattr(mission, f"{name}_probability") for mission in (before, after))
        assert other == pytest.approx(one, rel=1e-4), name


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
        if not any(state.fates for state in model.states):
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
    ends = Exact(model).ends()
    undetected = float(ends[UNAWARE] + ends[LATE])
    assert mission.geometric_cycles == pytest.approx(float(sum(ends.values())), rel=1e-12)
    assert mission.undetected_geometric == pytest.approx(undetected, rel=1e-12)
    # Without a failure nobody comes to `mend`.
    assert mission.expected_cycles == pytest.approx(4.0)
