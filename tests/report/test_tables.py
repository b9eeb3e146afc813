"""Tables that are written without the library are those that it would write."""

import random

import pytest

from tracerisk.common.text.paper import Paper
from tracerisk.report import tables
from tracerisk.report.tables import Column, render_table

HEADINGS = ["top", "probability", "a longer heading", "x"]
CELLS = ["", "a", "1.0e-3", " lead", "trail ", "a b  c", "[b]x[/b]", "\u00e9t\u00e9", "q" * 30]


@pytest.mark.parametrize("seed", range(5))
def test_a_plain_table_is_as_that_of_the_library(seed, monkeypatch):
    chance = random.Random(seed)
    given, found = [], []
    for _ in range(40):
        columns = [
            Column(chance.choice(HEADINGS), chance.random() < 0.5)
            for _ in range(chance.randint(1, 4))
        ]
        rows = [[chance.choice(CELLS) for _ in columns] for _ in range(chance.randint(0, 4))]
        title = chance.choice(["m.xml", "a title", "x" * 70, " t "])
        given.append((title, columns, rows, chance.choice([40, 60, 80])))
    plain = tables._plain_table
    assert any(plain(*each) is not None for each in given)
    found = [render_table(*each[:3], paper=Paper(each[3])) for each in given]
    monkeypatch.setattr(tables, "_plain_table", lambda *_: None)
    assert found == [render_table(*each[:3], paper=Paper(each[3])) for each in given]
