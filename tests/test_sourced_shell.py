"""The tests run in a shell that has sourced a ROS."""

import os
import subprocess
import sys
from pathlib import Path

from tests.installed_ros import write

ROOT = Path(__file__).parent.parent


PLUGINS = ("launch_testing", "launch_testing_ros_pytest_entrypoint", "launch_pytest")
"""The names in `pytest11` of setup.py of ros2/launch and ros2/launch_ros."""


def test_plugins_of_ros_that_cannot_be_imported_stop_no_test(tmp_path):
    site = tmp_path / "lib/python3/dist-packages"
    for plugin in PLUGINS:
        metadata = f"{plugin}-1.0.dist-info"
        write(
            site,
            {
                f"{metadata}/METADATA": f"Metadata-Version: 2.1\nName: {plugin}\nVersion: 1.0\n",
                f"{metadata}/entry_points.txt": f"[pytest11]\n{plugin} = {plugin}_absent\n",
            },
        )
    write(tmp_path, {"test_one.py": "def test_one():\n    assert True\n"})
    options = ["-c", str(ROOT / "pyproject.toml"), "-q", "-p", "no:cacheprovider"]
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", *options, str(tmp_path / "test_one.py")],
        cwd=ROOT,
        env={**os.environ, "PYTHONPATH": str(site)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr
    assert "1 passed" in ended.stdout
