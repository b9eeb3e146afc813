"""Programs whose lines real rclpy printed print the same on the stand-ins.

Recorded with rclpy 7.1.3 of Jazzy on Cyclone DDS (Python 3.11). The programs are ours.
"""

import contextlib
import io
import signal
import sys
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parents[2] / "data" / "rclpy_jazzy"
NAMES = sorted(path.stem for path in PROGRAMS.glob("*.py"))


def test_there_is_a_recording_of_each():
    assert sorted(path.stem for path in PROGRAMS.glob("*.txt")) == NAMES


@pytest.fixture
def as_python_starts():
    """Handlers of signals as in a new process: an earlier test may have left one of the command."""
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.mark.usefixtures("as_python_starts")
@pytest.mark.parametrize("name", NAMES)
def test_a_program_prints_what_it_prints_on_real_rclpy(name, run_ros2):
    program = PROGRAMS / f"{name}.py"
    code = compile(program.read_bytes(), str(program), "exec")

    def main():
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            exec(code, {"__name__": "__main__"})
        return printed.getvalue()

    recorded = (PROGRAMS / f"{name}.txt").read_text(encoding="utf-8")
    assert run_ros2(main).splitlines() == recorded.splitlines(), sys.version
