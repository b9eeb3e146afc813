"""What a controller asked for in vain is kept, and written as scenario lines that can be read."""

from __future__ import annotations

import pytest

from tracerisk.errors import Location
from tracerisk.ros.messages import Interfaces
from tracerisk.ros.messages2 import Interfaces2
from tracerisk.ros.needs import Need, NeedLedger
from tracerisk.ros.scenario import read_scenario
from tracerisk.ros.scenario_lines import scenario_lines

PLACE = Location("c.py", 3)
DETECT = Need("service", "/detect")


@pytest.fixture
def ledger():
    return NeedLedger()


def test_what_is_given_is_lacked_no_more(ledger):
    ledger.miss(DETECT, 5, PLACE)
    ledger.miss(DETECT, 9, PLACE)
    (missed,) = ledger.missed
    assert (missed.first_ns, missed.last_ns, missed.location) == (5, 9, PLACE)
    ledger.meet(DETECT)
    assert ledger.missed == ()


def test_a_type_that_is_told_before_or_after_is_that_of_the_need(ledger):
    ledger.miss(DETECT, 5, PLACE)
    ledger.tell_type("service", "/detect", "std_srvs/Trigger")
    ledger.tell_type("service", "/reset", "std_srvs/Empty")
    ledger.miss(Need("service", "/reset"), 6, PLACE)
    told = [each.need.told for each in ledger.missed]
    assert told == ["service /detect (std_srvs/Trigger)", "service /reset (std_srvs/Empty)"]


def test_who_asks_now_and_then_does_not_wait(ledger):
    need = Need("parameter", "/done")
    for _ in range(9):
        ledger.ask(need, 1)
    assert ledger.missed == ()
    ledger.ask(need, 2)
    assert [each.need for each in ledger.missed] == [need]


NEEDS = [
    Need("topic", "/object", "geometry_msgs/PoseStamped"),
    Need("topic", "/scan", "sensor_msgs/CameraInfo"),
    Need("service", "/detect", "std_srvs/Trigger"),
    Need("service", "/untyped"),
    Need("action", "/look", "control_msgs/PointHead"),
    Need("frame", "marker", parent="world"),
    Need("parameter", "/pick/names", "string_array"),
    Need("input", "'Go? [y/n]'"),
]


@pytest.mark.parametrize("interfaces", [Interfaces(), Interfaces2()], ids=["ros1", "ros2"])
def test_the_lines_are_a_scenario_that_gives_all_that_lacked(tmp_path, interfaces):
    path = tmp_path / "s.yaml"
    path.write_text(scenario_lines(NEEDS, interfaces))
    scenario = read_scenario(path)
    assert [each.topic for each in scenario.published] == ["/object", "/scan"]
    assert [each.name for each in scenario.services] == ["/detect", "/untyped"]
    assert [each.name for each in scenario.actions] == ["/look"]
    assert [each.frame for each in scenario.frames] == ["marker"]
    assert [each.value for each in scenario.parameters] == [[""]]
    assert scenario.answers == ("y",)


def test_stamps_are_now_and_a_quaternion_turns_nothing():
    lines = scenario_lines(NEEDS[:1], Interfaces())
    assert "header: {stamp: now, frame_id: ''}" in lines
    assert "orientation: {x: 0.0, y: 0.0, z: 0.0, w: 1.0}" in lines


def test_a_type_that_is_not_known_is_written_without_fields():
    need = Need("service", "/detect", "my_msgs/Detect")
    assert scenario_lines([need], Interfaces()) == "services:\n  - name: /detect\n"
