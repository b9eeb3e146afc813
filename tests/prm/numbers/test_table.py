from dataclasses import dataclass

import pytest

from tracerisk.errors import ModelError
from tracerisk.prm.numbers.table import Table


@dataclass(frozen=True)
class Row:
    name: str
    risk_share: float
    note: str = ""


TABLE = Table((Row("motor", 0.25), Row("<grip>", 1e-20)))


def test_rows_are_found_by_name_and_columns_are_arrays():
    assert TABLE["motor"].risk_share == 0.25
    assert TABLE.names == ("motor", "<grip>")
    assert TABLE.columns == ("risk_share",)
    assert TABLE.column("risk_share").tolist() == [0.25, 1e-20]
    assert len(TABLE) == 2
    assert [row.name for row in TABLE] == ["motor", "<grip>"]


def test_a_table_is_what_a_data_frame_is_made_of():
    assert TABLE.to_dict() == {"name": ["motor", "<grip>"], "risk_share": [0.25, 1e-20]}


def test_a_table_prints_in_columns():
    assert str(TABLE).splitlines() == [
        "name    risk share",
        "motor         0.25",
        "<grip>       1e-20",
    ]


def test_names_are_escaped_in_html():
    assert "<td>&lt;grip&gt;</td><td>1e-20</td>" in TABLE._repr_html_()


def test_an_empty_table_has_no_columns():
    assert Table(()).columns == ()
    assert Table(()).column("x").tolist() == []


def test_unknown_rows_and_columns_are_refused_with_those_there_are():
    with pytest.raises(ModelError, match="'motr' is not a row; did you mean 'motor'"):
        TABLE["motr"]
    with pytest.raises(ModelError, match="'share' is not a column; did you mean 'risk_share'"):
        TABLE.column("share")


def test_of_a_long_table_the_first_rows_are_shown_and_the_rest_reported():
    table = Table(tuple(Row(f"r{index}", 0.5) for index in range(100)))
    assert str(table).splitlines()[-1] == "and 40 more"
    assert "r59" in str(table)
    assert "r60" not in str(table)
    assert table._repr_html_().endswith("</table><p>and 40 more</p>")
    assert len(table.to_dict()["name"]) == 100
