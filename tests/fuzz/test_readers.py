"""No text that others wrote ends a reader with anything but a result or an error of ours.

The inputs that once found something are in `corpus/`, a folder a reader; they come first. The
quick subset runs always; with `-m slow`, TRACERISK_FUZZ_EXAMPLES (20,000) inputs a reader. Any
number of inputs over all readers, in processes with limits: `python tests/fuzz/many.py --help`.
"""

import importlib.util
import os
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def _beside(name):
    spec = importlib.util.spec_from_file_location(name, HERE / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


_beside("workspace_readers")
READERS = _beside("readers").READERS
many = _beside("many")

CORPUS = sorted(path for path in (HERE / "corpus").rglob("*") if path.is_file())
QUICK = 60
LONG = int(os.environ.get("TRACERISK_FUZZ_EXAMPLES", "20000"))


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_what_once_found_something_is_read_or_refused(path, tmp_path):
    many.accepts_or_refuses(path.parent.name, path.read_bytes(), tmp_path)


@pytest.mark.parametrize("name", READERS)
def test_a_whole_example_is_read(name, tmp_path):
    for data in READERS[name].examples:
        READERS[name].read(data, tmp_path)


@pytest.mark.parametrize("name", READERS)
def test_no_input_ends_a_reader_otherwise(name, tmp_path):
    for number in range(-(-QUICK // READERS[name].one_in)):
        many.accepts_or_refuses(name, many.mutated(name, 0, number), tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_no_input_of_many_ends_a_reader_otherwise(name):
    assert many.fuzzed([name], LONG, seed=1, jobs=1) == []
