from dataclasses import replace
from pathlib import Path

import pytest

from tracerisk.common.geometry.shapes import Shape
from tracerisk.errors import RobotError
from tracerisk.twin.physics.scene import Goal, GraspableObject, Scene, load_scene, scene_names
from tracerisk.twin.robots.robot import Robot, load_robot, robot_names
from tracerisk.twin.simulation.twin import Twin

SCENES = Path(__file__).parents[3] / "tracerisk" / "twin" / "physics" / "scenes"


def test_slots_are_where_the_scene_file_says(tube_racks: Scene):
    assert [thing.name for thing in tube_racks.objects] == [f"tube_{i}" for i in range(1, 11)]
    for i, (tube, goal) in enumerate(zip(tube_racks.objects, tube_racks.goals, strict=True)):
        assert tube.xyz == pytest.approx((0.30 + 0.04 * i, 0.20, 0.055))
        assert goal.xyz == pytest.approx((0.30 + 0.04 * i, -0.20, 0.055))


@pytest.mark.parametrize("name", robot_names())
def test_a_default_scene_has_nothing_but_what_the_robot_stands_on(name: str):
    robot = load_robot(name)
    assert robot.default_scene in scene_names()
    scene = load_scene(robot.default_scene)
    assert {each.name for each in scene.fixtures} <= {"floor", "column", "feet"}
    assert (scene.objects, scene.goals) == ((), ())


def test_the_floor_of_the_empty_scene_bears_what_lies_on_it(panda: Robot):
    ball = GraspableObject(
        "ball", (0.5, 0.0, 0.03), (0.0, 0.0, 0.0), 0.1, 0.5, (Shape("sphere", (0.02,)),)
    )
    goal = Goal("where it lies", (0.5, 0.0, 0.02))
    twin = Twin.build(panda, replace(load_scene("empty"), objects=(ball,), goals=(goal,)))
    twin.advance(1_000_000_000)
    (offset,) = twin.object_offsets()
    assert offset.offset_m < 0.001


def test_a_tube_left_alone_stands_in_its_slot(twin: Twin, tube_racks: Scene):
    twin.advance(2_000_000_000)
    for tube, offset in zip(tube_racks.objects, twin.object_offsets(), strict=True):
        assert offset.tilt_rad < 0.03
        # Both racks are 0.4 m apart: it has not left its own slot's middle by 2 mm.
        assert offset.offset_m == pytest.approx(0.4, abs=0.002), tube.name


def test_a_tube_in_the_wrong_rack_is_far_from_its_goal(twin: Twin):
    assert min(offset.offset_m for offset in twin.object_offsets()) > 0.3


def test_the_empty_scene_has_nothing_to_grasp(panda: Robot):
    twin = Twin.build(panda, load_scene("empty"))
    twin.advance(100_000_000)
    assert twin.object_offsets() == ()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("stands_in: source_rack", "stands_in: sauce_rack", "did you mean 'source_rack'"),
        ("pitch: 0.04", "pitch: 0.01", "leaves no rib"),
        ("mass: 0.025", "mass: 0.0", "0 is outside"),
        ("name: tube\n", "name: source_rack\n", None),
        ("- name: table", "- name: target_rack", "defined twice"),
    ],
)
def test_a_mistake_is_reported_with_the_file(
    tmp_path: Path, old: str, new: str, message: str | None
):
    text = (SCENES / "tube_racks.yaml").read_text(encoding="utf-8")
    assert old in text
    path = tmp_path / "bench.yaml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    if message is None:
        assert load_scene(path).objects[0].name == "source_rack_1"
        return
    with pytest.raises(RobotError, match=message) as caught:
        load_scene(path)
    assert caught.value.location is not None
    assert caught.value.location.file == str(path)


def test_a_body_named_as_a_link_is_refused(tmp_path: Path, panda: Robot):
    path = tmp_path / "bench.yaml"
    text = (SCENES / "empty.yaml").read_text(encoding="utf-8")
    path.write_text(text.replace("name: floor", "name: panda_hand"), encoding="utf-8")
    with pytest.raises(RobotError, match="both have a body 'panda_hand'"):
        Twin.build(panda, load_scene(path))
