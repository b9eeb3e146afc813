"""The examples of docs/sysml.md are read, and give what the text says."""

import re
from pathlib import Path

import pytest

from tracerisk.common.hardware.sysml.language.standard_names import FEATURES
from tracerisk.common.hardware.sysml.sysml_reader import read_sysml

TEXT = (Path(__file__).parents[4] / "docs" / "sysml.md").read_text(encoding="utf-8")
EXAMPLES = re.findall(r"```sysml\n(.*?)```", TEXT, re.DOTALL)
QUANTITIES = [
    {"arm.motor": 7, "power_supply": 2},
    {"engine": 1, "pump": 1},
    {"arm.drive": 6, "controller": 2},
]


@pytest.mark.parametrize("index", range(len(QUANTITIES)))
def test_an_example_is_read(tmp_path, index):
    assert len(EXAMPLES) == len(QUANTITIES)
    path = tmp_path / "example.sysml"
    path.write_text(EXAMPLES[index], encoding="utf-8")
    hardware = read_sysml(path)
    assert {each.name: each.quantity for each in hardware.components} == QUANTITIES[index]
    assert hardware.warnings == ()


def test_an_attribute_that_a_part_redefines_counts(tmp_path):
    path = tmp_path / "example.sysml"
    path.write_text(EXAMPLES[2], encoding="utf-8")
    assert read_sysml(path).components[0].age_s == 12000 * 3600.0


def test_every_feature_of_our_metadata_is_named():
    for kind, features in FEATURES.items():
        for feature in features:
            assert re.search(rf"\b{feature}\b", TEXT), f"{kind}.{feature}"
