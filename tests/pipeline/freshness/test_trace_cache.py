"""Which runs are kept, and for how long."""

import os

import pytest

from tracerisk.common.verdict import Coverage, Verdict
from tracerisk.pipeline.freshness import trace_cache
from tracerisk.pipeline.freshness.trace_cache import FOLDER, TraceCache
from tracerisk.trace import RunEnd, Trace


def trace(controller="arm.py", replay=b"seen"):
    end = RunEnd("ended", "it returned", 1.0)
    verdict = Verdict("complete", (), Coverage(1, 1))
    return Trace(controller, "panda", "empty", end, (), (), (), verdict=verdict, replay=replay)


@pytest.fixture
def folder(tmp_path):
    return tmp_path / FOLDER


def kept(folder):
    """The names of what is kept without the controller's part, which is the same for all here."""
    return sorted(path.name.partition("-")[2] for path in folder.glob("*-*"))


def written(cache, folder, *fingerprints, **of):
    """Write runs one after the other, each a second later than the one before."""
    for second, fingerprint in enumerate(fingerprints):
        cache.write(fingerprint, trace(**of))
        for path in folder.glob(f"*-{fingerprint}.*"):
            os.utime(path, (second, second))


def test_a_run_is_kept_with_its_replay(tmp_path, folder):
    cache = TraceCache(tmp_path)
    cache.write("aa", trace())
    assert cache.read("aa", "arm.py") == trace()
    assert cache.replay_path("aa", "arm.py").read_bytes() == b"seen"
    assert kept(folder) == ["aa.json", "aa.replay"]


def test_a_trace_that_was_read_leaves_the_replay_as_it_is(tmp_path):
    cache = TraceCache(tmp_path)
    cache.write("aa", trace())
    cache.write("aa", trace(replay=None))
    assert cache.replay_path("aa", "arm.py").read_bytes() == b"seen"


def test_an_earlier_run_stays_as_long_as_its_replay(tmp_path, folder, monkeypatch):
    monkeypatch.setattr(trace_cache, "MOST_REPLAYS", 2)
    cache = TraceCache(tmp_path)
    written(cache, folder, "aa", "bb")
    assert kept(folder) == ["aa.json", "aa.replay", "bb.json", "bb.replay"]
    written(cache, folder, "cc")
    assert kept(folder) == ["bb.json", "bb.replay", "cc.json", "cc.replay"]


def test_the_last_trace_of_another_controller_outlives_its_replay(tmp_path, folder, monkeypatch):
    monkeypatch.setattr(trace_cache, "MOST_REPLAYS", 1)
    cache = TraceCache(tmp_path)
    written(cache, folder, "aa", controller="other.py")
    written(cache, folder, "bb")
    assert kept(folder) == ["aa.json", "bb.json", "bb.replay"]


def test_bytes_are_bounded_and_the_newest_stays(tmp_path, folder, monkeypatch):
    monkeypatch.setattr(trace_cache, "MOST_REPLAY_BYTES", 10)
    cache = TraceCache(tmp_path)
    written(cache, folder, "aa", "bb", "cc", replay=b"12345")
    assert kept(folder) == ["bb.json", "bb.replay", "cc.json", "cc.replay"]
    cache.write("dd", trace(replay=b"1234567890"))
    assert kept(folder) == ["dd.json", "dd.replay"]
    cache.write("ee", trace(replay=b"12345678901"))
    assert "ee.json" in kept(folder)
    assert "ee.replay" not in kept(folder)
