"""The log of a run's contacts: which body touched which at each step, in files that outlive it.

`contacts.bin` has a row for each point of contact; `contact_bodies.jsonl` a line for each model
that was simulated: the bodies that it brought, and what was welded to which link from then on.
Both are appended to, so that what was logged stays readable however the process ended.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from tracerisk.common.text.bounded import MOST_OF_A_RUN, file_bytes
from tracerisk.errors import Location, LogError

BodyKind = Literal["link", "fixed", "free"]

ROW = np.dtype([("step", "<i4"), ("one", "<i4"), ("two", "<i4"), ("force", "<f4")])
"""A point of contact: step, the places of two bodies in the log, normal force [N].

A force below 0 says that the two overlap and that the simulation lets them pass.
"""
OVERLAP = -1.0
LOOK_EVERY = 4  # a step in so many is logged while the number of contacts stays as it is
POSTURE_EVERY = 80  # steps between two looks at whether links overlap

_ROWS = "contacts.bin"
_BODIES = "contact_bodies.jsonl"

Rows = NDArray[np.void]


@dataclass(frozen=True, slots=True)
class LoggedBody:
    """A body that can touch: a link of the robot, what stands fixed, or what can be moved."""

    name: str
    """The name of the body in the simulation."""
    kind: BodyKind
    """`link`, `fixed` or `free`."""
    mass_kg: float = 0.0
    """The mass [kg]; 0 for a body that is not free."""


@dataclass(frozen=True, slots=True)
class Weld:
    """A body that is fixed to a link for a time."""

    body: int
    """The index of the body in the log."""
    link: str
    """The name of the link."""
    start: int
    """The first step of the weld."""
    stop: int
    """The step after the last one of the weld."""


@dataclass(frozen=True, slots=True, eq=False)
class ContactLog:
    """What touched in one run."""

    bodies: tuple[LoggedBody, ...]
    """All bodies that could touch, in the order in which the log names them."""
    welds: tuple[Weld, ...]
    """The bodies that were fixed to a link, and when."""
    rows: Rows
    """The points of contact in the order of their steps, of dtype `ROW`, (n_rows,)."""


class ContactLogWriter:
    """Appends to the log of contacts in a directory; raises OSError when the disk refuses."""

    def __init__(self, directory: Path) -> None:
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
        self._rows = os.open(directory / _ROWS, flags, 0o644)
        self._bodies = os.open(directory / _BODIES, flags, 0o644)
        self._places: dict[LoggedBody, int] = {}

    def model(
        self, step: int, bodies: Sequence[LoggedBody], welds: Mapping[str, str]
    ) -> NDArray[np.int32]:
        """Note what can touch from `step` on, and the link to which each welded body is fast.

        Returns the place in the log of each of `bodies`.
        """
        fresh = [body for body in dict.fromkeys(bodies) if body not in self._places]
        self._places.update({body: len(self._places) + i for i, body in enumerate(fresh)})
        places = {body.name: self._places[body] for body in bodies}
        line = {
            "step": step,
            "bodies": [[body.name, body.kind, body.mass_kg] for body in fresh],
            "welds": [[places[name], link] for name, link in sorted(welds.items())],
        }
        os.write(self._bodies, (json.dumps(line) + "\n").encode())
        return np.array([self._places[body] for body in bodies], dtype=np.int32)

    def append(self, rows: Rows) -> None:
        """Append points of contact, in the order of their steps."""
        os.write(self._rows, rows.tobytes())

    def close(self) -> None:
        """Close the files; further calls do nothing."""
        if self._rows >= 0:
            os.close(self._rows)
            os.close(self._bodies)
        self._rows = self._bodies = -1


def read_contacts(directory: Path, n_steps: int) -> ContactLog:
    """Return the contacts of the first `n_steps` steps; none where none were logged.

    Raises LogError when the files do not fit each other.
    """
    if not (directory / _BODIES).exists():
        return ContactLog((), (), np.zeros(0, dtype=ROW))
    bodies: list[LoggedBody] = []
    welds: list[Weld] = []
    fast: dict[tuple[int, str], int] = {}
    for line in _lines(directory / _BODIES):
        step, now = line["step"], {(body, link) for body, link in line["welds"]}
        bodies += [LoggedBody(*item) for item in line["bodies"]]
        over = sorted(fast.keys() - now)
        welds += [Weld(*weld, fast.pop(weld), min(step, n_steps)) for weld in over]
        fast.update(dict.fromkeys(sorted(now - fast.keys()), step))
    welds += [Weld(*weld, start, n_steps) for weld, start in sorted(fast.items())]
    data = file_bytes(directory / _ROWS, MOST_OF_A_RUN) if (directory / _ROWS).exists() else b""
    rows = np.frombuffer(data[: len(data) // ROW.itemsize * ROW.itemsize], dtype=ROW)
    rows = rows[rows["step"] < n_steps]
    if len(rows) and max(rows["one"].max(), rows["two"].max()) >= len(bodies):
        raise LogError(f"names bodies that {_BODIES} lacks", Location(str(directory / _ROWS)))
    return ContactLog(tuple(bodies), tuple(w for w in welds if w.start < w.stop), rows)


def _lines(path: Path) -> list[dict[str, Any]]:
    # The last line of a run that was killed may be cut short.
    whole = file_bytes(path, MOST_OF_A_RUN).rpartition(b"\n")[0]
    try:
        return [json.loads(line) for line in whole.splitlines()]
    except json.JSONDecodeError as cause:
        raise LogError(f"is not a list of bodies: {cause}", Location(str(path))) from cause
