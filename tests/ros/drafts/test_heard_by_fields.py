"""A pose of an own message, published to nobody as the only motion, is one that a driver obeys."""

from types import SimpleNamespace

import pytest

from tests.ros.drafts.test_guards import values  # noqa: F401
from tracerisk.pipeline.run.needs.noted_drafts import NotedDrafts
from tracerisk.ros.controller.needs import Missed, Need
from tracerisk.ros.drafts.drafting import drafts
from tracerisk.ros.messages.ros1 import Interfaces
from tracerisk.ros.messages.ros2 import Interfaces2

OWN = {
    "HybridPose": "geometry_msgs/Pose pose\nuint8[] selection\ngeometry_msgs/Wrench wrench",
    "Joints": "float64[] joint_angles",
    "Preset": "sensor_msgs/JointState posture",
    "Station": "geometry_msgs/PoseStamped place\nstring name",
    "Waypoints": "geometry_msgs/Pose[] poses",
    "DetectedObject": "geometry_msgs/Pose pose",
    "ArmCommand": "geometry_msgs/Pose pose",
}
HEARD = {
    "a pose": ("/panda/hybrid_pose", "HybridPose", "pose"),
    "a pose with a frame": ("/next", "Station", "place"),
    "joints": ("/next", "Joints", "joint_angles"),
    "joints by name": ("/next", "Preset", "posture.position"),
    "joint states": ("/joint_states_interpolated", "sensor_msgs/JointState", "position"),
    "those of a model": ("/joint_states", "sensor_msgs/JointState", "position"),
}
UNHEARD = {
    "several": ("/next", "Waypoints"),
    "what is seen": ("/next", "DetectedObject"),
    "a state": ("/arm/state", "HybridPose"),
    "a marker": ("/arm_marker", "HybridPose"),
    "for RViz": ("/rviz/next", "HybridPose"),
    "a path": ("/path", "HybridPose"),
    "for the eye": ("/visual/next", "HybridPose"),
    "what is debugged": ("/debug_pose", "HybridPose"),
    "a model to be seen": ("/rviz/joint_states", "sensor_msgs/JointState"),
}


@pytest.fixture(params=[Interfaces, Interfaces2], ids=["ros1", "ros2"])
def interfaces(request, tmp_path):
    folder = tmp_path / "cell" / "msg"
    folder.mkdir(parents=True)
    for name, text in OWN.items():
        (folder / f"{name}.msg").write_text(f"{text}\n")
    return request.param(workspace={"cell": tmp_path / "cell"})


def missed(topic, short, kind="command"):
    return Missed(Need(kind, topic, short if "/" in short else f"cell/{short}"), 0, 0, None)


@pytest.mark.parametrize("kind", HEARD)
def test_a_message_moves_the_arm_by_its_fields(interfaces, values, kind):  # noqa: F811
    topic, short, path = HEARD[kind]
    (draft,) = drafts([missed(topic, short)], interfaces, values)
    (heard,) = draft.value["subscribed_topics"].values()
    assert path in heard["move"].values()


@pytest.mark.parametrize("kind", UNHEARD)
def test_what_says_or_shows_something_moves_nothing(interfaces, values, kind):  # noqa: F811
    (draft,) = drafts([missed(*UNHEARD[kind])], interfaces, values)
    assert draft.value is None


ONLY = {
    "alone": ([("/next", "HybridPose")], {}, ["/next"]),
    "beside a text": ([("/next", "HybridPose"), ("/speed", "Speed")], {}, ["/next"]),
    "beside another": ([("/next", "HybridPose"), ("/then", "Station")], {}, []),
    "of a model": ([("/joint_states", "sensor_msgs/JointState")], {}, ["/joint_states"]),
    "of a model beside a command": (
        [("/joint_states", "sensor_msgs/JointState"), ("/go", "ArmCommand")],
        {},
        ["/go"],
    ),
    "beside a command": ([("/next", "HybridPose"), ("/go", "ArmCommand")], {}, ["/go"]),
    "of what moves": ([("/next", "HybridPose")], {"shows_risk": True}, []),
    "of what sees": ([("/next", "HybridPose")], {"sees": True}, []),
    "of an unknown type": ([("/next", "Unknown")], {}, []),
}


@pytest.mark.parametrize("kind", ONLY)
def test_it_is_obeyed_where_it_is_the_only_motion(interfaces, values, kind):  # noqa: F811
    published, more, wanted = ONLY[kind]
    unheard = [
        missed(topic, short, "topic")
        if short in (*OWN, "Unknown") or "/" in short
        else Missed(Need("topic", topic, "std_msgs/Float64"), 0, 0, None)
        for topic, short in published
    ]
    run = SimpleNamespace(
        lacked=SimpleNamespace(
            runtime=SimpleNamespace(graph=SimpleNamespace(unheard=lambda: unheard)),
            interfaces=interfaces,
            values=values,
        ),
        _sees=lambda: more.get("sees", False),
    )
    found = NotedDrafts._may_be_obeyed(run, shows_risk=more.get("shows_risk", False))
    assert [each.need.name for each in found] == wanted
