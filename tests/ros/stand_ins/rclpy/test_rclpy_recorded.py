"""Programs whose lines real rclpy printed print the same on the stand-ins.

Recorded with rclpy 7.1.5 of Jazzy on Fast DDS, and `deadline` with 7.1.3 on Cyclone DDS (Python
3.11). The programs are ours. Where the real library is installed, it is asked again.
"""

import contextlib
import io
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAMS = Path(__file__).parents[2] / "data" / "rclpy_jazzy"
NAMES = sorted(path.stem for path in PROGRAMS.glob("*.py"))
OF_CYCLONE_DDS = frozenset({"deadline"})
"""What Fast DDS does otherwise: the order of events, and a lifespan that it does not keep."""
RACES = frozenset({"signal_in_callback", "signal_main_spin", "signal_thread_spin"})
"""What the real library ends in one way or another, by the thread that sees a signal first."""
MOST_RACES = 8
PYTHON = "RCLPY_PYTHON"
"""The variable that names the Python which has the real rclpy; else it is that of the PATH."""
FIRST_DOMAIN = 60
"""The domain of the first worker: programs that run side by side must not hear each other."""
MOST_S = 120.0


def test_there_is_a_recording_of_each():
    assert sorted(path.stem for path in PROGRAMS.glob("*.txt")) == NAMES


@pytest.fixture
def as_python_starts():
    """Handlers of signals as in a new process: an earlier test may have left one of the command."""
    before = signal.signal(signal.SIGTERM, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGTERM, before)


@pytest.mark.slow(but=30)
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


@pytest.fixture(scope="session")
def real_rclpy() -> str:
    """A Python that has the real rclpy and the messages of the programs."""
    asked = "import rclpy._rclpy_pybind11, control_msgs.action, std_srvs.srv, rosidl_runtime_py"
    for python in (os.environ.get(PYTHON), shutil.which("python3")):
        if python and subprocess.run([python, "-c", asked], capture_output=True).returncode == 0:
            return python
    pytest.skip(f"no Python has rclpy; name one by {PYTHON}")


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(set(NAMES) - OF_CYCLONE_DDS))
def test_a_program_still_prints_it_on_real_rclpy(name, real_rclpy):
    worker = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
    alone = {
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOCALHOST_ONLY": "1",
        "ROS_DOMAIN_ID": str(FIRST_DOMAIN + worker),
    }
    recorded = (PROGRAMS / f"{name}.txt").read_text(encoding="utf-8")
    for _ in range(MOST_RACES if name in RACES else 1):
        done = subprocess.run(
            [real_rclpy, "-W", "ignore", f"{name}.py"],
            cwd=PROGRAMS,
            env={**os.environ, **alone},
            capture_output=True,
            text=True,
            timeout=MOST_S,
        )
        if done.stdout.splitlines() == recorded.splitlines():
            return
    pytest.fail(f"{done.stdout}\n{done.stderr}")
