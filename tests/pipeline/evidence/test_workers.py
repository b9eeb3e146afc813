"""Workers end with the campaign that started them, however that ends."""

import multiprocessing
import time

from tracerisk.pipeline.evidence.workers import Workers

HOUR_S = 3600.0


def test_who_stops_a_campaign_waits_for_no_job():
    before = set(multiprocessing.active_children())
    results = Workers(jobs=2).run(time.sleep, [0.0, HOUR_S, HOUR_S])
    next(results)
    workers = set(multiprocessing.active_children()) - before
    assert workers
    results.close()
    for each in workers:
        each.join(60.0)
        assert each.exitcode is not None
