"""Pictures of a run: of its recording, or of the run done once more to have one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from tracerisk.adder.sources.write import atomic_write
from tracerisk.common.hardware.binding import elements_by_component
from tracerisk.common.hardware.formats import load_hardware
from tracerisk.common.text.printable import printable_json
from tracerisk.config import Settings
from tracerisk.errors import InputError, Location
from tracerisk.report.png.drawn import BOTH_SIZE, drawn, filmed
from tracerisk.report.png.film import FRAME_S, make_film, make_film_of_both
from tracerisk.report.png.pictures import LEGEND, legend_data, make_pictures

if TYPE_CHECKING:
    from tracerisk.report.html.report_input import SideBySide
    from tracerisk.report.html.run.replay import RecordedRun
    from tracerisk.report.png.drawn import FilmFormat
    from tracerisk.trace import Trace


def write_pictures(
    trace: Trace, run: RecordedRun, settings: Settings, folder: str
) -> tuple[str, ...]:
    """Write a picture for each function, and their legend; return the names of the files.

    Raises RenderError where nothing can be drawn on this machine, InputError where the folder
    cannot be written, LogError where the recording is not of the trace.
    """
    hardware = load_hardware(settings, trace.robot)
    components = elements_by_component(hardware, trace.elements)
    pictures = make_pictures(trace, components, run)
    files = dict(
        zip(
            (picture.file for picture in pictures),
            drawn(pictures, limits=settings.drawing_limits),
            strict=True,
        )
    )
    text = json.dumps(legend_data(trace, pictures), indent=1, ensure_ascii=False)
    files[LEGEND] = f"{printable_json(text)}\n".encode()
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        message = f"is not a folder for pictures: {error.strerror}"
        raise InputError(message, Location(folder)) from error
    for name, data in files.items():
        atomic_write(Path(folder) / name, data)
    return tuple(files)


def write_films(
    trace: Trace, run: RecordedRun, settings: Settings, films: Mapping[FilmFormat, str]
) -> dict[str, int]:
    """Write a film of the run in each format to its path; return how many bytes each has.

    Raises as `write_pictures`.
    """
    if not films:
        return {}
    frames = make_film(trace, run)
    written = filmed(frames, list(films), frame_s=FRAME_S, limits=settings.drawing_limits)
    return _write_films(films, written)


def write_films_of_both(
    both: SideBySide,
    trace: Trace,
    settings: Settings,
    films: Mapping[FilmFormat, str],
    renamed: Mapping[str, str],
) -> dict[str, int]:
    """Write a film of an earlier run beside the present one, as `write_films` does.

    `renamed` gives the later name of functions by their earlier one.
    """
    before = both.before
    frames = make_film_of_both(before.trace, before.recorded, trace, both.now, renamed=renamed)
    limits = settings.drawing_limits
    written = filmed(frames, list(films), frame_s=FRAME_S, size=BOTH_SIZE, beside=2, limits=limits)
    return _write_films(films, written)


def _write_films(films: Mapping[FilmFormat, str], written: Sequence[bytes]) -> dict[str, int]:
    for path, data in zip(films.values(), written, strict=True):
        try:
            atomic_write(Path(path), data)
        except OSError as error:
            message = f"cannot be written: {error.strerror}"
            raise InputError(message, Location(path)) from error
    return {path: len(data) for path, data in zip(films.values(), written, strict=True)}
