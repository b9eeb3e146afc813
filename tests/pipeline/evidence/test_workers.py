"""A campaign ends its workers, and says what it cannot write."""

import multiprocessing
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from tests.pipeline.evidence.test_file import CELL
from tracerisk.errors import InputError
from tracerisk.pipeline.evidence.journal import journal
from tracerisk.pipeline.evidence.workers import Workers

HOUR_S = 3600.0


def code_of(worker, limit_s: float):
    """Wait for the end of a worker; the thread of its pool may be the one that learns how it was."""
    deadline = time.monotonic() + limit_s
    while worker.exitcode is None and time.monotonic() < deadline:
        time.sleep(0.01)
    return worker.exitcode


def test_who_stops_a_campaign_waits_for_no_job():
    before = set(multiprocessing.active_children())
    results = Workers(jobs=2).run(time.sleep, [0.0, HOUR_S, HOUR_S])
    next(results)
    workers = set(multiprocessing.active_children()) - before
    assert workers
    results.close()
    for each in workers:
        assert code_of(each, 60.0) is not None


def test_a_worker_that_does_not_end_is_killed():
    """Whatever it waits for: here a function that is to run at its exit."""
    before = set(multiprocessing.active_children())
    stays = "import atexit, time; atexit.register(time.sleep, 3600.0)"
    results = Workers(jobs=1, ending_s=0.5).run(exec, [stays, "import time; time.sleep(3600.0)"])
    next(results)
    (worker,) = set(multiprocessing.active_children()) - before
    results.close()
    assert code_of(worker, 20.0) == -signal.SIGKILL


def test_a_limit_of_time_holds_in_the_middle_of_a_job():
    began = time.monotonic()
    results = list(Workers(jobs=2, most_s=3.0).run(time.sleep, [0.0, HOUR_S, HOUR_S, HOUR_S]))
    assert time.monotonic() - began < 60.0
    assert [job for job, _ in results] in ([], [0.0])


def test_what_was_done_before_the_limit_is_kept_however_late_it_is_taken(monkeypatch):
    now_s = [0.0]
    clock = SimpleNamespace(monotonic=lambda: now_s[0])
    monkeypatch.setattr("tracerisk.pipeline.evidence.workers.time", clock)
    results = Workers(jobs=1, most_s=100.0).run(time.sleep, [0.0, 0.1, HOUR_S])
    assert next(results)[0] == 0.0
    time.sleep(2.0)
    now_s[0] = 101.0
    assert [job for job, _ in results] == [0.1]


def test_workers_of_an_executor_end_the_job_that_they_have_begun():
    with ThreadPoolExecutor(1) as executor:
        workers = Workers(jobs=2, executor=executor, most_s=0.3)
        done = [job for job, _ in workers.run(time.sleep, [0.2] * 9)]
    assert 1 <= len(done) <= 3


def test_a_journal_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "cache").write_text("a file in the place of the folder")
    with pytest.raises(InputError, match="cannot be written"), journal(tmp_path / "cache" / "j"):
        pass
    with journal(tmp_path / "j") as keep:
        keep([CELL])
        (tmp_path / "j").unlink()
        (tmp_path / "j").mkdir()
        with pytest.raises(InputError, match="cannot be written"):
            keep([CELL])
