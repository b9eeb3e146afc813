"""No text that others wrote ends a reader with anything but a result or an error of ours.

The inputs that once found something are in `corpus/`, a folder a reader; they come first. The
quick subset runs always; with `-m slow`, TRACERISK_FUZZ_EXAMPLES (20,000) inputs a reader.
"""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tracerisk.errors import TraceRiskError

HERE = Path(__file__).parent
_spec = importlib.util.spec_from_file_location("fuzzed_readers", HERE / "readers.py")
assert _spec is not None
assert _spec.loader is not None
_module = importlib.util.module_from_spec(_spec)
sys.modules["fuzzed_readers"] = _module
_spec.loader.exec_module(_module)
READERS = _module.READERS

CORPUS = sorted(path for path in (HERE / "corpus").rglob("*") if path.is_file())
QUICK = 60
LONG = int(os.environ.get("TRACERISK_FUZZ_EXAMPLES", "20000"))

# What readers tend to stumble over, put into whole examples.
TOKENS = [
    *(b"1e400", b"-1e999", b"9" * 5000, b"0." + b"0" * 5000 + b"1", b"nan", b"NaN", b"Infinity"),
    *(b"(" * 3000, b"[" * 100_000, b'{"a":' * 20_000, b"-" * 3000, b"!" * 3000, b"<a>" * 3000),
    *(b"\x00", b"\xff", b"\r\n", b"\r", b"\x0c", b"\xef\xbb\xbf", b"\xe2\x80\xae", b"{", b"}"),
    *(b'"', b"'", b"#", b"!", b":=", b"=", b"..", b"../../etc/passwd", b"*a", b"&a [*a]", b"!!set"),
]


@st.composite
def mutated(draw, examples):
    """A whole example with pieces taken out, doubled, or replaced by what others stumbled over."""
    data = draw(st.sampled_from(examples))
    for _ in range(draw(st.integers(0, 4))):
        start = draw(st.integers(0, len(data)))
        end = draw(st.integers(start, min(len(data), start + 40)))
        piece = draw(st.sampled_from([b"", data[start:end] * 2, *TOKENS]) | st.binary(max_size=8))
        data = data[:start] + piece + data[end:]
    return data


def accepts_or_refuses(name: str, data: bytes) -> None:
    with tempfile.TemporaryDirectory() as folder:
        try:
            READERS[name].read(data, Path(folder))
        except TraceRiskError as error:
            assert str(error)  # noqa: PT017 - either outcome will do


def fuzz(name: str, examples: int) -> None:
    @settings(
        max_examples=examples,
        deadline=None,
        database=None,
        derandomize=examples == QUICK,
        suppress_health_check=list(HealthCheck),
    )
    @given(mutated(READERS[name].examples))
    def check(data):
        accepts_or_refuses(name, data)

    check()


@pytest.mark.parametrize("path", CORPUS, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_what_once_found_something_is_read_or_refused(path):
    accepts_or_refuses(path.parent.name, path.read_bytes())


@pytest.mark.parametrize("name", READERS)
def test_a_whole_example_is_read(name):
    if name not in ("trace", "openpra", "model"):
        for data in READERS[name].examples:
            with tempfile.TemporaryDirectory() as folder:
                READERS[name].read(data, Path(folder))


@pytest.mark.parametrize("name", READERS)
def test_no_input_ends_a_reader_otherwise(name):
    fuzz(name, QUICK)


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_no_input_of_many_ends_a_reader_otherwise(name):
    fuzz(name, LONG)
