"""What a live source publishes comes again and again, and a pose of it changes."""

import pytest

from tracerisk.pipeline.scenarios.entries import Entries, as_streams, repeated
from tracerisk.ros.controller.needs import Need
from tracerisk.ros.drafts.draft import Draft

POSE = {
    "position": {"x": 0.5, "y": 0.0, "z": 0.2},
    "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
}
KEY = ("publish", "/hand")


def published(kind, message):
    value = {"topic": "/hand", "type": kind, "after": 1.0, "message": message}
    return Entries({KEY: Draft(Need("topic", "/hand", kind), "/hand", value, "a guess")})


@pytest.mark.parametrize("is_repeated", [False, True])
@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("geometry_msgs/Pose", POSE),
        ("geometry_msgs/PoseStamped", {"header": {"frame_id": "base"}, "pose": POSE}),
        ("geometry_msgs/PoseArray", {"poses": [POSE]}),
    ],
)
def test_poses_change_from_one_message_to_the_next(kind, message, is_repeated):
    entries = published(kind, message)
    entries = repeated(entries) if is_repeated else entries
    draft = as_streams(entries).drafts[KEY]
    first, second, *rest = draft.value["messages"]
    assert first == message
    assert str(second) == str(message).replace("'z': 0.2", "'z': 0.3")
    assert rest == [first, second]
    assert draft.value["rate"] == 1.0
    assert "after" not in draft.value
    assert draft.words == "a guess; moved a little once a second"
    assert as_streams(as_streams(entries)) is None


@pytest.mark.parametrize(
    ("kind", "message"),
    [
        ("std_msgs/Float32MultiArray", {"data": [1.0, 0.5]}),
        ("std_msgs/Float64", {"data": 0.5}),
        ("geometry_msgs/Twist", {"linear": {"x": 0.1}}),
    ],
)
def test_numbers_and_speeds_come_faster_than_they_are_forgotten(kind, message):
    streamed = as_streams(published(kind, message))
    value = streamed.drafts[KEY].value
    assert as_streams(streamed) is None
    assert (value["message"], value["rate"], value["until"]) == (message, 10.0, 60.0)


@pytest.mark.parametrize("kind", ["std_msgs/String", "std_msgs/Bool", "sensor_msgs/Joy"])
def test_a_command_is_no_stream(kind):
    assert as_streams(published(kind, {"data": "go"})) is None
