"""Import MuJoCo where there is no window and no GPU."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

_BACKEND = "MUJOCO_GL"


@contextmanager
def no_display() -> Iterator[None]:
    """Import MuJoCo in it without a backend that renders, unless a user has named one.

    Both MuJoCo and dm-control look at the environment as they are imported. What the process
    starts later must not find in it what nobody has set.
    """
    if _BACKEND in os.environ:
        yield
        return
    os.environ[_BACKEND] = "disable"
    try:
        yield
    finally:
        os.environ.pop(_BACKEND, None)
