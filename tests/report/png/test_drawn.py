"""Pictures are drawn, and what they show is what they were told to."""

import io
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from tracerisk.errors import RenderError
from tracerisk.report.png.drawn import drawn
from tracerisk.report.png.pictures import KIND_COLOURS, CaptionRow, Picture, Solid, make_pictures

SIZE = (240, 160)
COMPONENTS = {"motor": ("panda_joint2", "panda_joint4")}


def pixels(png: bytes) -> np.ndarray:
    """The picture above the caption, (height, width, 3)."""
    return np.asarray(Image.open(io.BytesIO(png)).convert("RGB"))[: SIZE[1]].astype(int)


@pytest.fixture(scope="module")
def pictures(two_functions, turning_arm) -> tuple[Picture, ...]:
    return make_pictures(two_functions, COMPONENTS, turning_arm)


@pytest.fixture(scope="module")
def shown(pictures) -> tuple[bytes, ...]:
    """Both pictures, the first one without colour, with a mesh, and with hostile words."""
    lift, bend = pictures
    plain = tuple(
        replace(each, colour=KIND_COLOURS["robot"]) if each.element else each
        for each in lift.solids
    )
    square = (0.0, 0.0, 0.0, 0.4, 0.0, 0.0, 0.4, 0.4, 0.0, 0.0, 0.0, 0.0, 0.4, 0.4, 0.0, 0, 0.4, 0)
    mesh = Solid("mesh", (), (0.2, 0.0, 0.5), (1.0, 0.0, 0.0, 0.0), "#ff0000", None, square)
    hostile = CaptionRow("</script> ' \" {{ 7 }} 抓取 " + "x" * 400, "#ff0000")
    several = [
        lift,
        bend,
        replace(lift, solids=plain),
        replace(lift, solids=(*lift.solids, mesh)),
        replace(lift, title="</title>" * 40, rows=(hostile,) * 3),
    ]
    try:
        return drawn(several, size=SIZE)
    except RenderError as error:
        pytest.skip(f"nothing can be drawn here: {error}")


def test_functions_look_different(shown):
    lift, bend, *_ = shown
    assert np.abs(pixels(lift) - pixels(bend)).max() > 40


@pytest.mark.slow  # Those that the commands of docs/report.md draw twice are the same too.
def test_what_is_drawn_again_has_the_same_bytes(pictures, shown):
    lift, bend, *_ = shown
    assert drawn(pictures, size=SIZE) == (lift, bend)


def test_the_link_of_the_active_joint_and_no_other_is_coloured(pictures, shown):
    lift, _, plain, *_ = shown
    differs = np.abs(pixels(lift) - pixels(plain)).sum(axis=2) > 24
    assert differs.sum() > 100
    coloured = pixels(lift)[differs]
    # The colour of moving is a blue; the grey of an idle link has no hue.
    assert (coloured[:, 2] > coloured[:, 0] + 10).mean() > 0.9
    # They are where the camera sees the shapes of the links behind joint 2, and no other ones.
    camera = pictures[0].camera
    rows, columns = np.nonzero(differs)
    reach = 0.0
    centres = []
    for solid in pictures[0].solids:
        if solid.element == "panda_joint2":
            centres.append(on_picture(camera, solid.xyz))
            reach = max(reach, sum(solid.size))
    away = np.linalg.norm(np.subtract(camera.eye, camera.target))
    room = 1.3 * reach / away / np.tan(camera.field / 2) * SIZE[1] / 2 + 2
    for row, column in zip(rows, columns, strict=True):
        assert min(np.hypot(column - x, row - y) for x, y in centres) < room


def on_picture(camera, point) -> tuple[float, float]:
    """Column and row at which a point is seen, by the formula of a pinhole."""
    eye, target = np.array(camera.eye), np.array(camera.target)
    back = (eye - target) / np.linalg.norm(eye - target)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    seen = np.array(point) - eye
    scale = SIZE[1] / 2 / np.tan(camera.field / 2) / -(seen @ back)
    return SIZE[0] / 2 + scale * (seen @ right), SIZE[1] / 2 - scale * (
        seen @ np.cross(back, right)
    )


def test_a_mesh_is_drawn_even_a_flat_one(shown):
    lift, _, _, with_mesh, _ = shown
    red = [
        int(((seen[..., 0] > 150) & (seen[..., 1:] < 20).all(axis=2)).sum())
        for seen in (pixels(lift), pixels(with_mesh))
    ]
    assert red[0] == 0
    assert red[1] > 200


def test_the_words_are_in_the_picture_and_beside_it(pictures, shown):
    image = Image.open(io.BytesIO(shown[0]))
    assert image.text["Title"] == "lift"
    assert image.text["Description"].split("\n") == [row.text for row in pictures[0].rows]
    below = np.asarray(image.convert("L"))[SIZE[1] :]
    assert below.min() < 60 < 250 < below.max()


def test_long_and_hostile_words_are_wrapped_into_the_caption(shown):
    image, plain = (Image.open(io.BytesIO(each)) for each in (shown[4], shown[0]))
    assert image.width == SIZE[0]
    assert image.height > plain.height
    assert image.text["Description"].count("</script> ' \" {{ 7 }} 抓取") == 3
    # Nothing runs over the margin.
    assert np.asarray(image.convert("L"))[SIZE[1] :, -12:].min() > 200


def test_where_nothing_can_be_drawn_it_is_reported_what_to_install(pictures, monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "nothing")
    with pytest.raises(RenderError, match="without a screen, and there is none") as caught:
        drawn(pictures)
    for word in ("nothing: ", "libegl1, libgl1 and libgl1-mesa-dri", "libosmesa6", "MUJOCO_GL"):
        assert word in str(caught.value)


def test_both_ways_are_tried_where_the_renderer_is_off(monkeypatch):
    """A machine without either library, played by a process that ends as it would there."""
    asked = []

    def no_gl(module, *arguments, environment, **others):
        asked.append(environment["MUJOCO_GL"])
        return subprocess.CompletedProcess([], 1, b"", b"Traceback:\nImportError: no GL for you\n")

    monkeypatch.setenv("MUJOCO_GL", "disable")
    monkeypatch.setattr("tracerisk.report.png.drawn.run_limited", no_gl)
    reported = re.escape("(egl: ImportError: no GL for you; osmesa: ImportError: no GL for you)")
    with pytest.raises(RenderError, match=reported):
        drawn([])
    assert asked == ["egl", "osmesa"]


def test_making_pictures_loads_neither_renderer_nor_pillow():
    script = (
        "import sys, tracerisk.report.png.drawn, tracerisk.report.png.pictures;"
        "print(sorted({'mujoco', 'PIL', 'dm_control'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert done.stdout.decode().strip() == "[]"
