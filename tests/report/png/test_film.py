"""A film shows the whole run, from one place, and says how fast it is."""

import io
import itertools
from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest
from PIL import Image

from tracerisk.common.dependencies import EXTRAS
from tracerisk.errors import DependencyError, RenderError
from tracerisk.report.png.drawn import filmed
from tracerisk.report.png.film import MOST_FRAMES, make_film, make_film_of_both
from tracerisk.report.png.film_child import CAPTION
from tracerisk.trace import RunEnd

SIZE = (121, 81)


@pytest.fixture(scope="module")
def frames(two_functions, turning_arm):
    return make_film(two_functions, turning_arm)


@pytest.fixture(scope="module")
def films(frames):
    """A film as GIF, and as MP4 where that can be."""
    formats = ("gif", "mp4") if find_spec("av") else ("gif",)
    try:
        return filmed(frames[::8], formats, frame_s=0.1, size=SIZE)
    except RenderError as error:
        pytest.skip(f"nothing can be drawn here: {error}")


def test_every_tenth_of_a_second_of_a_short_run_has_a_frame_from_one_place(frames):
    assert len(frames) == 41
    assert len({each.camera for each in frames}) == 1
    titles = [each.title for each in frames]
    assert titles == ["lift"] * 20 + ["bend"] * 21
    assert frames[0].rows[0].text == "0.0 of 4.0 s"
    assert frames[-1].rows[0].text == "4.0 of 4.0 s"


def test_the_caption_counts_what_the_elements_do(frames):
    words = [row.text for row in frames[5].rows]
    assert words[1:] == ["moving 1", "holding 0", "grasping 0"]
    coloured = {solid.element for solid in frames[5].solids if solid.colour.startswith("#")}
    assert "panda_joint2" in coloured


def test_a_long_run_is_shown_faster_and_says_so(two_functions, turning_arm):
    samples = turning_arm.samples
    names = ("control", "position", "velocity", "torque", "pad_force")
    longer = {name: np.repeat(getattr(samples, name), 8, axis=0) for name in names}
    longer["poses"] = np.repeat(samples.poses, 8, axis=0)
    run = replace(turning_arm, samples=replace(samples, **longer))
    trace = replace(two_functions, end=RunEnd("ended", "the controller ended", 32.0))
    found = make_film(trace, run)
    assert len(found) == MOST_FRAMES
    assert found[60].rows[0].text == "16.1 of 32.0 s, 2.69 times as fast"


def test_two_runs_stand_beside_each_other_in_step_and_seen_from_one_place(
    two_functions, turning_arm, trace_of
):
    joints = ("panda_joint2", "panda_joint4")
    later = trace_of(("raise", 0.0, 1.0, joints), ("bend", 1.0, 3.0, joints))
    found = make_film_of_both(
        two_functions, turning_arm, later, turning_arm, renamed={"lift": "raise"}
    )
    before, now = found[::2], found[1::2]
    assert len(before) == len(now)
    assert len({each.camera for each in found}) == 1
    titles = [
        [name for name, last in zip(names, [None, *names], strict=False) if name != last]
        for names in ([each.title for each in side] for side in (before, now))
    ]
    assert titles == [["Before: lift", "Before: bend"], ["Now: raise", "Now: bend"]]
    # The visits begin in the same frame, although one takes half as long.
    starts = [
        [each.title for each in side].index(names[1])
        for side, names in zip((before, now), titles, strict=True)
    ]
    assert starts[0] == starts[1]
    assert [side[-1].rows[0].text for side in (before, now)] == ["4.0 of 4.0 s"] * 2
    try:
        (gif,) = filmed(found[::8] + found[1::8], ("gif",), frame_s=0.1, size=SIZE, beside=2)
    except RenderError as error:
        pytest.skip(f"nothing can be drawn here: {error}")
    image = Image.open(io.BytesIO(gif))
    assert image.n_frames == len(found[::8])
    assert image.width > 2 * SIZE[0]


def test_a_gif_moves_and_has_the_same_bytes_again(frames, films):
    gif = films[0]
    shown = Image.open(io.BytesIO(gif))
    assert (shown.n_frames, shown.size) == (6, (SIZE[0], SIZE[1] + CAPTION))
    assert shown.info["duration"] == 100
    assert shown.info["loop"] == 0
    seen = []
    for number in range(shown.n_frames):
        shown.seek(number)
        seen.append(np.asarray(shown.convert("RGB"))[: SIZE[1]].astype(int))
    assert all(np.abs(one - other).max() > 40 for one, other in itertools.pairwise(seen))
    assert filmed(frames[::8], ("gif",), frame_s=0.1, size=SIZE)[0] == gif


def test_an_mp4_has_every_frame(films):
    av = pytest.importorskip("av", reason="av is not installed")
    with av.open(io.BytesIO(films[1])) as container:
        stream = container.streams.video[0]
        assert stream.codec_context.name == "h264"
        shown = list(container.decode(video=0))
    assert [(each.width, each.height) for each in shown] == [(120, 144)] * 6


def test_without_the_extra_the_command_says_how_to_get_it(monkeypatch, tmp_path):
    from tracerisk.common import dependencies

    monkeypatch.setattr(dependencies, "is_installed", lambda name: name not in EXTRAS["film"])
    with pytest.raises(DependencyError, match=r"a film as MP4 needs av.*'tracerisk\[film\]'"):
        dependencies.require_film()
