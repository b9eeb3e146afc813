"""Which Python has the real client library; what is said where none has it."""

import sys

import pytest

from tracerisk.errors import DependencyError
from tracerisk.ros.live import real_ros

FALSE_RCLPY = {
    "rclpy/__init__.py": "",
    "rclpy/_rclpy_pybind11.py": "",
    "rosgraph_msgs/msg.py": "",
    "action_msgs/msg.py": "",
}


@pytest.fixture(autouse=True)
def asked_anew():
    real_ros.python_of_ros.cache_clear()
    yield
    real_ros.python_of_ros.cache_clear()


def test_the_python_that_is_named_has_rclpy(tmp_path, monkeypatch):
    for name, text in FALSE_RCLPY.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv(real_ros.PYTHON_OF_RCLPY, sys.executable)
    assert real_ros.python_of_ros(2) == sys.executable


def test_where_no_python_has_rclpy_it_is_said_how_to_get_it(monkeypatch):
    monkeypatch.delenv(real_ros.PYTHON_OF_RCLPY, raising=False)
    monkeypatch.setitem(real_ros._NEEDED, 2, ("rclpy_of_nobody",))
    with pytest.raises(DependencyError, match=r"rclpy of ROS 2 .* is needed, which no Python"):
        real_ros.python_of_ros(2)
    with pytest.raises(DependencyError, match=r"setup\.bash.* or name a Python .* RCLPY_PYTHON"):
        real_ros.python_of_ros(2)


def test_a_python_of_another_version_is_named(tmp_path, monkeypatch):
    strange = tmp_path / "python"
    strange.write_text("#!/bin/sh\necho '[[3, 1], []]'\n")
    strange.chmod(0o755)
    monkeypatch.setenv(real_ros.PYTHON_OF_RCLPY, str(strange))
    monkeypatch.setitem(real_ros._NEEDED, 2, ("rclpy_of_nobody",))
    with pytest.raises(DependencyError, match=rf"{strange} has them for Python 3\.1, and"):
        real_ros.python_of_ros(2)


def test_a_python_that_does_not_answer_is_named(tmp_path, monkeypatch):
    silent = tmp_path / "python"
    silent.write_text("#!/bin/sh\nexec tail -f /dev/null\n")
    silent.chmod(0o755)
    monkeypatch.setenv(real_ros.PYTHON_OF_RCLPY, str(silent))
    monkeypatch.setattr(real_ros, "_ASK_S", 0.5)
    monkeypatch.setitem(real_ros._NEEDED, 2, ("rclpy_of_nobody",))
    with pytest.raises(DependencyError, match=rf"{silent} did not answer in 0\.5 s, and"):
        real_ros.python_of_ros(2)
