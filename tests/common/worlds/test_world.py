"""The table of worlds: names, groups and what is drawn of them."""

import re
from pathlib import Path

import pytest

from tracerisk.common.worlds.world import ALL, NOMINAL, WORLDS, World, world_named, worlds_named
from tracerisk.errors import InputError

PAGE = Path(__file__).parents[3] / "docs" / "worlds.md"
JOINTS = ("shoulder_pan", "shoulder_lift", "elbow")


def names(text: str) -> list[str]:
    return [world.name for world in worlds_named(text)]


def test_all_stands_for_every_world_and_a_group_for_those_that_begin_so():
    assert names(ALL) == [world.name for world in WORLDS]
    assert names("gripper") == ["gripper-open", "gripper-closed", "gripper-half"]
    assert names("start, latency") == ["latency", "start"]


@pytest.mark.parametrize("text", ["discover", "other", "nominal", "latency,foo"])
def test_an_unknown_name_lists_those_there_are(text):
    with pytest.raises(InputError, match=r"unknown world '\w+'; .*allowed: all, discovery"):
        worlds_named(text)


def test_no_name_is_an_error():
    with pytest.raises(InputError, match="names no world; allowed: all, "):
        worlds_named(" , ")


def test_what_is_drawn_is_within_its_range_and_the_same_each_time():
    world = world_named("latency")
    drawn = [world.drawn(world.latency_s, number) for number in range(100)]
    assert drawn == [world.drawn(world.latency_s, number) for number in range(100)]
    assert min(drawn) >= 0.005
    assert max(drawn) <= 0.040
    assert max(drawn) - min(drawn) > 0.03
    assert NOMINAL.drawn(NOMINAL.latency_s, 1) == 0.0


@pytest.mark.parametrize(
    ("order", "expected"),
    [
        ("robot", ["shoulder_pan", "shoulder_lift", "elbow"]),
        ("alphabetical", ["elbow", "shoulder_lift", "shoulder_pan"]),
        ("reversed", ["elbow", "shoulder_lift", "shoulder_pan"]),
        ("rotated", ["elbow", "shoulder_pan", "shoulder_lift"]),
    ],
)
def test_joints_are_listed_in_the_order_of_the_world(order, expected):
    assert World("w", "", "", joint_order=order).ordered(JOINTS) == expected


def test_the_docs_have_the_table():
    rows = re.findall(
        r"^\| `([\w-]+)` \| (.+) \| \[.*\]\((\S+)\) \|$", PAGE.read_text(), re.MULTILINE
    )
    assert rows == [(world.name, world.description, world.source) for world in WORLDS]
