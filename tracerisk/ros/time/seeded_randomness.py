"""Randomness of the controller from the run's seed alone, so that two runs are the same."""

from __future__ import annotations

import functools
import os
import random
import sys
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from tracerisk.ros.time.scheduler import Scheduler

_NETWORK_NODE = 0x0242AC110002
"""What `uuid.getnode()` returns: an address that no real card has."""


@contextmanager
def seeded_generators(seed: int) -> Iterator[None]:
    """Begin the shared generators of `random` and `numpy` anew; put them back at the end."""
    python_state = random.getstate()
    numpy = sys.modules.get("numpy")
    numpy_state = numpy.random.get_state() if numpy is not None else None
    random.seed(seed)
    if numpy is not None:
        numpy.random.seed(seed % 2**32)
    try:
        yield
    finally:
        random.setstate(python_state)
        if numpy is not None:
            numpy.random.set_state(numpy_state)


def entropy_replacements(scheduler: Scheduler, seed: int) -> Iterator[tuple[Any, str, Any]]:
    """Return (owner, name, value) of what stands for the system's sources of entropy.

    They serve what the controller's threads ask of `os.urandom`, `secrets`, `uuid`, and of
    generators that are made without a seed; threads of others get the system's entropy.
    """
    entropy = random.Random(f"entropy {seed}")
    real_urandom, real_seed, real_seed_shared = os.urandom, random.Random.seed, random.seed

    def urandom(size: int, /) -> bytes:
        return real_urandom(size) if scheduler.current is None else entropy.randbytes(size)

    def fresh() -> int:
        return int.from_bytes(entropy.randbytes(32), "big")

    @functools.wraps(real_seed)
    def seed_generator(self: random.Random, a: Any = None, version: int = 2) -> None:
        is_system = isinstance(self, random.SystemRandom)
        if a is None and scheduler.current is not None and not is_system:
            a = fresh()
        real_seed(self, a, version)

    @functools.wraps(real_seed_shared)
    def seed_shared(a: Any = None, version: int = 2) -> None:
        real_seed_shared(fresh() if a is None and scheduler.current is not None else a, version)

    yield os, "urandom", urandom
    yield random, "_urandom", urandom
    yield random.Random, "seed", seed_generator
    yield random, "seed", seed_shared
    # uuid1 is then made of the clock, the generator of `random`, and the node.
    for name, value in (
        ("_generate_time_safe", None),
        ("_UuidCreate", None),
        ("_node", _NETWORK_NODE),
        ("_last_timestamp", None),
    ):
        if name in vars(uuid):
            yield uuid, name, value
