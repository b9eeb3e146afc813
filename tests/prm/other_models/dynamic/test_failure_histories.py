"""Every gate, spare, dependency and restriction of a Galileo file, by what they mean alone.

A history is the order in which events fail. What a gate makes of it is written here once more,
from the definitions in docs/theory.md, and histories are neither merged nor forgotten: each is a
state of its own.
"""

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from tracerisk.prm.other_models.dynamic import DynamicKind, DynamicTree, RestrictionKind
from tracerisk.prm.other_models.formats import galileo
from tracerisk.prm.trees.gates import GateKind

EVENTS = """
"K" lambda=2 dorm=1; "L" lambda=1.5; "M" lambda=0.7; "K2" lambda=0.9; "K3" lambda=0.5;
"N" lambda=3 dorm=0; "O" lambda=2 dorm=0; "P" lambda=1 dorm=0;
"Q1" lambda=4 dorm=0.4; "Q2" lambda=1 dorm=0.1; "Q3" lambda=2; "Q4" lambda=3 dorm=0.9;
"R" lambda=2.5 dorm=0.4; "S" lambda=1.1 dorm=0.7;
"D1" lambda=1; "D2" lambda=2; "D3" lambda=1.3; "D4" lambda=0.6; "D5" lambda=0.8; D6 lambda=0.3;
"D7" lambda=0.2;
"""

PARTS = {
    "in order": """
"in order" and "A" "B"; "A" or "A1" "A2" "A3"; "B" 1of2 "A4" "A5";
"A1" pand "K" "L" "M"; "A2" pand-incl "L" "M"; "A3" pand<= "M" "K3" "K2";
"A4" pand-excl "K" "K2" "M"; "A5" pand< "L" "K3" "K2";
"both" fdep "K" "K2" "K3";
""",
    "first": """
"first" vot3 "B1" "B2" "B3" "B4" "B5";
"B1" por "N" "O" "P"; "B2" por-incl "O" "P" "N"; "B3" por<= "N" "P";
"B4" por-excl "N" "O" "P"; "B5" por< "P" "N";
"both" fdep "O" "P";
""",
    "spares": """
"spares" 2of4 "C1" "C2" "C3" "C4";
"C1" wsp "Q1" "R" "S"; "C2" csp "Q2" "S" "R"; "C3" hsp "Q3" "R" "S"; "C4" spare "Q4" "S" "R";
""",
    "ruled out": """
"ruled out" vot3 D1 "D2" D3 "D4" "D5" "D6" "D7";
"order" seq "D1" "D2" "D3"; "one of" mutex "D3" "D4" "D5";
"F" fdep "D2" "D6"; "F'" pdep=0.4 "D6" D7;
""",
}

History = tuple[tuple[str, ...], ...]
"""What failed, one after the other; what a dependency brings about is together, after it."""


