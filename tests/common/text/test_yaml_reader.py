"""YAML files with the place of each key: what is read, and what is not YAML."""

import warnings

import pytest

from tracerisk.common.text.yaml_reader import read_yaml
from tracerisk.errors import InputError


@pytest.mark.parametrize("version", [(1, 1), (1, 2)])
def test_a_number_without_a_dot_is_read_without_a_word(tmp_path, version):
    file = tmp_path / "a.yaml"
    file.write_text("a: 1e-3\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read_yaml(file, version=version).number("a") == 0.001


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("a: [1\n", "a.yaml:2:1: is not valid YAML: "),
        ("? [a: b]\n: c\n", "a.yaml: cannot be read as YAML: "),
        ("a: 2026-13-01\n", "a.yaml: cannot be read as YAML: "),
        (
            "a: " + "[" * 100_000,
            "a.yaml:1:104: is not valid YAML: is nested deeper than 100 levels",
        ),
        ("a:\n " + "- " * 50_000, "a.yaml:2:202: is not valid YAML: is nested deeper than 100 "),
        ("b: 1\na: !!set x\n", "a.yaml:2: has a value that does not fit its tag (!!set, !!omap);"),
        ("1: 2\n", "a.yaml:1:1: key 1 is not a string; put it in quotes"),
        ("- 1\n", "a.yaml:1: expected a mapping at the top, found "),
    ],
)
def test_what_is_no_mapping_of_yaml_is_an_error_with_its_place(tmp_path, text, expected):
    file = tmp_path / "a.yaml"
    file.write_text(text)
    with pytest.raises(InputError) as found:
        read_yaml(file, shown="a.yaml")
    assert str(found.value).startswith(expected)
