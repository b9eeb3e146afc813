"""Draw the pictures in a process of its own, with whatever OpenGL needs no screen here.

The twin's own process runs with MuJoCo's renderer off, and a driver that crashes must not take
the command with it.
"""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Literal

from tracerisk.common.limits import Limit, Limits
from tracerisk.common.sandbox.limited_process import run_limited
from tracerisk.common.text.plain_data import picked
from tracerisk.errors import RenderError
from tracerisk.report.png.pictures import Picture

BACKENDS = ("egl", "osmesa")
"""Ways to draw without a screen, in the order in which they are tried."""
SIZE = (960, 640)
"""Width and height of a picture without its caption [px]."""
FILM_SIZE = (480, 320)
"""Width and height of a frame without its caption [px]."""
BOTH_SIZE = (400, 266)
"""The same of each of two frames beside each other."""
FilmFormat = Literal["gif", "mp4"]
_OFF = frozenset({"", "0", "disable", "disabled", "false", "no", "off"})
_READY = "ready"
_LIMITS = Limits(own=Limit("cpu_limit_s", 120.0))


def drawn(
    pictures: Sequence[Picture], *, size: tuple[int, int] = SIZE, limits: Limits = _LIMITS
) -> tuple[bytes, ...]:
    """Return each picture as PNG, the same bytes for the same picture on the same machine.

    Raises as `_written`.
    """
    names = [f"{number}.png" for number in range(len(pictures))]
    return _written(_request(pictures, size), names, limits)


def filmed(
    frames: Sequence[Picture],
    formats: Sequence[FilmFormat],
    *,
    frame_s: float,
    size: tuple[int, int] = FILM_SIZE,
    beside: int = 1,
    limits: Limits = _LIMITS,
) -> tuple[bytes, ...]:
    """Return frames as a film in each format, every one seen for `frame_s` [s].

    So many as `beside` says stand beside each other.

    The same frames give the same bytes of a GIF on the same machine. Raises as `_written`.
    """
    request = _request(frames, size) | {
        "films": list(formats),
        "frame_s": frame_s,
        "beside": beside,
    }
    return _written(request, [f"film.{name}" for name in formats], limits)


def _request(pictures: Sequence[Picture], size: tuple[int, int]) -> dict[str, object]:
    return {"size": size, "pictures": [_data(picture) for picture in pictures], "films": []}


def _written(data: dict[str, object], names: Sequence[str], limits: Limits) -> tuple[bytes, ...]:
    """Return the files that the drawing process writes.

    `MUJOCO_GL` chooses the backend where it names one, else EGL is tried and then OSMesa.
    Raises RenderError where none works, LimitError where drawing takes too long: then no other
    backend is tried.
    """
    request = json.dumps(data, sort_keys=True)
    chosen = os.environ.get("MUJOCO_GL", "").strip().lower()
    reasons = []
    for backend in BACKENDS if chosen in _OFF else (chosen,):
        with tempfile.TemporaryDirectory(prefix="tracerisk-") as folder:
            done = _run(request, folder, backend, limits)
            if done.returncode == 0:
                return tuple((Path(folder) / name).read_bytes() for name in names)
        message = _last_line(done.stderr.decode("utf-8", "replace"))
        if done.stdout.startswith(_READY.encode()):
            raise RuntimeError(f"the pictures could not be drawn with {backend}: {message}")
        reasons.append(f"{backend}: {message}")
    raise RenderError(
        "pictures need OpenGL that works without a screen, and there is none "
        f"({'; '.join(reasons)}); install libegl1, libgl1 and libgl1-mesa-dri, or libosmesa6 "
        "(packages of Debian and Ubuntu), or name one that works in MUJOCO_GL"
    )


def _run(
    request: str, folder: str, backend: str, limits: Limits
) -> subprocess.CompletedProcess[bytes]:
    return run_limited(
        "tracerisk.report.png.child",
        folder,
        request=request.encode(),
        limits=limits,
        doing=f"drawing with {backend}",
        environment={"MUJOCO_GL": backend, "PYOPENGL_PLATFORM": None},
    )


def _data(picture: Picture) -> dict[str, object]:
    return picked(picture, "title", "rows", "camera", "solids")


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "no error message"
