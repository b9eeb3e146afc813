from __future__ import annotations

import pytest

from tracerisk import trace_json
from tracerisk.trace import Trace


@pytest.fixture(scope="session")
def sample_run(tmp_path_factory, pick_and_place, example_in):
    """One run of the sample: the folder with all its outputs, and the command's outcome."""
    example = example_in(tmp_path_factory.mktemp("sample"))
    example.write("pick_and_place.py", pick_and_place)
    outcome = example.run(
        "run", "pick_and_place.py", "--json", "--trace", "trace.json", "--model", "model.json"
    )
    assert outcome.code == 0, outcome.err
    return example, outcome


@pytest.fixture(scope="session")
def short_run(tmp_path_factory, pick_and_place, example_in):
    """One run of the sample with two tubes of ten, as `sample_run`."""
    example = example_in(tmp_path_factory.mktemp("short"))
    example.write("pick_and_place.py", pick_and_place.replace(b"TUBES = 10\n", b"TUBES = 2\n"))
    outcome = example.run("run", "pick_and_place.py", "--json", "--trace", "trace.json")
    assert outcome.code == 0, outcome.err
    return example, outcome


@pytest.fixture(scope="session")
def short_trace(short_run) -> Trace:
    example, _ = short_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")


@pytest.fixture(scope="session")
def sample_trace(sample_run) -> Trace:
    example, _ = sample_run
    return trace_json.loads(example.read("trace.json").decode(), "trace.json")
