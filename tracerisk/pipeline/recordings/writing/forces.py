"""The forces of contacts as numbers: a topic for each pair of bodies that a trace says touched."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tracerisk.pipeline.recordings.recorded_topics import FORCES
from tracerisk.pipeline.recordings.writing.cdr import Stamped, number_message
from tracerisk.twin.recording.contact_log import LOOK_EVERY
from tracerisk.twin.recording.contact_pairs import pair_touches
from tracerisk.twin.recording.samples import Samples

if TYPE_CHECKING:
    from tracerisk.trace import Trace

_NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9_]+")

Array = NDArray[np.float64]


def force_messages(samples: Samples, trace: Trace) -> list[Stamped]:
    """Return the normal force of each pair whenever it changes, and 0 around a touch.

    The pairs are those of the trace's contacts, but for links that only overlapped: their force
    is not simulated.
    """
    log = samples.contacts
    wanted = {
        frozenset((touch.link, touch.other)): (touch.link, touch.other)
        for visit in trace.visits
        for touch in visit.contacts
    }
    if log is None or not wanted:
        return []
    forces: dict[tuple[str, str], Array] = {}
    for pair in pair_touches(log, samples.n_steps):
        names = wanted.get(frozenset((log.bodies[pair.one].name, log.bodies[pair.two].name)))
        if names is not None and pair.force is not None:
            # One that is attached counts as another body in the log, of the same name.
            force = forces.setdefault(names, np.zeros(samples.n_steps))
            force[pair.steps] += pair.force
    topics = _topics(forces)
    step_ns = samples.header.step_ns
    return [
        Stamped(step * step_ns, topics[names], number_message(value))
        for names, force in forces.items()
        for step, value in _bends(force)
    ]


def _bends(force: Array) -> Iterator[tuple[int, float]]:
    """Yield the first step of each stretch of equal values, of a long one the last too.

    Of rest, 0 N, before the first touch and after the last one, only the step next to it.
    """
    firsts = np.flatnonzero(np.diff(force, prepend=np.nan))
    lasts = np.append(firsts[1:], len(force)) - 1
    for first, last in zip(firsts.tolist(), lasts.tolist(), strict=True):
        value = float(force[first])
        if first > 0 or value:
            yield first, value
        if last - first >= LOOK_EVERY and (last < len(force) - 1 or value):
            yield last, value


def _topics(pairs: Iterable[tuple[str, str]]) -> dict[tuple[str, str], str]:
    """Return a topic for each pair, whose names may hold what topics must not."""
    topics: dict[tuple[str, str], str] = {}
    for pair in sorted(pairs):
        topic = "/".join((FORCES, *map(_name, pair)))
        taken = set(topics.values())
        copies = (topic if n == 1 else f"{topic}_{n}" for n in range(1, len(taken) + 2))
        topics[pair] = next(free for free in copies if free not in taken)
    return topics


def _name(name: str) -> str:
    """Return a name as a token of a topic: letters, digits and underscores, no digit first."""
    token = _NOT_IN_NAMES.sub("_", name)
    return f"_{token}" if not token or token[0].isdigit() else token
