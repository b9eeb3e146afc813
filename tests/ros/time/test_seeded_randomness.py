"""What is random in a controller comes from the seed of the run, and from nothing else."""

import os
import random
import secrets
import uuid

import numpy as np
import pytest

from tracerisk.ros.time.patches import virtual_time
from tracerisk.ros.time.scheduler import Scheduler

SECOND = 1_000_000_000


def draw():
    numbers = [
        random.random(),
        random.Random().random(),
        random.SystemRandom().random(),
        secrets.token_hex(8),
        os.urandom(4),
        uuid.uuid4(),
        uuid.uuid1(),
        np.random.rand(),
        np.random.default_rng().random(),
    ]
    random.seed()
    return [*numbers, random.random()]


def drawn(world, seed):
    scheduler = Scheduler(world, duration_ns=SECOND)
    with virtual_time(scheduler, seed=seed):
        return scheduler.run_main(draw)


def test_two_runs_of_one_seed_draw_the_same(world):
    assert drawn(world, 7) == drawn(type(world)(), 7)


@pytest.mark.parametrize("index", [0, 1, 2, 3, 4, 5, 7, 8, 9])
def test_another_seed_draws_something_else(world, index):
    assert drawn(world, 7)[index] != drawn(type(world)(), 8)[index]


def test_the_shared_generators_go_on_after_the_run_as_if_there_had_been_none(world):
    random.seed(3)
    np.random.seed(3)
    expected = random.random(), np.random.rand()
    random.seed(3)
    np.random.seed(3)
    drawn(world, 7)
    assert (random.random(), np.random.rand()) == expected


def test_after_the_run_entropy_is_the_systems_again(world):
    drawn(world, 7)
    assert os.urandom(16) != os.urandom(16)
    assert uuid.uuid4() != uuid.uuid4()
