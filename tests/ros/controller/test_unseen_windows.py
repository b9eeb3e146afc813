"""Figures that a run shows nobody cost nothing, and those that are kept are drawn."""

import pytest

from tracerisk.pipeline.run import controller_run


@pytest.fixture(scope="module")
def unseen_windows():
    """The module, which imports Matplotlib: that takes every process that collects tests long."""
    pytest.importorskip("matplotlib")
    from tracerisk.ros.controller import unseen_windows

    return unseen_windows


@pytest.fixture
def drawn(monkeypatch, unseen_windows):
    """Return the canvas of a figure with a line, and how often it was drawn."""
    from matplotlib.figure import Figure

    figure, times = Figure(), []
    figure.add_subplot().plot([0.0, 1.0])
    real = figure.draw
    monkeypatch.setattr(figure, "draw", lambda renderer: (times.append(1), real(renderer)))
    return unseen_windows.FigureCanvas(figure), times


def test_the_run_draws_by_it(unseen_windows):
    assert f"module://{unseen_windows.__name__}" == controller_run._FIGURES


@pytest.mark.slow(but=1)
@pytest.mark.parametrize("name", ["draw_idle", "flush_events"])
def test_a_figure_that_is_shown_is_not_drawn(drawn, name):
    canvas, times = drawn
    getattr(canvas, name)()
    assert not times


def test_a_figure_whose_pixels_are_read_is_drawn(drawn):
    canvas, times = drawn
    canvas.draw()
    assert times == [1]
    assert len(set(bytes(canvas.buffer_rgba()))) > 1


def test_a_figure_that_is_saved_is_drawn(drawn, tmp_path):
    canvas, times = drawn
    canvas.figure.savefig(tmp_path / "figure.png")
    assert times
    assert (tmp_path / "figure.png").read_bytes().startswith(b"\x89PNG")
