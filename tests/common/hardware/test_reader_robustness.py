"""Whatever stands in a description, it is read or refused with a place, never more."""

import copy
import json
import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.common.hardware.strategies import hardware_descriptions
from tracerisk.common.hardware.description_data import description_data
from tracerisk.common.hardware.yaml.hardware_reader import read_hardware
from tracerisk.errors import HardwareError

STRANGE = (
    None,
    True,
    False,
    0,
    -1,
    1,
    3,
    10**400,
    1.5,
    -0.0,
    float("inf"),
    "",
    "*",
    "x",
    "10/3",
    "always",
    [],
    [None],
    ["moving"],
    [[]],
    {},
    {"": None},
    {"value": 1},
    {"value": 1e-6, "per": "hour"},
)


@pytest.fixture(scope="module")
def file(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("strange") / "h.yaml"


def places(node):
    """Every map or list of the data, with each key or index in it."""
    entries = node.items() if isinstance(node, dict) else enumerate(node)
    for key, value in entries:
        yield node, key
        if isinstance(value, dict | list):
            yield from places(value)


@settings(max_examples=25)
@given(
    hardware=hardware_descriptions(),
    strange=st.sampled_from(STRANGE),
    how=st.sampled_from(["replace", "remove", "rename", "move"]),
    seed=st.integers(0, 2**32),
)
def test_a_description_with_one_thing_changed_is_read_or_refused(
    file, hardware, strange, how, seed
):
    data = description_data(hardware)
    choose = random.Random(seed)
    holder, key = choose.choice(list(places(data)))
    value = copy.deepcopy(strange)
    if how == "replace":
        holder[key] = value
    elif how == "remove":
        del holder[key]
    elif how == "rename" and isinstance(holder, dict):
        other, other_key = choose.choice(list(places(data)))
        holder[str(other_key)] = copy.deepcopy(other[other_key])
    elif how == "move":
        other, other_key = choose.choice(list(places(data)))
        holder[key] = copy.deepcopy(other[other_key])
    text = json.dumps(data, ensure_ascii=True).replace("Infinity", ".inf")
    file.write_text(text, encoding="utf-8")
    try:
        read = read_hardware(file, shown="h.yaml")
    except HardwareError as error:
        assert str(error).startswith("h.yaml:1:"), str(error)  # noqa: PT017
    else:
        assert read.components
