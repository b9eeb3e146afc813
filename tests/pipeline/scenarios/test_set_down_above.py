"""Drafts of calls that follow one another: what is taken at a pose is set down from above it."""

from typing import Any

from tracerisk.pipeline.scenarios.entries import Entries, set_down_above
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft

POSE = {
    "position": {"x": 0.5, "y": 0.0, "z": 0.2},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}


def entries(*calls: tuple[str, str, Any]) -> Entries:
    drafts = [
        Draft(Need("goal", name, kind), name, {"action": name, "goal": goal}, "one goal")
        for name, kind, goal in calls
    ]
    frame = Draft(Need("frame", "map"), "map", None, "the base")
    return Entries({(each.section, each.key): each for each in (frame, *drafts)})


def test_the_second_goal_of_the_same_pose_is_above_the_first():
    goal = {"object_pose": {"pose": POSE}, "ways": [POSE], "height": 0.2}
    found = set_down_above(entries(("/pick", "a/Move", goal), ("/place", "a/Move", goal)))
    assert found is not None
    first, second = (found.drafts["calls", name] for name in ("/pick", "/place"))
    assert first.value["goal"] == goal
    assert second.value["goal"]["object_pose"]["pose"]["position"] == {
        "x": 0.5,
        "y": 0.0,
        "z": 0.22,
    }
    assert second.value["goal"]["ways"][0]["position"]["z"] == 0.22
    assert second.value["goal"]["height"] == 0.2
    assert second.words == "one goal; 0.02 m above the one before"


def test_other_poses_types_and_goals_without_any_stay():
    other = {"pose": {**POSE, "position": {"x": 0.1, "y": 0.0, "z": 0.2}}}
    assert (
        set_down_above(entries(("/a", "a/Move", {"pose": POSE}), ("/b", "a/Move", other))) is None
    )
    same = {"pose": POSE}
    assert set_down_above(entries(("/a", "a/Move", same), ("/b", "b/Move", same))) is None
    assert set_down_above(entries(("/a", "a/Go", {"n": 1}), ("/b", "a/Go", {"n": 1}))) is None
