"""Fault trees beside SCRAM, an independent solver, and beside the published Aralia models."""

import csv
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.slow import slow_but
from tracerisk.prm.numbers.probability import Probability
from tracerisk.prm.other_models.formats.open_psa import read_open_psa
from tracerisk.prm.trees.bdd import SharedTree
from tracerisk.prm.trees.bdd.diagram import Limits

ROOT = Path(__file__).parents[3]
ARALIA = ROOT.parent / "shared" / "data" / "aralia"
SHIPPED = Path("/usr/share/scram/input")
needs_scram = pytest.mark.skipif(
    shutil.which("scram") is None or not SHIPPED.exists(), reason="SCRAM is not installed"
)
needs_aralia = pytest.mark.skipif(not ARALIA.exists(), reason="the Aralia models are not beside")

SHARED_MODELS = [
    ("Chinese/chinese.xml", "Chinese/chinese-basic-events.xml"),
    ("Baobab/baobab1.xml", "Baobab/baobab1-basic-events.xml"),
    ("CEA9601/CEA9601.xml", "CEA9601/CEA9601-basic-events.xml"),
]


def by_scram(*files: Path) -> float:
    """Return what SCRAM's diagram gives, six digits, with products of one event only."""
    command = ["scram", "--bdd", "--probability", "1", "--limit-order", "1", *map(str, files)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=100, check=True)
    found = re.search(r'<sum-of-products[^>]* probability="([^"]*)"', done.stdout)
    assert found, done.stdout[:1000]
    return float(found[1])


@needs_scram
@pytest.mark.parametrize("names", SHARED_MODELS[:2], ids=lambda names: names[0])
def test_a_shared_tree_has_the_probability_that_scram_finds(names):
    files = [SHIPPED / name for name in names]
    model = read_open_psa(*files)
    (top,) = model.tops
    tree = model.fault_tree(top)
    assert tree.shared
    assert tree.probability(tree.values_at(0.0)).p == pytest.approx(by_scram(*files), rel=1e-5)


@needs_scram
@pytest.mark.slow
def test_a_large_shared_tree_has_the_probability_that_scram_finds():
    files = [SHIPPED / name for name in SHARED_MODELS[2]]
    model = read_open_psa(*files)
    tree = model.fault_tree(model.tops[0])
    assert tree.probability(tree.values_at(0.0)).p == pytest.approx(by_scram(*files), rel=1e-5)


@needs_aralia
@pytest.mark.parametrize(
    "name",
    slow_but(
        ["chinese", "isp9605", "das9209", "edf9206"],
        ["chinese", "isp9605", "das9209", "edf9206", "baobab3"],
    ),
)
def test_an_aralia_model_has_its_known_probability_by_two_orders(name):
    with (ARALIA / "expected.csv").open(encoding="utf-8", newline="") as file:
        known = {row["model"]: float(row["p_top"] or "nan") for row in csv.DictReader(file)}
    model = read_open_psa(ARALIA / f"{name}.xml")
    tree = model.fault_tree(model.tops[0])
    values = tree.values_at(0.0)
    found = tree.probability(values)
    assert found.p == pytest.approx(known[name], rel=1e-13)
    pairs = {event.name: Probability.of(values[event.parameter]) for event in tree.events}
    other = SharedTree(tree, Limits(swapped=True)).probability(pairs)
    assert other == pytest.approx(found, rel=1e-14)


@needs_aralia
@pytest.mark.parametrize("name", ["chinese", "isp9605", "elf9601"])
def test_the_sensitivities_of_an_aralia_model_are_its_slopes(name):
    model = read_open_psa(ARALIA / f"{name}.xml")
    tree = model.fault_tree(model.tops[0])
    values = tree.values_at(0.0)
    slopes = tree.sensitivities(values)
    for event in tree.events[::7]:
        # The top is linear in each event, and its whole rise is the slope.
        rise = tree.difference({**values, event.parameter: 1.0}, {**values, event.parameter: 0.0})
        assert slopes[event.name] == pytest.approx(rise, rel=1e-13)


@pytest.mark.slow
@needs_aralia
def test_the_benchmark_says_seconds_memory_and_errors():
    run = [sys.executable, "benchmarks/fault_trees.py", "--models", str(ARALIA)]
    if shutil.which("scram"):
        run += ["--peer", "scram"]
    done = subprocess.run(
        [*run, "--models-only", "chinese"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=100,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "0.0011705818107586692" in done.stdout
    assert "solved 1 of 1" in done.stdout
    if shutil.which("scram"):
        for kind in ("cold", "warm"):
            assert f"{kind}: the peer takes " in done.stdout
