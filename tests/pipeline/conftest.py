from __future__ import annotations

import pytest

from tracerisk.common import trace_json
from tracerisk.trace import Trace

OUTPUTS = ("--json", "--trace", "trace.json", "--model", "model.json")


def ran(example, source: bytes):
    example.write("pick_and_place.py", source)
    outcome = example.run("run", "pick_and_place.py", *OUTPUTS)
    assert outcome.code == 0, outcome.err
    return example, outcome


@pytest.fixture(scope="session")
def short_source(pick_and_place) -> bytes:
    """The sample with two tubes of ten."""
    return pick_and_place.replace(b"TUBES = 10\n", b"TUBES = 2\n")


@pytest.fixture(scope="session")
def short_run(tmp_path_factory, short_source, example_in):
    """One run of it: the folder with all its outputs, and the command's outcome."""
    return ran(example_in(tmp_path_factory.mktemp("short")), short_source)


@pytest.fixture(scope="session", params=[2, pytest.param(10, marks=pytest.mark.slow)])
def tubes(request) -> int:
    """How many tubes of the sample are moved: as few as show the law, and in a slow test all."""
    return request.param


@pytest.fixture(scope="session")
def sample_run(tubes, request, tmp_path_factory, pick_and_place, example_in):
    """One run of the sample, as `short_run`."""
    if tubes == 2:
        return request.getfixturevalue("short_run")
    return ran(example_in(tmp_path_factory.mktemp("sample")), pick_and_place)


@pytest.fixture(scope="session")
def short_trace(short_run) -> Trace:
    example, _ = short_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


@pytest.fixture(scope="session")
def sample_trace(sample_run) -> Trace:
    example, _ = sample_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")
