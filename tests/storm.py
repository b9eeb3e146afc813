"""What the model checker Storm makes of a program in the language of PRISM."""

from fractions import Fraction
from pathlib import Path

import pytest


def storm_probability(path: Path, program: str, question: str) -> Fraction:
    """Return Storm's answer about the start of a program, which is written to a path.

    That of a chain in discrete time is exact, in rational numbers; that of one in continuous time
    has about six digits. Skips the test without stormpy.
    """
    stormpy = pytest.importorskip("stormpy", reason="stormpy is not installed")
    path.write_text(program, encoding="utf-8")
    is_exact = program.startswith("dtmc")
    read = stormpy.parse_prism_program(str(path), prism_compatibility=not is_exact)
    (asked,) = stormpy.parse_properties(question)
    if is_exact:
        built = stormpy.build_model[stormpy.Rational](read)
        environment = stormpy.environments.exact()
    else:
        built, environment = stormpy.build_model(read), stormpy.environments.sound()
    answer = stormpy.model_checking(built, asked, environment=environment)
    return Fraction(str(answer.get_value(built.initial_states[0])))


def of_gates(gates, top: str, leaves) -> str:
    """Return the condition under which the top of a tree happens.

    `gates` has (kind, k, inputs) by name, the kinds `and`, `or` and `atleast`; `leaves` has the
    condition of each input that is no gate.
    """

    def condition(name: str) -> str:
        if name not in gates:
            return leaves[name]
        kind, k, inputs = gates[name]
        below = [condition(each) for each in inputs]
        if kind == "atleast":
            return f"(({'+'.join(f'({each}?1:0)' for each in below)})>={k})"
        return f"({(' & ' if kind == 'and' else ' | ').join(below)})"

    return condition(top)
