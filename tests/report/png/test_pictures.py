"""What is in a picture, and what is said of it."""

import math
import re
import string
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tracerisk.common.geometry.shapes import Shape
from tracerisk.common.text.printable import one_line
from tracerisk.errors import InputError, LogError
from tracerisk.report import html
from tracerisk.report.png.pictures import (
    KIND_COLOURS,
    STATE_COLOURS,
    file_name,
    legend_data,
    make_pictures,
    mixed,
)
from tracerisk.twin.physics.declared_log import DeclaredChange, LoggedShape

COMPONENTS = {
    "motor": tuple(f"panda_joint{number}" for number in range(1, 8)),
    "power": (),
    "gripper": ("panda_hand",),
}


@pytest.fixture(scope="module")
def pictures(two_functions, turning_arm):
    return make_pictures(two_functions, COMPONENTS, turning_arm)


def hued(picture, element):
    """The colours of what an element drives."""
    return {solid.colour for solid in picture.solids if solid.element == element}


def test_there_is_a_picture_for_each_function_with_what_is_active_in_it(pictures):
    lift, bend = pictures
    assert (lift.file, bend.file) == ("01-lift.png", "02-bend.png")
    assert lift.entry["active"] == {"motor": {"panda_joint2": ["moving"]}}
    assert bend.entry["active"] == {"motor": {"panda_joint4": ["moving"]}}
    assert lift.entry["always"] == ["power"]
    assert (lift.entry["visit"], lift.entry["visits"]) == (1, 1)
    assert 0.0 < lift.entry["time_s"] < 2.0 < bend.entry["time_s"] < 4.0
    words = [row.text for row in lift.rows]
    assert "moving: motor (panda_joint2)" in words
    assert "always in use: power" in words
    assert {row.colour for row in lift.rows} == {None, STATE_COLOURS["moving"]}


def test_only_links_of_active_joints_have_the_colour_of_their_state(pictures):
    plain, blue = {KIND_COLOURS["robot"]}, STATE_COLOURS["moving"]
    lift, bend = pictures
    for picture, active, idle in ((lift, 2, 4), (bend, 4, 2)):
        assert hued(picture, f"panda_joint{idle}") == plain
        (colour,) = hued(picture, f"panda_joint{active}")
        assert colour in {mixed(KIND_COLOURS["robot"], blue, part) for part in (0.66, 0.92)}


def test_the_camera_is_the_same_and_sees_every_link_in_all_pictures(pictures):
    lift, bend = pictures
    assert lift.camera == bend.camera
    camera = lift.camera
    back = [e - t for e, t in zip(camera.eye, camera.target, strict=True)]
    away = math.hypot(*back)
    back = [each / away for each in back]
    flat = math.hypot(back[0], back[1])
    right = (-back[1] / flat, back[0] / flat, 0.0)
    up = (-back[2] * right[1], back[2] * right[0], flat)
    links = [
        solid.xyz for picture in pictures for solid in picture.solids if solid.element is not None
    ]
    tangent = math.tan(camera.field / 2)
    for point in links:
        seen = [p - e for p, e in zip(point, camera.eye, strict=True)]
        x, y, z = (
            sum(a * b for a, b in zip(axis, seen, strict=True)) for axis in (right, up, back)
        )
        assert z < 0.0
        assert abs(x) < -z * tangent * 1.5
        assert abs(y) < -z * tangent


def test_the_legend_lists_the_pictures_and_what_the_colours_mean(two_functions, pictures):
    legend = legend_data(two_functions, pictures)
    assert [each["function"] for each in legend["pictures"]] == ["lift", "bend"]
    assert legend["colours"] == STATE_COLOURS
    assert (legend["robot"], legend["scene"]) == ("panda", "tube_racks")


def test_what_moves_with_no_component_is_reported_and_a_sensor_with_none_is_not(
    trace_of, turning_arm
):
    trace = trace_of(("lift", 0.0, 4.0, ("panda_joint2", "eye")))
    (picture,) = make_pictures(trace, {}, turning_arm)
    assert picture.entry["active"] == {"": {"panda_joint2": ["moving"]}}
    assert "moving: no component: panda_joint2" in [row.text for row in picture.rows]
    (picture,) = make_pictures(trace, {"camera": ("eye",)}, turning_arm)
    assert picture.entry["active"]["camera"] == {"eye": ["in use"]}


def test_of_many_elements_the_first_are_named(trace_of, turning_arm):
    names = tuple(f"s{index}" for index in range(40))
    trace = trace_of(("lift", 0.0, 4.0, names))
    (picture,) = make_pictures(trace, {"sensor": names}, turning_arm)
    (reported,) = [row.text for row in picture.rows if row.colour == STATE_COLOURS["in use"]]
    assert reported.endswith("s11, and 28 more)")


def test_what_the_controller_puts_into_the_scene_is_there_from_then_on(two_functions, turning_arm):
    box = LoggedShape(
        "box", False, (0.5, 0.0, 0.3, 1.0, 0.0, 0.0, 0.0), (Shape("sphere", (0.07,)),)
    )
    change = DeclaredChange(1_000, (box,), np.zeros(0), np.zeros((0, 0, 7)))
    lift, bend = make_pictures(two_functions, COMPONENTS, replace(turning_arm, declared=(change,)))
    balls = [
        [solid for solid in picture.solids if solid.size == (0.07,)] for picture in (lift, bend)
    ]
    assert balls[0] == []
    assert [(each.xyz, each.colour) for each in balls[1]] == [
        ((0.5, 0.0, 0.3), KIND_COLOURS["declared"])
    ]


def test_a_recording_of_another_run_is_refused(trace_of, turning_arm):
    trace = trace_of(("lift", 0.0, 9.0, ("panda_joint2",)), end_s=9.0)
    with pytest.raises(LogError, match=r"recording \(panda, 4\.0 s\) is not of the run.*9\.0 s"):
        make_pictures(trace, COMPONENTS, turning_arm)


def test_a_run_that_commanded_nothing_has_no_pictures(trace_of, turning_arm):
    with pytest.raises(InputError, match="nothing to picture"):
        make_pictures(trace_of(), COMPONENTS, turning_arm)


@pytest.mark.parametrize(
    ("function", "name"),
    [
        ("place", "03-place.png"),
        ("PickNode.place", "03-PickNode.place.png"),
        ("<module>", "03-module.png"),
        ("../../etc/passwd", "03-etc_passwd.png"),
        ("größer", "03-gr_er.png"),
        ("\u202e\n</script>", "03-script.png"),
        ("抓取", "03-function.png"),
        ("", "03-function.png"),
        ("..", "03-function.png"),
    ],
)
def test_names_of_files_are_safe(function, name):
    assert file_name(3, function) == name


@given(st.text(max_size=300), st.integers(1, 2000))
def test_no_function_name_leads_out_of_the_folder(function, number):
    name = file_name(number, function)
    assert set(name) <= set(string.ascii_letters + string.digits + "_.-")
    assert len(name) <= 60
    assert name.startswith(f"{number:02d}-")
    assert name.endswith(".png")


def test_states_have_the_colours_of_the_page():
    css = (Path(html.__file__).parent / "assets" / "page.css").read_text(encoding="utf-8")
    light = dict(re.findall(r"--([\w-]+): light-dark\((#\w{6}), ", css))
    for state in ("moving", "holding", "grasping"):
        assert STATE_COLOURS[state] == light[state]


def test_what_would_not_show_is_written_as_its_code():
    assert one_line("a\u202eb\n größer") == "a\\u202eb größer"
