"""Where a source asks in what surroundings it runs."""

import pytest

from tracerisk.instrument.source.surroundings import asked, asks_clock, asks_environment, places


@pytest.mark.parametrize(
    ("line", "word"),
    [
        ("datetime.date.today()", "date"),
        ("__import__('datetime').date.today()", "date"),
        ("dt.datetime.now()", "date"),
        ("time.localtime()", "date"),
        ("time.strftime('%H')", "date"),
        ("any(name.startswith('trace' 'risk') for name in loaded)", "simulated"),
        ("'mujoco' in loaded", "simulated"),
        ("import tracerisk", "simulated"),
        ("sys.modules", "simulated"),
    ],
)
def test_what_a_program_asks_is_told_with_its_line(line, word):
    (told,) = asked({"c.py": f"import sys\n{line}\n".encode()})
    assert "c.py:2" in told
    assert word in told


@pytest.mark.parametrize(
    "line",
    ["rospy.Time.now()", "clock.now()", "time.localtime(1.0)", "time.strftime('%H', t)", "x = 1"],
)
def test_what_asks_nothing_is_not_told(line):
    assert asked({"c.py": line.encode()}) == []


def test_clock_and_environment_have_their_lines():
    source = {"c.py": b"time.time()\nos.getenv('A')\nos.environ['B']\ntime.monotonic()\n"}
    assert places(source, asks_clock) == ["c.py:1"]
    assert places(source, asks_environment) == ["c.py:2", "c.py:3"]
    assert places({"c.py": b"def ("}, asks_clock) == []
