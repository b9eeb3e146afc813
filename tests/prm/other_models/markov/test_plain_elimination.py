"""Which chains are solved with no array library, and no compilation."""

import subprocess
import sys

import pytest

from tracerisk.prm import MarkovChain
from tracerisk.prm.other_models.markov import solver

LADDER = """
import sys
from tracerisk.prm import MarkovChain
n = 5_000
rows = {str(i): {str(i + 1): 0.9, str(max(i - 1, 0)): 0.09, "down": 0.01} for i in range(n)}
rows["0"] = {"1": 0.99, "down": 0.01}
print(MarkovChain.of(rows).solve("0").absorption()["down"])
print(sorted({"numpy", "scipy"} & set(sys.modules)))
"""


def test_a_long_sparse_chain_compiles_nothing():
    done = subprocess.run(
        [sys.executable, "-c", LADDER], capture_output=True, text=True, check=True
    )
    down, loaded = done.stdout.splitlines()
    assert float(down) == pytest.approx(1.0, rel=1e-13)
    assert loaded == "[]"


def test_a_chain_that_fills_in_goes_on_to_compiled_code_with_the_same_figures(monkeypatch):
    rows = {
        f"s{i}": {f"s{(i * 7 + step) % 60}": 0.19 for step in (1, 5, 14, 23, 46)}
        | {"down": 0.02, "done": 0.03}
        for i in range(60)
    }
    plain = MarkovChain.of(rows).solve("s0").absorption()
    monkeypatch.setattr(solver, "_SMALL_PRODUCTS", 100)
    compiled = MarkovChain.of(rows).solve("s0").absorption()
    assert compiled == pytest.approx(plain, rel=1e-14)
