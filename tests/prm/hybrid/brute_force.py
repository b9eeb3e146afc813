"""Random missions of functions, and an independent solver of them: every set of failed units.

Numbers have 150 digits. A group with spares is a chain over the sets of its failed units, whose
exponential is summed as a power series; a mission is solved from the last sets to the first.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from functools import lru_cache
from itertools import combinations
from random import Random

from tracerisk.adder.blocks.values import read_redundancy
from tracerisk.common.hardware.redundancy import Redundancy

DIGITS = 150
Units = frozenset[tuple[str, int]]


@dataclass(frozen=True)
class Use:
    """How a function uses a component."""

    p: float
    redundancy: Redundancy
    text: str


@dataclass(frozen=True)
class Mission:
    """Functions in their order: by each the components it uses, and what follows it."""

    quantities: Mapping[str, int]
    uses: Mapping[str, Mapping[str, Use]]
    following: Mapping[str, Mapping[str, Fraction]]

    @property
    def hidden(self) -> set[str]:
        """The components of which failed units stay failed until the mission ends."""
        return {
            name
            for uses in self.uses.values()
            for name, use in uses.items()
            if use.redundancy.is_redundant
            and use.redundancy.detected == "mission_start"
            and use.redundancy.required < self.quantities[name]
        }

    def own(self, name: str, use: Use) -> str:
        """Return the parameter of a unit's own failures, or of its group where that has one."""
        is_group = use.redundancy.has_spares and use.redundancy.required < self.quantities[name]
        if is_group and name not in self.hidden:
            return f"{name} {{spares}}"
        return f"{name} {{own}}" if self._is_shared(name, use) else name

    def _is_shared(self, name: str, use: Use) -> bool:
        return (
            use.redundancy.is_redundant
            and self.quantities[name] > 1
            and use.redundancy.common_cause > 0.0
        )

    def failure(self, scale: Mapping[str, Decimal] | None = None) -> Decimal:
        """Return the mission's failure probability, parameters multiplied by `scale`."""
        with localcontext() as context:
            context.prec = DIGITS
            return 1 - self.successes(scale or {})[next(iter(self.uses)), frozenset()]

    def successes(self, scale: Mapping[str, Decimal]) -> dict[tuple[str, Units], Decimal]:
        """Return the success of missions from each function and set of failed units."""
        units = [(name, i) for name in sorted(self.hidden) for i in range(self.quantities[name])]
        found: dict[tuple[str, Units], Decimal] = {}
        functions = list(self.uses)
        for size in range(len(units), -1, -1):
            for chosen in combinations(units, size):
                failed = frozenset(chosen)
                rows, right = [], []
                for function in functions:
                    row = [Decimal(int(other == function)) for other in functions]
                    known = Decimal(0)
                    for after, weight in self.visit(function, failed, scale).items():
                        for target, share in self.following[function].items():
                            way = weight * share.numerator / share.denominator
                            if target == "done":
                                known += way
                            elif after == failed:
                                row[functions.index(target)] -= way
                            else:
                                known += way * found[target, after]
                    rows.append(row)
                    right.append(known)
                solved = _solve(rows, right)
                found |= {
                    (function, failed): success
                    for function, success in zip(functions, solved, strict=True)
                }
        return found

    def visit(
        self, function: str, failed: Units, scale: Mapping[str, Decimal]
    ) -> dict[Units, Decimal]:
        """Return the sets of failed units that a visit leaves, and how often it does."""
        left: dict[Units, Decimal] = {failed: Decimal(1)}
        for name, use in self.uses[function].items():
            is_hidden = name in self.hidden
            before = frozenset(i for other, i in failed if other == name and is_hidden)
            grown: dict[Units, Decimal] = {}
            for state, share in left.items():
                for after, weight in self._component(name, use, before, scale):
                    kept = {(name, i) for i in after} if is_hidden else set()
                    key = state | kept
                    grown[key] = grown.get(key, 0) + share * weight
            left = grown
        return left

    def _component(
        self, name: str, use: Use, before: frozenset[int], scale: Mapping[str, Decimal]
    ) -> Iterator[tuple[frozenset[int], Decimal]]:
        units, redundancy = self.quantities[name], use.redundancy
        required = redundancy.required if redundancy.is_redundant else units
        beta = Decimal(redundancy.common_cause) if self._is_shared(name, use) else Decimal(0)
        p = (1 - beta) * Decimal(use.p) * scale.get(self.own(name, use), Decimal(1))
        common = beta * Decimal(use.p) * scale.get(f"{name} {{common cause}}", Decimal(1))
        if units - len(before) < required:
            return
        if redundancy.has_spares and required < units:
            outcomes = _spares(units, redundancy, before, p)
        else:
            outcomes = _active(units, required, before, p)
        for after, weight in outcomes.items():
            yield after, weight * (1 - common)