class Histories:
    """All that can fail below a tree's top, in every order."""

    def __init__(self, tree: DynamicTree) -> None:
        self.tree = tree
        self.gates = {gate.name: gate for gate in tree.gates}
        below = [tree.top, *(d for each in tree.dependencies for d in (each.trigger,))]
        names = set()
        while below:
            name = below.pop()
            if name not in names:
                names.add(name)
                below += self.gates[name].inputs if name in self.gates else ()
        self.events = [event for event in tree.events if event.name in names]
        self.spares = [gate for gate in tree.gates if gate.kind == DynamicKind.SPARE]

    def probability(self, time: float) -> float:
        """Return the probability that the top has failed by then."""
        histories: list[History] = [()]
        parents, rates, leaving = [0], [0.0], []
        for number, history in enumerate(histories):  # grows meanwhile
            ways = list(self.onward(history))
            leaving.append(math.fsum(rate for rate, _ in ways))
            for rate, following in ways:
                histories.append(following)
                parents.append(number)
                rates.append(rate)
        # Uniformisation: each history has one before it.
        fastest = max(leaving)
        stay = 1.0 - np.array(leaving) / fastest
        enter = np.array(rates) / fastest
        share = np.zeros(len(histories))
        share[0] = 1.0
        weight, found, step = math.exp(-fastest * time), np.zeros(len(histories)), 0
        while step < fastest * time or weight > 1e-18:
            found += weight * share
            share = share * stay + share[parents] * enter
            step += 1
            weight *= fastest * time / step
        failed = [math.isfinite(self.instant(self.tree.top, each)) for each in histories]
        return float(found[failed].sum())

    def onward(self, history: History) -> Iterator[tuple[float, History]]:
        """Yield what fails next, and how fast."""
        for event in self.events:
            rate = event.model.rate * (1.0 if self.works(event.name, history) else event.dormancy)
            if rate > 0.0:
                for share, together in self.brought_about(event.name, history):
                    yield rate * share, (*history, *together)

    def brought_about(self, name: str, history: History) -> Iterator[tuple[float, History]]:
        """Yield what fails with an event, and how probable that is; nothing if it is ruled out."""
        gone = {each for instant in history for each in instant}
        if name in gone or self.is_ruled_out((*history, (name,))):
            return
        outcomes: list[tuple[float, History]] = [(1.0, ((name,),))]
        for dependency in self.tree.dependencies:
            grown = []
            for share, instants in outcomes:
                now = gone.union(*instants)
                more = tuple(each for each in dependency.dependents if each not in now)
                if dependency.trigger not in now - gone or not more:
                    grown.append((share, instants))
                    continue
                grown.append((share * dependency.probability, (*instants, more)))
                if dependency.probability < 1.0:
                    grown.append((share * (1.0 - dependency.probability), instants))
            outcomes = grown
        yield from outcomes

    def is_ruled_out(self, history: History) -> bool:
        when = {name: at for at, instant in enumerate(history) for name in instant}
        for restriction in self.tree.restrictions:
            times = [when.get(name, math.inf) for name in restriction.inputs]
            if restriction.kind == RestrictionKind.SEQUENCE:
                if any(later < before for before, later in pairwise(times)):
                    return True
            elif sum(map(math.isfinite, times)) > 1:
                return True
        return False

    def works(self, name: str, history: History) -> bool:
        """Whether a unit is in use, and not a spare that waits."""
        waiting = {unit for gate in self.spares for unit in gate.inputs[1:]}
        return name not in waiting or name in self.taken(history)[0]

    def taken(self, history: History) -> tuple[set[str], dict[str, float]]:
        """Return the spares that were taken, and when spare gates had none left to take."""
        uses = {gate.name: gate.inputs[0] for gate in self.spares}
        taken, ended = set(uses.values()), {}
        gone: set[str] = set()
        for at, instant in enumerate(history):
            for name in instant:
                gone.add(name)
                for gate in self.spares:
                    if gate.name in ended or uses[gate.name] != name:
                        continue
                    free = [u for u in gate.inputs if u not in gone and u not in taken]
                    if free:
                        uses[gate.name] = free[0]
                        taken.add(free[0])
                    else:
                        ended[gate.name] = float(at)
        return taken, ended

    def instant(self, name: str, history: History) -> float:
        """Return the number of the instant at which an element fails."""
        if name not in self.gates:
            return next((float(at) for at, now in enumerate(history) if name in now), math.inf)
        gate = self.gates[name]
        if gate.kind == DynamicKind.SPARE:
            return self.taken(history)[1].get(name, math.inf)
        times = [self.instant(each, history) for each in gate.inputs]
        if gate.kind == GateKind.OR:
            return min(times)
        if gate.kind == GateKind.AND:
            return max(times)
        if gate.kind == GateKind.ATLEAST:
            return sorted(times)[gate.k - 1]
        first, *others = times
        if gate.kind == DynamicKind.PAND:
            in_order = all(a < b or (gate.inclusive and a == b) for a, b in pairwise(times))
            return times[-1] if in_order else math.inf
        assert gate.kind == DynamicKind.POR
        is_first = all(first < other or (gate.inclusive and first == other) for other in others)
        return first if is_first else math.inf


def part(name: str) -> DynamicTree:
    return galileo.loads(f'toplevel "{name}";{PARTS[name]}{EVENTS}', f"{name}.dft")


@pytest.mark.parametrize("time", [0.01, 0.3, 2.0])
@pytest.mark.parametrize("name", PARTS)
def test_each_kind_of_gate_is_what_its_histories_make_it(name, time):
    tree = part(name)
    assert tree.probability(time).p == pytest.approx(Histories(tree).probability(time), rel=1e-9)


def test_all_gates_together_are_independent_parts():
    names = " ".join(f'"{name}"' for name in PARTS)
    parts = "".join(PARTS.values()).replace('"both" fdep "O"', '"both too" fdep "O"')
    whole = galileo.loads(f'toplevel "T"; "T" and {names};{parts}{EVENTS}', "all.dft")
    expected = math.prod(Histories(part(name)).probability(1.0) for name in PARTS)
    assert whole.probability(1.0).p == pytest.approx(expected, rel=1e-9)
