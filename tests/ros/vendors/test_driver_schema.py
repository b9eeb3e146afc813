"""The JSON Schema of driver descriptions: what editors complete is what the reader takes."""

import copy
import json
from importlib.resources import files
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tracerisk.errors import DriverError
from tracerisk.ros.vendors import description_keys, value_reader
from tracerisk.ros.vendors.description import EFFECTS
from tracerisk.ros.vendors.description_reader import read_driver

SCHEMA = json.loads(files("tracerisk.ros.vendors").joinpath("driver.schema.json").read_text())
VALIDATOR = jsonschema.Draft7Validator(SCHEMA)
ROOT = Path(__file__).parents[3]
FILES = sorted(
    [*ROOT.glob("tracerisk/ros/vendors/*/*.driver.yaml"), *ROOT.glob("tests/data/drivers/*/*.yaml")]
)


def ids(path: Path) -> str:
    return path.name


def loaded(path: Path) -> Any:
    return yaml.load(path.read_text(), yaml.CSafeLoader)


def test_the_schema_is_one_of_its_draft():
    jsonschema.Draft7Validator.check_schema(SCHEMA)


@pytest.mark.parametrize("path", FILES, ids=ids)
def test_descriptions_that_are_read_fit_the_schema(path):
    read_driver(path)
    assert [each.message for each in VALIDATOR.iter_errors(loaded(path))] == []


def test_keys_that_the_schema_completes_are_those_that_the_reader_knows():
    assert set(SCHEMA["properties"]) == set(description_keys.TOP)
    for kind, keys in description_keys.OF_KIND.items():
        known = set(SCHEMA["definitions"][kind]["properties"])
        assert known - set(description_keys.CASE) == set(keys)
        assert known - set(keys) <= set(description_keys.CASE)
    for effect, roles in EFFECTS.items():
        assert set(SCHEMA["definitions"][effect]["properties"]) == set(roles)
    (_, _, _, full) = SCHEMA["definitions"]["value"]["anyOf"]
    assert set(full["properties"]) == set(value_reader.VALUE)


def places(node: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    found = [path]
    if isinstance(node, dict | list):
        items = node.items() if isinstance(node, dict) else enumerate(node)
        for key, value in items:
            found += places(value, (*path, key))
    return found


BASES = [loaded(path) for path in FILES]
JUNK = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(2**70), 2**70),
    st.floats(allow_nan=False, allow_infinity=False),
    st.text(max_size=12),
    st.sampled_from(["$joints", "$nothing", "$joints[0] deg", "a..b", "points[].x", "deg", "tool"]),
    st.lists(st.integers(0, 3), max_size=3),
    st.dictionaries(st.sampled_from(["field", "value", "unit", "map", "x"]), st.text(max_size=4)),
)


@pytest.mark.slow
@settings(suppress_health_check=list(HealthCheck))
@given(st.data())
def test_a_changed_description_is_read_or_reported_with_its_line(tmp_path_factory, data):
    changed = copy.deepcopy(data.draw(st.sampled_from(BASES)))
    for _ in range(data.draw(st.integers(1, 3))):
        where = data.draw(st.sampled_from(places(changed)[1:]))
        owner = changed
        for key in where[:-1]:
            owner = owner[key]
        what = data.draw(st.sampled_from(["replace", "remove", "add"]))
        if what == "replace":
            owner[where[-1]] = data.draw(JUNK)
        elif what == "remove":
            del owner[where[-1]]
        elif isinstance(owner, dict):
            owner[data.draw(st.text(min_size=1, max_size=8))] = data.draw(JUNK)
        if len(places(changed)) < 2:
            break
    path = tmp_path_factory.getbasetemp() / "changed.driver.yaml"
    path.write_text(yaml.dump(changed, Dumper=yaml.CSafeDumper, allow_unicode=True), "utf-8")
    wrong = [each.message for each in VALIDATOR.iter_errors(changed)]
    failed = None
    try:
        read_driver(path, shown="changed.driver.yaml")
    except DriverError as error:
        failed = error
    if failed is None:
        assert wrong == []
    else:
        place = failed.location
        assert place is not None
        assert (place.file, place.line is None) == ("changed.driver.yaml", False)


@given(st.binary(max_size=200))
def test_bytes_that_are_no_description_are_reported(tmp_path_factory, data):
    path = tmp_path_factory.getbasetemp() / "bytes.driver.yaml"
    path.write_bytes(data)
    with pytest.raises(DriverError):
        read_driver(path)
