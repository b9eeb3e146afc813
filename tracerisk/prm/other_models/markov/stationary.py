"""The long run of states that all lead to each other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from tracerisk.prm.numbers.elimination import Label
from tracerisk.prm.other_models.markov.solver import solver_of


def stationary(rows: Sequence[Mapping[int, float]], label: Label, kind: str) -> list[float]:
    """Return the long-run share of each state, by elimination of all states but one.

    `rows[i][j]` is the probability or rate of going from i to j; each state leads to each.
    Grassmann, Taksar, Heyman (1985). Raises ModelError as `solver_of` does.
    """
    if len(rows) == 1:
        return [1.0]
    # The first state is what the others are left for.
    ways = [
        {target - 1: p for target, p in row.items() if target not in (0, state)}
        for state, row in enumerate(rows[1:], 1)
    ]
    solver = solver_of(
        ways, [row.get(0, 0.0) for row in rows[1:]], lambda state: label(state + 1), kind
    )
    start = [rows[0].get(state, 0.0) for state in range(1, len(rows))]
    shares = [1.0, *solver.left(start)]
    total = math.fsum(shares)
    return [share / total for share in shares]
