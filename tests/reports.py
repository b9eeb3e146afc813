"""What the workers of a test run report to the process that gathers it."""

import pytest
from _pytest.runner import runtestprotocol

_AT_ONCE_S = 0.005


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> bool | None:
    """Run a test, and report no set-up or tear-down of it that passed at once.

    To read one takes as long as most tests, and there are two for each.
    """
    if not hasattr(item.config, "workerinput"):
        return None
    hook = item.ihook
    hook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
    for report in runtestprotocol(item, nextitem=nextitem, log=False):
        if report.when == "call" or not report.passed or report.duration > _AT_ONCE_S:
            hook.pytest_runtest_logreport(report=report)
    hook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
    return True