def _active(
    units: int, required: int, before: frozenset[int], p: Decimal
) -> dict[frozenset[int], Decimal]:
    working = [i for i in range(units) if i not in before]
    found = {}
    for count in range(len(working) - required + 1):
        for more in combinations(working, count):
            found[before | set(more)] = math.prod([p] * count + [1 - p] * (len(working) - count))
    return found


@lru_cache(maxsize=10_000)
def _spares(
    units: int, redundancy: Redundancy, before: frozenset[int], p: Decimal
) -> dict[frozenset[int], Decimal]:
    if p == 1:
        return {}
    hazard = -(1 - p).ln()
    dormancy, switch = Decimal(redundancy.dormancy), Decimal(redundancy.switch)
    ways: dict[frozenset[int], list[tuple[frozenset[int], Decimal]]] = {}
    leaving: dict[frozenset[int], Decimal] = {}
    waiting = [before]
    while waiting:
        state = waiting.pop()
        if state in ways:
            continue
        sound = [i for i in range(units) if i not in state]
        ways[state], leaving[state] = [], Decimal(0)
        for place, unit in enumerate(sound):
            works = place < redundancy.required
            rate = Decimal(1) if works else dormancy
            leaving[state] += rate
            survives = (1 - switch) if works else Decimal(1)
            if len(sound) > redundancy.required:
                ways[state].append((state | {unit}, rate * survives))
                waiting.append(state | {unit})
    # exp(G h), its row of the set that the visit begins with, as a power series.
    term = dict.fromkeys(ways, Decimal(0))
    term[before] = Decimal(1)
    found = dict(term)
    number = 0
    while True:
        number += 1
        following = {state: -share * leaving[state] for state, share in term.items()}
        for state, share in term.items():
            for target, rate in ways[state]:
                following[target] += share * rate
        term = {state: share * hazard / number for state, share in following.items()}
        for state, share in term.items():
            found[state] += share
        if number > 5 and max(map(abs, term.values())) < Decimal(10) ** -(DIGITS - 5):
            return found


def _solve(rows: list[list[Decimal]], right: list[Decimal]) -> list[Decimal]:
    size = len(rows)
    for column in range(size):
        pivot = max(range(column, size), key=lambda row: abs(rows[row][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        right[column], right[pivot] = right[pivot], right[column]
        for row in range(size):
            if row != column and rows[row][column] != 0:
                factor = rows[row][column] / rows[column][column]
                rows[row] = [a - factor * b for a, b in zip(rows[row], rows[column], strict=True)]
                right[row] -= factor * right[column]
    return [right[i] / rows[i][i] for i in range(size)]


def random_mission(random: Random) -> Mission:
    """Draw a mission: one to three functions, up to two groups of any redundancy, loops."""
    functions = [f"f{i}" for i in range(random.randint(1, 3))]
    quantities = {f"c{i}": random.randint(1, 3 if i else 4) for i in range(random.randint(1, 2))}
    uses: dict[str, dict[str, Use]] = {}
    following = {}
    for function in functions:
        uses[function] = {}
        for name, quantity in quantities.items():
            if len(functions) == 1 or random.random() < 0.8:
                text = _redundancy(random, quantity)
                uses[function][name] = Use(_chance(random), read_redundancy(text), text)
        weights = {target: random.randint(0, 4) for target in (*functions, "done")}
        weights["done"] += 1
        total = sum(weights.values())
        following[function] = {
            target: Fraction(weight, total) for target, weight in weights.items() if weight
        }
    return Mission(quantities, uses, following)


def _chance(random: Random) -> float:
    return random.choice(
        (
            10 ** random.uniform(-12, -1),
            10 ** random.uniform(-12, -1),
            random.uniform(0.05, 0.95),
            1.0 - 10 ** random.uniform(-9, -1),
        )
    )


def _redundancy(random: Random, quantity: int) -> str:
    if quantity == 1 or random.random() < 0.15:
        return "false"
    text = random.choice(("true", f"required {random.randint(1, quantity)}"))
    kind = random.randrange(6)
    if kind == 1:
        text += ", spare cold"
    elif kind == 2:
        text += f", spare warm {random.choice((0.25, 0.999, random.uniform(0.01, 0.99)))!r}"
    elif kind == 3:
        text += ", spare hot"
    elif kind == 4:
        text += f", spare warm {random.choice((0.0, 1.0, 1e-9))!r}"
    if kind and random.random() < 0.4:
        text += f", switch {random.choice((0.01, 1.0, random.random()))!r}"
    if random.random() < 0.25:
        text += f", common_cause {random.choice((0.1, 1e-9, random.random()))!r}"
    detected = random.random()
    if detected < 0.3:
        text += f", detected {'each_visit' if detected < 0.2 else 'mission_start'}"
    return text
