"""What docs/safety.md computes, computed again."""

import math
import re
from pathlib import Path

import pytest

from tracerisk.pipeline.dossier.anomalies import ANOMALIES
from tracerisk.pipeline.dossier.assumptions import GENERAL
from tracerisk.pipeline.dossier.sheet import STEPS

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "docs" / "safety.md").read_text(encoding="utf-8")


def test_the_rate_per_hour_follows_from_the_mission():
    failure, seconds = map(
        float, re.findall(r"sample controller has F = (\S+) and T = (\S+) s", TEXT)[0]
    )
    (shown, first, hours, rate) = re.findall(
        r"-ln\(1 - (\S+)\) / \(\S+ / 3600\) = (\S+) / (\S+) h = (\S+) per hour", TEXT
    )[0]
    assert float(shown) == failure
    assert float(first) == pytest.approx(-math.log1p(-failure), rel=1e-3)
    assert float(hours) == pytest.approx(seconds / 3600, rel=1e-3)
    assert float(rate) == pytest.approx(-math.log1p(-failure) / (seconds / 3600), rel=1e-3)


@pytest.mark.slow
def test_the_sample_has_the_figure_and_the_time_of_the_example(sample_of_docs):
    figure, seconds = sample_of_docs
    assert f"F = {figure:.3e} and T = {seconds:.1f} s" in TEXT


@pytest.fixture
def sample_of_docs(example, pick_and_place):
    example.write("pick_and_place.py", pick_and_place)
    data = example.run("run", "pick_and_place.py", "--json").json
    mission = data["assessment"]["mission"]
    return mission["failure_probability"], data["trace"]["end"]["simulated_s"]


def test_the_sheet_of_a_dossier_has_the_steps_of_this_page():
    rows = re.findall(
        r"^\| (\d+) \| ([^|]*) \|", TEXT.partition("## Before you rely")[2], re.MULTILINE
    )
    steps = [
        re.sub(r" \(\[how\]\([^)]*\)\)|\[([^\]]*)\]\([^)]*\)", r"\1", step) for _, step in rows
    ]
    assert [int(number) for number, _ in rows] == list(range(1, len(STEPS) + 1))
    assert steps == list(STEPS)


def test_a_dossier_has_the_assumptions_of_this_page():
    section = TEXT.partition("## Assumptions and limits")[2].partition("Not modelled")[0]
    rows = re.findall(r"^\| ([^|]+) \| ([^|]+) \| [^|]+ \|$", section, re.MULTILINE)[1:]
    plain = [tuple(re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", cell) for cell in row) for row in rows]
    assert plain == list(GENERAL)


def test_a_dossier_has_the_known_anomalies_of_this_page():
    rows = re.findall(r"^\| (K\d+) \| ([^|]+) \|", TEXT, re.MULTILINE)
    assert rows == [(anomaly.number, anomaly.concerns) for anomaly in ANOMALIES]


def test_every_test_that_it_names_exists():
    named = re.findall(r"tests/[\w/]+(?:\.py)?", TEXT)
    assert len(named) > 10
    assert [name for name in named if not (ROOT / name).exists()] == []
