"""Who listens to events of Python's audit hooks hears those alone."""

import sys

from tracerisk.common.sandbox.files.audit_events import listen


def test_each_listener_hears_its_own_events_and_all_hear_what_they_share():
    heard = []
    listen(("test.one", "test.both"), lambda *told: heard.append(("first", *told)))
    listen(("test.both",), lambda *told: heard.append(("second", *told)))
    for event in ("test.one", "test.both", "test.none"):
        sys.audit(event, 7)
    assert heard == [
        ("first", "test.one", (7,)),
        ("first", "test.both", (7,)),
        ("second", "test.both", (7,)),
    ]
