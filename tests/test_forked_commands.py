"""Commands of tests are forked, whatever tests before them have imported."""

import os

from tests import conftest


def test_a_variable_that_an_import_has_set_is_gone_before_the_next_test(monkeypatch):
    monkeypatch.setenv("KMP_INIT_AT_FORK", "FALSE")
    conftest.pytest_runtest_setup()
    assert "KMP_INIT_AT_FORK" not in os.environ


def test_what_was_there_at_the_start_stays(monkeypatch):
    monkeypatch.setitem(conftest.AT_START, "LC_ALL", "C.UTF-8")
    monkeypatch.setenv("LC_ALL", "C.UTF-8")
    conftest.pytest_runtest_setup()
    assert os.environ["LC_ALL"] == "C.UTF-8"
